//! The local planners of this crate. A new one is a file of its own and a line here.

use openbench_core::Registry;

use super::registry::LocalPlanners;
use crate::{follower, mppi, teb};

/// The planners of this crate, in the order in which they are listed.
pub fn built_in() -> LocalPlanners {
    Registry::new("local planner")
        .with_entry(teb::entry())
        .with_entry(follower::entry())
        .with_entry(mppi::entry())
}
