//! The contract of a chat model: messages in, one text out.
//!
//! It contains what providers have in common: roles, images beside text, and a request for JSON or
//! for JSON of a schema. Streaming, tools and several choices are not part of it. All types can be
//! written to a file and read back unchanged, including errors, so that a recorded conversation
//! replays exactly ([`crate::replay`]).

use openbench_core::ModelUse;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// A model that answers a conversation: a remote endpoint, a recording, or a script in a test.
///
/// Implementations are shared between threads. A call blocks until there is an answer or an error,
/// so an implementation that waits must have a time-out.
///
/// ```
/// use openbench_models::{ChatError, ChatModel, ChatReply, ChatRequest, Message};
///
/// /// Repeats the last message.
/// struct Echo;
///
/// impl ChatModel for Echo {
///     fn name(&self) -> &str {
///         "echo"
///     }
///
///     fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
///         let last = request.messages.last();
///         let text = last.map_or(String::new(), |message| message.text.clone());
///         Ok(ChatReply { text, prompt_tokens: 4, completion_tokens: 4 })
///     }
/// }
///
/// let request = ChatRequest::new(vec![Message::user("To unit2, building1.")]);
/// let counted = Echo.chat_counted(&request);
/// assert_eq!(counted.reply?.text, "To unit2, building1.");
/// assert_eq!((counted.used.calls, counted.used.prompt_tokens), (1, 4));
/// # Ok::<(), ChatError>(())
/// ```
pub trait ChatModel: Send + Sync {
    /// The name of the model in results, without endpoint and without secrets.
    fn name(&self) -> &str;

    /// Answers the conversation with one text.
    ///
    /// # Errors
    /// Any [`ChatError`]. The implementation retries where that helps, so an error is final.
    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError>;

    /// [`ChatModel::chat`] with its cost, which an error has as well.
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

/// The author of a [`Message`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Instructions in front of the conversation.
    System,
    /// The user.
    User,
    /// The model, in an earlier turn.
    Assistant,
}

/// One turn of a conversation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Message {
    /// The author.
    pub role: Role,
    /// The text.
    pub text: String,
    /// Images beside the text, each a complete PNG or JPEG file.
    pub images: Vec<Vec<u8>>,
}

impl Message {
    /// Instructions for the model.
    pub fn system(text: impl Into<String>) -> Self {
        Self {
            role: Role::System,
            text: text.into(),
            images: Vec::new(),
        }
    }

    /// A message of the user, without images.
    pub fn user(text: impl Into<String>) -> Self {
        Self {
            role: Role::User,
            text: text.into(),
            images: Vec::new(),
        }
    }

    /// An earlier answer of the model.
    pub fn assistant(text: impl Into<String>) -> Self {
        Self {
            role: Role::Assistant,
            text: text.into(),
            images: Vec::new(),
        }
    }

    /// Adds an image, a complete PNG or JPEG file.
    #[must_use]
    pub fn with_image(mut self, file: Vec<u8>) -> Self {
        self.images.push(file);
        self
    }
}

/// The required form of an answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Format {
    /// Free text.
    Text,
    /// One JSON object.
    Json,
    /// One JSON object of this schema where the provider can enforce a schema, else one JSON
    /// object.
    Schema(Schema),
}

/// A JSON Schema.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Schema {
    /// Name of the schema: ASCII letters, digits, `_` and `-` only.
    pub name: String,
    /// The schema as JSON text, which is an object.
    pub text: String,
}

/// A request to a [`ChatModel`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChatRequest {
    /// The conversation so far, oldest message first.
    pub messages: Vec<Message>,
    /// The required form of the answer. Servers do not guarantee it: callers must check.
    pub format: Format,
    /// Maximum length of the answer, tokens of the model.
    pub max_tokens: u32,
    /// Sampling temperature; 0 requests the most probable answer.
    pub temperature: f32,
}

impl ChatRequest {
    /// A request for plain text of at most 1024 tokens, at temperature 0.
    pub fn new(messages: Vec<Message>) -> Self {
        Self {
            messages,
            format: Format::Text,
            max_tokens: 1024,
            temperature: 0.0,
        }
    }

    /// Requests one JSON object.
    #[must_use]
    pub fn as_json(mut self) -> Self {
        self.format = Format::Json;
        self
    }

    /// Requests one JSON object of a schema.
    #[must_use]
    pub fn as_schema(mut self, schema: Schema) -> Self {
        self.format = Format::Schema(schema);
        self
    }

    /// SHA-256 over all fields, in hexadecimal digits. The length of each part is hashed before the
    /// part, so different requests have different encodings.
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
        // The bits, since a digest must not depend on how a number is printed.
        hasher.update(self.temperature.to_bits().to_le_bytes());
        for message in &self.messages {
            hasher.update([message.role as u8]);
            hash_part(&mut hasher, message.text.as_bytes());
            // The number of images, so that no image can pass for the next message.
            hasher.update((message.images.len() as u64).to_le_bytes());
            message
                .images
                .iter()
                .for_each(|image| hash_part(&mut hasher, image));
        }
        crate::digest::hex(&hasher.finalize())
    }
}

