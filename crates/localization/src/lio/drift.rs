//! How far off the map is by now.
//!
//! The filter knows where the sensors are in the map. The map itself is made of what was seen from
//! poses that were known no better. What a scan adds to it is as far off as the pose it was seen
//! from, beside what the map round it was off already. So the map's error grows by the share of the
//! pose's error that the new part has in all that is seen. Nothing that is seen later reduces it.
//! The map's origin is where the robot stands at the start, by definition.
//!
//! The map's tilt is another matter: gravity shows it, slowly. The map in view is assumed to be
//! tilted by an angle of its own (`State::map_tilt`), which the filter estimates: a LiDAR at R sees
//! the map as from exp(tilt) R. What is new is put in upright, so that the next ground is not
//! tilted. One effect is neglected, being small while the angle is: the motion since the last scan
//! is one in the tilted map. FAST-LIO2 has nothing of the kind.

use nalgebra::{Matrix2, Matrix3, Matrix6, Vector2, Vector3};

use super::belief::Belief;
use super::state::{Covariance, at};
use crate::deviation::PoseDeviation;
use crate::so3::hat;

/// Share of a pose's covariance that goes over to what is put into the map from there.
///
/// The rest is of the scan alone, and averages out among the scans that fill a cube. Measured with
/// this share: the normalized squared errors of heading and position on the ground over fifty
/// drives (`benchmarks/odometry/consistency.py`) are 3.3 where 3 are right.
const LASTING: f64 = 0.5;
/// The same for the pose's tilt.
///
/// It is more than what averages out, since maps bend forward and down along the whole trajectory:
/// uneven surfaces beside the ground are taken for planes. With ranges free of noise, and hardly
/// any correction by gravity (0.1), 414 m of `avenue` (`benchmarks/odometry`) end 19 cm off, 2 cm
/// if planes beside the ground have to be even to 3 mm. Gravity corrects the tilt, the sooner the
/// larger this is. Measured on all of `avenue`: 4 has a NEES of 6 and ends 17 cm off, 0.5 and 30
/// have 105 and 31.
const LASTING_TILT: f64 = 4.0;
/// No larger share of the map is assumed to be tilted as the pose is: a covariance in which both
/// are one has no inverse.
const MAX_RENEWED: f64 = 0.5;
/// A map that begins where the robot is is tilted against it by no more than this, radians.
pub(super) const UPRIGHT_RAD: f64 = 1e-6;

/// Covariance of the error of the map round the robot.
#[derive(Debug, Clone, Default)]
pub(super) struct Drift {
    /// Rotation, then position of the robot with it, both in `odom`.
    covariance: Matrix6<f64>,
    /// Where the robot was then.
    position: Vector3<f64>,
}

impl Drift {
    /// A scan was put into the map; `share` is the share of the new in all that was seen. Along
    /// degenerate directions the pose's error is the same from scan to scan, and is not added
    /// again.
    pub(super) fn grow(&mut self, belief: &mut Belief, share: f64, degenerate: &[Vector3<f64>]) {
        self.carry(belief.state.position);
        // Before the tilt is renewed: the scan was matched to the map as it was tilted until now.
        let seen = in_odom(&belief.in_map());
        renew_tilt(belief, share, &seen.fixed_view::<2, 2>(0, 0).into_owned());
        self.renew_roll_and_pitch(belief, share);
        let mut keep = Matrix6::identity();
        for direction in degenerate {
            let mut block = keep.fixed_view_mut::<3, 3>(3, 3);
            block -= direction * direction.transpose();
        }
        // Roll and pitch do not add up: they were renewed above.
        keep[(0, 0)] = 0.0;
        keep[(1, 1)] = 0.0;
        self.covariance += keep * seen * keep.transpose() * (share * LASTING);
    }

