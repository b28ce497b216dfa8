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

mod marks;
mod talk;
mod written;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError, mpsc};
use std::time::{Duration, Instant};

use llama_cpp_2::llama_backend::LlamaBackend;
use llama_cpp_2::model::LlamaModel;
use llama_cpp_2::model::params::LlamaModelParams;

use crate::chat::{ChatError, ChatModel, ChatReply, ChatRequest, CountedReply};
use crate::error::LocalError;
use crate::spec::local_name;
use crate::store::GGUF_MAGIC;
use talk::{Limit, Talk, endpoint};

/// A model that answers in this process. Clones share it.
#[derive(Debug, Clone)]
pub(crate) struct Local {
    name: String,
    timeout: Duration,
    questions: mpsc::Sender<Question>,
}

/// A request on its way to the model's thread.
struct Question {
    request: ChatRequest,
    limit: Limit,
    answer: mpsc::Sender<CountedReply>,
}

impl Local {
    /// The model in a file, loaded if it is not yet.
    ///
    /// # Errors
    /// [`LocalError`] if the file cannot be used.
    pub(crate) fn open(file: &Path, timeout: Duration) -> Result<Self, LocalError> {
        static OPEN: Mutex<BTreeMap<PathBuf, Local>> = Mutex::new(BTreeMap::new());
        let path = file.canonicalize()?;
        let name = local_name(file);
        // Held while a model is loaded: llama.cpp does not make two contexts at once.
        let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = open.get(&path) {
            return Ok(Self { name, timeout, ..known.clone() });
        }
        check_magic(&path)?;
        let local = Self { questions: start(&path, &name)?, name, timeout };
        open.insert(path, local.clone());
        Ok(local)
    }

    fn ask(&self, request: &ChatRequest, limit: Limit) -> Option<CountedReply> {
        let (answer, answered) = mpsc::channel();
        let question = Question { request: request.clone(), limit, answer };
        self.questions.send(question).ok()?;
        answered.recv().ok()
    }
}

impl ChatModel for Local {
    fn name(&self) -> &str {
        &self.name
    }

    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
        self.chat_counted(request).reply
    }

    fn chat_counted(&self, request: &ChatRequest) -> CountedReply {
        let begin = Instant::now();
        let limit = Limit { until: begin + self.timeout, seconds: self.timeout.as_secs() };
        let mut counted = self.ask(request, limit).unwrap_or_else(|| {
            let detail = "llama.cpp stopped at an earlier request".to_owned();
            let endpoint = endpoint(&self.name);
            CountedReply::of_one_call(Err(ChatError::Unreachable { endpoint, detail }))
        });
        counted.used.latency_ms = begin.elapsed().as_millis().try_into().unwrap_or(u64::MAX);
        counted
    }
}

fn check_magic(path: &Path) -> Result<(), LocalError> {
    let mut magic = [0_u8; GGUF_MAGIC.len()];
    File::open(path)?.read_exact(&mut magic)?;
    if &magic == GGUF_MAGIC { Ok(()) } else { Err(LocalError::NotGguf) }
}

/// Starts the thread of a model and waits until it is loaded.
fn start(file: &Path, name: &str) -> Result<mpsc::Sender<Question>, LocalError> {
    let (questions, asked) = mpsc::channel();
    let (ready, loaded) = mpsc::channel();
    let (file, name) = (file.to_owned(), name.to_owned());
    std::thread::Builder::new()
        .name("local model".into())
        .spawn(move || serve(&file, &name, &ready, &asked))?;
    loaded.recv().map_err(|_| LocalError::Interrupted)??;
    Ok(questions)
}

/// The model's thread: loads it, says whether that went well, and answers until nobody can ask any more.
fn serve(
    file: &Path,
    name: &str,
    ready: &mpsc::Sender<Result<(), LocalError>>,
    questions: &mpsc::Receiver<Question>,
) {
    if let Err(error) = load_and_answer(file, name, ready, questions) {
        // Whoever opens the model waits for this, and asks only after it.
        let _ = ready.send(Err(error));
    }
}

fn load_and_answer(
    file: &Path,
    name: &str,
    ready: &mpsc::Sender<Result<(), LocalError>>,
    questions: &mpsc::Receiver<Question>,
) -> Result<(), LocalError> {
    let backend = backend()?;
    let model = LlamaModel::load_from_file(backend, file, &LlamaModelParams::default())
        .map_err(|_| LocalError::Unloadable)?;
    let mut talk = Talk::new(backend, &model, name)?;
    // Whoever opens the model waits for this, and asks only after it.
    let _ = ready.send(Ok(()));
    for question in questions {
        let counted = talk.answer(&question.request, question.limit);
        // Nobody minds an answer that is not waited for any more.
        let _ = question.answer.send(counted);
    }
    Ok(())
}

/// llama.cpp, initialized once a process.
fn backend() -> Result<&'static LlamaBackend, LocalError> {
    // The error is kept for all who ask later, hence as text.
    static BACKEND: OnceLock<Result<LlamaBackend, String>> = OnceLock::new();
    let backend = BACKEND.get_or_init(|| {
        let mut backend = LlamaBackend::init().map_err(|error| error.to_string())?;
        backend.void_logs();
        Ok(backend)
    });
    backend.as_ref().map_err(|detail| LocalError::Backend { detail: detail.clone() })
}

#[cfg(test)]
mod tests;
