//! Environments for learners: one, or several on threads of their own.

use std::collections::BTreeMap;
use std::num::NonZeroU32;
use std::slice;
use std::sync::{Mutex, MutexGuard, TryLockError};

use numpy::ndarray::ArrayView1;
use numpy::{IntoPyArray, PyArray1, PyArray3, PyArray4, PyArrayMethods, PyReadonlyArray2};
use openbench_bench::suite::GoalKind;
use openbench_core::{Goal, Health};
use openbench_environment::{
    Actions, AfterEnd, Beginning, Declaration, Environment, Environments, Observation, Observe,
    Options, PoseSource, RangeImage, ResettingStep, Rewards, StartDistance, World,
};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::errors::{InputError, of_environment};
use crate::suite::WrittenSuite;

/// Most points of a scan: its rays.
const MAX_POINTS: usize = 20_000;
/// Columns and rows of the robot's camera.
const IMAGE: (usize, usize) = (640, 480);

/// What an environment observes, asks and rewards.
#[pyclass(frozen, name = "EnvironmentOptions")]
#[derive(Clone)]
pub struct PyOptions {
    options: Options,
    /// Whether the estimated pose is among the arrays; a goal is seen from it, too.
    shows_pose: bool,
    shows_goal: bool,
}

#[pymethods]
impl PyOptions {
    #[new]
    #[pyo3(signature = (
        *, observations, goal, start, steps, actions, arrival, rewards, range_image,
        one_firing_in, pose, time_limit
    ))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords")]
    fn new(
        observations: Vec<String>,
        goal: &str,
        start: Option<(f64, f64)>,
        steps: u32,
        actions: &str,
        arrival: Option<f64>,
        rewards: BTreeMap<String, f64>,
        range_image: (usize, usize),
        one_firing_in: u32,
        pose: &str,
        time_limit: Option<f64>,
    ) -> PyResult<Self> {
        let (rows, columns) = range_image;
        let size = RangeImage { rows, columns };
        let mut observe = observe(&observations, size, pose)?;
        let refuse_none = || InputError::new_err("one_firing_in: write 1 to 100");
        observe.one_firing_in = NonZeroU32::new(one_firing_in).ok_or_else(refuse_none)?;
        let options = Options {
            observe,
            goal: match goal {
                "instruction" => GoalKind::Instruction,
                "point" => GoalKind::Point,
                _ => return Err(refused("goal", goal, "instruction, point")),
            },
            start: start.map(|(least, largest)| StartDistance { least, largest }),
            steps_per_action: steps,
            actions: match actions {
                "velocity" => Actions::Velocity,
                "waypoint" => Actions::Waypoint,
                _ => return Err(refused("actions", actions, "velocity, waypoint")),
            },
            declaration: arrival.map_or(Declaration::Policy, Declaration::Arrival),
            rewards: weights(&rewards)?,
            time_limit_s: time_limit,
        };
        options.check().map_err(|error| of_environment(&error))?;
        let is_asked = |name: &str| observations.iter().any(|asked| asked == name);
        let shows_goal = is_asked("goal");
        if shows_goal && options.goal != GoalKind::Point {
            return Err(InputError::new_err(
                "observations: \"goal\" is a place, which needs goal=\"point\"; an instruction \
                 is in `info`",
            ));
        }
        Ok(Self {
            options,
            shows_pose: is_asked("pose"),
            shows_goal,
        })
    }
}

impl PyOptions {
    pub fn options(&self) -> &Options {
        &self.options
    }
}

fn observe(names: &[String], size: RangeImage, pose: &str) -> PyResult<Observe> {
    let mut observe = Observe::default();
    let source = match pose {
        "wheels" => PoseSource::Wheels,
        "odometry" => PoseSource::Odometry,
        _ => return Err(refused("pose", pose, "wheels, odometry")),
    };
    for name in names {
        match name.as_str() {
            "image" => observe.image = true,
            "points" => observe.points = true,
            "range_image" => observe.range_image = Some(size),
            "imu" => observe.imu = true,
            "wheels" => observe.wheels = true,
            // A goal is seen from an estimated pose.
            "pose" | "goal" => observe.pose = Some(source),
            _ => {
                let known = "image, points, range_image, imu, wheels, pose, goal";
                return Err(refused("observations", name, known));
            }
        }
    }
    Ok(observe)
}

