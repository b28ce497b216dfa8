//! Whether computing takes simulated time.

use serde::{Deserialize, Serialize};

use super::level::{Condition, check_ranges};

/// Whether computing takes simulated time.
///
/// ```
/// use openbench_bench::suite::{Compute, Condition};
///
/// assert_eq!(Compute::default().slowness, 0.0);
/// assert_eq!(Compute::LEVELS[1], ("charged", Compute { slowness: 1.0, ..Compute::default() }));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Compute {
    /// Factor on the costs of the reference computer: 0 for free, 1 for that computer, 2 for one
    /// that is half as fast.
    pub slowness: f64,
    /// How long the robot drives on with its last command while no new one comes, seconds.
    pub hold_s: f64,
}

impl Compute {
    const FREE: Self = Self {
        slowness: 0.0,
        // As the differential drive controller of ros2_control does by default.
        hold_s: 0.5,
    };
}

impl Default for Compute {
    fn default() -> Self {
        Self::FREE
    }
}

impl Condition for Compute {
    const KEY: &'static str = "compute";
    const LEVELS: &'static [(&'static str, Self)] = &[
        ("free", Self::FREE),
        (
            "charged",
            Self {
                slowness: 1.0,
                ..Self::FREE
            },
        ),
    ];

    fn check(&self) -> Result<(), String> {
        check_ranges(&[
            ("slowness", self.slowness, 1000.0),
            ("hold_s", self.hold_s, 60.0),
        ])
    }

    fn is_off(&self) -> bool {
        // Without costs every decision comes in time.
        self.slowness == 0.0
    }
}
