//! What can be written on the command line.

mod bench;
mod compare;
mod data;
mod language;
mod logs;
mod maps;
mod run;
mod values;
mod world;

use clap::{Parser, Subcommand};

pub use bench::*;
pub use compare::*;
pub use data::*;
pub use language::*;
pub use logs::*;
pub use maps::*;
pub use run::*;
pub use world::*;

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
  openbench run
  openbench run medium --jobs 2 --out runs/medium
  openbench compare runs/medium runs/mine
  openbench world generate --map city.osm.pbf --around 7.4197,43.7314 --radius 300 --out worlds/city
  openbench run worlds/city
  openbench run --world city.world --map city.osm --models gazebo_models \\
      --deliveries deliveries.txt --truth doors.txt
  openbench plan --map city.osm \"Box to unit 1, building 3\"
  openbench route --map city.osm.pbf 7.4197,43.7314 7.4246,43.7387

Exit codes: 0 done, 1 a run could not be finished or has a problem, 2 bad usage or input,
130 or 143 stopped by SIGINT or SIGTERM; `run --resume` continues.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run an agent through a suite of deliveries and score it
    Run(RunArgs),
    /// Plan the deliveries of an instruction; prints JSON
    Plan(PlanArgs),
    /// Measure how many instructions a planner understands (SRTP)
    Srtp(SrtpArgs),
    /// Compute a route; prints JSON in the format of OSRM's HTTP API
    Route(RouteArgs),
    /// Write a map's roads as a graph file that routing opens at once
    Prepare(PrepareArgs),
    /// Draw a map as a costmap file of ROS's map server
    Costmap(CostmapArgs),
    /// Compute the trajectory of a log by LiDAR-inertial odometry
    Odometry(OdometryArgs),
    /// Drive around a world and record all sensor data and the truth
    Record(RecordArgs),
    /// Serve OSRM's HTTP API: route, nearest, table
    Serve(ServeArgs),
    /// Score a log of the paper's recorder; prints JSON
    Evaluate(EvaluateArgs),
    /// Repeat the recorded actions of a run, or its agent, and compare every state
    Verify(VerifyArgs),
    /// Compare the results of agents that ran the same suites
    Compare(CompareArgs),
    /// Generate, import and render worlds
    World(WorldArgs),
    /// Download published worlds and a sample map
    Data(DataArgs),
    /// List and download model files
    Models(ModelsArgs),
    /// Measure parts: speed, planners, localization, deliveries in towns
    Bench(BenchArgs),
}
