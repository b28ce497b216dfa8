//! The ladder of recovery: steps that are tried one after the other where the robot does not drive
//! on.

use std::time::Duration;

use openbench_core::SimTime;

use crate::local::Blocked;

/// Standing blocked for so long, the robot tries the next step.
const PATIENCE: Duration = Duration::from_millis(800);
/// A robot that is slowed down again within this long counts as slowed all the time.
const SLOWED: Duration = Duration::from_secs(2);
/// So many steps are tried before a goal is given up.
const ATTEMPTS: u32 = 4;
/// Steps that are kept until they are taken; later ones are lost.
const MOST_RECOVERIES: usize = 1000;

/// A kind of step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Step {
    /// The robot began to be slower than its path alone would let it be.
    Slow,
    /// The robot stopped.
    Stop,
    /// The path was searched anew.
    Replan,
    /// The robot began to back off.
    Back,
    /// The robot began to turn on the spot.
    Turn,
    /// The robot began a maneuver of its whole footprint, forward at first.
    Maneuver,
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

/// What a blocked robot is to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rung {
    /// Stand and see whether it goes on.
    Wait,
    /// Search the path anew.
    Replan,
    /// Search places and headings with the whole footprint.
    Maneuver,
    /// Give the goal up.
    GiveUp,
}

/// Since when the robot has been blocked, and by what.
#[derive(Debug, Clone, Copy)]
struct Blockage {
    since: SimTime,
    cause: Blocked,
}

/// How far the robot has climbed, and the steps that it took.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ladder {
    blockage: Option<Blockage>,
    /// Steps tried since the last progress.
    attempts: u32,
    /// When the planner last slowed the robot down.
    slowed: Option<SimTime>,
    recoveries: Vec<Recovery>,
}

impl Ladder {
    /// Begins at the bottom, for another goal. Steps that were not taken out yet are kept.
    pub(crate) fn reset(&mut self) {
        *self = Self {
            recoveries: std::mem::take(&mut self.recoveries),
            ..Self::default()
        };
    }

    /// The robot made progress: the next time it is blocked, all steps are tried again.
    pub(crate) fn made_progress(&mut self) {
        self.attempts = 0;
    }

    /// The robot is not blocked, or no longer.
    pub(crate) fn unblock(&mut self) {
        self.blockage = None;
    }

    /// What blocks the robot.
    pub(crate) fn cause(&self) -> Option<Blocked> {
        self.blockage.map(|blockage| blockage.cause)
    }

    /// The robot is slower than it could be.
    pub(crate) fn slow(&mut self, time: SimTime, cause: Blocked) {
        let last = self.slowed.replace(time);
        if last.is_none_or(|last| time.since(last) > SLOWED) {
            self.record(time, Step::Slow, cause);
        }
    }

    /// The robot is blocked: the next step, once the last one was given time. A moving obstacle
    /// near the robot may go away, so with one no goal is given up.
    pub(crate) fn climb(&mut self, time: SimTime, cause: Blocked, is_anybody_near: bool) -> Rung {
        if self.blockage.is_none() {
            self.record(time, Step::Stop, cause);
        }
        let since = self.blockage.map_or(time, |blockage| blockage.since);
        if time.since(since) < PATIENCE {
            self.blockage = Some(Blockage { since, cause });
            return Rung::Wait;
        }
        self.blockage = Some(Blockage { since: time, cause });
        self.attempts += 1;
        // Nobody nearby explains a missing path or an unknown pose.
        if is_anybody_near && !matches!(cause, Blocked::NoPath | Blocked::NoPose) {
            // One below the top: neither this step nor a maneuver that is not found gives the goal
            // up.
            self.attempts = self.attempts.min(ATTEMPTS - 1);
        }
        match self.attempts {
            1 => {
                self.record(time, Step::Replan, cause);
                Rung::Replan
            }
            attempts if attempts > ATTEMPTS => Rung::GiveUp,
            _ => Rung::Maneuver,
        }
    }

    /// Whether nothing is left to try.
    pub(crate) fn is_at_top(&self) -> bool {
        self.attempts >= ATTEMPTS
    }

    /// Keeps a step that was taken.
    pub(crate) fn record(&mut self, time: SimTime, step: Step, cause: Blocked) {
        if self.recoveries.len() < MOST_RECOVERIES {
            self.recoveries.push(Recovery { time, step, cause });
        }
    }

    /// The steps since this was last called, a thousand at most.
    pub(crate) fn take(&mut self) -> Vec<Recovery> {
        std::mem::take(&mut self.recoveries)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAUSE: Blocked = Blocked::NoGap;

    /// The steps of a robot that is blocked for `cycles` of 0.1 s.
    fn climbed(ladder: &mut Ladder, cycles: u32, is_anybody_near: bool) -> Vec<Rung> {
        let time = |cycle: u32| SimTime::ZERO + Duration::from_millis(100) * cycle;
        let rungs = (0..cycles).map(|cycle| ladder.climb(time(cycle), CAUSE, is_anybody_near));
        rungs.filter(|rung| *rung != Rung::Wait).collect()
    }

    #[test]
    fn a_blocked_robot_replans_maneuvers_three_times_and_gives_up() {
        let mut ladder = Ladder::default();
        let wanted = [
            Rung::Replan,
            Rung::Maneuver,
            Rung::Maneuver,
            Rung::Maneuver,
            Rung::GiveUp,
        ];
        assert_eq!(climbed(&mut ladder, 45, false), wanted);
        let steps: Vec<Step> = ladder.take().iter().map(|recovery| recovery.step).collect();
        assert_eq!(steps, [Step::Stop, Step::Replan]);
    }

    #[test]
    fn with_somebody_near_no_goal_is_given_up() {
        let rungs = climbed(&mut Ladder::default(), 200, true);
        assert!(
            rungs.len() > 20 && !rungs.contains(&Rung::GiveUp),
            "{rungs:?}"
        );
    }

    #[test]
    fn after_progress_all_steps_are_tried_again() {
        let mut ladder = Ladder::default();
        climbed(&mut ladder, 30, false);
        ladder.made_progress();
        ladder.unblock();
        assert_eq!(climbed(&mut ladder, 9, false), [Rung::Replan]);
    }
}
