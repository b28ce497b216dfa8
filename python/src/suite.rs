//! Suites by name, with what makes them harder.

use openbench_bench::worlds::suite_named;
use openbench_bench::{BenchError, Suite};
use pyo3::prelude::*;

/// A suite as Python writes it: a name, a file or the folder of a world; conditions such as
/// `("map", "city")`; the seed of what they draw.
#[derive(Debug, Clone, FromPyObject)]
pub struct WrittenSuite(String, Vec<(String, String)>, u64);

impl WrittenSuite {
    /// The suite.
    ///
    /// # Errors
    /// A suite that there is not, or a condition that cannot be set.
    pub fn suite(&self) -> Result<Suite, BenchError> {
        let Self(name, conditions, seed) = self;
        let mut suite = suite_named(name)?;
        for (key, value) in conditions {
            let set = suite.conditions.set(key, value);
            set.map_err(BenchError::world)?;
        }
        Ok(suite.with_seed(*seed))
    }
}
