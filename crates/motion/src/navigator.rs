//! To a goal, whatever comes: a way, a local planner along it, and what to do when that does not go on.
//!
//! The ladder: the planner slows down; what it cannot pass it stops before; after a moment the way is searched anew; then places and headings are searched with the whole footprint, which backs, turns or winds through; what
//! cannot be reached even so is given up with a cause. Each step is kept with what led to it.

use std::time::Duration;

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};

use crate::astar::PlanError;
use crate::feasible::{Motion, conflict_before_stop, first_conflict};
use crate::local::{Blocked, LocalPlanner, Progress, Situation, ahead, check};
use crate::maneuver::{NoManeuver, maneuver};
use crate::shape::{Footprint, Obstacle, ShapeError};
use crate::teb::band::Band;
use crate::teb::planner::wanted;
use crate::teb::settings::{Limits, SettingsError};

/// A way is searched anew after this long, since more has been seen.
const REPLAN: Duration = Duration::from_millis(2500);
/// A way is not searched anew more often than this.
const REPLAN_EARLIEST: Duration = Duration::from_millis(300);
/// Standing before something that long, the robot tries the next step of the ladder.
const PATIENCE: Duration = Duration::from_millis(800);
/// Having got this far from where it last was in trouble, the robot is out of it, metres.
const PROGRESS: f64 = 0.5;
/// Without getting that far for this long, a goal is given up.
const NO_PROGRESS: Duration = Duration::from_secs(25);
/// Time in which somebody moves near does not count, up to this: he will be gone sooner or later.
const NO_PROGRESS_AMONG_PEOPLE: Duration = Duration::from_secs(120);
/// Who moves within this distance is near, metres.
const NEAR: f64 = 2.0;
/// A robot that is driven and has moved by less than so many metres and radians after so long does not get on, though its planner thinks so.
const CREEPING: (f64, f64, Duration) = (0.03, 0.1, Duration::from_millis(2000));
/// A robot that is slowed down again within this long has not been let go.
const SLOWED: Duration = Duration::from_secs(2);
/// Steps that are kept until somebody asks for them; later ones are lost.
const MOST_RECOVERIES: usize = 1000;
/// Who is told less than this is to stand: m/s, rad/s.
const STILL: (f64, f64) = (1e-3, 1e-2);
/// As often the ladder is climbed before a goal is given up.
const ATTEMPTS: u32 = 4;
/// A maneuver leads to where the way is this far ahead, metres.
const MANEUVER: f64 = 3.0;
/// Distance from obstacles that a maneuver keeps to be driven on, metres.
const SURE: f64 = 0.001;
/// Seconds until somebody is met below which a maneuver is not driven on.
const SOON: f64 = 1.0;
/// Seconds that a velocity is driven until the next is asked for, and a little for what lags.
const HOLD: f64 = 0.1;

/// Who knows the ways of the ground.
pub trait Guide {
    /// The way from one place to another, both included; where one of them is blocked, from or to as near as it gets.
    fn way(&mut self, from: MapPoint, to: MapPoint) -> Result<Vec<MapPoint>, PlanError>;

    /// Whether the next metres of a way are known to be blocked by now.
    fn is_blocked(&self, path: &[MapPoint], from: MapPoint) -> bool;
}

/// What the robot knows of itself and its surroundings.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'a> {
    /// Now.
    pub time: SimTime,
    /// Where the robot believes to be, in `map`.
    pub pose: Pose2,
    /// How it believes to move.
    pub velocity: Velocity,
    /// What stands or moves within some metres, where it is now.
    pub obstacles: &'a [Obstacle],
}

/// Why a goal is given up.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Cause {
    /// No way leads there, by what is known of the ground.
    #[error("{0}")]
    NoWay(PlanError),
    /// A way leads there for a point, but not for the footprint.
    #[error("the footprint does not get there: {0}")]
    TooNarrow(NoManeuver),
    /// The robot did not get on, though nothing says why it should not.
    #[error("the robot did not get on: {0}")]
    Stuck(Blocked),
}

/// A step of the ladder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// The robot began to be slower than its way alone would let it be.
    Slow,
    /// The robot stopped.
    Stop,
    /// The way was searched anew.
    Replan,
    /// The robot began to back off.
    Back,
    /// The robot began to turn on the spot.
    Turn,
    /// The robot began to drive as a search with its whole footprint found, forward at first.
    Wind,
}

/// A step that was taken, and why.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recovery {
    /// When.
    pub time: SimTime,
    /// What.
    pub step: Step,
    /// What led to it.
    pub cause: Blocked,
}

