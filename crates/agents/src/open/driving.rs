//! Getting to a place: what is known of the ground, a navigator over it, and when a place is given up.

use std::time::Duration;

use openbench_core::{
    Event, Events, FailureCause, GiveUp, MapPoint, Pose2, RobotDescription, SimTime, Velocity,
    WheelSample,
};
use openbench_motion::costmap::window::Window;
use openbench_motion::{
    Footprint, LocalPlanner, Navigation, Navigator, Obstacle, RangeRing, Surroundings, Tracker,
    people::Newcomers,
};

use crate::open::terrain::Terrain;

/// Half the time of a scan, nanoseconds: on average its points are as old when it is over.
const HALF_SCAN_NS: u64 = 50_000_000;
/// Obstacles within this distance are told to the local planner, metres.
const SIGHT: f64 = 5.0;
/// A place is given up after this long and this much for each metre of the first way to it.
const LEG_TIME: (f64, f64) = (30.0, 8.0);
/// Time with somebody who moves within so many metres does not count, up to so long: he will be gone sooner or later.
const AMONG_PEOPLE: (f64, Duration) = (2.0, Duration::from_secs(300));
/// A place that may be missed is given up once the way to it is known to be this many times and metres longer than it was believed to be.
const DETOUR: (f64, f64) = (1.6, 6.0);

/// A place to get to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Where.
    pub point: MapPoint,
    /// Heading there, if it matters.
    pub yaw: Option<f64>,
    /// Whether to get there however long the way turns out to be.
    pub must: bool,
}

/// How driving goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Driving {
    /// On the way.
    OnTheWay(Velocity),
    /// There, or as near as free ground goes.
    Arrived,
    /// The place cannot be reached.
    Unreachable,
}

/// Drives to one place after another.
pub struct Driver {
    robot: RobotDescription,
    footprint: Footprint,
    terrain: Terrain,
    /// What stands around the robot, more finely: what the local planner keeps off.
    window: Window,
    tracker: Tracker,
    navigator: Navigator,
    target: Option<Target>,
    wheels: Option<WheelSample>,
    velocity: Velocity,
    /// Length of the way when it was first searched, metres.
    first_length: Option<f64>,
    patience: Patience,
    /// The way that was last told.
    told: Vec<MapPoint>,
}

impl Driver {
    /// A driver over ground with a local planner.
    pub fn new(
        terrain: Terrain,
        robot: RobotDescription,
        planner: Box<dyn LocalPlanner>,
    ) -> Result<Self, GiveUp> {
        let unfit = |why: String| GiveUp {
            address: None,
            cause: FailureCause::Briefing,
            detail: why,
        };
        Ok(Self {
            footprint: Footprint::of(&robot).map_err(|e| unfit(e.to_string()))?,
            navigator: Navigator::new(&robot, planner).map_err(|e| unfit(e.to_string()))?,
            window: Window::new(terrain.near(), terrain.near().grid().center(0)),
            robot,
            terrain,
            tracker: Tracker::default(),
            target: None,
            wheels: None,
            velocity: Velocity::ZERO,
            first_length: None,
            patience: Patience::default(),
            told: Vec::new(),
        })
    }

    /// What is known about the ground.
    pub fn terrain(&self) -> &Terrain {
        &self.terrain
    }

    /// Takes in what a scan shows.
    pub fn observe(&mut self, ring: &RangeRing, now: SimTime) {
        self.window.follow(self.terrain.near(), ring.center);
        let low = self.terrain.near().newcomers(ring);
        let seen = Newcomers {
            sensor: ring.center,
            low: &low,
            above: &ring.above,
        };
        self.tracker
            .update(SimTime(now.0.saturating_sub(HALF_SCAN_NS)), &seen);
        self.window
            .observe_but(ring, |point| self.tracker.covers(point));
        self.terrain
            .near_mut()
            .observe_but(ring, |point| self.tracker.covers(point));
    }

    /// Forgets all that was seen: it was drawn where it is not.
    pub fn forget_seen(&mut self) {
        self.terrain.forget_seen();
        self.window.forget_seen();
    }

    /// Goes on after the robot stood for so long for a reason that is no driver's: it is not late for that.
    pub fn resume(&mut self, stood: Duration) {
        self.navigator.resume(stood);
        self.patience.looked = None;
    }

