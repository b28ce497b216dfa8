//! A drive of a local planner through a scene, with ideal wheels.

use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

use cpu_time::ThreadTime;
use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::Limits;
use openbench_motion::Motion;
use openbench_motion::feasible::clearance;
use openbench_motion::recovery::Step;
use openbench_motion::teb::{Explorer, Exploring};
use openbench_motion::{
    Blocked, Footprint, Guide, LocalPlanner, Navigation, Navigator, Obstacle, PlanError, Progress,
    Situation, Surroundings, Vector2,
};
use openbench_motion::{FailureReason, NavigatorError};

use super::scene::Scene;

/// Constant part of the time limit of a drive.
const BASE_TIME_LIMIT_S: f64 = 40.0;
/// Time limit for each metre of the straight line from start to goal.
const TIME_LIMIT_S_PER_M: f64 = 8.0;
/// Time between two decisions of the planner.
pub const CYCLE_S: f64 = 0.05;
/// Integration steps in one cycle.
const STEPS_PER_CYCLE: usize = 5;
/// Overlap above which a contact counts as a collision; below it is rounding.
const CONTACT_TOLERANCE_M: f64 = 1e-6;
/// Position error at the goal within which the robot has arrived.
const POSITION_TOLERANCE_M: f64 = 0.1;
/// Heading error at the goal within which the robot has arrived.
const HEADING_TOLERANCE_RAD: f64 = 0.08;
/// Distance up to which the planner receives obstacles.
const SENSOR_RANGE_M: f64 = 8.0;
/// Turn rate above which a change of its sign counts as a swerve.
const SWERVE_RATE_RAD_PER_S: f64 = 0.2;

/// The end of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// The navigator reported arrival at the goal.
    Reached,
    /// The navigator reported arrival outside the tolerance of the goal.
    Mistaken,
    /// The navigator gave up.
    GaveUp(FailureReason),
    /// The time limit expired.
    Timeout,
}

/// The result of a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Its end.
    pub end: End,
    /// Number of collisions.
    pub collisions: usize,
    /// Maximum penetration of an obstacle, metres.
    pub deepest: f64,
    /// Duration, seconds.
    pub seconds: f64,
    /// Number of changes of sign between turn rates above 0.2 rad/s.
    pub swerves: usize,
    /// CPU time of each decision of the local planner, milliseconds.
    pub cycles: Vec<f64>,
    /// Number of recovery steps, from stopping upwards.
    pub recoveries: usize,
    /// The true pose at each decision.
    pub track: Vec<Pose2>,
}

/// A global planner around the visible static obstacles.
struct SceneGuide<'a> {
    explorer: &'a mut Explorer,
    standing: Vec<Obstacle>,
    how: Exploring,
}

impl Guide for SceneGuide<'_> {
    fn path(&mut self, from: MapPoint, to: MapPoint) -> Result<Vec<MapPoint>, PlanError> {
        let paths = self.explorer.explore(from, to, &self.standing, &self.how);
        paths
            .into_iter()
            .next()
            .map(|path| path.corners)
            .ok_or(PlanError::NoPath(from, to))
    }

    fn is_blocked(&self, _path: &[MapPoint], _from: MapPoint) -> bool {
        // All static obstacles are known from the start.
        false
    }
}

/// A planner that measures the CPU time of its decisions.
struct Timed {
    planner: Box<dyn LocalPlanner>,
    /// Receives milliseconds.
    cycles: Sender<f64>,
}

impl LocalPlanner for Timed {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Progress, Blocked> {
        // CPU time of this thread: other scenes are driven on other threads at the same time.
        let began = ThreadTime::now();
        let decided = self.planner.plan(situation);
        // The drive, which receives them, may be over.
        let _ = self.cycles.send(began.elapsed().as_secs_f64() * 1e3);
        decided
    }

    // Passed on: the trait's default would replace the planner's own rules for people.
    fn limit_near_people(&self, situation: &Situation<'_>, velocity: Velocity) -> Velocity {
        self.planner.limit_near_people(situation, velocity)
    }

    fn reset(&mut self) {
        self.planner.reset();
    }
}

