//! Drives with degraded sensors. A localizer may then have large errors, but it must report them.

use std::fmt;
use std::ops::ControlFlow;
use std::time::Duration;

use nalgebra::{Rotation3, UnitVector3, Vector3};
use openbench_core::{
    Health, ImuSample, LidarScan, Observation, Pose2, PoseEstimate, SimTime, WheelSample,
};
use openbench_localization::Localizer;
use openbench_sim::noise::Noise;
use serde::Serialize;

use crate::tour::{Style, Tour, drive};
use openbench_bench::run::threads;
use openbench_bench::score::metrics::LocalizationSum;
use openbench_bench::score::metrics::localization::localization;
use openbench_bench::trace::PoseError;
use openbench_bench::{BenchError, Prepared};

/// Standard deviation of a LiDAR range, from the data sheet.
const RANGE_NOISE_M: f64 = 0.02;
/// Standard deviation of a gyroscope sample, from the data sheet.
const GYRO_NOISE_RAD_PER_S: f64 = 5.6e-4;
/// Standard deviation of an accelerometer sample, from the data sheet.
const ACCEL_NOISE_MPS2: f64 = 7e-3;
/// Initial time with intact sensors, as if the robot was switched on in its garage.
const INTACT: Duration = Duration::from_secs(5);
/// Duration of an occlusion of the LiDAR, at the end of each [`OCCLUSION_PERIOD`].
const OCCLUSION: Duration = Duration::from_secs(15);
const OCCLUSION_PERIOD: Duration = Duration::from_secs(45);
/// Shocks of the IMU: period and duration in samples.
const SHOCK_PERIOD_SAMPLES: u64 = 311;
const SHOCK_SAMPLES: u64 = 3;
/// Shocks of the IMU: standard deviations.
const SHOCK_ACCEL_MPS2: f64 = 60.0;
const SHOCK_RATE_RAD_PER_S: f64 = 6.0;
/// Stream of random numbers, distinct from those of sensors, traffic and tour.
const RANDOM_STREAM: u64 = 53;

/// A degradation of the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Degradation {
    /// No degradation.
    None,
    /// The noise of LiDAR and IMU is larger than in the data sheets by this factor.
    Noisy(f64),
    /// The coordinates of points are rounded to multiples of this many metres, as after a
    /// conversion to single precision.
    Quantised(f64),
    /// The field of view of the LiDAR is reduced to this many degrees, for 15 s in 45 s.
    Blinded(f64),
    /// The IMU has a shock about every three seconds.
    #[serde(rename = "jerked")]
    ImuShocks,
    /// The LiDAR has a mounting error in yaw, degrees.
    TurnedLidar(f64),
    /// The LiDAR has a mounting error in pitch, degrees, forward.
    #[serde(rename = "leaning_lidar")]
    PitchedLidar(f64),
    /// The wheels are larger than described by this factor.
    Wheels(f64),
    /// The time stamps of the LiDAR are late by this many milliseconds.
    Late(u64),
}

/// All degradations that are tested.
pub const ALL: [Degradation; 18] = [
    Degradation::None,
    Degradation::Noisy(2.0),
    Degradation::Noisy(5.0),
    Degradation::Noisy(10.0),
    Degradation::Quantised(0.05),
    Degradation::Quantised(0.25),
    Degradation::Quantised(1.0),
    Degradation::Blinded(30.0),
    Degradation::Blinded(0.0),
    Degradation::ImuShocks,
    Degradation::TurnedLidar(1.0),
    Degradation::TurnedLidar(5.0),
    Degradation::PitchedLidar(1.0),
    Degradation::PitchedLidar(5.0),
    Degradation::Wheels(1.05),
    Degradation::Wheels(1.5),
    Degradation::Late(50),
    Degradation::Late(150),
];

impl fmt::Display for Degradation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("intact sensors"),
            Self::Noisy(factor) => write!(f, "noise x {factor}"),
            Self::Quantised(metres) => write!(f, "points rounded to {metres} m"),
            Self::Blinded(degrees) => write!(f, "LiDAR view {degrees}°, 15 s in 45 s"),
            Self::ImuShocks => f.write_str("IMU shock every 3 s"),
            Self::TurnedLidar(degrees) => write!(f, "LiDAR yaw error {degrees}°"),
            Self::PitchedLidar(degrees) => write!(f, "LiDAR pitch error {degrees}°"),
            Self::Wheels(factor) => write!(f, "wheel radius x {factor}"),
            Self::Late(ms) => write!(f, "LiDAR stamps {ms} ms late"),
        }
    }
}

