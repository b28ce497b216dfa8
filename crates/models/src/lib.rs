#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! | module | what it does |
//! |---|---|
//! | `chat` | [`ChatModel`]: the contract of a chat model: messages in, one text out |
//! | [`spec`], `provider` | [`ModelSpec`]: reads which chat model a user means |
//! | `open`, `address`, `secret` | opens a [`ModelSpec`]: endpoint, key, time-out |
//! | `remote`, `transport` | a [`ChatModel`] behind a provider's endpoint: protocol and HTTP |
//! | `local`, `gbnf` | a [`ChatModel`] in this process, from a GGUF file (feature `local-llm`) |
//! | `exchanges` | [`Exchanges`]: where answers go, or come from |
//! | `budget` | [`Metered`]: counts and limits the calls of a mission |
//! | `replay` | [`Recorder`], [`Replay`]: record answers and repeat them |
//! | [`catalogue`] | [`CATALOGUE`]: the known model files, their sources, licences and checksums |
//! | `store` | [`ModelStore`]: the folder of model files |
//! | `pull` | [`ModelStore::download`]: downloads files that are missing in the folder |
//! | `wheel`, `hub` | sources of files: wheels on PyPI, and a model hub |
//! | `error` | [`SpecError`], [`OpenError`], [`StoreError`], [`ReplayError`] |

mod address;
mod budget;
pub mod catalogue;
mod chat;
mod digest;
mod error;
mod exchanges;
#[cfg(any(test, feature = "local-llm"))]
mod gbnf;
mod hub;
#[cfg(feature = "local-llm")]
mod local;
#[cfg(test)]
mod loopback;
mod open;
mod provider;
mod pull;
mod quote;
mod remote;
mod replay;
mod secret;
pub mod spec;
mod store;
mod transport;
mod wheel;

pub use budget::{Budget, Meter, Metered};
pub use catalogue::{CATALOGUE, Hub, ModelFile, Source, Wheel};
pub use chat::{
    ChatError, ChatModel, ChatReply, ChatRequest, CountedReply, Format, Message, Role, Schema,
};
pub use digest::sha256_of;
pub use error::{BudgetError, Cause, LocalError, OpenError, ReplayError, SpecError, StoreError};
pub use exchanges::Exchanges;
pub use provider::Provider;
pub use pull::PullEvent;
pub use replay::{Recorder, Replay};
pub use spec::ModelSpec;
pub use store::ModelStore;
