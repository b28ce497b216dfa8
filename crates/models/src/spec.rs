//! Which chat model a user means: the text behind `--planner` and the like.
//!
//! | text | meaning |
//! |---|---|
//! | `openai:MODEL@URL` | the endpoint at URL, which ends in `/v1` or the like and speaks as OpenAI does: DashScope, Qianfan, vLLM, llama-server … |
//! | `openai:MODEL` | the endpoint in `OPENBENCH_API_BASE`, else OpenAI's own |
//! | `anthropic:MODEL`, `gemini:MODEL` | Anthropic's or Google's own endpoint, in their own words; `@URL` for another that speaks so |
//! | `ollama:MODEL` | Ollama on this machine; `@URL` for another |
//! | `local:NAME` | a model of `openbench models list`, or a GGUF file by its path, in this process (builds with the feature `local-llm`) |
//! | `replay:FILE` | what was recorded in FILE |
//!
//! The keys for the providers' own endpoints are those in `OPENAI_API_KEY`, `ANTHROPIC_API_KEY` and `GEMINI_API_KEY`, which go nowhere else. For any other endpoint, and where
//! the provider's own variable is empty, the key is that in `OPENBENCH_API_KEY`. Without a key a request has none, as local servers like it; the
//! providers' own endpoints need one. A key is not sent unencrypted to another machine. `OPENBENCH_API_TIMEOUT` is how many seconds an answer is
//! waited for (60; of a local model 600).

use std::path::PathBuf;
use std::time::Duration;

use crate::chat::ChatModel;
use crate::remote::Remote;
use crate::replay::{Replay, ReplayError};
use crate::secret::Secret;
use crate::transport::{Bounds, Credential, Transport};

const BASE_VARIABLE: &str = "OPENBENCH_API_BASE";
const KEY_VARIABLE: &str = "OPENBENCH_API_KEY";
const TIMEOUT_VARIABLE: &str = "OPENBENCH_API_TIMEOUT";
/// How long an answer of a model in this process is waited for.
const LOCAL_TIMEOUT: Duration = Duration::from_secs(600);
/// Where Ollama listens unless it is told otherwise.
const OLLAMA: &str = "http://127.0.0.1:11434/v1";

/// Whose words an endpoint speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Provider {
    /// OpenAI's chat completions, as many other servers speak them.
    OpenAi,
    /// Anthropic's messages.
    Anthropic,
    /// Google's `generateContent`.
    Gemini,
}

impl Provider {
    /// The provider's own endpoint.
    pub(crate) const fn own_base(self) -> &'static str {
        match self {
            Self::OpenAi => "https://api.openai.com/v1",
            Self::Anthropic => "https://api.anthropic.com",
            Self::Gemini => "https://generativelanguage.googleapis.com",
        }
    }

    /// The variable with the key for that endpoint alone.
    const fn key_variable(self) -> &'static str {
        match self {
            Self::OpenAi => "OPENAI_API_KEY",
            Self::Anthropic => "ANTHROPIC_API_KEY",
            Self::Gemini => "GEMINI_API_KEY",
        }
    }

    /// The header in which a key travels, and what stands before it there.
    const fn key_header(self) -> (&'static str, &'static str) {
        match self {
            Self::OpenAi => ("authorization", "Bearer "),
            Self::Anthropic => ("x-api-key", ""),
            Self::Gemini => ("x-goog-api-key", ""),
        }
    }
}

/// A chat model as a user names it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ModelSpec {
    /// A model behind an endpoint.
    Remote {
        /// Whose words the endpoint speaks.
        provider: Provider,
        /// The model's name there.
        model: String,
        /// The endpoint, if the text names it.
        base: Option<String>,
    },
    /// A model in this process: a name in the folder of model files, or a file.
    Local(String),
    /// A recording.
    Replay(PathBuf),
}

