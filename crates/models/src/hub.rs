//! Model files from a hub: Hugging Face, or a mirror in `HF_ENDPOINT`, as in Hugging Face's own
//! tools.
//!
//! A file is written to disk while it is downloaded, and never beyond its length in the catalogue.
//! The store checks its checksum.

use std::io::{Read, Write};
use std::time::Duration;

use ureq::Agent;

use crate::address::is_loopback;
use crate::catalogue::{Hub, ModelFile};
use crate::error::{Cause, StoreError};

const HUGGING_FACE: &str = "https://huggingface.co";
/// Time limit for a file.
const FILE_TIMEOUT: Duration = Duration::from_secs(4 * 3600);
/// Time limit until the hub answers.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(60);
/// Downloaded bytes between two reports of progress.
const REPORT_STEP_BYTES: u64 = 4 << 20;
/// Bytes that are read at a time.
const BUFFER_BYTES: usize = 1 << 16;

/// The address of the hub: the value of `HF_ENDPOINT`, else Hugging Face.
pub(crate) fn endpoint(variable: Option<String>) -> Result<String, StoreError> {
    let stated = variable.map(|text| text.trim().trim_end_matches('/').to_owned());
    let base = stated
        .filter(|text| !text.is_empty())
        .unwrap_or_else(|| HUGGING_FACE.to_owned());
    let is_safe = base.starts_with("https://") || base.starts_with("http://") && is_loopback(&base);
    // The address is printed in errors, so it must not hold a password.
    if is_safe && !base.contains(['@', '?', '#', ' ']) {
        return Ok(base);
    }
    let source = "HF_ENDPOINT must be https://HOST, without user name, password or query";
    Err(StoreError::HubFailed {
        url: "HF_ENDPOINT".into(),
        source: source.into(),
    })
}

/// The address of a file on the hub.
fn url(base: &str, hub: &Hub) -> String {
    format!(
        "{base}/{}/resolve/{}/{}",
        hub.repository, hub.revision, hub.path
    )
}

/// Writes a file of the hub to `sink` and reports the number of downloaded bytes.
pub(crate) fn fetch(
    base: &str,
    hub: &Hub,
    file: &ModelFile,
    sink: &mut dyn Write,
    report: &mut dyn FnMut(u64),
) -> Result<(), StoreError> {
    let url = url(base, hub);
    let mut response = agent(base)
        .get(&url)
        .call()
        .map_err(|error| failed(&url, error))?;
    // One more byte than expected reveals a longer file.
    let mut body = response.body_mut().as_reader().take(file.bytes + 1);
    let mut buffer = vec![0_u8; BUFFER_BYTES];
    let (mut received, mut reported) = (0_u64, 0_u64);
    loop {
        let count = body
            .read(&mut buffer)
            .map_err(|error| failed(&url, error))?;
        // A file that is too short ends here as well; its checksum tells.
        if count == 0 {
            return Ok(());
        }
        received += count as u64;
        if received > file.bytes {
            return Err(failed(
                &url,
                format!("it is longer than {} bytes", file.bytes),
            ));
        }
        sink.write_all(&buffer[..count])
            .map_err(|source| StoreError::Io {
                path: file.file_name().into(),
                source,
            })?;
        if received - reported >= REPORT_STEP_BYTES {
            reported = received;
            report(received);
        }
    }
}

fn agent(base: &str) -> Agent {
    Agent::config_builder()
        // The hub redirects to other hosts, which must be encrypted as well.
        .https_only(base.starts_with("https://"))
        .timeout_global(Some(FILE_TIMEOUT))
        .timeout_recv_response(Some(ANSWER_TIMEOUT))
        .timeout_connect(Some(ANSWER_TIMEOUT))
        .build()
        .into()
}

fn failed(url: &str, source: impl Into<Cause>) -> StoreError {
    StoreError::HubFailed {
        url: url.to_owned(),
        source: source.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<String, StoreError> {
        endpoint(Some(text.to_owned()))
    }

    #[test]
    fn the_hub_is_hugging_face_or_an_encrypted_mirror() {
        assert_eq!(endpoint(None).unwrap(), HUGGING_FACE);
        assert_eq!(of(" ").unwrap(), HUGGING_FACE);
        assert_eq!(
            of("https://mirror.example/").unwrap(),
            "https://mirror.example"
        );
        assert!(of("http://127.0.0.1:80").is_ok());
        for bad in [
            "http://mirror.example",
            "mirror.example",
            "https://user:secret@host",
            "https://h/?x",
        ] {
            let error = of(bad).unwrap_err();
            assert!(!error.to_string().contains("secret"), "{bad}");
        }
    }
}
