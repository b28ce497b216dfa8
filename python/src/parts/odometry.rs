//! LiDAR-inertial odometry on arrays.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use nalgebra::{Matrix4, Vector3};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1};
use openbench_core::{ImuSample, LidarPoint, LidarScan, Pose3, RobotDescription, SimTime};
use openbench_localization::lidar_inertial::sensor_settings;
use openbench_localization::lio::{Estimate, LidarInertialOdometry, Settings, Speed, Status};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{Matrix, Rows, rows_of};

/// How sensors have moved since the start.
#[pyclass(frozen)]
pub struct Odometry {
    odometry: Mutex<LidarInertialOdometry>,
}

#[pymethods]
impl Odometry {
    /// For the benchmark's robot, or for sensors that are mounted elsewhere: poses (4, 4) of the
    /// IMU in the body, and of the LiDAR in the IMU's frame.
    #[new]
    #[pyo3(signature = (
        imu=None, lidar=None, *, gyro_noise=None, accel_noise=None, range_noise=None,
        angle_noise=None, typical_speed=None, min_range=None
    ))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        imu: Option<Rows<'_>>,
        lidar: Option<Rows<'_>>,
        gyro_noise: Option<f64>,
        accel_noise: Option<f64>,
        range_noise: Option<f64>,
        angle_noise: Option<f64>,
        typical_speed: Option<f64>,
        min_range: Option<f64>,
    ) -> PyResult<Self> {
        let mut settings: Settings = sensor_settings(&RobotDescription::sentry());
        if let Some(imu) = imu {
            settings.imu = pose_of(&imu, "imu")?;
        }
        if let Some(lidar) = lidar {
            settings.lidar = pose_of(&lidar, "lidar")?;
        }
        let numbers = [
            (&mut settings.imu_noise.gyro, gyro_noise, "gyro_noise"),
            (&mut settings.imu_noise.accel, accel_noise, "accel_noise"),
            (&mut settings.lidar_noise.range, range_noise, "range_noise"),
            (&mut settings.lidar_noise.angle, angle_noise, "angle_noise"),
            (
                &mut settings.typical_speed_m_s,
                typical_speed,
                "typical_speed",
            ),
            (&mut settings.min_range_m, min_range, "min_range"),
        ];
        for (setting, given, name) in numbers {
            if let Some(number) = given {
                if !(number > 0.0 && number < 1e3) {
                    let problem = format!("{name}: write a positive number");
                    return Err(PyValueError::new_err(problem));
                }
                *setting = number;
            }
        }
        Ok(Self {
            odometry: Mutex::new(LidarInertialOdometry::new(settings)),
        })
    }

    /// Takes in samples of the IMU: times (n,) in nanoseconds, turn rates (n, 3) in rad/s and
    /// specific forces (n, 3) in m/s².
    fn imu(
        &self,
        py: Python<'_>,
        stamps: &Bound<'_, PyAny>,
        gyro: Rows<'_>,
        accel: Rows<'_>,
    ) -> PyResult<Vec<PyEstimate>> {
        let (gyro, accel) = (rows_of::<3>(&gyro, "gyro")?, rows_of::<3>(&accel, "accel")?);
        let stamps = nanoseconds(stamps, "stamps")?;
        same_length("gyro", stamps.len(), gyro.len())?;
        same_length("accel", stamps.len(), accel.len())?;
        Ok(py.detach(|| {
            let samples = stamps.into_iter().zip(gyro).zip(accel);
            let samples = samples.map(|((stamp, gyro), accel)| ImuSample {
                stamp: SimTime(stamp),
                gyro,
                accel,
            });
            let mut odometry = self.lock();
            let estimates = samples.flat_map(|sample| odometry.imu(sample));
            estimates.map(PyEstimate).collect()
        }))
    }

    /// Takes in a scan: the time of its first ray in nanoseconds, points (n, 3) in metres in the
    /// LiDAR's frame, each as seen at its own time, and that time (n,) in nanoseconds after the
    /// first.
    fn scan(
        &self,
        py: Python<'_>,
        stamp: u64,
        points: Rows<'_>,
        offsets: &Bound<'_, PyAny>,
    ) -> PyResult<Vec<PyEstimate>> {
        let points = rows_of::<3>(&points, "points")?;
        let offsets = nanoseconds(offsets, "offsets")?;
        same_length("offsets", points.len(), offsets.len())?;
        if offsets.iter().any(|offset| u32::try_from(*offset).is_err()) {
            return Err(PyValueError::new_err("offsets: a scan lasts 4 s at most"));
        }
        Ok(py.detach(|| {
            let points = points.into_iter().zip(offsets);
            let points = points.map(|(xyz, offset)| LidarPoint {
                xyz: xyz.map(|number| number as f32),
                offset_ns: offset as u32,
                reflectivity: 0,
                line: 0,
            });
            let scan = LidarScan {
                stamp: SimTime(stamp),
                points: points.collect(),
            };
            let estimates = self.lock().scan(scan);
            estimates.into_iter().map(PyEstimate).collect()
        }))
    }

    /// Takes in a velocity (3,) of the body by its wheels, in m/s in its own frame, with standard
    /// deviations (3,), and its turn rate in rad/s.
    fn speed(
        &self,
        py: Python<'_>,
        stamp: u64,
        velocity: [f64; 3],
        deviation: [f64; 3],
        turn: f64,
    ) {
        let speed = Speed {
            stamp: SimTime(stamp),
            velocity: Vector3::from(velocity),
            deviation: Vector3::from(deviation),
            turn,
        };
        py.detach(|| self.lock().speed(speed));
    }

    /// How much input could not be used: samples of the IMU, scans, speeds and points.
    #[getter]
    fn refused(&self, py: Python<'_>) -> BTreeMap<&'static str, usize> {
        let refused = py.detach(|| self.lock().refused());
        BTreeMap::from([
            ("imu", refused.imu),
            ("scans", refused.scans),
            ("speeds", refused.speeds),
            ("points", refused.points),
        ])
    }
}

