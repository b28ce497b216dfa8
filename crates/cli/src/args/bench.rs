//! Arguments of `bench` and its subcommands.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Subcommand};
use openbench_bench::WorldSource;

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
    /// Speed of the simulator: LiDAR rays, images, real-time factor of one core
    Sim(BenchSimArgs),
    /// Speed of routing: routes, nearest points, tables, map preparation
    Routing(BenchRoutingArgs),
    /// Solve the pose graph of a g2o file: chi² and CPU time
    Posegraph(BenchPosegraphArgs),
    /// Compare local planners in random scenes with the best known motion
    Motion(BenchMotionArgs),
    /// Drive among people: collisions by fault, near misses, stops
    People(BenchPeopleArgs),
    /// Localization with degraded sensors: errors, and whether they are reported
    Health(BenchHealthArgs),
    /// Deliveries in random neighbourhoods of maps: success, causes of failure, pose errors
    Towns(BenchTownsArgs),
    /// Localization on public maps with errors: where a robot finds itself, and when it is sure
    Localization(BenchLocalizationArgs),
}

/// Arguments of `bench localization`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
A robot drives 60 m again and again, along doors in random order. On each drive it compares
what its LiDAR sees with the buildings of a map that is wrong as public maps are.

A drive of another length (`--drive`) shows whether the robot stays where it is on the map:
`along` has the errors after all of its legs of 5 m.

Recall is the share of drives on which the pose is right after so many metres; a drive
without an accepted pose counts as a miss. Shares are fractions of 1 in JSON.

Examples:
  openbench bench localization medium --start 10m --level good --poses 20 --jobs 2
  openbench bench localization medium-7 medium-8 --start block --level city --drives drives
  openbench bench localization krems --start off --beside heidelberg --json
  openbench bench localization medium --poses 50 --peers --peer ./my-program
  openbench bench localization medium --labels truth
  openbench bench localization medium --without building-offsets
  openbench bench localization medium --start block --missing 0.5
  openbench bench localization krems --poses 2 --drive 3000 --odometry-drift 0.01")]
pub struct BenchLocalizationArgs {
    /// Built-in worlds (small, medium-7, krems), suite files (.toml), or world folders
    #[arg(required_unless_present = "world", conflicts_with = "world")]
    pub worlds: Vec<String>,
    /// A Gazebo world instead
    #[command(flatten)]
    pub imported: ImportedArgs,
    /// How wrong the map is: exact, good, city or poor, as in the condition `map`
    #[arg(long, default_value = "good")]
    pub level: String,
    /// Share of the buildings that are missing on the map, instead of the level's
    #[arg(long, value_name = "SHARE", value_parser = missing)]
    pub missing: Option<f64>,
    /// What is known about the start: exact, 5m, 10m, block or map, as in the condition `start`;
    /// off for a robot that is beside the map
    #[arg(long, default_value = "10m")]
    pub start: String,
    /// The world whose map the robot gets with `--start off`
    #[arg(long, value_name = "WORLD", default_value = "medium-9999")]
    pub beside: String,
    /// Length of a drive, metres
    #[arg(long, value_name = "METRES", default_value_t = 60.0, value_parser = metres_of_drive)]
    pub drive: f64,
    /// Adds drift to odometry, as a share of the distance driven
    #[arg(long, value_name = "SHARE", value_parser = drift)]
    pub odometry_drift: Option<f64>,
    /// How facades are distinguished from hedges, cars and other surfaces: by geometry, or, as an
    /// upper bound, by the true class of each surface
    #[arg(long, value_enum, default_value_t = LabelSource::Geometry)]
    pub labels: LabelSource,
    /// Leaves out a part of registration (ablation)
    #[arg(long, value_enum, value_name = "PART", conflicts_with = "examples")]
    pub without: Option<RegistrationPart>,
    /// Number of drives in each world
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub poses: u32,
    /// Seed of drives, noise, map errors and starts
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder in which recorded drives are kept, and from which they are read if they are there
    #[arg(long, value_name = "FOLDER")]
    pub drives: Option<PathBuf>,
    /// Also localize by odometry alone, by ICP and by a particle filter, on the same drives
    #[arg(long, conflicts_with = "examples")]
    pub peers: bool,
    /// Also localize by a program of your own, on the same drives. It gets lines of JSON and
    /// answers with poses, as benchmarks/localization/global_registration.py does
    #[arg(long, conflicts_with = "examples")]
    pub peer: Vec<PathBuf>,
    /// Only write all candidate poses with their errors, one in a line, to fit probabilities to
    #[arg(long, value_name = "FILE.jsonl")]
    pub examples: Option<PathBuf>,
    /// Drives in parallel; only computing times depend on it
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// How facades are distinguished from other surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LabelSource {
    /// By geometry
    Geometry,
    /// By the true class of each surface
    Truth,
}

