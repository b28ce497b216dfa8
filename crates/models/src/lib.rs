//! Model files and chat or vision endpoints.
//!
//! | module | what it holds |
//! |---|---|
//! | [`chat`] | [`ChatModel`]: messages in, one text out |
//! | [`spec`] | [`ModelSpec`]: which chat model a user means, and where its key comes from |
//! | `remote`, `transport` | a provider's endpoint as a [`ChatModel`]: what is said, and how it gets there |
//! | `local`, `gbnf` | a GGUF file as a [`ChatModel`] in this process, and JSON Schemas as its grammar (feature `local-llm`) |
//! | [`budget`] | [`Metered`]: what a mission asks of models, counted and bounded |
//! | [`exchanges`] | [`Exchanges`]: where answers go, or come from |
//! | [`replay`] | [`Recorder`] and [`Replay`]: what a model answered, kept and given again |
//! | [`catalogue`] | [`CATALOGUE`]: the model files that OpenBench knows, their source, licence and checksum |
//! | [`store`] | [`ModelStore`]: the folder where model files lie |
//! | [`pull`], `hub` | where they come from: wheels on PyPI, fetched by the user's pip, and a hub of models |

pub mod budget;
pub mod catalogue;
pub mod chat;
mod digest;
pub mod exchanges;
#[cfg(any(test, feature = "local-llm"))]
mod gbnf;
mod hub;
#[cfg(feature = "local-llm")]
mod local;
pub mod pull;
mod remote;
pub mod replay;
mod secret;
pub mod spec;
pub mod store;
mod transport;

pub use budget::{Budget, Meter, Metered};
pub use catalogue::{CATALOGUE, Hub, ModelFile, Source, Wheel};
pub use chat::{ChatError, ChatModel, ChatReply, ChatRequest, Format, Message, Role, Schema};
pub use exchanges::Exchanges;
pub use replay::{Recorder, Replay, ReplayError};
pub use spec::{ModelSpec, Provider, SpecError};
pub use store::{ModelError, ModelStore, PullEvent};
