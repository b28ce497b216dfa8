//! What a robot with two driven sides can do.

use openbench_core::RobotDescription;

use crate::checks::{SettingsError, not_negative, positive};

/// What a robot with two driven sides can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Largest forward speed, m/s.
    pub forward: f64,
    /// Largest backward speed, m/s; zero for a robot that never backs.
    pub backward: f64,
    /// Largest turn rate, rad/s.
    pub turn: f64,
    /// Largest acceleration of the wheels' rims, m/s².
    pub acceleration: f64,
    /// Half of the effective track: a turn rate times this is the rims' speed in turning, metres.
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

    /// Whether a robot could have these.
    pub fn check(&self) -> Result<(), SettingsError> {
        positive("the largest forward speed", self.forward)?;
        positive("the largest turn rate", self.turn)?;
        positive("the largest acceleration", self.acceleration)?;
        positive("half of the track", self.half_track)?;
        not_negative("the largest backward speed", self.backward)
    }
}
