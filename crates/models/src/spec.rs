//! Names of chat models, as in `--planner NAME`.
//!
//! | name | meaning |
//! |---|---|
//! | `openai:MODEL@URL` | any OpenAI-compatible endpoint: DashScope, Qianfan, vLLM, llama-server |
//! | `openai:MODEL` | the endpoint in `OPENBENCH_API_BASE`, else that of OpenAI |
//! | `anthropic:MODEL` | the endpoint of Anthropic, or `@URL` of a compatible one |
//! | `gemini:MODEL` | the endpoint of Google, or `@URL` of a compatible one |
//! | `ollama:MODEL` | Ollama on this machine, or `@URL` of another |
//! | `local:NAME` | a model of `openbench models list` in this process |
//! | `local:PATH` | a GGUF file in this process |
//! | `replay:FILE` | the answers recorded in FILE |
//!
//! A URL includes the version of the protocol where it has one, such as `/v1`. Models in this
//! process need a build with the feature `local-llm`.
//!
//! The environment provides keys and the time-out:
//!
//! | variable | use |
//! |---|---|
//! | `OPENAI_API_KEY` | key for the own endpoint of OpenAI only |
//! | `ANTHROPIC_API_KEY` | key for the own endpoint of Anthropic only |
//! | `GEMINI_API_KEY` | key for the own endpoint of Google only |
//! | `OPENBENCH_API_KEY` | key for other endpoints, and where the provider's variable is empty |
//! | `OPENBENCH_API_TIMEOUT` | time-out of an answer, seconds (default 60, local models 600) |
//!
//! The providers' own endpoints require a key. Without one, requests to other endpoints have none,
//! as local servers expect. A key is never sent to another machine unencrypted.

use std::path::{Path, PathBuf};

use crate::error::SpecError;
use crate::provider::Provider;

/// The default endpoint of Ollama.
const OLLAMA: &str = "http://127.0.0.1:11434/v1";

/// A form of the names of chat models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Form {
    /// The form, with what stands for the argument after the colon: `replay:FILE`.
    pub name: &'static str,
    /// What it means, in one line.
    pub about: &'static str,
}

impl Form {
    const fn new(name: &'static str, about: &'static str) -> Self {
        Self { name, about }
    }

    /// The name of a model of this form, which [`ModelSpec::parse`] reads.
    ///
    /// ```
    /// use openbench_models::spec::FORMS;
    ///
    /// assert_eq!(FORMS[0].spec("gpt-4o"), "openai:gpt-4o");
    /// ```
    pub fn spec(&self, argument: &str) -> String {
        let word = self.name.split(':').next().unwrap_or_default();
        format!("{word}:{argument}")
    }
}

/// All forms, in the order in which they are listed.
pub const FORMS: [Form; 6] = [
    Form::new(
        "openai:MODEL[@URL]",
        "a model of any OpenAI-compatible endpoint",
    ),
    Form::new("anthropic:MODEL", "a model of Anthropic"),
    Form::new("gemini:MODEL", "a model of Google"),
    Form::new("ollama:MODEL", "a model of Ollama, on this machine"),
    Form::new("local:NAME", "a model in this process"),
    Form::new("replay:FILE", "the recorded answers in a file"),
];

/// A chat model as a user names it.
///
/// ```
/// use openbench_models::{ModelSpec, Provider};
///
/// let spec = ModelSpec::parse("openai:qwen2.5-vl@https://llm.example/v1")?;
/// let ModelSpec::Remote { provider, model, base } = spec else { unreachable!() };
/// assert_eq!((provider, model.as_str()), (Provider::OpenAi, "qwen2.5-vl"));
/// assert_eq!(base.as_deref(), Some("https://llm.example/v1"));
/// assert!(ModelSpec::parse("qwen2.5-vl").is_err());
/// # Ok::<(), openbench_models::SpecError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ModelSpec {
    /// A model behind an endpoint.
    Remote {
        /// The protocol of the endpoint.
        provider: Provider,
        /// The name of the model at the endpoint.
        model: String,
        /// The address of the endpoint, if the name contains one.
        base: Option<String>,
    },
    /// A model in this process: a name in the folder of model files, or a path.
    Local(String),
    /// A file of recorded answers.
    Replay(PathBuf),
}

impl ModelSpec {
    /// Reads a name of one of the forms in the [module's table](self). Nothing is opened.
    ///
    /// # Errors
    /// [`SpecError::Unknown`].
    pub fn parse(spec: &str) -> Result<Self, SpecError> {
        Self::read(spec).ok_or_else(|| SpecError::Unknown {
            spec: spec.to_owned(),
        })
    }

