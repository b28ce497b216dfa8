//! How far off the map is by now.
//!
//! The filter knows where the sensors are in the map; the map itself is made of what was seen from places that were known no better. What a scan adds to it is as far off as
//! the pose it was seen from, beside what the map round it was off already. So the map's error grows by the part of the pose's error that the new makes up in
//! all that is seen, and nothing that is seen later takes it away. The map's beginning is where the robot stands by definition.
//!
//! How the map leans is another matter: gravity tells it, slowly. So the map in view is taken to lean by an angle of its own (`State::map_tilt`), which the filter estimates, a LiDAR at R seeing the map as from exp(tilt) R; what is new is put
//! in upright, so that the next ground does not lean. Left out, being small while the angle is: that the way since the last scan is one in the leaning map. FAST-LIO2 has nothing of the kind.

use nalgebra::{Matrix2, Matrix3, Matrix6, Vector2, Vector3};

use super::inertial::Known;
use super::so3::hat;
use super::state::{Covariance, at};

/// What of a pose's covariance goes over to what is put into the map from there. The rest is of the scan alone, and averages out among the scans that fill a cube. Measured with this: the
/// normalized errors squared of heading and place on the ground over fifty drives (`benchmarks/odometry/consistency.py`) are 3.3 where 3 are right.
const LASTING: f64 = 0.5;
/// The same for how the pose leans. It is more than what averages out, since maps bend forward and down along the whole of a way: surfaces beside the ground are taken for planes
/// that are none. With ranges free of noise, and gravity told hardly anything (0.1), 414 m of `avenue` (`benchmarks/odometry`) end 19 cm
/// off, 2 cm if planes beside the ground have to be even to 3 mm. Gravity is what puts it right, the sooner the larger this is. Measured on all of `avenue`: 4 has a NEES of 6 and ends
/// 17 cm off, 0.5 and 30 have 105 and 31.
const LEANING: f64 = 4.0;

/// No more of the map is taken to lean as the pose does: a covariance in which both are one has no inverse.
const RENEWED: f64 = 0.5;
/// A map that begins where the robot is leans by no more than that against it, radians.
pub(super) const UPRIGHT: f64 = 1e-6;

/// Covariance of the error of the map round the robot.
#[derive(Debug, Clone, Default)]
pub(super) struct Drift {
    /// Rotation, then position of the robot with it, both in `odom`.
    covariance: Matrix6<f64>,
    /// Where the robot was then.
    at: Vector3<f64>,
}

impl Drift {
    /// A scan was put into the map; what was new is that share of all that was seen. Along loose directions the pose's error is one and the same from scan to scan, and does not
    /// grow by each of them.
    pub(super) fn grow(&mut self, known: &mut Known, share: f64, loose: &[Vector3<f64>]) {
        self.carry(known.state.position);
        let seen = in_odom(&known.in_map());
        lean(known, share, &seen.fixed_view::<2, 2>(0, 0).into_owned());
        self.level(known, share);
        let mut keep = Matrix6::identity();
        for direction in loose {
            let mut block = keep.fixed_view_mut::<3, 3>(3, 3);
            block -= direction * direction.transpose();
        }
        (keep[(0, 0)], keep[(1, 1)]) = (0.0, 0.0);
        self.covariance += keep * seen * keep.transpose() * (share * LASTING);
    }

    /// How the map leans does not grow without end, since gravity tells how the pose leans: what is new in the map leans as the pose does.
    fn level(&mut self, known: &Known, share: f64) {
        let left = 1.0 - share;
        for axis in 0..2 {
            let mut row = self.covariance.row_mut(axis);
            row *= left;
            let mut column = self.covariance.column_mut(axis);
            column *= left;
        }
        let mut leaning = self.covariance.fixed_view_mut::<2, 2>(0, 0);
        leaning += in_odom(known).fixed_view::<2, 2>(0, 0) * (1.0 - left * left);
    }

    /// A position that was not known along these directions is known in the map again, better by that: the map of meanwhile is as far off as it was before.
    pub(super) fn keep(&mut self, before: &Known, after: &Known, loose: &[Vector3<f64>]) {
        self.carry(after.state.position);
        for direction in loose {
            let variance = |known: &Known| {
                direction.dot(
                    &(known
                        .covariance
                        .fixed_view::<3, 3>(at::POSITION, at::POSITION)
                        * direction),
                )
            };
            let mut block = self.covariance.fixed_view_mut::<3, 3>(3, 3);
            block +=
                direction * direction.transpose() * (variance(before) - variance(after)).max(0.0);
        }
    }

