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

use std::path::{Path, PathBuf};

use crate::error::SpecError;
use crate::provider::Provider;

/// The address of Ollama's endpoint unless its user changes it.
const OLLAMA: &str = "http://127.0.0.1:11434/v1";

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

impl ModelSpec {
    /// Reads the forms in the module's table. Nothing is opened.
    ///
    /// # Errors
    /// [`SpecError::Unknown`].
    pub fn parse(spec: &str) -> Result<Self, SpecError> {
        Self::read(spec).ok_or_else(|| SpecError::Unknown { spec: spec.to_owned() })
    }

    fn read(spec: &str) -> Option<Self> {
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

    /// `MODEL` or `MODEL@URL`. Names of models may hold an `@` themselves.
    fn remote(provider: Provider, text: &str, preset: Option<&str>) -> Option<Self> {
        let at = text.find("@http://").or_else(|| text.find("@https://"));
        let (model, base) = match at {
            Some(at) => (&text[..at], Some(&text[at + 1..])),
            None => (text, preset),
        };
        let base = base.map(str::to_owned);
        (!model.is_empty()).then(|| Self::Remote { provider, model: model.to_owned(), base })
    }
}

/// What a local model is called: its file's name as it was given, without `.gguf`.
pub fn local_name(file: &Path) -> String {
    let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
    name.strip_suffix(".gguf").map(str::to_owned).unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn remote(provider: Provider, model: &str, base: Option<&str>) -> ModelSpec {
        ModelSpec::Remote { provider, model: model.into(), base: base.map(Into::into) }
    }

    #[test]
    fn forms() {
        use Provider::{Anthropic, Gemini, OpenAi};
        for (text, spec) in [
            ("openai:m", remote(OpenAi, "m", None)),
            ("ollama:qwen2.5:0.5b", remote(OpenAi, "qwen2.5:0.5b", Some(OLLAMA))),
            ("ollama:m@http://h/v1", remote(OpenAi, "m", Some("http://h/v1"))),
            ("anthropic:m", remote(Anthropic, "m", None)),
            ("gemini:m@https://h", remote(Gemini, "m", Some("https://h"))),
            ("openai:@cf/m:7b@http://h:1/v1", remote(OpenAi, "@cf/m:7b", Some("http://h:1/v1"))),
            ("replay:a:b", ModelSpec::Replay("a:b".into())),
            ("local:a:b", ModelSpec::Local("a:b".into())),
        ] {
            assert_eq!(ModelSpec::parse(text).unwrap(), spec);
        }
    }

    #[test]
    fn other_texts_are_refused() {
        for bad in
            ["", "openai", "openai:", "openai:@http://h", "replay:", "local:", "gpt", "ollama:", "claude:m"]
        {
            assert!(matches!(ModelSpec::parse(bad), Err(SpecError::Unknown { .. })), "{bad}");
        }
    }

    #[test]
    fn a_local_model_is_called_as_its_file() {
        assert_eq!(local_name(Path::new("folder/mine.gguf")), "mine");
        assert_eq!(local_name(Path::new("smollm2")), "smollm2");
    }
}
