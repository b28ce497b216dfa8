//! A chat model in this process: a GGUF file, run by llama.cpp on the CPU.
//!
//! One thread owns a model, and all who ask it wait in line; a file is loaded once a process. On one machine the same request gets the same answer, whatever was asked
//! before: prompts are read in pieces of [`PIECE`] tokens, and of earlier prompts only whole pieces are kept. Between machines answers may
//! differ in the last bit of a sum and so in a word: what is to be repeated elsewhere is recorded.
//!
//! Half of the processors work on it. Its threads wait for each other hundreds of times a token, so that one that has to share its processor with something else holds up
//! all: on two shared processors two threads took 39 s for an answer of a hundred tokens beside other work, and three alone.
//!
//! JSON is written under a grammar ([`crate::gbnf`]). What the model would read as a mark of the conversation is broken up where it stands in a text, so that an instruction cannot end its message
//! and begin another; models whose marks are ordinary words (`[INST]`) have no such guard.

use std::collections::BTreeMap;
use std::io::Read;
use std::num::NonZeroU32;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError, mpsc};
use std::time::{Duration, Instant};

use llama_cpp_2::context::LlamaContext;
use llama_cpp_2::context::params::LlamaContextParams;
use llama_cpp_2::llama_backend::LlamaBackend;
use llama_cpp_2::llama_batch::LlamaBatch;
use llama_cpp_2::model::params::LlamaModelParams;
use llama_cpp_2::model::{LlamaChatMessage, LlamaChatTemplate, LlamaModel};
use llama_cpp_2::sampling::LlamaSampler;
use llama_cpp_2::token::LlamaToken;
use llama_cpp_2::token::data::LlamaTokenData;
use llama_cpp_2::token::data_array::LlamaTokenDataArray;
use llama_cpp_2::token_type::LlamaTokenAttr;
use openbench_core::ModelUse;
use sha2::Digest;

use crate::chat::{ChatError, ChatModel, ChatReply, ChatRequest, Format, Role};
use crate::gbnf;
use crate::spec::local_name;
use crate::transport::quote;

/// Tokens that are read at once.
const PIECE: usize = 64;
/// The longest conversation, tokens; shorter where the model knows no longer ones.
const CONTEXT: u32 = 4096;
/// How many conversations are kept, for others that begin alike.
const KEPT: usize = 3;
/// The longest answer, tokens, whatever is allowed: a small model that repeats itself does so until it is stopped.
const LONGEST_ANSWER: usize = 512;

/// How many tokens may stand how often one after the other before that is a loop.
const LOOPS: RangeInclusive<usize> = 8..=200;
const REPEATED: usize = 4;
/// Characters of an answer that an error quotes.
const QUOTED: usize = 120;

type Counted = (Result<ChatReply, ChatError>, ModelUse);

/// A model that answers in this process. Clones share it.
#[derive(Debug, Clone)]
pub(crate) struct Local {
    name: String,
    timeout: Duration,
    questions: mpsc::Sender<Question>,
}

/// How long an answer is waited for.
#[derive(Debug, Clone, Copy)]
struct Limit {
    until: Instant,
    seconds: u64,
}

/// A request on its way to the model's thread.
struct Question {
    request: ChatRequest,
    limit: Limit,
    answer: mpsc::Sender<Counted>,
}