fn weights(given: &BTreeMap<String, f64>) -> PyResult<Rewards> {
    let mut rewards = Rewards::default();
    for (name, weight) in given {
        *match name.as_str() {
            "progress" => &mut rewards.progress,
            "success" => &mut rewards.success,
            "failure" => &mut rewards.failure,
            "contact" => &mut rewards.contact,
            "time" => &mut rewards.time,
            _ => {
                let known = "progress, success, failure, contact, time";
                return Err(refused("rewards", name, known));
            }
        } = *weight;
    }
    Ok(rewards)
}

fn refused(option: &str, value: &str, known: &str) -> PyErr {
    InputError::new_err(format!("{option}: there is no {value:?}; known: {known}"))
}

/// A value that one thread of one process uses.
struct Owned<T> {
    value: Mutex<Option<T>>,
    process: u32,
}

impl<T> Owned<T> {
    fn new(value: T) -> Self {
        Self {
            value: Mutex::new(Some(value)),
            process: std::process::id(),
        }
    }

    /// The value, unless it is in use, closed, or of a process that forked.
    fn lock(&self) -> PyResult<Held<'_, T>> {
        if self.process != std::process::id() {
            return Err(PyRuntimeError::new_err(
                "this environment belongs to the process that made it: make it after the fork, or \
                 start processes by spawn or forkserver",
            ));
        }
        let guard = self.guard()?;
        if guard.is_none() {
            return Err(PyRuntimeError::new_err("this environment is closed"));
        }
        Ok(Held(guard))
    }

    /// Drops the value. In a process that forked it has no threads, and stays.
    fn close(&self) -> PyResult<()> {
        if self.process == std::process::id() {
            *self.guard()? = None;
        }
        Ok(())
    }

    fn guard(&self) -> PyResult<MutexGuard<'_, Option<T>>> {
        match self.value.try_lock() {
            Ok(guard) => Ok(guard),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err(
                "this environment is in use by another thread",
            )),
        }
    }
}

/// A value that is there while this is held.
struct Held<'a, T>(MutexGuard<'a, Option<T>>);

impl<T> Held<'_, T> {
    fn get(&mut self) -> PyResult<&mut T> {
        self.0
            .as_mut()
            .ok_or_else(|| PyRuntimeError::new_err("this environment is closed"))
    }
}

/// Several environments in one world, on threads of their own.
#[pyclass(frozen, name = "Environments")]
pub struct PyEnvironments {
    environments: Owned<Environments>,
    options: PyOptions,
}

#[pymethods]
impl PyEnvironments {
    #[new]
    fn new(
        py: Python<'_>,
        suite: WrittenSuite,
        options: &PyOptions,
        count: usize,
        threads: usize,
        autoreset: bool,
    ) -> PyResult<Self> {
        let options = options.clone();
        let after_end = if autoreset {
            AfterEnd::Reset
        } else {
            AfterEnd::Wait
        };
        let environments = py.detach(|| {
            let world = World::new(suite.suite()?, &options.options)?;
            Environments::new(&world, &options.options, count, threads, after_end)
        });
        Ok(Self {
            environments: Owned::new(environments.map_err(|error| of_environment(&error))?),
            options,
        })
    }

    /// Ends all threads; what follows raises.
    fn close(&self) -> PyResult<()> {
        self.environments.close()
    }

