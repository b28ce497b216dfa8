//! A conversation with a model that is loaded: reading a prompt, writing an answer token by token.

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
use openbench_core::ModelUse;
use sha2::Digest;

use super::marks::{marks_of, without_marks};
use super::written::Written;
use crate::chat::{ChatError, ChatReply, ChatRequest, CountedReply, Format, Message, Role};
use crate::error::LocalError;
use crate::gbnf;

/// Tokens that are read at once.
const PIECE: usize = 64;
/// The longest conversation, tokens; shorter where the model knows no longer ones.
const CONTEXT: u32 = 4096;
/// How many conversations are kept, for others that begin alike.
const KEPT: usize = 3;
/// The longest answer, tokens, whatever is allowed: a small model that repeats itself does so until it is stopped.
const LONGEST_ANSWER: usize = 512;

/// How long an answer is waited for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    pub until: Instant,
    pub seconds: u64,
}

/// How errors call the model.
pub(super) fn endpoint(name: &str) -> String {
    format!("local:{name}")
}

/// A model and what it has read.
pub(super) struct Talk<'a> {
    name: &'a str,
    model: &'a LlamaModel,
    template: LlamaChatTemplate,
    /// What the model takes for marks of a conversation.
    marks: Vec<String>,
    context: LlamaContext<'a>,
    /// The longest conversation, tokens.
    length: usize,
    batch: LlamaBatch<'a>,
    /// The tokens of each conversation that is kept, whole pieces only, the one that was used last in front.
    kept: Vec<Kept>,
}

/// A conversation that is kept.
struct Kept {
    /// Its number in the context.
    sequence: i32,
    read: Vec<LlamaToken>,
}

impl Kept {
    /// How many tokens of a prompt need not be read again; the last one must be, since what follows it is asked for.
    fn known(&self, prompt: &[LlamaToken]) -> usize {
        let same = self.read.iter().zip(prompt).take_while(|(a, b)| a == b).count();
        same.min(prompt.len() - 1) / PIECE * PIECE
    }
}

impl<'a> Talk<'a> {
    pub(super) fn new(
        backend: &LlamaBackend,
        model: &'a LlamaModel,
        name: &'a str,
    ) -> Result<Self, LocalError> {
        let template = model.chat_template(None).map_err(|_| LocalError::NoChatTemplate)?;
        let threads = std::thread::available_parallelism().map_or(1, |n| (n.get() / 2).clamp(1, 64)) as i32;
        let length = CONTEXT.min(model.n_ctx_train());
        let parameters = LlamaContextParams::default()
            .with_n_ctx(NonZeroU32::new(length * KEPT as u32))
            .with_n_seq_max(KEPT as u32)
            .with_kv_unified(false)
            .with_n_batch(PIECE as u32)
            .with_n_ubatch(PIECE as u32)
            .with_n_threads(threads)
            .with_n_threads_batch(threads)
            // Never: it adds up in an order that depends on the number of threads.
            .with_flash_attention_policy(0);
        let context = model.new_context(backend, parameters).map_err(|_| LocalError::NoContext)?;
        Ok(Self {
            name,
            template,
            marks: marks_of(model),
            context,
            batch: LlamaBatch::new(PIECE, 1),
            length: length as usize,
            kept: (0..KEPT as i32).map(|sequence| Kept { sequence, read: Vec::new() }).collect(),
            model,
        })
    }

