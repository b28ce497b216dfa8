//! Chat models behind OpenAI-compatible endpoints: `POST BASE/chat/completions`.
//!
//! Sends only what every such server understands, follows no redirects, and bounds time, retries and the size of answers. Tried again are
//! refused or broken connections and the statuses 429 and 5xx, waiting longer each time; not a time-out, which a second try would only double.

use std::io::Read;
use std::time::Duration;

use base64::Engine;
use serde_json::{Value, json};
use ureq::Agent;

use crate::chat::{ChatError, ChatModel, ChatReply, ChatRequest, Message, Role};
use crate::secret::Secret;
use crate::spec::is_this_machine;

/// Characters of a server's complaint that an error quotes.
const QUOTED: usize = 300;

/// Bounds of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OpenAiSettings {
    /// The longest that one try may take, from the connection to the last byte.
    pub timeout: Duration,
    /// Further tries after the first.
    pub retries: u32,
    /// The pause before the second try; each further pause is twice as long. A server's `Retry-After` may lengthen it.
    pub first_pause: Duration,
    /// No pause is longer.
    pub longest_pause: Duration,
    /// Longer answers are refused, bytes after decompression.
    pub max_reply_bytes: u64,
}

impl Default for OpenAiSettings {
    fn default() -> Self {
        Self {
            timeout: Duration::from_secs(60),
            retries: 3,
            first_pause: Duration::from_millis(500),
            longest_pause: Duration::from_secs(20),
            max_reply_bytes: 4 << 20,
        }
    }
}

/// A model behind an OpenAI-compatible endpoint. Made by [`crate::ModelSpec::open`].
#[derive(Debug)]
pub(crate) struct OpenAi {
    agent: Agent,
    model: String,
    url: String,
    key: Option<Secret>,
    settings: OpenAiSettings,
}

/// A failed try.
struct Failure {
    error: ChatError,
    /// Whether another try may help.
    passing: bool,
    /// What the server asked to wait.
    wait: Option<Duration>,
}

impl OpenAi {
    /// `base` is without a slash at its end.
    pub(crate) fn new(model: &str, base: &str, key: Option<Secret>, settings: OpenAiSettings) -> Self {
        let config = Agent::config_builder()
            .timeout_global(Some(settings.timeout))
            .max_redirects(0)
            .max_redirects_will_error(false)
            .http_status_as_error(false);
        let config = if is_this_machine(base) { config.proxy(None) } else { config };
        let url = format!("{base}/chat/completions");
        Self { agent: config.build().new_agent(), model: model.into(), url, key, settings }
    }

    #[cfg(test)]
    pub(crate) fn has_key(&self) -> bool {
        self.key.is_some()
    }

    fn attempt(&self, body: &[u8]) -> Result<ChatReply, Failure> {
        let mut request = self.agent.post(&self.url).header("content-type", "application/json");
        if let Some(key) = &self.key {
            request = request.header("authorization", key.header());
        }
        let mut response = request.send(body).map_err(|error| self.broken(&error))?;
        let status = response.status().as_u16();
        let wait =
            response.headers().get("retry-after").and_then(|value| value.to_str().ok()?.trim().parse().ok());
        let text = self.read(response.body_mut())?;
        if status != 200 {
            let error = self.status(status, &text);
            let passing = status == 429 || status >= 500;
            return Err(Failure { error, passing, wait: wait.map(Duration::from_secs) });
        }
        self.reply(&text).map_err(|detail| self.unusable(&detail))
    }

    fn read(&self, body: &mut ureq::Body) -> Result<String, Failure> {
        let mut bytes = Vec::new();
        let limit = self.settings.max_reply_bytes;
        body.as_reader()
            .take(limit + 1)
            .read_to_end(&mut bytes)
            .map_err(|error| self.broken(&error.into()))?;
        if bytes.len() as u64 > limit {
            return Err(self.unusable(&format!("it is longer than {limit} bytes")));
        }
        Ok(self.blot_out(&String::from_utf8_lossy(&bytes)))
    }

