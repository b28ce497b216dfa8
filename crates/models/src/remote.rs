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

use crate::chat::{
    ChatError, ChatModel, ChatReply, ChatRequest, CountedReply, Format, Message, Role, Schema,
};
use crate::provider::Provider;
use crate::quote::quote;
use crate::transport::Transport;

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

    /// Asks; where the endpoint refuses how the answer's form is asked for, or the temperature, without that, and remembers it.
    fn ask(&self, request: &ChatRequest) -> CountedReply {
        let mut total = ModelUse::default();
        let mut refusal = None;
        for rung in self.rungs(&request.format) {
            let CountedReply { reply, used } = self.ask_by(rung, request);
            total = total.plus(used);
            match reply {
                Err(error) if is_about_form(&error) => {
                    refusal.get_or_insert(error);
                }
                reply => {
                    if refusal.is_some() && reply.is_ok() {
                        self.rung.store(rung as u8, Ordering::Relaxed);
                    }
                    return CountedReply { reply, used: total };
                }
            }
        }
        let refusal = refusal.unwrap_or_else(|| self.bad_request("there is no form to ask for"));
        CountedReply { reply: Err(refusal), used: total }
    }

    /// The ways to ask for a form that the endpoint may understand, the strictest first.
    fn rungs(&self, format: &Format) -> impl Iterator<Item = Rung> {
        let first = match format {
            Format::Text => Rung::Prompt,
            Format::Json => Rung::Json,
            Format::Schema(_) => Rung::Schema,
        };
        let known = LADDER[usize::from(self.rung.load(Ordering::Relaxed)).min(LADDER.len() - 1)];
        // Anthropic has no mode for JSON without a schema.
        let has_json = self.provider != Provider::Anthropic;
        LADDER
            .into_iter()
            .filter(move |rung| *rung >= first && *rung >= known && (has_json || *rung != Rung::Json))
    }

    fn ask_by(&self, rung: Rung, request: &ChatRequest) -> CountedReply {
        let is_stubborn = self.is_stubborn.load(Ordering::Relaxed);
        let first = self.ask_once(rung, request, is_stubborn);
        let said = first.reply.as_ref().err().and_then(refusal).unwrap_or_default();
        if is_stubborn || !said.contains("temperature") {
            return first;
        }
        let again = self.ask_once(rung, request, true);
        if again.reply.is_ok() {
            self.is_stubborn.store(true, Ordering::Relaxed);
        }
        CountedReply { reply: again.reply, used: first.used.plus(again.used) }
    }

    fn ask_once(&self, rung: Rung, request: &ChatRequest, is_stubborn: bool) -> CountedReply {
        let request = match self.translated(rung, request) {
            Ok(request) if is_stubborn => request.temperature(None),
            Ok(request) => request,
            Err(error) => return CountedReply { reply: Err(error), used: ModelUse::default() },
        };
        match pollster::block_on(self.wire.call(request)) {
            Err(error) => CountedReply::of_one_call(Err(self.failure(&error))),
            Ok(response) => {
                let tokens = Tokens::of(&response);
                let mut counted = CountedReply::of_one_call(self.reply(&response));
                // An answer of no use costs as much as another.
                counted.used.prompt_tokens = tokens.prompt.into();
                counted.used.completion_tokens = tokens.completion.into();
                counted
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
        let mut value: serde_json::Value =
            serde_json::from_str(&schema.text).map_err(|e| self.bad_schema(&e))?;
        if let Some(object) = value.as_object_mut() {
            object.insert("title".into(), schema.name.clone().into());
        }
        schemars::Schema::try_from(value).map_err(|e| self.bad_schema(&e))
    }

    fn bad_schema(&self, error: &dyn std::error::Error) -> ChatError {
        self.bad_request(&format!("its schema cannot be used: {error}"))
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
                let reason = match reason {
                    Some(reason) => quote(&format!("{reason:?}")),
                    None => "none given".into(),
                };
                return Err(self.bad_reply(&format!("it holds no text (finish reason: {reason})")));
            }
            _ => {}
        }
        let tokens = Tokens::of(response);
        Ok(ChatReply {
            text: self.transport.blot_out(&text),
            prompt_tokens: tokens.prompt,
            completion_tokens: tokens.completion,
        })
    }

    /// What the transport said, or what the wire could not make of the answer.
    fn failure(&self, error: &ProviderError) -> ChatError {
        if let Some(error) = of_transport(error) {
            return error.clone();
        }
        match error {
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
        self.chat_counted(request).reply
    }

    fn chat_counted(&self, request: &ChatRequest) -> CountedReply {
        let start = Instant::now();
        let mut counted = self.ask(request);
        counted.used.latency_ms = start.elapsed().as_millis().try_into().unwrap_or(u64::MAX);
        counted
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

/// What the transport reported, inside the error of a provider's wire.
fn of_transport(error: &ProviderError) -> Option<&ChatError> {
    match error {
        ProviderError::Http(inner) => match &**inner {
            rig_core::http_client::Error::Instance(inner) => inner.downcast_ref::<ChatError>(),
            _ => None,
        },
        _ => None,
    }
}

/// Tokens of a request and its answer, as far as the provider counts them.
struct Tokens {
    prompt: u32,
    completion: u32,
}

impl Tokens {
    fn of(response: &CompletionResponse) -> Self {
        Self { prompt: count(response.usage.input_tokens), completion: count(response.usage.output_tokens) }
    }
}

fn count(tokens: Option<u64>) -> u32 {
    tokens.unwrap_or(0).try_into().unwrap_or(u32::MAX)
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
