//! Sensors that a suite adds to the robot.

use openbench_core::RobotDescription;
use serde::{Deserialize, Serialize};

/// What the robot has besides the benchmark's own sensors: nothing, unless a suite says so. Results of a suite that does are not to be
/// compared with others'.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sensors {
    /// A satellite receiver.
    pub gnss: bool,
}

impl Sensors {
    /// The robot with these sensors.
    pub fn robot(self) -> RobotDescription {
        let robot = RobotDescription::sentry();
        if self.gnss { robot.with_gnss() } else { robot }
    }

    pub(super) fn none(&self) -> bool {
        *self == Self::default()
    }
}
