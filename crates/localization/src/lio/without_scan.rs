//! How the odometry goes on where no scan, or not even the IMU, has come.

use nalgebra::Vector3;
use openbench_core::SimTime;

use super::estimate::{Estimate, Status};
use super::pipeline::{ALL_DIRECTIONS, Pipeline};
use super::state::at;
use super::velocity_update::limit_velocity;
use crate::deviation::PoseDeviation;

/// How far off the pose may be after a time without the IMU.
const LOST: PoseDeviation = PoseDeviation {
    metres: 100.0,
    radians: 1.0,
};
/// How fast the robot may be then, m/s.
const LOST_M_S: f64 = 100.0;

impl Pipeline {
    /// Goes on without a scan, by IMU and wheels.
    pub(super) fn coast(&mut self, until: SimTime) -> Option<Estimate> {
        let mut belief = self.belief.take()?;
        let since = until.since(belief.stamp);
        self.inertial
            // Without a scan nothing shows what a saturated gyroscope has missed.
            .predict(&mut belief, until, &self.settings, &Vector3::zeros());
        let typical_speed = self.settings.typical_speed_m_s;
        for direction in &ALL_DIRECTIONS {
            limit_velocity(&mut belief, direction, typical_speed, since);
        }
        self.refused.gaps += self.inertial.forget(until);
        let estimate = self.estimate(&belief, None, Status::Coasting);
        self.belief = Some(belief);
        Some(estimate)
    }

    /// Goes on from where the robot was, though it may be elsewhere by now: the IMU was silent.
    pub(super) fn lose(&mut self, stamp: SimTime) -> Option<Estimate> {
        let mut belief = self.belief.take()?;
        belief.stamp = stamp;
        belief.state.velocity = Vector3::zeros();
        belief.add_deviation(at::ROTATION, LOST.radians);
        belief.add_deviation(at::POSITION, LOST.metres);
        belief.add_deviation(at::VELOCITY, LOST_M_S);
        self.drift.lose(&mut belief, LOST);
        self.begin_map();
        self.inertial.clear();
        // Wheels and gyroscope of the time before say nothing about a pose that is unknown.
        self.trust.forget_trajectory();
        self.refused.gaps += 1;
        let estimate = self.estimate(&belief, None, Status::Lost);
        self.belief = Some(belief);
        Some(estimate)
    }
}
