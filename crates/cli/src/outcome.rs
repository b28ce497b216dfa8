//! Exit codes. 0: done (a failed delivery is a result, not an error). 1: an episode could not be
//! completed, `verify` differs, or `plan` reports a problem. 2: bad usage or bad input. 130, 143: a
//! run was stopped by SIGINT or SIGTERM.

use std::io::{self, Write};
use std::process::ExitCode;

use openbench_bench::BenchError;
use openbench_core::with_causes;

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Done.
    Done,
    /// Done, and what was found is a problem.
    Problem,
    /// Stopped in order by the signal of this number.
    Stopped(u8),
}

/// What clap says about a command line; `--help` and `--version` are no errors.
pub fn usage(error: &clap::Error) -> ExitCode {
    // If the terminal is closed, there is nobody to tell.
    let _ = error.print();
    if error.use_stderr() {
        ExitCode::from(2)
    } else {
        ExitCode::SUCCESS
    }
}

/// The exit code of a command; an error is said on stderr, with its causes.
pub fn exit(result: anyhow::Result<Outcome>) -> ExitCode {
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Problem) => ExitCode::from(1),
        // As shells report processes that a signal has ended.
        Ok(Outcome::Stopped(signal)) => ExitCode::from(128 + signal),
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            // Not `eprintln!`, which panics if stderr cannot be written.
            let _ = writeln!(io::stderr(), "openbench: {}", with_causes(error.as_ref()));
            ExitCode::from(if is_failed_run(&error) { 1 } else { 2 })
        }
    }
}

fn is_failed_run(error: &anyhow::Error) -> bool {
    // A replay that differs, a model that never answered, a log that cannot be written. Other
    // errors are of usage or input.
    matches!(
        error.downcast_ref(),
        Some(
            BenchError::Differs { .. }
                | BenchError::Altered { .. }
                | BenchError::Log(_)
                | BenchError::Unreachable { .. }
        )
    )
}

/// Whoever read our output has had enough, as `head` does.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<io::Error>()
        .is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
}

/// Writes text to stdout.
pub fn say(text: &str) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}

/// Writes a value to stdout as JSON.
pub fn say_json(value: &impl serde::Serialize) -> anyhow::Result<()> {
    say(&(serde_json::to_string_pretty(value)? + "\n"))
}

/// Writes a message for people to stderr.
pub fn tell(message: &str) {
    // Not `eprintln!`, which panics if stderr cannot be written.
    let _ = writeln!(io::stderr(), "{message}");
}
