//! What worlds and seeds may be used for: training, validation or tests.
//!
//! Results on test worlds and seeds mean something only if no constant was chosen and no network
//! was trained on them.

use std::fmt;
use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

/// A part of all worlds and seeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Split {
    /// For training and tuning.
    Train,
    /// To choose between what was trained, and to stop tuning.
    Validation,
    /// To report.
    Test,
}

impl Split {
    /// All parts.
    pub const ALL: [Self; 3] = [Self::Train, Self::Validation, Self::Test];

    /// The seeds of drawn neighbourhoods and of conditions that belong to it.
    pub const fn seeds(self) -> RangeInclusive<u64> {
        match self {
            Self::Train => 0..=9_999,
            Self::Validation => 10_000..=10_999,
            Self::Test => 11_000..=11_999,
        }
    }

    /// The part that a seed belongs to, if any.
    ///
    /// ```
    /// use openbench_bench::suite::split::Split;
    ///
    /// assert_eq!(Split::of_seed(7), Some(Split::Train));
    /// assert_eq!(Split::of_seed(11_003), Some(Split::Test));
    /// assert_eq!(Split::of_seed(12_000), None);
    /// ```
    pub fn of_seed(seed: u64) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|split| split.seeds().contains(&seed))
    }
}

impl fmt::Display for Split {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Train => "train",
            Self::Validation => "validation",
            Self::Test => "test",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_seed_is_in_two_parts() {
        for pair in Split::ALL.windows(2) {
            assert!(pair[0].seeds().end() < pair[1].seeds().start());
        }
    }
}
