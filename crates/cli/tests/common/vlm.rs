//! A vision-language model behind an OpenAI-compatible endpoint on this machine that always says the same.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};

/// Sees the plate of unit 1 straight ahead.
pub const UNIT_1: &str =
    r#"{"plates": [{"text": "UNIT 1", "box": [280, 120, 360, 220], "confidence": 0.9}]}"#;
/// Sees no plate.
pub const NOTHING: &str = r#"{"plates": []}"#;

/// Serves until the test ends; returns what to write after `reader=`.
pub fn reader_that_says(answer: &'static str) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            std::thread::spawn(move || reply(&stream, answer));
        }
    });
    format!("openai:parrot@http://127.0.0.1:{port}/v1")
}

/// One request a connection. A client that has gone needs no answer.
fn reply(mut stream: &TcpStream, answer: &str) -> Option<()> {
    let mut request = BufReader::new(stream);
    let mut length = 0;
    loop {
        let mut line = String::new();
        request.read_line(&mut line).ok()?;
        match line.trim().to_ascii_lowercase().strip_prefix("content-length:") {
            Some(bytes) => length = bytes.trim().parse().ok()?,
            None if line.trim().is_empty() => break,
            None => {}
        }
    }
    std::io::copy(&mut request.take(length), &mut std::io::sink()).ok()?;
    let message =
        serde_json::json!({ "message": { "role": "assistant", "content": answer }, "finish_reason": "stop" });
    let body = serde_json::json!({ "choices": [message] }).to_string();
    let head = format!(
        "HTTP/1.1 200 OK\r\ncontent-type: application/json\r\ncontent-length: {}\r\nconnection: close\r\n\r\n",
        body.len()
    );
    stream.write_all((head + &body).as_bytes()).ok()
}
