//! Doors, units and house numbers of houses of which no map says them: drawn from random numbers,
//! so that no rule finds them in the outline and the streets.
//!
//! | module | content |
//! |---|---|
//! | `doors` | [`draw_doors`]: where the doors of a house are |
//! | `units` | units of several doors |
//! | `numbers` | [`number_street`]: house numbers along a street; [`Inserted`] |

mod doors;
mod numbers;
mod units;

pub use doors::{DoorWish, DrawnDoor, Face, FaceWeights, draw_doors};
pub use numbers::{GAPS, Inserted, number_street};