/// What to do now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Navigation {
    /// Drive with this velocity.
    Drive(Velocity),
    /// The end of the way is reached.
    Arrived,
    /// The goal is given up.
    Failed(Cause),
}

/// A navigator cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NavigatorError {
    /// A limit makes no sense.
    #[error(transparent)]
    Limits(#[from] SettingsError),
    /// The footprint is none.
    #[error(transparent)]
    Footprint(#[from] ShapeError),
}

/// Leads a robot to one goal after another.
pub struct Navigator {
    planner: Box<dyn LocalPlanner>,
    footprint: Footprint,
    limits: Limits,
    goal: Option<(MapPoint, Option<f64>)>,
    /// How it went with the last goal, once that is known.
    ended: Option<Navigation>,
    path: Vec<MapPoint>,
    planned: Option<SimTime>,
    blocked: Option<(SimTime, Blocked)>,
    /// Why the last search found no way, if it found none.
    no_way: Option<PlanError>,
    /// A maneuver being driven, and when it was last looked at.
    maneuver: Option<(Band, SimTime)>,
    attempts: u32,
    /// Where the robot was when it last got on, and when.
    anchor: Option<(MapPoint, SimTime)>,
    /// For how long since then somebody has been near.
    waited: Duration,
    /// When that was last looked at.
    last: Option<SimTime>,
    /// Where the robot was when it last moved at all, and for how long it has been driven since.
    moved: Option<(Pose2, Duration)>,
    /// Whether it was last told to drive.
    driven: bool,
    /// Since when the robot has not known where it is.
    lost: Option<SimTime>,
    /// When the planner last slowed the robot down.
    slowed: Option<SimTime>,
    recoveries: Vec<Recovery>,
}

impl Navigator {
    /// A navigator for a robot with a local planner.
    pub fn new(robot: &RobotDescription, planner: Box<dyn LocalPlanner>) -> Result<Self, NavigatorError> {
        Ok(Self {
            planner,
            footprint: Footprint::of(robot)?,
            limits: Limits::of(robot)?,
            goal: None,
            ended: None,
            path: Vec::new(),
            planned: None,
            blocked: None,
            no_way: None,
            maneuver: None,
            attempts: 0,
            anchor: None,
            waited: Duration::ZERO,
            last: None,
            moved: None,
            driven: false,
            lost: None,
            slowed: None,
            recoveries: Vec::new(),
        })
    }

    /// Sets out for a place, with a heading if it matters.
    pub fn set_goal(&mut self, point: MapPoint, yaw: Option<f64>) {
        self.planner.reset();
        (self.goal, self.ended) = (Some((point, yaw)), None);
        self.path.clear();
        (self.planned, self.blocked, self.maneuver) = (None, None, None);
        (self.attempts, self.anchor, self.no_way, self.moved) = (0, None, None, None);
        (self.last, self.slowed, self.lost) = (None, None, None);
        self.driven = false;
    }

    /// The way that is being followed.
    pub fn path(&self) -> &[MapPoint] {
        &self.path
    }

    /// The steps of the ladder that were taken since this was last asked, a thousand at most.
    pub fn take_recoveries(&mut self) -> Vec<Recovery> {
        std::mem::take(&mut self.recoveries)
    }

    /// What to do now. Once a goal is reached or given up the robot stands until it gets another, and hears the same again; without any goal it is where it should be.
    pub fn drive(&mut self, now: &Surroundings<'_>, guide: &mut dyn Guide) -> Navigation {
        let Some((point, yaw)) = self.goal else { return self.ended.unwrap_or(Navigation::Arrived) };
        let decided = self.decide(now, point, yaw, guide);
        self.driven = matches!(decided, Navigation::Drive(velocity) if !is_still(velocity));
        if !matches!(decided, Navigation::Drive(_)) {
            (self.goal, self.ended) = (None, Some(decided));
        }
        decided
    }

    fn decide(
        &mut self,
        now: &Surroundings<'_>,
        point: MapPoint,
        yaw: Option<f64>,
        guide: &mut dyn Guide,
    ) -> Navigation {
        if let Err(cause) = check(now.pose, now.velocity, &[point], yaw) {
            return self.wait_for_pose(now, cause);
        }
        self.find_again(now);
        self.note_progress(now);
        if self.stagnates(now) {
            let cause = self.blocked.map_or(Blocked::Creeping, |(_, cause)| cause);
            return Navigation::Failed(Cause::Stuck(cause));
        }
        if let Some(velocity) = self.drive_maneuver(now) {
            return Navigation::Drive(velocity);
        }
        if self.is_stale(now, guide) {
            self.planned = Some(now.time);
            match guide.way(now.pose.point(), point) {
                Ok(path) => (self.path, self.no_way) = (path, None),
                Err(error) => {
                    self.path.clear();
                    self.no_way = Some(error);
                    return self.climb(now, Blocked::NoPath, Cause::NoWay(error), point, yaw);
                }
            }
        }
        if let Some(error) = self.no_way {
            return self.climb(now, Blocked::NoPath, Cause::NoWay(error), point, yaw);
        }
        let situation = Situation {
            time: now.time,
            pose: now.pose,
            velocity: now.velocity,
            path: &self.path,
            final_yaw: yaw,
            obstacles: now.obstacles,
        };
        match self.planner.plan(&situation) {
            Ok(Progress::Arrived) => Navigation::Arrived,
            Ok(Progress::Drive(_) | Progress::Slowed(..)) if self.creeps(now) => {
                let cause = Blocked::Creeping;
                self.climb(now, cause, Cause::Stuck(cause), point, yaw)
            }
            Ok(Progress::Drive(velocity)) => {
                self.blocked = None;
                Navigation::Drive(velocity)
            }
            Ok(Progress::Slowed(velocity, cause)) => {
                self.blocked = None;
                self.note_slow(now, cause);
                Navigation::Drive(velocity)
            }
            Err(cause) => self.climb(now, cause, Cause::Stuck(cause), point, yaw),
        }
    }

    /// Stands until the robot knows again where it is; what is wrong with the goal itself stays so.
    fn wait_for_pose(&mut self, now: &Surroundings<'_>, cause: Blocked) -> Navigation {
        if self.lost.is_none() {
            self.record(now, Step::Stop, cause);
        }
        let since = *self.lost.get_or_insert(now.time);
        if cause == Blocked::NoPose && now.time.since(since) < NO_PROGRESS {
            return Navigation::Drive(Velocity::ZERO);
        }
        Navigation::Failed(Cause::Stuck(cause))
    }

    /// Begins anew from where the robot finds itself after it had lost its pose; the time in between does not count.
    fn find_again(&mut self, now: &Surroundings<'_>) {
        if let Some(since) = self.lost.take() {
            self.resume(now.time.since(since));
        }
    }

    /// Begins anew from where the robot is, after it stood for so long for a reason that is no driver's; that time does not count.
    pub fn resume(&mut self, stood: Duration) {
        self.anchor = self.anchor.map(|(place, time)| (place, time + stood));
        (self.moved, self.last, self.blocked) = (None, None, None);
        (self.planned, self.maneuver) = (None, None);
        self.planner.reset();
    }

    fn note_slow(&mut self, now: &Surroundings<'_>, cause: Blocked) {
        let last = self.slowed.replace(now.time);
        if last.is_none_or(|last| now.time.since(last) > SLOWED) {
            self.record(now, Step::Slow, cause);
        }
    }

    fn note_progress(&mut self, now: &Surroundings<'_>) {
        let here = now.pose.point();
        if self.anchor.is_none_or(|(anchor, _)| anchor.distance(here) > PROGRESS) {
            (self.anchor, self.attempts, self.waited) = (Some((here, now.time)), 0, Duration::ZERO);
        }
        let elapsed = now.time.since(self.last.replace(now.time).unwrap_or(now.time));
        if is_anybody_near(now) {
            self.waited += elapsed;
        }
        let apart = |from: &Pose2| (from.point().distance(here), wrap_angle(from.yaw - now.pose.yaw).abs());
        match &mut self.moved {
            Some((from, driven)) if apart(from).0 < CREEPING.0 && apart(from).1 < CREEPING.1 => {
                *driven += if self.driven { elapsed } else { Duration::ZERO };
            }
            moved => *moved = Some((now.pose, Duration::ZERO)),
        }
    }

    /// Whether the robot has all but stood while it was driven for a while. Where somebody moves it may well wait.
    fn creeps(&self, now: &Surroundings<'_>) -> bool {
        let still = self.moved.is_some_and(|(_, driven)| driven >= CREEPING.2);
        still && !now.obstacles.iter().any(Obstacle::is_moving)
    }

    fn stagnates(&self, now: &Surroundings<'_>) -> bool {
        let Some(stood) = self.anchor.map(|(_, since)| now.time.since(since)) else { return false };
        stood >= NO_PROGRESS_AMONG_PEOPLE || stood.saturating_sub(self.waited) >= NO_PROGRESS
    }

    fn is_stale(&self, now: &Surroundings<'_>, guide: &dyn Guide) -> bool {
        let Some(planned) = self.planned else { return true };
        let age = now.time.since(planned);
        let blocked = || guide.is_blocked(&self.path, now.pose.point());
        age >= REPLAN || age >= REPLAN_EARLIEST && (self.path.is_empty() || blocked())
    }

    /// Stops; after a moment searches the way anew and, if that was done already, with the whole footprint; gives up after the last attempt.
    fn climb(
        &mut self,
        now: &Surroundings<'_>,
        cause: Blocked,
        failed: Cause,
        point: MapPoint,
        yaw: Option<f64>,
    ) -> Navigation {
        if self.blocked.is_none() {
            self.record(now, Step::Stop, cause);
        }
        let (since, _) = *self.blocked.insert((self.blocked.map_or(now.time, |b| b.0), cause));
        if now.time.since(since) < PATIENCE {
            return Navigation::Drive(Velocity::ZERO);
        }
        self.blocked = Some((now.time, cause));
        self.attempts += 1;
        if !matches!(cause, Blocked::NoPath | Blocked::NoPose) && is_anybody_near(now) {
            // Whoever is in the way may go: that is no reason to give up.
            self.attempts = self.attempts.min(ATTEMPTS - 1);
        }
        if self.attempts > ATTEMPTS {
            return Navigation::Failed(failed);
        }
        if self.attempts == 1 {
            self.record(now, Step::Replan, cause);
            self.planned = None;
            self.planner.reset();
            return Navigation::Drive(Velocity::ZERO);
        }
        self.begin_maneuver(now, cause, failed, point, yaw)
    }

    fn begin_maneuver(
        &mut self,
        now: &Surroundings<'_>,
        cause: Blocked,
        failed: Cause,
        point: MapPoint,
        yaw: Option<f64>,
    ) -> Navigation {
        let (to, last) = ahead(&self.path, now.pose.point(), MANEUVER).unwrap_or((point, true));
        let yaw = yaw.filter(|_| last);
        match maneuver(&self.footprint, &self.limits, now.obstacles, now.pose, to, yaw) {
            Ok(band) => {
                self.record(now, first_step(&band), cause);
                self.maneuver = Some((band, now.time));
                (self.blocked, self.moved) = (None, Some((now.pose, Duration::ZERO)));
                Navigation::Drive(Velocity::ZERO)
            }
            // Who moves may have been in the way, and what was seen may have been wrong: the last attempt decides.
            Err(why) if self.attempts >= ATTEMPTS => Navigation::Failed(match failed {
                Cause::NoWay(_) => failed,
                Cause::TooNarrow(_) | Cause::Stuck(_) => Cause::TooNarrow(why),
            }),
            Err(_) => Navigation::Drive(Velocity::ZERO),
        }
    }

    /// Drives a maneuver as it was found, until it is done or something is in its way.
    fn drive_maneuver(&mut self, now: &Surroundings<'_>) -> Option<Velocity> {
        let creeps = self.creeps(now);
        let (band, seen) = self.maneuver.as_mut()?;
        band.keep_up(now.pose, now.time.since(*seen).as_secs_f64());
        *seen = now.time;
        let situation = Situation {
            time: now.time,
            pose: now.pose,
            velocity: now.velocity,
            path: &self.path,
            final_yaw: None,
            obstacles: now.obstacles,
        };
        let command = self.planner.among_people(&situation, wanted(band, &self.limits));
        let motion = Motion { pose: now.pose, velocity: now.velocity, command };
        let meets = conflict_before_stop(&self.footprint, now.obstacles, motion, &self.limits, HOLD, SURE);
        // Who moves may have come into its way since.
        let met = first_conflict(&self.footprint, &self.limits, now.obstacles, band, SURE);
        // Its last steps lead to the goal's very place, where a robot may not get that stands beside it.
        if band.duration() < 3.0 * HOLD || creeps || meets.is_some() || met.is_some_and(|at| at < SOON) {
            (self.maneuver, self.planned) = (None, None);
            self.planner.reset();
            return None;
        }
        Some(command)
    }

    fn record(&mut self, now: &Surroundings<'_>, step: Step, cause: Blocked) {
        if self.recoveries.len() < MOST_RECOVERIES {
            self.recoveries.push(Recovery { time: now.time, step, cause });
        }
    }
}

/// What a maneuver begins with.
fn first_step(band: &Band) -> Step {
    match band.velocity(0).linear {
        v if v < -1e-3 => Step::Back,
        v if v < 1e-3 => Step::Turn,
        _ => Step::Wind,
    }
}

fn is_still(velocity: Velocity) -> bool {
    velocity.linear.abs() < STILL.0 && velocity.angular.abs() < STILL.1
}

fn is_anybody_near(now: &Surroundings<'_>) -> bool {
    let here = now.pose.point();
    now.obstacles.iter().any(|o| o.is_moving() && o.distance_to(here) < NEAR)
}
