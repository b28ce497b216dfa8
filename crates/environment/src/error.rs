//! Errors of environments.

use openbench_bench::BenchError;

/// What an environment cannot do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EnvironmentError {
    /// An option makes no sense.
    #[error("{option}: {problem}")]
    Option {
        /// Its name.
        option: &'static str,
        /// What is wrong, and what to write.
        problem: String,
    },
    /// A number in an action is not finite.
    #[error("the action {0:?} has a number that is not finite")]
    Action([f64; 3]),
    /// A step without an episode.
    #[error("there is no episode: call reset first, and again after the end of an episode")]
    NoEpisode,
    /// No place to begin was found.
    #[error(
        "no place was found from which the shortest way to {door} has {least} to {largest} m; \
         choose other distances"
    )]
    NoStart {
        /// The door.
        door: String,
        /// Least length.
        least: f64,
        /// Largest length.
        largest: f64,
    },
    /// An environment of several is still at a step.
    #[error("environment {0} is at work: receive its step first")]
    AtWork(usize),
    /// More steps are waited for than were begun.
    #[error("{count} steps are waited for, and {at_work} were begun")]
    Idle {
        /// Number of environments at work.
        at_work: usize,
        /// Number of steps that are waited for.
        count: usize,
    },
    /// A defect of this program.
    #[error("a step panicked; please report it with what was printed")]
    Panicked,
    /// An error of the benchmark.
    #[error(transparent)]
    Bench(#[from] BenchError),
}
