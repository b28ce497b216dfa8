//! The satellite receiver: off unless the robot's description has one.

use nalgebra::Vector3;
use openbench_core::{GnssFix, Pose3, SimTime};
use openbench_scene::RayCaster;

use crate::noise::Noise;

/// Time between two fixes, nanoseconds: 5 Hz.
pub const FIX_NS: u64 = 200_000_000;
/// Deviation of a fix under an open sky, metres: east, north, up.
const DEVIATION: [f64; 3] = [1.5, 1.5, 3.0];

/// A receiver under an open sky.
#[derive(Debug)]
pub struct Gnss {
    noise: Noise,
    antenna: Pose3,
}

impl Gnss {
    /// A receiver whose antenna stands at `antenna` in `base_link`.
    pub fn new(noise: Noise, antenna: Pose3) -> Self {
        Self { noise, antenna }
    }

    /// The fix at `stamp`, or `None` without enough satellites.
    pub fn fix(&mut self, _caster: &RayCaster, stamp: SimTime, base_link: &Pose3) -> Option<GnssFix> {
        let truth = (base_link * self.antenna).translation.vector;
        let error = Vector3::from(DEVIATION.map(|d| d * self.noise.normal()));
        let covariance = nalgebra::Matrix3::from_diagonal(&Vector3::from(DEVIATION.map(|d| d * d)));
        Some(GnssFix {
            stamp,
            position: (truth + error).into(),
            covariance: covariance.into(),
            satellites: 10,
        })
    }
}
