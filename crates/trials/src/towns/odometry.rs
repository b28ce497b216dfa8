//! Odometry errors on a drive through a window.

use std::ops::ControlFlow;
use std::time::Duration;

use cpu_time::ThreadTime;
use openbench_core::{Observation, Pose3, RobotDescription};
use openbench_localization::lidar_inertial::sensor_settings;
use openbench_localization::lio::{Estimate, LidarInertialOdometry, Status};
use openbench_localization::wheels::Wheels;
use serde::{Deserialize, Serialize};

use crate::tour::{STANDSTILL, Style, Tour, drive};
use openbench_bench::score::metrics::consistency::pose_at;
use openbench_bench::score::metrics::{EstimatedPose, Nees, StampedPose, nees};
use openbench_bench::{BenchError, Prepared};

/// Simulated duration of the drive.
const DRIVE_TIME: Duration = Duration::from_secs(180);

/// Odometry errors of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OdometrySum {
    /// Driven distance, metres.
    pub metres: f64,
    /// Number of estimated poses, one per scan.
    pub scans: usize,
    /// Number of poses with degenerate scans.
    pub coasting: usize,
    /// Number of poses with scans and IMU in conflict.
    pub disputed: usize,
    /// Root mean square position error, metres, after alignment at the first pose.
    pub rms_m: f64,
    /// Maximum position error, metres.
    pub max_m: f64,
    /// Consistency of the errors with the estimated covariances.
    pub nees: Option<Nees>,
    /// Median CPU time per scan, milliseconds. Depends on the machine.
    pub cpu_ms_p50: f64,
    /// 99th percentile of the CPU time per scan, milliseconds.
    pub cpu_ms_p99: f64,
}

/// Drives from door to door for three minutes and evaluates the odometry.
///
/// # Errors
/// A world in which a robot cannot drive.
pub fn measure(prepared: &Prepared, seed: u64) -> Result<OdometrySum, BenchError> {
    let tour = Tour {
        time: DRIVE_TIME,
        via: Vec::new(),
        style: Style::Smooth,
        seed,
        standstill: STANDSTILL,
    };
    let mut follower = Follower::new(&prepared.robot);
    let driven = drive(prepared, &tour, &mut |simulator, _| {
        follower.take(&simulator.observation(), simulator.base_link());
        Ok(ControlFlow::Continue(()))
    })?;
    Ok(follower.sum(driven.metres, &prepared.robot))
}

struct Follower {
    odometry: LidarInertialOdometry,
    wheels: Wheels,
    estimates: Vec<EstimatedPose>,
    truth: Vec<StampedPose>,
    coasting: usize,
    disputed: usize,
    spent: Duration,
    times: Vec<Duration>,
}

impl Follower {
    fn new(robot: &RobotDescription) -> Self {
        Self {
            odometry: LidarInertialOdometry::new(sensor_settings(robot)),
            wheels: Wheels::new(robot),
            estimates: Vec::new(),
            truth: Vec::new(),
            coasting: 0,
            disputed: 0,
            spent: Duration::ZERO,
            times: Vec::new(),
        }
    }

    fn take(&mut self, observation: &Observation<'_>, truth: Pose3) {
        self.truth.push(StampedPose {
            time: observation.time,
            pose: truth,
        });
        let began = ThreadTime::now();
        let speeds = observation
            .wheels
            .iter()
            .filter_map(|sample| self.wheels.take(sample));
        speeds.for_each(|speed| self.odometry.speed(speed));
        let mut estimates: Vec<Estimate> = observation
            .imu
            .iter()
            .flat_map(|sample| self.odometry.imu(*sample))
            .collect();
        estimates.extend(
            observation
                .scan
                .into_iter()
                .flat_map(|scan| self.odometry.scan(scan.clone())),
        );
        // Summed up until an estimate comes: it costs what all messages before it have cost.
        self.spent += began.elapsed();
        if !estimates.is_empty() {
            self.times.push(std::mem::take(&mut self.spent));
        }
        for estimate in estimates {
            self.coasting += usize::from(estimate.status == Status::Coasting);
            self.disputed += usize::from(estimate.status == Status::Disputed);
            self.estimates.push(EstimatedPose {
                time: estimate.stamp,
                pose: estimate.pose,
                covariance: estimate.covariance,
            });
        }
    }

    fn sum(mut self, metres: f64, robot: &RobotDescription) -> OdometrySum {
        self.times.sort_unstable();
        let distances = distances(&self.estimates, &self.truth);
        let squares: f64 = distances.iter().map(|d| d * d).sum();
        OdometrySum {
            metres,
            scans: self.estimates.len(),
            coasting: self.coasting,
            disputed: self.disputed,
            rms_m: (squares / distances.len().max(1) as f64).sqrt(),
            max_m: distances.iter().copied().fold(0.0, f64::max),
            nees: nees(&self.estimates, &self.truth, &robot.imu),
            cpu_ms_p50: percentile_ms(&self.times, 50),
            cpu_ms_p99: percentile_ms(&self.times, 99),
        }
    }
}

/// A percentile of ascending times, milliseconds; 0 without times.
fn percentile_ms(ascending: &[Duration], percent: usize) -> f64 {
    let time = ascending.get(ascending.len() * percent / 100);
    time.copied().unwrap_or_default().as_secs_f64() * 1e3
}

/// Distances of the estimated from the true positions after alignment at the first pose, metres.
fn distances(estimates: &[EstimatedPose], truth: &[StampedPose]) -> Vec<f64> {
    let Some(alignment) = estimates
        .first()
        .and_then(|first| Some(first.pose * pose_at(truth, first.time)?.inverse()))
    else {
        return Vec::new();
    };
    estimates
        .iter()
        .filter_map(|estimate| {
            let expected = alignment * pose_at(truth, estimate.time)?;
            Some((estimate.pose.translation.vector - expected.translation.vector).norm())
        })
        .collect()
}
