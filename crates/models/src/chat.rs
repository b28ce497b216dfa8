//! The contract with a chat model: messages in, one text out.
//!
//! Follows the shape that providers share (roles, pictures beside text, a request for JSON or for JSON of a schema), and no more: no
//! streaming, no tools, no several choices. Everything here can be written to a file and read back unchanged, errors too,
//! so that a recorded conversation replays exactly ([`crate::replay`]).

use openbench_core::ModelUse;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Something that answers a conversation: a remote endpoint, a recording, or a script in a test.
///
/// Implementations are shared between worker threads; a call blocks until the answer or an error is there, so an
/// implementation that can wait must bound the wait itself.
pub trait ChatModel: Send + Sync {
    /// The model's name as results report it, without endpoint and without secrets.
    fn name(&self) -> &str;

    /// Answers the conversation with one text.
    ///
    /// # Errors
    /// Any [`ChatError`]; retries are the implementation's business, so an error here is final for this request.
    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError>;

    /// [`ChatModel::chat`], and what it cost: also where there is no answer in the end.
    fn chat_counted(&self, request: &ChatRequest) -> CountedReply {
        CountedReply::of_one_call(self.chat(request))
    }
}

impl<M: ChatModel + ?Sized> ChatModel for Box<M> {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
        (**self).chat(request)
    }

    fn chat_counted(&self, request: &ChatRequest) -> CountedReply {
        (**self).chat_counted(request)
    }
}

impl<M: ChatModel + ?Sized> ChatModel for std::sync::Arc<M> {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
        (**self).chat(request)
    }

    fn chat_counted(&self, request: &ChatRequest) -> CountedReply {
        (**self).chat_counted(request)
    }
}

/// Who speaks in a [`Message`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Standing orders, before the conversation.
    System,
    /// The one who asks.
    User,
    /// The model, in earlier turns.
    Assistant,
}

/// One turn of a conversation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Message {
    /// Who speaks.
    pub role: Role,
    /// What is said.
    pub text: String,
    /// Pictures shown with the text, each a whole PNG or JPEG file.
    pub images: Vec<Vec<u8>>,
}

impl Message {
    /// Standing orders for the model.
    pub fn system(text: impl Into<String>) -> Self {
        Self { role: Role::System, text: text.into(), images: Vec::new() }
    }

    /// A question without pictures.
    pub fn user(text: impl Into<String>) -> Self {
        Self { role: Role::User, text: text.into(), images: Vec::new() }
    }

    /// An earlier answer of the model.
    pub fn assistant(text: impl Into<String>) -> Self {
        Self { role: Role::Assistant, text: text.into(), images: Vec::new() }
    }

    /// The same turn with one more picture, a whole PNG or JPEG file.
    #[must_use]
    pub fn with_image(mut self, file: Vec<u8>) -> Self {
        self.images.push(file);
        self
    }
}

/// What an answer shall look like.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Format {
    /// Free text.
    Text,
    /// One JSON object.
    Json,
    /// One JSON object of this schema, where the provider can hold the model to one; one JSON object elsewhere.
    Schema(Schema),
}

/// A JSON Schema.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Schema {
    /// What it describes: ASCII letters, digits, `_` and `-` only.
    pub name: String,
    /// The schema as JSON text, an object.
    pub text: String,
}

/// What is asked of a [`ChatModel`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChatRequest {
    /// The conversation so far, oldest first.
    pub messages: Vec<Message>,
    /// What the answer shall look like. Servers honour it as well as they can; callers still check.
    pub format: Format,
    /// The longest answer wanted, in the model's tokens.
    pub max_tokens: u32,
    /// Sampling temperature; 0 asks for the likeliest answer.
    pub temperature: f32,
}

impl ChatRequest {
    /// A conversation that asks for plain text, 1024 tokens at most, at temperature 0.
    pub fn new(messages: Vec<Message>) -> Self {
        Self { messages, format: Format::Text, max_tokens: 1024, temperature: 0.0 }
    }

    /// The same conversation, asking for one JSON object.
    #[must_use]
    pub fn as_json(mut self) -> Self {
        self.format = Format::Json;
        self
    }

    /// The same conversation, asking for one JSON object of a schema.
    #[must_use]
    pub fn as_schema(mut self, schema: Schema) -> Self {
        self.format = Format::Schema(schema);
        self
    }

    /// SHA-256 over every field, in hex. Each part is preceded by its length, so no two requests share an encoding.
    pub fn digest(&self) -> String {
        let mut hasher = Sha256::new();
        match &self.format {
            Format::Text => hasher.update([0]),
            Format::Json => hasher.update([1]),
            Format::Schema(schema) => {
                hasher.update([2]);
                hash_part(&mut hasher, schema.name.as_bytes());
                hash_part(&mut hasher, schema.text.as_bytes());
            }
        }
        hasher.update(self.max_tokens.to_le_bytes());
        hasher.update(self.temperature.to_bits().to_le_bytes());
        for message in &self.messages {
            hasher.update([message.role as u8]);
            hash_part(&mut hasher, message.text.as_bytes());
            hasher.update((message.images.len() as u64).to_le_bytes());
            message.images.iter().for_each(|image| hash_part(&mut hasher, image));
        }
        crate::digest::hex(&hasher.finalize())
    }
}

