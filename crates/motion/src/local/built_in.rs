//! The local planners of this crate. A new one is a file of its own and a line here.

use super::registry::LocalPlanners;
use crate::{follower, mppi, teb};

/// The planners of this crate, in the order in which they are listed.
pub fn built_in() -> LocalPlanners {
    LocalPlanners::new([teb::entry(), follower::entry(), mppi::entry()])
}
