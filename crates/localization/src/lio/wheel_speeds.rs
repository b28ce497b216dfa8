//! Velocities from the wheels that are still needed.

use std::collections::VecDeque;
use std::time::Duration;

use openbench_core::SimTime;

use super::speed::Speed;

/// At most this many velocities wait for the IMU.
const MAX_WAITING: usize = 1000;
/// A velocity is valid this long before and after its stamp.
pub(super) const VALIDITY: Duration = Duration::from_millis(300);
/// Wheels are steady while their velocity changes by less than this, m/s,
const STEADY_SPEED_M_S: f64 = 0.1;
/// and their turn rate by less than this, rad/s.
const STEADY_TURN_RAD_S: f64 = 0.3;

/// Velocities in the order of their stamps.
#[derive(Debug, Clone, Default)]
pub(super) struct WheelSpeeds(VecDeque<Speed>);

impl WheelSpeeds {
    /// Takes in a velocity, if it can be used.
    pub(super) fn push(&mut self, speed: Speed) -> bool {
        let is_late = self.0.back().is_some_and(|last| speed.stamp <= last.stamp);
        let is_usable = speed.is_sound() && !is_late && self.0.len() < MAX_WAITING;
        if is_usable {
            self.0.push_back(speed);
        }
        is_usable
    }

    /// All of them.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Speed> {
        self.0.iter()
    }

    /// Those after an instant.
    pub(super) fn after(&self, stamp: SimTime) -> impl Iterator<Item = &Speed> {
        self.0.iter().skip_while(move |speed| speed.stamp <= stamp)
    }

    /// The velocity that is valid at an instant: the last one before it, or else the first.
    pub(super) fn at(&self, stamp: SimTime) -> Option<&Speed> {
        let before = self.0.partition_point(|speed| speed.stamp <= stamp);
        let speed = self.0.get(before.saturating_sub(1))?;
        // `since` is zero where the other stamp is later, so one of the two decides.
        let is_valid = stamp.since(speed.stamp) <= VALIDITY && speed.stamp.since(stamp) <= VALIDITY;
        is_valid.then_some(speed)
    }

    /// Whether the velocity after this one is nearly the same.
    pub(super) fn is_steady_after(&self, speed: &Speed) -> bool {
        let after = self.0.partition_point(|other| other.stamp <= speed.stamp);
        // As long as the next velocity has not come, the wheels do not count as steady.
        self.0.get(after).is_some_and(|next| {
            (next.velocity - speed.velocity).norm() < STEADY_SPEED_M_S
                && (next.turn - speed.turn).abs() < STEADY_TURN_RAD_S
        })
    }

    /// Drops what is older than an instant, except for the last one, which is still valid.
    pub(super) fn forget(&mut self, until: SimTime) {
        while self.0.get(1).is_some_and(|speed| speed.stamp <= until) {
            self.0.pop_front();
        }
    }

    /// Drops all.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}
