//! Dead reckoning: distance from the wheels, heading from the gyroscope.
//!
//! The gyroscope's bias is what it shows at rest: over the first four seconds, and again at every
//! halt, averaged by a Kalman filter of one state. The body comes to rest later than its wheels,
//! and starts before the next tick of their encoders. Only readings well within a halt count as
//! rest.
//! The wheels of a skid-steered robot say little about its heading, but the mean of both sides says
//! how far it went.

use std::collections::VecDeque;
use std::time::Duration;

use openbench_core::frames::wrap_angle;
use openbench_core::{ImuSample, Observation, Pose2, RobotDescription, SimTime, WheelSample};

use crate::Localizer;
use crate::history::{History, StampedPose};

/// Rest of this length at the start shows the gyroscope's bias to 3e-5 rad/s: a degree in ten
/// minutes.
const SETTLE: Duration = Duration::from_millis(4000);
/// A robot whose wheels have turned by this angle has set off, radians: six marks of the encoders,
/// about a millimetre.
const SET_OFF_RAD: f64 = 0.02;
/// The robot rests once its wheels have rested for this time.
const STANDING: Duration = Duration::from_millis(150);
/// This many samples at the end of a halt may already be of the next motion.
const STARTING: usize = 5;
/// Noise of one sample of the gyroscope, rad/s: twice that of the part it is meant for.
const GYRO_NOISE_RAD_S: f64 = 1e-3;
/// Random walk of the gyroscope's bias, rad/s/√s: twice that of the part it is meant for.
const BIAS_WALK: f64 = 4e-6;
/// Standard deviation of the bias at the start, rad/s.
const INITIAL_BIAS_RAD_S: f64 = 0.05;

/// Pose from wheels and gyroscope.
///
/// # Example
///
/// Four seconds of rest, then one turn of the wheels (0.38 m) towards the north:
///
/// ```
/// use std::f64::consts::{FRAC_PI_2, TAU};
/// use std::sync::Arc;
///
/// use openbench_core::{Camera, Image, ImuSample, Observation, Pose2, RobotDescription};
/// use openbench_core::{SimTime, WheelSample};
/// use openbench_localization::{DeadReckoning, Localizer};
///
/// struct NoCamera;
/// impl Camera for NoCamera {
///     fn image(&self) -> Option<Arc<Image>> {
///         None
///     }
/// }
///
/// let mut localizer = DeadReckoning::new(RobotDescription::sentry());
/// localizer.reset(Pose2::new(20.0, 10.0, FRAC_PI_2));
/// for i in 1..=500 {
///     let stamp = SimTime::from_millis(10 * i);
///     let angle = TAU * (i as f64 - 400.0).max(0.0) / 100.0;
///     localizer.update(&Observation {
///         time: stamp,
///         imu: &[ImuSample { stamp, gyro: [0.0, 0.0, 0.002], accel: [0.0, 0.0, 9.81] }],
///         wheels: &[WheelSample { stamp, left: angle, right: angle }],
///         scan: None,
///         gnss: None,
///         camera: &NoCamera,
///     });
/// }
/// let pose = localizer.pose();
/// assert!(localizer.ready());
/// assert!((pose.y - 10.377).abs() < 1e-3, "{pose:?}");
/// assert!((pose.yaw - FRAC_PI_2).abs() < 1e-3, "the gyroscope's bias was learned: {pose:?}");
/// ```
#[derive(Debug, Clone)]
pub struct DeadReckoning {
    robot: RobotDescription,
    history: History,
    wheels: Option<WheelSample>,
    /// When the wheels last turned.
    moved: SimTime,
    /// Turn rates of the newest samples at rest, not yet learned from.
    resting: VecDeque<f64>,
    bias: GyroBias,
    /// How far the wheels have turned, forwards or backwards, radians.
    rolled: f64,
    ready: bool,
}

/// Bias of the gyroscope: a Kalman filter of one state.
#[derive(Debug, Clone, Copy)]
struct GyroBias {
    /// rad/s.
    mean: f64,
    /// (rad/s)².
    variance: f64,
}

