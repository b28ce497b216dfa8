//! Suites by name, with what makes them harder.

use openbench_bench::worlds::{is_drawn_by_seed, suite_named, suite_of_seed};
use openbench_bench::{BenchError, Suite};
use pyo3::prelude::*;

/// A suite as Python writes it: a name, a file or the folder of a world; conditions such as
/// `("map", "city")`; the seed of what they draw.
#[derive(Debug, Clone, FromPyObject)]
pub struct WrittenSuite(String, Vec<(String, String)>, u64);

impl WrittenSuite {
    /// The suite, in the world that its name says.
    ///
    /// # Errors
    /// A suite that there is not, or a condition that cannot be set.
    pub fn suite(&self) -> Result<Suite, BenchError> {
        self.harder(suite_named(&self.0)?, self.2)
    }

    /// The suite for a run with its seed, which may draw another neighbourhood.
    ///
    /// # Errors
    /// As [`suite`](Self::suite).
    pub fn of_run(&self) -> Result<Suite, BenchError> {
        self.of_seed(self.2)
    }

    /// The suite for a run with another seed.
    ///
    /// # Errors
    /// As [`suite`](Self::suite).
    pub fn of_seed(&self, seed: u64) -> Result<Suite, BenchError> {
        self.harder(suite_of_seed(&self.0, seed)?, seed)
    }

    fn harder(&self, mut suite: Suite, seed: u64) -> Result<Suite, BenchError> {
        let words = self.1.iter().map(|(key, value)| (&**key, &**value));
        suite.conditions.set_all(words).map_err(BenchError::world)?;
        Ok(suite.with_seed(seed))
    }

    /// Whether another seed has another neighbourhood.
    pub fn differs_from_seed(&self, seed: u64) -> bool {
        is_drawn_by_seed(&self.0) && self.2 != seed
    }
}
