//! Navigation to a goal: a path, a local planner along it, and recovery where that does not drive
//! on.
//!
//! The ladder of recovery: the planner slows down, and stops before what it cannot pass; after a
//! moment the path is searched anew; then places and headings are searched with the whole
//! footprint, which backs, turns or winds through. A goal that cannot be reached even so is given
//! up with a cause. Each step is kept with what led to it.

use std::time::Duration;

use openbench_core::{MapPoint, RobotDescription, SimTime, Velocity};

use crate::astar::PlanError;
use crate::checks::SettingsError;
use crate::limits::Limits;
use crate::local::planner::check;
use crate::local::{Blocked, LocalPlanner, PathPoint, Progress, ahead};
use crate::recovery::ladder::{Ladder, Recovery, Rung, Step};
use crate::recovery::progress::{NO_PROGRESS, ProgressMonitor};
use crate::recovery::under_way::UnderWay;
use crate::recovery::{NoManeuver, maneuver};
use crate::route::{Guide, Route};
use crate::shape::{Footprint, ShapeError};
use crate::surroundings::Surroundings;

/// A maneuver leads to where the path is this far ahead, metres.
const MANEUVER_M: f64 = 3.0;

/// Why a goal is given up.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FailureReason {
    /// No path leads there, by what is known of the ground.
    #[error(transparent)]
    NoPath(PlanError),
    /// A path leads there for a point, but not for the footprint.
    #[error("the footprint does not fit through: {0}")]
    TooNarrow(NoManeuver),
    /// The robot made no progress, though no obstacle explains it.
    #[error("the robot made no progress: {0}")]
    Stuck(Blocked),
}

/// What to do now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Navigation {
    /// Drive with this velocity.
    Drive(Velocity),
    /// The end of the path is reached.
    Arrived,
    /// The goal is given up.
    Failed(FailureReason),
}

