//! Opens the chat model that a [`ModelSpec`] names: an endpoint, a file or a recording.
//!
//! The environment provides what the name leaves open; [`crate::spec`] lists its variables. No
//! request is sent while a model is opened.

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
/// Default time-out for an answer of a model in this process: a slow machine needs
/// minutes for a long prompt.
const LOCAL_TIMEOUT: Duration = Duration::from_secs(600);

impl ModelSpec {
    /// Opens the model. The environment of the process provides address and key where the name
    /// leaves them open. No request is sent.
    ///
    /// # Errors
    /// Any [`OpenError`].
    pub fn open(&self) -> Result<Box<dyn ChatModel>, OpenError> {
        self.open_with(|variable| std::env::var(variable).ok())
    }

    /// [`ModelSpec::open`] with another environment than that of the process.
    ///
    /// ```
    /// use openbench_models::{ModelSpec, OpenError};
    ///
    /// let no_variables = |_: &str| None;
    /// let local = ModelSpec::parse("ollama:qwen2.5:0.5b")?.open_with(no_variables)?;
    /// assert_eq!(local.name(), "qwen2.5:0.5b");
    ///
    /// let openai = ModelSpec::parse("openai:gpt-4o")?.open_with(no_variables);
    /// assert!(matches!(openai, Err(OpenError::MissingKey { .. })));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
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
                local(name, timeout).map_err(|source| OpenError::Local {
                    name: name.clone(),
                    source,
                })
            }
            Self::Remote {
                provider,
                model,
                base,
            } => {
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

/// An endpoint: its protocol, its address and the key for it.
#[derive(Debug)]
pub(crate) struct Endpoint {
    provider: Provider,
    /// Without trailing slash.
    base: String,
    key: Option<Secret>,
}

impl Endpoint {
    /// The endpoint at `base`. Where that is open: the one in the environment, else the provider's
    /// own.
    pub(crate) fn new(
        provider: Provider,
        base: Option<&str>,
        environment: impl Fn(&str) -> Option<String>,
    ) -> Result<Self, OpenError> {
        let base = match (base, provider) {
            (Some(base), _) => Some(base.to_owned()),
            // The variable is for OpenAI-compatible servers; other protocols would not work there.
            (None, Provider::OpenAi) => filled(&environment, BASE_VARIABLE),
            (None, _) => None,
        };
        let base = address::checked(base.as_deref().unwrap_or(provider.own_base()))?;
        let key = key(provider, &base, &environment)?;
        if key.is_some() && base.starts_with("http://") && !address::is_loopback(&base) {
            let detail = "the key would be sent unencrypted; use https, or unset OPENBENCH_API_KEY";
            return Err(OpenError::BadBase { base, detail });
        }
        Ok(Self {
            provider,
            base,
            key,
        })
    }

    /// A model behind the endpoint.
    pub(crate) fn model(self, name: &str, bounds: Bounds) -> Remote {
        let header = self.provider.key_header();
        let credential = self.key.map(|key| Credential { key, header });
        let transport = Transport::new(&self.base, credential, bounds);
        Remote::new(self.provider, name, &self.base, transport)
    }
}

/// The key for an endpoint: the provider's key for the provider's own endpoint, else the general
/// key.
fn key(
    provider: Provider,
    base: &str,
    environment: impl Fn(&str) -> Option<String>,
) -> Result<Option<Secret>, OpenError> {
    let is_own = base == provider.own_base();
    // A provider's key is sent to the provider alone, never to an address that only speaks its
    // protocol.
    let own = is_own.then(|| provider.key_variable());
    for variable in own.into_iter().chain([KEY_VARIABLE]) {
        if let Some(text) = filled(&environment, variable) {
            // An error, not the next variable: a damaged key must not be replaced by another one
            // silently.
            let key = Secret::new(&text).ok_or(OpenError::UnusableKey { variable })?;
            return Ok(Some(key));
        }
    }
    if is_own {
        let variable = provider.key_variable();
        return Err(OpenError::MissingKey {
            base: base.to_owned(),
            variable,
        });
    }
    Ok(None)
}

/// The time-out for an answer that the environment sets.
fn timeout(environment: impl Fn(&str) -> Option<String>) -> Result<Option<Duration>, OpenError> {
    let Some(text) = environment(TIMEOUT_VARIABLE).filter(|text| !text.trim().is_empty()) else {
        return Ok(None);
    };
    match text.trim().parse::<u64>() {
        Ok(seconds @ 1..=3600) => Ok(Some(Duration::from_secs(seconds))),
        _ => Err(OpenError::BadTimeout { text }),
    }
}

/// The value of a variable without surrounding white space; `None` if it is empty.
fn filled(environment: impl Fn(&str) -> Option<String>, variable: &str) -> Option<String> {
    let text = environment(variable)?.trim().to_owned();
    (!text.is_empty()).then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(spec: &str, variables: &[(&str, &str)]) -> Result<Box<dyn ChatModel>, OpenError> {
        ModelSpec::parse(spec)
            .unwrap()
            .open_with(|name| value(variables, name))
    }

    fn value(variables: &[(&str, &str)], name: &str) -> Option<String> {
        let (_, value) = variables.iter().find(|(variable, _)| *variable == name)?;
        Some((*value).to_owned())
    }

    #[test]
    fn openai_requires_a_key_and_a_local_server_does_not() {
        assert!(matches!(
            open("openai:m", &[]),
            Err(OpenError::MissingKey { .. })
        ));
        let blank = open("openai:m", &[("OPENAI_API_KEY", " ")]);
        assert!(matches!(blank, Err(OpenError::MissingKey { .. })));
        assert!(open("openai:m", &[("OPENAI_API_KEY", "k\n")]).is_ok());
        assert_eq!(
            open("openai:m@http://localhost:1/v1", &[]).unwrap().name(),
            "m"
        );
    }

    #[test]
    fn a_providers_key_is_sent_to_that_provider_only() {
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
    fn keys_are_not_sent_unencrypted() {
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
            assert!(
                open("ollama:m", &[(TIMEOUT_VARIABLE, good)]).is_ok(),
                "{good}"
            );
        }
        for bad in ["0", "3601", "1.5", "-1", "soon"] {
            let opened = open("ollama:m", &[(TIMEOUT_VARIABLE, bad)]);
            assert!(matches!(opened, Err(OpenError::BadTimeout { .. })), "{bad}");
        }
    }

    #[test]
    fn invalid_keys_are_not_shown() {
        let error = open("openai:m", &[("OPENBENCH_API_KEY", "sec\nret")])
            .err()
            .unwrap();
        assert!(matches!(
            error,
            OpenError::UnusableKey {
                variable: "OPENBENCH_API_KEY"
            }
        ));
        assert!(!format!("{error} {error:?}").contains("sec\n"));
    }
}
