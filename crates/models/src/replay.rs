//! Records the answers of a chat model and repeats them.
//!
//! A recording has one JSON object on each line: an exchange, which may be an error. Exchanges are
//! found by [`ChatRequest::digest`]; several answers to one request are repeated in their order.
//!
//! Images are recorded as their SHA-256 only, so a request cannot be sent again from a recording.
//! If threads share a recorder, equal requests of different threads may exchange their answers:
//! give each episode a recorder of its own.

use std::collections::{BTreeMap, VecDeque};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use openbench_core::{ModelUse, with_causes};
use serde::{Deserialize, Serialize};

use crate::chat::{ChatError, ChatModel, ChatReply, ChatRequest, CountedReply, Message, Role};
use crate::digest::sha256_of;
use crate::error::{Cause, ReplayError};

/// Limit for what one recorder writes, bytes. Three recorders in one file stay below the limit for
/// reading.
const MAX_WRITTEN_BYTES: u64 = 80 << 20;
/// Limit for the length of a recording that is read, bytes.
const MAX_READ_BYTES: u64 = 256 << 20;

/// One line of a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Exchange {
    digest: String,
    model: String,
    /// For people; replay uses the digest only.
    #[serde(default)]
    messages: Vec<RecordedMessage>,
    outcome: Outcome,
    /// The cost.
    #[serde(default)]
    used: ModelUse,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct RecordedMessage {
    role: Role,
    text: String,
    /// SHA-256 of each image.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    images: Vec<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Outcome {
    Reply(ChatReply),
    Error(ChatError),
}

impl Exchange {
    fn new(model: &str, request: &ChatRequest, counted: &CountedReply) -> Self {
        let outcome = match &counted.reply {
            Ok(reply) => Outcome::Reply(reply.clone()),
            Err(error) => Outcome::Error(error.clone()),
        };
        Self {
            digest: request.digest(),
            model: model.to_owned(),
            messages: request.messages.iter().map(RecordedMessage::new).collect(),
            outcome,
            used: counted.used,
        }
    }
}

impl RecordedMessage {
    fn new(message: &Message) -> Self {
        // Reading from memory does not fail.
        let images = message
            .images
            .iter()
            .filter_map(|image| sha256_of(&image[..]).ok())
            .collect();
        Self {
            role: message.role,
            text: message.text.clone(),
            images,
        }
    }
}

/// A [`ChatModel`] that records each exchange with the model inside it.
#[derive(Debug)]
pub struct Recorder<M, W> {
    model: M,
    sink: Mutex<Sink<W>>,
}

#[derive(Debug)]
struct Sink<W> {
    writer: W,
    /// Number of bytes that this recorder wrote.
    written: u64,
}

impl<W: Write> Sink<W> {
    fn write(&mut self, exchange: &Exchange) -> std::io::Result<()> {
        let mut line = serde_json::to_vec(exchange)?;
        line.push(b'\n');
        // Counted before the test and not taken back: once the limit is passed nothing more is
        // written, so the recording has no gap.
        self.written += line.len() as u64;
        if self.written > MAX_WRITTEN_BYTES {
            let detail = format!("it would be longer than {MAX_WRITTEN_BYTES} bytes");
            return Err(std::io::Error::new(
                std::io::ErrorKind::FileTooLarge,
                detail,
            ));
        }
        // One call for the whole line, since several recorders may share a file.
        self.writer.write_all(&line)?;
        self.writer.flush()
    }
}

impl<M: ChatModel, W: Write + Send> Recorder<M, W> {
    /// Records to `sink`: a file, or a `Vec<u8>` in memory. Each exchange is flushed.
    pub fn new(model: M, sink: W) -> Self {
        Self {
            model,
            sink: Mutex::new(Sink {
                writer: sink,
                written: 0,
            }),
        }
    }

    /// Ends the recording and returns the sink.
    pub fn into_sink(self) -> W {
        self.sink
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
            .writer
    }
}

