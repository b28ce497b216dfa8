//! The part of a turn that a gyroscope at its limit does not measure.
//!
//! A saturated gyroscope shows its limit, however fast the robot turns. The prediction turns too
//! little then, and the scan shows by how much.

use nalgebra::{UnitQuaternion, Vector3};

use super::belief::Belief;
use super::inertial::GyroSaturation;
use super::state::at;
use crate::so3::log;

/// Standard deviation of the turn rate that remains unknown, rad/s.
const DEVIATION_RAD_S: f64 = 0.05;
/// A rotation by less than this needs no further correction, radians.
const CONVERGED_RAD: f64 = 1e-3;

/// Turn rate that the gyroscope did not show in the last scan.
#[derive(Debug, Clone, Default)]
pub(super) struct UnmeasuredTurn {
    /// In the IMU's frame, rad/s.
    rate: Vector3<f64>,
}

impl UnmeasuredTurn {
    pub(super) fn rate(&self) -> &Vector3<f64> {
        &self.rate
    }

    /// Adds what a rotation of the IMU by a scan shows; `None` if the scan showed nothing. Says
    /// whether the prediction should be repeated with the new rate.
    pub(super) fn refine(
        &mut self,
        saturation: &GyroSaturation,
        correction: Option<UnitQuaternion<f64>>,
    ) -> bool {
        if saturation.duration.is_zero() {
            self.rate = Vector3::zeros();
            return false;
        }
        let Some(correction) = correction else {
            return false;
        };
        let turn = log(correction);
        if turn.norm() < CONVERGED_RAD {
            return false;
        }
        let rate = turn / saturation.duration.as_secs_f64();
        // About the other axes the gyroscope has measured the turn.
        for axis in (0..3).filter(|axis| saturation.axes[*axis]) {
            self.rate[axis] += rate[axis];
        }
        true
    }
}

/// Adds the uncertainty of the unmeasured turn to a belief's rotation.
pub(super) fn add_uncertainty(belief: &mut Belief, saturation: &GyroSaturation) {
    let deviation = DEVIATION_RAD_S * saturation.duration.as_secs_f64();
    for axis in (0..3).filter(|axis| saturation.axes[*axis]) {
        let i = at::ROTATION + axis;
        belief.covariance[(i, i)] += deviation * deviation;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// About z for a tenth of a second.
    const SATURATION: GyroSaturation = GyroSaturation {
        duration: Duration::from_millis(100),
        axes: [false, false, true],
    };

    fn rotation(x: f64, z: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(Vector3::new(x, 0.0, z))
    }

    #[test]
    fn a_scan_shows_the_unmeasured_rate_of_saturated_axes() {
        let mut unmeasured = UnmeasuredTurn::default();
        assert!(unmeasured.refine(&SATURATION, Some(rotation(0.01, 0.02))));
        assert!((unmeasured.rate() - Vector3::z() * 0.2).norm() < 1e-9);
        assert!(
            !unmeasured.refine(&SATURATION, Some(rotation(0.0, 1e-4))),
            "converged"
        );
        assert!(
            !unmeasured.refine(&SATURATION, None),
            "the scan showed nothing"
        );
        assert!(
            (unmeasured.rate() - Vector3::z() * 0.2).norm() < 1e-9,
            "kept for the next scan"
        );
        assert!(!unmeasured.refine(&GyroSaturation::default(), None));
        assert_eq!(
            *unmeasured.rate(),
            Vector3::zeros(),
            "a gyroscope that measures all again"
        );
    }
}