    /// The answer in the server's JSON.
    fn reply(&self, text: &str) -> Result<ChatReply, String> {
        let value: Value = serde_json::from_str(text).map_err(|error| format!("not JSON: {error}"))?;
        let choice = &value["choices"][0];
        let said = choice["message"]["content"].as_str().unwrap_or_default();
        let reason = choice["finish_reason"].as_str().unwrap_or("none given");
        if reason == "length" {
            return Err("it was cut off at the longest answer allowed; allow more tokens".into());
        }
        if said.trim().is_empty() {
            return Err(format!("no text at choices[0].message.content (finish reason: {})", quote(reason)));
        }
        let tokens =
            |name: &str| value["usage"][name].as_u64().map_or(0, |count| count.min(u32::MAX.into()) as u32);
        let (prompt_tokens, completion_tokens) = (tokens("prompt_tokens"), tokens("completion_tokens"));
        Ok(ChatReply { text: self.blot_out(said), prompt_tokens, completion_tokens })
    }

    fn broken(&self, error: &ureq::Error) -> Failure {
        let endpoint = self.url.clone();
        if is_timeout(error) {
            let seconds = self.settings.timeout.as_millis().div_ceil(1000) as u64;
            return Failure { error: ChatError::Timeout { endpoint, seconds }, passing: false, wait: None };
        }
        let detail = self.blot_out(&error.to_string());
        Failure { error: ChatError::Unreachable { endpoint, detail }, passing: true, wait: None }
    }

    fn status(&self, code: u16, text: &str) -> ChatError {
        let value: Value = serde_json::from_str(text).unwrap_or_default();
        let said =
            value["error"]["message"].as_str().map_or_else(|| text.to_owned(), |said| self.blot_out(said));
        ChatError::Status { endpoint: self.url.clone(), code, detail: quote(&said) }
    }

    fn unusable(&self, detail: &str) -> Failure {
        let error = ChatError::BadReply { endpoint: self.url.clone(), detail: detail.to_owned() };
        Failure { error, passing: false, wait: None }
    }

    fn blot_out(&self, text: &str) -> String {
        self.key.as_ref().map_or_else(|| text.to_owned(), |key| key.blot_out(text))
    }
}

impl ChatModel for OpenAi {
    fn name(&self) -> &str {
        &self.model
    }

    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
        let body = body(&self.model, request).to_string();
        let mut pause = self.settings.first_pause;
        for _ in 0..self.settings.retries {
            match self.attempt(body.as_bytes()) {
                Ok(reply) => return Ok(reply),
                Err(failure) if failure.passing => {
                    std::thread::sleep(
                        failure.wait.unwrap_or_default().max(pause).min(self.settings.longest_pause),
                    );
                    pause *= 2;
                }
                Err(failure) => return Err(failure.error),
            }
        }
        self.attempt(body.as_bytes()).map_err(|failure| failure.error)
    }
}

fn is_timeout(error: &ureq::Error) -> bool {
    match error {
        ureq::Error::Timeout(_) => true,
        ureq::Error::Io(io) => {
            let wrapped = io.get_ref().and_then(|inner| inner.downcast_ref::<ureq::Error>());
            matches!(wrapped, Some(ureq::Error::Timeout(_))) || io.kind() == std::io::ErrorKind::TimedOut
        }
        _ => false,
    }
}

/// The beginning of a foreign text, on one line.
fn quote(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(QUOTED).collect()
}

fn body(model: &str, request: &ChatRequest) -> Value {
    let mut body = json!({
        "model": model,
        "messages": request.messages.iter().map(message).collect::<Vec<_>>(),
        "max_tokens": request.max_tokens,
        "temperature": request.temperature,
    });
    if request.json {
        body["response_format"] = json!({ "type": "json_object" });
    }
    body
}

fn message(message: &Message) -> Value {
    let role = match message.role {
        Role::System => "system",
        Role::User => "user",
        Role::Assistant => "assistant",
    };
    if message.images.is_empty() {
        return json!({ "role": role, "content": message.text });
    }
    let mut parts = vec![json!({ "type": "text", "text": message.text })];
    parts.extend(
        message
            .images
            .iter()
            .map(|file| json!({ "type": "image_url", "image_url": { "url": data_url(file) } })),
    );
    json!({ "role": role, "content": parts })
}

fn data_url(file: &[u8]) -> String {
    let kind = if file.starts_with(&[0xff, 0xd8]) { "jpeg" } else { "png" };
    format!("data:image/{kind};base64,{}", base64::engine::general_purpose::STANDARD.encode(file))
}

#[cfg(test)]
#[path = "openai_tests.rs"]
mod tests;
