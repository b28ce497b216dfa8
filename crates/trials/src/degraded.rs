//! Drives with sensors that are worse than believed: a localizer may be off then, but it has to say
//! so.

use std::fmt;
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
use openbench_bench::score::metrics::localization::localization;
use openbench_bench::score::metrics::{LocalizationSum, PoseError};
use openbench_bench::{BenchError, Prepared};

/// What the robot's data sheets say of a sample: metres, rad/s, m/s².
const RANGE: f64 = 0.02;
const GYRO: f64 = 5.6e-4;
const ACCEL: f64 = 7e-3;
/// Sensors are sound for so long at first, as when a robot is switched on in its garage.
const SOUND: Duration = Duration::from_secs(5);
/// The LiDAR is blind for so long, once in [`TROUBLE`].
const BLIND: Duration = Duration::from_secs(15);
const TROUBLE: Duration = Duration::from_secs(45);
/// A jerk every so many samples of the IMU lasts so many of them and is that large, m/s² and rad/s.
const JERK: (u64, u64, f64, f64) = (311, 3, 60.0, 6.0);
/// Stream of random numbers, beside those of sensors, traffic and tour.
const STREAM: u64 = 53;

/// What is wrong with the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Degradation {
    /// Nothing.
    None,
    /// LiDAR and IMU are so many times as noisy as their data sheets say.
    Noisy(f64),
    /// Coordinates of points are multiples of so many metres, as after a detour through single
    /// precision.
    Quantised(f64),
    /// The LiDAR sees a sector of so many degrees only, for 15 s in 45.
    Blinded(f64),
    /// The IMU is hit every three seconds.
    Jerked,
    /// The LiDAR is turned about the upright axis by so many degrees more than is believed.
    TurnedLidar(f64),
    /// The LiDAR leans forward by so many degrees more than is believed.
    LeaningLidar(f64),
    /// The wheels are so many times as large as is believed.
    Wheels(f64),
    /// The LiDAR's scans are stamped so many milliseconds too late.
    Late(u64),
}

/// All that is tried.
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
    Degradation::Jerked,
    Degradation::TurnedLidar(1.0),
    Degradation::TurnedLidar(5.0),
    Degradation::LeaningLidar(1.0),
    Degradation::LeaningLidar(5.0),
    Degradation::Wheels(1.05),
    Degradation::Wheels(1.5),
    Degradation::Late(50),
    Degradation::Late(150),
];

impl fmt::Display for Degradation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("sound sensors"),
            Self::Noisy(times) => write!(f, "noise x {times}"),
            Self::Quantised(metres) => write!(f, "points in steps of {metres} m"),
            Self::Blinded(degrees) => write!(f, "LiDAR sees {degrees} degrees, 15 s in 45"),
            Self::Jerked => f.write_str("IMU hit every 3 s"),
            Self::TurnedLidar(degrees) => write!(f, "LiDAR turned by {degrees} degrees"),
            Self::LeaningLidar(degrees) => write!(f, "LiDAR leaning by {degrees} degrees"),
            Self::Wheels(times) => write!(f, "wheels x {times}"),
            Self::Late(ms) => write!(f, "LiDAR stamped {ms} ms late"),
        }
    }
}

/// How it went with one kind of trouble.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// What was wrong.
    pub degradation: Degradation,
    /// Errors of the poses; null if none was told.
    pub errors: Option<LocalizationSum>,
    /// Share of poses that were called good.
    pub good: f64,
    /// Share of poses that were called lost.
    pub lost: f64,
    /// The largest error of a pose that was called good, metres.
    pub largest_good_m: f64,
    /// Metres driven.
    pub metres: f64,
}

/// Drives of `time` with each kind of trouble, the same way each time.
pub fn trials(
    prepared: &Prepared,
    seed: u64,
    time: Duration,
    threads: usize,
    make: &(dyn Fn() -> Box<dyn Localizer> + Sync),
) -> Result<Vec<Trial>, BenchError> {
    let one = |i: usize| trial(prepared, seed, time, ALL[i], make().as_mut());
    threads::each(0..ALL.len(), threads, one, Ok)
}

