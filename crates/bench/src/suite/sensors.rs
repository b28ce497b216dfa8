//! Sensors added to the robot by a suite.

use openbench_core::RobotDescription;
use serde::{Deserialize, Serialize};

/// Sensors in addition to the benchmark's own; none by default. Results with additional sensors are
/// not comparable with others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sensors {
    /// A GNSS receiver.
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
