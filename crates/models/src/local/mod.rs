//! A chat model in this process: a GGUF file, run by llama.cpp on the CPU.
//!
//! One thread owns a model and answers requests in their order. A file is loaded once in a process.
//!
//! On one machine equal requests have equal answers, whatever was requested before: prompts are
//! read in batches of a fixed number of tokens, and only whole batches of earlier prompts are
//! reused. Between machines, sums may differ in their last bit and answers in a word. Record
//! answers that are to be repeated on another machine.
//!
//! llama.cpp uses half of the processors. Its threads synchronize hundreds of times for each token,
//! so one that shares its processor delays all of them. On two processors with other load, two
//! threads took 39 s for an answer of 100 tokens, one thread took three.
//!
//! A grammar restricts answers to JSON where that is requested ([`crate::gbnf`]). Control tokens in
//! the text of a message are broken up, so that an instruction cannot end its message and begin
//! another. Models whose control tokens are ordinary words, such as `[INST]`, have no such
//! protection.

mod control_tokens;
mod session;
mod written;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, mpsc};
use std::time::{Duration, Instant};

use llama_cpp_2::LlamaCppError;
use llama_cpp_2::llama_backend::LlamaBackend;
use llama_cpp_2::model::LlamaModel;
use llama_cpp_2::model::params::LlamaModelParams;

use crate::chat::{ChatError, ChatModel, ChatReply, ChatRequest, CountedReply};
use crate::error::LocalError;
use crate::spec::local_name;
use crate::store::GGUF_MAGIC;
use session::{Limit, Session, endpoint};

/// A model in this process. Clones share it.
#[derive(Debug, Clone)]
pub(crate) struct Local {
    name: String,
    timeout: Duration,
    requests: mpsc::Sender<QueuedRequest>,
}

/// A request for the thread of a model.
struct QueuedRequest {
    request: ChatRequest,
    limit: Limit,
    reply: mpsc::Sender<CountedReply>,
}

impl Local {
    /// The model of a file, which is loaded unless it already is.
    ///
    /// # Errors
    /// [`LocalError`] if the file cannot be used.
    pub(crate) fn open(file: &Path, timeout: Duration) -> Result<Self, LocalError> {
        static OPEN: Mutex<BTreeMap<PathBuf, Local>> = Mutex::new(BTreeMap::new());
        // Two names of one file must not load it twice.
        let path = file.canonicalize().map_err(LocalError::Read)?;
        let name = local_name(file);
        // Locked while a model is loaded: llama.cpp cannot create two contexts at the same time.
        let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = open.get(&path) {
            return Ok(Self {
                name,
                timeout,
                ..known.clone()
            });
        }
        check_magic(&path)?;
        let local = Self {
            // Before the name moves into the struct; fields are evaluated in this order.
            requests: start(&path, &name)?,
            name,
            timeout,
        };
        open.insert(path, local.clone());
        Ok(local)
    }

    fn send(&self, request: &ChatRequest, limit: Limit) -> Option<CountedReply> {
        let (reply, replied) = mpsc::channel();
        let queued = QueuedRequest {
            request: request.clone(),
            limit,
            reply,
        };
        // An error means that the thread has ended, and `recv` below fails if it ends during this
        // request.
        self.requests.send(queued).ok()?;
        replied.recv().ok()
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
        let limit = Limit {
            until: begin + self.timeout,
            seconds: self.timeout.as_secs(),
        };
        let mut counted = self.send(request, limit).unwrap_or_else(|| {
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
    File::open(path)
        .and_then(|mut file| file.read_exact(&mut magic))
        .map_err(LocalError::Read)?;
    if &magic == GGUF_MAGIC {
        Ok(())
    } else {
        Err(LocalError::NotGguf)
    }
}

/// Starts the thread of a model and waits until the model is loaded.
fn start(file: &Path, name: &str) -> Result<mpsc::Sender<QueuedRequest>, LocalError> {
    let (requests, queue) = mpsc::channel();
    let (ready, loaded) = mpsc::channel();
    let (file, name) = (file.to_owned(), name.to_owned());
    std::thread::Builder::new()
        .name("local model".into())
        .spawn(move || serve(&file, &name, &ready, &queue))
        .map_err(LocalError::Thread)?;
    // The outer error: the thread ended without a report. The inner one is its report.
    loaded.recv().map_err(|_| LocalError::Interrupted)??;
    Ok(requests)
}

/// The thread of a model: loads it, reports whether that succeeded, and answers requests until all
/// senders are dropped.
fn serve(
    file: &Path,
    name: &str,
    ready: &mpsc::Sender<Result<(), LocalError>>,
    queue: &mpsc::Receiver<QueuedRequest>,
) {
    if let Err(error) = load_and_answer(file, name, ready, queue) {
        // `start` waits for this.
        let _ = ready.send(Err(error));
    }
}

fn load_and_answer(
    file: &Path,
    name: &str,
    ready: &mpsc::Sender<Result<(), LocalError>>,
    queue: &mpsc::Receiver<QueuedRequest>,
) -> Result<(), LocalError> {
    let backend = backend()?;
    let model = LlamaModel::load_from_file(backend, file, &LlamaModelParams::default())
        .map_err(|_| LocalError::Unloadable)?;
    let mut session = Session::new(backend, &model, name)?;
    // `start` waits for this.
    let _ = ready.send(Ok(()));
    for queued in queue {
        let counted = session.answer(&queued.request, queued.limit);
        // An error means that the caller no longer waits.
        let _ = queued.reply.send(counted);
    }
    Ok(())
}

/// llama.cpp, which is initialized once in a process.
fn backend() -> Result<&'static LlamaBackend, LocalError> {
    // The error is kept for later calls; it is shared because it cannot be cloned.
    static BACKEND: OnceLock<Result<LlamaBackend, Arc<LlamaCppError>>> = OnceLock::new();
    let backend = BACKEND.get_or_init(|| {
        let mut backend = LlamaBackend::init()?;
        backend.void_logs();
        Ok(backend)
    });
    backend.as_ref().map_err(|source| LocalError::Backend {
        source: source.clone(),
    })
}

#[cfg(test)]
mod tests;
