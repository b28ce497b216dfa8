//! Several environments on several threads.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use crate::environment::{Environment, Step};
use crate::error::EnvironmentError;
use crate::observation::Observation;
use crate::options::Options;
use crate::world::World;

/// Largest number of environments.
const MOST: usize = 4096;
/// Largest number of threads.
const MOST_THREADS: usize = 256;

/// Several environments in one world. Their threads end when this is dropped.
///
/// ```
/// use openbench_bench::worlds::suite_named;
/// use openbench_environment::{AfterEnd, Beginning, Environments, Options, World};
///
/// let options = Options::default();
/// let world = World::new(suite_named("small")?, &options)?;
/// let mut environments = Environments::new(&world, &options, 2, 2, AfterEnd::Reset)?;
/// let seeded = |seed| Some(Beginning { seed: Some(seed), episode: None });
/// environments.reset(&[seeded(1), seeded(2)])?;
/// let steps = environments.step(&[[0.3, 0.0, 0.0], [0.0, 0.5, 0.0]])?;
/// assert!(steps.iter().all(|step| step.begun.is_none()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Environments {
    /// `None` while the environment is at work.
    idle: Vec<Option<Box<Environment>>>,
    jobs: Sender<Job>,
    done: Receiver<Done>,
}

/// A step, and the observation with which the next episode begins where one ended: the policy acts
/// on that.
#[derive(Debug, Clone, PartialEq)]
pub struct ResettingStep {
    /// The step.
    pub step: Step,
    /// The first observation of the next episode.
    pub begun: Option<Observation>,
}

/// What follows the end of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AfterEnd {
    /// The next episode begins in the same step.
    Reset,
    /// Nothing, until the environment is reset.
    Wait,
}

/// How an episode begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Beginning {
    /// As of [`Environment::reset`].
    pub seed: Option<u64>,
    /// As of [`Environment::reset`].
    pub episode: Option<usize>,
}

/// What an environment is to do. It travels with it, so no thread waits for another.
struct Job {
    index: usize,
    environment: Box<Environment>,
    order: Order,
}

enum Order {
    Reset(Beginning),
    Step([f64; 3]),
}

struct Done {
    index: usize,
    environment: Box<Environment>,
    outcome: Result<Outcome, EnvironmentError>,
}

enum Outcome {
    Begun(Observation),
    Stepped(Box<ResettingStep>),
}

impl Environments {
    /// So many environments with the same options, on so many threads.
    ///
    /// # Errors
    /// As [`Environment::new`], or [`EnvironmentError::Option`] of a number that makes no sense.
    pub fn new(
        world: &World,
        options: &Options,
        count: usize,
        threads: usize,
        after_end: AfterEnd,
    ) -> Result<Self, EnvironmentError> {
        in_range("num_envs", count, MOST)?;
        in_range("threads", threads, MOST_THREADS)?;
        let make = |_| Environment::new(world.clone(), options.clone());
        let environments: Result<Vec<Environment>, _> = (0..count).map(make).collect();
        let idle = environments?.into_iter();
        let (jobs, waiting) = mpsc::channel();
        let (finished, done) = mpsc::channel();
        let waiting = Arc::new(Mutex::new(waiting));
        for _ in 0..threads.min(count) {
            let (waiting, finished) = (Arc::clone(&waiting), finished.clone());
            thread::spawn(move || work(&waiting, &finished, after_end));
        }
        Ok(Self {
            idle: idle
                .map(|environment| Some(Box::new(environment)))
                .collect(),
            jobs,
            done,
        })
    }

    /// Number of environments.
    pub fn count(&self) -> usize {
        self.idle.len()
    }

    /// An environment that is not at work.
    pub fn idle(&self, index: usize) -> Option<&Environment> {
        self.idle.get(index)?.as_deref()
    }

    /// As [`idle`](Self::idle), to be lent to another thread.
    pub fn idle_mut(&mut self, index: usize) -> Option<&mut Environment> {
        self.idle.get_mut(index)?.as_deref_mut()
    }

    /// Begins an episode in each environment for which there is a beginning, one for each
    /// environment.
    ///
    /// # Errors
    /// As [`Environment::reset`], of the environment with the lowest number.
    pub fn reset(
        &mut self,
        beginnings: &[Option<Beginning>],
    ) -> Result<Vec<Option<Observation>>, EnvironmentError> {
        let mut asked = 0;
        for (index, beginning) in beginnings.iter().enumerate() {
            if let Some(beginning) = beginning {
                self.order(index, Order::Reset(*beginning))?;
                asked += 1;
            }
        }
        let mut begun = vec![None; self.count()];
        for (index, outcome) in self.collect(asked)? {
            if let Outcome::Begun(observation) = outcome {
                begun[index] = Some(observation);
            }
        }
        Ok(begun)
    }