fn hash_part(hasher: &mut Sha256, bytes: &[u8]) {
    hasher.update((bytes.len() as u64).to_le_bytes());
    hasher.update(bytes);
}

/// The answer of a [`ChatModel`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChatReply {
    /// The text, as the model wrote it.
    pub text: String,
    /// Tokens of the request; 0 if the server does not report them.
    pub prompt_tokens: u32,
    /// Tokens of the answer; 0 if the server does not report them.
    pub completion_tokens: u32,
}

/// The answer of a [`ChatModel`] or its error, with the cost.
#[derive(Debug, Clone, PartialEq)]
pub struct CountedReply {
    /// The answer or the error.
    pub reply: Result<ChatReply, ChatError>,
    /// Calls, tokens and time of all attempts together.
    pub used: ModelUse,
}

impl CountedReply {
    /// The outcome of one call, with a latency of 0.
    pub fn of_one_call(reply: Result<ChatReply, ChatError>) -> Self {
        let mut used = ModelUse {
            calls: 1,
            ..ModelUse::default()
        };
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

/// Why there is no answer. No variant contains a key.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum ChatError {
    /// The server cannot be reached, or the connection broke.
    #[error(
        "cannot reach the model at {endpoint}: {detail}; check the address and whether the server \
         is running"
    )]
    Unreachable {
        /// The address of the request.
        endpoint: String,
        /// The error of the network.
        detail: String,
    },
    /// The server did not answer in time.
    #[error(
        "the model at {endpoint} did not answer within {seconds} s; use a longer time-out or a \
         faster model"
    )]
    Timeout {
        /// The address of the request.
        endpoint: String,
        /// The time-out, seconds, rounded up.
        seconds: u64,
    },
    /// The HTTP status of the answer is not 200.
    #[error("the model at {endpoint} answered with HTTP status {code}: {detail}")]
    Status {
        /// The address of the request.
        endpoint: String,
        /// The HTTP status.
        code: u16,
        /// The beginning of the server's message.
        detail: String,
    },
    /// The answer is malformed, truncated, withheld, or longer than the limit.
    #[error("the answer of {endpoint} cannot be used: {detail}")]
    BadReply {
        /// The address of the request.
        endpoint: String,
        /// What is wrong with the answer.
        detail: String,
    },
    /// The request cannot be expressed in the protocol of the provider.
    #[error("the request cannot be sent to {endpoint}: {detail}")]
    BadRequest {
        /// The address of the endpoint.
        endpoint: String,
        /// What is wrong with the request.
        detail: String,
    },
    /// The budget of the mission is exhausted.
    #[error(
        "the budget for models is exhausted: {spent}; raise it with \
         --set budget=CALLS,TOKENS,SECONDS"
    )]
    Budget {
        /// The limit that was reached, in words.
        spent: String,
    },
    /// A recording contains no further answer to this request.
    #[error("the recording contains no answer to request {digest}; record it again with the model")]
    NotRecorded {
        /// [`ChatRequest::digest`] of the request.
        digest: String,
    },
    /// The recording cannot be written.
    #[error("cannot write the recording: {detail}")]
    Recording {
        /// The error of the file system.
        detail: String,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_with_equal_concatenation_have_different_digests() {
        let one = ChatRequest::new(vec![Message::user("ab"), Message::user("c")]);
        let two = ChatRequest::new(vec![Message::user("a"), Message::user("bc")]);
        assert_ne!(one.digest(), two.digest());
    }

    #[test]
    fn the_digest_depends_on_each_field() {
        let base = ChatRequest::new(vec![Message::user("a").with_image(vec![1])]);
        let mut seen = vec![base.digest(), base.clone().as_json().digest()];
        for (name, text) in [("a", "{}"), ("a", "[]"), ("a{", "}")] {
            let schema = Schema {
                name: name.into(),
                text: text.into(),
            };
            seen.push(base.clone().as_schema(schema).digest());
        }
        seen.push(
            ChatRequest {
                max_tokens: 7,
                ..base.clone()
            }
            .digest(),
        );
        seen.push(
            ChatRequest {
                temperature: 0.5,
                ..base.clone()
            }
            .digest(),
        );
        seen.push(ChatRequest::new(vec![Message::system("a").with_image(vec![1])]).digest());
        seen.push(ChatRequest::new(vec![Message::user("a").with_image(vec![2])]).digest());
        seen.push(ChatRequest::new(vec![Message::user("a")]).digest());
        let distinct: std::collections::BTreeSet<_> = seen.iter().collect();
        assert_eq!(distinct.len(), seen.len());
    }
}
