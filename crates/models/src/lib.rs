//! Model files and chat or vision endpoints.
//!
//! | module | what it holds |
//! |---|---|
//! | [`chat`] | [`ChatModel`]: messages in, one text out |
//! | [`spec`], [`provider`] | [`ModelSpec`]: which chat model a user means |
//! | `open`, `address`, `secret` | from a [`ModelSpec`] to the model, with its endpoint and key |
//! | `remote`, `transport` | a provider's endpoint as a [`ChatModel`]: what is said, and how it gets there |
//! | `local`, `gbnf` | a GGUF file as a [`ChatModel`] in this process, and JSON Schemas as its grammar (feature `local-llm`) |
//! | [`budget`] | [`Metered`]: what a mission asks of models, counted and bounded |
//! | [`exchanges`] | [`Exchanges`]: where answers go, or come from |
//! | [`replay`] | [`Recorder`] and [`Replay`]: what a model answered, kept and given again |
//! | [`catalogue`] | [`CATALOGUE`]: the model files that OpenBench knows, their source, licence and checksum |
//! | [`store`] | [`ModelStore`]: the folder where model files lie |
//! | `wheel`, `hub` | where they come from: wheels on PyPI, fetched by the user's pip, and a hub of models |
//! | [`pull`] | [`ModelStore::ensure`]: brings what is missing in the folder |
//! | [`error`] | why a model cannot be named, opened or brought here |

mod address;
pub mod budget;
pub mod catalogue;
pub mod chat;
mod digest;
pub mod error;
pub mod exchanges;
#[cfg(any(test, feature = "local-llm"))]
mod gbnf;
mod hub;
#[cfg(feature = "local-llm")]
mod local;
#[cfg(test)]
mod loopback;
mod open;
pub mod provider;
pub mod pull;
mod quote;
mod remote;
pub mod replay;
mod secret;
pub mod spec;
pub mod store;
mod transport;
mod wheel;

pub use budget::{Budget, Meter, Metered};
pub use catalogue::{CATALOGUE, Hub, ModelFile, Source, Wheel};
pub use chat::{ChatError, ChatModel, ChatReply, ChatRequest, CountedReply, Format, Message, Role, Schema};
pub use error::{BudgetError, LocalError, ModelError, OpenError, ReplayError, SpecError};
pub use exchanges::Exchanges;
pub use provider::Provider;
pub use pull::PullEvent;
pub use replay::{Recorder, Replay};
pub use spec::ModelSpec;
pub use store::ModelStore;