/// The result with one degradation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DegradedResult {
    /// The degradation.
    pub degradation: Degradation,
    /// Errors of the poses; null if none was reported.
    pub errors: Option<LocalizationSum>,
    /// Share of poses with good health.
    pub good: f64,
    /// Share of poses with the health lost.
    pub lost: f64,
    /// The largest error of a pose with good health, metres.
    pub largest_good_m: f64,
    /// Driven distance, metres.
    pub metres: f64,
}

/// Tests a localizer with all degradations in [`ALL`], each on a drive of the duration `time` along
/// the same route. `make` creates a fresh localizer for each drive.
///
/// # Errors
/// A world in which a robot cannot drive.
pub fn trials(
    prepared: &Prepared,
    seed: u64,
    time: Duration,
    threads: usize,
    make: &(dyn Fn() -> Box<dyn Localizer> + Sync),
) -> Result<Vec<DegradedResult>, BenchError> {
    let one = |i: usize| trial(prepared, seed, time, ALL[i], make().as_mut());
    threads::each(0..ALL.len(), threads, one, Ok)
}

/// Tests a localizer with one degradation.
///
/// # Errors
/// A world in which a robot cannot drive.
pub fn trial(
    prepared: &Prepared,
    seed: u64,
    time: Duration,
    degradation: Degradation,
    localizer: &mut dyn Localizer,
) -> Result<DegradedResult, BenchError> {
    let tour = Tour {
        time,
        via: Vec::new(),
        style: Style::Smooth,
        seed,
        // An agent too stands until its localizer is ready.
        standstill: INTACT,
    };
    let mut sensors = Degraded {
        degradation,
        noise: Noise::new(seed, RANDOM_STREAM),
        samples: 0,
    };
    let mut errors: Vec<PoseError> = Vec::new();
    // The start is known, as an agent knows it from its briefing.
    localizer.reset(prepared.world.start);
    let driven = drive(prepared, &tour, &mut |simulator, _| {
        let truth = Pose2::from_pose3(&simulator.base_link());
        sensors.show(&simulator.observation(), localizer);
        // Until then the pose is not meant to be trusted, so it is not judged.
        if localizer.ready() {
            let estimate = PoseEstimate {
                pose: localizer.pose(),
                health: localizer.health(),
            };
            errors.push(PoseError::new(simulator.time(), truth, estimate));
        }
        Ok(ControlFlow::Continue(()))
    })?;
    let good = errors.iter().filter(|error| error.health == Health::Good);
    Ok(DegradedResult {
        degradation,
        errors: localization(std::iter::once(&errors[..])),
        good: share(&errors, Health::Good),
        lost: share(&errors, Health::Lost),
        largest_good_m: good.map(PoseError::distance).fold(0.0, f64::max),
        metres: driven.metres,
    })
}

/// Share of poses with a health; 0 without poses.
fn share(errors: &[PoseError], health: Health) -> f64 {
    let count = errors.iter().filter(|error| error.health == health).count();
    count as f64 / errors.len().max(1) as f64
}

/// Degraded sensors.
struct Degraded {
    degradation: Degradation,
    noise: Noise,
    /// Number of IMU samples so far.
    samples: u64,
}

impl Degraded {
    /// Passes an observation to a localizer after degrading it.
    fn show(&mut self, observation: &Observation<'_>, localizer: &mut dyn Localizer) {
        // The angles of the wheels count from the start, so their radius must not change later.
        let has_wrong_wheels = matches!(self.degradation, Degradation::Wheels(_));
        if !has_wrong_wheels && observation.time.since(SimTime::ZERO) < INTACT {
            localizer.update(observation);
            return;
        }
        let imu: Vec<ImuSample> = observation
            .imu
            .iter()
            .map(|sample| self.imu(*sample))
            .collect();
        let wheels: Vec<WheelSample> = observation
            .wheels
            .iter()
            .map(|sample| self.wheels(*sample))
            .collect();
        let scan = observation.scan.map(|scan| self.scan(scan));
        localizer.update(&Observation {
            imu: &imu,
            wheels: &wheels,
            scan: scan.as_ref(),
            ..*observation
        });
    }