/// Simulates a robot with ideal wheels of limited acceleration until it arrives, gives up, or
/// exceeds the time limit.
///
/// # Errors
/// A robot for which no navigator can be created.
///
/// ```
/// use openbench_core::RobotDescription;
/// use openbench_motion::{Teb, TebSettings};
/// use openbench_trials::motion::drive::{End, drive};
/// use openbench_trials::motion::scene::scene;
///
/// // Scene 0 of seed 1 is of the kind `open`.
/// let robot = RobotDescription::sentry();
/// let scene = scene(0, 1, &robot)?;
/// let drive = drive(&scene, &robot, Box::new(Teb::new(&robot, TebSettings::default())?))?;
/// assert_eq!((drive.end, drive.collisions), (End::Reached, 0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn drive(
    scene: &Scene,
    robot: &RobotDescription,
    planner: Box<dyn LocalPlanner>,
) -> Result<Drive, NavigatorError> {
    let (footprint, limits) = (Footprint::of(robot)?, Limits::of(robot)?);
    // The navigator owns the planner, and the times are read after the drive.
    let (timing, cycles) = channel();
    let mut navigator = Navigator::new(
        robot,
        Box::new(Timed {
            planner,
            cycles: timing,
        }),
    )?;
    navigator.set_goal(scene.goal.point(), Some(scene.goal.yaw));
    let straight_line = scene.start.point().distance(scene.goal.point());
    let limit = BASE_TIME_LIMIT_S + TIME_LIMIT_S_PER_M * straight_line;
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
    let mut motion = Motion {
        pose: scene.start,
        velocity: Velocity::ZERO,
        command: Velocity::ZERO,
    };
    let mut touch = Touch::new(&footprint, scene);
    // The last turn rate that was more than a correction.
    let mut turned = 0.0;
    for cycle in 0..(limit / CYCLE_S) as usize {
        let time = cycle as f64 * CYCLE_S;
        let by = scene
            .jump
            .filter(|j| time >= j.at)
            .map_or(Vector2::ZERO, |j| j.by);
        // Obstacles are measured relative to the robot: they jump together with its estimated pose.
        let seen = seen(scene, motion.pose, time, by);
        let pose = Pose2::new(motion.pose.x + by.x, motion.pose.y + by.y, motion.pose.yaw);
        // The true pose: the estimate's jump is not the robot's.
        drive.track.push(motion.pose);
        // Moving obstacles are left to the local planner: paths are searched among obstacles where
        // they are now.
        let standing = seen.iter().filter(|o| !o.is_moving()).cloned().collect();
        let mut guide = SceneGuide {
            explorer: &mut explorer,
            standing,
            how: exploring(&footprint),
        };
        let now = SimTime::ZERO + Duration::from_secs_f64(time);
        let surroundings = Surroundings {
            time: now,
            pose,
            velocity: motion.velocity,
            obstacles: &seen,
        };
        motion.command = match navigator.drive(&surroundings, &mut guide) {
            Navigation::Drive(velocity) => velocity,
            Navigation::Arrived => {
                // By the estimate, in whose frame the goal is. The reference motion gets a goal
                // that is moved by the jump instead.
                let there = is_there(pose, scene.goal);
                (drive.end, drive.seconds) =
                    (if there { End::Reached } else { End::Mistaken }, time);
                break;
            }
            Navigation::Failed(cause) => {
                (drive.end, drive.seconds) = (End::GaveUp(cause), time);
                break;
            }
        };
        for step in 0..STEPS_PER_CYCLE {
            let dt = CYCLE_S / STEPS_PER_CYCLE as f64;
            motion.step(&limits, dt);
            // After the step, so that pose and time belong together.
            touch.look(motion.pose, time + (step + 1) as f64 * dt);
        }
        if motion.velocity.angular.abs() > SWERVE_RATE_RAD_PER_S {
            drive.swerves += usize::from(turned * motion.velocity.angular < 0.0);
            turned = motion.velocity.angular;
        }
    }
    (drive.collisions, drive.deepest) = (touch.count, touch.deepest);
    let steps = navigator.take_recoveries();
    drive.recoveries = steps
        .iter()
        .filter(|recovery| recovery.step != Step::Slow)
        .count();
    drive.cycles = cycles.try_iter().collect();
    Ok(drive)
}

fn exploring(footprint: &Footprint) -> Exploring {
    let keep = footprint.inscribed();
    Exploring {
        cell: 0.04,
        around: 3.0,
        keep,
        comfort: keep + 0.25,
        most: 1,
        longest: 2.0,
    }
}

/// Counts collisions. A robot that starts inside an obstacle by rounding may remain there, but not
/// deeper.
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
        let floor = 0.0_f64.min(clearance(
            footprint,
            scene.obstacles.iter(),
            scene.start,
            0.0,
            1.0,
        ));
        Self {
            footprint,
            scene,
            floor,
            touching: false,
            count: 0,
            deepest: 0.0,
        }
    }

    fn look(&mut self, pose: Pose2, time: f64) {
        let clear = clearance(self.footprint, self.scene.obstacles.iter(), pose, time, 1.0);
        // The floor is the shallowest penetration so far: a deeper one is a new contact.
        let touches = clear < self.floor - CONTACT_TOLERANCE_M;
        self.count += usize::from(touches && !self.touching);
        self.touching = touches;
        self.deepest = self.deepest.max(self.floor - clear);
        // The floor only rises: a contact that the robot has left must not come back.
        self.floor = 0.0_f64.min(self.floor.max(clear));
    }
}

/// Whether a robot at `pose` is within the tolerance of the goal, for planners and for the
/// reference motion.
pub fn is_there(pose: Pose2, goal: Pose2) -> bool {
    pose.point().distance(goal.point()) < POSITION_TOLERANCE_M
        && wrap_angle(pose.yaw - goal.yaw).abs() < HEADING_TOLERANCE_RAD
}

/// The obstacles within sensor range, displaced by the jump `by` of the estimate.
fn seen(scene: &Scene, pose: Pose2, time: f64, by: Vector2) -> Vec<Obstacle> {
    let now = scene.obstacles.iter().map(|o| o.after(time));
    let near = now.filter(|o| o.distance_to(pose.point()) < SENSOR_RANGE_M);
    near.map(|o| shifted(&o, by)).collect()
}

fn shifted(o: &Obstacle, by: Vector2) -> Obstacle {
    let (corners, rounding) = (o.corners(), o.rounding());
    let corners: Vec<MapPoint> = corners
        .map(|c| MapPoint::new(c.x + by.x, c.y + by.y))
        .collect();
    Obstacle::new(&corners, rounding, o.velocity()).unwrap_or_else(|_| o.clone())
}