impl<M: ChatModel, W: Write + Send> ChatModel for Recorder<M, W> {
    fn name(&self) -> &str {
        self.model.name()
    }

    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
        self.chat_counted(request).reply
    }

    fn chat_counted(&self, request: &ChatRequest) -> CountedReply {
        let counted = self.model.chat_counted(request);
        // Errors are recorded too: a replay must fail where the model failed.
        let exchange = Exchange::new(self.name(), request, &counted);
        let written = self
            .sink
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .write(&exchange);
        match written {
            Ok(()) => counted,
            Err(error) => {
                let error = ChatError::Recording {
                    detail: with_causes(&error),
                };
                CountedReply {
                    reply: Err(error),
                    used: counted.used,
                }
            }
        }
    }
}

/// A [`ChatModel`] that repeats recorded answers exactly.
///
/// ```
/// use openbench_models::{ChatModel, ChatRequest, Message, Recorder, Replay};
/// # use openbench_models::{ChatError, ChatReply};
/// # struct Model;
/// # impl ChatModel for Model {
/// #     fn name(&self) -> &str { "model" }
/// #     fn chat(&self, _: &ChatRequest) -> Result<ChatReply, ChatError> {
/// #         Ok(ChatReply { text: "unit2".into(), prompt_tokens: 9, completion_tokens: 2 })
/// #     }
/// # }
/// # let model = Model;
///
/// let request = ChatRequest::new(vec![Message::user("Which unit?")]);
/// let recorder = Recorder::new(model, Vec::new());
/// let answer = recorder.chat(&request);
///
/// let replay = Replay::from_reader(&recorder.into_sink()[..])?;
/// assert_eq!(replay.chat(&request), answer);
/// # Ok::<(), openbench_models::ReplayError>(())
/// ```
#[derive(Debug)]
pub struct Replay {
    name: String,
    answers: Mutex<BTreeMap<String, VecDeque<CountedReply>>>,
}

impl Replay {
    /// Reads a recording file.
    ///
    /// # Errors
    /// [`ReplayError`] if the file cannot be read, is longer than 256 MiB, or a line is not an
    /// exchange.
    pub fn open(file: &Path) -> Result<Self, ReplayError> {
        let reader = openbench_core::input::open(file).map_err(|source| ReplayError::Read {
            file: file.into(),
            source,
        })?;
        Self::from_reader(reader)
    }

    /// The same answers under another name. Models that were recorded to one file share the
    /// recording, since the same request may have been sent to each of them.
    pub fn named(self: &Arc<Self>, name: &str) -> impl ChatModel + use<> {
        Named {
            replay: Arc::clone(self),
            name: name.to_owned(),
        }
    }

    /// Reads a recording from memory or a stream.
    ///
    /// # Errors
    /// [`ReplayError::BadLine`], also for the line that exceeds 256 MiB.
    pub fn from_reader(reader: impl Read) -> Result<Self, ReplayError> {
        let mut name = None;
        let mut answers = BTreeMap::<String, VecDeque<CountedReply>>::new();
        let mut read_bytes = 0;
        for (index, line) in BufReader::new(reader)
            // Bounded here: a single line could be of any length.
            .take(MAX_READ_BYTES)
            .lines()
            .enumerate()
        {
            let line = line.map_err(|error| bad_line(index, error))?;
            read_bytes += line.len() as u64 + 1;
            if read_bytes >= MAX_READ_BYTES {
                let detail = format!("the recording is longer than {MAX_READ_BYTES} bytes");
                return Err(bad_line(index, detail));
            }
            if line.trim().is_empty() {
                continue;
            }
            let exchange: Exchange =
                serde_json::from_str(&line).map_err(|error| bad_line(index, error))?;
            name.get_or_insert(exchange.model);
            let reply = match exchange.outcome {
                Outcome::Reply(reply) => Ok(reply),
                Outcome::Error(error) => Err(error),
            };
            let counted = CountedReply {
                reply,
                used: exchange.used,
            };
            answers
                .entry(exchange.digest)
                .or_default()
                .push_back(counted);
        }
        Ok(Self {
            name: name.unwrap_or_else(|| "replay".into()),
            answers: Mutex::new(answers),
        })
    }
}

