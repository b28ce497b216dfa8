//! A chat endpoint on this machine that speaks as OpenAI's does and behaves as a test wants.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::json;

/// Sees the plate of unit 1 straight ahead.
pub const UNIT_1: &str =
    r#"{"plates": [{"text": "UNIT 1", "box": [280, 120, 360, 220], "confidence": 0.9}]}"#;
/// Sees no plate.
pub const NOTHING: &str = r#"{"plates": []}"#;

/// What the endpoint does with a request.
#[derive(Debug, Clone)]
pub enum Answer {
    /// The model says this.
    Says(String),
    /// An HTTP status without further words.
    Status(u16),
    /// A body that is sent as if it were an answer, status 200.
    Body(String),
    /// Nothing for longer than anybody waits.
    Silence,
    /// The connection is closed.
    HangUp,
}

/// An answer of the model.
pub fn says(text: impl Into<String>) -> Answer {
    Answer::Says(text.into())
}

/// Serves until the test ends; returns what to write after `reader=` or `planner=`. The answer
/// follows from the number of the request, from 0, and its body.
pub fn endpoint(answer: impl Fn(usize, &str) -> Answer + Send + Sync + 'static) -> String {
    let port = http(answer);
    format!("openai:parrot@http://127.0.0.1:{port}/v1")
}

/// As [`endpoint`]; returns the port.
pub fn http(answer: impl Fn(usize, &str) -> Answer + Send + Sync + 'static) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let (answer, asked) = (Arc::new(answer), Arc::new(AtomicUsize::new(0)));
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let (answer, asked) = (answer.clone(), asked.clone());
            std::thread::spawn(move || {
                let request = read(&stream)?;
                reply(
                    &stream,
                    answer(asked.fetch_add(1, Ordering::SeqCst), &request),
                )
            });
        }
    });
    port
}

/// An endpoint that always says the same.
pub fn reader_that_says(answer: &'static str) -> String {
    endpoint(move |_, _| says(answer))
}

/// A reader that answers what no reader says: the delivery fails where it is asked first.
pub fn babbler() -> String {
    reader_that_says("I see a door.")
}

/// The body of the one request of a connection. A client that has gone needs no answer.
fn read(stream: &TcpStream) -> Option<String> {
    let mut request = BufReader::new(stream);
    let mut length = 0;
    loop {
        let mut line = String::new();
        request.read_line(&mut line).ok()?;
        match line
            .trim()
            .to_ascii_lowercase()
            .strip_prefix("content-length:")
        {
            Some(bytes) => length = bytes.trim().parse().ok()?,
            None if line.trim().is_empty() => break,
            None => {}
        }
    }
    let mut body = Vec::new();
    request.take(length).read_to_end(&mut body).ok()?;
    // Images are no text.
    Some(String::from_utf8_lossy(&body).into_owned())
}

fn reply(mut stream: &TcpStream, answer: Answer) -> Option<()> {
    let (status, body) = match answer {
        Answer::Says(text) => {
            let message = json!({ "role": "assistant", "content": text });
            let usage = json!({ "prompt_tokens": 100, "completion_tokens": 10 });
            let choice = json!({ "message": message, "finish_reason": "stop" });
            (
                200,
                json!({ "choices": [choice], "usage": usage }).to_string(),
            )
        }
        Answer::Status(status) => (status, String::new()),
        Answer::Body(body) => (200, body),
        Answer::Silence => {
            std::thread::sleep(std::time::Duration::from_secs(30));
            return None;
        }
        Answer::HangUp => return None,
    };
    let head = format!(
        "HTTP/1.1 {status} X\r\ncontent-type: application/json\r\ncontent-length: \
        {}\r\nconnection: close\r\n\r\n",
        body.len()
    );
    stream.write_all((head + &body).as_bytes()).ok()
}