impl DeadReckoning {
    /// A localizer for a robot.
    pub fn new(robot: RobotDescription) -> Self {
        Self {
            robot,
            history: History::from(Pose2::default()),
            wheels: None,
            moved: SimTime::ZERO,
            resting: VecDeque::new(),
            bias: GyroBias::unknown(),
            rolled: 0.0,
            ready: false,
        }
    }

    fn advance(&mut self, imu: &ImuSample, wheels: &WheelSample) {
        let StampedPose { stamp, pose } = self.history.newest();
        let dt = imu.stamp.since(stamp).as_secs_f64();
        let last = self.wheels.replace(*wheels);
        let left = last.map_or(wheels.left, |last| wheels.left - last.left);
        let right = last.map_or(wheels.right, |last| wheels.right - last.right);
        let forward = (left + right) / 2.0 * self.robot.wheel_radius;
        self.bias.predict(dt);
        self.learn_at_rest(imu, left != 0.0 || right != 0.0);
        self.rolled += left.abs().max(right.abs());
        // What the gyroscope shows before the robot sets off is its bias. A robot that sets off
        // before its bias is well known turns all the same.
        let turned = if self.ready || self.rolled > SET_OFF_RAD {
            (imu.gyro[2] - self.bias.mean) * dt
        } else {
            0.0
        };
        // The chord of an arc points along the heading of half the arc.
        let chord = Pose2::new(pose.x, pose.y, pose.yaw + turned / 2.0).transform(forward, 0.0);
        let next = Pose2::new(chord.x, chord.y, wrap_angle(pose.yaw + turned));
        self.history.push(imu.stamp, next);
    }

    /// Learns the bias from readings that are well within a halt.
    fn learn_at_rest(&mut self, imu: &ImuSample, is_moving: bool) {
        if is_moving {
            self.moved = imu.stamp;
            self.resting.clear();
        } else if imu.stamp.since(self.moved) >= STANDING {
            self.resting.push_back(imu.gyro[2]);
        }
        if self.resting.len() > STARTING
            && let Some(rate) = self.resting.pop_front()
        {
            self.bias.update(rate);
        }
    }
}

impl GyroBias {
    fn unknown() -> Self {
        Self {
            mean: 0.0,
            variance: INITIAL_BIAS_RAD_S * INITIAL_BIAS_RAD_S,
        }
    }

    /// Lets the bias walk for some seconds.
    fn predict(&mut self, seconds: f64) {
        self.variance += BIAS_WALK * BIAS_WALK * seconds;
    }

    /// Takes in a turn rate at rest, rad/s.
    fn update(&mut self, rate: f64) {
        let gain = self.variance / (self.variance + GYRO_NOISE_RAD_S * GYRO_NOISE_RAD_S);
        self.mean += gain * (rate - self.mean);
        self.variance *= 1.0 - gain;
    }
}

impl Localizer for DeadReckoning {
    fn name(&self) -> &str {
        "dead-reckoning"
    }

    fn registers_scans(&self) -> bool {
        false
    }

    fn reset(&mut self, start: Pose2) {
        *self = Self::new(self.robot.clone());
        self.history = History::from(start);
    }

    fn update(&mut self, observation: &Observation<'_>) {
        // Both come at 100 Hz with the same stamps.
        for (imu, wheels) in observation.imu.iter().zip(observation.wheels) {
            let is_finite =
                imu.gyro[2].is_finite() && wheels.left.is_finite() && wheels.right.is_finite();
            if is_finite && imu.stamp > self.history.newest().stamp {
                self.advance(imu, wheels);
            }
        }
        self.ready = self.ready || observation.time.since(SimTime::ZERO) >= SETTLE;
    }

    fn pose_at(&self, time: SimTime) -> Pose2 {
        self.history.at(time)
    }

    fn pose(&self) -> Pose2 {
        self.history.newest().pose
    }

