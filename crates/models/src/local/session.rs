//! A loaded model: it reads prompts and writes answers token by token.

use std::num::NonZeroU32;
use std::time::Instant;

use llama_cpp_2::context::LlamaContext;
use llama_cpp_2::context::params::LlamaContextParams;
use llama_cpp_2::llama_backend::LlamaBackend;
use llama_cpp_2::llama_batch::LlamaBatch;
use llama_cpp_2::model::{LlamaChatMessage, LlamaChatTemplate, LlamaModel};
use llama_cpp_2::sampling::LlamaSampler;
use llama_cpp_2::token::LlamaToken;
use llama_cpp_2::token::data::LlamaTokenData;
use llama_cpp_2::token::data_array::LlamaTokenDataArray;
use openbench_core::{ModelUse, with_causes};
use sha2::Digest;

use super::control_tokens::{break_up, control_tokens};
use super::written::Written;
use crate::chat::{ChatError, ChatReply, ChatRequest, CountedReply, Format, Message, Role};
use crate::error::LocalError;
use crate::gbnf;

/// Number of tokens that are read at a time. The number is fixed, since sums of other batches
/// differ in their last bits, and small, so that the time limit is checked often.
const BATCH_TOKENS: usize = 64;
/// Maximum length of a conversation, tokens, unless the model has a shorter one. Prompts hold
/// the names of a map; the cache takes memory for each token.
const CONTEXT_TOKENS: u32 = 4096;
/// Number of prompts in the cache, for later ones with the same beginning: a planner asks three
/// different questions in turn.
const CACHED_PROMPTS: usize = 3;
/// Maximum length of an answer, tokens, even if a request allows more: a small model that repeats
/// itself does not stop.
const MAX_ANSWER_TOKENS: usize = 512;

/// Time limit of a request.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    pub until: Instant,
    pub seconds: u64,
}

/// The name of the model in errors.
pub(super) fn endpoint(name: &str) -> String {
    format!("local:{name}")
}

/// A loaded model and its cache of prompts.
pub(super) struct Session<'a> {
    name: &'a str,
    model: &'a LlamaModel,
    template: LlamaChatTemplate,
    /// Texts that the model reads as control tokens.
    control_tokens: Vec<String>,
    context: LlamaContext<'a>,
    /// Maximum length of a conversation, tokens.
    max_tokens: usize,
    batch: LlamaBatch<'a>,
    /// The prompts in the cache, the most recently used first.
    cache: Vec<CachedPrompt>,
}

/// A prompt in the cache.
struct CachedPrompt {
    /// Its number in the context.
    sequence: i32,
    /// Its tokens, whole batches only.
    tokens: Vec<LlamaToken>,
}

impl CachedPrompt {
    /// Number of tokens of a prompt that need not be read again. The last one must be, since its
    /// logits are needed.
    fn known(&self, prompt: &[LlamaToken]) -> usize {
        let same = self
            .tokens
            .iter()
            .zip(prompt)
            .take_while(|(a, b)| a == b)
            .count();
        // Rounded down to whole batches, so that the rest is read in the same batches as in a new
        // prompt. `try_answer` refuses empty prompts, so the subtraction is safe.
        same.min(prompt.len() - 1) / BATCH_TOKENS * BATCH_TOKENS
    }
}

