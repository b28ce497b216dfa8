//! A model at a provider's endpoint as a [`ChatModel`].
//!
//! What a request looks like on the wire of OpenAI (and of the many servers that speak as it does), Anthropic and Gemini is `rig-core`'s business; how it
//! gets there, [`crate::transport`]'s. Each exchange is one request and one whole answer.

use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::time::Instant;

use base64::Engine;
use openbench_core::ModelUse;
use rig_core::completion::{CompletionRequest, CompletionResponse, FinishReason};
use rig_core::driver::{DynModel, Model};
use rig_core::message::{ImageMediaType, Message as RigMessage, UserContent};
use rig_core::operation::Completion;
use rig_core::providers::anthropic::wire::AnthropicConfig;
use rig_core::providers::gemini::GeminiConfig;
use rig_core::providers::gemini::completion::GenerateContent;
use rig_core::providers::openai::wire::{BodyRewrite, OPENAI, OpenAIConfig};
use rig_core::{ProviderError, schemars};
use serde_json::json;

use crate::chat::{ChatError, ChatModel, ChatReply, ChatRequest, Format, Message, Role, Schema};
use crate::spec::Provider;
use crate::transport::{Transport, quote};

/// A model behind an endpoint. Made by [`crate::ModelSpec::open`].
#[derive(Debug)]
pub(crate) struct Remote {
    name: String,
    base: String,
    provider: Provider,
    wire: DynModel<Completion>,
    transport: Transport,
    /// How much less than a schema the endpoint was found to understand: an index into [`LADDER`].
    rung: AtomicU8,
    /// Whether the model was found to take no temperature, as those that reason do.
    is_stubborn: AtomicBool,
}

/// What a provider said or failed to say, and what it counted.
type Counted = (Result<ChatReply, ChatError>, ModelUse);

/// How an answer's form is asked for, the strictest first. Endpoints that speak as OpenAI does differ in how many of these they know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd)]
enum Rung {
    Schema,
    Json,
    Prompt,
}

const LADDER: [Rung; 3] = [Rung::Schema, Rung::Json, Rung::Prompt];

impl Remote {
    /// `base` is without a slash at its end.
    pub(crate) fn new(provider: Provider, model: &str, base: &str, transport: Transport) -> Self {
        let wire = match provider {
            Provider::OpenAi => {
                let mut dialect = OPENAI;
                if base != Provider::OpenAi.own_base() {
                    // Many servers that speak as OpenAI does take a text, and no list of parts, from `system`.
                    dialect.quirks.rewrite = BodyRewrite::Perplexity;
                }
                let config = OpenAIConfig::with_key(&dialect, "").with_base_url(base);
                Model::new(config.chat(model), transport.clone()).erase()
            }
            Provider::Anthropic => {
                let client = AnthropicConfig::new("").with_base_url(base).connect(transport.clone());
                Model::new(client.completion(model).wire, transport.clone()).erase()
            }
            Provider::Gemini => {
                let config = GeminiConfig::new("").with_base_url(base);
                Model::new(GenerateContent::new(config, model), transport.clone()).erase()
            }
        };
        Self {
            name: model.to_owned(),
            base: base.to_owned(),
            provider,
            wire,
            transport,
            rung: AtomicU8::new(0),
            is_stubborn: AtomicBool::new(false),
        }
    }

    #[cfg(test)]
    pub(crate) fn has_key(&self) -> bool {
        self.transport.has_key()
    }

