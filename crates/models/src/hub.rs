//! Files on a hub of models: Hugging Face's, or a mirror of it that `HF_ENDPOINT` names, as its own tools have it.
//!
//! What arrives is written to disk as it comes and never longer than the catalogue says; whether it is the right file is for the store to check.

use std::io::{Read, Write};
use std::time::Duration;

use ureq::Agent;

use crate::address::is_loopback;
use crate::catalogue::{Hub, ModelFile};
use crate::error::{Cause, ModelError};

const OWN: &str = "https://huggingface.co";
/// The longest that a file may take.
const FILE_TIMEOUT: Duration = Duration::from_secs(4 * 3600);
/// The longest until the hub answers.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(60);
/// Bytes between two reports.
const REPORT_STEP_BYTES: u64 = 4 << 20;
/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 16;

/// The hub's address, from the environment.
pub(crate) fn endpoint(variable: Option<String>) -> Result<String, ModelError> {
    let stated = variable.map(|text| text.trim().trim_end_matches('/').to_owned());
    let base = stated.filter(|text| !text.is_empty()).unwrap_or_else(|| OWN.to_owned());
    let is_safe = base.starts_with("https://") || base.starts_with("http://") && is_loopback(&base);
    if is_safe && !base.contains(['@', '?', '#', ' ']) {
        return Ok(base);
    }
    let source = "HF_ENDPOINT must be https://HOST, without a user, a password or a question mark";
    Err(ModelError::Hub { url: "HF_ENDPOINT".into(), source: source.into() })
}

/// Where a file lies on the hub at this address.
fn url(base: &str, hub: &Hub) -> String {
    format!("{base}/{}/resolve/{}/{}", hub.repository, hub.revision, hub.path)
}

/// Writes a file from there into `sink`, and tells how many bytes have come.
pub(crate) fn fetch(
    base: &str,
    hub: &Hub,
    file: &ModelFile,
    sink: &mut dyn Write,
    told: &mut dyn FnMut(u64),
) -> Result<(), ModelError> {
    let url = url(base, hub);
    let mut response = agent(base).get(&url).call().map_err(|error| failed(&url, error))?;
    // One byte more than the file has shows that it is another one.
    let mut body = response.body_mut().as_reader().take(file.bytes + 1);
    let mut buffer = vec![0_u8; BUFFER_BYTES];
    let (mut come, mut reported) = (0_u64, 0_u64);
    loop {
        let count = body.read(&mut buffer).map_err(|error| failed(&url, error))?;
        if count == 0 {
            return Ok(());
        }
        come += count as u64;
        if come > file.bytes {
            return Err(failed(&url, format!("it is longer than {} bytes", file.bytes)));
        }
        sink.write_all(&buffer[..count])
            .map_err(|source| ModelError::Storage { path: file.file_name().into(), source })?;
        if come - reported >= REPORT_STEP_BYTES {
            reported = come;
            told(come);
        }
    }
}

fn agent(base: &str) -> Agent {
    Agent::config_builder()
        // The hub sends files from another host, which is not asked in the clear either.
        .https_only(base.starts_with("https://"))
        .timeout_global(Some(FILE_TIMEOUT))
        .timeout_recv_response(Some(ANSWER_TIMEOUT))
        .timeout_connect(Some(ANSWER_TIMEOUT))
        .build()
        .into()
}

fn failed(url: &str, source: impl Into<Cause>) -> ModelError {
    ModelError::Hub { url: url.to_owned(), source: source.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<String, ModelError> {
        endpoint(Some(text.to_owned()))
    }

    #[test]
    fn the_hub_is_huggingface_or_a_mirror_that_is_not_asked_in_the_clear() {
        assert_eq!(endpoint(None).unwrap(), OWN);
        assert_eq!(of(" ").unwrap(), OWN);
        assert_eq!(of("https://mirror.example/").unwrap(), "https://mirror.example");
        assert!(of("http://127.0.0.1:80").is_ok());
        for bad in ["http://mirror.example", "mirror.example", "https://user:secret@host", "https://h/?x"] {
            let error = of(bad).unwrap_err();
            assert!(!error.to_string().contains("secret"), "{bad}");
        }
    }
}