impl Local {
    /// The model in a file, loaded if it is not yet.
    ///
    /// # Errors
    /// In words why the file cannot be used.
    pub(crate) fn open(file: &Path, timeout: Duration) -> Result<Self, String> {
        static OPEN: Mutex<BTreeMap<PathBuf, Local>> = Mutex::new(BTreeMap::new());
        let path = file.canonicalize().map_err(|e| e.to_string())?;
        // Held while a model is loaded: llama.cpp does not make two contexts at once.
        let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = open.get(&path) {
            return Ok(Self { name: local_name(file), timeout, ..known.clone() });
        }
        check_magic(&path)?;
        let name = local_name(file);
        let (questions, asked) = mpsc::channel();
        let (ready, loaded) = mpsc::channel();
        let (file, called) = (path.clone(), name.clone());
        std::thread::Builder::new()
            .name("local model".into())
            .spawn(move || serve(&file, &called, &ready, &asked))
            .map_err(|e| e.to_string())?;
        loaded.recv().map_err(|_| "llama.cpp gave up while it loaded the file".to_owned())??;
        let local = Self { name, timeout, questions };
        open.insert(path, local.clone());
        Ok(local)
    }
}

impl ChatModel for Local {
    fn name(&self) -> &str {
        &self.name
    }

    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
        self.chat_counted(request).0
    }

    fn chat_counted(&self, request: &ChatRequest) -> Counted {
        let begin = Instant::now();
        let (answer, told) = mpsc::channel();
        let limit = Limit { until: begin + self.timeout, seconds: self.timeout.as_secs() };
        let question = Question { request: request.clone(), limit, answer };
        let sent = self.questions.send(question).is_ok();
        let gone = || {
            let detail = "llama.cpp stopped at an earlier request".to_owned();
            let used = ModelUse { calls: 1, failed: 1, ..ModelUse::default() };
            (Err(ChatError::Unreachable { endpoint: endpoint(&self.name), detail }), used)
        };
        let (answer, used) = sent.then(|| told.recv().ok()).flatten().unwrap_or_else(gone);
        let latency_ms = begin.elapsed().as_millis().try_into().unwrap_or(u64::MAX);
        (answer, ModelUse { latency_ms, ..used })
    }
}

/// How errors call the model.
fn endpoint(name: &str) -> String {
    format!("local:{name}")
}

fn check_magic(path: &Path) -> Result<(), String> {
    let mut magic = [0_u8; 4];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut magic));
    match read {
        Ok(()) if &magic == b"GGUF" => Ok(()),
        Ok(()) => Err("it is no GGUF file".into()),
        Err(error) => Err(error.to_string()),
    }
}

fn backend() -> Result<&'static LlamaBackend, String> {
    static BACKEND: OnceLock<Result<LlamaBackend, String>> = OnceLock::new();
    let init = || {
        let mut backend = LlamaBackend::init().map_err(|e| e.to_string())?;
        backend.void_logs();
        Ok(backend)
    };
    BACKEND.get_or_init(init).as_ref().map_err(Clone::clone)
}

/// The model's thread: loads it, says whether that went well, and answers until nobody can ask any more.
fn serve(
    file: &Path,
    name: &str,
    ready: &mpsc::Sender<Result<(), String>>,
    questions: &mpsc::Receiver<Question>,
) {
    let loaded = backend().and_then(|backend| {
        let model = LlamaModel::load_from_file(backend, file, &LlamaModelParams::default());
        Ok((backend, model.map_err(|_| "llama.cpp cannot load it: damaged, or of a kind it does not know")?))
    });
    let opened = loaded.as_ref().map_err(Clone::clone).and_then(|(b, model)| Talk::new(b, model, name));
    // Whoever opens the model waits for this, and asks only after it.
    let mut talk = match opened {
        Ok(talk) => {
            let _ = ready.send(Ok(()));
            talk
        }
        Err(error) => {
            let _ = ready.send(Err(error));
            return;
        }
    };
    for question in questions {
        let counted = talk.answer(&question.request, question.limit);
        // Nobody minds an answer that is not waited for any more.
        let _ = question.answer.send(counted);
    }
}