/// Why a text names no usable chat model.
#[derive(Debug, thiserror::Error)]
pub enum SpecError {
    /// The text is none of the known forms.
    #[error(
        "`{spec}` names no chat model: write openai:MODEL, openai:MODEL@URL, anthropic:MODEL, gemini:MODEL, ollama:MODEL, local:NAME or replay:FILE"
    )]
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
    /// The time-out is no number of seconds that can be waited.
    #[error("OPENBENCH_API_TIMEOUT={text} is no time-out: write whole seconds, 1 to 3600")]
    BadTimeout {
        /// What is set.
        text: String,
    },
    /// The model's file is not here, or is of no use.
    #[error("local:{name}: {detail}")]
    Local {
        /// The model as the text has it.
        name: String,
        /// What is wrong, and what to do.
        detail: String,
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
            ("local", name) if !name.is_empty() => Ok(Self::Local(name.to_owned())),
            (word, rest) => {
                let (provider, preset) = match word {
                    "openai" => (Provider::OpenAi, None),
                    "ollama" => (Provider::OpenAi, Some(OLLAMA)),
                    "anthropic" => (Provider::Anthropic, None),
                    "gemini" => (Provider::Gemini, None),
                    _ => return Err(unknown()),
                };
                let at = rest.find("@http://").or_else(|| rest.find("@https://"));
                let (model, base) = at.map_or((rest, preset), |at| (&rest[..at], Some(&rest[at + 1..])));
                let model = (!model.is_empty()).then(|| model.to_owned()).ok_or_else(unknown)?;
                Ok(Self::Remote { provider, model, base: base.map(str::to_owned) })
            }
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
            Self::Local(name) => {
                let timeout = stated_timeout(&environment)?.unwrap_or(LOCAL_TIMEOUT);
                let bad = |detail| SpecError::Local { name: name.clone(), detail };
                local(name, timeout).map_err(bad)?
            }
            Self::Remote { provider, model, base } => {
                let timeout = stated_timeout(&environment)?;
                let bounds =
                    timeout.map_or_else(Bounds::default, |timeout| Bounds { timeout, ..Bounds::default() });
                Box::new(endpoint(*provider, model, base.as_deref(), bounds, environment)?)
            }
        })
    }
}

/// What a local model is called: its file's name as it was given, without `.gguf`.
pub fn local_name(file: &std::path::Path) -> String {
    let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
    name.strip_suffix(".gguf").map(str::to_owned).unwrap_or(name)
}

#[cfg(feature = "local-llm")]
fn local(name: &str, timeout: Duration) -> Result<Box<dyn ChatModel>, String> {
    let store = crate::store::ModelStore::from_environment().map_err(|e| e.to_string())?;
    Ok(Box::new(crate::local::Local::open(&store.chat_model(name)?, timeout)?))
}

#[cfg(not(feature = "local-llm"))]
fn local(_: &str, _: Duration) -> Result<Box<dyn ChatModel>, String> {
    Err("this build has no local models: build it with `--features local-llm`, which needs cmake and libclang".into())
}

/// A model at an endpoint; base address and key from the environment where they are left open.
pub(crate) fn endpoint(
    provider: Provider,
    model: &str,
    base: Option<&str>,
    bounds: Bounds,
    environment: impl Fn(&str) -> Option<String>,
) -> Result<Remote, SpecError> {
    let filled = |variable| environment(variable).map(|v| v.trim().to_owned()).filter(|v| !v.is_empty());
    let elsewhere = || (provider == Provider::OpenAi).then(|| filled(BASE_VARIABLE)).flatten();
    let base = base.map(str::to_owned).or_else(elsewhere).unwrap_or_else(|| provider.own_base().into());
    let base = checked_base(&base)?;
    let is_own = base == provider.own_base();
    let own = is_own.then(|| provider.key_variable());
    let variables = own.into_iter().chain([KEY_VARIABLE]);
    let found = variables.filter_map(|variable| filled(variable).map(|key| (variable, key))).next();
    let key = match found {
        Some((variable, key)) => Some(Secret::new(&key).ok_or(SpecError::UnusableKey { variable })?),
        None if is_own => return Err(SpecError::MissingKey { base, variable: provider.key_variable() }),
        None => None,
    };
    if key.is_some() && base.starts_with("http://") && !is_this_machine(&base) {
        let detail = "a key would travel unencrypted; use https, or unset OPENBENCH_API_KEY";
        return Err(SpecError::BadBase { base, detail });
    }
    let (header, scheme) = provider.key_header();
    let credential = key.map(|key| Credential { key, header, scheme });
    let transport = Transport::new(&base, credential, bounds);
    Ok(Remote::new(provider, model, &base, transport))
}