impl Odometry {
    /// Locked only while Python's lock is released, so that two threads never wait for each other.
    fn lock(&self) -> MutexGuard<'_, LidarInertialOdometry> {
        self.odometry.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Times (n,) in nanoseconds. Numbers with fractions are refused: they would be seconds.
///
/// # Errors
/// `ValueError` that names the argument.
fn nanoseconds(given: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<u64>> {
    let array = given
        .py()
        .import("numpy")?
        .call_method1("asarray", (given,))?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    let is_empty = array.getattr("size")?.extract::<usize>()? == 0;
    if !is_empty && kind != "i" && kind != "u" {
        let problem = format!("{name}: write integers, nanoseconds");
        return Err(PyValueError::new_err(problem));
    }
    let array = array.call_method1("astype", ("int64",))?;
    let array: PyReadonlyArray1<'_, i64> = array.extract()?;
    let times = array.as_array().to_vec().into_iter().map(u64::try_from);
    let times: Result<Vec<u64>, _> = times.collect();
    times.map_err(|_| PyValueError::new_err(format!("{name}: a time is negative")))
}

fn same_length(name: &str, expected: usize, found: usize) -> PyResult<()> {
    if expected == found {
        return Ok(());
    }
    let problem = format!("{name}: {found} rows instead of {expected}");
    Err(PyValueError::new_err(problem))
}

/// A pose of a matrix (4, 4).
fn pose_of(rows: &Rows<'_>, name: &str) -> PyResult<Pose3> {
    let rows = rows_of::<4>(rows, name)?;
    let problem = || PyValueError::new_err(format!("{name}: write a pose as a 4 x 4 matrix"));
    if rows.len() != 4 || !rows.iter().flatten().all(|number| number.is_finite()) {
        return Err(problem());
    }
    let matrix = Matrix4::from_fn(|row, column| rows[row][column]);
    let rotation = matrix.fixed_view::<3, 3>(0, 0).into_owned();
    let error = (rotation * rotation.transpose() - nalgebra::Matrix3::identity())
        .abs()
        .max();
    if error > 1e-6 || rotation.determinant() < 0.0 || rows[3] != [0.0, 0.0, 0.0, 1.0] {
        return Err(problem());
    }
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(rotation);
    let translation = matrix.fixed_view::<3, 1>(0, 3).into_owned();
    Ok(Pose3::from_parts(translation.into(), rotation.into()))
}

/// Where the body was at the end of a scan.
#[pyclass(frozen, name = "Estimate")]
pub struct PyEstimate(Estimate);

#[pymethods]
impl PyEstimate {
    /// Nanoseconds.
    #[getter]
    fn stamp(&self) -> u64 {
        self.0.stamp.0
    }

    /// Pose (4, 4) of the body in the frame of its start, z up.
    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        // Matrices are stored by columns.
        let rows = self.0.pose.to_homogeneous().transpose();
        rows.as_slice().to_vec().into_pyarray(py).reshape([4, 4])
    }

    /// Velocity (3,) of the IMU in that frame, m/s.
    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.velocity.as_slice().to_vec().into_pyarray(py)
    }

    /// Covariance (6, 6) of the IMU's pose: rotation in its own frame, then position; rad², m².
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        // It is symmetric.
        self.0
            .covariance
            .as_slice()
            .to_vec()
            .into_pyarray(py)
            .reshape([6, 6])
    }

    /// How far it can be trusted: tracking, disputed, noisy, coasting or lost.
    #[getter]
    fn status(&self) -> &'static str {
        match self.0.status {
            Status::Tracking => "tracking",
            Status::Disputed => "disputed",
            Status::Noisy => "noisy",
            Status::Coasting => "coasting",
            Status::Lost => "lost",
            // A kind that is added later.
            _ => "unknown",
        }
    }

    /// Points that lay on known planes.
    #[getter]
    fn points(&self) -> usize {
        self.0.points
    }
}
