//! Scoring: from traces to metrics.
//!
//! | module | content |
//! |---|---|
//! | `deliveries` | from an episode's trace to the results of its deliveries |
//! | [`health`] | the agent's reports on its own pose over time |
//! | [`stages`] | what the agent did over time |
//! | [`departures`] | in what a run departs from the defaults |
//! | [`metrics`] | the metrics, as functions of plain values |
//! | [`statistics`] | confidence intervals |
//! | [`provenance`] | [`Provenance`](provenance::Provenance): what results were made from and with |
//! | [`results`] | [`Results`]: the file `results.json` |
//! | [`across`] | several runs: means over seeds, differences between systems |
//! | [`evaluate`] | the paper's metrics for logs of the reference recorder |

pub mod across;
pub mod deliveries;
pub mod departures;
pub mod evaluate;
pub mod health;
pub mod metrics;
pub mod provenance;
pub mod results;
pub mod stages;
pub mod statistics;

pub use results::Results;
