use std::path::PathBuf;

use clap::{Args, Subcommand};

/// `openbench data`
#[derive(Debug, Args)]
pub struct DataArgs {
    /// What to do
    #[command(subcommand)]
    pub command: DataCommand,
}

/// What can be done with published data.
#[derive(Debug, Subcommand)]
pub enum DataCommand {
    /// List the data sets, their sources and licences
    List,
    /// Download data sets and check them against pinned SHA-256 sums
    Pull(DataPullArgs),
}

const EXAMPLES: &str = "\
Examples:
  openbench data pull published        the paper's worlds small and medium, into data/published
  openbench data pull sample-map       a town's OpenStreetMap extract, into data/sample-map

OPENBENCH_DATA_MIRROR names a host to be asked in place of GitHub, with the same paths.";

/// `openbench data pull`
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct DataPullArgs {
    /// Names of data sets, as `openbench data list` has them
    #[arg(required = true, value_name = "NAME")]
    pub names: Vec<String>,
    /// Folder for the data sets, each in a folder of its name
    #[arg(long, default_value = "data")]
    pub out: PathBuf,
}
