//! Arguments of `run`.

use std::path::PathBuf;

use clap::Args as ClapArgs;

use super::values::*;

/// Arguments of `run`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Settings of the agent `open`:
  planner=grammar | MODEL      reader=ppocr-v4 | MODEL, or several in turn: what one cannot read the next is asked (MODEL,ppocr-v4)
        MODEL is openai:NAME[@URL] (and whoever speaks as OpenAI does), anthropic:NAME, gemini:NAME, ollama:NAME, local:NAME, replay:FILE
  budget=CALLS,TOKENS,SECONDS: the most that an episode asks of models (1000,2000000,1800); the grammar goes on without
  thinking=free | charged: whether the robot stands still for as long as models take to answer
  localizer=fused | lidar-inertial | dead-reckoning | truth (for comparison only, and named in the results)
  fixes=none | gnss | disturbed-truth:NOISE,SHARE,FAR (metres of noise, share that is false, up to how many metres; for
        comparison only): what `fused` corrects its odometry by
  motion=teb | follower | mppi: what turns ways into velocities
  ground=alike | pavements: whether ways keep to pavements, at detours of up to a fifth

Example:
  openbench run --world small_osm.world --map small.osm --models gazebo_models \\
      --deliveries delivery_instructions_small.txt --truth delivery_instructions_small_gt.txt")]
pub struct RunArgs {
    /// A built-in suite (small, medium, large), a suite file (.toml), or the folder of a generated or imported world
    #[arg(conflicts_with = "world")]
    pub suite: Option<String>,
    /// The agent
    #[arg(long, default_value = "open")]
    pub agent: String,
    /// What all noise is drawn from
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Folder for results, report and logs
    #[arg(long, default_value = "runs/latest")]
    pub out: PathBuf,
    /// Episodes run at the same time; results do not depend on it
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// A setting of the agent
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub settings: Vec<(String, String)>,
    /// How much is logged: none, thin, full
    #[arg(long, default_value = "thin")]
    pub record: openbench_bench::Level,
    /// People who walk about in the world; by default as many as the suite says
    #[arg(long)]
    pub pedestrians: Option<u16>,
    /// Cars that drive about in the world; by default as many as the suite says
    #[arg(long)]
    pub cars: Option<u16>,
    /// A map in which found doors are remembered from run to run
    #[arg(long, value_name = "FILE.osm")]
    pub memory: Option<PathBuf>,
    /// Print results as JSON
    #[arg(long)]
    pub json: bool,
    /// A Gazebo world (SDF)
    #[arg(long, requires_all = ["map"])]
    pub world: Option<PathBuf>,
    /// The OSM map of that world
    #[arg(long, requires = "world")]
    pub map: Option<PathBuf>,
    /// Folder in which `model://` is looked up (may be given more than once)
    #[arg(long, requires = "world")]
    pub models: Vec<PathBuf>,
    /// Instructions, one a line
    #[arg(long, requires = "world")]
    pub deliveries: Option<PathBuf>,
    /// True positions, `(x, y)`; several in one line for a sequence
    #[arg(long, requires = "deliveries")]
    pub truth: Option<PathBuf>,
    /// Single deliveries and sequences to draw where no file of deliveries is given
    #[arg(long, value_names = ["SINGLES", "SEQUENCES", "LENGTH"], num_args = 3, requires = "world", conflicts_with = "deliveries")]
    pub draw: Option<Vec<usize>>,
    /// How the world lies on the Earth, e.g. utm:50N,-500000,-4483000
    #[arg(long, requires = "world")]
    pub georef: Option<String>,
}