    /// Begins episodes: for each environment `None`, or its seed and the number of its episode.
    /// Returns the observations of those that began, in their order.
    fn reset<'py>(
        &self,
        py: Python<'py>,
        beginnings: Vec<Option<(Option<u64>, Option<usize>)>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mut held = self.environments.lock()?;
        let environments = held.get()?;
        let beginning = |(seed, episode)| Beginning { seed, episode };
        let beginnings: Vec<_> = beginnings.into_iter().map(|b| b.map(beginning)).collect();
        let begun = py.detach(|| environments.reset(&beginnings));
        let begun = begun.map_err(|error| of_environment(&error))?;
        let begun: Vec<Observation> = begun.into_iter().flatten().collect();
        arrays(py, &self.options, &begun)
    }

    /// A step of each environment, by rows of linear velocity, angular velocity and declaration.
    fn step<'py>(
        &self,
        py: Python<'py>,
        actions: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Stepped<'py>> {
        let actions = rows(&actions)?;
        let mut held = self.environments.lock()?;
        let environments = held.get()?;
        if actions.len() != environments.count() {
            return Err(PyValueError::new_err(format!(
                "there are {} environments and {} actions",
                environments.count(),
                actions.len()
            )));
        }
        let steps = py.detach(|| environments.step(&actions));
        let steps = steps.map_err(|error| of_environment(&error))?;
        stepped(py, &self.options, steps)
    }

    /// Lets one environment begin a step.
    fn send(&self, index: usize, action: [f64; 3]) -> PyResult<()> {
        let mut held = self.environments.lock()?;
        let sent = held.get()?.send(index, action);
        sent.map_err(|error| of_environment(&error))
    }

    /// Waits for the first `count` steps that are done; returns the numbers of their environments
    /// and what `step` returns, in the order in which they were done.
    fn receive<'py>(
        &self,
        py: Python<'py>,
        count: usize,
    ) -> PyResult<(Bound<'py, PyArray1<i64>>, Stepped<'py>)> {
        let mut held = self.environments.lock()?;
        let environments = held.get()?;
        let received = py.detach(|| environments.receive(count));
        let received = received.map_err(|error| of_environment(&error))?;
        let (numbers, steps): (Vec<usize>, Vec<ResettingStep>) = received.into_iter().unzip();
        let numbers: Vec<i64> = numbers.into_iter().map(|number| number as i64).collect();
        let stepped = stepped(py, &self.options, steps)?;
        Ok((numbers.into_pyarray(py), stepped))
    }

    /// What is known of the running episode of one environment: its instruction, its open address,
    /// each empty if there is none, and its simulated time in seconds.
    fn episode(&self, index: usize) -> PyResult<(String, String, f64)> {
        let mut held = self.environments.lock()?;
        let environment = idle(held.get()?, index)?;
        let instruction = match environment.briefing().map(|briefing| &briefing.goal) {
            Some(Goal::Instruction(text)) => text.clone(),
            Some(Goal::Point(_) | Goal::Image(_)) | None => String::new(),
        };
        let address = environment.open_address().map(ToString::to_string);
        let time = environment.time().seconds();
        Ok((instruction, address.unwrap_or_default(), time))
    }

    /// The public map of all episodes, OSM XML.
    fn map<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mut held = self.environments.lock()?;
        let environment = idle(held.get()?, 0)?;
        let map = environment.world().prepared().public_data().to_xml();
        Ok(PyBytes::new(py, &map))
    }

    /// A picture of one environment, from the robot's camera: rows, columns, three bytes.
    fn picture<'py>(
        &self,
        py: Python<'py>,
        index: usize,
    ) -> PyResult<Option<Bound<'py, PyArray3<u8>>>> {
        let mut held = self.environments.lock()?;
        let environment = held.get()?.idle_mut(index).ok_or_else(|| not_idle(index))?;
        // Moved, since an environment can be lent to one thread only.
        let picture = py.detach(move || environment.picture());
        let shaped = picture.map(|picture| {
            let shape = [picture.height as usize, picture.width as usize, 3];
            picture.rgb.into_pyarray(py).reshape(shape)
        });
        shaped.transpose()
    }

    /// What no policy may know: the true pose, and the length of the way that is left, metres.
    fn privileged(&self, index: usize) -> PyResult<Option<Privileged>> {
        let mut held = self.environments.lock()?;
        let environment = idle(held.get()?, index)?;
        let known = environment.privileged();
        Ok(known.map(|(pose, left)| ([pose.x, pose.y, pose.yaw], left)))
    }
}

type Privileged = ([f64; 3], Option<f64>);

/// Observations, rewards, terminations, truncations, and the ends of episodes: the environment, its
/// last observation, and its scores as JSON. Where an episode ended, the observation is the first
/// one of the next.
type Stepped<'py> = (
    Bound<'py, PyDict>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
    Vec<(usize, Bound<'py, PyDict>, String)>,
);

fn stepped<'py>(
    py: Python<'py>,
    options: &PyOptions,
    steps: Vec<ResettingStep>,
) -> PyResult<Stepped<'py>> {
    let column = |flag: fn(&ResettingStep) -> bool| steps.iter().map(flag).collect::<Vec<bool>>();
    let terminations = column(|step| step.step.terminated);
    let truncations = column(|step| step.step.truncated);
    let rewards: Vec<f64> = steps.iter().map(|step| step.step.reward).collect();
    let (mut observations, mut ends) = (Vec::with_capacity(steps.len()), Vec::new());
    for (row, ResettingStep { step, begun }) in steps.into_iter().enumerate() {
        if let Some(outcome) = step.outcome {
            let last = arrays(py, options, slice::from_ref(&step.observation))?;
            ends.push((row, last, json(&outcome)?));
        }
        observations.push(begun.unwrap_or(step.observation));
    }
    Ok((
        arrays(py, options, &observations)?,
        rewards.into_pyarray(py),
        terminations.into_pyarray(py),
        truncations.into_pyarray(py),
        ends,
    ))
}

