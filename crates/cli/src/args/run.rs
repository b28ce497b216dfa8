//! Arguments of `run`.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::{Args as ClapArgs, ValueEnum};

use super::values::*;

/// Heading of the arguments that take the place of a suite.
const GAZEBO: &str = "A Gazebo world instead of a suite";

/// Who says which doors instructions mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Targets {
    /// OPEN's grammar reads them: where it errs, results are wrong
    Planner,
}

/// Arguments of `run`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench run medium --jobs 2 --out runs/medium
  openbench run --resume runs/medium
  openbench run small --seeds 0..9 --jobs 2 --out runs/ten
  openbench run small --set localizer=dead-reckoning
  openbench run medium --seed 7
  openbench run medium --condition map=city --condition start=5m --noise-seed 7
  openbench run small --agent openpi:ws://127.0.0.1:8000 --set timeout=10
  openbench run --world small_osm.world --map small.osm --models gazebo_models \\
      --deliveries delivery_instructions_small.txt --truth delivery_instructions_small_gt.txt")]
pub struct RunArgs {
    /// A built-in suite (small, medium, large), that of a drawn neighbourhood (medium-7) or of a
    /// real place (krems), a track (paper, street, hard), a suite file (.toml), or a world folder
    /// [default: small]
    #[arg(conflicts_with = "world")]
    pub suite: Option<String>,
    /// The agent to run
    #[arg(long, default_value = "open")]
    pub agent: String,
    /// Seed of all random draws. With small, medium and large a seed other than 0 also draws
    /// another neighbourhood of that kind
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Seed of noise, traffic and conditions alone [default: that of --seed]
    #[arg(long, value_name = "SEED", conflicts_with_all = ["seeds", "resume"])]
    pub noise_seed: Option<u64>,
    /// Run with each of these seeds, the last one included, and report means over them; each gets
    /// a folder in the folder of the run. Seeds that are done already are not run again
    #[arg(
        long,
        value_name = "FIRST..LAST",
        value_parser = seeds,
        conflicts_with_all = ["seed", "memory", "draw"]
    )]
    pub seeds: Option<RangeInclusive<u64>>,
    /// Folder for results, report and logs; those of an earlier run there are replaced, those of
    /// other seeds only with --discard
    #[arg(long, default_value = "runs/latest")]
    pub out: PathBuf,
    /// Continue the interrupted run in this folder: only what is missing is run
    #[arg(
        long,
        value_name = "DIR",
        conflicts_with_all = [
            "suite", "agent", "seed", "seeds", "out", "settings", "conditions", "realtime",
            "record", "pedestrians", "cars", "memory", "world", "discard"
        ]
    )]
    pub resume: Option<PathBuf>,
    /// Remove what an interrupted run has left in the folder; with --seeds, also replace seeds that
    /// were run with other settings, which is refused without it
    #[arg(long)]
    pub discard: bool,
    /// Episodes that run in parallel; results do not depend on it
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// A setting of the agent, see below; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub settings: Vec<(String, String)>,
    /// Makes the run harder: a level, such as map=city or start=10m, which sets all numbers of its
    /// condition, or one number that changes the level, such as map.shift_m=3; may be repeated, in
    /// any order. The suite's own stays where nothing is said
    #[arg(long = "condition", value_name = "KEY=VALUE", value_parser = key_value)]
    pub conditions: Vec<(String, String)>,
    /// Computing takes simulated time, by the clock: an answer of a model, of a policy server or of
    /// an agent in Python or in another program takes effect only as late as it came; short for
    /// --set thinking=charged
    #[arg(long)]
    pub realtime: bool,
    /// What the logs hold: none, thin or full
    #[arg(long, default_value = "thin")]
    pub record: openbench_bench::Level,
    /// Number of pedestrians [default: as in the suite]
    #[arg(long)]
    pub pedestrians: Option<u16>,
    /// Number of moving cars [default: as in the suite]
    #[arg(long)]
    pub cars: Option<u16>,
    /// OSM file in which found doors are kept from run to run
    #[arg(long, value_name = "FILE.osm")]
    pub memory: Option<PathBuf>,
    /// Print results as JSON
    #[arg(long)]
    pub json: bool,
    /// A Gazebo world (SDF)
    #[arg(long, requires_all = ["map"], help_heading = GAZEBO)]
    pub world: Option<PathBuf>,
    /// The OSM map of that world
    #[arg(long, requires = "world", help_heading = GAZEBO)]
    pub map: Option<PathBuf>,
    /// Folder with the models that `model://` names; may be repeated
    #[arg(long, requires = "world", help_heading = GAZEBO)]
    pub models: Vec<PathBuf>,
    /// File of instructions, one per line, or a JSONL file with annotations (keys `instruction`,
    /// `deliveries`, `before`)
    #[arg(long, requires = "world", help_heading = GAZEBO)]
    pub deliveries: Option<PathBuf>,
    /// File of true door positions, `(x, y)`; several per line for a sequence
    #[arg(long, requires = "deliveries", help_heading = GAZEBO)]
    pub truth: Option<PathBuf>,
    /// Who says which doors the instructions mean, if neither --truth nor annotations do
    #[arg(
        long,
        value_name = "SOURCE",
        requires = "deliveries",
        conflicts_with = "truth",
        help_heading = GAZEBO
    )]
    pub targets: Option<Targets>,
    /// Draw single deliveries and sequences instead of reading a file of deliveries
    #[arg(
        long,
        value_names = ["SINGLES", "SEQUENCES", "LENGTH"],
        num_args = 3,
        requires = "world",
        conflicts_with = "deliveries",
        help_heading = GAZEBO
    )]
    pub draw: Option<Vec<usize>>,
    /// Georeference of the world: UTM zone, and the metres that are added to easting and northing,
    /// such as utm:50N,-500000,-4483000 [default: that of the map]
    #[arg(long, requires = "world", help_heading = GAZEBO)]
    pub georef: Option<String>,
}
