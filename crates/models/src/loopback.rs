//! A scripted HTTP server on loopback, for tests.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread::JoinHandle;
use std::time::Duration;

/// In a script: no answer, while the connection stays open.
pub(crate) const SILENCE: &str = "silence";
/// How long the connection stays open then.
const SILENCE_TIME: Duration = Duration::from_millis(600);

/// A server that answers each connection with the next text of its script, verbatim.
pub(crate) struct Loopback {
    /// `http://127.0.0.1:PORT`.
    pub address: String,
    thread: JoinHandle<Vec<String>>,
}

impl Loopback {
    /// Starts a server with an answer for each of several connections.
    pub(crate) fn serve(script: Vec<String>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("http://{}", listener.local_addr().unwrap());
        let thread = std::thread::spawn(move || {
            script
                .iter()
                .map(|answer| exchange(&listener, answer))
                .collect()
        });
        Self { address, thread }
    }

    /// Waits for the end of the script and returns the requests, with heads and bodies.
    pub(crate) fn requests(self) -> Vec<String> {
        self.thread.join().unwrap()
    }
}

/// An answer with this status, such as `200 OK`, and body.
pub(crate) fn http(status: &str, body: &str) -> String {
    format!(
        "HTTP/1.1 {status}\r\ncontent-length: {}\r\nconnection: close\r\n\r\n{body}",
        body.len()
    )
}

fn exchange(listener: &TcpListener, answer: &str) -> String {
    let (mut stream, _) = listener.accept().unwrap();
    let request = read_request(&stream);
    if answer == SILENCE {
        std::thread::sleep(SILENCE_TIME);
    } else {
        stream.write_all(answer.as_bytes()).unwrap();
    }
    request
}

fn read_request(stream: &TcpStream) -> String {
    let mut reader = BufReader::new(stream);
    let (mut head, mut length) = (String::new(), 0);
    while !head.ends_with("\r\n\r\n") {
        let start = head.len();
        reader.read_line(&mut head).unwrap();
        if let Some(value) = head[start..].to_lowercase().strip_prefix("content-length:") {
            length = value.trim().parse().unwrap();
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).unwrap();
    head + &String::from_utf8(body).unwrap()
}