impl<'a> Session<'a> {
    pub(super) fn new(
        backend: &LlamaBackend,
        model: &'a LlamaModel,
        name: &'a str,
    ) -> Result<Self, LocalError> {
        let template = model
            .chat_template(None)
            .map_err(|_| LocalError::NoChatTemplate)?;
        let threads =
            std::thread::available_parallelism().map_or(1, |n| (n.get() / 2).clamp(1, 64)) as i32;
        // A model is trained for conversations of at most `n_ctx_train` tokens.
        let max_tokens = CONTEXT_TOKENS.min(model.n_ctx_train());
        let parameters = LlamaContextParams::default()
            // Without a unified cache each sequence has an equal part of the context.
            .with_n_ctx(NonZeroU32::new(max_tokens * CACHED_PROMPTS as u32))
            .with_n_seq_max(CACHED_PROMPTS as u32)
            .with_kv_unified(false)
            .with_n_batch(BATCH_TOKENS as u32)
            .with_n_ubatch(BATCH_TOKENS as u32)
            .with_n_threads(threads)
            .with_n_threads_batch(threads)
            // Off: its order of summation depends on the number of threads.
            .with_flash_attention_policy(0);
        let context = model
            .new_context(backend, parameters)
            .map_err(|_| LocalError::NoContext)?;
        Ok(Self {
            name,
            template,
            control_tokens: control_tokens(model),
            context,
            batch: LlamaBatch::new(BATCH_TOKENS, 1),
            max_tokens: max_tokens as usize,
            cache: (0..CACHED_PROMPTS as i32)
                .map(|sequence| CachedPrompt {
                    sequence,
                    tokens: Vec::new(),
                })
                .collect(),
            model,
        })
    }

    pub(super) fn answer(&mut self, request: &ChatRequest, limit: Limit) -> CountedReply {
        let mut used = ModelUse {
            calls: 1,
            ..ModelUse::default()
        };
        let reply = self.try_answer(request, limit, &mut used);
        used.failed = reply.is_err().into();
        CountedReply { reply, used }
    }

    fn try_answer(
        &mut self,
        request: &ChatRequest,
        limit: Limit,
        used: &mut ModelUse,
    ) -> Result<ChatReply, ChatError> {
        let prompt = self.prompt(request)?;
        if prompt.is_empty() {
            return Err(
                self.bad_request("the chat template of the model yields no text for it".into())
            );
        }
        let room = self.max_tokens.saturating_sub(prompt.len());
        // Less would cut off nearly any answer.
        if room < BATCH_TOKENS {
            let detail = format!(
                "it has {} tokens, but the model reads and writes at most {}",
                prompt.len(),
                self.max_tokens
            );
            return Err(self.bad_request(detail));
        }
        used.prompt_tokens = prompt.len() as u64;
        if let Err(error) = self.read_prompt(&prompt, limit) {
            // The cache may differ from what `cache` says after an error.
            self.clear_cache();
            return Err(error);
        }
        let most = MAX_ANSWER_TOKENS.min(request.max_tokens as usize).min(room);
        let mut written = Written::default();
        // Not yet `?`: tokens of a failed answer count as well.
        let answer = self.write(request, most, limit, prompt.len(), &mut written);
        used.completion_tokens = written.tokens.len() as u64;
        answer?;
        Ok(ChatReply {
            text: String::from_utf8_lossy(&written.bytes).into_owned(),
            prompt_tokens: prompt.len() as u32,
            completion_tokens: written.tokens.len() as u32,
        })
    }

    /// The tokens of the conversation in the chat template of the model.
    fn prompt(&self, request: &ChatRequest) -> Result<Vec<LlamaToken>, ChatError> {
        let turns: Vec<_> = request
            .messages
            .iter()
            .map(|message| self.turn(message))
            .collect::<Result<_, _>>()?;
        if turns.is_empty() {
            return Err(self.bad_request("it has no messages".into()));
        }
        let text = self.model.apply_chat_template(&self.template, &turns, true);
        let text = text.map_err(|error| {
            let cause = with_causes(&error);
            self.bad_request(format!("the chat template of the model fails: {cause}"))
        })?;
        let vocab = self.model.vocab();
        // The template contains the begin-of-text token if the model needs one.
        Ok(vocab.tokenize(text.as_bytes(), false, true))
    }

    fn turn(&self, message: &Message) -> Result<LlamaChatMessage, ChatError> {
        if !message.images.is_empty() {
            return Err(self.bad_request("local models cannot read images".into()));
        }
        let role = match message.role {
            Role::System => "system",
            Role::User => "user",
            Role::Assistant => "assistant",
        };
        // Zero bytes end a string of C, and what stands behind them would be lost.
        let text = break_up(message.text.replace('\0', " "), &self.control_tokens);
        LlamaChatMessage::new(role.into(), text)
            .map_err(|error| self.bad_request(with_causes(&error)))
    }

