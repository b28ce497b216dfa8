//! What is wrong with the LiDAR's returns.

use openbench_sim::lidar::BeamErrors;

use super::level::{Condition, check_ranges};

impl Condition for BeamErrors {
    const KEY: &'static str = "lidar";
    const LEVELS: &'static [(&'static str, Self)] = &[
        (
            "ideal",
            Self {
                beam_mrad: 0.0,
                glass: 0.0,
                ghosts: 0.0,
            },
        ),
        (
            "real",
            Self {
                beam_mrad: 3.0,
                glass: 0.9,
                ghosts: 0.1,
            },
        ),
    ];

    fn check(&self) -> Result<(), String> {
        check_ranges(&[
            ("beam_mrad", self.beam_mrad, 20.0),
            ("glass", self.glass, 1.0),
            ("ghosts", self.ghosts, 1.0),
        ])?;
        if self.ghosts > 0.0 && self.glass == 0.0 {
            return Err("ghosts are a share of what glass takes; set glass too".to_owned());
        }
        Ok(())
    }
}
