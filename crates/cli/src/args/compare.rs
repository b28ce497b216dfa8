//! Arguments of `compare`.

use std::path::PathBuf;

use clap::Args as ClapArgs;

use super::values::*;

/// Arguments of `compare`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Runs are paired by world, seed and episode. Intervals are bootstrapped by world, or by episode
where there are fewer than five worlds. Success is tested by McNemar's exact test, adjusted by Holm
for several systems. Runs of different suites, worlds, maps or seeds are refused.

Examples:
  openbench compare runs/open runs/mine
  openbench compare runs/ten runs/ten-truth runs/ten-mine --json
  openbench compare runs/open --points 5      how many episodes tell 5 points apart")]
pub struct CompareArgs {
    /// Folders of runs, or folders with such folders, as `run --seeds` and `bench towns` make them;
    /// each is a system, and the first one is what the others are compared with
    #[arg(required = true, value_name = "RUN")]
    pub runs: Vec<PathBuf>,
    /// Difference of success, in points, for which the number of episodes is computed that it takes
    /// to find it
    #[arg(long, default_value_t = 2.0, value_parser = points)]
    pub points: f64,
    /// Print the comparison as JSON
    #[arg(long)]
    pub json: bool,
}