    /// A step of each environment. Where an episode ends, the next one begins in the same step, if
    /// they were made so.
    ///
    /// # Errors
    /// As [`Environment::step`], of the environment with the lowest number.
    pub fn step(&mut self, actions: &[[f64; 3]]) -> Result<Vec<ResettingStep>, EnvironmentError> {
        for (index, action) in actions.iter().enumerate() {
            self.send(index, *action)?;
        }
        let mut steps = self.receive(actions.len())?;
        steps.sort_by_key(|(index, _)| *index);
        Ok(steps.into_iter().map(|(_, step)| step).collect())
    }

    /// Lets one environment begin a step; [`receive`](Self::receive) has its result.
    ///
    /// # Errors
    /// [`EnvironmentError::AtWork`], or [`EnvironmentError::Option`] of a number that is too large.
    pub fn send(&mut self, index: usize, action: [f64; 3]) -> Result<(), EnvironmentError> {
        self.order(index, Order::Step(action))
    }

    /// Waits for the first `count` steps that are done, and returns them with the numbers of their
    /// environments in the order in which they were done.
    ///
    /// # Errors
    /// As [`step`](Self::step), or [`EnvironmentError::Idle`] if fewer are at work.
    pub fn receive(
        &mut self,
        count: usize,
    ) -> Result<Vec<(usize, ResettingStep)>, EnvironmentError> {
        let stepped = |(index, outcome)| match outcome {
            Outcome::Stepped(step) => Some((index, *step)),
            Outcome::Begun(_) => None,
        };
        let outcomes = self.collect(count)?;
        Ok(outcomes.into_iter().filter_map(stepped).collect())
    }

    fn order(&mut self, index: usize, order: Order) -> Result<(), EnvironmentError> {
        let count = self.count();
        let slot = self.idle.get_mut(index).ok_or(EnvironmentError::Option {
            option: "environment",
            problem: format!("there are {count}, and {index} is none of them"),
        })?;
        let environment = slot.take().ok_or(EnvironmentError::AtWork(index))?;
        let job = Job {
            index,
            environment,
            order,
        };
        // Threads end after this is dropped only.
        self.jobs.send(job).map_err(|_| EnvironmentError::Panicked)
    }

    /// Waits for so many outcomes. All of them are taken back before an error is returned.
    fn collect(&mut self, count: usize) -> Result<Vec<(usize, Outcome)>, EnvironmentError> {
        let at_work = self.idle.iter().filter(|slot| slot.is_none()).count();
        if count > at_work {
            return Err(EnvironmentError::Idle { at_work, count });
        }
        let (mut outcomes, mut errors) = (Vec::with_capacity(count), Vec::new());
        for _ in 0..count {
            let done = self.done.recv().map_err(|_| EnvironmentError::Panicked)?;
            self.idle[done.index] = Some(done.environment);
            match done.outcome {
                Ok(outcome) => outcomes.push((done.index, outcome)),
                Err(error) => errors.push((done.index, error)),
            }
        }
        match errors.into_iter().min_by_key(|(index, _)| *index) {
            Some((_, error)) => Err(error),
            None => Ok(outcomes),
        }
    }
}

/// Does jobs until there are no more.
fn work(waiting: &Mutex<Receiver<Job>>, finished: &Sender<Done>, after_end: AfterEnd) {
    loop {
        let next = waiting
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .recv();
        let Ok(Job {
            index,
            mut environment,
            order,
        }) = next
        else {
            break;
        };
        // An environment that panicked has no episode, and can be reset.
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            obey(&mut environment, order, after_end)
        }));
        let outcome = outcome.unwrap_or(Err(EnvironmentError::Panicked));
        let done = Done {
            index,
            environment,
            outcome,
        };
        if finished.send(done).is_err() {
            break;
        }
    }
}

fn obey(
    environment: &mut Environment,
    order: Order,
    after_end: AfterEnd,
) -> Result<Outcome, EnvironmentError> {
    match order {
        Order::Reset(Beginning { seed, episode }) => {
            environment.reset(seed, episode).map(Outcome::Begun)
        }
        Order::Step(action) => {
            let step = environment.step(action)?;
            let resets = step.outcome.is_some() && after_end == AfterEnd::Reset;
            let begun = resets.then(|| environment.reset(None, None)).transpose()?;
            Ok(Outcome::Stepped(Box::new(ResettingStep { step, begun })))
        }
    }
}

fn in_range(option: &'static str, value: usize, most: usize) -> Result<(), EnvironmentError> {
    if (1..=most).contains(&value) {
        return Ok(());
    }
    let problem = format!("{value} is none of 1 to {most}");
    Err(EnvironmentError::Option { option, problem })
}