/// The error of a line, counted from 0.
fn bad_line(index: usize, source: impl Into<Cause>) -> ReplayError {
    ReplayError::BadLine {
        line: index + 1,
        source: source.into(),
    }
}

impl ChatModel for Replay {
    fn name(&self) -> &str {
        &self.name
    }

    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
        self.chat_counted(request).reply
    }

    fn chat_counted(&self, request: &ChatRequest) -> CountedReply {
        let digest = request.digest();
        let mut answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        // Used up, not repeated: a request that was recorded once and is sent twice differs from
        // the recorded run.
        match answers.get_mut(&digest).and_then(VecDeque::pop_front) {
            Some(counted) => counted,
            None => CountedReply::of_one_call(Err(ChatError::NotRecorded { digest })),
        }
    }
}

/// A shared [`Replay`] with its own name.
struct Named {
    replay: Arc<Replay>,
    name: String,
}

impl ChatModel for Named {
    fn name(&self) -> &str {
        &self.name
    }

    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
        self.replay.chat(request)
    }

    fn chat_counted(&self, request: &ChatRequest) -> CountedReply {
        self.replay.chat_counted(request)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;
    use crate::chat::Message;

    /// A model that answers with the number of the call and fails each third time.
    struct Counting(AtomicU32);

    impl ChatModel for Counting {
        fn name(&self) -> &str {
            "counting"
        }

        fn chat(&self, _: &ChatRequest) -> Result<ChatReply, ChatError> {
            let call = self.0.fetch_add(1, Ordering::SeqCst);
            if call % 3 == 2 {
                return Err(ChatError::Timeout {
                    endpoint: "e".into(),
                    seconds: 1,
                });
            }
            Ok(ChatReply {
                text: format!("{call} \u{2028} \"ü\"\n"),
                prompt_tokens: call,
                completion_tokens: 0,
            })
        }
    }

    #[test]
    fn a_replay_repeats_the_answers_of_the_model() {
        let recorder = Recorder::new(Counting(AtomicU32::new(0)), Vec::new());
        let requests: Vec<_> = ["a", "b", "a", "b", "a"]
            .map(|text| ChatRequest::new(vec![Message::user(text)]))
            .into();
        let first: Vec<_> = requests
            .iter()
            .map(|request| recorder.chat(request))
            .collect();
        let replay = Replay::from_reader(&recorder.into_sink()[..]).unwrap();
        assert_eq!(replay.name(), "counting");
        // The order of different requests does not matter.
        for index in [1, 0, 2, 4, 3] {
            assert_eq!(replay.chat(&requests[index]), first[index], "{index}");
        }
        assert!(matches!(
            replay.chat(&requests[0]),
            Err(ChatError::NotRecorded { .. })
        ));
    }

    #[test]
    fn images_are_recorded_as_their_digest() {
        let recorder = Recorder::new(Counting(AtomicU32::new(0)), Vec::new());
        recorder
            .chat(&ChatRequest::new(vec![
                Message::user("x").with_image(b"abc".to_vec()),
            ]))
            .unwrap();
        let text = String::from_utf8(recorder.into_sink()).unwrap();
        assert!(
            text.contains("ba7816bf8f01cfea") && text.lines().count() == 1,
            "{text}"
        );
    }

    #[test]
    fn errors_of_recordings_name_the_line() {
        let error = Replay::from_reader(&b"\n{\"digest\": 3}\n"[..]).unwrap_err();
        assert!(
            matches!(error, ReplayError::BadLine { line: 2, .. }),
            "{error}"
        );
        assert!(matches!(
            Replay::open(Path::new("/nonexistent")),
            Err(ReplayError::Read { .. })
        ));
    }
}
