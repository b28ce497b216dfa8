//! What to do about a pose that is not to be trusted.

use std::time::Duration;

use openbench_core::{Doubt, Health, RobotDescription, SimTime, Velocity};

/// A robot that does not trust its pose drives and turns at no more than this part of what it can.
const SLOWER: f64 = 0.5;
/// A robot that does not know where it is stands for so long in case it finds out, then gives up.
const PATIENCE: Duration = Duration::from_secs(15);
/// After contradictions that lasted so long, what was seen meanwhile may be drawn anywhere.
const MISLED: Duration = Duration::from_secs(1);

/// What to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measure {
    /// Drive as usual.
    GoOn,
    /// Drive slowly.
    Slow,
    /// Stand.
    Stand,
    /// Give up: nobody knows where the robot is.
    GiveUp,
}

/// Remembers how it has gone.
#[derive(Debug, Clone, Copy, Default)]
pub struct Caution {
    health: Health,
    /// Since when the pose is doubted for the same reason.
    since: SimTime,
    /// Whether what was seen meanwhile is to be forgotten.
    misled: bool,
}

impl Caution {
    /// Takes in how far the pose is to be trusted now.
    pub fn look(&mut self, health: Health, now: SimTime) -> Measure {
        if self.health != health {
            (self.health, self.since) = (health, now);
        }
        let lasted = now.since(self.since);
        match health {
            Health::Good => Measure::GoOn,
            Health::Degraded(doubt) => {
                // Without features the pose only drifts, as it does among noise.
                self.misled |= doubt == Doubt::Contradiction && lasted >= MISLED;
                Measure::Slow
            }
            Health::Lost => {
                self.misled = true;
                if lasted < PATIENCE {
                    Measure::Stand
                } else {
                    Measure::GiveUp
                }
            }
        }
    }

    /// Whether the pose is trusted again, and what was seen before is to be forgotten; once each
    /// time.
    pub fn is_over(&mut self) -> bool {
        self.health == Health::Good && std::mem::take(&mut self.misled)
    }

    /// A velocity as it is driven while the pose is doubted: along the same arc, no faster than a
    /// part of what `robot` can. A part of the velocity itself would be halved again and again,
    /// since the next one is planned from what the robot has come to, and leave it creeping.
    pub fn slowed(velocity: Velocity, robot: &RobotDescription) -> Velocity {
        let part = |now: f64, most: f64| (SLOWER * most / now.abs()).min(1.0);
        let part =
            part(velocity.linear, robot.max_forward).min(part(velocity.angular, robot.max_turn));
        Velocity::new(velocity.linear * part, velocity.angular * part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_is_lost_stands_and_then_gives_up() {
        let mut caution = Caution::default();
        let at = SimTime::from_millis;
        assert_eq!(caution.look(Health::Good, at(0)), Measure::GoOn);
        assert_eq!(caution.look(Health::Lost, at(1000)), Measure::Stand);
        assert_eq!(caution.look(Health::Lost, at(15_900)), Measure::Stand);
        assert_eq!(caution.look(Health::Lost, at(16_000)), Measure::GiveUp);
    }

    #[test]
    fn what_was_seen_in_doubt_is_forgotten_once_it_is_over() {
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
    fn who_doubts_drives_at_half_speed_along_the_same_arc_and_does_not_come_to_creep() {
        let robot = RobotDescription::sentry();
        let half = SLOWER * robot.max_forward;
        // As a driver does that speeds up from what it has come to.
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
            (turn.angular + SLOWER * robot.max_turn).abs() < 1e-9,
            "{turn:?}"
        );
        assert_eq!(Caution::slowed(Velocity::ZERO, &robot), Velocity::ZERO);
    }
}
