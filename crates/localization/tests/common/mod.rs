//! A robot to test localizers with.

use std::sync::Arc;

use openbench_core::{
    Camera, Image, ImuSample, Observation, Pose2, RobotDescription, SimTime, WheelSample,
};
use openbench_localization::Localizer;

struct Blind;

impl Camera for Blind {
    fn image(&self) -> Option<Arc<Image>> {
        None
    }
}

/// A robot whose sensors are exact except for a biased gyroscope. Its localizer gets observations
/// every 50 ms.
pub struct Robot {
    pub time: SimTime,
    pub truth: Pose2,
    wheels: [f64; 2],
    /// Of the IMU in `map`, m/s. The IMU is not in the middle of the robot.
    velocity: [f64; 2],
}

/// Of the gyroscope, rad/s.
const BIAS: f64 = 0.004;
/// Between samples, seconds.
const DT: f64 = 0.01;

impl Robot {
    pub fn at(truth: Pose2) -> Self {
        Self {
            time: SimTime::ZERO,
            truth,
            wheels: [0.0; 2],
            velocity: [0.0; 2],
        }
    }

    /// Moves on for one step. Returns the specific force of an IMU that is `lever` metres in front
    /// of the middle.
    fn go(&mut self, linear: f64, angular: f64, lever: f64) -> [f64; 3] {
        let imu = |pose: Pose2| pose.transform(lever, 0.0);
        let before = imu(self.truth);
        // The chord of an arc points along the heading of half the arc.
        let half = Pose2::new(0.0, 0.0, angular * DT / 2.0);
        self.truth =
            self.truth
                .compose(half)
                .compose(Pose2::new(linear * DT, 0.0, angular * DT / 2.0));
        let after = imu(self.truth);
        let velocity = [(after.x - before.x) / DT, (after.y - before.y) / DT];
        let [x, y] = [0, 1].map(|i| (velocity[i] - self.velocity[i]) / DT);
        self.velocity = velocity;
        let (sine, cosine) = libm::sincos(self.truth.yaw);
        [cosine * x + sine * y, cosine * y - sine * x, 9.8]
    }

    pub fn drive(
        &mut self,
        localizer: &mut dyn Localizer,
        linear: f64,
        angular: f64,
        seconds: f64,
    ) {
        let robot = RobotDescription::sentry();
        for _ in 0..(seconds / 0.05).round() as usize {
            let (mut imu, mut wheels) = (Vec::new(), Vec::new());
            for _ in 0..5 {
                self.time = SimTime(self.time.0 + 10_000_000);
                let accel = self.go(linear, angular, robot.imu.translation.x);
                let difference = angular * robot.effective_track / 2.0;
                for (angle, speed) in self
                    .wheels
                    .iter_mut()
                    .zip([linear - difference, linear + difference])
                {
                    *angle += speed * DT / robot.wheel_radius;
                }
                let (stamp, [left, right]) = (self.time, self.wheels);
                imu.push(ImuSample {
                    stamp,
                    gyro: [0.0, 0.0, angular + BIAS],
                    accel,
                });
                wheels.push(WheelSample { stamp, left, right });
            }
            localizer.update(&seen(self.time, &imu, &wheels));
        }
    }
}

pub fn seen<'a>(time: SimTime, imu: &'a [ImuSample], wheels: &'a [WheelSample]) -> Observation<'a> {
    Observation {
        time,
        imu,
        wheels,
        scan: None,
        gnss: None,
        camera: &Blind,
    }
}
