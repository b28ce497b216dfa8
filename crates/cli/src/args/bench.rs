//! Arguments of `bench` and its subcommands.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Args as ClapArgs, Subcommand};
use openbench_motion::local::built_in::built_in;

use super::{RoadArgs, values::*};

/// Arguments of `bench`.
#[derive(Debug, ClapArgs)]
pub struct BenchArgs {
    /// What to measure
    #[command(subcommand)]
    pub command: BenchCommand,
}

/// What can be measured.
#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// The simulator: LiDAR rays, images, seconds simulated in a second of one core
    Sim(BenchSimArgs),
    /// Routing: routes, nearest places, tables, preparing a map
    Routing(BenchRoutingArgs),
    /// The pose graph of a g2o file: chi² and CPU seconds
    Posegraph(BenchPosegraphArgs),
    /// Local planners: drives through scenes from a seed, and what could have been done in each
    Motion(BenchMotionArgs),
    /// Driving among people: kilometres in the simulator, collisions, and who was to blame
    People(BenchPeopleArgs),
    /// Localization with sensors that are worse than believed: errors, and whether they are told
    Health(BenchHealthArgs),
    /// Deliveries in neighbourhoods that a seed draws from maps: success, failures by cause, errors of poses
    Towns(BenchTownsArgs),
}

/// Arguments of `bench health`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
The same drive for each kind of trouble: noise, points in steps, a LiDAR that is blind, turned or late, an IMU that is hit,
wheels of another size. A localizer may be off then, but not by a metre while it calls its pose good.

Example:
  openbench bench health medium --minutes 3 --jobs 2")]
