//! What the robot does when its pose estimate cannot be trusted.

use std::time::Duration;

use openbench_core::{Doubt, Health, RobotDescription, SimTime, Velocity};

/// Share of the robot's limits at which it drives and turns while its pose is in doubt.
const SLOW_SHARE: f64 = 0.5;
/// How long a lost robot stands, in case the localizer recovers, before it gives up.
const LOST_TIMEOUT: Duration = Duration::from_secs(15);
/// After contradictions of this duration, obstacles seen meanwhile may be misplaced.
const MISLEADING_TIME: Duration = Duration::from_secs(1);

/// What to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measure {
    /// Drive as usual.
    GoOn,
    /// Drive slowly.
    Slow,
    /// Stand still.
    Stand,
    /// Give up: the robot is lost.
    GiveUp,
}

/// Follows the health of the localizer.
#[derive(Debug, Clone, Copy, Default)]
pub struct Caution {
    health: Health,
    /// Since when the health is the same.
    since: SimTime,
    /// Whether obstacles seen in doubt must be forgotten.
    misled: bool,
}

impl Caution {
    /// Takes the localizer's health and returns the measure to take.
    pub fn look(&mut self, health: Health, now: SimTime) -> Measure {
        if self.health != health {
            (self.health, self.since) = (health, now);
        }
        let lasted = now.since(self.since);
        match health {
            Health::Good => Measure::GoOn,
            Health::Degraded(doubt) => {
                // In other kinds of doubt the pose drifts slowly, so obstacles stay about right.
                self.misled |= doubt == Doubt::Contradiction && lasted >= MISLEADING_TIME;
                Measure::Slow
            }
            Health::Lost => {
                self.misled = true;
                if lasted < LOST_TIMEOUT {
                    Measure::Stand
                } else {
                    Measure::GiveUp
                }
            }
        }
    }

    /// Whether the pose is trusted again and obstacles seen in doubt must be forgotten. True once
    /// each time.
    pub fn is_over(&mut self) -> bool {
        self.health == Health::Good && std::mem::take(&mut self.misled)
    }

    /// A velocity limited for driving in doubt: the same arc, within a share of the robot's limits.
    ///
    /// Halving the planned velocity instead would halve it again and again, since the planner
    /// starts from the current velocity, until the robot creeps.
    pub fn slowed(velocity: Velocity, robot: &RobotDescription) -> Velocity {
        // A velocity of zero gives infinity here, and so a share of 1.
        let part = |now: f64, most: f64| (SLOW_SHARE * most / now.abs()).min(1.0);
        let part =
            part(velocity.linear, robot.max_forward).min(part(velocity.angular, robot.max_turn));
        Velocity::new(velocity.linear * part, velocity.angular * part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_robot_stands_and_then_gives_up() {
        let mut caution = Caution::default();
        let at = SimTime::from_millis;
        assert_eq!(caution.look(Health::Good, at(0)), Measure::GoOn);
        assert_eq!(caution.look(Health::Lost, at(1000)), Measure::Stand);
        assert_eq!(caution.look(Health::Lost, at(15_900)), Measure::Stand);
        assert_eq!(caution.look(Health::Lost, at(16_000)), Measure::GiveUp);
    }

    #[test]
    fn obstacles_seen_in_doubt_are_forgotten_once_when_it_is_over() {
        let mut caution = Caution::default();
        let at = SimTime::from_millis;
        let doubt = Health::Degraded(Doubt::Contradiction);
        assert_eq!(caution.look(doubt, at(100)), Measure::Slow);
        assert_eq!(caution.look(Health::Good, at(200)), Measure::GoOn);
        assert!(!caution.is_over(), "too short to have misled");
        caution.look(doubt, at(300));
        caution.look(doubt, at(1500));
        assert!(!caution.is_over(), "not yet over");
        caution.look(Health::Good, at(1600));
        assert!(caution.is_over() && !caution.is_over());
    }

    #[test]
    fn in_doubt_the_robot_drives_the_same_arc_at_half_speed_and_does_not_creep() {
        let robot = RobotDescription::sentry();
        let half = SLOW_SHARE * robot.max_forward;
        // Like a planner that accelerates from the current velocity.
        let (mut speed, faster) = (0.0, 0.05);
        for _ in 0..100 {
            let wanted = f64::min(speed + faster, robot.max_forward);
            speed = Caution::slowed(Velocity::new(wanted, 0.0), &robot).linear;
        }
        assert!((speed - half).abs() < 1e-9, "{speed}");
        let arc = Caution::slowed(Velocity::new(robot.max_forward, 0.3), &robot);
        assert!(
            (arc.linear - half).abs() < 1e-9 && (arc.angular - 0.15).abs() < 1e-9,
            "{arc:?}"
        );
        let turn = Caution::slowed(Velocity::new(0.0, -robot.max_turn), &robot);
        assert!(
            (turn.angular + SLOW_SHARE * robot.max_turn).abs() < 1e-9,
            "{turn:?}"
        );
        assert_eq!(Caution::slowed(Velocity::ZERO, &robot), Velocity::ZERO);
    }
}
