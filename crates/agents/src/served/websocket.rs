//! A WebSocket connection to a policy server, limited in time and length.

use std::io::{self, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpStream, ToSocketAddrs};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, HandshakeError, Message, WebSocket};

use super::address::Address;
use super::error::ServerError;
use super::limits::{MAX_ANSWER_BYTES, shown};

/// Each address of a host gets that long at least to answer.
const LEAST_WAIT: Duration = Duration::from_millis(1);

/// A connection.
pub struct Connection {
    socket: WebSocket<TimedStream>,
}

/// Until when an exchange may last, sending and receiving together.
#[derive(Debug, Clone, Copy)]
pub struct Deadline {
    until: Instant,
    within: Duration,
}

impl Deadline {
    /// That long from now on.
    pub fn after(within: Duration) -> Self {
        Self {
            until: Instant::now() + within,
            within,
        }
    }
}

/// What a server sent.
#[derive(Debug, Clone, PartialEq)]
pub enum Received {
    /// Bytes.
    Binary(Vec<u8>),
    /// Text, which a server that fails may send instead.
    Text(String),
}

impl Connection {
    /// Connects to `ws://HOST:PORT/PATH`; an address without a port means port 80.
    ///
    /// # Errors
    /// [`ServerError::Unreachable`], or [`ServerError::Silent`].
    pub fn open(address: &Address, deadline: Deadline) -> Result<Self, ServerError> {
        let Deadline { until, within } = deadline;
        let stream = connect(address, within)?;
        let config = WebSocketConfig::default()
            .max_message_size(Some(MAX_ANSWER_BYTES))
            .max_frame_size(Some(MAX_ANSWER_BYTES));
        let stream = TimedStream { stream, until };
        let shaken = tungstenite::client::client_with_config(address.url(), stream, Some(config));
        match shaken {
            Ok((socket, _)) => Ok(Self { socket }),
            Err(HandshakeError::Failure(Error::Io(error))) if is_late(&error) => {
                Err(ServerError::Silent { within })
            }
            Err(HandshakeError::Failure(error)) => Err(unreachable(address, &error)),
            // It blocks, so that it is not interrupted.
            Err(HandshakeError::Interrupted(_)) => Err(ServerError::Silent { within }),
        }
    }

    /// Sends bytes.
    ///
    /// # Errors
    /// [`ServerError::Silent`] if the server does not take them in time, or
    /// [`ServerError::Closed`].
    pub fn send(&mut self, bytes: Vec<u8>, deadline: Deadline) -> Result<(), ServerError> {
        let Deadline { until, within } = deadline;
        self.socket.get_mut().until = until;
        let sent = self.socket.send(Message::binary(bytes));
        sent.map_err(|error| failure(error, within))
    }

    /// Waits for a message. Pings are answered meanwhile.
    ///
    /// # Errors
    /// As [`send`](Self::send), or [`ServerError::TooLong`].
    pub fn receive(&mut self, deadline: Deadline) -> Result<Received, ServerError> {
        let Deadline { until, within } = deadline;
        self.socket.get_mut().until = until;
        loop {
            match self.socket.read().map_err(|error| failure(error, within))? {
                Message::Binary(bytes) => return Ok(Received::Binary(bytes.to_vec())),
                Message::Text(text) => return Ok(Received::Text(text.to_string())),
                Message::Close(frame) => {
                    let detail = frame.map_or_else(
                        || "without a reason".to_owned(),
                        |frame| format!("{} {}", frame.code, shown(frame.reason.as_str())),
                    );
                    return Err(ServerError::Closed { detail });
                }
                Message::Ping(_) | Message::Pong(_) | Message::Frame(_) => {}
            }
        }
    }
}

fn failure(error: Error, within: Duration) -> ServerError {
    match error {
        Error::Io(error) if is_late(&error) => ServerError::Silent { within },
        Error::Capacity(_) => ServerError::TooLong,
        Error::Protocol(_) | Error::Utf8(_) => ServerError::unreadable(error.to_string()),
        error => ServerError::Closed {
            detail: error.to_string(),
        },
    }
}

fn is_late(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock
    )
}

/// Connects to a server.
///
/// # Errors
/// [`ServerError::Unreachable`].
pub fn connect(address: &Address, within: Duration) -> Result<TcpStream, ServerError> {
    let until = Instant::now() + within;
    first_that_answers(address, until).map_err(|error| unreachable(address, &error))
}

fn unreachable(address: &Address, error: &impl std::fmt::Display) -> ServerError {
    ServerError::Unreachable {
        address: address.host_and_port(),
        detail: shown(&error.to_string()),
    }
}

/// A connection with the first address of a host that answers.
fn first_that_answers(address: &Address, until: Instant) -> io::Result<TcpStream> {
    let mut last = None;
    for socket in looked_up(address, until)? {
        let left = until.saturating_duration_since(Instant::now());
        match TcpStream::connect_timeout(&socket, left.max(LEAST_WAIT)) {
            Ok(stream) => {
                // A question is one message: waiting for more would only cost time.
                stream.set_nodelay(true)?;
                return Ok(stream);
            }
            Err(error) => last = Some(error),
        }
    }
    Err(last.unwrap_or_else(|| io::ErrorKind::AddrNotAvailable.into()))
}

/// The addresses of a host. The system's lookup has no limit in time, so that it gets a thread,
/// which is left alone when it is late.
fn looked_up(address: &Address, until: Instant) -> io::Result<Vec<SocketAddr>> {
    if let Ok(ip) = address.host.parse::<IpAddr>() {
        return Ok(vec![SocketAddr::new(ip, address.port)]);
    }
    let (sender, receiver) = mpsc::channel();
    let (host, port) = (address.host.clone(), address.port);
    thread::Builder::new()
        .name("lookup".to_owned())
        .spawn(move || {
            let found = (host.as_str(), port).to_socket_addrs();
            // Nobody waits any more after the time limit.
            let _ = sender.send(found.map(Iterator::collect));
        })?;
    let left = until.saturating_duration_since(Instant::now());
    receiver.recv_timeout(left).unwrap_or_else(|_| {
        let problem = "the name of the host was not found in time";
        Err(io::Error::new(io::ErrorKind::TimedOut, problem))
    })
}

/// A stream whose reads and writes end at an instant, however slowly bytes trickle in.
struct TimedStream {
    stream: TcpStream,
    until: Instant,
}

impl TimedStream {
    fn left(&self) -> io::Result<Option<Duration>> {
        let left = self.until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        Ok(Some(left))
    }
}

impl Read for TimedStream {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(self.left()?)?;
        self.stream.read(buffer)
    }
}

impl Write for TimedStream {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(self.left()?)?;
        self.stream.write(buffer)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    const WITHIN: Duration = Duration::from_secs(5);

    fn address(host: &str, port: u16) -> Address {
        let text = format!("ws://{host}:{port}");
        Address::parse(&text, "ws", "ws://127.0.0.1:8000").unwrap()
    }

    #[test]
    fn hosts_are_found_by_number_and_by_name() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        for host in ["127.0.0.1", "localhost"] {
            connect(&address(host, port), WITHIN).unwrap();
        }
    }

    #[test]
    fn a_host_that_nobody_knows_is_unreachable() {
        let refused = connect(&address("no-such-host.invalid", 80), WITHIN);
        assert!(matches!(refused, Err(ServerError::Unreachable { .. })));
    }
}
