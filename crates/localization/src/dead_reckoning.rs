//! Dead reckoning: the way from the wheels, the heading from the gyroscope.
//!
//! The gyroscope's bias is its mean while the wheels stand still: over the first one and a half seconds, and again at every halt.
//! A skid-steer robot's wheels say little about its heading, but the mean of both sides says how far it went.

use std::collections::VecDeque;
use std::time::Duration;

use openbench_core::{
    ImuSample, Observation, Pose2, RobotDescription, SimTime, WheelSample, frames::wrap_angle,
};

use crate::Localizer;

/// Standing still that long shows the gyroscope's bias.
const SETTLE: Duration = Duration::from_millis(1500);
/// Poses of this long are remembered.
const MEMORY: Duration = Duration::from_millis(1000);
/// Least weight of one sample at rest in the running mean of the bias, which wanders.
const BIAS_GAIN: f64 = 0.001;

/// Pose from wheels and gyroscope.
#[derive(Debug, Clone)]
pub struct DeadReckoning {
    robot: RobotDescription,
    history: VecDeque<(SimTime, Pose2)>,
    wheels: Option<WheelSample>,
    bias: f64,
    samples_at_rest: u32,
    ready: bool,
}

impl DeadReckoning {
    /// A localizer for a robot.
    pub fn new(robot: RobotDescription) -> Self {
        let history = VecDeque::from([(SimTime::ZERO, Pose2::default())]);
        Self { robot, history, wheels: None, bias: 0.0, samples_at_rest: 0, ready: false }
    }

    fn newest(&self) -> (SimTime, Pose2) {
        self.history.back().copied().unwrap_or_default()
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
        let at_rest = left == 0.0 && right == 0.0;
        if at_rest {
            self.learn_bias(imu.gyro[2]);
        }
        let turned = if at_rest { 0.0 } else { (imu.gyro[2] - self.bias) * dt };
        // Along the chord of the arc.
        let chord = Pose2::new(pose.x, pose.y, pose.yaw + turned / 2.0).transform(forward, 0.0);
        self.history.push_back((imu.stamp, Pose2::new(chord.x, chord.y, wrap_angle(pose.yaw + turned))));
        while self.history.len() > 2 && imu.stamp.since(self.history[1].0) > MEMORY {
            self.history.pop_front();
        }
    }

    fn learn_bias(&mut self, rate: f64) {
        self.samples_at_rest = self.samples_at_rest.saturating_add(1);
        let gain = (1.0 / f64::from(self.samples_at_rest)).max(BIAS_GAIN);
        self.bias += gain * (rate - self.bias);
    }
}

impl Localizer for DeadReckoning {
    fn name(&self) -> &str {
        "dead-reckoning"
    }

    fn reset(&mut self, start: Pose2) {
        *self = Self::new(self.robot.clone());
        self.history = VecDeque::from([(SimTime::ZERO, start)]);
    }

    fn update(&mut self, observation: &Observation<'_>) {
        // Both come at 100 Hz with the same stamps.
        for (imu, wheels) in observation.imu.iter().zip(observation.wheels) {
            self.advance(imu, wheels);
        }
        self.ready = self.ready || observation.time.since(SimTime::ZERO) >= SETTLE;
    }

    fn pose_at(&self, time: SimTime) -> Pose2 {
        let after = self.history.partition_point(|(t, _)| *t < time);
        let Some(&(t1, b)) = self.history.get(after) else { return self.newest().1 };
        let Some(&(t0, a)) = after.checked_sub(1).and_then(|i| self.history.get(i)) else { return b };
        let s = time.since(t0).as_secs_f64() / t1.since(t0).as_secs_f64().max(1e-9);
        Pose2::new(a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), a.yaw + s * wrap_angle(b.yaw - a.yaw))
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
    fn feed(localizer: &mut DeadReckoning, from_ms: u64, seconds: f64, speed: f64, rate: f64) -> u64 {
        let end = from_ms + (seconds * 1000.0) as u64;
        let mut angle = localizer.wheels.map_or(0.0, |w| w.left);
        for ms in (from_ms + 10..=end).step_by(10) {
            angle += speed * 0.01 / 0.06;
            let stamp = SimTime::from_millis(ms);
            let imu = [ImuSample { stamp, gyro: [0.0, 0.0, rate + 0.01], accel: [0.0, 0.0, 9.8] }];
            let wheels = [WheelSample { stamp, left: angle, right: angle }];
            localizer.update(&Observation {
                time: stamp,
                imu: &imu,
                wheels: &wheels,
                scan: None,
                camera: &Blind,
            });
        }
        end
    }

    #[test]
    fn a_circle_closes_despite_the_bias() {
        let mut localizer = DeadReckoning::new(RobotDescription::sentry());
        localizer.reset(Pose2::new(2.0, 1.0, 0.5));
        let at = feed(&mut localizer, 0, 1.5, 0.0, 0.0);
        assert!(localizer.ready());
        feed(&mut localizer, at, std::f64::consts::TAU / 0.5, 0.4, 0.5);
        let pose = localizer.pose();
        assert!(pose.point().distance(openbench_core::MapPoint::new(2.0, 1.0)) < 0.02, "{pose:?}");
        assert!(wrap_angle(pose.yaw - 0.5).abs() < 0.01, "{pose:?}");
    }

    #[test]
    fn poses_in_between_are_interpolated() {
        let mut localizer = DeadReckoning::new(RobotDescription::sentry());
        let at = feed(&mut localizer, 0, 1.0, 0.0, 0.0);
        feed(&mut localizer, at, 0.5, 0.5, 0.0);
        let (a, b) =
            (localizer.pose_at(SimTime::from_millis(1200)), localizer.pose_at(SimTime::from_millis(1210)));
        let middle = localizer.pose_at(SimTime::from_millis(1205));
        assert!((middle.x - (a.x + b.x) / 2.0).abs() < 1e-9 && b.x > a.x);
        assert_eq!(localizer.pose_at(SimTime::from_millis(99_999)), localizer.pose());
    }
}