    /// Nobody knows any more how far everything has gone, but for these deviations, radians and metres.
    pub(super) fn lose(&mut self, known: &mut Known, turned: f64, far: f64) {
        self.carry(known.state.position);
        upright(known);
        for i in 0..6 {
            let deviation = if i < 3 { turned } else { far };
            self.covariance[(i, i)] += deviation * deviation;
        }
    }

    /// A map that is turned is the farther off the farther the robot goes in it.
    fn carry(&mut self, to: Vector3<f64>) {
        let mut lever = Matrix6::identity();
        lever
            .fixed_view_mut::<3, 3>(3, 0)
            .copy_from(&-hat(to - self.at));
        self.covariance = lever * self.covariance * lever.transpose();
        self.at = to;
    }

    /// Covariance of a pose, the map's error included: rotation in the IMU's frame, position in `odom`.
    pub(super) fn told(&self, known: &Known) -> Matrix6<f64> {
        let mut here = self.clone();
        here.carry(known.state.position);
        let mut back = turning(
            &known
                .state
                .rotation
                .to_rotation_matrix()
                .into_inner()
                .transpose(),
        );
        // How far the pose leans, it knows itself.
        back.fixed_columns_mut::<2>(0).fill(0.0);
        known.covariance.fixed_view::<6, 6>(0, 0) + back * here.covariance * back.transpose()
    }
}

/// The map begins anew where the robot is.
pub(super) fn upright(known: &mut Known) {
    known.state.map_tilt = Vector2::zeros();
    known.covariance.fixed_rows_mut::<2>(at::MAP_TILT).fill(0.0);
    known
        .covariance
        .fixed_columns_mut::<2>(at::MAP_TILT)
        .fill(0.0);
    (at::MAP_TILT..at::MAP_TILT + 2).for_each(|i| known.covariance[(i, i)] = UPRIGHT * UPRIGHT);
}

/// New ground was put into the map as the pose leans, so that the map leans less than it did and more as the pose is wrong; `seen` is the covariance of how the pose
/// leans against the map.
fn lean(known: &mut Known, share: f64, seen: &Matrix2<f64>) {
    let share = share.min(RENEWED);
    known.state.map_tilt *= 1.0 - share;
    let rotation = known.state.rotation.to_rotation_matrix();
    let mut step = Covariance::identity();
    let mut tilt = step.fixed_view_mut::<2, 3>(at::MAP_TILT, at::ROTATION);
    tilt -= rotation.matrix().fixed_rows::<2>(0) * share;
    let mut tilt = step.fixed_view_mut::<2, 2>(at::MAP_TILT, at::MAP_TILT);
    tilt *= 1.0 - share;
    known.covariance = step * known.covariance * step.transpose();
    let mut tilt = known
        .covariance
        .fixed_view_mut::<2, 2>(at::MAP_TILT, at::MAP_TILT);
    tilt += seen * (share * LEANING);
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
            map_tilt: Vector2::zeros(),
        };
        Known {
            stamp: SimTime::ZERO,
            state,
            covariance: Covariance::identity() * 1e-6,
        }
    }

    #[test]
    fn it_grows_with_what_is_new_and_a_turned_map_leads_off_sideways() {
        let mut drift = Drift::default();
        assert!((drift.told(&known(0.0)) - Matrix6::identity() * 1e-6).norm() < 1e-12);
        drift.grow(&mut known(0.0), 0.0, &[]);
        assert!((drift.told(&known(9.0))[(4, 4)] - 1e-6).abs() < 1e-12);
        drift.grow(&mut known(0.0), 0.5 / LASTING, &[]);
        let far = drift.told(&known(10.0));
        // Along the way: the pose and half of it once more. Across it ten metres times half a milliradian squared as well.
        assert!((far[(3, 3)] - 1.5e-6).abs() < 1e-9);
        assert!(
            (far[(4, 4)] - (1.5e-6 + 100.0 * 0.5e-6)).abs() < 1e-9,
            "{far}"
        );
        assert!((far[(2, 2)] - 1.5e-6).abs() < 1e-9);
    }

    #[test]
    fn what_was_not_known_along_a_corridor_stays_unknown_behind_it() {
        let (mut drift, along) = (Drift::default(), [Vector3::x()]);
        let (mut before, after) = (known(0.0), known(0.0));
        before.covariance[(3, 3)] = 4.0;
        (0..100).for_each(|_| drift.grow(&mut before, 0.1, &along));
        assert!(
            (drift.told(&before)[(3, 3)] - 4.0).abs() < 1e-6,
            "told once"
        );
        drift.keep(&before, &after, &along);
        let told = drift.told(&after);
        assert!(
            (told[(3, 3)] - 4.0).abs() < 1e-6 && told[(4, 4)] < 1e-4,
            "{told}"
        );
    }
}
