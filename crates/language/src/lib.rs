#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! | module | contents |
//! |---|---|
//! | `lexicon` | words, numbers and marks of all languages; a text as lexemes |
//! | `gazetteer` | the names on a map as instructions may say them |
//! | `grammar` | [`GrammarPlanner`]: rules that read lexemes; the default |
//! | `chat_planner` | [`ChatPlanner`]: three prompts, and guards against what a model invents |
//! | `wish`, `resolve` | what is asked for, and where that is on the map |
//! | `order`, `arrange` | the shortest order that the instruction allows, as deliveries |
//! | `steps` | the location query: navigate to what the map knows, explore for the rest |
//! | `error` | [`PlanError`]: why there is no plan |

mod arrange;
mod chat_planner;
mod error;
mod gazetteer;
mod grammar;
mod lexicon;
mod order;
mod resolve;
mod steps;
mod wish;

use openbench_core::{MapPoint, Plan, TravelTimes};
use openbench_osm::OsmMap;

pub use chat_planner::ChatPlanner;
pub use error::{AnswerError, PlanError};
pub use grammar::GrammarPlanner;
pub use steps::{destination, steps};

/// What a planner is asked.
#[derive(Clone, Copy)]
pub struct PlanRequest<'a> {
    /// The instruction, in any language.
    pub instruction: &'a str,
    /// The public map, or an agent's own copy of it.
    pub map: &'a OsmMap,
    /// The robot's position, in map coordinates (metres).
    pub start: MapPoint,
    /// Seconds between places, for the order of deliveries.
    pub times: &'a dyn TravelTimes,
}

/// Turns an instruction into deliveries in driving order.
///
/// A plan always reports what was understood: one delivery for each door, named by the map's own
/// names, else `building<N>` and `unit<N>`. What is wrong with a delivery is its `problem`. Orders
/// that the instruction asks for are kept. Beyond them the drive is short, and of equally short
/// orders the instruction's own wins.
pub trait Planner {
    /// The planner's name as results report it.
    fn name(&self) -> &str;

    /// Plans the deliveries of one instruction.
    ///
    /// # Errors
    /// [`PlanError::NotUnderstood`] if the instruction names no place to deliver to; the other
    /// variants if a model fails.
    fn plan(&self, request: &PlanRequest<'_>) -> Result<Plan, PlanError>;
}
