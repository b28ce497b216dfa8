//! What a policy sees and does in a run, as in the environment in which it was trained.

use std::slice;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use numpy::{AllowTypeChange, PyArrayLike1};
use openbench_core::{
    Camera, Image, ImuSample, LidarPoint, LidarScan, Observation, Pose2, RobotDescription, SimTime,
    WheelSample,
};
use openbench_environment::Adapter;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Rows, point_of, rows_of};
use crate::environment::{PyOptions, arrays};
use crate::errors::{InputError, of_environment};

/// Between a policy and the sensor data of a run. Images are left to Python.
#[pyclass(frozen, name = "Adapter")]
pub struct PyAdapter {
    adapter: Mutex<Adapter>,
    options: PyOptions,
}

/// The time of the first ray in seconds, points (n, 3), and their times (n,) after the first.
type ScanArrays<'py> = (f64, Rows<'py>, PyArrayLike1<'py, f64, AllowTypeChange>);

#[pymethods]
impl PyAdapter {
    #[new]
    fn new(
        options: &PyOptions,
        robot: &str,
        start: [f64; 3],
        goal: Option<(f64, f64)>,
    ) -> PyResult<Self> {
        let robot: RobotDescription = serde_json::from_str(robot)
            .map_err(|error| InputError::new_err(format!("robot: {error}")))?;
        let [x, y, yaw] = start;
        let goal = goal.map(|goal| point_of(goal, "goal")).transpose()?;
        let adapter = Adapter::new(options.options(), &robot, Pose2::new(x, y, yaw), goal);
        Ok(Self {
            adapter: Mutex::new(adapter.map_err(|error| of_environment(&error))?),
            options: options.clone(),
        })
    }

    /// Whether scans are needed.
    #[getter]
    fn wants_scans(&self) -> bool {
        self.options.options().observe.needs_scans()
    }

    /// Takes in what was sensed during a step: samples of the IMU (n, 7), of the wheels (n, 3), and
    /// a scan.
    fn take(
        &self,
        py: Python<'_>,
        time: f64,
        imu: Rows<'_>,
        wheels: Rows<'_>,
        scan: Option<ScanArrays<'_>>,
    ) -> PyResult<()> {
        let imu = rows_of::<7>(&imu, "imu")?;
        let imu: Vec<ImuSample> = imu.into_iter().map(imu_sample).collect();
        let wheels = rows_of::<3>(&wheels, "wheels")?;
        let wheels: Vec<WheelSample> = wheels.into_iter().map(wheel_sample).collect();
        let scan = scan.map(scan_of).transpose()?;
        py.detach(|| {
            self.lock().take(&Observation {
                time: instant(time),
                imu: &imu,
                wheels: &wheels,
                scan: scan.as_ref(),
                gnss: None,
                camera: &NoCamera,
            });
        });
        Ok(())
    }

    /// Whether there is something to see, and a pose; until then the robot should stand.
    fn is_ready(&self, time: f64) -> bool {
        self.lock().is_ready(instant(time))
    }

    /// Where the robot takes itself to be, if that is observed: x, y, yaw.
    #[getter]
    fn pose(&self) -> Option<(f64, f64, f64)> {
        let pose = self.lock().estimate()?.pose;
        Some((pose.x, pose.y, pose.yaw))
    }

    /// What the policy gets, with a first axis of one; an image is black.
    fn observation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let observation = self.lock().observation();
        arrays(py, &self.options, slice::from_ref(&observation))
    }

    /// Begins an action.
    fn begin(&self, action: [f64; 2]) -> PyResult<()> {
        if !action.iter().all(|number| number.is_finite()) {
            return Err(PyValueError::new_err("action: NaN or infinity"));
        }
        self.lock().begin(action);
        Ok(())
    }

    /// The velocity of the next step of the action: m/s, rad/s.
    fn velocity(&self, time: f64) -> (f64, f64) {
        let velocity = self.lock().velocity(instant(time));
        (velocity.linear, velocity.angular)
    }
}

impl PyAdapter {
    fn lock(&self) -> MutexGuard<'_, Adapter> {
        self.adapter.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Images stay in Python.
struct NoCamera;

impl Camera for NoCamera {
    fn image(&self) -> Option<Arc<Image>> {
        None
    }
}

/// An instant in seconds. Negative ones and those that are no number are the first.
fn instant(seconds: f64) -> SimTime {
    SimTime((seconds * 1e9).round() as u64)
}

fn imu_sample([stamp, p, q, r, x, y, z]: [f64; 7]) -> ImuSample {
    ImuSample {
        stamp: instant(stamp),
        gyro: [p, q, r],
        accel: [x, y, z],
    }
}

fn wheel_sample([stamp, left, right]: [f64; 3]) -> WheelSample {
    WheelSample {
        stamp: instant(stamp),
        left,
        right,
    }
}

fn scan_of((stamp, points, offsets): ScanArrays<'_>) -> PyResult<LidarScan> {
    let points = rows_of::<3>(&points, "points")?;
    let offsets = offsets.as_array();
    if points.len() != offsets.len() {
        let problem = format!("{} points have {} offsets", points.len(), offsets.len());
        return Err(PyValueError::new_err(problem));
    }
    let point = |(xyz, offset): ([f64; 3], &f64)| LidarPoint {
        xyz: xyz.map(|number| number as f32),
        offset_ns: (offset * 1e9).round() as u32,
        reflectivity: 0,
        line: 0,
    };
    Ok(LidarScan {
        stamp: instant(stamp),
        points: points.into_iter().zip(offsets).map(point).collect(),
    })
}
