//! The offline planner: a grammar that knows the map. No model, no network, well under a
//! millisecond.
//!
//! The grammar reads lexemes, which the lexicon makes of the instruction, in stages:
//!
//! | module | its one concept |
//! |---|---|
//! | [`names`] | the map's own names in the text |
//! | [`mentions`] | buildings and units, lists of them, all of them |
//! | [`intent`] | those that are meant: not denied, not taken back, not corrected |
//! | [`pairing`], [`ownership`] | doors: which unit belongs to which building |
//! | [`fallback`] | doors without a word for a level |
//! | [`items`], [`deadlines`], [`levels`] | what is delivered, until when, on which floor |
//! | [`sequence`] | which stop comes before which |
//! | [`rule`], [`rules`] | the tables of rules that the stages apply |
//! | [`planner`] | all stages in their order |
//! | [`evidence`] | what a text holds, whatever it means |
//!
//! All of them read a [`reading::Reading`]. The grammar understands addresses, not stories:
//! pronouns are passed over, and conditions in which nothing is cancelled.

mod deadlines;
mod door;
pub(crate) mod evidence;
mod fallback;
mod intent;
mod items;
mod levels;
mod mentions;
mod names;
mod negated_order;
mod ownership;
mod pairing;
mod planner;
mod reading;
mod rule;
mod rules;
mod sequence;
mod weight;

pub use planner::GrammarPlanner;
