//! OSRM's error responses.

use super::json::Json;

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Failure {
    /// OSRM's code.
    pub code: &'static str,
    /// OSRM's message.
    pub message: String,
}

impl Failure {
    /// A failure.
    pub fn new(code: &'static str, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
        }
    }

    /// The query is malformed at an offset in bytes from its beginning.
    pub fn query(position: usize) -> Self {
        Self::new(
            "InvalidQuery",
            format!("Query string malformed close to position {position}"),
        )
    }

    /// The response body.
    pub fn to_json(&self) -> Vec<u8> {
        let mut json = Json::default();
        json.object(|json| {
            json.key("message").string(&self.message);
            json.key("code").string(self.code);
        });
        json.into_bytes()
    }
}
