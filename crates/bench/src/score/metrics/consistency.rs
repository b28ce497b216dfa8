//! Whether a pose is as far off as its covariance says.

use nalgebra::{Matrix6, Vector6};
use openbench_core::{Pose3, SimTime};
use serde::{Deserialize, Serialize};

/// The normalized estimation error squared (Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation*, 2001, section 5.4): six
/// on average if the covariance is right, less if it is too large, more if it is too small.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Nees {
    /// Over all poses.
    pub mean: f64,
    /// At the last pose.
    pub end: f64,
    /// At the last pose of position and heading on the ground only: three on average.
    pub ground: f64,
}

/// Of poses of `base_link` with covariances of the IMU's rotation in its own frame and of its position; `imu` is its place on the robot. Both ways are laid on each other at the
/// first pose, which therefore does not count.
pub fn nees(
    told: &[(SimTime, Pose3, Matrix6<f64>)],
    truth: &[(SimTime, Pose3)],
    imu: &Pose3,
) -> Option<Nees> {
    let (start, first, _) = told.first()?;
    let apart = pose_at(truth, *start)?.inverse();
    let errors = told[1..].iter().filter_map(|(stamp, pose, covariance)| {
        let right = first * apart * pose_at(truth, *stamp)? * imu;
        let pose = pose * imu;
        let turned = (right.rotation.inverse() * pose.rotation).scaled_axis();
        let moved = pose.translation.vector - right.translation.vector;
        let error = Vector6::new(turned.x, turned.y, turned.z, moved.x, moved.y, moved.z);
        // Yaw of a robot that is about upright, x, y.
        let ground = error.select_rows(&[2, 3, 4]);
        let among = covariance
            .select_rows(&[2, 3, 4])
            .select_columns(&[2, 3, 4]);
        let squared = error.dot(&(covariance.try_inverse()? * error));
        Some([squared, ground.dot(&(among.try_inverse()? * &ground))])
    });
    let errors: Vec<[f64; 2]> = errors.collect();
    let [end, ground] = *errors.last()?;
    Some(Nees {
        mean: errors.iter().map(|e| e[0]).sum::<f64>() / errors.len() as f64,
        end,
        ground,
    })
}

/// The true pose at an instant, between two that are known.
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

    /// Errors of one deviation along each of six axes, of which no two are as wide.
    #[test]
    fn errors_of_one_deviation_along_each_axis_make_six() {
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
        let told = [
            (SimTime::ZERO, Pose3::identity(), covariance),
            (SimTime::from_millis(100), there * imu.inverse(), covariance),
        ];
        let found = nees(&told, &truth, &imu).unwrap();
        assert!(
            (found.end - 6.0).abs() < 1e-6 && (found.ground - 3.0).abs() < 1e-6,
            "{found:?}"
        );
        assert!(
            (found.mean - 6.0).abs() < 1e-6,
            "the first pose does not count"
        );
        assert!(nees(&[], &truth, &imu).is_none() && nees(&told, &truth[..1], &imu).is_none());
    }
}