    /// Takes in how the wheels turned.
    pub fn observe_wheels(&mut self, wheels: &[WheelSample]) {
        for now in wheels {
            if let Some(before) = self.wheels.replace(*now) {
                let seconds = now.stamp.since(before.stamp).as_secs_f64();
                // Samples in quick succession say more of their stamps than of the wheels.
                if seconds > 1e-3 {
                    let rim = |a: f64, b: f64| self.robot.wheel_radius * (b - a) / seconds;
                    let (left, right) = (rim(before.left, now.left), rim(before.right, now.right));
                    let turn = (right - left) / self.robot.effective_track;
                    self.velocity = Velocity::new((left + right) / 2.0, turn);
                }
            }
        }
    }

    /// Sets out for a place.
    pub fn set_target(&mut self, target: Target) {
        self.target = Some(target);
        self.navigator.set_goal(target.point, target.yaw);
        (self.patience, self.first_length) = (Patience::default(), None);
        self.told.clear();
    }

    /// What to do now at `pose`.
    pub fn drive(&mut self, pose: Pose2, now: SimTime, events: &mut dyn Events) -> Driving {
        let Some(target) = self.target else {
            return Driving::Arrived;
        };
        self.terrain.near_mut().clear_below(&self.footprint, pose);
        self.window.clear_below(&self.footprint, pose);
        let mut obstacles = self.window.obstacles_near(pose.point(), SIGHT);
        obstacles.extend(self.tracker.moving(now));
        let is_near = |o: &Obstacle| o.is_moving() && o.distance_to(pose.point()) < AMONG_PEOPLE.0;
        self.patience.spend(now, obstacles.iter().any(is_near));
        let surroundings = Surroundings {
            time: now,
            pose,
            velocity: self.velocity,
            obstacles: &obstacles,
        };
        let decided = self.navigator.drive(&surroundings, &mut self.terrain);
        self.tell(events);
        let late = self.patience.is_spent();
        let driving = match decided {
            Navigation::Drive(_) if late || !target.must && self.is_detour() => {
                Driving::Unreachable
            }
            Navigation::Drive(velocity) => Driving::OnTheWay(velocity),
            // The way led to where more can be seen, and goes on from there.
            Navigation::Arrived if self.terrain.is_partial() && !late => {
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

    /// Tells of new ways and of what was done where it did not go on, and says how long the first way may take.
    fn tell(&mut self, events: &mut dyn Events) {
        let path = self.navigator.path();
        if !path.is_empty() && path != self.told {
            let length = length(path);
            self.first_length.get_or_insert(length);
            self.patience.begin(length);
            events.record(Event::Path(path.to_vec()));
            self.told = path.to_vec();
        }
        for recovery in self.navigator.take_recoveries() {
            events.record(Event::Note(format!(
                "{:?}: {}",
                recovery.step, recovery.cause
            )));
        }
    }

    fn is_detour(&self) -> bool {
        self.first_length
            .is_some_and(|first| length(&self.told) > DETOUR.0 * first + DETOUR.1)
    }
}

/// How long getting to a place may still take.
#[derive(Debug, Clone, Copy, Default)]
struct Patience {
    /// Nothing said as long as no way is known.
    left: Option<Duration>,
    among_people: Duration,
    looked: Option<SimTime>,
}

impl Patience {
    /// The first way is this long, metres; those that are found later change nothing.
    fn begin(&mut self, length: f64) {
        self.left
            .get_or_insert(Duration::from_secs_f64(LEG_TIME.0 + LEG_TIME.1 * length));
    }

    fn spend(&mut self, now: SimTime, is_anybody_near: bool) {
        let passed = self
            .looked
            .map_or(Duration::ZERO, |looked| now.since(looked));
        self.looked = Some(now);
        let Some(left) = &mut self.left else { return };
        if is_anybody_near && self.among_people < AMONG_PEOPLE.1 {
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

    /// Seconds until patience with a way of 10 m is spent.
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
    fn who_waits_for_people_has_longer_but_not_for_ever() {
        assert_eq!(lasts(|_| false), 110);
        assert_eq!(lasts(|second| second % 2 == 0), 219);
        assert_eq!(lasts(|_| true), 410);
    }
}
