#![doc = include_str!("../README.md")]
//!
//! | module | contents |
//! |---|---|
//! | [`border`] | [`Border`]: from the briefing's frame to one with its origin near the start |
//! | [`open`] | [`Open`]: plan, drive, explore, read plates, deliver, remember |
//! | [`remote`] | [`remote::Policy`]: an agent whose decisions another program makes |
//! | [`served`] | [`served::Served`]: an agent whose decisions a policy server makes |

pub mod border;
pub mod open;
pub mod remote;
pub mod served;

pub use border::Border;
pub use open::{Open, Parts};
