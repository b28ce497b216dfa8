//! A [`ChatModel`] behind the endpoint of a provider.
//!
//! `rig-core` encodes requests in the protocols of OpenAI and compatible servers, Anthropic and
//! Gemini; [`crate::transport`] sends them. Each exchange is one request and one complete answer.

use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::time::Instant;

use base64::Engine;
use openbench_core::{ModelUse, with_causes};
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
    /// The strictest request for a form that the endpoint understands, as far as known: an index
    /// into [`FORM_REQUESTS`].
    form_request: AtomicU8,
    /// Whether the model has rejected a temperature, as reasoning models do.
    rejects_temperature: AtomicBool,
}

/// A way to request the form of an answer, the strictest first. OpenAI-compatible endpoints differ
/// in how many of these they support.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd)]
enum FormRequest {
    /// With the JSON Schema.
    Schema,
    /// With the mode for JSON.
    Json,
    /// In the words of the prompt only.
    Prompt,
}

const FORM_REQUESTS: [FormRequest; 3] =
    [FormRequest::Schema, FormRequest::Json, FormRequest::Prompt];

impl Remote {
    /// A model at `base`, which has no trailing slash.
    pub(crate) fn new(provider: Provider, model: &str, base: &str, transport: Transport) -> Self {
        let wire = match provider {
            Provider::OpenAi => {
                let mut dialect = OPENAI;
                if base != Provider::OpenAi.own_base() {
                    // Many compatible servers accept only text, not a list of parts, as `system`.
                    dialect.quirks.rewrite = BodyRewrite::Perplexity;
                }
                // An empty key: `transport` removes it and adds the real one, so that no other code
                // holds it.
                let config = OpenAIConfig::with_key(&dialect, "").with_base_url(base);
                Model::new(config.chat(model), transport.clone()).erase()
            }
            Provider::Anthropic => {
                let client = AnthropicConfig::new("")
                    .with_base_url(base)
                    .connect(transport.clone());
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
            form_request: AtomicU8::new(0),
            rejects_temperature: AtomicBool::new(false),
        }
    }

    /// Sends a request. If the endpoint rejects the way in which the form of the answer is
    /// requested, or the temperature, sends it again without that, and remembers what works.
    fn send(&self, request: &ChatRequest) -> CountedReply {
        let mut total = ModelUse::default();
        let mut refusal = None;
        for form in self.form_requests(&request.format) {
            let CountedReply { reply, used } = self.send_as(form, request);
            // Each attempt is a call that may cost, so all of them count against the budget.
            total = total.plus(used);
            match reply {
                Err(error) if is_about_form(&error) => {
                    // The first refusal is reported: it is about what was asked for, not about a
                    // way around it.
                    refusal.get_or_insert(error);
                }
                reply => {
                    // Remembered only if the weaker request works: the refusal may have had another
                    // cause.
                    if refusal.is_some() && reply.is_ok() {
                        self.form_request.store(form as u8, Ordering::Relaxed);
                    }
                    return CountedReply { reply, used: total };
                }
            }
        }
        let refusal =
            refusal.unwrap_or_else(|| self.bad_request("there is no way to request its form"));
        CountedReply {
            reply: Err(refusal),
            used: total,
        }
    }

    /// The requests for this form that the endpoint may support, the strictest first.
    fn form_requests(&self, format: &Format) -> impl Iterator<Item = FormRequest> {
        let first = match format {
            Format::Text => FormRequest::Prompt,
            Format::Json => FormRequest::Json,
            Format::Schema(_) => FormRequest::Schema,
        };
        let index = usize::from(self.form_request.load(Ordering::Relaxed));
        let known = FORM_REQUESTS[index.min(FORM_REQUESTS.len() - 1)];
        // Anthropic has no mode for JSON without a schema.
        let has_json = self.provider != Provider::Anthropic;
        FORM_REQUESTS.into_iter().filter(move |form| {
            *form >= first && *form >= known && (has_json || *form != FormRequest::Json)
        })
    }

    fn send_as(&self, form: FormRequest, request: &ChatRequest) -> CountedReply {
        let rejects_temperature = self.rejects_temperature.load(Ordering::Relaxed);
        let first = self.send_once(form, request, rejects_temperature);
        let refusal = first.reply.as_ref().err().and_then(refusal);
        let is_about_temperature = refusal.is_some_and(|message| message.contains("temperature"));
        if rejects_temperature || !is_about_temperature {
            return first;
        }
        let again = self.send_once(form, request, true);
        if again.reply.is_ok() {
            self.rejects_temperature.store(true, Ordering::Relaxed);
        }
        CountedReply {
            reply: again.reply,
            used: first.used.plus(again.used),
        }
    }

    fn send_once(
        &self,
        form: FormRequest,
        request: &ChatRequest,
        rejects_temperature: bool,
    ) -> CountedReply {
        let request = match self.translated(form, request) {
            Ok(request) if rejects_temperature => request.temperature(None),
            Ok(request) => request,
            Err(error) => {
                return CountedReply {
                    reply: Err(error),
                    used: ModelUse::default(),
                };
            }
        };
        // The transport blocks and its futures are ready at once, so no runtime is needed.
        match pollster::block_on(self.wire.call(request)) {
            Err(error) => CountedReply::of_one_call(Err(self.failure(&error))),
            Ok(response) => {
                let tokens = Tokens::of(&response);
                let mut counted = CountedReply::of_one_call(self.reply(&response));
                // An unusable answer costs as much as any other.
                counted.used.prompt_tokens = tokens.prompt.into();
                counted.used.completion_tokens = tokens.completion.into();
                counted
            }
        }
    }

    fn translated(
        &self,
        form: FormRequest,
        request: &ChatRequest,
    ) -> Result<CompletionRequest, ChatError> {
        let Some((last, before)) = request.messages.split_last() else {
            return Err(self.bad_request("it has no messages"));
        };
        let translated = CompletionRequest::new(message(last))
            .messages(before.iter().map(message))
            .temperature(f64::from(request.temperature))
            .max_tokens(u64::from(request.max_tokens));
        Ok(match (&request.format, form) {
            (Format::Schema(schema), FormRequest::Schema) => {
                translated.output_schema(self.schema(schema)?)
            }
            (_, FormRequest::Prompt) => translated,
            _ => match self.provider {
                Provider::OpenAi => translated
                    .additional_params(json!({ "response_format": { "type": "json_object" } })),
                Provider::Gemini => translated.additional_params(
                    json!({ "generationConfig": { "responseMimeType": "application/json" } }),
                ),
                // Anthropic has no such mode: the prompt requests JSON.
                Provider::Anthropic => translated,
            },
        })
    }

    fn schema(&self, schema: &Schema) -> Result<schemars::Schema, ChatError> {
        let mut value: serde_json::Value =
            serde_json::from_str(&schema.text).map_err(|e| self.bad_schema(&e))?;
        if let Some(object) = value.as_object_mut() {
            // `rig-core` names a schema after its title.
            object.insert("title".into(), schema.name.clone().into());
        }
        schemars::Schema::try_from(value).map_err(|e| self.bad_schema(&e))
    }

    fn bad_schema(&self, error: &dyn std::error::Error) -> ChatError {
        self.bad_request(&format!(
            "its schema cannot be used: {}",
            with_causes(error)
        ))
    }

    fn reply(&self, response: &CompletionResponse) -> Result<ChatReply, ChatError> {
        let text = response.text();
        match response.finish_reason() {
            Some(FinishReason::Length) => {
                return Err(
                    self.bad_reply("it was truncated at the maximum length; allow more tokens")
                );
            }
            Some(FinishReason::ContentFilter) => {
                return Err(self.bad_reply("it was withheld by the content filter of the provider"));
            }
            // After truncation and filter, which may also leave no text but say more about the
            // cause.
            reason if text.trim().is_empty() => {
                let reason = match reason {
                    Some(reason) => quote(&format!("{reason:?}")),
                    None => "none given".into(),
                };
                return Err(
                    self.bad_reply(&format!("it contains no text (finish reason: {reason})"))
                );
            }
            _ => {}
        }
        let tokens = Tokens::of(response);
        Ok(ChatReply {
            text: self.transport.redact(&text),
            prompt_tokens: tokens.prompt,
            completion_tokens: tokens.completion,
        })
    }

    /// The error of the transport, or why the answer cannot be decoded.
    fn failure(&self, error: &ProviderError) -> ChatError {
        // As it is: it names the address and says whether a time-out or a status is the cause.
        if let Some(error) = of_transport(error) {
            return error.clone();
        }
        match error {
            ProviderError::Request(detail) => self.bad_request(&with_causes(detail)),
            ProviderError::Json(detail) => {
                self.bad_reply(&format!("not JSON: {}", with_causes(detail)))
            }
            ProviderError::ProviderResponse(response) => self.bad_reply(&response.body),
            _ => self.bad_reply(&with_causes(error)),
        }
    }

    fn bad_reply(&self, detail: &str) -> ChatError {
        ChatError::BadReply {
            endpoint: self.base.clone(),
            detail: quote(&self.transport.redact(detail)),
        }
    }

    fn bad_request(&self, detail: &str) -> ChatError {
        ChatError::BadRequest {
            endpoint: self.base.clone(),
            detail: quote(&self.transport.redact(detail)),
        }
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
        let mut counted = self.send(request);
        counted.used.latency_ms = start.elapsed().as_millis().try_into().unwrap_or(u64::MAX);
        counted
    }
}

/// Words in the messages of endpoints that reject the request for a form.
const FORM_WORDS: [&str; 9] = [
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

/// The message of an endpoint that rejects the request itself, in lower case.
fn refusal(error: &ChatError) -> Option<String> {
    match error {
        ChatError::Status {
            code: 400 | 422,
            detail,
            ..
        } => Some(detail.trim().to_lowercase()),
        _ => None,
    }
}

/// Whether an endpoint may reject the request for a form: its message says so or is empty.
fn is_about_form(error: &ChatError) -> bool {
    refusal(error).is_some_and(|message| {
        message.is_empty() || FORM_WORDS.iter().any(|word| message.contains(word))
    })
}

/// The error of the transport inside an error of `rig-core`.
fn of_transport(error: &ProviderError) -> Option<&ChatError> {
    match error {
        ProviderError::Http(inner) => match &**inner {
            rig_core::http_client::Error::Instance(inner) => inner.downcast_ref::<ChatError>(),
            _ => None,
        },
        _ => None,
    }
}

/// Tokens of a request and its answer; 0 where the provider does not count them.
struct Tokens {
    prompt: u32,
    completion: u32,
}

impl Tokens {
    fn of(response: &CompletionResponse) -> Self {
        Self {
            prompt: count(response.usage.input_tokens),
            completion: count(response.usage.output_tokens),
        }
    }
}

fn count(tokens: Option<u64>) -> u32 {
    tokens.unwrap_or(0).try_into().unwrap_or(u32::MAX)
}

fn message(message: &Message) -> RigMessage {
    match message.role {
        Role::System => RigMessage::system(&message.text),
        Role::Assistant => RigMessage::assistant(&message.text),
        Role::User => {
            let mut content = vec![UserContent::text(&message.text)];
            content.extend(message.images.iter().map(|file| image(file)));
            RigMessage::User { content }
        }
    }
}

fn image(file: &[u8]) -> UserContent {
    // The magic bytes of JPEG. Messages contain PNG or JPEG only.
    let kind = if file.starts_with(&[0xff, 0xd8]) {
        ImageMediaType::JPEG
    } else {
        ImageMediaType::PNG
    };
    let text = base64::engine::general_purpose::STANDARD.encode(file);
    UserContent::image_base64(text, Some(kind), None)
}

#[cfg(test)]
#[path = "remote_tests.rs"]
mod tests;
