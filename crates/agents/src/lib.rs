#![doc = include_str!("../README.md")]
//!
//! | module | contents |
//! |---|---|
//! | [`border`] | [`Border`]: from the briefing's frame to one with its origin near the start |
//! | [`open`] | [`Open`]: plan, drive, explore, read plates, deliver, remember |

pub mod border;
pub mod open;

pub use border::Border;
pub use open::{Open, Parts};
