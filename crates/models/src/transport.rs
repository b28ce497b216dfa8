//! HTTP requests to a provider, limited in time, attempts and length.
//!
//! Redirects are not followed. Refused or broken connections and the statuses 429 and 5xx are
//! retried, with increasing pauses. Time-outs are not, since a second attempt would only double the
//! time.
//!
//! The key is added here and nowhere else, to a header, and removed from all texts that come back.

use std::io::Read;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bytes::Bytes;
use http::{HeaderMap, Request, Response, header};
use openbench_core::with_causes;
use rig_core::http_client::{self, HttpClientExt, LazyBody, MultipartForm, StreamingResponse};
use serde_json::Value;
use ureq::Agent;

use crate::address::is_loopback;
use crate::chat::ChatError;
use crate::provider::KeyHeader;
use crate::quote::quote;
use crate::secret::Secret;

/// Limits of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Bounds {
    /// Time limit for one attempt, from the connection to the last byte.
    pub timeout: Duration,
    /// Number of attempts after the first. None begins when the time-out has passed since the
    /// first.
    pub retries: u32,
    /// Pause before the second attempt. Each further pause is twice as long, or as long as the
    /// server's `Retry-After`.
    pub first_pause: Duration,
    /// Limit for a pause.
    pub longest_pause: Duration,
    /// Limit for the length of an answer, bytes after decompression.
    pub max_reply_bytes: u64,
}

impl Default for Bounds {
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

/// A key and the header that carries it.
#[derive(Debug, Clone)]
pub(crate) struct Credential {
    pub key: Secret,
    pub header: KeyHeader,
}

/// Sends the requests of a provider's protocol. It blocks: its futures are ready when first polled.
#[derive(Debug, Clone)]
pub(crate) struct Transport {
    agent: Agent,
    credential: Option<Arc<Credential>>,
    bounds: Bounds,
}

/// A failed attempt.
struct Failure {
    error: ChatError,
    /// Whether another attempt may succeed.
    is_transient: bool,
    /// The pause that the server requests.
    wait: Option<Duration>,
}

/// A request without the placeholder for the key.
struct Outgoing {
    endpoint: String,
    body: Bytes,
    headers: HeaderMap,
}

impl Transport {
    /// A transport for requests to `base` with this key.
    pub(crate) fn new(base: &str, credential: Option<Credential>, bounds: Bounds) -> Self {
        let config = Agent::config_builder()
            .timeout_global(Some(bounds.timeout))
            // A redirect would send the key, and the request, to an address that the user did not
            // name.
            .max_redirects(0)
            .max_redirects_will_error(false)
            // The body of a refusal says why, so statuses are judged below.
            .http_status_as_error(false);
        let config = if is_loopback(base) {
            // A proxy would look for the address on its own machine.
            config.proxy(None)
        } else {
            config
        };
        Self {
            agent: config.build().new_agent(),
            credential: credential.map(Arc::new),
            bounds,
        }
    }

    /// `text` without the key.
    pub(crate) fn redact(&self, text: &str) -> String {
        match &self.credential {
            Some(credential) => credential.key.redact(text),
            None => text.to_owned(),
        }
    }

    /// Sends a request, and again until the status is 200 or no further attempt may succeed.
    fn exchange(&self, outgoing: &Outgoing) -> Result<String, ChatError> {
        let (began, mut pause, mut attempts) = (Instant::now(), self.bounds.first_pause, 0);
        loop {
            let failure = match self.attempt(outgoing) {
                Ok(text) => return Ok(text),
                Err(failure) => failure,
            };
            let wait = failure
                .wait
                .unwrap_or_default()
                .max(pause)
                // The server decides the pause only within the bounds: it may ask for hours.
                .min(self.bounds.longest_pause);
            attempts += 1;
            let is_late = began.elapsed() + wait >= self.bounds.timeout;
            if !failure.is_transient || attempts > self.bounds.retries || is_late {
                return Err(failure.error);
            }
            std::thread::sleep(wait);
            pause *= 2;
        }
    }

    fn attempt(&self, outgoing: &Outgoing) -> Result<String, Failure> {
        let mut request = self.agent.post(&outgoing.endpoint);
        for (name, value) in &outgoing.headers {
            request = request.header(name, value);
        }
        if let Some(credential) = &self.credential {
            let value = format!("{}{}", credential.header.scheme, credential.key.expose());
            request = request.header(credential.header.name, value);
        }
        let endpoint = &outgoing.endpoint;
        let mut response = request
            .send(&outgoing.body[..])
            .map_err(|error| self.broken(endpoint, &error))?;
        let status = response.status().as_u16();
        // Before the body is read, which borrows the response.
        let wait = retry_after(response.headers());
        let text = self.read(endpoint, response.body_mut())?;
        if status != 200 {
            let is_transient = status == 429 || status >= 500;
            return Err(Failure {
                error: self.status(endpoint, status, &text),
                is_transient,
                wait,
            });
        }
        Ok(text)
    }