/// A model and what it has read.
struct Talk<'a> {
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
    fn new(backend: &LlamaBackend, model: &'a LlamaModel, name: &'a str) -> Result<Self, String> {
        let template =
            model.chat_template(None).map_err(|_| "it has no chat template: it is no model to talk with")?;
        let vocab = model.vocab();
        let is_mark = |token: &LlamaToken| {
            vocab.is_control(*token)
                || vocab.is_eog(*token)
                || vocab.attr(*token).contains(LlamaTokenAttr::UserDefined)
        };
        let marks = vocab
            .tokens()
            .filter(is_mark)
            .filter_map(|token| Some(vocab.text(token)?.to_str().ok()?.to_owned()));
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
        let context = model
            .new_context(backend, parameters)
            .map_err(|_| "llama.cpp can make no context for it: too little memory?")?;
        Ok(Self {
            name,
            template,
            // Some models keep runs of blanks among them.
            marks: marks.filter(|mark| mark.len() > 1 && mark.contains(['<', '|', '['])).collect(),
            context,
            batch: LlamaBatch::new(PIECE, 1),
            length: length as usize,
            kept: (0..KEPT as i32).map(|sequence| Kept { sequence, read: Vec::new() }).collect(),
            model,
        })
    }

    fn answer(&mut self, request: &ChatRequest, limit: Limit) -> Counted {
        let mut used = ModelUse { calls: 1, ..ModelUse::default() };
        let answer = self.try_answer(request, limit, &mut used);
        used.failed = answer.is_err().into();
        (answer, used)
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
        let turn = |message: &crate::chat::Message| {
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
        };
        let turns: Vec<_> = request.messages.iter().map(turn).collect::<Result<_, _>>()?;
        if turns.is_empty() {
            return Err(self.bad_request("it has no messages".into()));
        }
        let text = self.model.apply_chat_template(&self.template, &turns, true);
        let text = text.map_err(|e| self.bad_request(format!("the model's chat template fails: {e}")))?;
        let vocab = self.model.vocab();
        // The template writes the first mark itself, if it wants one.
        Ok(vocab.tokenize(text.as_bytes(), false, true))
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

/// An answer so far.
#[derive(Default)]
struct Written {
    bytes: Vec<u8>,
    tokens: Vec<LlamaToken>,
}

impl Written {
    /// Whether the end is the same several times over. Small models that fall into that do not get out of it.
    fn repeats_itself(&self) -> bool {
        let is_repeated = |length: usize| {
            let Some(begin) = self.tokens.len().checked_sub(REPEATED * length) else { return false };
            let end = &self.tokens[begin..];
            end[length..] == end[..end.len() - length]
        };
        LOOPS.into_iter().any(is_repeated)
    }

    /// How it ends, in quotes.
    fn end(&self) -> String {
        let text = String::from_utf8_lossy(&self.bytes);
        let skip = text.chars().count().saturating_sub(QUOTED);
        format!(": …{}", quote(&text.chars().skip(skip).collect::<String>()))
    }
}

/// The likeliest token that is possible at all; of equals the first.
fn likeliest(candidates: impl Iterator<Item = LlamaTokenData>) -> Option<LlamaTokenData> {
    let better = |best: LlamaTokenData, next: LlamaTokenData| {
        if next.logit() > best.logit() { next } else { best }
    };
    candidates.filter(|data| data.logit().is_finite()).reduce(better)
}

/// Chooses by chance, the same for the same request.
fn chance(request: &ChatRequest) -> LlamaSampler {
    let digest = sha2::Sha256::digest(request.digest());
    let seed = u32::from_le_bytes([digest[0], digest[1], digest[2], digest[3]]);
    LlamaSampler::chain_simple([LlamaSampler::temp(request.temperature), LlamaSampler::dist(seed)])
}

/// A text in which no mark is whole any more.
fn without_marks(mut text: String, marks: &[String]) -> String {
    for mark in marks {
        while text.contains(mark.as_str()) {
            let first = mark.chars().next().map_or(0, char::len_utf8);
            text = text.replace(mark.as_str(), &format!("{} {}", &mark[..first], &mark[first..]));
        }
    }
    text
}

#[cfg(test)]
#[path = "local_tests.rs"]
mod tests;