    /// Asks; where the endpoint refuses how the answer's form is asked for, or the temperature, without that, and remembers it.
    fn ask(&self, request: &ChatRequest) -> Counted {
        let first = match &request.format {
            Format::Text => Rung::Prompt,
            Format::Json => Rung::Json,
            Format::Schema(_) => Rung::Schema,
        };
        let known = LADDER[usize::from(self.rung.load(Ordering::Relaxed)).min(LADDER.len() - 1)];
        let rungs = LADDER.into_iter().filter(|rung| *rung >= first && *rung >= known);
        // Anthropic has no mode for JSON without a schema.
        let rungs = rungs.filter(|rung| self.provider != Provider::Anthropic || *rung != Rung::Json);
        let (mut total, mut refusal) = (ModelUse::default(), None);
        for rung in rungs {
            let (answer, used) = self.ask_by(rung, request);
            total = total.plus(used);
            match answer {
                Err(error) if is_about_form(&error) => {
                    refusal.get_or_insert(error);
                }
                answer => {
                    if refusal.is_some() && answer.is_ok() {
                        self.rung.store(rung as u8, Ordering::Relaxed);
                    }
                    return (answer, total);
                }
            }
        }
        let refusal = refusal.unwrap_or_else(|| self.bad_request("there is no form to ask for"));
        (Err(refusal), total)
    }

    fn ask_by(&self, rung: Rung, request: &ChatRequest) -> Counted {
        let is_stubborn = self.is_stubborn.load(Ordering::Relaxed);
        let (answer, used) = self.ask_once(rung, request, is_stubborn);
        let said = answer.as_ref().err().and_then(refusal).unwrap_or_default();
        if is_stubborn || !said.contains("temperature") {
            return (answer, used);
        }
        let (again, more) = self.ask_once(rung, request, true);
        if again.is_ok() {
            self.is_stubborn.store(true, Ordering::Relaxed);
        }
        (again, used.plus(more))
    }

    fn ask_once(&self, rung: Rung, request: &ChatRequest, is_stubborn: bool) -> Counted {
        let request = match self.translated(rung, request) {
            Ok(request) if is_stubborn => request.temperature(None),
            Ok(request) => request,
            Err(error) => return (Err(error), ModelUse::default()),
        };
        let one = ModelUse { calls: 1, ..ModelUse::default() };
        let failed = ModelUse { failed: 1, ..one };
        match pollster::block_on(self.wire.call(request)) {
            Err(error) => (Err(self.failure(&error)), failed),
            Ok(response) => {
                let answer = self.reply(&response);
                let used = if answer.is_ok() { one } else { failed };
                let (prompt_tokens, completion_tokens) = tokens(&response);
                let (prompt_tokens, completion_tokens) = (prompt_tokens.into(), completion_tokens.into());
                (answer, ModelUse { prompt_tokens, completion_tokens, ..used })
            }
        }
    }

    fn translated(&self, rung: Rung, request: &ChatRequest) -> Result<CompletionRequest, ChatError> {
        let Some((last, before)) = request.messages.split_last() else {
            return Err(self.bad_request("it has no messages"));
        };
        let translated = CompletionRequest::new(translated(last))
            .messages(before.iter().map(translated))
            .temperature(f64::from(request.temperature))
            .max_tokens(u64::from(request.max_tokens));
        Ok(match (&request.format, rung) {
            (Format::Schema(schema), Rung::Schema) => translated.output_schema(self.schema(schema)?),
            (_, Rung::Prompt) => translated,
            _ => match self.provider {
                Provider::OpenAi => {
                    translated.additional_params(json!({ "response_format": { "type": "json_object" } }))
                }
                Provider::Gemini => translated.additional_params(
                    json!({ "generationConfig": { "responseMimeType": "application/json" } }),
                ),
                // Has no such mode: the prompt says it.
                Provider::Anthropic => translated,
            },
        })
    }

    fn schema(&self, schema: &Schema) -> Result<schemars::Schema, ChatError> {
        let bad = |detail: String| self.bad_request(&format!("its schema cannot be used: {detail}"));
        let mut value: serde_json::Value =
            serde_json::from_str(&schema.text).map_err(|e| bad(e.to_string()))?;
        if let Some(object) = value.as_object_mut() {
            object.insert("title".into(), schema.name.clone().into());
        }
        schemars::Schema::try_from(value).map_err(|e| bad(e.to_string()))
    }

