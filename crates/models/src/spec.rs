//! Which chat model a user means: the text behind `--planner` and the like.
//!
//! | text | meaning |
//! |---|---|
//! | `openai:MODEL@URL` | the OpenAI-compatible endpoint at URL, which ends in `/v1` or the like |
//! | `openai:MODEL` | the endpoint in `OPENBENCH_API_BASE`, else OpenAI's own |
//! | `replay:FILE` | what was recorded in FILE |
//!
//! The key is that in `OPENBENCH_API_KEY`. `OPENAI_API_KEY` serves too, but goes to OpenAI's own endpoint only, so that it never reaches a
//! server for which it was not made. Without a key a request has none, as local servers like it; OpenAI's own endpoint needs one. A
//! key is not sent unencrypted to another machine.

use std::path::PathBuf;

use crate::chat::ChatModel;
use crate::openai::{OpenAi, OpenAiSettings};
use crate::replay::{Replay, ReplayError};
use crate::secret::Secret;

/// OpenAI's own endpoint.
const OPENAI: &str = "https://api.openai.com/v1";
const BASE_VARIABLE: &str = "OPENBENCH_API_BASE";
const KEY_VARIABLE: &str = "OPENBENCH_API_KEY";
const OPENAI_KEY_VARIABLE: &str = "OPENAI_API_KEY";

/// A chat model as a user names it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ModelSpec {
    /// A model behind an OpenAI-compatible endpoint.
    OpenAi {
        /// The model's name there.
        model: String,
        /// The endpoint, unless the environment names it.
        base: Option<String>,
    },
    /// A recording.
    Replay(PathBuf),
}

/// Why a text names no usable chat model.
#[derive(Debug, thiserror::Error)]
pub enum SpecError {
    /// The text is none of the known forms.
    #[error("`{spec}` names no chat model: write openai:MODEL, openai:MODEL@URL or replay:FILE")]
    Unknown {
        /// The text.
        spec: String,
    },
    /// The address is not one of the kind `http(s)://host[:port]/path`.
    #[error("`{base}` is no address of an endpoint: {detail}")]
    BadBase {
        /// The address.
        base: String,
        /// What is wrong with it.
        detail: &'static str,
    },
    /// The endpoint needs a key and there is none.
    #[error("{base} needs a key: set the environment variable {variable}")]
    MissingKey {
        /// The endpoint.
        base: String,
        /// Where a key is looked for.
        variable: &'static str,
    },
    /// The key holds blanks, line breaks or letters that HTTP cannot carry.
    #[error(
        "the environment variable {variable} holds no usable key: it has a blank, a control character or a letter outside ASCII"
    )]
    UnusableKey {
        /// Where the key was read from.
        variable: &'static str,
    },
    /// The recording cannot be read.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

impl ModelSpec {
    /// Reads the forms in the module's table.
    ///
    /// # Errors
    /// [`SpecError::Unknown`].
    pub fn parse(spec: &str) -> Result<Self, SpecError> {
        let unknown = || SpecError::Unknown { spec: spec.to_owned() };
        match spec.split_once(':').ok_or_else(unknown)? {
            ("replay", file) if !file.is_empty() => Ok(Self::Replay(file.into())),
            ("openai", rest) if !rest.is_empty() => {
                let at = rest.find("@http://").or_else(|| rest.find("@https://"));
                let (model, base) =
                    at.map_or((rest, None), |at| (&rest[..at], Some(rest[at + 1..].to_owned())));
                let model = (!model.is_empty()).then(|| model.to_owned()).ok_or_else(unknown)?;
                Ok(Self::OpenAi { model, base })
            }
            _ => Err(unknown()),
        }
    }

    /// Makes the model, with base address and key from the process's environment where the text leaves them open. Nothing is sent yet.
    ///
    /// # Errors
    /// Any [`SpecError`] but `Unknown`.
    pub fn open(&self) -> Result<Box<dyn ChatModel>, SpecError> {
        self.open_with(|variable| std::env::var(variable).ok())
    }

    /// [`ModelSpec::open`] in another environment than the process's.
    ///
    /// # Errors
    /// As [`ModelSpec::open`].
    pub fn open_with(
        &self,
        environment: impl Fn(&str) -> Option<String>,
    ) -> Result<Box<dyn ChatModel>, SpecError> {
        Ok(match self {
            Self::Replay(file) => Box::new(Replay::open(file)?),
            Self::OpenAi { model, base } => {
                Box::new(endpoint(model, base.as_deref(), OpenAiSettings::default(), environment)?)
            }
        })
    }
}

/// A model at an endpoint; base address and key from the environment where they are left open.
pub(crate) fn endpoint(
    model: &str,
    base: Option<&str>,
    settings: OpenAiSettings,
    environment: impl Fn(&str) -> Option<String>,
) -> Result<OpenAi, SpecError> {
    let filled = |variable| environment(variable).map(|v| v.trim().to_owned()).filter(|v| !v.is_empty());
    let base = base.map(str::to_owned).or_else(|| filled(BASE_VARIABLE)).unwrap_or_else(|| OPENAI.into());
    let base = checked_base(&base)?;
    let keys = [KEY_VARIABLE, OPENAI_KEY_VARIABLE].into_iter().take(if base == OPENAI { 2 } else { 1 });
    let key = keys.filter_map(|variable| filled(variable).map(|key| (variable, key))).next();
    let key = match key {
        Some((variable, key)) => Some(Secret::new(&key).ok_or(SpecError::UnusableKey { variable })?),
        None if base == OPENAI => return Err(SpecError::MissingKey { base, variable: KEY_VARIABLE }),
        None => None,
    };
    if key.is_some() && base.starts_with("http://") && !is_this_machine(&base) {
        let detail = "a key would travel unencrypted; use https, or unset OPENBENCH_API_KEY";
        return Err(SpecError::BadBase { base, detail });
    }
    Ok(OpenAi::new(model, &base, key, settings))
}