    /// Reads the tokens of a prompt that are not in the cache. Afterwards the context has the
    /// logits of the last one.
    fn read_prompt(&mut self, prompt: &[LlamaToken], limit: Limit) -> Result<(), ChatError> {
        let known = self
            .cache
            .iter()
            .map(|cached| cached.known(prompt))
            .max()
            .unwrap_or_default();
        // Among equal ones the least recently used one is replaced, which is the last of the list.
        let place = self
            .cache
            .iter()
            .rposition(|cached| cached.known(prompt) == known)
            .unwrap_or_default();
        let mut chosen = self.cache.remove(place);
        chosen.tokens.truncate(known);
        let sequence = chosen.sequence;
        self.cache.insert(0, chosen);
        let cleared =
            self.context
                .clear_kv_cache_seq(Some(sequence as u32), Some(known as u32), None);
        // Models without a cache of tokens can only be cleared completely.
        let known = if cleared.is_ok_and(|done| done) {
            known
        } else {
            self.clear_prompt(sequence)?
        };
        for (i, piece) in prompt[known..].chunks(BATCH_TOKENS).enumerate() {
            let begin = known + i * BATCH_TOKENS;
            let is_last = begin + piece.len() == prompt.len();
            self.decode(piece, begin, is_last)?;
            // The last batch may be shorter, and the answer follows it in the context. A later
            // prompt reads both anew.
            if piece.len() == BATCH_TOKENS {
                self.cache[0].tokens.extend_from_slice(piece);
            }
            self.check_time(limit)?;
        }
        Ok(())
    }

    fn decode(
        &mut self,
        tokens: &[LlamaToken],
        begin: usize,
        is_last: bool,
    ) -> Result<(), ChatError> {
        self.batch.clear();
        for (i, token) in tokens.iter().enumerate() {
            // Logits are computed for the last token only, which the answer follows.
            let wanted = is_last && i + 1 == tokens.len();
            let added = self.batch.add(
                *token,
                (begin + i) as i32,
                &[self.cache[0].sequence],
                wanted,
            );
            added.map_err(|error| self.bad_reply(with_causes(&error)))?;
        }
        self.context.decode(&mut self.batch).map_err(|error| {
            let detail = format!("llama.cpp cannot continue: {}", with_causes(&error));
            ChatError::BadReply {
                endpoint: endpoint(self.name),
                detail,
            }
        })
    }

    /// Writes an answer of at most `most` tokens after position `place`.
    fn write(
        &mut self,
        request: &ChatRequest,
        most: usize,
        limit: Limit,
        mut place: usize,
        written: &mut Written,
    ) -> Result<(), ChatError> {
        let mut grammar = self.grammar(&request.format)?;
        let mut random = (request.temperature > 0.0).then(|| random_sampler(request));
        let vocab = self.model.vocab();
        loop {
            let token = self.pick(grammar.as_mut(), random.as_mut());
            let token = token
                .ok_or_else(|| self.bad_reply("no token can follow the ones written".into()))?;
            if vocab.is_eog(token) {
                return Ok(());
            }
            // After the test for the end, which may come exactly at the maximum length.
            if written.tokens.len() == most {
                let detail = format!("it was truncated after {most} tokens, the maximum length");
                return Err(self.bad_reply(format!("{detail}{}", written.end())));
            }
            if written.repeats_itself() {
                return Err(self.bad_reply(format!("it repeats itself{}", written.end())));
            }
            if let Some(grammar) = &mut grammar {
                grammar.try_accept(token).map_err(|error| {
                    let cause = with_causes(&error);
                    self.bad_reply(format!("it violates its grammar: {cause}"))
                })?;
            }
            // Bytes, not text: a token may hold a part of a character.
            vocab.token_to_piece_into(token, &mut written.bytes, false, None);
            written.tokens.push(token);
            self.check_time(limit)?;
            self.decode(&[token], place, true)?;
            place += 1;
        }
    }

