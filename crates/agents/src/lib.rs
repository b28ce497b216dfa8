//! OPEN, the baseline of the OpenBench paper. An agent sees a briefing and observations, nothing else: this crate cannot
//! reach the simulator.
//!
//! | module | its one job |
//! |---|---|
//! | [`open`] | [`Open`]: plan, drive, explore, read plates, deliver, remember |

pub mod open;

pub use open::{Open, Parts};