    fn read(&self, endpoint: &str, body: &mut ureq::Body) -> Result<String, Failure> {
        let mut bytes = Vec::new();
        let limit = self.bounds.max_reply_bytes;
        body.as_reader()
            // After decompression, so that a small answer cannot grow without bound. One more byte
            // than allowed reveals a longer one.
            .take(limit + 1)
            .read_to_end(&mut bytes)
            .map_err(|error| self.broken(endpoint, &error.into()))?;
        if bytes.len() as u64 > limit {
            let detail = format!("it is longer than {limit} bytes");
            let error = ChatError::BadReply {
                endpoint: endpoint.to_owned(),
                detail,
            };
            return Err(Failure {
                error,
                is_transient: false,
                wait: None,
            });
        }
        Ok(self.redact(&String::from_utf8_lossy(&bytes)))
    }

    fn broken(&self, endpoint: &str, error: &ureq::Error) -> Failure {
        let endpoint = endpoint.to_owned();
        if is_timeout(error) {
            let seconds = self.bounds.timeout.as_millis().div_ceil(1000) as u64;
            return Failure {
                error: ChatError::Timeout { endpoint, seconds },
                is_transient: false,
                wait: None,
            };
        }
        let detail = self.redact(&with_causes(error));
        Failure {
            error: ChatError::Unreachable { endpoint, detail },
            is_transient: true,
            wait: None,
        }
    }

    /// The error for a status. OpenAI, Anthropic and Gemini have their message in the same field.
    fn status(&self, endpoint: &str, code: u16, text: &str) -> ChatError {
        let value: Value = serde_json::from_str(text).unwrap_or_default();
        let message = match value["error"]["message"].as_str() {
            Some(message) => self.redact(message),
            None => text.to_owned(),
        };
        ChatError::Status {
            endpoint: endpoint.to_owned(),
            code,
            detail: quote(&message),
        }
    }
}

impl Outgoing {
    /// Removes the headers for keys, which the protocol fills with an empty key.
    fn new<T: Into<Bytes>>(request: Request<T>) -> Self {
        let (parts, body) = request.into_parts();
        let endpoint = parts.uri.to_string();
        // Some protocols carry the key in the query, here an empty one.
        let endpoint = endpoint.split('?').next().unwrap_or_default().to_owned();
        let mut headers = parts.headers;
        for name in ["authorization", "x-api-key", "x-goog-api-key"] {
            headers.remove(name);
        }
        Self {
            endpoint,
            body: body.into(),
            headers,
        }
    }
}

impl HttpClientExt for Transport {
    fn send<T, U>(
        &self,
        request: Request<T>,
    ) -> impl Future<Output = http_client::Result<Response<LazyBody<U>>>> + Send + 'static
    where
        T: Into<Bytes> + Send,
        U: From<Bytes> + Send + 'static,
    {
        let (transport, outgoing) = (self.clone(), Outgoing::new(request));
        async move {
            let text = transport
                .exchange(&outgoing)
                // `failure` in `remote` takes the error of this type out again.
                .map_err(http_client::Error::instance)?;
            let body: LazyBody<U> = Box::pin(async move { Ok(U::from(Bytes::from(text))) });
            Ok(Response::builder()
                .header(header::CONTENT_TYPE, "application/json")
                .body(body)?)
        }
    }

    fn send_multipart<U>(
        &self,
        _: Request<MultipartForm>,
    ) -> impl Future<Output = http_client::Result<Response<LazyBody<U>>>> + Send + 'static
    where
        U: From<Bytes> + Send + 'static,
    {
        std::future::ready(Err(unused()))
    }

    fn send_streaming<T>(
        &self,
        _: Request<T>,
    ) -> impl Future<Output = http_client::Result<StreamingResponse>> + Send
    where
        T: Into<Bytes> + Send,
    {
        std::future::ready(Err(unused()))
    }
}

/// The error for multipart and streaming requests, which chats do not use.
fn unused() -> http_client::Error {
    let detail = "multipart and streaming requests are not supported".to_owned();
    http_client::Error::instance(ChatError::BadRequest {
        endpoint: String::new(),
        detail,
    })
}

/// The pause that the server requests, if it is a number of seconds.
fn retry_after(headers: &HeaderMap) -> Option<Duration> {
    let value = headers.get(header::RETRY_AFTER)?.to_str().ok()?;
    value.trim().parse().ok().map(Duration::from_secs)
}

fn is_timeout(error: &ureq::Error) -> bool {
    match error {
        ureq::Error::Timeout(_) => true,
        // While the body is read, a time-out arrives wrapped in an error of input and output.
        ureq::Error::Io(io) => {
            let wrapped = io
                .get_ref()
                .and_then(|inner| inner.downcast_ref::<ureq::Error>());
            matches!(wrapped, Some(ureq::Error::Timeout(_)))
                || io.kind() == std::io::ErrorKind::TimedOut
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_are_read_as_seconds_and_not_as_dates() {
        let asked = |text: &'static str| {
            let value = http::HeaderValue::from_static(text);
            retry_after(&HeaderMap::from_iter([(header::RETRY_AFTER, value)]))
        };
        assert_eq!(asked(" 7 "), Some(Duration::from_secs(7)));
        assert_eq!(asked("Wed, 21 Oct 2015 07:28:00 GMT"), None);
        assert_eq!(retry_after(&HeaderMap::new()), None);
    }
}