/// A drive with one kind of trouble.
pub fn trial(
    prepared: &Prepared,
    seed: u64,
    time: Duration,
    degradation: Degradation,
    localizer: &mut dyn Localizer,
) -> Result<Trial, BenchError> {
    let tour = Tour {
        time,
        via: Vec::new(),
        style: Style::Smooth,
        seed,
    };
    let mut sensors = Degraded {
        degradation,
        noise: Noise::new(seed, STREAM),
        samples: 0,
    };
    let mut errors: Vec<PoseError> = Vec::new();
    localizer.reset(prepared.world.start);
    let driven = drive(prepared, &tour, &mut |simulator, _| {
        let truth = Pose2::from_pose3(&simulator.base_link());
        sensors.show(&simulator.observation(), localizer);
        if localizer.ready() {
            let told = PoseEstimate {
                pose: localizer.pose(),
                health: localizer.health(),
            };
            errors.push(PoseError::new(simulator.time(), truth, told));
        }
        Ok(())
    })?;
    let share = |health: Health| {
        errors.iter().filter(|error| error.health == health).count() as f64
            / errors.len().max(1) as f64
    };
    let good = errors.iter().filter(|error| error.health == Health::Good);
    Ok(Trial {
        degradation,
        errors: localization(std::iter::once(&errors[..])),
        good: share(Health::Good),
        lost: share(Health::Lost),
        largest_good_m: good.map(PoseError::distance).fold(0.0, f64::max),
        metres: driven.metres,
    })
}

/// Sensors with something wrong.
struct Degraded {
    degradation: Degradation,
    noise: Noise,
    /// Samples of the IMU so far.
    samples: u64,
}

impl Degraded {
    /// Shows an observation to a localizer as the sensors have it.
    fn show(&mut self, observation: &Observation<'_>, localizer: &mut dyn Localizer) {
        // Wheels are as large as they are from the start: their angles count from there.
        let grown = matches!(self.degradation, Degradation::Wheels(_));
        if !grown && observation.time.since(SimTime::ZERO) < SOUND {
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
            Degradation::Noisy(times) => {
                let more = (times * times - 1.0).max(0.0).sqrt();
                sample.gyro = sample.gyro.map(|x| x + self.normal(more * GYRO));
                sample.accel = sample.accel.map(|x| x + self.normal(more * ACCEL));
            }
            Degradation::Jerked if self.samples % JERK.0 < JERK.1 => {
                sample.accel = sample.accel.map(|x| x + self.normal(JERK.2));
                sample.gyro = sample.gyro.map(|x| x + self.normal(JERK.3));
            }
            _ => {}
        }
        sample
    }

    fn wheels(&self, sample: WheelSample) -> WheelSample {
        match self.degradation {
            // Smaller angles for the same way.
            Degradation::Wheels(times) => WheelSample {
                left: sample.left / times,
                right: sample.right / times,
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
            Degradation::Blinded(degrees) if is_in_trouble(stamp) => {
                let half = degrees.to_radians() / 2.0;
                let is_seen =
                    |xyz: &[f32; 3]| libm::atan2(f64::from(xyz[1]), f64::from(xyz[0])).abs() < half;
                scan.points.retain(|point| is_seen(&point.xyz));
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
        let turned = |axis: UnitVector3<f64>, degrees: f64| {
            Rotation3::from_axis_angle(&axis, degrees.to_radians()).inverse() * at
        };
        let at = match self.degradation {
            Degradation::Noisy(times) => {
                let more = (times * times - 1.0).max(0.0).sqrt() * RANGE;
                at * (1.0 + self.normal(more) / at.norm().max(0.1))
            }
            Degradation::Quantised(metres) => at.map(|x| (x / metres).round() * metres),
            Degradation::TurnedLidar(degrees) => turned(Vector3::z_axis(), degrees),
            Degradation::LeaningLidar(degrees) => turned(Vector3::y_axis(), degrees),
            _ => at,
        };
        at.cast::<f32>().into()
    }
}

fn is_in_trouble(time: SimTime) -> bool {
    let since = time.since(SimTime::ZERO + SOUND).as_nanos() % TROUBLE.as_nanos();
    since >= (TROUBLE - BLIND).as_nanos()
}
