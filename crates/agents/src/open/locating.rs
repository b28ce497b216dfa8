//! Finding out where the robot is: it drives over ground that it sees to be free, to see more of
//! the buildings around it.
//!
//! Until the localizer knows where the robot is, poses are in a frame of its own. The map is not
//! used to drive: where its buildings are in that frame is what is to be found out.

use std::time::Duration;

use openbench_core::{Event, Events, MapPoint, Pose2, SimTime, Velocity, Work};
use openbench_motion::{Beam, RangeRing};

use crate::open::driving::{Driver, Driving, Target};

/// The robot looks around for so long before it drives.
const FIRST_LOOK: Duration = Duration::from_millis(1500);
/// Distances of places to drive to, metres; nearer ones if no other is free. Scans show ground to
/// be free as far as eight metres away.
const DISTANCES_M: [f64; 3] = [6.5, 4.0, 2.5];
/// This near to a place the next one is chosen, so that the robot does not stop, metres.
const NEAR_M: f64 = 1.5;
/// Where none is found, the robot looks again after this time.
const PATIENCE: Duration = Duration::from_secs(1);
/// Directions in which places are tried: one each ten degrees.
const DIRECTIONS: usize = 36;
/// Ground is seen to be free so far to each side of the line to a place, metres,
const HALF_WIDTH_M: f64 = 0.8;
/// and so far beyond it.
const BEYOND_M: f64 = 0.5;
/// A place whose path is longer than the straight line by this factor lies behind something.
const DETOUR_FACTOR: f64 = 1.5;
/// The robot remembers where it was in steps of this length, metres.
const STEP_M: f64 = 2.0;
/// A place this far from all that the robot has seen from near is as good as one farther away.
const NEW_M: f64 = 15.0;
/// So far ahead on the route to the first delivery a robot looks whose start is roughly known.
const AHEAD_M: f64 = 20.0;

/// For how long a robot searches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Its way, metres.
    pub metres: f64,
    /// Its time.
    pub time: Duration,
}

impl Limit {
    /// For a robot that has a pose to go on with.
    pub const WITH_POSE: Self = Self {
        metres: 60.0,
        time: Duration::from_secs(120),
    };
    /// For one that has none.
    pub const WITHOUT_POSE: Self = Self {
        metres: 200.0,
        time: Duration::from_secs(420),
    };
}

/// What to do next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Search {
    /// Drive so until the next observation.
    Drive(Velocity),
    /// The limit is reached.
    Over,
}

/// A robot that searches itself.
pub struct Locating {
    /// On ground without a map.
    driver: Driver,
    limit: Limit,
    /// Where the robot should go, as far as it knows; may be empty.
    route: Vec<MapPoint>,
    began: Option<SimTime>,
    /// Free ground in each degree, as the newest scan shows it.
    beams: Vec<Beam>,
    /// Where the robot was, and places that it did not reach.
    seen_from: Vec<MapPoint>,
    target: Option<MapPoint>,
    /// When a place was chosen last.
    chosen: Option<SimTime>,
    last: Option<MapPoint>,
    metres: f64,
}

impl Locating {
    /// A search with a driver on ground without a map. Of two equally good places it takes the one
    /// that lies along `route`, in the frame of the poses.
    pub fn new(driver: Driver, route: Vec<MapPoint>, limit: Limit) -> Self {
        Self {
            driver,
            limit,
            route,
            began: None,
            beams: Vec::new(),
            seen_from: Vec::new(),
            target: None,
            chosen: None,
            last: None,
            metres: 0.0,
        }
    }

    /// The driver, to take in wheels and scans.
    pub fn driver_mut(&mut self) -> &mut Driver {
        &mut self.driver
    }

    /// Takes in which ground a scan shows to be free.
    pub fn look(&mut self, ring: &RangeRing) {
        self.beams.clone_from(&ring.beams);
    }

    /// Continues after the robot stood for this long for another reason: that time does not count.
    pub fn resume(&mut self, stood: Duration) {
        self.began = self.began.map(|began| began + stood);
        self.driver.resume(stood);
    }

    /// How far the robot came, metres.
    pub fn metres(&self) -> f64 {
        self.metres
    }