fn idle(environments: &Environments, index: usize) -> PyResult<&Environment> {
    environments.idle(index).ok_or_else(|| not_idle(index))
}

fn not_idle(index: usize) -> PyErr {
    PyValueError::new_err(format!("environment {index} is at work, or there is none"))
}

/// The rows of an array of actions.
fn rows(actions: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<[f64; 3]>> {
    let actions = actions.as_array();
    let row = |row: ArrayView1<'_, f64>| match row.as_slice() {
        Some(&[linear, angular, declaration]) => Ok([linear, angular, declaration]),
        _ => Err(PyValueError::new_err(
            "an action has three numbers, contiguous in memory",
        )),
    };
    actions.rows().into_iter().map(row).collect()
}

/// Observations as arrays with a row for each.
pub fn arrays<'py>(
    py: Python<'py>,
    options: &PyOptions,
    observations: &[Observation],
) -> PyResult<Bound<'py, PyDict>> {
    let (observe, count) = (&options.options.observe, observations.len());
    let dict = PyDict::new(py);
    if observe.image {
        dict.set_item("image", images(py, observations)?)?;
    }
    if observe.points {
        let mut padded = vec![0.0_f32; count * MAX_POINTS * 3];
        let rows = padded.chunks_exact_mut(MAX_POINTS * 3);
        for (row, observation) in rows.zip(observations) {
            let filled = row.len().min(observation.points.len());
            row[..filled].copy_from_slice(&observation.points[..filled]);
        }
        let points = padded.into_pyarray(py).reshape([count, MAX_POINTS, 3])?;
        dict.set_item("points", points)?;
        let counts = observations.iter().map(|o| (o.points.len() / 3) as i64);
        dict.set_item("point_count", counts.collect::<Vec<i64>>().into_pyarray(py))?;
    }
    if let Some(RangeImage { rows, columns }) = observe.range_image {
        let pixels = joined(observations, |observation| &observation.range_image);
        dict.set_item(
            "range_image",
            pixels.into_pyarray(py).reshape([count, rows, columns])?,
        )?;
    }
    if observe.imu {
        let samples = joined(observations, |observation| &observation.imu);
        let rows = samples.len() / 6 / count.max(1);
        dict.set_item("imu", samples.into_pyarray(py).reshape([count, rows, 6])?)?;
    }
    if observe.wheels {
        let speeds = joined(observations, |observation| &observation.wheels);
        dict.set_item("wheels", speeds.into_pyarray(py).reshape([count, 2])?)?;
    }
    if options.shows_pose {
        let pose = |observation: &Observation| {
            let pose = observation.pose.unwrap_or_default();
            [pose.x, pose.y, pose.yaw]
        };
        let poses: Vec<f64> = observations.iter().flat_map(pose).collect();
        dict.set_item("pose", poses.into_pyarray(py).reshape([count, 3])?)?;
        let health = |observation: &Observation| match observation.health {
            Health::Good => 0,
            Health::Degraded(_) => 1,
            Health::Lost => 2,
        };
        let healths: Vec<i64> = observations.iter().map(health).collect();
        dict.set_item("health", healths.into_pyarray(py))?;
    }
    if options.shows_goal {
        let goal = |observation: &Observation| observation.goal.unwrap_or_default();
        let goals: Vec<f32> = observations.iter().flat_map(goal).collect();
        dict.set_item("goal", goals.into_pyarray(py).reshape([count, 2])?)?;
    }
    Ok(dict)
}

/// The images, black where the camera had none yet.
fn images<'py>(
    py: Python<'py>,
    observations: &[Observation],
) -> PyResult<Bound<'py, PyArray4<u8>>> {
    let (width, height) = IMAGE;
    let mut pixels = Vec::with_capacity(observations.len() * width * height * 3);
    for (row, observation) in observations.iter().enumerate() {
        if let Some(image) = &observation.image {
            pixels.extend_from_slice(&image.rgb);
        }
        pixels.resize((row + 1) * width * height * 3, 0);
    }
    pixels
        .into_pyarray(py)
        .reshape([observations.len(), height, width, 3])
}

fn joined(observations: &[Observation], values: fn(&Observation) -> &[f32]) -> Vec<f32> {
    observations
        .iter()
        .flat_map(|o| values(o).iter().copied())
        .collect()
}

fn json(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}