/// How long an answer is waited for, if the environment says so.
fn stated_timeout(environment: impl Fn(&str) -> Option<String>) -> Result<Option<Duration>, SpecError> {
    let Some(text) = environment(TIMEOUT_VARIABLE).filter(|text| !text.trim().is_empty()) else {
        return Ok(None);
    };
    match text.trim().parse::<u64>() {
        Ok(seconds @ 1..=3600) => Ok(Some(Duration::from_secs(seconds))),
        _ => Err(SpecError::BadTimeout { text }),
    }
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
        let spec = |provider, model: &str, base: Option<&str>| ModelSpec::Remote {
            provider,
            model: model.into(),
            base: base.map(Into::into),
        };
        let openai = |model, base| spec(Provider::OpenAi, model, base);
        assert_eq!(ModelSpec::parse("openai:m").unwrap(), openai("m", None));
        assert_eq!(ModelSpec::parse("ollama:qwen2.5:0.5b").unwrap(), openai("qwen2.5:0.5b", Some(OLLAMA)));
        assert_eq!(ModelSpec::parse("ollama:m@http://h/v1").unwrap(), openai("m", Some("http://h/v1")));
        assert_eq!(ModelSpec::parse("anthropic:m").unwrap(), spec(Provider::Anthropic, "m", None));
        assert_eq!(
            ModelSpec::parse("gemini:m@https://h").unwrap(),
            spec(Provider::Gemini, "m", Some("https://h"))
        );
        assert_eq!(
            ModelSpec::parse("openai:@cf/m:7b@http://h:1/v1").unwrap(),
            openai("@cf/m:7b", Some("http://h:1/v1"))
        );
        assert_eq!(ModelSpec::parse("replay:a:b").unwrap(), ModelSpec::Replay("a:b".into()));
        assert_eq!(ModelSpec::parse("local:a:b").unwrap(), ModelSpec::Local("a:b".into()));
        for bad in
            ["", "openai", "openai:", "openai:@http://h", "replay:", "local:", "gpt", "ollama:", "claude:m"]
        {
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
    fn a_providers_key_goes_to_that_provider_only() {
        for provider in [Provider::OpenAi, Provider::Anthropic, Provider::Gemini] {
            let environment = |name: &str| (name == provider.key_variable()).then(|| "k".to_owned());
            let made = |base| endpoint(provider, "m", base, Bounds::default(), environment);
            assert!(made(None).unwrap().has_key());
            assert!(!made(Some("https://other.example/v1")).unwrap().has_key());
            let without = endpoint(provider, "m", None, Bounds::default(), |_| None);
            assert!(matches!(without, Err(SpecError::MissingKey { .. })));
        }
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
    fn time_outs_are_whole_seconds() {
        let with = |text| open("ollama:m", &[(TIMEOUT_VARIABLE, text)]);
        assert!(with("5").is_ok() && with(" ").is_ok());
        for bad in ["0", "3601", "1.5", "-1", "soon"] {
            assert!(matches!(with(bad), Err(SpecError::BadTimeout { .. })), "{bad}");
        }
    }

    #[test]
    fn unusable_keys_are_named_not_shown() {
        let error = open("openai:m", &[("OPENBENCH_API_KEY", "sec\nret")]).err().unwrap();
        assert!(matches!(error, SpecError::UnusableKey { variable: "OPENBENCH_API_KEY" }));
        assert!(!format!("{error} {error:?}").contains("sec\n"));
    }
}