pub struct BenchHealthArgs {
    /// A built-in world (small, medium, large), a suite file (.toml), or the folder of a generated or imported world
    pub world: String,
    /// How long each drive is
    #[arg(long, default_value_t = 3.0, value_parser = minutes)]
    pub minutes: f64,
    /// Seed of noise and the order of doors
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Drives at a time; results do not depend on it
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `bench towns`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
A window is a square of a map with ten doors at least. Four single deliveries and a sequence of three are drawn in each.
Windows that are done are kept in the folder: the same command again goes on where it was broken off.

Examples:
  openbench bench towns --map krems.osm.pbf --map heidelberg.osm.pbf --windows 20 --jobs 2
  openbench bench towns --map krems.osm.pbf --windows 4 --seed 7 --false-origin 5000 --out far --json > far.json
  openbench bench towns --map krems.osm.pbf --windows 30 --draw --out windows
  openbench record windows/000/world --out 000.mcap")]
pub struct BenchTownsArgs {
    /// A map (.osm or .osm.pbf); windows are drawn from each in turn
    #[arg(long = "map", required = true)]
    pub maps: Vec<PathBuf>,
    /// How many windows
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    pub windows: u16,
    /// How far a window reaches to each side of its middle, metres
    #[arg(long, value_name = "M", default_value_t = 160.0, value_parser = radius)]
    pub radius: f64,
    /// What windows, worlds, deliveries and noise are drawn from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How far the origin of coordinates is from each window, kilometres; nothing should depend on it
    #[arg(long, value_name = "KM", default_value_t = 0.0, value_parser = far)]
    pub false_origin: f64,
    /// The agent
    #[arg(long, default_value = "open")]
    pub agent: String,
    /// A setting of the agent
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub settings: Vec<(String, String)>,
    /// Episodes run at the same time; results do not depend on it
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// Folder for worlds, results and reports
    #[arg(long, default_value = "runs/towns")]
    pub out: PathBuf,
    /// Draw the windows and make their worlds, and deliver nothing
    #[arg(long)]
    pub draw: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `bench motion`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench bench motion --scenes 200 --seed 7
  openbench bench motion --scenes 1000 --planner teb --jobs 2 --json
  openbench bench motion --scenes 1 --first 42 --planner teb --pictures scenes")]
pub struct BenchMotionArgs {
    /// Scenes to draw; every tenth is of the same kind
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub scenes: u32,
    /// Number of the first scene
    #[arg(long, default_value_t = 0)]
    pub first: u32,
    /// Seed of the scenes
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Who drives; may be given several times [default: all of them]
    #[arg(long = "planner", value_parser = local_planner(), value_delimiter = ',')]
    pub planners: Vec<String>,
    /// Scenes at a time; only CPU times depend on it
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// Write a picture (.svg) of each drive into this folder
    #[arg(long)]
    pub pictures: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `bench people`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
OPEN's driver goes from door to door by LiDAR and wheels; only where it is it is told. Cameras and language are left out.

Examples:
  openbench bench people small --pedestrians 10,40 --km 2
  openbench bench people small --pedestrians 40 --cars 10 --planner follower --jobs 2 --json")]
pub struct BenchPeopleArgs {
    /// A built-in world (small, medium, large), a suite file (.toml), or the folder of a generated or imported world
    pub world: String,
    /// People who walk about; a row for each number
    #[arg(long, default_value = "20", value_delimiter = ',')]
    pub pedestrians: Vec<u16>,
    /// Cars that drive about
    #[arg(long, default_value_t = 0)]
    pub cars: u16,
    /// Kilometres for each row at most, in drives of half a kilometre or less; drives of more than 50 minutes end before
    #[arg(long, default_value_t = 1.0, value_parser = kilometres)]
    pub km: f64,
    /// Seed of people, noise and the order of doors
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// The local planner, as in `run --set motion=`
    #[arg(long, default_value = "teb")]
    pub planner: String,
    /// Drives at a time; results do not depend on it
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// The names of local planners.
fn local_planner() -> PossibleValuesParser {
    let names = built_in().entries().to_vec().into_iter();
    PossibleValuesParser::new(
        names.map(|entry| PossibleValue::new(entry.name()).help(entry.description())),
    )
}

/// Arguments of `bench posegraph`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Example:
  openbench bench posegraph sphere2500.g2o --json --out solved.g2o")]
pub struct BenchPosegraphArgs {
    /// The graph (.g2o)
    pub graph: PathBuf,
    /// Write the solved graph to this file
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `bench routing`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Example:
  openbench bench routing --map porto.osm.pbf --profile foot --pairs pairs.csv --json --answers answers.csv")]
pub struct BenchRoutingArgs {
    /// The map and who travels
    #[command(flatten)]
    pub roads: RoadArgs,
    /// From where to where: rows of lon,lat,lon,lat
    #[arg(long)]
    pub pairs: PathBuf,
    /// Write distance_m,duration_s of every pair to this file
    #[arg(long)]
    pub answers: Option<PathBuf>,
    /// Write the graph to this folder, for peers that know no maps
    #[arg(long)]
    pub dump: Option<PathBuf>,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `bench sim`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench bench sim medium
  openbench bench sim medium --pedestrians 50 --cars 20
  openbench bench sim --world medium_osm.world --map medium.osm --models gazebo_models --json")]
pub struct BenchSimArgs {
    /// A built-in world
    #[arg(conflicts_with = "world", default_value = "medium")]
    pub name: String,
    /// A Gazebo world (SDF)
    #[arg(long, requires = "map")]
    pub world: Option<PathBuf>,
    /// The OSM map of that world
    #[arg(long, requires = "world")]
    pub map: Option<PathBuf>,
    /// Folder in which `model://` is looked up (may be given more than once)
    #[arg(long)]
    pub models: Vec<PathBuf>,
    /// How the world lies on the Earth
    #[arg(long)]
    pub georef: Option<String>,
    /// People who walk about
    #[arg(long, default_value_t = 0)]
    pub pedestrians: u16,
    /// Cars that drive about
    #[arg(long, default_value_t = 0)]
    pub cars: u16,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Folder for the triangles and rays that were measured, for other programs to be measured with
    #[arg(long)]
    pub dump: Option<PathBuf>,
}
