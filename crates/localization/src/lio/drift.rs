//! How far off the map is by now.
//!
//! The filter knows where the sensors are in the map; the map itself is made of what was seen from places that were known no better. What a scan adds to it is as far off as
//! the pose it was seen from, beside what the map round it was off already. So the map's error grows by the part of the pose's error that the new makes up in
//! all that is seen, and nothing that is seen later takes it away. The map's beginning is where the robot stands by definition.

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::inertial::Known;
use super::so3::hat;

/// What of a pose's covariance goes over to what is put into the map from there. The rest is of the scan alone, and averages out among the scans that fill a cube. Measured: with 1 the
/// normalized errors squared of fifty drives (`benchmarks/odometry/consistency.py`) were 2.8 where 6 were right.
const LASTING: f64 = 0.5;

/// Covariance of the error of the map round the robot.
#[derive(Debug, Clone, Default)]
pub(super) struct Drift {
    /// Rotation, then position of the robot with it, both in `odom`.
    covariance: Matrix6<f64>,
    /// Where the robot was then.
    at: Vector3<f64>,
}

impl Drift {
    /// A scan was put into the map; what was new is that share of all that was seen.
    pub(super) fn grow(&mut self, known: &Known, share: f64) {
        self.carry(known.state.position);
        self.covariance += in_odom(known) * (share * LASTING);
    }

    /// A map that is turned is the farther off the farther the robot goes in it.
    fn carry(&mut self, to: Vector3<f64>) {
        let mut lever = Matrix6::identity();
        lever.fixed_view_mut::<3, 3>(3, 0).copy_from(&-hat(to - self.at));
        self.covariance = lever * self.covariance * lever.transpose();
        self.at = to;
    }

    /// Covariance of a pose, the map's error included: rotation in the IMU's frame, position in `odom`.
    pub(super) fn told(&self, known: &Known) -> Matrix6<f64> {
        let mut here = self.clone();
        here.carry(known.state.position);
        let back = turning(&known.state.rotation.to_rotation_matrix().into_inner().transpose());
        known.covariance.fixed_view::<6, 6>(0, 0) + back * here.covariance * back.transpose()
    }
}

/// A pose's covariance with its rotation in `odom`.
fn in_odom(known: &Known) -> Matrix6<f64> {
    let turn = turning(&known.state.rotation.to_rotation_matrix().into_inner());
    turn * known.covariance.fixed_view::<6, 6>(0, 0) * turn.transpose()
}

/// Turns rotations, leaves positions.
fn turning(rotation: &Matrix3<f64>) -> Matrix6<f64> {
    let mut turn = Matrix6::identity();
    turn.fixed_view_mut::<3, 3>(0, 0).copy_from(rotation);
    turn
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lio::so3::exp;
    use crate::lio::state::{Covariance, State};
    use openbench_core::SimTime;

    fn known(x: f64) -> Known {
        let state = State {
            rotation: exp(Vector3::z() * 1.2),
            position: Vector3::new(x, 0.0, 0.0),
            velocity: Vector3::zeros(),
            gyro_bias: Vector3::zeros(),
            accel_bias: Vector3::zeros(),
            gravity: Vector3::z() * -9.8,
            mount_rotation: exp(Vector3::zeros()),
            mount_position: Vector3::zeros(),
        };
        Known { stamp: SimTime::ZERO, state, covariance: Covariance::identity() * 1e-6 }
    }

    #[test]
    fn it_grows_with_what_is_new_and_a_turned_map_leads_off_sideways() {
        let mut drift = Drift::default();
        assert!((drift.told(&known(0.0)) - Matrix6::identity() * 1e-6).norm() < 1e-12);
        drift.grow(&known(0.0), 0.0);
        assert!((drift.told(&known(9.0))[(4, 4)] - 1e-6).abs() < 1e-12);
        drift.grow(&known(0.0), 0.5 / LASTING);
        let far = drift.told(&known(10.0));
        // Along the way: the pose and half of it once more. Across it ten metres times half a milliradian squared as well.
        assert!((far[(3, 3)] - 1.5e-6).abs() < 1e-9);
        assert!((far[(4, 4)] - (1.5e-6 + 100.0 * 0.5e-6)).abs() < 1e-9, "{far}");
        assert!((far[(2, 2)] - 1.5e-6).abs() < 1e-9);
    }
}
