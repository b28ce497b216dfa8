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

/// The NEES of estimated poses of `base_link`; `None` for fewer than two poses with a known true
/// pose.
///
/// Each covariance is that of the IMU's rotation, in the IMU frame, and of its position; `imu` is
/// the pose of the IMU on the robot. The trajectories are aligned at the first pose, which
/// therefore has no error and is left out.
pub fn nees(
    estimates: &[(SimTime, Pose3, Matrix6<f64>)],
    truth: &[(SimTime, Pose3)],
    imu: &Pose3,
) -> Option<Nees> {
    let (start, first, _) = estimates.first()?;
    let from_first = pose_at(truth, *start)?.inverse();
    let errors = estimates[1..]
        .iter()
        .filter_map(|(stamp, pose, covariance)| {
            let expected = first * from_first * pose_at(truth, *stamp)? * imu;
            let pose = pose * imu;
            let rotation = (expected.rotation.inverse() * pose.rotation).scaled_axis();
            let position = pose.translation.vector - expected.translation.vector;
            let error = Vector6::new(
                rotation.x, rotation.y, rotation.z, position.x, position.y, position.z,
            );
            // Yaw (of a robot that is nearly upright), x, y.
            let ground = error.select_rows(&[2, 3, 4]);
            let ground_covariance = covariance
                .select_rows(&[2, 3, 4])
                .select_columns(&[2, 3, 4]);
            let squared = error.dot(&(covariance.try_inverse()? * error));
            Some([
                squared,
                ground.dot(&(ground_covariance.try_inverse()? * &ground)),
            ])
        });
    let errors: Vec<[f64; 2]> = errors.collect();
    let [end, ground] = *errors.last()?;
    Some(Nees {
        mean: errors.iter().map(|e| e[0]).sum::<f64>() / errors.len() as f64,
        end,
        ground,
    })
}

/// The true pose at an instant, interpolated between two known poses; `None` outside their
/// interval.
pub fn pose_at(truth: &[(SimTime, Pose3)], time: SimTime) -> Option<Pose3> {
    let after = truth.partition_point(|(t, _)| *t < time);
    let (t1, b) = truth.get(after)?;
    let Some((t0, a)) = after.checked_sub(1).and_then(|i| truth.get(i)) else {
        return (*t1 == time).then_some(*b);
    };
    let part = time.since(*t0).as_secs_f64() / t1.since(*t0).as_secs_f64();
    a.try_lerp_slerp(b, part, 1e-9).or(Some(*b))
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
        let truth = [
            (SimTime::ZERO, turned),
            (SimTime::from_millis(100), turned * driven),
        ];
        let deviations = Vector6::new(0.01, 0.02, 0.03, 0.4, 0.5, 0.6);
        let covariance = Matrix6::from_diagonal(&deviations.map(|x| x * x));
        let mut there = driven * imu;
        there.rotation *= nalgebra::UnitQuaternion::new(deviations.fixed_rows::<3>(0).into_owned());
        there.translation.vector += deviations.fixed_rows::<3>(3);
        let estimates = [
            (SimTime::ZERO, Pose3::identity(), covariance),
            (SimTime::from_millis(100), there * imu.inverse(), covariance),
        ];
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
