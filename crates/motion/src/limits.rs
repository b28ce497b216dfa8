//! Limits of speed and acceleration of a differential drive.

use openbench_core::RobotDescription;

use crate::checks::{SettingsError, not_negative, positive};

/// Limits of speed and acceleration of a differential drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Largest forward speed, m/s.
    pub forward: f64,
    /// Largest backward speed, m/s; zero for a robot that never drives backward.
    pub backward: f64,
    /// Largest turn rate, rad/s.
    pub turn: f64,
    /// Largest acceleration of the wheels' rims on the ground, m/s².
    pub acceleration: f64,
    /// Half of the effective track, metres: the rims' speed in turning is the turn rate times this.
    pub half_track: f64,
}

impl Limits {
    /// The limits of a robot.
    pub fn of(robot: &RobotDescription) -> Result<Self, SettingsError> {
        let limits = Self {
            forward: robot.max_forward,
            backward: robot.max_backward,
            turn: robot.max_turn,
            acceleration: robot.max_acceleration,
            half_track: robot.effective_track / 2.0,
        };
        limits.check().map(|()| limits)
    }

    /// Whether all limits are positive, or zero for driving backward.
    pub fn check(&self) -> Result<(), SettingsError> {
        positive("the largest forward speed", self.forward)?;
        positive("the largest turn rate", self.turn)?;
        positive("the largest acceleration", self.acceleration)?;
        positive("half of the track", self.half_track)?;
        not_negative("the largest backward speed", self.backward)
    }
}