    fn reply(&self, response: &CompletionResponse) -> Result<ChatReply, ChatError> {
        let text = response.text();
        match response.finish_reason() {
            Some(FinishReason::Length) => {
                return Err(self.bad_reply("it was cut off at the longest answer allowed; allow more tokens"));
            }
            Some(FinishReason::ContentFilter) => {
                return Err(self.bad_reply("the provider's filter withheld it"));
            }
            reason if text.trim().is_empty() => {
                let reason = reason.map_or_else(|| "none given".into(), |r| quote(&format!("{r:?}")));
                return Err(self.bad_reply(&format!("it holds no text (finish reason: {reason})")));
            }
            _ => {}
        }
        let (prompt_tokens, completion_tokens) = tokens(response);
        Ok(ChatReply { text: self.transport.blot_out(&text), prompt_tokens, completion_tokens })
    }

    /// What the transport said, or what the wire could not make of the answer.
    fn failure(&self, error: &ProviderError) -> ChatError {
        let inner = match error {
            ProviderError::Http(inner) => match &**inner {
                rig_core::http_client::Error::Instance(inner) => inner.downcast_ref::<ChatError>().cloned(),
                _ => None,
            },
            _ => None,
        };
        match error {
            _ if inner.is_some() => inner.unwrap_or_else(|| self.bad_reply("")),
            ProviderError::Request(detail) => self.bad_request(&detail.to_string()),
            ProviderError::Json(detail) => self.bad_reply(&format!("not JSON: {detail}")),
            ProviderError::ProviderResponse(response) => self.bad_reply(&response.body),
            _ => self.bad_reply(&error.to_string()),
        }
    }

    fn bad_reply(&self, detail: &str) -> ChatError {
        ChatError::BadReply { endpoint: self.base.clone(), detail: quote(&self.transport.blot_out(detail)) }
    }

    fn bad_request(&self, detail: &str) -> ChatError {
        ChatError::BadRequest { endpoint: self.base.clone(), detail: quote(&self.transport.blot_out(detail)) }
    }
}

impl ChatModel for Remote {
    fn name(&self) -> &str {
        &self.name
    }

    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
        self.chat_counted(request).0
    }

    fn chat_counted(&self, request: &ChatRequest) -> Counted {
        let start = Instant::now();
        let (answer, used) = self.ask(request);
        let latency_ms = start.elapsed().as_millis().try_into().unwrap_or(u64::MAX);
        (answer, ModelUse { latency_ms, ..used })
    }
}

/// Words of endpoints that refuse how an answer's form is asked for.
const FORM: [&str; 9] = [
    "format",
    "schema",
    "json",
    "structured",
    "output_config",
    "unsupported",
    "unexpected",
    "unrecognized",
    "extra",
];

/// What an endpoint says that refuses a request as such, in lower case.
fn refusal(error: &ChatError) -> Option<String> {
    match error {
        ChatError::Status { code: 400 | 422, detail, .. } => Some(detail.trim().to_lowercase()),
        _ => None,
    }
}

/// Whether an endpoint may refuse how an answer's form is asked for: it says so, or does not say why.
fn is_about_form(error: &ChatError) -> bool {
    refusal(error).is_some_and(|said| said.is_empty() || FORM.iter().any(|word| said.contains(word)))
}

/// Tokens of a request and its answer, as far as the provider counts them.
fn tokens(response: &CompletionResponse) -> (u32, u32) {
    let count = |tokens: Option<u64>| tokens.unwrap_or(0).min(u32::MAX.into()) as u32;
    (count(response.usage.input_tokens), count(response.usage.output_tokens))
}

fn translated(message: &Message) -> RigMessage {
    match message.role {
        Role::System => RigMessage::system(&message.text),
        Role::Assistant => RigMessage::assistant(&message.text),
        Role::User => {
            let mut content = vec![UserContent::text(&message.text)];
            content.extend(message.images.iter().map(|file| picture(file)));
            RigMessage::User { content }
        }
    }
}

fn picture(file: &[u8]) -> UserContent {
    let kind = if file.starts_with(&[0xff, 0xd8]) { ImageMediaType::JPEG } else { ImageMediaType::PNG };
    let text = base64::engine::general_purpose::STANDARD.encode(file);
    UserContent::image_base64(text, Some(kind), None)
}

#[cfg(test)]
#[path = "remote_tests.rs"]
mod tests;
