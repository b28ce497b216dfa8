//! What to do about a pose that is not to be trusted.

use std::time::Duration;

use openbench_core::{Doubt, Health, SimTime, Velocity};

/// A robot that does not trust its pose drives at this part of its speed.
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
                if lasted < PATIENCE { Measure::Stand } else { Measure::GiveUp }
            }
        }
    }

    /// Whether the pose is trusted again, and what was seen before is to be forgotten; once each
    /// time.
    pub fn is_over(&mut self) -> bool {
        self.health == Health::Good && std::mem::take(&mut self.misled)
    }

    /// A velocity as it is driven while the pose is doubted.
    pub fn slowed(velocity: Velocity) -> Velocity {
        Velocity::new(velocity.linear * SLOWER, velocity.angular * SLOWER)
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
}