    pub(super) fn answer(&mut self, request: &ChatRequest, limit: Limit) -> CountedReply {
        let mut used = ModelUse { calls: 1, ..ModelUse::default() };
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
            return Err(self.bad_request("the model's chat template makes nothing of it".into()));
        }
        let room = self.length.saturating_sub(prompt.len());
        if room < PIECE {
            let detail = format!(
                "it is {} tokens long, and {} are the most that the model reads and writes",
                prompt.len(),
                self.length
            );
            return Err(self.bad_request(detail));
        }
        used.prompt_tokens = prompt.len() as u64;
        if let Err(error) = self.read_prompt(&prompt, limit) {
            self.forget();
            return Err(error);
        }
        let most = LONGEST_ANSWER.min(request.max_tokens as usize).min(room);
        let mut written = Written::default();
        let answer = self.write(request, most, limit, prompt.len(), &mut written);
        used.completion_tokens = written.tokens.len() as u64;
        answer?;
        Ok(ChatReply {
            text: String::from_utf8_lossy(&written.bytes).into_owned(),
            prompt_tokens: prompt.len() as u32,
            completion_tokens: written.tokens.len() as u32,
        })
    }

    /// The conversation in the model's own form, as tokens.
    fn prompt(&self, request: &ChatRequest) -> Result<Vec<LlamaToken>, ChatError> {
        let turns: Vec<_> =
            request.messages.iter().map(|message| self.turn(message)).collect::<Result<_, _>>()?;
        if turns.is_empty() {
            return Err(self.bad_request("it has no messages".into()));
        }
        let text = self.model.apply_chat_template(&self.template, &turns, true);
        let text = text.map_err(|e| self.bad_request(format!("the model's chat template fails: {e}")))?;
        let vocab = self.model.vocab();
        // The template writes the first mark itself, if it wants one.
        Ok(vocab.tokenize(text.as_bytes(), false, true))
    }

    fn turn(&self, message: &Message) -> Result<LlamaChatMessage, ChatError> {
        if !message.images.is_empty() {
            return Err(self.bad_request("local models read no pictures".into()));
        }
        let role = match message.role {
            Role::System => "system",
            Role::User => "user",
            Role::Assistant => "assistant",
        };
        let text = without_marks(message.text.replace('\0', " "), &self.marks);
        LlamaChatMessage::new(role.into(), text).map_err(|e| self.bad_request(e.to_string()))
    }

    /// Reads what was not read before; the last token's logits are there afterwards.
    fn read_prompt(&mut self, prompt: &[LlamaToken], limit: Limit) -> Result<(), ChatError> {
        let known = self.kept.iter().map(|kept| kept.known(prompt)).max().unwrap_or_default();
        // Of those that know nothing of it the one that was not used for longest goes.
        let place = self.kept.iter().rposition(|kept| kept.known(prompt) == known).unwrap_or_default();
        let mut chosen = self.kept.remove(place);
        chosen.read.truncate(known);
        let sequence = chosen.sequence;
        self.kept.insert(0, chosen);
        let cleared = self.context.clear_kv_cache_seq(Some(sequence as u32), Some(known as u32), None);
        // Models without a cache of tokens forget all or nothing.
        let known = if cleared.is_ok_and(|done| done) { known } else { self.forget_all_of(sequence)? };
        for (i, piece) in prompt[known..].chunks(PIECE).enumerate() {
            let begin = known + i * PIECE;
            let is_last = begin + piece.len() == prompt.len();
            self.decode(piece, begin, is_last)?;
            if piece.len() == PIECE {
                self.kept[0].read.extend_from_slice(piece);
            }
            self.check_time(limit)?;
        }
        Ok(())
    }

    fn decode(&mut self, tokens: &[LlamaToken], begin: usize, is_last: bool) -> Result<(), ChatError> {
        self.batch.clear();
        for (i, token) in tokens.iter().enumerate() {
            let wanted = is_last && i + 1 == tokens.len();
            let added = self.batch.add(*token, (begin + i) as i32, &[self.kept[0].sequence], wanted);
            added.map_err(|e| self.bad_reply(e.to_string()))?;
        }
        self.context.decode(&mut self.batch).map_err(|e| {
            let detail = format!("llama.cpp cannot go on: {e}");
            ChatError::BadReply { endpoint: endpoint(self.name), detail }
        })
    }

    /// Writes an answer of so many tokens at most.
    fn write(
        &mut self,
        request: &ChatRequest,
        most: usize,
        limit: Limit,
        mut place: usize,
        written: &mut Written,
    ) -> Result<(), ChatError> {
        let mut grammar = self.grammar(&request.format)?;
        let mut chance = (request.temperature > 0.0).then(|| chance(request));
        let vocab = self.model.vocab();
        loop {
            let token = self.pick(grammar.as_mut(), chance.as_mut());
            let token =
                token.ok_or_else(|| self.bad_reply("nothing can follow what it has written".into()))?;
            if vocab.is_eog(token) {
                return Ok(());
            }
            if written.tokens.len() == most {
                let detail = format!("it was cut off after {most} tokens, the longest answer allowed");
                return Err(self.bad_reply(format!("{detail}{}", written.end())));
            }
            if written.repeats_itself() {
                return Err(self.bad_reply(format!("it repeats itself{}", written.end())));
            }
            if let Some(grammar) = &mut grammar {
                let taken = grammar.try_accept(token);
                taken.map_err(|e| self.bad_reply(format!("it left its grammar: {e}")))?;
            }
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
                let schema = serde_json::from_str(&schema.text);
                gbnf::grammar(Some(&schema.map_err(|e| self.bad_request(format!("its schema: {e}")))?))
            }
        };
        let sampler = LlamaSampler::grammar(self.model, &text, "root");
        sampler.map(Some).map_err(|e| self.bad_request(format!("its schema: {e}")))
    }

    /// The next token: the likeliest that the grammar allows, or one by chance.
    fn pick(
        &self,
        grammar: Option<&mut LlamaSampler>,
        chance: Option<&mut LlamaSampler>,
    ) -> Option<LlamaToken> {
        if chance.is_none() {
            let best = likeliest(self.context.candidates_ith(-1))?;
            let Some(grammar) = grammar else { return Some(best.id()) };
            // To ask the grammar about one token is much cheaper than about all of them.
            let mut one = LlamaTokenDataArray::new(vec![best], false);
            one.apply_sampler(grammar);
            if one.data.first().is_some_and(|data| data.logit().is_finite()) {
                return Some(best.id());
            }
            let mut all = self.context.token_data_array_ith(-1);
            all.apply_sampler(grammar);
            return likeliest(all.data.into_iter()).map(|data| data.id());
        }
        let mut all = self.context.token_data_array_ith(-1);
        for sampler in grammar.into_iter().chain(chance) {
            all.apply_sampler(sampler);
        }
        all.selected_token()
    }

    fn check_time(&self, limit: Limit) -> Result<(), ChatError> {
        let timeout = ChatError::Timeout { endpoint: endpoint(self.name), seconds: limit.seconds };
        if Instant::now() < limit.until { Ok(()) } else { Err(timeout) }
    }

    /// Has the newest conversation begin anew: nothing of it is known.
    fn forget_all_of(&mut self, sequence: i32) -> Result<usize, ChatError> {
        self.kept[0].read.clear();
        match self.context.clear_kv_cache_seq(Some(sequence as u32), None, None) {
            Ok(true) => Ok(0),
            _ => Err(self.bad_reply("what was read before cannot be forgotten".into())),
        }
    }

    fn forget(&mut self) {
        self.context.clear_kv_cache();
        self.kept.iter_mut().for_each(|kept| kept.read.clear());
    }

    fn bad_request(&self, detail: String) -> ChatError {
        ChatError::BadRequest { endpoint: endpoint(self.name), detail }
    }

    fn bad_reply(&self, detail: String) -> ChatError {
        ChatError::BadReply { endpoint: endpoint(self.name), detail }
    }
}

/// The likeliest token that is possible at all; of equals the first.
fn likeliest(candidates: impl Iterator<Item = LlamaTokenData>) -> Option<LlamaTokenData> {
    candidates
        .filter(|data| data.logit().is_finite())
        .reduce(|best, next| if next.logit() > best.logit() { next } else { best })
}

/// Chooses by chance, the same for the same request.
fn chance(request: &ChatRequest) -> LlamaSampler {
    let digest = sha2::Sha256::digest(request.digest());
    let seed = u32::from_le_bytes([digest[0], digest[1], digest[2], digest[3]]);
    LlamaSampler::chain_simple([LlamaSampler::temp(request.temperature), LlamaSampler::dist(seed)])
}
