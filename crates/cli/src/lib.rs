//! The command line: parse, build the parts that were asked for, call, print.
//!
//! An agent of your own becomes a binary of your own: hand its factory to [`main_with`] and every command knows it beside the
//! built-in ones.
//!
//! | module | its one job |
//! |---|---|
//! | [`args`] | what can be written on the command line |
//! | [`commands`] | one file a command |
//! | [`open_parts`] | OPEN's parts from `--set` |
//! | [`outcome`] | exit codes, in one place |

pub mod args;
pub mod commands;
mod open_models;
pub mod open_parts;
pub mod outcome;
mod progress;

use std::process::ExitCode;

use clap::Parser;

pub use openbench_bench::{AgentFactory, AgentRequest, Registry};

use args::{Args, Command};
use outcome::Outcome;

/// Runs the command line with the agents of `extra` beside the built-in ones.
pub fn main_with(extra: Registry) -> ExitCode {
    let filter =
        tracing_subscriber::EnvFilter::try_from_env("OPENBENCH_LOG").unwrap_or_else(|_| "warn".into());
    tracing_subscriber::fmt().with_writer(std::io::stderr).with_env_filter(filter).without_time().init();
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(error) => return outcome::usage(&error),
    };
    let registry = extra.with("open", open_parts::factory());
    outcome::exit(dispatch(args.command, &registry))
}

fn dispatch(command: Command, registry: &Registry) -> anyhow::Result<Outcome> {
    match command {
        Command::Run(args) => commands::run::run(&args, registry),
        Command::Plan(args) => commands::plan::run(&args),
        Command::Srtp(args) => commands::srtp::run(&args),
        Command::Route(args) => commands::route::run(&args),
        Command::Odometry(args) => commands::odometry::run(&args),
        Command::Record(args) => commands::record::run(&args),
        Command::Prepare(args) => commands::prepare::run(&args),
        Command::Costmap(args) => commands::costmap::run(&args),
        Command::Serve(args) => commands::serve::run(&args),
        Command::Evaluate(args) => commands::evaluate::run(&args),
        Command::Verify(args) => commands::verify::run(&args, registry),
        Command::World(args) => commands::world::run(&args),
        Command::Models(args) => commands::models::run(&args),
        Command::Bench(args) => commands::bench::run(&args, registry),
    }
}
