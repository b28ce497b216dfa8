//! Model servers of vla-eval: a WebSocket, and MessagePack frames
//! `{type, payload, seq, timestamp}` with NumPy's arrays.
//!
//! `hello` is answered by `hello`, an `observation` by an `action` or an `error` with the same
//! `seq`; `episode_start` and `episode_end` are not answered.

use rmpv::Value;

use super::address::Address;
use super::arrays::{Keys, Rows, entry, from_bytes, text, to_bytes};
use super::error::ServerError;
use super::limits::shown;
use super::question::{Answer, Episode, Question, Server};
use super::settings::Settings;
use super::websocket::{Connection, Deadline, Received};

/// What an address looks like.
pub(super) const EXAMPLE: &str = "vla-eval:ws://127.0.0.1:8000";
/// Version of the protocol.
const PROTOCOL: u64 = 1;
/// Name of the camera among the images of an observation.
const CAMERA: &str = "camera";

/// A policy of vla-eval.
pub struct VlaEval {
    address: Address,
    settings: Settings,
    connection: Option<Connection>,
    /// Number of the last frame.
    seq: u64,
}

impl VlaEval {
    /// The server at `ws://HOST:PORT`, which is not connected to yet.
    ///
    /// # Errors
    /// [`ServerError::Address`].
    pub fn new(address: &str, settings: Settings) -> Result<Self, ServerError> {
        Ok(Self {
            address: Address::parse(address, "ws", EXAMPLE)?,
            settings,
            connection: None,
            seq: 0,
        })
    }

    /// Connects anew, and exchanges greetings.
    fn greet(&mut self) -> Result<(), ServerError> {
        let deadline = Deadline::after(self.settings.patience.begin);
        self.connection = Some(Connection::open(&self.address, deadline)?);
        let hello = map([
            ("harness_version", Value::from(env!("CARGO_PKG_VERSION"))),
            ("protocol_version", Value::from(PROTOCOL)),
            ("benchmark", Value::from("openbench")),
        ]);
        let seq = self.send("hello", hello, deadline)?;
        self.receive("hello", seq, deadline).map(|_| ())
    }

    /// Sends a frame and returns its number.
    fn send(&mut self, kind: &str, payload: Value, deadline: Deadline) -> Result<u64, ServerError> {
        self.seq += 1;
        let frame = map([
            ("type", Value::from(kind)),
            ("payload", payload),
            ("seq", Value::from(self.seq)),
            // Simulated time has no place in the protocol, and wall time would not repeat.
            ("timestamp", Value::from(0.0)),
        ]);
        let connection = self
            .connection
            .as_mut()
            .ok_or_else(ServerError::not_begun)?;
        connection.send(to_bytes(&frame), deadline)?;
        Ok(self.seq)
    }

    /// The payload of the frame that answers the frame of this number.
    fn receive(&mut self, kind: &str, seq: u64, deadline: Deadline) -> Result<Value, ServerError> {
        let connection = self
            .connection
            .as_mut()
            .ok_or_else(ServerError::not_begun)?;
        let frame = match connection.receive(deadline)? {
            Received::Binary(bytes) => from_bytes(&bytes)?,
            Received::Text(text) => {
                let detail = shown(&text);
                return Err(ServerError::Reported { detail });
            }
        };
        let payload = entry(&frame, "payload").unwrap_or(&Value::Nil);
        let found = entry(&frame, "type").and_then(text).unwrap_or_default();
        if found == "error" {
            let detail = entry(payload, "error").and_then(text);
            let detail = shown(detail.unwrap_or("it does not say which"));
            return Err(ServerError::Reported { detail });
        }
        if found != kind {
            let detail = format!("its type is `{}` instead of `{kind}`", shown(found));
            return Err(ServerError::unreadable(detail));
        }
        if entry(&frame, "seq").and_then(Value::as_u64) != Some(seq) {
            return Err(ServerError::unreadable("it answers another question"));
        }
        // Taken out instead of copied.
        let Value::Map(entries) = frame else {
            return Err(ServerError::unreadable("it is no map"));
        };
        let is_payload = |(key, _): &(Value, Value)| text(key) == Some("payload");
        let payload = entries.into_iter().find(is_payload);
        Ok(payload.map_or(Value::Nil, |(_, payload)| payload))
    }
}

impl Server for VlaEval {
    fn reach(&mut self) -> Result<(), ServerError> {
        self.greet()?;
        self.connection = None;
        Ok(())
    }

    fn begin(&mut self, episode: &Episode) -> Result<(), ServerError> {
        self.greet()?;
        let deadline = Deadline::after(self.settings.patience.begin);
        let task = map([
            ("name", Value::from(episode.words.as_str())),
            ("seed", Value::from(episode.seed)),
        ]);
        self.send("episode_start", map([("task", task)]), deadline)?;
        Ok(())
    }

    fn ask(&mut self, question: &Question) -> Result<Answer, ServerError> {
        let keys = Keys::Text;
        let mut state = question.state().to_vec();
        state.extend(question.goal.iter().flat_map(|goal| [goal.x, goal.y]));
        let observation = map([
            (
                "images",
                map([(CAMERA, keys.image(&self.settings.size.of(&question.image)))]),
            ),
            ("task_description", Value::from(question.words.as_str())),
            ("states", keys.floats(&state)),
        ]);
        let deadline = Deadline::after(self.settings.within(question));
        let seq = self.send("observation", observation, deadline)?;
        let payload = self.receive("action", seq, deadline)?;
        let actions = entry(&payload, "actions");
        let actions = actions.ok_or_else(|| ServerError::unreadable("it lacks `actions`"))?;
        self.settings.answer(&Rows::read(actions)?)
    }

    fn end(&mut self) {
        // The judge's scores are not known yet, and no policy's business.
        let metrics = Value::Map(Vec::new());
        // A server that is gone needs not know.
        let deadline = Deadline::after(self.settings.patience.act);
        let _ = self.send("episode_end", map([("metrics", metrics)]), deadline);
        self.connection = None;
    }
}

fn map<const N: usize>(entries: [(&str, Value); N]) -> Value {
    let entries = entries.into_iter();
    Value::Map(
        entries
            .map(|(key, value)| (Value::from(key), value))
            .collect(),
    )
}
