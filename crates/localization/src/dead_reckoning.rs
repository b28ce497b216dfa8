//! Dead reckoning: the way from the wheels, the heading from the gyroscope.
//!
//! The gyroscope's bias is what it shows at rest: over the first four seconds, and again at every halt, weighed by a Kalman
//! filter of one state. The body comes to rest later than its wheels, and starts before the next mark of their encoders shows: only what
//! the gyroscope said well within a halt counts as rest.
//! A skid-steer robot's wheels say little about its heading, but the mean of both sides says how far it went.

use std::collections::VecDeque;
use std::time::Duration;

use openbench_core::{
    ImuSample, Observation, Pose2, RobotDescription, SimTime, WheelSample, frames::wrap_angle,
};

use crate::Localizer;
use crate::history::History;

/// Standing still that long at the start shows the gyroscope's bias: to 3e-5 rad/s, a degree in ten minutes.
const SETTLE: Duration = Duration::from_millis(4000);
/// Wheels that have stood that long mean that the robot does.
const STANDING: Duration = Duration::from_millis(150);
/// Samples at the end of a halt that may already be of the next motion.
const STARTING: usize = 5;
/// Noise of one sample of the gyroscope, rad/s, twice that of the part that is meant.
const GYRO_NOISE: f64 = 1e-3;
/// Random walk of the gyroscope's bias, rad/s/√s, twice that of the part that is meant.
const BIAS_WALK: f64 = 4e-6;
/// Deviation of the bias before anything is known, rad/s.
const BIAS_AT_FIRST: f64 = 0.05;

/// Pose from wheels and gyroscope.
#[derive(Debug, Clone)]
pub struct DeadReckoning {
    robot: RobotDescription,
    history: History,
    wheels: Option<WheelSample>,
    /// When the wheels last turned.
    moved: SimTime,
    /// Turn rates of the newest samples at rest, not yet learned from.
    resting: VecDeque<f64>,
    bias: f64,
    /// Variance of the bias, (rad/s)².
    bias_variance: f64,
    ready: bool,
}

impl DeadReckoning {
    /// A localizer for a robot.
    pub fn new(robot: RobotDescription) -> Self {
        let history = History::from(Pose2::default());
        let bias_variance = BIAS_AT_FIRST * BIAS_AT_FIRST;
        Self {
            robot,
            history,
            wheels: None,
            moved: SimTime::ZERO,
            resting: VecDeque::new(),
            bias: 0.0,
            bias_variance,
            ready: false,
        }
    }

    fn newest(&self) -> (SimTime, Pose2) {
        self.history.newest()
    }

    fn advance(&mut self, imu: &ImuSample, wheels: &WheelSample) {
        let (before, pose) = self.newest();
        let dt = imu.stamp.since(before).as_secs_f64();
        let (left, right) = match self.wheels {
            Some(last) => (wheels.left - last.left, wheels.right - last.right),
            None => (wheels.left, wheels.right),
        };
        self.wheels = Some(*wheels);
        let forward = (left + right) / 2.0 * self.robot.wheel_radius;
        self.bias_variance += BIAS_WALK * BIAS_WALK * dt;
        if left != 0.0 || right != 0.0 {
            self.moved = imu.stamp;
            self.resting.clear();
        } else if imu.stamp.since(self.moved) >= STANDING {
            self.resting.push_back(imu.gyro[2]);
        }
        if self.resting.len() > STARTING {
            self.resting
                .pop_front()
                .into_iter()
                .for_each(|rate| self.learn_bias(rate));
        }
        let turned = if self.ready {
            (imu.gyro[2] - self.bias) * dt
        } else {
            0.0
        };
        // Along the chord of the arc.
        let chord = Pose2::new(pose.x, pose.y, pose.yaw + turned / 2.0).transform(forward, 0.0);
        self.history.push(
            imu.stamp,
            Pose2::new(chord.x, chord.y, wrap_angle(pose.yaw + turned)),
        );
    }

    fn learn_bias(&mut self, rate: f64) {
        let gain = self.bias_variance / (self.bias_variance + GYRO_NOISE * GYRO_NOISE);
        self.bias += gain * (rate - self.bias);
        self.bias_variance *= 1.0 - gain;
    }
}

impl Localizer for DeadReckoning {
    fn name(&self) -> &str {
        "dead-reckoning"
    }

    fn reset(&mut self, start: Pose2) {
        *self = Self::new(self.robot.clone());
        self.history = History::from(start);
    }