fn hash_part(hasher: &mut Sha256, bytes: &[u8]) {
    hasher.update((bytes.len() as u64).to_le_bytes());
    hasher.update(bytes);
}

/// What a [`ChatModel`] answered.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChatReply {
    /// The answer, as the model wrote it.
    pub text: String,
    /// Tokens that the request cost; 0 where the server did not say.
    pub prompt_tokens: u32,
    /// Tokens that the answer cost; 0 where the server did not say.
    pub completion_tokens: u32,
}

/// What a [`ChatModel`] answered, or why it did not, and what that cost.
#[derive(Debug, Clone, PartialEq)]
pub struct CountedReply {
    /// The answer.
    pub reply: Result<ChatReply, ChatError>,
    /// Calls, tokens and time of all tries together.
    pub used: ModelUse,
}

impl CountedReply {
    /// The outcome of a single call that took no time worth counting.
    pub fn of_one_call(reply: Result<ChatReply, ChatError>) -> Self {
        let mut used = ModelUse { calls: 1, ..ModelUse::default() };
        match &reply {
            Ok(reply) => {
                used.prompt_tokens = reply.prompt_tokens.into();
                used.completion_tokens = reply.completion_tokens.into();
            }
            Err(_) => used.failed = 1,
        }
        Self { reply, used }
    }
}

/// Why there is no answer. No variant ever holds a key.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum ChatError {
    /// No connection to the server, or it broke off.
    #[error("cannot reach the model at {endpoint}: {detail}; check the address and that the server runs")]
    Unreachable {
        /// The address that was tried.
        endpoint: String,
        /// What the network said.
        detail: String,
    },
    /// The server did not answer in time.
    #[error(
        "the model at {endpoint} did not answer within {seconds} s; try a longer time-out or a faster model"
    )]
    Timeout {
        /// The address that was tried.
        endpoint: String,
        /// The limit that ran out, rounded up.
        seconds: u64,
    },
    /// The server answered with an HTTP status other than 200.
    #[error("the model at {endpoint} answered with HTTP status {code}: {detail}")]
    Status {
        /// The address that was tried.
        endpoint: String,
        /// The HTTP status.
        code: u16,
        /// The beginning of what the server said about it.
        detail: String,
    },
    /// The answer is not what such a server sends, is cut off or withheld, or exceeds the size limit.
    #[error("the answer of {endpoint} cannot be used: {detail}")]
    BadReply {
        /// The address (or the recording) that answered.
        endpoint: String,
        /// What is wrong with the answer.
        detail: String,
    },
    /// The request cannot be put into the words of the provider.
    #[error("the request cannot be sent to {endpoint}: {detail}")]
    BadRequest {
        /// The address that it was meant for.
        endpoint: String,
        /// What is wrong with it.
        detail: String,
    },
    /// The mission may not ask any more.
    #[error("no more may be asked of the model: {spent}; allow more with --set budget=CALLS,TOKENS,SECONDS")]
    Budget {
        /// Which bound was reached, in words.
        spent: String,
    },
    /// A recording holds no (further) answer to this request.
    #[error("the recording has no answer to request {digest}; record it again with the model itself")]
    NotRecorded {
        /// [`ChatRequest::digest`] of the request.
        digest: String,
    },
    /// The recording could not be written.
    #[error("cannot write the recording: {detail}")]
    Recording {
        /// What the file system said.
        detail: String,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digest_separates_requests_that_concatenate_alike() {
        let one = ChatRequest::new(vec![Message::user("ab"), Message::user("c")]);
        let two = ChatRequest::new(vec![Message::user("a"), Message::user("bc")]);
        assert_ne!(one.digest(), two.digest());
    }

    #[test]
    fn digest_depends_on_every_field() {
        let base = ChatRequest::new(vec![Message::user("a").with_image(vec![1])]);
        let mut seen = vec![base.digest(), base.clone().as_json().digest()];
        for (name, text) in [("a", "{}"), ("a", "[]"), ("a{", "}")] {
            let schema = Schema { name: name.into(), text: text.into() };
            seen.push(base.clone().as_schema(schema).digest());
        }
        seen.push(ChatRequest { max_tokens: 7, ..base.clone() }.digest());
        seen.push(ChatRequest { temperature: 0.5, ..base.clone() }.digest());
        seen.push(ChatRequest::new(vec![Message::system("a").with_image(vec![1])]).digest());
        seen.push(ChatRequest::new(vec![Message::user("a").with_image(vec![2])]).digest());
        seen.push(ChatRequest::new(vec![Message::user("a")]).digest());
        let distinct: std::collections::BTreeSet<_> = seen.iter().collect();
        assert_eq!(distinct.len(), seen.len());
    }
}
