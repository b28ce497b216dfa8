//! LiDAR-inertial odometry on arrays.

use nalgebra::{Matrix4, Vector3};
use numpy::{AllowTypeChange, IntoPyArray, PyArray1, PyArrayLike1, PyArrayMethods};
use openbench_core::{ImuSample, LidarPoint, LidarScan, Pose3, RobotDescription, SimTime};
use openbench_localization::lidar_inertial::sensor_settings;
use openbench_localization::lio::{Estimate, LidarInertialOdometry, Settings, Speed, Status};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::arrays::{Matrix, Rows, rows_of};

/// Times in nanoseconds.
type Stamps<'py> = PyArrayLike1<'py, u64, AllowTypeChange>;

/// How sensors have moved since the start.
#[pyclass]
pub struct Odometry {
    odometry: LidarInertialOdometry,
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
            odometry: LidarInertialOdometry::new(settings),
        })
    }

    /// Takes in samples of the IMU: times (n,) in nanoseconds, turn rates (n, 3) in rad/s and
    /// specific forces (n, 3) in m/s².
    fn imu(
        &mut self,
        py: Python<'_>,
        stamps: Stamps<'_>,
        gyro: Rows<'_>,
        accel: Rows<'_>,
    ) -> PyResult<Vec<PyEstimate>> {
        let (gyro, accel) = (rows_of::<3>(&gyro, "gyro")?, rows_of::<3>(&accel, "accel")?);
        let stamps: Vec<u64> = stamps.as_array().to_vec();
        same_length("gyro", stamps.len(), gyro.len())?;
        same_length("accel", stamps.len(), accel.len())?;
        Ok(py.detach(|| {
            let samples = stamps.into_iter().zip(gyro).zip(accel);
            let samples = samples.map(|((stamp, gyro), accel)| ImuSample {
                stamp: SimTime(stamp),
                gyro,
                accel,
            });
            let estimates = samples.flat_map(|sample| self.odometry.imu(sample));
            estimates.map(PyEstimate).collect()
        }))
    }

    /// Takes in a scan: the time of its first ray in nanoseconds, points (n, 3) in metres in the
    /// LiDAR's frame, each as seen at its own time, and that time (n,) in nanoseconds after the
    /// first.
    fn scan(
        &mut self,
        py: Python<'_>,
        stamp: u64,
        points: Rows<'_>,
        offsets: Stamps<'_>,
    ) -> PyResult<Vec<PyEstimate>> {
        let points = rows_of::<3>(&points, "points")?;
        let offsets: Vec<u64> = offsets.as_array().to_vec();
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
            let estimates = self.odometry.scan(scan);
            estimates.into_iter().map(PyEstimate).collect()
        }))
    }

    /// Takes in a velocity (3,) of the body by its wheels, in m/s in its own frame, with standard
    /// deviations (3,), and its turn rate in rad/s.
    fn speed(&mut self, stamp: u64, velocity: [f64; 3], deviation: [f64; 3], turn: f64) {
        self.odometry.speed(Speed {
            stamp: SimTime(stamp),
            velocity: Vector3::from(velocity),
            deviation: Vector3::from(deviation),
            turn,
        });
    }
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
