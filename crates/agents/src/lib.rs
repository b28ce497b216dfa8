//! OPEN, the baseline of the OpenBench paper. An agent sees a briefing and observations, nothing else: this crate cannot
//! reach the simulator.
//!
//! | module | its one job |
//! |---|---|
//! | [`border`] | [`Border`]: the briefing's frame outside, a frame with its origin near the start inside |
//! | [`open`] | [`Open`]: plan, drive, explore, read plates, deliver, remember |

pub mod border;
pub mod open;

pub use border::Border;
pub use open::{Open, Parts};