    fn normal(&mut self, deviation: f64) -> f64 {
        deviation * self.noise.normal()
    }

    fn imu(&mut self, mut sample: ImuSample) -> ImuSample {
        self.samples += 1;
        match self.degradation {
            Degradation::Noisy(factor) => {
                let added = added_noise(factor);
                let (gyro, accel) = (added * GYRO_NOISE_RAD_PER_S, added * ACCEL_NOISE_MPS2);
                sample.gyro = sample.gyro.map(|x| x + self.normal(gyro));
                sample.accel = sample.accel.map(|x| x + self.normal(accel));
            }
            Degradation::ImuShocks if self.samples % SHOCK_PERIOD_SAMPLES < SHOCK_SAMPLES => {
                sample.accel = sample.accel.map(|x| x + self.normal(SHOCK_ACCEL_MPS2));
                sample.gyro = sample.gyro.map(|x| x + self.normal(SHOCK_RATE_RAD_PER_S));
            }
            _ => {}
        }
        sample
    }

    fn wheels(&self, sample: WheelSample) -> WheelSample {
        match self.degradation {
            // Larger wheels turn less over the same distance.
            Degradation::Wheels(factor) => WheelSample {
                left: sample.left / factor,
                right: sample.right / factor,
                ..sample
            },
            _ => sample,
        }
    }

    fn scan(&mut self, scan: &LidarScan) -> LidarScan {
        let mut scan = scan.clone();
        let stamp = scan.stamp;
        match self.degradation {
            Degradation::Late(ms) => scan.stamp = stamp + Duration::from_millis(ms),
            Degradation::Blinded(degrees) if is_occluded(stamp) => {
                let half = degrees.to_radians() / 2.0;
                // Strictly less: at 0 degrees not even a point straight ahead is left.
                scan.points.retain(|point| bearing(point.xyz).abs() < half);
            }
            _ => scan
                .points
                .iter_mut()
                .for_each(|point| point.xyz = self.point(point.xyz)),
        }
        scan
    }

    fn point(&mut self, xyz: [f32; 3]) -> [f32; 3] {
        let at = Vector3::from(xyz.map(f64::from));
        let at = match self.degradation {
            Degradation::Noisy(factor) => {
                // Along the ray, as the error of a range is.
                let added = added_noise(factor) * RANGE_NOISE_M;
                // The lower bound avoids a division by zero for a point at the sensor.
                at * (1.0 + self.normal(added) / at.norm().max(0.1))
            }
            Degradation::Quantised(metres) => at.map(|x| (x / metres).round() * metres),
            Degradation::TurnedLidar(degrees) => seen_turned(at, Vector3::z_axis(), degrees),
            Degradation::PitchedLidar(degrees) => seen_turned(at, Vector3::y_axis(), degrees),
            _ => at,
        };
        at.cast::<f32>().into()
    }
}

/// A point as seen by a sensor that is turned about an axis: it turns the other way.
fn seen_turned(point: Vector3<f64>, axis: UnitVector3<f64>, degrees: f64) -> Vector3<f64> {
    Rotation3::from_axis_angle(&axis, degrees.to_radians()).inverse() * point
}

/// Noise to add, in standard deviations of the simulated noise, so that the sum has `factor` of
/// them.
fn added_noise(factor: f64) -> f64 {
    // Variances add, in units of the simulated one: 1 + added² = factor².
    (factor * factor - 1.0).max(0.0).sqrt()
}

/// Direction of a point from the sensor: radians, counter-clockwise from forward.
fn bearing([x, y, _]: [f32; 3]) -> f64 {
    libm::atan2(f64::from(y), f64::from(x))
}

fn is_occluded(time: SimTime) -> bool {
    let phase = time.since(SimTime::ZERO + INTACT).as_nanos() % OCCLUSION_PERIOD.as_nanos();
    phase >= (OCCLUSION_PERIOD - OCCLUSION).as_nanos()
}