/// A navigator cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NavigatorError {
    /// A limit makes no sense.
    #[error(transparent)]
    Limits(#[from] SettingsError),
    /// The footprint is none.
    #[error(transparent)]
    Footprint(#[from] ShapeError),
}

/// A goal.
#[derive(Debug, Clone, Copy)]
struct Goal {
    point: MapPoint,
    /// Heading there, if it matters.
    yaw: Option<f64>,
}

/// The task of a navigator.
#[derive(Debug, Clone, Copy)]
enum Task {
    /// No goal was given yet.
    None,
    /// Driving to a goal.
    Drive(Goal),
    /// The result of the last goal.
    Ended(Navigation),
}

/// Leads a robot to one goal after another.
pub struct Navigator {
    planner: Box<dyn LocalPlanner>,
    footprint: Footprint,
    limits: Limits,
    task: Task,
    route: Route,
    ladder: Ladder,
    progress: ProgressMonitor,
    maneuver: Option<UnderWay>,
    /// Since when the robot's pose has been unknown.
    lost: Option<SimTime>,
}

impl Navigator {
    /// A navigator for a robot with a local planner.
    pub fn new(
        robot: &RobotDescription,
        planner: Box<dyn LocalPlanner>,
    ) -> Result<Self, NavigatorError> {
        Ok(Self {
            planner,
            footprint: Footprint::of(robot)?,
            limits: Limits::of(robot)?,
            task: Task::None,
            route: Route::default(),
            ladder: Ladder::default(),
            progress: ProgressMonitor::default(),
            maneuver: None,
            lost: None,
        })
    }

    /// Sets out for a place in `map`, with a heading (radians) if it matters.
    pub fn set_goal(&mut self, point: MapPoint, yaw: Option<f64>) {
        self.planner.reset();
        self.task = Task::Drive(Goal { point, yaw });
        self.route = Route::default();
        self.ladder.reset();
        self.progress = ProgressMonitor::default();
        (self.maneuver, self.lost) = (None, None);
    }

    /// The path that is being followed.
    pub fn path(&self) -> &[MapPoint] {
        self.route.path()
    }

    /// The steps of recovery that were taken since this was last called, a thousand at most.
    pub fn take_recoveries(&mut self) -> Vec<Recovery> {
        self.ladder.take()
    }

    /// What to do now. Once a goal is reached or given up the answer stays the same until there is
    /// another goal; without any goal the robot has arrived.
    pub fn drive(&mut self, now: &Surroundings<'_>, guide: &mut dyn Guide) -> Navigation {
        let goal = match self.task {
            Task::None => return Navigation::Arrived,
            Task::Ended(decided) => return decided,
            Task::Drive(goal) => goal,
        };
        // Each step decides only where those before it left the decision open. The pose comes
        // first, since all others need it.
        let decided = self
            .wait_for_pose(now, &goal)
            .or_else(|| self.give_up_without_progress(now))
            .or_else(|| self.drive_maneuver(now))
            .or_else(|| self.refresh_route(now, &goal, guide))
            .unwrap_or_else(|| self.follow_route(now, &goal));
        match decided {
            Navigation::Drive(velocity) => self.progress.command(velocity),
            Navigation::Arrived | Navigation::Failed(_) => self.task = Task::Ended(decided),
        }
        decided
    }

    /// Stands until the robot's pose is known. A goal that is not finite is given up.
    fn wait_for_pose(&mut self, now: &Surroundings<'_>, goal: &Goal) -> Option<Navigation> {
        let Err(cause) = check(now.pose, now.velocity, &[goal.point], goal.yaw) else {
            if let Some(since) = self.lost.take() {
                self.resume(now.time.since(since));
            }
            return None;
        };
        if self.lost.is_none() {
            self.ladder.record(now.time, Step::Stop, cause);
        }
        let since = *self.lost.get_or_insert(now.time);
        let waits = cause == Blocked::NoPose && now.time.since(since) < NO_PROGRESS;
        Some(if waits {
            STAND
        } else {
            Navigation::Failed(FailureReason::Stuck(cause))
        })
    }

    /// Begins anew from where the robot is, after it stood for so long for a reason that is no
    /// obstacle. That time counts against no timeout.
    pub fn resume(&mut self, stood: Duration) {
        self.progress.resume(stood);
        self.ladder.unblock();
        self.route.expire();
        self.maneuver = None;
        self.planner.reset();
    }

    /// Gives the goal up after too long without progress.
    fn give_up_without_progress(&mut self, now: &Surroundings<'_>) -> Option<Navigation> {
        if self.progress.note(now) {
            self.ladder.made_progress();
        }
        // Not blocked, and yet without progress: the robot hardly moves.
        let cause = self.ladder.cause().unwrap_or(Blocked::Creeping);
        let failed = Navigation::Failed(FailureReason::Stuck(cause));
        self.progress.is_stagnant(now.time).then_some(failed)
    }

    /// Drives a maneuver as it was found, until it is done or blocked.
    fn drive_maneuver(&mut self, now: &Surroundings<'_>) -> Option<Navigation> {
        let maneuver = self.maneuver.as_mut()?;
        maneuver.keep_up(now);
        let situation = now.situation(self.route.path(), None);
        let command = self
            .planner
            .limit_near_people(&situation, maneuver.command(&self.limits));
        let is_done = maneuver.is_over()
            || self.progress.is_creeping(now)
            || maneuver.is_blocked(&self.footprint, &self.limits, now, command);
        if is_done {
            self.maneuver = None;
            self.route.expire();
            self.planner.reset();
            return None;
        }
        Some(Navigation::Drive(command))
    }

    /// Searches the path again if it is old or blocked; recovers if there is none.
    fn refresh_route(
        &mut self,
        now: &Surroundings<'_>,
        goal: &Goal,
        guide: &mut dyn Guide,
    ) -> Option<Navigation> {
        let error = self.route.refresh(now, goal.point, guide).err()?;
        Some(self.recover(now, goal, Blocked::NoPath, FailureReason::NoPath(error)))
    }

    /// Asks the local planner for a velocity; recovers if it has none.
    fn follow_route(&mut self, now: &Surroundings<'_>, goal: &Goal) -> Navigation {
        let planned = self
            .planner
            .plan(&now.situation(self.route.path(), goal.yaw));
        let decided = match planned {
            // The planner sees nothing in the way, and yet the robot hardly moves: something holds
            // it that no sensor shows.
            Ok(Progress::Drive(_) | Progress::Slowed(..)) if self.progress.is_creeping(now) => {
                Err(Blocked::Creeping)
            }
            planned => planned,
        };
        match decided {
            Ok(Progress::Arrived) => Navigation::Arrived,
            Ok(Progress::Drive(velocity)) => {
                self.ladder.unblock();
                Navigation::Drive(velocity)
            }
            Ok(Progress::Slowed(velocity, cause)) => {
                self.ladder.unblock();
                self.ladder.slow(now.time, cause);
                Navigation::Drive(velocity)
            }
            Err(cause) => self.recover(now, goal, cause, FailureReason::Stuck(cause)),
        }
    }

    /// Takes the next step of the ladder; `failed` is why the goal is given up if none is left.
    fn recover(
        &mut self,
        now: &Surroundings<'_>,
        goal: &Goal,
        cause: Blocked,
        failed: FailureReason,
    ) -> Navigation {
        match self.ladder.climb(now.time, cause, now.is_anybody_near()) {
            Rung::Wait => STAND,
            Rung::Replan => {
                self.route.expire();
                self.planner.reset();
                STAND
            }
            Rung::Maneuver => self.begin_maneuver(now, goal, cause, failed),
            Rung::GiveUp => Navigation::Failed(failed),
        }
    }

    /// Searches a maneuver along the next metres of the path, and begins it.
    fn begin_maneuver(
        &mut self,
        now: &Surroundings<'_>,
        goal: &Goal,
        cause: Blocked,
        failed: FailureReason,
    ) -> Navigation {
        let to = ahead(self.route.path(), now.pose.point(), MANEUVER_M).unwrap_or(PathPoint {
            point: goal.point,
            is_end: true,
        });
        let yaw = goal.yaw.filter(|_| to.is_end);
        let (footprint, limits) = (&self.footprint, &self.limits);
        match maneuver(footprint, limits, now.obstacles, now.pose, to.point, yaw) {
            Ok(band) => {
                let begun = UnderWay::new(band, now.time);
                self.ladder.record(now.time, begun.first_step(), cause);
                self.ladder.unblock();
                self.progress.restart(now.pose);
                self.maneuver = Some(begun);
                STAND
            }
            // Moving obstacles are left out, and LiDAR data may have been wrong: only the last
            // attempt decides.
            Err(why) if self.ladder.is_at_top() => Navigation::Failed(match failed {
                FailureReason::NoPath(_) => failed,
                FailureReason::TooNarrow(_) | FailureReason::Stuck(_) => {
                    FailureReason::TooNarrow(why)
                }
            }),
            Err(_) => STAND,
        }
    }
}

/// Stand, and decide again in the next cycle.
const STAND: Navigation = Navigation::Drive(Velocity::ZERO);
