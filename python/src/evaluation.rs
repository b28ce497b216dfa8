//! Runs of suites with policies of this process.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use openbench_agents::remote::channel::channel;
use openbench_agents::remote::{Link, LinkError, Patience, Policy, Pool};
use openbench_bench::run::registry::{AgentError, AgentSettings};
use openbench_bench::{
    AgentFactory, AgentRequest, BenchError, Prepared, Results, RunRequest, Setting, Unfinished, run,
};
use openbench_core::Agent;
use pyo3::prelude::*;

use crate::errors::{InputError, raised};
use crate::policy::PolicyEnd;
use crate::suite::WrittenSuite;

/// How often Python's signals are asked for during a run.
const SIGNALS_EVERY: Duration = Duration::from_millis(100);

/// Episodes that run in parallel, at most.
const MOST_JOBS: usize = 256;
/// Longest time for an action, seconds.
const LONGEST_S: f64 = 86_400.0;

/// A suite that is ready to be run by policies of this process.
#[pyclass(frozen)]
pub struct Run {
    suite: WrittenSuite,
    prepared: Prepared,
    agent: String,
    stop: Arc<AtomicBool>,
}

/// How a run is driven.
struct Drive {
    seed: u64,
    jobs: usize,
    out: Option<PathBuf>,
    patience: Patience,
    /// Starts a thread with a policy at the end of a connection.
    start: Py<PyAny>,
}

#[pymethods]
impl Run {
    /// Builds the world of a suite.
    #[new]
    fn new(py: Python<'_>, suite: WrittenSuite, agent: String) -> PyResult<Self> {
        let prepared = py.detach(|| Prepared::new(suite.of_run()?, None));
        Ok(Self {
            prepared: prepared.map_err(|error| raised(&error))?,
            suite,
            agent,
            stop: Arc::default(),
        })
    }

    /// Ends the run after the current step.
    fn stop(&self) {
        // Relaxed suffices: no other memory depends on the flag.
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Drives all episodes; returns `results.json`. `start` is called with a `PolicyEnd` whenever
    /// a policy is needed, and starts a thread that serves it.
    fn drive(
        &self,
        py: Python<'_>,
        seed: u64,
        jobs: usize,
        timeout: f64,
        out: Option<PathBuf>,
        start: Py<PyAny>,
    ) -> PyResult<String> {
        if !(1..=MOST_JOBS).contains(&jobs) {
            return Err(InputError::new_err(format!("jobs: write 1 to {MOST_JOBS}")));
        }
        if !(timeout > 0.0 && timeout <= LONGEST_S) {
            return Err(InputError::new_err("timeout: write seconds, at most a day"));
        }
        let drive = Drive {
            seed,
            jobs,
            out,
            patience: Patience {
                act: Duration::from_secs_f64(timeout),
                ..Patience::default()
            },
            start,
        };
        let results = py.detach(|| self.run_and_watch(&drive))?;
        serde_json::to_string(&results).map_err(|error| InputError::new_err(error.to_string()))
    }
}

impl Run {
    /// Runs on a thread of its own, while this one asks for Python's signals.
    fn run_and_watch(&self, drive: &Drive) -> PyResult<Results> {
        thread::scope(|scope| {
            let (done, wait) = mpsc::channel();
            scope.spawn(move || {
                // Nobody waits after an exception of a signal.
                let _ = done.send(self.run(drive));
            });
            loop {
                match wait.recv_timeout(SIGNALS_EVERY) {
                    Ok(results) => return results.map_err(|error| raised(&error)),
                    Err(RecvTimeoutError::Timeout) => {
                        Python::attach(|py| py.check_signals()).inspect_err(|_| self.stop())?;
                    }
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(InputError::new_err("the run ended without results"));
                    }
                }
            }
        })
    }

    fn run(&self, drive: &Drive) -> Result<Results, BenchError> {
        let stop = Arc::clone(&self.stop);
        let start = Python::attach(|py| drive.start.clone_ref(py));
        let pool = Pool::new(move |_| connect(&start, &stop));
        let factory = RunningAgents {
            pool,
            patience: drive.patience,
        };
        let own = if self.suite.differs_from_seed(drive.seed) {
            Some(Prepared::new(self.suite.of_seed(drive.seed)?, None)?)
        } else {
            self.prepared.of_seed(drive.seed)?
        };
        let prepared = own.as_ref().unwrap_or(&self.prepared);
        let request = RunRequest {
            seed: drive.seed,
            jobs: drive.jobs,
            out: drive.out.as_deref(),
            unfinished: Unfinished::Discard,
            build: &openbench::build(),
            command: "openbench.evaluate",
            stop: &self.stop,
            ..RunRequest::new(prepared, &self.agent, &factory)
        };
        Ok(run(&request)?.results)
    }
}

/// Agents of this process.
struct RunningAgents {
    pool: Pool,
    patience: Patience,
}

impl AgentFactory for RunningAgents {
    fn make(&self, request: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
        Ok(Box::new(Policy::new(
            &self.pool,
            request.seed,
            self.patience,
        )?))
    }

    fn in_force(&self, _: &AgentSettings) -> BTreeMap<String, Setting> {
        let seconds = |patience: Patience| patience.act.as_secs_f64().to_string();
        let timeout = Setting::new(seconds(self.patience), &seconds(Patience::default()));
        BTreeMap::from([("timeout".to_owned(), timeout)])
    }

    fn cannot_repeat(&self, _: &AgentSettings) -> Option<String> {
        let reason = "the agent was an object of a Python program; one that can be run again is \
                      named by `--agent python:FILE:CLASS`";
        Some(reason.to_owned())
    }
}

/// A connection with a policy on a new thread.
fn connect(start: &Py<PyAny>, stop: &Arc<AtomicBool>) -> Result<Box<dyn Link>, LinkError> {
    let (link, policy) = channel(Arc::clone(stop));
    let started = Python::attach(|py| start.call1(py, (PolicyEnd::of_channels(policy),)));
    started.map_err(|error| LinkError::CannotBegin {
        detail: error.to_string(),
    })?;
    Ok(Box::new(link))
}
