//! Policies in other programs: an agent that sends what it observes, and does what is answered.
//!
//! | module | contents |
//! |---|---|
//! | [`policy`] | [`Policy`]: the agent |
//! | [`message`] | [`Request`](message::Request), [`Reply`](message::Reply): what both sides say |
//! | [`frame`] | messages on a stream of bytes |
//! | [`link`] | [`Link`]: a connection with a policy |
//! | [`child`] | [`ChildLink`]: a policy in a child process |
//! | [`channel`] | [`ChannelLink`]: a policy on another thread of this process |
//! | [`pool`] | [`Pool`]: links that episodes share one after the other |

pub mod channel;
pub mod child;
pub mod frame;
pub mod link;
pub mod message;
pub mod policy;
pub mod pool;

pub use channel::ChannelLink;
pub use child::ChildLink;
pub use link::{Link, LinkError};
pub use policy::{Patience, Policy};
pub use pool::Pool;