    /// Gravity shows the pose's tilt, and what is new in the map is tilted as the pose is. The
    /// map's tilt therefore does not grow without bound.
    fn renew_roll_and_pitch(&mut self, belief: &Belief, share: f64) {
        // Rows and columns shrink, so variances shrink by the square. What is added makes the sum a
        // mean of the old tilt and the pose's.
        let kept = 1.0 - share;
        for axis in 0..2 {
            let mut row = self.covariance.row_mut(axis);
            row *= kept;
            let mut column = self.covariance.column_mut(axis);
            column *= kept;
        }
        let mut tilt = self.covariance.fixed_view_mut::<2, 2>(0, 0);
        tilt += in_odom(belief).fixed_view::<2, 2>(0, 0) * (1.0 - kept * kept);
    }

    /// A position that was unknown along some directions is known in the map again. The part of
    /// the map that was seen meanwhile is as far off as the position was before.
    pub(super) fn keep(&mut self, before: &Belief, after: &Belief, unknown: &[Vector3<f64>]) {
        self.carry(after.state.position);
        for direction in unknown {
            let gained = position_variance(before, direction) - position_variance(after, direction);
            let mut block = self.covariance.fixed_view_mut::<3, 3>(3, 3);
            block += direction * direction.transpose() * gained.max(0.0);
        }
    }

    /// A new map begins where the robot is. Where that is is known to this deviation.
    pub(super) fn lose(&mut self, belief: &mut Belief, deviation: PoseDeviation) {
        self.carry(belief.state.position);
        set_map_upright(belief);
        for i in 0..6 {
            let deviation = if i < 3 {
                deviation.radians
            } else {
                deviation.metres
            };
            self.covariance[(i, i)] += deviation * deviation;
        }
    }

    /// Moves on with the robot: a rotated map is the farther off the farther the robot is from
    /// where it was.
    fn carry(&mut self, position: Vector3<f64>) {
        let mut lever = Matrix6::identity();
        lever
            .fixed_view_mut::<3, 3>(3, 0)
            // A rotation θ displaces the robot by θ × d = -d × θ, with the lever d.
            .copy_from(&-hat(position - self.position));
        self.covariance = lever * self.covariance * lever.transpose();
        self.position = position;
    }

    /// Covariance of a belief's pose, the map's error included: rotation in the IMU's frame,
    /// position in `odom`.
    pub(super) fn pose_covariance(&self, belief: &Belief) -> Matrix6<f64> {
        let mut here = self.clone();
        here.carry(belief.state.position);
        let rotation = belief.state.rotation.to_rotation_matrix().into_inner();
        let mut into_imu = rotating(&rotation.transpose());
        // The belief's own tilt is known from gravity.
        into_imu.fixed_columns_mut::<2>(0).fill(0.0);
        let pose = belief.covariance.fixed_view::<6, 6>(0, 0);
        pose + into_imu * here.covariance * into_imu.transpose()
    }
}

/// The map begins anew where the robot is.
pub(super) fn set_map_upright(belief: &mut Belief) {
    belief.state.map_tilt = Vector2::zeros();
    belief
        .covariance
        .fixed_rows_mut::<2>(at::MAP_TILT)
        .fill(0.0);
    belief
        .covariance
        .fixed_columns_mut::<2>(at::MAP_TILT)
        .fill(0.0);
    for i in at::MAP_TILT..at::MAP_TILT + 2 {
        // Not zero, since the filter inverts the covariance.
        belief.covariance[(i, i)] = UPRIGHT_RAD * UPRIGHT_RAD;
    }
}

