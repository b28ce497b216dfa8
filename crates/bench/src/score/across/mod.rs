//! Several runs: means over seeds and worlds, and differences between systems.
//!
//! | module | content |
//! |---|---|
//! | `measures` | what is compared |
//! | `system` | [`System`]: the runs of one system |
//! | `samples` | its values, by world, seed, episode and door |
//! | [`mod@means`] | [`Means`]: means over its runs, with intervals |
//! | [`comparison`] | [`Comparison`]: differences between systems, paired by episode |
//! | [`paired`] | the statistics of pairs |

pub mod comparison;
pub mod means;
mod measures;
pub mod paired;
mod samples;
mod system;

pub use comparison::{CompareError, Comparison, compare};
pub use means::{Means, means};
pub use measures::Unit;
pub use samples::ClusteredBy;
pub use system::System;
