//! Driving to a target: costmaps, tracked people, the navigator, and when a target is given up.

use std::time::Duration;

use openbench_core::{
    Event, Events, MapPoint, Pose2, RobotDescription, SimTime, Velocity, WheelSample, Work,
};
use openbench_motion::costmap::RollingWindow;
use openbench_motion::{
    Footprint, LocalPlanner, Navigation, Navigator, NavigatorError, NewPoints, Obstacle, RangeRing,
    ShapeError, Surroundings, Tracker,
};
use openbench_osm::OsmMap;

use crate::open::terrain::Terrain;

/// Half the duration of a scan: the mean age of its points at its end.
const HALF_SCAN_NS: u64 = 50_000_000;
/// Obstacles within this distance are passed to the local planner.
const SIGHT_M: f64 = 5.0;
/// A target is given up after this time, and this much more for each metre of the first path.
const BASE_TIME_S: f64 = 30.0;
const TIME_PER_METRE_S: f64 = 8.0;
/// Time with a moving person within this distance does not count: people move on.
const PEOPLE_NEAR_M: f64 = 2.0;
/// The longest time with people near that does not count.
const LONGEST_AMONG_PEOPLE: Duration = Duration::from_secs(300);
/// An optional target is given up once its path is longer than the first one by this factor and
/// this many metres.
const DETOUR_FACTOR: f64 = 1.6;
const DETOUR_M: f64 = 6.0;
/// Time between two reports of the ground, and how far they reach along x and y, metres.
const COSTMAP_INTERVAL: Duration = Duration::from_secs(2);
const COSTMAP_M: f64 = 10.0;

/// A target to drive to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Its position in `map`.
    pub point: MapPoint,
    /// Heading at the target, if it matters: radians.
    pub yaw: Option<f64>,
    /// Whether to pursue it however long the path turns out to be.
    pub must: bool,
}

/// The state of driving to a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Driving {
    /// On the way, with the velocity to drive.
    OnTheWay(Velocity),
    /// At the target, or as near as free ground permits.
    Arrived,
    /// The target cannot be reached.
    Unreachable,
}