    fn read(spec: &str) -> Option<Self> {
        // At the first colon: names of models contain colons too, as in `qwen2.5:0.5b`.
        let (word, rest) = spec.split_once(':')?;
        if rest.is_empty() {
            return None;
        }
        match word {
            "openai" => Self::remote(Provider::OpenAi, rest, None),
            "ollama" => Self::remote(Provider::OpenAi, rest, Some(OLLAMA)),
            "anthropic" => Self::remote(Provider::Anthropic, rest, None),
            "gemini" => Self::remote(Provider::Gemini, rest, None),
            "local" => Some(Self::Local(rest.to_owned())),
            "replay" => Some(Self::Replay(rest.into())),
            _ => None,
        }
    }

    /// Reads `MODEL` or `MODEL@URL`. The name of a model may contain an `@` itself.
    fn remote(provider: Provider, text: &str, preset: Option<&str>) -> Option<Self> {
        let at = text.find("@http://").or_else(|| text.find("@https://"));
        let (model, base) = match at {
            Some(at) => (&text[..at], Some(&text[at + 1..])),
            None => (text, preset),
        };
        // Such a model would be asked for at the provider's own endpoint, with the user's key.
        if model.split('@').skip(1).any(looks_like_address) {
            return None;
        }
        let base = base.map(str::to_owned);
        (!model.is_empty()).then(|| Self::Remote {
            provider,
            model: model.to_owned(),
            base,
        })
    }
}

/// Whether a part of a name is an address that lacks `http://`: a host with a port or a path, an IP
/// address, or this machine. Versions, as in `m@20240620`, and paths, as in `@cf/m`, are none.
fn looks_like_address(part: &str) -> bool {
    let (authority, path) = part.split_once('/').unwrap_or((part, ""));
    let (host, port) = authority.rsplit_once(':').unwrap_or((authority, ""));
    let has_port = !port.is_empty() && port.bytes().all(|byte| byte.is_ascii_digit());
    let is_host = host == "localhost" || host.parse::<std::net::IpAddr>().is_ok();
    let is_name = host.contains('.') && !path.is_empty();
    is_host || is_name || (has_port && (host.contains('.') || host.starts_with('[')))
}

/// The reported name of a local model: the name of its file without `.gguf`.
pub fn local_name(file: &Path) -> String {
    let name = file
        .file_name()
        .unwrap_or(file.as_os_str())
        .to_string_lossy()
        .into_owned();
    name.strip_suffix(".gguf")
        .map(str::to_owned)
        .unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn remote(provider: Provider, model: &str, base: Option<&str>) -> ModelSpec {
        ModelSpec::Remote {
            provider,
            model: model.into(),
            base: base.map(Into::into),
        }
    }

    #[test]
    fn an_address_without_a_scheme_is_no_name_of_a_model() {
        for text in [
            "openai:x@127.0.0.1:5091",
            "openai:x@localhost/v1",
            "openai:x@[::1]:80/v1",
            "anthropic:x@llm.example:443",
            "openai:x@llm.example/v1",
            "openai:x@user:secret@llm.example:443/v1",
        ] {
            let error = ModelSpec::parse(text).unwrap_err().to_string();
            assert!(error.contains("http://"), "{text}: {error}");
        }
        for text in ["openai:m@20240620", "openai:@cf/m:7b", "openai:a@b"] {
            assert!(ModelSpec::parse(text).is_ok(), "{text}");
        }
    }

    #[test]
    fn all_forms_are_read() {
        use Provider::{Anthropic, Gemini, OpenAi};
        for (text, spec) in [
            ("openai:m", remote(OpenAi, "m", None)),
            (
                "ollama:qwen2.5:0.5b",
                remote(OpenAi, "qwen2.5:0.5b", Some(OLLAMA)),
            ),
            (
                "ollama:m@http://h/v1",
                remote(OpenAi, "m", Some("http://h/v1")),
            ),
            ("anthropic:m", remote(Anthropic, "m", None)),
            ("gemini:m@https://h", remote(Gemini, "m", Some("https://h"))),
            (
                "openai:@cf/m:7b@http://h:1/v1",
                remote(OpenAi, "@cf/m:7b", Some("http://h:1/v1")),
            ),
            ("replay:a:b", ModelSpec::Replay("a:b".into())),
            ("local:a:b", ModelSpec::Local("a:b".into())),
        ] {
            assert_eq!(ModelSpec::parse(text).unwrap(), spec);
        }
    }

    #[test]
    fn names_of_the_listed_forms_are_read() {
        for form in FORMS {
            let spec = form.spec("m");
            assert!(ModelSpec::parse(&spec).is_ok(), "{spec}");
        }
    }

    #[test]
    fn other_texts_are_refused() {
        for bad in [
            "",
            "openai",
            "openai:",
            "openai:@http://h",
            "replay:",
            "local:",
            "gpt",
            "ollama:",
            "claude:m",
        ] {
            assert!(
                matches!(ModelSpec::parse(bad), Err(SpecError::Unknown { .. })),
                "{bad}"
            );
        }
    }

    #[test]
    fn a_local_model_has_the_name_of_its_file() {
        assert_eq!(local_name(Path::new("folder/mine.gguf")), "mine");
        assert_eq!(local_name(Path::new("smollm2")), "smollm2");
    }
}