/// A part of registration that can be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RegistrationPart {
    /// Ground that rays show to be free
    FreeSpace,
    /// Offsets of buildings: each is taken to be where the map shows it
    BuildingOffsets,
    /// Hypotheses that are confirmed on the way: one place has to be enough
    HypothesisBank,
}

fn metres_of_drive(text: &str) -> Result<f64, String> {
    let metres = text.parse().map_err(|_| "give metres".to_owned())?;
    if (60.0..=20_000.0).contains(&metres) {
        Ok(metres)
    } else {
        Err("give 60 to 20000 metres".to_owned())
    }
}

fn drift(text: &str) -> Result<f64, String> {
    share(text, 0.5)
}

fn missing(text: &str) -> Result<f64, String> {
    share(text, 0.9)
}

/// A share of something, at most so large.
fn share(text: &str, most: f64) -> Result<f64, String> {
    let share = text.parse().ok();
    let allowed = share.filter(|share| (0.0..=most).contains(share));
    allowed.ok_or(format!("give a share from 0 to {most}, such as 0.01"))
}

/// A Gazebo world instead of a built-in one.
#[derive(Debug, ClapArgs)]
pub struct ImportedArgs {
    /// A Gazebo world (SDF)
    #[arg(long, requires = "map")]
    pub world: Option<PathBuf>,
    /// The OSM map of that world
    #[arg(long, requires = "world")]
    pub map: Option<PathBuf>,
    /// Folder with the models that `model://` names; may be repeated
    #[arg(long)]
    pub models: Vec<PathBuf>,
    /// Georeference of the world: UTM zone, and the metres that are added to easting and northing,
    /// such as utm:50N,-500000,-4483000
    #[arg(long)]
    pub georef: Option<String>,
}

impl ImportedArgs {
    /// The world that is asked for, if one is.
    pub fn source(&self) -> Option<WorldSource> {
        Some(WorldSource::Imported {
            world: self.world.clone()?,
            map: self.map.clone()?,
            models: self.models.clone(),
            georeference: self.georef.clone(),
        })
    }
}

/// Arguments of `bench health`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
The same drive is repeated with each kind of degradation: noise, quantized points, a LiDAR
that is blinded, rotated or late, impacts on the IMU, wheels of another radius. A localizer
may be wrong then, but not by more than a metre while its health is good.

Example:
  openbench bench health medium --minutes 3 --jobs 2")]