    fn update(&mut self, observation: &Observation<'_>) {
        // Both come at 100 Hz with the same stamps.
        for (imu, wheels) in observation.imu.iter().zip(observation.wheels) {
            let sound =
                imu.gyro[2].is_finite() && wheels.left.is_finite() && wheels.right.is_finite();
            if sound && imu.stamp > self.newest().0 {
                self.advance(imu, wheels);
            }
        }
        self.ready = self.ready || observation.time.since(SimTime::ZERO) >= SETTLE;
    }

    fn pose_at(&self, time: SimTime) -> Pose2 {
        self.history.at(time)
    }

    fn pose(&self) -> Pose2 {
        self.newest().1
    }

    fn ready(&self) -> bool {
        self.ready
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::{Camera, Image};
    use std::sync::Arc;

    struct Blind;
    impl Camera for Blind {
        fn image(&self) -> Option<Arc<Image>> {
            None
        }
    }

    /// Feeds `seconds` of samples with a gyroscope bias; wheel speed and turn rate as given.
    fn feed(
        localizer: &mut DeadReckoning,
        from_ms: u64,
        seconds: f64,
        speed: f64,
        rate: f64,
    ) -> u64 {
        let end = from_ms + (seconds * 1000.0) as u64;
        let mut angle = localizer.wheels.map_or(0.0, |w| w.left);
        for ms in (from_ms + 10..=end).step_by(10) {
            angle += speed * 0.01 / 0.06;
            let stamp = SimTime::from_millis(ms);
            let imu = [ImuSample {
                stamp,
                gyro: [0.0, 0.0, rate + 0.01],
                accel: [0.0, 0.0, 9.8],
            }];
            let wheels = [WheelSample {
                stamp,
                left: angle,
                right: angle,
            }];
            localizer.update(&Observation {
                time: stamp,
                imu: &imu,
                wheels: &wheels,
                scan: None,
                gnss: None,
                camera: &Blind,
            });
        }
        end
    }

    #[test]
    fn a_circle_closes_despite_the_bias() {
        let mut localizer = DeadReckoning::new(RobotDescription::sentry());
        localizer.reset(Pose2::new(2.0, 1.0, 0.5));
        let at = feed(&mut localizer, 0, 4.0, 0.0, 0.0);
        assert!(localizer.ready());
        feed(&mut localizer, at, std::f64::consts::TAU / 0.5, 0.4, 0.5);
        let pose = localizer.pose();
        assert!(
            pose.point()
                .distance(openbench_core::MapPoint::new(2.0, 1.0))
                < 0.02,
            "{pose:?}"
        );
        assert!(wrap_angle(pose.yaw - 0.5).abs() < 0.01, "{pose:?}");
    }

    #[test]
    fn a_turn_that_outlasts_the_wheels_counts_and_is_not_taken_for_bias() {
        let mut localizer = DeadReckoning::new(RobotDescription::sentry());
        let mut at = feed(&mut localizer, 0, 4.0, 0.0, 0.0);
        for _ in 0..20 {
            at = feed(&mut localizer, at, 0.5, 0.3, 0.2);
            // The wheels stand while the body slides on for a tenth of a second.
            at = feed(&mut localizer, at, 0.1, 0.0, 0.2);
            at = feed(&mut localizer, at, 0.4, 0.0, 0.0);
        }
        let turned = 20.0 * 0.6 * 0.2;
        assert!(
            (localizer.pose().yaw - turned).abs() < 0.02,
            "{:?}",
            localizer.pose()
        );
        assert!((localizer.bias - 0.01).abs() < 1e-4, "{}", localizer.bias);
    }

    #[test]
    fn poses_in_between_are_interpolated() {
        let mut localizer = DeadReckoning::new(RobotDescription::sentry());
        let at = feed(&mut localizer, 0, 4.0, 0.0, 0.0);
        feed(&mut localizer, at, 0.5, 0.5, 0.0);
        let (a, b) = (
            localizer.pose_at(SimTime::from_millis(4200)),
            localizer.pose_at(SimTime::from_millis(4210)),
        );
        let middle = localizer.pose_at(SimTime::from_millis(4205));
        assert!((middle.x - (a.x + b.x) / 2.0).abs() < 1e-9 && b.x > a.x);
        assert_eq!(
            localizer.pose_at(SimTime::from_millis(99_999)),
            localizer.pose()
        );
    }
}
