//! Getting to a place: costmap, search, follower, and what to do when stuck.

use std::time::Duration;

use openbench_core::{Event, Events, MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::{Blocked, Costmap, FollowInput, Follower, PathFollower, Progress, RangeRing, plan};
use openbench_osm::polygon::nearest_on_segment;

/// A way is searched anew after this long, since more has been seen.
const REPLAN: Duration = Duration::from_millis(2500);
/// Standing before an obstacle that long, the robot searches for another way.
const PATIENCE: Duration = Duration::from_millis(800);
/// Without having moved on, a way is not searched anew more often than this.
const REPLAN_EARLIEST: Duration = Duration::from_millis(300);
/// Within this distance of the robot's middle its own hull stands, metres.
const OWN_HULL: f64 = 0.4;
/// How far ahead of the robot the way is checked against every scan, metres.
const CHECK_AHEAD: f64 = 3.0;
/// Backing off lasts this long.
const BACK_OFF: Duration = Duration::from_millis(1600);
/// As often the robot backs off before it gives a place up.
const ATTEMPTS: u32 = 4;
/// Without leaving a circle of half a metre for this long, a place is given up.
const NO_PROGRESS: Duration = Duration::from_secs(25);
/// A place is also given up after this long and this much for each metre of the first way to it.
const LEG_TIME: (f64, f64) = (30.0, 8.0);

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
    costmap: Costmap,
    follower: Follower,
    target: Option<Target>,
    path: Vec<MapPoint>,
    planned: SimTime,
    blocked: Option<SimTime>,
    backing: Option<SimTime>,
    attempts: u32,
    /// Where the robot was when it last moved on, and when.
    anchor: (MapPoint, SimTime),
    /// Length of the way when it was first searched, metres.
    first_length: Option<f64>,
    deadline: Option<SimTime>,
}

impl Driver {
    /// A driver over a costmap.
    pub fn new(costmap: Costmap, robot: RobotDescription) -> Self {
        Self {
            costmap,
            follower: Follower::new(robot),
            target: None,
            path: Vec::new(),
            planned: SimTime::ZERO,
            blocked: None,
            backing: None,
            attempts: 0,
            anchor: (MapPoint::default(), SimTime::ZERO),
            first_length: None,
            deadline: None,
        }
    }

    /// What is known about the ground.
    pub fn costmap(&self) -> &Costmap {
        &self.costmap
    }

    /// Takes in what a scan shows.
    pub fn observe(&mut self, ring: &RangeRing) {
        self.costmap.observe(ring);
    }

    /// Sets out for a place.
    pub fn set_target(&mut self, target: Target, now: SimTime) {
        self.target = Some(target);
        self.path.clear();
        (self.blocked, self.backing, self.attempts) = (None, None, 0);
        (self.anchor.1, self.deadline, self.first_length) = (now, None, None);
    }

    /// What to do now at `pose`.
    pub fn drive(&mut self, pose: Pose2, now: SimTime, events: &mut dyn Events) -> Driving {
        let Some(target) = self.target else { return Driving::Arrived };
        if let Some(velocity) = self.back_off(pose, now) {
            return Driving::OnTheWay(velocity);
        }
        if self.stagnates(pose, now) {
            self.target = None;
            return Driving::Unreachable;
        }
        let age = now.since(self.planned);
        let stale = self.path.is_empty()
            || age >= REPLAN
            || (age >= REPLAN_EARLIEST && !self.clear_ahead(pose.point()));
        if stale && !self.search(pose, target, now, events) {
            return self.set_back(now);
        }
        if !target.must && self.is_detour() {
            self.target = None;
            return Driving::Unreachable;
        }
        let input = FollowInput { pose, path: &self.path, final_yaw: target.yaw, costmap: &self.costmap };
        match self.follower.follow(&input) {
            Ok(Progress::Arrived) => {
                self.target = None;
                Driving::Arrived
            }
            Ok(Progress::Drive(velocity)) => {
                self.blocked = None;
                Driving::OnTheWay(velocity)
            }
            Err(Blocked::NoPath | Blocked::NoPose) => self.set_back(now),
            Err(Blocked::Obstacle(_)) => self.wait(now),
        }
    }