    fn ready(&self) -> bool {
        self.ready
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::{Camera, Image, MapPoint};
    use std::sync::Arc;

    struct Blind;

    impl Camera for Blind {
        fn image(&self) -> Option<Arc<Image>> {
            None
        }
    }

    /// A robot with a biased gyroscope, and its localizer.
    struct Trial {
        localizer: DeadReckoning,
        millis: u64,
        wheel_angle: f64,
    }

    impl Trial {
        /// Begins at a pose with four seconds of rest.
        fn new(start: Pose2) -> Self {
            let mut trial = Self::at(start);
            trial.drive(4.0, 0.0, 0.0);
            trial
        }

        /// Begins at a pose.
        fn at(start: Pose2) -> Self {
            let mut localizer = DeadReckoning::new(RobotDescription::sentry());
            localizer.reset(start);
            Self {
                localizer,
                millis: 0,
                wheel_angle: 0.0,
            }
        }

        /// Drives for so many seconds; `speed` is the wheels', m/s, and `rate` the body's, rad/s.
        fn drive(&mut self, seconds: f64, speed: f64, rate: f64) {
            for _ in 0..(seconds * 1000.0) as u64 / 10 {
                self.millis += 10;
                self.wheel_angle += speed * 0.01 / 0.06;
                let stamp = SimTime::from_millis(self.millis);
                let gyro = [0.0, 0.0, rate + 0.01];
                let imu = [ImuSample {
                    stamp,
                    gyro,
                    accel: [0.0, 0.0, 9.8],
                }];
                let (left, right) = (self.wheel_angle, self.wheel_angle);
                let wheels = [WheelSample { stamp, left, right }];
                self.localizer.update(&Observation {
                    time: stamp,
                    imu: &imu,
                    wheels: &wheels,
                    scan: None,
                    gnss: None,
                    camera: &Blind,
                });
            }
        }
    }

    #[test]
    fn a_circle_closes_despite_the_bias() {
        let mut trial = Trial::new(Pose2::new(2.0, 1.0, 0.5));
        assert!(trial.localizer.ready());
        trial.drive(std::f64::consts::TAU / 0.5, 0.4, 0.5);
        let pose = trial.localizer.pose();
        assert!(
            pose.point().distance(MapPoint::new(2.0, 1.0)) < 0.02,
            "{pose:?}"
        );
        assert!(wrap_angle(pose.yaw - 0.5).abs() < 0.01, "{pose:?}");
    }

    #[test]
    fn a_robot_that_sets_off_early_turns_by_what_it_knows_of_the_bias() {
        let mut trial = Trial::at(Pose2::default());
        trial.drive(0.5, 0.0, 0.0);
        assert!(!trial.localizer.ready());
        trial.drive(2.0, 0.3, 0.4);
        let yaw = trial.localizer.pose().yaw;
        assert!((yaw - 0.8).abs() < 0.02, "{yaw}");
    }

    #[test]
    fn a_turn_that_outlasts_the_wheels_counts_and_is_not_taken_for_bias() {
        let mut trial = Trial::new(Pose2::default());
        for _ in 0..20 {
            trial.drive(0.5, 0.3, 0.2);
            // The wheels rest while the body slides on for a tenth of a second.
            trial.drive(0.1, 0.0, 0.2);
            trial.drive(0.4, 0.0, 0.0);
        }
        let turned = 20.0 * 0.6 * 0.2;
        let (yaw, bias) = (trial.localizer.pose().yaw, trial.localizer.bias.mean);
        assert!((yaw - turned).abs() < 0.02, "{yaw}");
        assert!((bias - 0.01).abs() < 1e-4, "{bias}");
    }

    #[test]
    fn poses_in_between_are_interpolated() {
        let mut trial = Trial::new(Pose2::default());
        trial.drive(0.5, 0.5, 0.0);
        let [a, middle, b] =
            [4200, 4205, 4210].map(|millis| trial.localizer.pose_at(SimTime::from_millis(millis)));
        assert!((middle.x - (a.x + b.x) / 2.0).abs() < 1e-9);
        assert!(b.x > a.x);
        let future = SimTime::from_millis(99_999);
        assert_eq!(trial.localizer.pose_at(future), trial.localizer.pose());
    }
}
