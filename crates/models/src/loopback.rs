//! A server on this machine that answers by a script, for tests of what goes over HTTP.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread::JoinHandle;
use std::time::Duration;

/// An answer that is none: the connection is held open without a byte.
pub(crate) const SILENCE: &str = "silence";

/// A server that answers one connection with each text of its script, verbatim.
pub(crate) struct Loopback {
    /// `http://127.0.0.1:PORT`.
    pub address: String,
    thread: JoinHandle<Vec<String>>,
}

impl Loopback {
    pub(crate) fn serve(script: Vec<String>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("http://{}", listener.local_addr().unwrap());
        let thread =
            std::thread::spawn(move || script.iter().map(|answer| exchange(&listener, answer)).collect());
        Self { address, thread }
    }

    /// Waits until the script is through and returns the requests, heads and bodies.
    pub(crate) fn requests(self) -> Vec<String> {
        self.thread.join().unwrap()
    }
}

/// An answer with a status such as `200 OK` and a body.
pub(crate) fn http(status: &str, body: &str) -> String {
    format!("HTTP/1.1 {status}\r\ncontent-length: {}\r\nconnection: close\r\n\r\n{body}", body.len())
}

fn exchange(listener: &TcpListener, answer: &str) -> String {
    let (mut stream, _) = listener.accept().unwrap();
    let request = read_request(&stream);
    if answer == SILENCE {
        std::thread::sleep(Duration::from_millis(600));
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