/// New ground was put into the map, tilted as the pose is. The map is tilted less than before then,
/// and more as the pose is wrong. `seen` is the covariance of the pose's tilt against the map.
fn renew_tilt(belief: &mut Belief, share: f64, seen: &Matrix2<f64>) {
    let share = share.min(MAX_RENEWED);
    belief.state.map_tilt *= 1.0 - share;
    let rotation = belief.state.rotation.to_rotation_matrix();
    // The new tilt is (1 - share) tilt - share × (error of the rotation, turned into `odom`).
    let mut step = Covariance::identity();
    let mut by_rotation = step.fixed_view_mut::<2, 3>(at::MAP_TILT, at::ROTATION);
    by_rotation -= rotation.matrix().fixed_rows::<2>(0) * share;
    let mut by_tilt = step.fixed_view_mut::<2, 2>(at::MAP_TILT, at::MAP_TILT);
    by_tilt *= 1.0 - share;
    belief.covariance = step * belief.covariance * step.transpose();
    let mut tilt = belief
        .covariance
        .fixed_view_mut::<2, 2>(at::MAP_TILT, at::MAP_TILT);
    tilt += seen * (share * LASTING_TILT);
}

/// Variance of a belief's position along a direction, m².
fn position_variance(belief: &Belief, direction: &Vector3<f64>) -> f64 {
    let position = belief
        .covariance
        .fixed_view::<3, 3>(at::POSITION, at::POSITION);
    direction.dot(&(position * direction))
}

/// Covariance of a belief's pose with the rotation in `odom`.
fn in_odom(belief: &Belief) -> Matrix6<f64> {
    let turn = rotating(&belief.state.rotation.to_rotation_matrix().into_inner());
    turn * belief.covariance.fixed_view::<6, 6>(0, 0) * turn.transpose()
}

/// Rotates rotations, leaves positions.
fn rotating(rotation: &Matrix3<f64>) -> Matrix6<f64> {
    let mut turn = Matrix6::identity();
    turn.fixed_view_mut::<3, 3>(0, 0).copy_from(rotation);
    turn
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lio::state::State;
    use nalgebra::UnitQuaternion;
    use openbench_core::{Pose3, SimTime};

    fn belief(x: f64) -> Belief {
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::z() * 1.2);
        let pose = Pose3::from_parts(Vector3::new(x, 0.0, 0.0).into(), rotation);
        Belief {
            stamp: SimTime::ZERO,
            state: State::at_rest(&pose, 9.8),
            covariance: Covariance::identity() * 1e-6,
        }
    }

    #[test]
    fn it_grows_with_what_is_new_and_a_rotated_map_leads_off_sideways() {
        let mut drift = Drift::default();
        let start = drift.pose_covariance(&belief(0.0));
        assert!((start - Matrix6::identity() * 1e-6).norm() < 1e-12);
        drift.grow(&mut belief(0.0), 0.0, &[]);
        assert!((drift.pose_covariance(&belief(9.0))[(4, 4)] - 1e-6).abs() < 1e-12);
        drift.grow(&mut belief(0.0), 0.5 / LASTING, &[]);
        let far = drift.pose_covariance(&belief(10.0));
        // Along the path: the pose and half of it once more. Across it ten metres times half a
        // milliradian squared as well.
        assert!((far[(3, 3)] - 1.5e-6).abs() < 1e-9);
        assert!(
            (far[(4, 4)] - (1.5e-6 + 100.0 * 0.5e-6)).abs() < 1e-9,
            "{far}"
        );
        assert!((far[(2, 2)] - 1.5e-6).abs() < 1e-9);
    }

    #[test]
    fn what_was_unknown_along_a_corridor_stays_unknown_behind_it() {
        let mut drift = Drift::default();
        let along = [Vector3::x()];
        let mut before = belief(0.0);
        let after = belief(0.0);
        before.covariance[(3, 3)] = 4.0;
        (0..100).for_each(|_| drift.grow(&mut before, 0.1, &along));
        assert!(
            (drift.pose_covariance(&before)[(3, 3)] - 4.0).abs() < 1e-6,
            "counted once"
        );
        drift.keep(&before, &after, &along);
        let covariance = drift.pose_covariance(&after);
        assert!((covariance[(3, 3)] - 4.0).abs() < 1e-6, "{covariance}");
        assert!(covariance[(4, 4)] < 1e-4, "{covariance}");
    }
}
