//! Servers of openpi: a WebSocket, and MessagePack with NumPy's arrays.
//!
//! The server first sends its metadata. Each observation, a map, gets an answer, a map with
//! `actions`; a text instead is the traceback of its error. It keeps nothing between questions, so
//! that a new connection is a new episode.

use rmpv::Value;

use super::address::Address;
use super::arrays::{Keys, Rows, entry, from_bytes, to_bytes};
use super::error::ServerError;
use super::limits::shown;
use super::question::{Answer, Episode, Question, Server};
use super::settings::Settings;
use super::websocket::{Connection, Deadline, Received};

/// What an address looks like.
pub(super) const EXAMPLE: &str = "openpi:ws://127.0.0.1:8000";

/// A policy of openpi.
pub struct OpenPi {
    address: Address,
    settings: Settings,
    connection: Option<Connection>,
}

impl OpenPi {
    /// The server at `ws://HOST:PORT`, which is not connected to yet.
    ///
    /// # Errors
    /// [`ServerError::Address`].
    pub fn new(address: &str, settings: Settings) -> Result<Self, ServerError> {
        Ok(Self {
            address: Address::parse(address, "ws", EXAMPLE)?,
            settings,
            connection: None,
        })
    }

    /// A new connection, on which the metadata have come.
    fn connect(&self) -> Result<Connection, ServerError> {
        let deadline = Deadline::after(self.settings.patience.begin);
        let mut connection = Connection::open(&self.address, deadline)?;
        message(connection.receive(deadline)?)?;
        Ok(connection)
    }

    fn observation(&self, question: &Question) -> Value {
        let keys = Keys::Bytes;
        let mut entries = vec![
            (
                self.settings.image.as_str(),
                keys.image(&self.settings.size.of(&question.image)),
            ),
            (self.settings.state.as_str(), keys.floats(&question.state())),
            ("prompt", Value::from(question.words.as_str())),
        ];
        if let Some(goal) = question.goal {
            entries.push(("observation/goal", keys.floats(&[goal.x, goal.y])));
        }
        let entries = entries.into_iter();
        Value::Map(
            entries
                .map(|(key, value)| (Value::from(key), value))
                .collect(),
        )
    }
}

impl Server for OpenPi {
    fn reach(&mut self) -> Result<(), ServerError> {
        self.connect().map(|_| ())
    }

    fn begin(&mut self, _: &Episode) -> Result<(), ServerError> {
        self.connection = Some(self.connect()?);
        Ok(())
    }

    fn ask(&mut self, question: &Question) -> Result<Answer, ServerError> {
        let observation = to_bytes(&self.observation(question));
        let deadline = Deadline::after(self.settings.within(question));
        let connection = self
            .connection
            .as_mut()
            .ok_or_else(ServerError::not_begun)?;
        connection.send(observation, deadline)?;
        let answer = message(connection.receive(deadline)?)?;
        let actions = entry(&answer, "actions");
        let actions = actions.ok_or_else(|| ServerError::unreadable("it lacks `actions`"))?;
        self.settings.answer(&Rows::read(actions)?)
    }

    fn end(&mut self) {
        self.connection = None;
    }
}

/// A map, unless it is a text, which reports an error.
fn message(received: Received) -> Result<Value, ServerError> {
    match received {
        Received::Binary(bytes) => from_bytes(&bytes),
        Received::Text(text) => Err(ServerError::Reported {
            detail: shown(&text),
        }),
    }
}
