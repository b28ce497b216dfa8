//! What can be written on the command line.

mod bench;
mod data;
mod language;
mod logs;
mod maps;
mod run;
mod values;
mod world;

use clap::{Parser, Subcommand};

pub use bench::*;
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
    /// Download published worlds and a sample map
    Data(DataArgs),
    /// Model files
    Models(ModelsArgs),
    /// Measure our own speed, for comparisons
    Bench(BenchArgs),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Args::command().debug_assert();
    }
}
