//! Scoring: from what happened to numbers.
//!
//! | module | its one job |
//! |---|---|
//! | [`deliveries`] | from an episode's trace to the results of its deliveries |
//! | [`metrics`] | the metrics, as functions of plain values |
//! | [`statistics`] | intervals |
//! | [`results`] | [`Results`]: the file `results.json` |
//! | [`evaluate`] | the reference's recorder files |

pub mod deliveries;
pub mod evaluate;
pub mod metrics;
pub mod results;
pub mod statistics;

pub use results::Results;
