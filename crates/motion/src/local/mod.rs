//! Local planners: from a path and what stands around to a velocity.
//!
//! | module | contents |
//! |---|---|
//! | `planner` | [`LocalPlanner`], the trait, with what goes in and what comes out |
//! | `path` | points of a path ahead of the robot |
//! | `registry` | [`LocalPlanners`]: planners by name, to which others can be added |
//! | [`built_in`] | the planners of this crate, a line each |

pub mod built_in;
mod path;
pub(crate) mod planner;
mod registry;

pub use path::{PathPoint, ahead};
pub use planner::{Blocked, LocalPlanner, Progress, Situation};
pub use registry::{
    LocalPlanners, MakeError, MakePlanner, PlannerEntry, PlannerError, PlannerSettings,
    make_planner, planner_entry,
};