/// A robot that cannot be driven.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DriverError {
    /// Its footprint is not sound.
    #[error(transparent)]
    Footprint(#[from] ShapeError),
    /// Its limits are not sound.
    #[error(transparent)]
    Navigator(#[from] NavigatorError),
}

/// Drives to one target after another.
pub struct Driver {
    robot: RobotDescription,
    footprint: Footprint,
    terrain: Terrain,
    /// The costmap around the robot in finer cells, for the local planner.
    window: RollingWindow,
    tracker: Tracker,
    navigator: Navigator,
    target: Option<Target>,
    wheels: Option<WheelSample>,
    velocity: Velocity,
    /// Length of the first path to the target, metres.
    first_length: Option<f64>,
    patience: Patience,
    /// The path that was last reported.
    reported: Vec<MapPoint>,
    /// When the ground was last reported.
    shown: Option<SimTime>,
}

impl Driver {
    /// A driver for a robot, with its terrain and local planner.
    ///
    /// # Errors
    /// A robot without a sound footprint or limits.
    pub fn new(
        terrain: Terrain,
        robot: RobotDescription,
        planner: Box<dyn LocalPlanner>,
    ) -> Result<Self, DriverError> {
        Ok(Self {
            footprint: Footprint::of(&robot)?,
            navigator: Navigator::new(&robot, planner)?,
            window: RollingWindow::new(terrain.near(), terrain.near().grid().center(0)),
            robot,
            terrain,
            tracker: Tracker::default(),
            target: None,
            wheels: None,
            velocity: Velocity::ZERO,
            first_length: None,
            patience: Patience::default(),
            reported: Vec::new(),
            shown: None,
        })
    }

    /// The terrain as known so far.
    pub fn terrain(&self) -> &Terrain {
        &self.terrain
    }

    /// Adds a scan to the costmaps and to the tracker of people.
    pub fn observe(&mut self, ring: &RangeRing, now: SimTime) {
        // New points are those on ground that was free so far. They are found before the scan
        // enters the costmap, where they would be known obstacles.
        self.window.follow(self.terrain.near(), ring.center);
        let low = self.terrain.near().new_points(ring);
        let seen = NewPoints {
            sensor: ring.center,
            low: &low,
            above: &ring.above,
        };
        self.tracker
            .update(SimTime(now.0.saturating_sub(HALF_SCAN_NS)), &seen);
        // People are obstacles of the tracker, with a velocity. In the costmaps they would stay as
        // static obstacles where they have been.
        self.window
            .observe_static(ring, |point| self.tracker.covers(point));
        self.terrain
            .near_mut()
            .observe_static(ring, |point| self.tracker.covers(point));
    }

    /// Takes a map on which some buildings are elsewhere.
    pub fn set_map(&mut self, map: OsmMap) {
        self.terrain.set_map(map);
        self.window.take_ground(self.terrain.near());
    }

    /// Forgets all obstacles that were seen, after they were misplaced. The ground around the robot
    /// is covered.
    pub fn forget_seen(&mut self, here: MapPoint) {
        self.terrain.forget_seen();
        self.terrain.follow(here);
        self.window.forget_seen();
    }

    /// Continues after the robot stood for this long for another reason: that time does not count.
    pub fn resume(&mut self, stood: Duration) {
        self.navigator.resume(stood);
        // The next call then measures no time, so the pause does not count.
        self.patience.looked = None;
    }

    /// Updates the velocity estimate from wheel angles.
    pub fn observe_wheels(&mut self, wheels: &[WheelSample]) {
        for now in wheels {
            if let Some(before) = self.wheels.replace(*now) {
                let seconds = now.stamp.since(before.stamp).as_secs_f64();
                // In shorter intervals errors of the stamps would dominate.
                if seconds > 1e-3 {
                    let rim = |a: f64, b: f64| self.robot.wheel_radius * (b - a) / seconds;
                    let (left, right) = (rim(before.left, now.left), rim(before.right, now.right));
                    let turn = (right - left) / self.robot.effective_track;
                    self.velocity = Velocity::new((left + right) / 2.0, turn);
                }
            }
        }
    }

    /// Sets a new target.
    pub fn set_target(&mut self, target: Target) {
        self.target = Some(target);
        self.navigator.set_goal(target.point, target.yaw);
        (self.patience, self.first_length) = (Patience::default(), None);
        self.reported.clear();
    }

    /// Where it drives to.
    #[cfg(test)]
    pub fn target(&self) -> Option<Target> {
        self.target
    }

    /// Moves the target with the building that it is in front of. The robot has no more time for
    /// it than before.
    pub fn move_target(&mut self, by: MapPoint) {
        if let Some(target) = &mut self.target {
            target.point = MapPoint::new(target.point.x + by.x, target.point.y + by.y);
            self.navigator.set_goal(target.point, target.yaw);
        }
    }

    /// Decides how to drive on from `pose`.
    pub fn drive(&mut self, pose: Pose2, now: SimTime, events: &mut dyn Events) -> Driving {
        let Some(target) = self.target else {
            return Driving::Arrived;
        };
        // The robot stands on this ground, so it is free, whatever was seen there before.
        self.terrain.near_mut().clear_below(&self.footprint, pose);
        self.window.clear_below(&self.footprint, pose);
        let mut obstacles = self.window.obstacles_near(pose.point(), SIGHT_M);
        obstacles.extend(self.tracker.moving(now));
        let is_near = |o: &Obstacle| o.is_moving() && o.distance_to(pose.point()) < PEOPLE_NEAR_M;
        self.patience.spend(now, obstacles.iter().any(is_near));
        let surroundings = Surroundings {
            time: now,
            pose,
            velocity: self.velocity,
            obstacles: &obstacles,
        };
        let decided = self.navigator.drive(&surroundings, &mut self.terrain);
        events.record(Event::Work(Work::LocalPlan));
        for _ in 0..self.terrain.take_searches() {
            events.record(Event::Work(Work::PathSearch));
        }
        // First, since the first path sets the time limit that `is_spent` tests.
        self.report(events);
        self.show_ground(pose.point(), now, events);
        let late = self.patience.is_spent();
        let driving = match decided {
            Navigation::Drive(_) if late || !target.must && self.is_detour() => {
                Driving::Unreachable
            }
            Navigation::Drive(velocity) => Driving::OnTheWay(velocity),
            // The path led to a place from which more can be seen, and continues from there.
            Navigation::Arrived if self.terrain.is_partial() && !late => {
                // `patience` is kept: each partial path counts against the same time limit.
                self.navigator.set_goal(target.point, target.yaw);
                Driving::OnTheWay(Velocity::ZERO)
            }
            Navigation::Arrived => Driving::Arrived,
            Navigation::Failed(cause) => {
                events.record(Event::Note(cause.to_string()));
                Driving::Unreachable
            }
        };
        if !matches!(driving, Driving::OnTheWay(_)) {
            self.target = None;
        }
        driving
    }

    /// Reports new paths and recoveries, and sets the time limit by the first path.
    fn report(&mut self, events: &mut dyn Events) {
        let path = self.navigator.path();
        if !path.is_empty() && path != self.reported {
            let length = length(path);
            // Later paths are compared with the first one, which was planned without the obstacles
            // that were seen since.
            self.first_length.get_or_insert(length);
            self.patience.begin(length);
            events.record(Event::Path(path.to_vec()));
            self.reported = path.to_vec();
        }
        for recovery in self.navigator.take_recoveries() {
            events.record(Event::Note(format!(
                "{:?}: {}",
                recovery.step, recovery.cause
            )));
        }
    }

    /// Reports the ground around the robot from time to time.
    fn show_ground(&mut self, here: MapPoint, now: SimTime, events: &mut dyn Events) {
        let is_due = |shown: SimTime| now.since(shown) >= COSTMAP_INTERVAL;
        if self.shown.is_none_or(is_due) {
            self.shown = Some(now);
            let ground = self.terrain.near().around(here, COSTMAP_M);
            events.record(Event::Costmap(ground));
        }
    }

    fn is_detour(&self) -> bool {
        self.first_length
            .is_some_and(|first| length(&self.reported) > DETOUR_FACTOR * first + DETOUR_M)
    }
}

/// The time that is left for a target.
#[derive(Debug, Clone, Copy, Default)]
struct Patience {
    /// `None` until a path is known.
    left: Option<Duration>,
    among_people: Duration,
    looked: Option<SimTime>,
}

impl Patience {
    /// Starts the clock with the first path's length, metres. Later calls change nothing.
    fn begin(&mut self, length: f64) {
        self.left.get_or_insert(Duration::from_secs_f64(
            BASE_TIME_S + TIME_PER_METRE_S * length,
        ));
    }

    fn spend(&mut self, now: SimTime, is_anybody_near: bool) {
        let passed = self
            .looked
            .map_or(Duration::ZERO, |looked| now.since(looked));
        self.looked = Some(now);
        // Before the first path there is no limit yet, but `looked` is up to date for the first
        // one.
        let Some(left) = &mut self.left else { return };
        // Bounded, so that somebody who stays near for good does not stop the clock for ever.
        if is_anybody_near && self.among_people < LONGEST_AMONG_PEOPLE {
            self.among_people += passed;
        } else {
            *left = left.saturating_sub(passed);
        }
    }

    fn is_spent(&self) -> bool {
        self.left == Some(Duration::ZERO)
    }
}

fn length(path: &[MapPoint]) -> f64 {
    path.windows(2).map(|w| w[0].distance(w[1])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seconds until the time for a path of 10 m is over.
    fn lasts(is_anybody_near: impl Fn(u64) -> bool) -> u64 {
        let mut patience = Patience::default();
        for second in 0.. {
            patience.spend(
                SimTime::ZERO + Duration::from_secs(second),
                is_anybody_near(second),
            );
            patience.begin(10.0 + second as f64);
            if patience.is_spent() {
                return second;
            }
        }
        unreachable!()
    }

    #[test]
    fn waiting_for_people_extends_the_time_limit_but_not_for_ever() {
        assert_eq!(lasts(|_| false), 110);
        assert_eq!(lasts(|second| second % 2 == 0), 219);
        assert_eq!(lasts(|_| true), 410);
    }
}
