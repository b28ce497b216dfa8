//! The route from one place on the network to another.
//!
//! | module | contents |
//! |---|---|
//! | `travel` | [`Leg`]: the edges of a route, and what they take |
//! | `line` | [`Line`]: where a leg runs |
//! | `ends` | where a search begins and ends for places within edges |
//! | `find` | the lightest leg |
//! | `alternatives` | other legs that are worth offering |
//! | `table` | what the lightest legs between many places take |

mod alternatives;
mod ends;
mod find;
mod line;
mod table;
mod travel;

pub use ends::Memory;
pub use line::Line;
pub use travel::{Leg, LengthAndDuration, Measures};
