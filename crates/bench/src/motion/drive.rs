//! Driving through a scene.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use cpu_time::ThreadTime;
use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::Limits;
use openbench_motion::Motion;
use openbench_motion::feasible::clearance;
use openbench_motion::navigator::{Cause, NavigatorError};
use openbench_motion::recovery::Step;
use openbench_motion::teb::classes::{Explorer, Exploring};
use openbench_motion::{
    Blocked, Footprint, Guide, LocalPlanner, Navigation, Navigator, Obstacle, PlanError, Progress, Situation,
    Surroundings, Vector2,
};

use super::scene::Scene;

/// Seconds that a drive may take: so many, and so many for each metre of the straight line.
const LIMIT: (f64, f64) = (40.0, 8.0);
/// Seconds between two decisions.
pub const CYCLE: f64 = 0.05;
/// Steps of motion in one cycle.
const STEPS: usize = 5;
/// Overlap from which on it counts as a collision, metres: rounding is none.
const TOUCH: f64 = 1e-6;
/// Distance and heading error with which a robot has arrived, metres and radians.
const TOLERANCE: (f64, f64) = (0.1, 0.08);
/// What is nearer than this is told to the planner, metres.
const SIGHT: f64 = 8.0;

/// How a drive ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// The robot said that it was there, and was.
    Reached,
    /// It said so, and was not.
    Mistaken,
    /// It gave up.
    GaveUp(Cause),
    /// The time was over.
    Timeout,
}

/// How a drive went.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// How it ended.
    pub end: End,
    /// Times that the robot began to touch something.
    pub collisions: usize,
    /// The most that it was inside something, metres.
    pub deepest: f64,
    /// Seconds.
    pub seconds: f64,
    /// Changes of sign of a turn rate of more than 0.2 rad/s.
    pub swerves: usize,
    /// Milliseconds of each decision of the local planner.
    pub cycles: Vec<f64>,
    /// Steps of the ladder that were taken, from stopping on.
    pub recoveries: usize,
    /// Where it was at each decision.
    pub track: Vec<Pose2>,
}

/// Ways around what is seen to stand.
struct SceneGuide<'a> {
    explorer: &'a mut Explorer,
    standing: Vec<Obstacle>,
    how: Exploring,
}

impl Guide for SceneGuide<'_> {
    fn way(&mut self, from: MapPoint, to: MapPoint) -> Result<Vec<MapPoint>, PlanError> {
        let ways = self.explorer.explore(from, to, &self.standing, &self.how);
        ways.into_iter().next().map(|way| way.corners).ok_or(PlanError::NoWay(from, to))
    }

    fn is_blocked(&self, _path: &[MapPoint], _from: MapPoint) -> bool {
        // All that stands was known from the start.
        false
    }
}

/// A planner whose decisions are timed.
struct Timed {
    planner: Box<dyn LocalPlanner>,
    cycles: Rc<RefCell<Vec<f64>>>,
}

impl LocalPlanner for Timed {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Progress, Blocked> {
        let began = ThreadTime::now();
        let decided = self.planner.plan(situation);
        self.cycles.borrow_mut().push(began.elapsed().as_secs_f64() * 1e3);
        decided
    }

    fn among_people(&self, situation: &Situation<'_>, velocity: Velocity) -> Velocity {
        self.planner.among_people(situation, velocity)
    }

    fn reset(&mut self) {
        self.planner.reset();
    }
}

