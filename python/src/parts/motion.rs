//! Costmaps, and planners that turn paths into velocities.

use std::sync::{Mutex, MutexGuard, PoisonError};

use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity, with_causes};
use openbench_motion::local::built_in::built_in;
use openbench_motion::local::make_planner;
use openbench_motion::{
    LocalPlanner, Obstacle, PlannerSettings, Progress, RangeRing, ScanPoint, Search, Situation,
    Vector2, plan,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::map::Map;
use crate::arrays::{Matrix, Rows, point_of, points_of, rows_of, to_array};
use crate::errors::{InputError, PlanningError};

/// The ground with the cost of driving over it.
#[pyclass(frozen)]
pub struct Costmap {
    costmap: Mutex<openbench_motion::Costmap>,
}

#[pymethods]
impl Costmap {
    /// An area of a map from its south-western corner to its north-eastern one.
    #[new]
    fn new(py: Python<'_>, map: &Map, low: (f64, f64), high: (f64, f64)) -> PyResult<Self> {
        let (low, high) = (point_of(low, "low")?, point_of(high, "high")?);
        let robot = RobotDescription::sentry();
        let map = &map.map;
        let costmap = py.detach(|| openbench_motion::Costmap::new(map, low, high, &robot));
        let costmap = costmap.map_err(|error| InputError::new_err(with_causes(&error)))?;
        Ok(Self {
            costmap: Mutex::new(costmap),
        })
    }

    /// Side of a cell, metres.
    #[getter]
    fn cell(&self, py: Python<'_>) -> f64 {
        py.detach(|| self.lock().grid().cell)
    }

    /// South-western corner of the first cell.
    #[getter]
    fn origin(&self, py: Python<'_>) -> (f64, f64) {
        let origin = py.detach(|| self.lock().grid().origin);
        (origin.x, origin.y)
    }

    /// Takes in the points (n, 3) of a scan in `map`, z above the ground, that was measured at
    /// `sensor` (x, y, z).
    fn observe(&self, py: Python<'_>, points: Rows<'_>, sensor: (f64, f64, f64)) -> PyResult<()> {
        let center = point_of((sensor.0, sensor.1), "sensor")?;
        if !sensor.2.is_finite() {
            return Err(PyValueError::new_err("sensor: NaN or infinity"));
        }
        let points = rows_of::<3>(&points, "points")?;
        py.detach(|| {
            let is_finite = |point: &&[f64; 3]| point.iter().all(|c| c.is_finite());
            let finite = points.iter().filter(is_finite);
            let seen = finite.map(|[x, y, z]| ScanPoint::new(MapPoint::new(*x, *y), *z));
            let mut costmap = self.lock();
            costmap.observe(&RangeRing::new(center, sensor.2, seen));
            costmap.inflate();
        });
        Ok(())
    }

    /// Cost of driving one metre through each cell, rows from the south; infinite where the robot
    /// does not fit.
    fn costs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (costs, shape) = py.detach(|| {
            let costmap = self.lock();
            let grid = *costmap.grid();
            let cost = |cell| costmap.cost(cell).map_or(f32::INFINITY, |cost| cost as f32);
            let costs: Vec<f32> = (0..grid.len()).map(cost).collect();
            (costs, [grid.height, grid.width])
        });
        costs.into_pyarray(py).reshape(shape)
    }

    /// The cheapest path (n, 2), by A*.
    fn plan<'py>(
        &self,
        py: Python<'py>,
        start: (f64, f64),
        goal: (f64, f64),
    ) -> PyResult<Matrix<'py>> {
        let (start, goal) = (point_of(start, "start")?, point_of(goal, "goal")?);
        let path = py.detach(|| plan(&mut Search::default(), &self.lock(), start, goal));
        let path = path.map_err(|error| PlanningError::new_err(with_causes(&error)))?;
        to_array(py, &path)
    }
}

impl Costmap {
    /// Locked only while Python's lock is released, so that two threads never wait for each other.
    fn lock(&self) -> MutexGuard<'_, openbench_motion::Costmap> {
        self.costmap.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What a robot must not touch: convex, perhaps with rounded corners, perhaps moving.
#[pyclass(frozen, name = "Obstacle")]
pub struct PyObstacle {
    obstacle: Obstacle,
}

#[pymethods]
impl PyObstacle {
    /// Corners (n, 2) in `map`, counter-clockwise: one of a disc, two of a wall. Without a velocity
    /// (m/s) it stands.
    #[new]
    #[pyo3(signature = (corners, rounding=0.0, velocity=None))]
    fn new(corners: Rows<'_>, rounding: f64, velocity: Option<(f64, f64)>) -> PyResult<Self> {
        let corners = points_of(&corners, "corners")?;
        let velocity = velocity.map_or(Vector2::ZERO, |(x, y)| Vector2::new(x, y));
        let obstacle = Obstacle::new(&corners, rounding, velocity);
        let obstacle = obstacle.map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(Self { obstacle })
    }
}

/// Turns a path into velocities.
#[pyclass(frozen, name = "LocalPlanner")]
pub struct PyLocalPlanner {
    planner: Mutex<Box<dyn LocalPlanner>>,
}

#[pymethods]
impl PyLocalPlanner {
    /// A planner by its name: teb, follower or mppi.
    #[new]
    #[pyo3(signature = (name="teb", seed=1))]
    fn new(name: &str, seed: u64) -> PyResult<Self> {
        let planners = built_in();
        let found = planners.find(name);
        let found = found.map_err(|error| InputError::new_err(error.to_string()))?;
        let settings = PlannerSettings::new(RobotDescription::sentry()).with_seed(seed);
        let planner = make_planner(found.entry, &settings);
        let planner = planner.map_err(|error| InputError::new_err(with_causes(&error)))?;
        Ok(Self {
            planner: Mutex::new(planner),
        })
    }

    /// The velocity to drive with now, or `None` at the end of the path.
    #[pyo3(signature = (time, pose, velocity, path, obstacles, final_yaw=None))]
    #[allow(clippy::too_many_arguments, reason = "arguments of Python")]
    fn plan(
        &self,
        py: Python<'_>,
        time: f64,
        pose: (f64, f64, f64),
        velocity: (f64, f64),
        path: Rows<'_>,
        obstacles: Vec<PyRef<'_, PyObstacle>>,
        final_yaw: Option<f64>,
    ) -> PyResult<Option<(f64, f64)>> {
        if !(0.0..1e9).contains(&time) {
            return Err(PyValueError::new_err("time: write seconds from 0"));
        }
        let path = points_of(&path, "path")?;
        let obstacles: Vec<Obstacle> = obstacles.iter().map(|o| o.obstacle.clone()).collect();
        let progress = py.detach(|| {
            let mut planner = self.planner.lock().unwrap_or_else(PoisonError::into_inner);
            planner.plan(&Situation {
                time: SimTime((time * 1e9) as u64),
                pose: Pose2::new(pose.0, pose.1, pose.2),
                velocity: Velocity::new(velocity.0, velocity.1),
                path: &path,
                final_yaw,
                obstacles: &obstacles,
            })
        });
        match progress.map_err(|error| PlanningError::new_err(error.to_string()))? {
            Progress::Arrived => Ok(None),
            Progress::Drive(Velocity { linear, angular })
            | Progress::Slowed(Velocity { linear, angular }, _) => Ok(Some((linear, angular))),
        }
    }

    /// Forgets what was planned before.
    fn reset(&self) {
        let mut planner = self.planner.lock().unwrap_or_else(PoisonError::into_inner);
        planner.reset();
    }
}
