//! From the name of a chat model to the model: endpoints with their keys, files, recordings.
//!
//! What the name leaves open comes from the environment. Nothing is sent while a model is opened.

use std::time::Duration;

use crate::address;
use crate::chat::ChatModel;
use crate::error::{LocalError, OpenError};
use crate::provider::Provider;
use crate::remote::Remote;
use crate::replay::Replay;
use crate::secret::Secret;
use crate::spec::ModelSpec;
use crate::transport::{Bounds, Credential, Transport};

const BASE_VARIABLE: &str = "OPENBENCH_API_BASE";
const KEY_VARIABLE: &str = "OPENBENCH_API_KEY";
const TIMEOUT_VARIABLE: &str = "OPENBENCH_API_TIMEOUT";
/// How long an answer of a model in this process is waited for.
const LOCAL_TIMEOUT: Duration = Duration::from_secs(600);

impl ModelSpec {
    /// Makes the model, with base address and key from the process's environment where the text
    /// leaves them open. Nothing is sent yet.
    ///
    /// # Errors
    /// Any [`OpenError`].
    pub fn open(&self) -> Result<Box<dyn ChatModel>, OpenError> {
        self.open_with(|variable| std::env::var(variable).ok())
    }

    /// [`ModelSpec::open`] in another environment than the process's.
    ///
    /// # Errors
    /// As [`ModelSpec::open`].
    pub fn open_with(
        &self,
        environment: impl Fn(&str) -> Option<String>,
    ) -> Result<Box<dyn ChatModel>, OpenError> {
        match self {
            Self::Replay(file) => Ok(Box::new(Replay::open(file)?)),
            Self::Local(name) => {
                let timeout = timeout(&environment)?.unwrap_or(LOCAL_TIMEOUT);
                local(name, timeout).map_err(|source| OpenError::Local { name: name.clone(), source })
            }
            Self::Remote { provider, model, base } => {
                let mut bounds = Bounds::default();
                bounds.timeout = timeout(&environment)?.unwrap_or(bounds.timeout);
                let endpoint = Endpoint::new(*provider, base.as_deref(), &environment)?;
                Ok(Box::new(endpoint.model(model, bounds)))
            }
        }
    }
}

#[cfg(feature = "local-llm")]
fn local(name: &str, timeout: Duration) -> Result<Box<dyn ChatModel>, LocalError> {
    let file = crate::store::ModelStore::from_environment()?.chat_model(name)?;
    Ok(Box::new(crate::local::Local::open(&file, timeout)?))
}

#[cfg(not(feature = "local-llm"))]
fn local(_: &str, _: Duration) -> Result<Box<dyn ChatModel>, LocalError> {
    Err(LocalError::NotBuilt)
}

/// Where a provider's protocol is spoken, and the key for it.
#[derive(Debug)]
pub(crate) struct Endpoint {
    provider: Provider,
    /// Without a slash at its end.
    base: String,
    key: Option<Secret>,
}

impl Endpoint {
    /// The endpoint at `base`; the environment's where it is left open, else the provider's own.
    pub(crate) fn new(
        provider: Provider,
        base: Option<&str>,
        environment: impl Fn(&str) -> Option<String>,
    ) -> Result<Self, OpenError> {
        let base = match (base, provider) {
            (Some(base), _) => Some(base.to_owned()),
            (None, Provider::OpenAi) => filled(&environment, BASE_VARIABLE),
            (None, _) => None,
        };
        let base = address::checked(base.as_deref().unwrap_or(provider.own_base()))?;
        let key = key(provider, &base, &environment)?;
        if key.is_some() && base.starts_with("http://") && !address::is_loopback(&base) {
            let detail = "a key would travel unencrypted; use https, or unset OPENBENCH_API_KEY";
            return Err(OpenError::BadBase { base, detail });
        }
        Ok(Self { provider, base, key })
    }

    /// A model behind the endpoint.
    pub(crate) fn model(self, name: &str, bounds: Bounds) -> Remote {
        let header = self.provider.key_header();
        let credential = self.key.map(|key| Credential { key, header });
        let transport = Transport::new(&self.base, credential, bounds);
        Remote::new(self.provider, name, &self.base, transport)
    }
}

