//! From an instruction in words to ordered deliveries.
//!
//! | module | its one concept |
//! |---|---|
//! | [`grammar`] | [`GrammarPlanner`]: an offline grammar that knows the map; the default |
//! | [`chat_planner`] | [`ChatPlanner`]: the paper's three prompts to a chat model, and guards against what it invents |
//! | `question` | those prompts, and what their answers look like |
//! | [`mod@steps`] | the location query: navigate to what the map knows, explore for the rest |
//! | [`error`] | [`PlanError`]: why there is no plan |
//! | `gazetteer` | the names on a map as instructions may say them |
//! | `wish`, `resolve`, `arrange` | what is asked for, where that is on the map, in which order to drive |
//! | `order` | the shortest order that the instruction allows |

mod arrange;
mod chat_json;
pub mod chat_planner;
pub mod error;
mod gazetteer;
pub mod grammar;
mod order;
mod question;
mod resolve;
pub mod steps;
mod wish;

use openbench_core::{MapPoint, Plan, TravelTimes};
use openbench_osm::OsmMap;

pub use chat_planner::ChatPlanner;
pub use error::PlanError;
pub use grammar::GrammarPlanner;
pub use steps::{destination, steps};

/// What a planner is asked.
#[derive(Clone, Copy)]
pub struct PlanRequest<'a> {
    /// The instruction, in any language.
    pub instruction: &'a str,
    /// The public map, or an agent's own copy of it.
    pub map: &'a OsmMap,
    /// Where the robot stands.
    pub start: MapPoint,
    /// Seconds between places, for the order of deliveries.
    pub times: &'a dyn TravelTimes,
}

/// Turns an instruction into deliveries in driving order.
///
/// A plan always says what was understood: one delivery a door, named by the map's own names, else `building<N>` and `unit<N>`; what
/// is wrong with a delivery stands in its `problem`. Orders that the instruction asks for are kept, otherwise the drive is
/// short, and of equally short orders the instruction's own wins.
pub trait Planner {
    /// The planner's name as results report it.
    fn name(&self) -> &str;

    /// Plans the deliveries of one instruction.
    ///
    /// # Errors
    /// [`PlanError::NotUnderstood`] if the instruction names no place to deliver to; the other variants if a model fails.
    fn plan(&self, request: &PlanRequest<'_>) -> Result<Plan, PlanError>;
}