    fn grammar(&self, format: &Format) -> Result<Option<LlamaSampler>, ChatError> {
        let text = match format {
            Format::Text => return Ok(None),
            Format::Json => gbnf::grammar(None),
            Format::Schema(schema) => {
                let schema =
                    serde_json::from_str(&schema.text).map_err(|error| self.bad_schema(&error))?;
                gbnf::grammar(Some(&schema))
            }
        };
        LlamaSampler::grammar(self.model, &text, "root")
            .map(Some)
            .map_err(|error| self.bad_schema(&error))
    }

    /// The next token: the most probable one that the grammar allows, or a random one.
    fn pick(
        &self,
        grammar: Option<&mut LlamaSampler>,
        random: Option<&mut LlamaSampler>,
    ) -> Option<LlamaToken> {
        if random.is_none() {
            let best = most_probable(self.context.candidates_ith(-1))?;
            let Some(grammar) = grammar else {
                return Some(best.id());
            };
            // Checking one token with the grammar is much cheaper than checking all.
            let mut one = LlamaTokenDataArray::new(vec![best], false);
            one.apply_sampler(grammar);
            if one
                .data
                .first()
                .is_some_and(|data| data.logit().is_finite())
            {
                return Some(best.id());
            }
            // The most probable token violates the grammar, so all are checked.
            let mut all = self.context.token_data_array_ith(-1);
            all.apply_sampler(grammar);
            return most_probable(all.data.into_iter()).map(|data| data.id());
        }
        let mut all = self.context.token_data_array_ith(-1);
        // The grammar first: it makes forbidden tokens impossible before one is drawn.
        for sampler in grammar.into_iter().chain(random) {
            all.apply_sampler(sampler);
        }
        all.selected_token()
    }

    fn check_time(&self, limit: Limit) -> Result<(), ChatError> {
        let timeout = ChatError::Timeout {
            endpoint: endpoint(self.name),
            seconds: limit.seconds,
        };
        if Instant::now() < limit.until {
            Ok(())
        } else {
            Err(timeout)
        }
    }

    /// Clears the prompt that is used last.
    fn clear_prompt(&mut self, sequence: i32) -> Result<usize, ChatError> {
        self.cache[0].tokens.clear();
        match self
            .context
            .clear_kv_cache_seq(Some(sequence as u32), None, None)
        {
            Ok(true) => Ok(0),
            _ => Err(self.bad_reply("the cache of its prompt cannot be cleared".into())),
        }
    }

    fn clear_cache(&mut self) {
        self.context.clear_kv_cache();
        self.cache
            .iter_mut()
            .for_each(|cached| cached.tokens.clear());
    }

    fn bad_schema(&self, error: &dyn std::error::Error) -> ChatError {
        self.bad_request(format!("its schema cannot be used: {}", with_causes(error)))
    }

    fn bad_request(&self, detail: String) -> ChatError {
        ChatError::BadRequest {
            endpoint: endpoint(self.name),
            detail,
        }
    }

    fn bad_reply(&self, detail: String) -> ChatError {
        ChatError::BadReply {
            endpoint: endpoint(self.name),
            detail,
        }
    }
}

/// The most probable possible token, the first among equals.
fn most_probable(candidates: impl Iterator<Item = LlamaTokenData>) -> Option<LlamaTokenData> {
    candidates
        .filter(|data| data.logit().is_finite())
        .reduce(|best, next| {
            if next.logit() > best.logit() {
                next
            } else {
                best
            }
        })
}

/// A random sampler whose seed depends on the request only.
fn random_sampler(request: &ChatRequest) -> LlamaSampler {
    let digest = sha2::Sha256::digest(request.digest());
    let seed = u32::from_le_bytes([digest[0], digest[1], digest[2], digest[3]]);
    LlamaSampler::chain_simple([
        LlamaSampler::temp(request.temperature),
        LlamaSampler::dist(seed),
    ])
}