/// The key for an endpoint: the provider's, which goes to its own endpoint only, else the general one.
fn key(
    provider: Provider,
    base: &str,
    environment: impl Fn(&str) -> Option<String>,
) -> Result<Option<Secret>, OpenError> {
    let is_own = base == provider.own_base();
    let own = is_own.then(|| provider.key_variable());
    for variable in own.into_iter().chain([KEY_VARIABLE]) {
        if let Some(text) = filled(&environment, variable) {
            let key = Secret::new(&text).ok_or(OpenError::UnusableKey { variable })?;
            return Ok(Some(key));
        }
    }
    if is_own {
        let variable = provider.key_variable();
        return Err(OpenError::MissingKey { base: base.to_owned(), variable });
    }
    Ok(None)
}

/// How long an answer is waited for, if the environment says so.
fn timeout(environment: impl Fn(&str) -> Option<String>) -> Result<Option<Duration>, OpenError> {
    let Some(text) = environment(TIMEOUT_VARIABLE).filter(|text| !text.trim().is_empty()) else {
        return Ok(None);
    };
    match text.trim().parse::<u64>() {
        Ok(seconds @ 1..=3600) => Ok(Some(Duration::from_secs(seconds))),
        _ => Err(OpenError::BadTimeout { text }),
    }
}

/// What a variable holds, without blanks at its ends; `None` where nothing is left.
fn filled(environment: impl Fn(&str) -> Option<String>, variable: &str) -> Option<String> {
    let text = environment(variable)?.trim().to_owned();
    (!text.is_empty()).then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(spec: &str, variables: &[(&str, &str)]) -> Result<Box<dyn ChatModel>, OpenError> {
        ModelSpec::parse(spec).unwrap().open_with(|name| value(variables, name))
    }

    fn value(variables: &[(&str, &str)], name: &str) -> Option<String> {
        let (_, value) = variables.iter().find(|(variable, _)| *variable == name)?;
        Some((*value).to_owned())
    }

    #[test]
    fn openai_needs_a_key_and_a_local_server_does_not() {
        assert!(matches!(open("openai:m", &[]), Err(OpenError::MissingKey { .. })));
        let blank = open("openai:m", &[("OPENAI_API_KEY", " ")]);
        assert!(matches!(blank, Err(OpenError::MissingKey { .. })));
        assert!(open("openai:m", &[("OPENAI_API_KEY", "k\n")]).is_ok());
        assert_eq!(open("openai:m@http://localhost:1/v1", &[]).unwrap().name(), "m");
    }

    #[test]
    fn a_providers_key_goes_to_that_provider_only() {
        for provider in [Provider::OpenAi, Provider::Anthropic, Provider::Gemini] {
            let variables = [(provider.key_variable(), "k")];
            let own = Endpoint::new(provider, None, |name| value(&variables, name)).unwrap();
            assert!(own.key.is_some());
            let other = Some("https://other.example/v1");
            let other = Endpoint::new(provider, other, |name| value(&variables, name)).unwrap();
            assert!(other.key.is_none());
            let without = Endpoint::new(provider, None, |_| None);
            assert!(matches!(without, Err(OpenError::MissingKey { .. })));
        }
    }

    #[test]
    fn keys_do_not_travel_in_the_clear() {
        let key = [("OPENBENCH_API_KEY", "k")];
        let far = open("openai:m@http://far.example/v1", &key);
        assert!(matches!(far, Err(OpenError::BadBase { .. })));
        assert!(open("openai:m@http://far.example/v1", &[]).is_ok());
        assert!(open("openai:m@http://127.0.0.1:1/v1", &key).is_ok());
    }

    #[test]
    fn passwords_in_addresses_are_not_shown() {
        let error = open("openai:m@https://u:secret@h/v1", &[]).err().unwrap();
        assert!(matches!(error, OpenError::BadBase { .. }));
        assert!(!format!("{error} {error:?}").contains("secret"));
    }

    #[test]
    fn time_outs_are_whole_seconds() {
        for good in ["5", " "] {
            assert!(open("ollama:m", &[(TIMEOUT_VARIABLE, good)]).is_ok(), "{good}");
        }
        for bad in ["0", "3601", "1.5", "-1", "soon"] {
            let opened = open("ollama:m", &[(TIMEOUT_VARIABLE, bad)]);
            assert!(matches!(opened, Err(OpenError::BadTimeout { .. })), "{bad}");
        }
    }

    #[test]
    fn unusable_keys_are_named_not_shown() {
        let error = open("openai:m", &[("OPENBENCH_API_KEY", "sec\nret")]).err().unwrap();
        assert!(matches!(error, OpenError::UnusableKey { variable: "OPENBENCH_API_KEY" }));
        assert!(!format!("{error} {error:?}").contains("sec\n"));
    }
}