    /// Decides how to drive on from `pose`, in the frame of the scans.
    pub fn step(&mut self, pose: Pose2, now: SimTime, events: &mut dyn Events) -> Search {
        let here = pose.point();
        self.remember(here);
        let since = now.since(*self.began.get_or_insert(now));
        if self.metres >= self.limit.metres || since >= self.limit.time {
            return Search::Over;
        }
        if since < FIRST_LOOK {
            return Search::Drive(Velocity::ZERO);
        }
        let events = &mut InOwnFrame(events);
        if self.is_to_choose(here, now) {
            self.chosen = Some(now);
            self.choose(here, events);
        }
        let Some(target) = self.target else {
            // All around is blocked: people and cars move on.
            return Search::Drive(Velocity::ZERO);
        };
        match self.driver.drive(pose, now, events) {
            Driving::OnTheWay(velocity) => Search::Drive(velocity),
            Driving::Arrived | Driving::Unreachable => {
                self.seen_from.push(target);
                self.target = None;
                Search::Drive(Velocity::ZERO)
            }
        }
    }

    fn remember(&mut self, here: MapPoint) {
        self.metres += self.last.map_or(0.0, |last| last.distance(here));
        self.last = Some(here);
        let is_new = |at: &MapPoint| at.distance(here) >= STEP_M;
        if self.seen_from.last().is_none_or(is_new) {
            self.seen_from.push(here);
        }
    }

    /// Whether the robot needs another place, and did not look for one just before.
    fn is_to_choose(&self, here: MapPoint, now: SimTime) -> bool {
        let target = self.target;
        target.is_none_or(|target| target.distance(here) < NEAR_M)
            && self
                .chosen
                .is_none_or(|chosen| now.since(chosen) >= PATIENCE)
    }

    /// Sets the best place as target, if there is one.
    fn choose(&mut self, here: MapPoint, events: &mut dyn Events) {
        let mut distances = DISTANCES_M.into_iter();
        let best = distances.find_map(|distance| self.best_at(here, distance, events));
        if let Some(point) = best {
            self.target = best;
            self.driver.set_target(Target {
                point,
                yaw: None,
                must: false,
            });
        } else if self.target.is_none() {
            // Nothing is new: the same places once more, rather than none.
            self.seen_from.clear();
        }
    }

    /// The best place at this distance to which free ground leads.
    fn best_at(&self, here: MapPoint, distance: f64, events: &mut dyn Events) -> Option<MapPoint> {
        let bearings = (0..DIRECTIONS).map(|i| (i as f64 * 360.0 / DIRECTIONS as f64).to_radians());
        let places: Vec<MapPoint> = bearings
            .filter(|bearing| is_free(&self.beams, *bearing, distance))
            .map(|bearing| here.offset(bearing, distance))
            .collect();
        if places.is_empty() {
            return None;
        }
        events.record(Event::Work(Work::PathSearch));
        let costs = self.driver.terrain().costs(here, &places);
        let is_near = |cost: &Option<f64>| cost.is_some_and(|c| c <= DETOUR_FACTOR * distance);
        let reachable = places.into_iter().zip(costs);
        let reachable = reachable.filter(|(_, cost)| is_near(cost));
        let (best, worth) = reachable
            .map(|(place, _)| (place, self.worth(here, place)))
            .reduce(|a, b| if b.1 > a.1 { b } else { a })?;
        (worth > 0.0).then_some(best)
    }

    /// How much a place promises, metres: its distance from where the robot was, and how much
    /// nearer it is to where the robot should go.
    fn worth(&self, here: MapPoint, place: MapPoint) -> f64 {
        let distances = self.seen_from.iter().map(|at| at.distance(place));
        let new = distances.fold(NEW_M, f64::min);
        let nearer = self
            .ahead(here)
            .map_or(0.0, |goal| goal.distance(here) - goal.distance(place));
        new + nearer
    }

    /// The point of the route some way ahead of the robot.
    fn ahead(&self, here: MapPoint) -> Option<MapPoint> {
        let away = |point: &MapPoint| point.distance(here);
        let nearest = (0..self.route.len())
            .min_by(|a, b| away(&self.route[*a]).total_cmp(&away(&self.route[*b])))?;
        let ahead = &self.route[nearest..];
        let far = ahead.iter().find(|point| away(point) >= AHEAD_M);
        far.or(ahead.last()).copied()
    }
}

/// Whether a scan shows the ground to a place to be free, as wide as the robot and a bit beyond.
fn is_free(beams: &[Beam], bearing: f64, distance: f64) -> bool {
    let half = libm::ceil(libm::atan2(HALF_WIDTH_M, distance).to_degrees()) as i64;
    let middle = libm::floor(bearing.to_degrees()) as i64;
    let degrees = beams.len() as i64;
    degrees > 0
        && (middle - half..=middle + half).all(|degree| {
            let beam = beams[degree.rem_euclid(degrees) as usize];
            beam.reach >= distance + BEYOND_M
        })
}