fn checked_base(base: &str) -> Result<String, SpecError> {
    let base = base.trim_end_matches('/');
    let bad = |shown: &str, detail| Err(SpecError::BadBase { base: shown.to_owned(), detail });
    let Some(rest) = base.strip_prefix("https://").or_else(|| base.strip_prefix("http://")) else {
        return bad(base, "it does not begin with http:// or https://");
    };
    let authority = rest.split(['/', '?', '#']).next().unwrap_or_default();
    if authority.contains('@') {
        // Not shown: what stands before the @ is a password.
        return bad("http(s)://…@…", "it holds a user name or password; put the key into OPENBENCH_API_KEY");
    }
    if authority.is_empty()
        || base.contains(['?', '#'])
        || base.chars().any(|c| c.is_whitespace() || c.is_control())
    {
        return bad(base, "write http(s)://host[:port]/path");
    }
    Ok(base.to_owned())
}

/// Whether the address is on the loopback interface.
pub(crate) fn is_this_machine(base: &str) -> bool {
    let rest = base.split_once("://").map_or(base, |(_, rest)| rest);
    let authority = rest.split('/').next().unwrap_or_default();
    let host = match authority.strip_prefix('[') {
        Some(bracketed) => bracketed.split(']').next().unwrap_or_default(),
        None => authority.split(':').next().unwrap_or_default(),
    };
    host == "localhost" || host.parse::<std::net::IpAddr>().is_ok_and(|ip| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(spec: &str, environment: &[(&str, &str)]) -> Result<Box<dyn ChatModel>, SpecError> {
        let lookup = |name: &str| environment.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned());
        ModelSpec::parse(spec)?.open_with(lookup)
    }

    #[test]
    fn forms() {
        let openai = |model: &str, base: Option<&str>| ModelSpec::OpenAi {
            model: model.into(),
            base: base.map(Into::into),
        };
        assert_eq!(ModelSpec::parse("openai:m").unwrap(), openai("m", None));
        assert_eq!(
            ModelSpec::parse("openai:@cf/m:7b@http://h:1/v1").unwrap(),
            openai("@cf/m:7b", Some("http://h:1/v1"))
        );
        assert_eq!(ModelSpec::parse("replay:a:b").unwrap(), ModelSpec::Replay("a:b".into()));
        for bad in ["", "openai", "openai:", "openai:@http://h", "replay:", "gpt"] {
            assert!(matches!(ModelSpec::parse(bad), Err(SpecError::Unknown { .. })), "{bad}");
        }
    }

    #[test]
    fn openai_needs_a_key_and_a_local_server_does_not() {
        assert!(matches!(open("openai:m", &[]), Err(SpecError::MissingKey { .. })));
        assert!(matches!(open("openai:m", &[("OPENAI_API_KEY", " ")]), Err(SpecError::MissingKey { .. })));
        assert!(open("openai:m", &[("OPENAI_API_KEY", "k\n")]).is_ok());
        assert_eq!(open("openai:m@http://localhost:1/v1", &[]).unwrap().name(), "m");
    }

    #[test]
    fn openais_key_goes_to_openai_only() {
        let environment = |name: &str| (name == OPENAI_KEY_VARIABLE).then(|| "k".to_owned());
        let has_key =
            |base| endpoint("m", Some(base), OpenAiSettings::default(), environment).unwrap().has_key();
        assert!(has_key(OPENAI));
        assert!(!has_key("https://other.example/v1"));
    }

    #[test]
    fn keys_do_not_travel_in_the_clear() {
        let key = [("OPENBENCH_API_KEY", "k")];
        assert!(matches!(open("openai:m@http://far.example/v1", &key), Err(SpecError::BadBase { .. })));
        assert!(open("openai:m@http://far.example/v1", &[]).is_ok());
        for local in ["http://127.0.0.1:1/v1", "http://localhost/v1", "http://[::1]:1/v1"] {
            assert!(open(&format!("openai:m@{local}"), &key).is_ok(), "{local}");
        }
    }

    #[test]
    fn bad_bases_are_refused_without_showing_passwords() {
        for base in ["https://", "https://h?x", "https://u:secret@h/v1", "https://h/a b"] {
            let error = open(&format!("openai:m@{base}"), &[]).err().unwrap();
            assert!(matches!(error, SpecError::BadBase { .. }), "{base}");
            assert!(!format!("{error} {error:?}").contains("secret"));
        }
    }

    #[test]
    fn unusable_keys_are_named_not_shown() {
        let error = open("openai:m", &[("OPENBENCH_API_KEY", "sec\nret")]).err().unwrap();
        assert!(matches!(error, SpecError::UnusableKey { variable: "OPENBENCH_API_KEY" }));
        assert!(!format!("{error} {error:?}").contains("sec\n"));
    }
}