pub struct BenchHealthArgs {
    /// A built-in world (small, medium, large), a suite file (.toml), or a world folder
    pub world: String,
    /// Duration of each drive, minutes
    #[arg(long, default_value_t = 3.0, value_parser = minutes)]
    pub minutes: f64,
    /// Seed of noise and the order of doors
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// The localizer, as in `run --set localizer=NAME`; without fixes
    #[arg(long, value_name = "NAME", default_value = "fused")]
    pub localizer: String,
    /// Drives in parallel; results do not depend on it
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `bench towns`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
A window is a square of a map with at least ten doors. Four single deliveries and a sequence
of three are drawn in each. Finished windows stay in the folder: the same command continues
where it was interrupted.

Examples:
  openbench bench towns --map krems.osm.pbf --map heidelberg.osm.pbf --windows 20 --jobs 2
  openbench bench towns --map krems.osm.pbf --windows 4 --false-origin 5000 --out far --json
  openbench bench towns --map krems.osm.pbf --windows 30 --draw --out windows
  openbench record windows/000/world --out 000.mcap")]
pub struct BenchTownsArgs {
    /// A map (.osm or .osm.pbf); may be repeated, windows are drawn from each in turn
    #[arg(long = "map", required = true)]
    pub maps: Vec<PathBuf>,
    /// Number of windows
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    pub windows: u16,
    /// Half the side of a window, metres
    #[arg(long, value_name = "M", default_value_t = 160.0, value_parser = radius)]
    pub radius: f64,
    /// Seed of windows, worlds, deliveries and noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Distance of the coordinates' origin from each window, kilometres
    #[arg(long, value_name = "KM", default_value_t = 0.0, value_parser = far)]
    pub false_origin: f64,
    /// The agent to run
    #[arg(long, default_value = "open")]
    pub agent: String,
    /// A setting of the agent, as in `run`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub settings: Vec<(String, String)>,
    /// Episodes that run in parallel; results do not depend on it
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// Folder for worlds, results and reports
    #[arg(long, default_value = "runs/towns")]
    pub out: PathBuf,
    /// Only draw the windows and write their worlds
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
    /// Number of scenes; every tenth is of the same kind
    #[arg(
        long,
        default_value_t = 100,
        value_parser = clap::value_parser!(u32).range(1..=1_000_000)
    )]
    pub scenes: u32,
    /// Number of the first scene
    #[arg(long, default_value_t = 0)]
    pub first: u32,
    /// Seed of the scenes
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Local planners, separated by commas [default: all]
    #[arg(long = "planner", value_name = "NAME", value_delimiter = ',')]
    pub planners: Vec<String>,
    /// Scenes in parallel; only CPU times depend on it
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// Folder for a picture (.svg) of each drive
    #[arg(long)]
    pub pictures: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `bench people`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
OPEN's driver drives from door to door with LiDAR and wheels; its pose is given by the
simulator. Camera and language are not used.

Examples:
  openbench bench people small --pedestrians 10,40 --km 2
  openbench bench people small --pedestrians 40 --cars 10 --planner follower --jobs 2 --json")]
pub struct BenchPeopleArgs {
    /// A built-in world (small, medium, large), a suite file (.toml), or a world folder
    pub world: String,
    /// Numbers of pedestrians, separated by commas: one row each
    #[arg(long, default_value = "20", value_delimiter = ',')]
    pub pedestrians: Vec<u16>,
    /// Number of moving cars
    #[arg(long, default_value_t = 0)]
    pub cars: u16,
    /// Kilometres per row, in drives of up to 500 m or 50 minutes
    #[arg(long, default_value_t = 1.0, value_parser = kilometres)]
    pub km: f64,
    /// Seed of people, noise and the order of doors
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// The local planner, as in `run --set motion=NAME`
    #[arg(long, value_name = "NAME", default_value = "teb")]
    pub planner: String,
    /// Drives in parallel; results do not depend on it
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `bench posegraph`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Example:
  openbench bench posegraph sphere2500.g2o --json --out solved.g2o")]
pub struct BenchPosegraphArgs {
    /// The graph (.g2o)
    pub graph: PathBuf,
    /// File for the solved graph
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
  openbench bench routing --map porto.osm.pbf --profile foot --pairs pairs.csv --json")]
pub struct BenchRoutingArgs {
    /// Map and profile
    #[command(flatten)]
    pub roads: RoadArgs,
    /// CSV file of pairs: lon,lat,lon,lat per line
    #[arg(long)]
    pub pairs: PathBuf,
    /// File for distance_m,duration_s of each pair
    #[arg(long)]
    pub answers: Option<PathBuf>,
    /// Folder for the graph, for programs that read no maps
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
    /// A Gazebo world instead
    #[command(flatten)]
    pub imported: ImportedArgs,
    /// Number of pedestrians
    #[arg(long, default_value_t = 0)]
    pub pedestrians: u16,
    /// Number of moving cars
    #[arg(long, default_value_t = 0)]
    pub cars: u16,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Folder for the measured triangles and rays, for other programs
    #[arg(long)]
    pub dump: Option<PathBuf>,
}