/// Lets through what is the same in every frame.
struct InOwnFrame<'a>(&'a mut dyn Events);

impl Events for InOwnFrame<'_> {
    fn record(&mut self, event: Event) {
        if !matches!(event, Event::Path(_) | Event::Costmap(_)) {
            self.0.record(event);
        }
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::{Discard, Georeference, LonLat, RobotDescription};
    use openbench_motion::costmap::Preferences;
    use openbench_motion::local::{PlannerSettings, make_planner};
    use openbench_motion::{ScanPoint, follower};
    use openbench_osm::{OsmData, OsmMap};

    use super::*;
    use crate::open::terrain::Terrain;

    /// A search on open ground from the origin.
    fn search(route: Vec<MapPoint>) -> Locating {
        let robot = RobotDescription::sentry();
        let anywhere = Georeference::tangent_plane(LonLat::new(8.0, 50.0));
        let nothing = OsmMap::new(&OsmData::default(), anywhere);
        let from = MapPoint::default();
        let terrain = Terrain::new(nothing, None, from, &robot, Preferences::NONE).unwrap();
        let planner =
            make_planner(&follower::entry(), &PlannerSettings::new(robot.clone())).unwrap();
        let driver = Driver::new(terrain, robot, planner).unwrap();
        Locating::new(driver, route, Limit::WITHOUT_POSE)
    }

    /// A street from west to east, with walls 4 m to each side, seen from `here` to 8 m.
    fn street(here: MapPoint) -> RangeRing {
        let points = (0..720).map(|i| {
            let bearing = (0.5 * f64::from(i)).to_radians();
            let (sine, _) = libm::sincos(bearing);
            let wall = (4.0 - here.y * sine.signum()) / sine.abs().max(1e-9);
            let height = if wall < 7.9 { 0.3 } else { 0.0 };
            ScanPoint::new(here.offset(bearing, wall.min(7.9)), height)
        });
        RangeRing::new(here, 0.5, points)
    }

    /// Where a robot drives to that stands at the origin, once it has looked around.
    fn target(search: &mut Locating) -> MapPoint {
        search.look(&street(MapPoint::default()));
        let stands = Search::Drive(Velocity::ZERO);
        let start = Pose2::default();
        assert_eq!(search.step(start, SimTime::ZERO, &mut Discard), stands);
        search.step(start, SimTime::from_millis(2000), &mut Discard);
        search.target.unwrap()
    }

    #[test]
    fn in_a_street_it_drives_along_the_street() {
        let target = target(&mut search(Vec::new()));
        assert!(target.x.abs() > 6.0 && target.y.abs() < 3.2, "{target}");
    }

    #[test]
    fn it_drives_to_where_it_has_to_go_and_not_back_to_where_it_was() {
        for x in [-60.0, 60.0] {
            let target = target(&mut search(vec![
                MapPoint::default(),
                MapPoint::new(x, 0.0),
            ]));
            assert!(target.x * x > 0.0, "{target}");
        }
        let mut again = search(Vec::new());
        again.seen_from.push(MapPoint::new(10.0, 0.0));
        assert!(target(&mut again).x < -6.0);
    }

    #[test]
    fn it_stays_where_no_free_ground_is_seen_and_ends_after_a_time() {
        let mut blind = search(Vec::new());
        let at = SimTime::from_millis;
        for milliseconds in [0, 2000, 4000] {
            let step = blind.step(Pose2::default(), at(milliseconds), &mut Discard);
            assert_eq!(step, Search::Drive(Velocity::ZERO));
        }
        let late = at(1_000_000);
        assert_eq!(
            blind.step(Pose2::default(), late, &mut Discard),
            Search::Over
        );
    }

    #[test]
    fn it_ends_after_a_way() {
        let mut search = search(Vec::new());
        let mut steps = (0..).map(|i| {
            let pose = Pose2::new(f64::from(i), 0.0, 0.0);
            search.step(pose, SimTime::from_millis(100), &mut Discard)
        });
        let metres = steps.position(|step| step == Search::Over);
        assert_eq!(metres, Some(Limit::WITHOUT_POSE.metres as usize));
    }
}