/// Drives a robot with ideal wheels of limited acceleration until it is there, gives up, or the time is over.
pub fn drive(
    scene: &Scene,
    robot: &RobotDescription,
    planner: Box<dyn LocalPlanner>,
) -> Result<Drive, NavigatorError> {
    let (footprint, limits) = (Footprint::of(robot)?, Limits::of(robot)?);
    let cycles = Rc::new(RefCell::new(Vec::new()));
    let mut navigator = Navigator::new(robot, Box::new(Timed { planner, cycles: Rc::clone(&cycles) }))?;
    navigator.set_goal(scene.goal.point(), Some(scene.goal.yaw));
    let limit = LIMIT.0 + LIMIT.1 * scene.start.point().distance(scene.goal.point());
    let mut drive = Drive {
        end: End::Timeout,
        collisions: 0,
        deepest: 0.0,
        seconds: limit,
        swerves: 0,
        cycles: vec![],
        recoveries: 0,
        track: vec![],
    };
    let mut explorer = Explorer::default();
    let mut motion = Motion { pose: scene.start, velocity: Velocity::ZERO, command: Velocity::ZERO };
    let mut touch = Touch::new(&footprint, scene);
    let mut turned = 0.0;
    for cycle in 0..(limit / CYCLE) as usize {
        let time = cycle as f64 * CYCLE;
        let by = scene.jump.filter(|j| time >= j.at).map_or(Vector2::ZERO, |j| j.by);
        let seen = seen(scene, motion.pose, time, by);
        let pose = Pose2::new(motion.pose.x + by.x, motion.pose.y + by.y, motion.pose.yaw);
        drive.track.push(motion.pose);
        let standing = seen.iter().filter(|o| !o.is_moving()).cloned().collect();
        let mut guide = SceneGuide { explorer: &mut explorer, standing, how: exploring(&footprint) };
        let now = SimTime::ZERO + Duration::from_secs_f64(time);
        let surroundings = Surroundings { time: now, pose, velocity: motion.velocity, obstacles: &seen };
        motion.command = match navigator.drive(&surroundings, &mut guide) {
            Navigation::Drive(velocity) => velocity,
            Navigation::Arrived => {
                let there = is_there(pose, scene.goal);
                (drive.end, drive.seconds) = (if there { End::Reached } else { End::Mistaken }, time);
                break;
            }
            Navigation::Failed(cause) => {
                (drive.end, drive.seconds) = (End::GaveUp(cause), time);
                break;
            }
        };
        for step in 0..STEPS {
            let dt = CYCLE / STEPS as f64;
            motion.step(&limits, dt);
            touch.look(motion.pose, time + (step + 1) as f64 * dt);
        }
        if motion.velocity.angular.abs() > 0.2 {
            drive.swerves += usize::from(turned * motion.velocity.angular < 0.0);
            turned = motion.velocity.angular;
        }
    }
    (drive.collisions, drive.deepest) = (touch.count, touch.deepest);
    let steps = navigator.take_recoveries();
    drive.recoveries = steps.iter().filter(|recovery| recovery.step != Step::Slow).count();
    drive.cycles = cycles.take();
    Ok(drive)
}

fn exploring(footprint: &Footprint) -> Exploring {
    let keep = footprint.inscribed();
    Exploring { cell: 0.04, around: 3.0, keep, comfort: keep + 0.25, most: 1, longest: 2.0 }
}

/// Counts collisions: a robot that begins inside something by rounding may stay as it is.
struct Touch<'a> {
    footprint: &'a Footprint,
    scene: &'a Scene,
    floor: f64,
    touching: bool,
    count: usize,
    deepest: f64,
}

impl<'a> Touch<'a> {
    fn new(footprint: &'a Footprint, scene: &'a Scene) -> Self {
        let floor = 0.0_f64.min(clearance(footprint, scene.obstacles.iter(), scene.start, 0.0, 1.0));
        Self { footprint, scene, floor, touching: false, count: 0, deepest: 0.0 }
    }

    fn look(&mut self, pose: Pose2, time: f64) {
        let clear = clearance(self.footprint, self.scene.obstacles.iter(), pose, time, 1.0);
        let touches = clear < self.floor - TOUCH;
        self.count += usize::from(touches && !self.touching);
        self.touching = touches;
        self.deepest = self.deepest.max(self.floor - clear);
        self.floor = 0.0_f64.min(self.floor.max(clear));
    }
}

/// Whether a robot at `pose` has arrived: what planners are told to keep to, and what the best motion's time is counted to.
pub fn is_there(pose: Pose2, goal: Pose2) -> bool {
    pose.point().distance(goal.point()) < TOLERANCE.0 && wrap_angle(pose.yaw - goal.yaw).abs() < TOLERANCE.1
}

fn seen(scene: &Scene, pose: Pose2, time: f64, by: Vector2) -> Vec<Obstacle> {
    let now = scene.obstacles.iter().map(|o| o.after(time));
    let near = now.filter(|o| o.distance_to(pose.point()) < SIGHT);
    near.map(|o| shifted(&o, by)).collect()
}

fn shifted(o: &Obstacle, by: Vector2) -> Obstacle {
    let (corners, rounding) = (o.corners(), o.rounding());
    let corners: Vec<MapPoint> = corners.map(|c| MapPoint::new(c.x + by.x, c.y + by.y)).collect();
    Obstacle::new(&corners, rounding, o.velocity()).unwrap_or_else(|_| o.clone())
}
