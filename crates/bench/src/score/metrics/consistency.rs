//! Consistency of pose errors with their covariances: the normalized estimation error squared.

use nalgebra::{Matrix6, Vector6};
use openbench_core::{Pose3, SimTime};
use serde::{Deserialize, Serialize};

/// The normalized estimation error squared (NEES) of poses with six degrees of freedom.
///
/// Its mean is 6 if the covariance is consistent, less if it is too large, more if it is too small.
/// Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and
/// Navigation*, 2001, section 5.4.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Nees {
    /// Mean over all poses.
    pub mean: f64,
    /// Value of the last pose.
    pub end: f64,
    /// Value of the last pose for x, y and yaw only; its expectation is 3.
    pub ground: f64,
}

/// A true pose of `base_link`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StampedPose {
    /// When the robot was there.
    pub time: SimTime,
    /// The pose, in the frame of the trajectory.
    pub pose: Pose3,
}

/// An estimated pose of `base_link`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimatedPose {
    /// When the robot was estimated to be there.
    pub time: SimTime,
    /// The pose, in the frame of the trajectory.
    pub pose: Pose3,
    /// Covariance of the IMU's rotation, in the IMU frame, radians, and of its position, metres.
    pub covariance: Matrix6<f64>,
}

/// The NEES of estimated poses; `None` for fewer than two poses with a known true pose.
///
/// `imu` is the pose of the IMU on the robot. The trajectories are aligned at the first pose, which
/// therefore has no error and is left out.
pub fn nees(estimates: &[EstimatedPose], truth: &[StampedPose], imu: &Pose3) -> Option<Nees> {
    let first = estimates.first()?;
    let from_first = pose_at(truth, first.time)?.inverse();
    let errors = estimates[1..].iter().filter_map(|estimate| {
        // The true motion since the first estimate, appended to that estimate. The IMU's pose
        // follows, since the covariance is that of the IMU.
        let expected = first.pose * from_first * pose_at(truth, estimate.time)? * imu;
        squared_errors(estimate, expected, imu)
    });
    let errors: Vec<SquaredErrors> = errors.collect();
    let last = errors.last()?;
    Some(Nees {
        mean: errors.iter().map(|e| e.all).sum::<f64>() / errors.len() as f64,
        end: last.all,
        ground: last.ground,
    })
}

/// Normalized squared errors of a pose.
struct SquaredErrors {
    /// Along all six axes.
    all: f64,
    /// Of yaw, x and y.
    ground: f64,
}

/// The errors of an estimate if the IMU is at `expected`; `None` for a singular covariance.
fn squared_errors(estimate: &EstimatedPose, expected: Pose3, imu: &Pose3) -> Option<SquaredErrors> {
    /// Rows of yaw (of a robot that is nearly upright), x and y.
    const GROUND: [usize; 3] = [2, 3, 4];
    let EstimatedPose {
        pose, covariance, ..
    } = estimate;
    let pose = pose * imu;
    // The rotation error in the IMU frame and the position error in that of the trajectory, as the
    // covariance has them.
    let rotation = (expected.rotation.inverse() * pose.rotation).scaled_axis();
    let position = pose.translation.vector - expected.translation.vector;
    let error = Vector6::new(
        rotation.x, rotation.y, rotation.z, position.x, position.y, position.z,
    );
    // Rows and columns of the covariance belong to the marginal distribution of these axes. Those
    // of its inverse would not: they belong to the conditional one.
    let ground = error.select_rows(&GROUND);
    let ground_covariance = covariance.select_rows(&GROUND).select_columns(&GROUND);
    Some(SquaredErrors {
        // NEES: e' P⁻¹ e.
        all: error.dot(&(covariance.try_inverse()? * error)),
        ground: ground.dot(&(ground_covariance.try_inverse()? * &ground)),
    })
}

/// The true pose at an instant, interpolated between two known poses; `None` outside their
/// interval.
pub fn pose_at(truth: &[StampedPose], time: SimTime) -> Option<Pose3> {
    let after = truth.partition_point(|known| known.time < time);
    let next = truth.get(after)?;
    let Some(last) = after.checked_sub(1).and_then(|i| truth.get(i)) else {
        return (next.time == time).then_some(next.pose);
    };
    // The search ensures `last.time < time <= next.time`: the divisor is positive.
    let part = time.since(last.time).as_secs_f64() / next.time.since(last.time).as_secs_f64();
    // Opposite rotations have no shortest way between them.
    let between = last.pose.try_lerp_slerp(&next.pose, part, 1e-9);
    between.or(Some(next.pose))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors of one standard deviation along each of six axes, all with different deviations.
    #[test]
    fn errors_of_one_standard_deviation_along_each_axis_have_a_nees_of_six() {
        let turned = Pose3::new(
            nalgebra::Vector3::new(5.0, -3.0, 0.0),
            nalgebra::Vector3::z() * 0.7,
        );
        let driven = Pose3::new(
            nalgebra::Vector3::new(2.0, 1.0, 0.0),
            nalgebra::Vector3::z() * 1.2,
        );
        let imu = Pose3::new(
            nalgebra::Vector3::new(0.3, 0.0, 0.2),
            nalgebra::Vector3::z() * 0.4,
        );
        let truth = [(0, turned), (100, turned * driven)].map(|(ms, pose)| StampedPose {
            time: SimTime::from_millis(ms),
            pose,
        });
        let deviations = Vector6::new(0.01, 0.02, 0.03, 0.4, 0.5, 0.6);
        let covariance = Matrix6::from_diagonal(&deviations.map(|x| x * x));
        let mut there = driven * imu;
        there.rotation *= nalgebra::UnitQuaternion::new(deviations.fixed_rows::<3>(0).into_owned());
        there.translation.vector += deviations.fixed_rows::<3>(3);
        let poses = [(0, Pose3::identity()), (100, there * imu.inverse())];
        let estimates = poses.map(|(ms, pose)| EstimatedPose {
            time: SimTime::from_millis(ms),
            pose,
            covariance,
        });
        let found = nees(&estimates, &truth, &imu).unwrap();
        assert!(
            (found.end - 6.0).abs() < 1e-6 && (found.ground - 3.0).abs() < 1e-6,
            "{found:?}"
        );
        assert!(
            (found.mean - 6.0).abs() < 1e-6,
            "the first pose is left out"
        );
        assert!(nees(&[], &truth, &imu).is_none() && nees(&estimates, &truth[..1], &imu).is_none());
    }
}
