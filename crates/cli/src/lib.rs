//! The command `openbench` as a library: a program of one's own is the same command with further
//! agents, plate readers, localizers, sources of fixes and local planners.
//!
//! ```no_run
//! use openbench::{AgentError, AgentRequest, Extensions};
//! use openbench_core::{Action, Agent, Briefing, Events, GiveUp, Observation, Velocity};
//!
//! /// Stands still.
//! struct Idle;
//!
//! impl Agent for Idle {
//!     fn begin(&mut self, _: &Briefing, _: &mut dyn Events) -> Result<(), GiveUp> {
//!         Ok(())
//!     }
//!
//!     fn act(&mut self, _: &Observation<'_>, _: &mut dyn Events) -> Action {
//!         Action::Drive(Velocity::ZERO)
//!     }
//! }
//!
//! fn make(_: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
//!     Ok(Box::new(Idle))
//! }
//!
//! fn main() -> std::process::ExitCode {
//!     openbench::main_with(Extensions::new().with_agent("idle", "stands still", make))
//! }
//! ```
//!
//! `run --agent idle` then runs it.
//!
//! | module | contents |
//! |---|---|
//! | [`args`] | what can be written on the command line |
//! | [`commands`] | one file a command |
//! | [`datasets`] | published data: manifests and download |
//! | [`extensions`] | [`Extensions`]: agents and parts from outside |
//! | `help` | help texts that list agents and parts |
//! | `open_agent` | OPEN as an agent of the benchmark |
//! | `policy_agents` | agents in Python and in other programs |
//! | [`outcome`] | exit codes, in one place |
//! | `signals` | SIGINT and SIGTERM end a run in order |

pub mod args;
pub mod commands;
pub mod datasets;
pub mod extensions;
mod help;
mod open_agent;
pub mod outcome;
mod policy_agents;
mod progress;
mod served_agents;
mod signals;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::OnceLock;

use clap::FromArgMatches as _;

pub use extensions::{ExtensionError, Extensions};
pub use openbench_agents::open::parts::{Fixes, FixesPart, LocalizerPart, PartError, Situation};
pub use openbench_bench::run::registry::AgentError;
pub use openbench_bench::{AgentFactory, AgentRequest, Build, ModelDigest, Setting};

use args::{Args, Command};
use openbench_bench::worlds::hashes::hash_file;
use outcome::Outcome;

/// Runs the command line with agents and parts beside the built-in ones.
pub fn main_with(extensions: Extensions) -> ExitCode {
    ExitCode::from(main_of(std::env::args_os(), extensions))
}

/// As [`main_with`], with these arguments, of which the first one is the name of the program.
/// Returns the exit code.
pub fn main_of(arguments: impl IntoIterator<Item = OsString>, extensions: Extensions) -> u8 {
    let filter = tracing_subscriber::EnvFilter::try_from_env("OPENBENCH_LOG")
        .unwrap_or_else(|_| "warn".into());
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_env_filter(filter)
        .without_time()
        // A process that runs several commands has its subscriber already.
        .try_init()
        .ok();
    // Before the extensions are checked, so that --help works even if a name is refused.
    let matches = help::command(&extensions).try_get_matches_from(arguments);
    let args = match matches.and_then(|matches| Args::from_arg_matches(&matches)) {
        Ok(args) => args,
        Err(error) => return outcome::usage(&error),
    };
    let checked = extensions.checked().map_err(anyhow::Error::from);
    outcome::exit(checked.and_then(|()| dispatch(args.command, &extensions)))
}

/// The commit that this program is built from.
const COMMIT: &str = env!("OPENBENCH_COMMIT");

/// The file that has this code, where it is not the program of the process.
static MODULE: OnceLock<PathBuf> = OnceLock::new();

/// Names the file that has this code, if an interpreter runs it: results have its hash. The first
/// name counts.
pub fn set_module(file: PathBuf) {
    MODULE.get_or_init(|| file);
}

/// This program: its commit, its file, and the platform that it is built for.
pub fn build() -> Build {
    let module = MODULE.get().cloned();
    let program = module.or_else(|| std::env::current_exe().ok());
    Build {
        commit: COMMIT.to_owned(),
        // A program whose file was replaced since it started can still run.
        program: program
            .and_then(|path| hash_file(&path).ok())
            .unwrap_or_default(),
        target: env!("OPENBENCH_TARGET").to_owned(),
    }
}

fn dispatch(command: Command, extensions: &Extensions) -> anyhow::Result<Outcome> {
    match command {
        Command::Run(args) => commands::run::run(&args, &extensions.agents()),
        Command::Plan(args) => commands::plan::run(&args, extensions.parts()),
        Command::Srtp(args) => commands::srtp::run(&args, extensions.parts()),
        Command::Route(args) => commands::route::run(&args),
        Command::Odometry(args) => commands::odometry::run(&args),
        Command::Record(args) => commands::record::run(&args),
        Command::Prepare(args) => commands::prepare::run(&args),
        Command::Costmap(args) => commands::costmap::run(&args),
        Command::Serve(args) => commands::serve::run(&args),
        Command::Evaluate(args) => commands::evaluate::run(&args),
        Command::Verify(args) => commands::verify::run(&args, &extensions.agents()),
        Command::Compare(args) => commands::compare::run(&args),
        Command::World(args) => commands::world::run(&args),
        Command::Data(args) => commands::data::run(&args),
        Command::Models(args) => commands::models::run(&args),
        Command::Bench(args) => commands::bench::run(&args, extensions),
    }
}