    fn search(&mut self, pose: Pose2, target: Target, now: SimTime, events: &mut dyn Events) -> bool {
        self.costmap.inflate();
        self.planned = now;
        match plan(&self.costmap, pose.point(), target.point) {
            Ok(path) => {
                let length = length(&path);
                self.first_length.get_or_insert(length);
                let limit = Duration::from_secs_f64(LEG_TIME.0 + LEG_TIME.1 * length);
                self.deadline.get_or_insert(now + limit);
                events.record(Event::Path(path.clone()));
                self.path = path;
                true
            }
            Err(error) => {
                events.record(Event::Note(error.to_string()));
                self.path.clear();
                false
            }
        }
    }

    fn is_detour(&self) -> bool {
        self.first_length.is_some_and(|first| length(&self.path) > DETOUR.0 * first + DETOUR.1)
    }

    /// Whether the next metres of the way are free by the newest scans.
    fn clear_ahead(&self, from: MapPoint) -> bool {
        let Some((at, start)) = nearest_on_path(&self.path, from) else { return true };
        let mut left = CHECK_AHEAD;
        let mut begin = start;
        for &corner in &self.path[at + 1..] {
            let length = begin.distance(corner);
            let end = along(begin, corner, left / length);
            // The robot stands where it stands: only what lies ahead of its own hull counts.
            let hull = (OWN_HULL - begin.distance(from)).max(0.0) / begin.distance(end);
            if hull < 1.0 && !self.costmap.is_clear(along(begin, end, hull), end) {
                return false;
            }
            left -= length;
            if left <= 0.0 {
                break;
            }
            begin = corner;
        }
        true
    }

    fn wait(&mut self, now: SimTime) -> Driving {
        let since = *self.blocked.get_or_insert(now);
        if now.since(since) >= PATIENCE { self.set_back(now) } else { Driving::OnTheWay(Velocity::ZERO) }
    }

    fn set_back(&mut self, now: SimTime) -> Driving {
        self.blocked = None;
        self.path.clear();
        self.attempts += 1;
        if self.attempts > ATTEMPTS {
            self.target = None;
            return Driving::Unreachable;
        }
        self.backing = Some(now);
        Driving::OnTheWay(Velocity::ZERO)
    }

    /// Backwards a little, if there is room, so that turning and seeing get easier.
    fn back_off(&mut self, pose: Pose2, now: SimTime) -> Option<Velocity> {
        let since = self.backing?;
        let behind = pose.transform(-0.3, 0.0);
        let room = self.costmap.nearest_obstacle_within(behind, 0.2).is_none();
        if now.since(since) >= BACK_OFF || !room {
            self.backing = None;
            return None;
        }
        Some(Velocity::new(-0.15, 0.0))
    }

    fn stagnates(&mut self, pose: Pose2, now: SimTime) -> bool {
        if pose.point().distance(self.anchor.0) > 0.5 {
            self.anchor = (pose.point(), now);
        }
        now.since(self.anchor.1) >= NO_PROGRESS || self.deadline.is_some_and(|deadline| now > deadline)
    }
}

/// The place on a way that is nearest to `from`, and the number of the stretch that it is on.
fn nearest_on_path(path: &[MapPoint], from: MapPoint) -> Option<(usize, MapPoint)> {
    let on = |i: usize| (i, nearest_on_segment(path[i], path[i + 1], from).0);
    let stretches = (0..path.len().saturating_sub(1)).map(on);
    stretches.min_by(|a, b| a.1.distance(from).total_cmp(&b.1.distance(from)))
}

/// The point at the share `t` of the way from `a` to `b`, `b` at most.
fn along(a: MapPoint, b: MapPoint, t: f64) -> MapPoint {
    let t = if t < 1.0 { t } else { 1.0 };
    MapPoint::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y))
}

fn length(path: &[MapPoint]) -> f64 {
    path.windows(2).map(|w| w[0].distance(w[1])).sum()
}
