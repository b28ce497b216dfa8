//! `openbench verify`

use std::path::Path;

use openbench_bench::plural::count;
use openbench_bench::{
    Agents, BenchError, Prepared, RunRecord, RunRequest, memory_of, repeat, verify, verify_agent,
};

use crate::args::VerifyArgs;
use crate::commands::run::{check_agent, prepare_agent};
use crate::outcome::{Outcome, say, tell};
use crate::progress::progress_bar;

/// Drives a run's actions again and compares its files; with `--agent` it runs the agent, too.
pub fn run(args: &VerifyArgs, agents: &Agents) -> anyhow::Result<Outcome> {
    let record = RunRecord::read(&args.run)?;
    check_version(&record, &args.run)?;
    if record.episodes == 0 {
        anyhow::bail!("{} contains no episodes to verify", args.run.display());
    }
    if args.agent {
        // In the order of `run`: settings before the world, downloads after it.
        check_repeatable(&record, args, agents)?;
    }
    let prepared = Prepared::new(record.suite.clone(), record.truth.as_deref())?;
    let unchecked = check_claims(&record, &prepared, args, agents)?;
    replay(&record, &prepared, args)?;
    if args.agent {
        drive_again(&record, &prepared, args, agents)?;
    }
    let run = args.run.display();
    let episodes = count(record.episodes, "episode", "episodes");
    let repeats = if args.agent {
        ", and the agent repeats them"
    } else {
        ""
    };
    let mut said = format!("{run}: {episodes}: files and actions agree{repeats}\n");
    if let Some(reason) = unchecked {
        said += &format!("{run}: what it says of its agent cannot be checked: {reason}\n");
    }
    if let Some(reason) = &record.cannot_repeat {
        said += &format!("{run}: who made the actions cannot be checked: {reason}\n");
    }
    say(&said)?;
    Ok(Outcome::Done)
}

/// Runs repeat within one version. Another build of it may differ, which is good to know if it
/// does.
fn check_version(record: &RunRecord, run: &Path) -> anyhow::Result<()> {
    let version = env!("CARGO_PKG_VERSION");
    if record.version != version {
        anyhow::bail!(
            "{} was made by version {}, this is version {version}; runs repeat within one version \
             only",
            run.display(),
            record.version
        );
    }
    let (then, now) = (record.build.commit.as_str(), crate::COMMIT);
    if then != now {
        tell(&format!(
            "{} was made by commit {then}, this program by {now}; they may differ",
            run.display()
        ));
    }
    Ok(())
}

/// Compares all files with what the recorded actions give.
fn replay(record: &RunRecord, prepared: &Prepared, args: &VerifyArgs) -> anyhow::Result<()> {
    let bar = progress_bar(record.episodes, "verifying");
    let jobs = usize::from(args.jobs);
    verify(&args.run, record, prepared, jobs, &mut || bar.inc(1))?;
    bar.finish_and_clear();
    Ok(())
}

/// Compares what the record says of its agent with the agent. In words, why that is impossible.
fn check_claims(
    record: &RunRecord,
    prepared: &Prepared,
    args: &VerifyArgs,
    agents: &Agents,
) -> anyhow::Result<Option<String>> {
    let factory = match agents.get(&record.agent) {
        Ok(factory) => factory.as_ref(),
        Err(unknown) => return Ok(Some(unknown.to_string())),
    };
    if let Err(unknown) = factory.check(&record.settings) {
        return Ok(Some(unknown.to_string()));
    }
    match verify_agent(&args.run, record, prepared, factory) {
        Err(BenchError::Agent { source, .. }) => Ok(Some(source.to_string())),
        checked => Ok(checked.map(|()| None)?),
    }
}

/// Refuses an agent that cannot be run again.
fn check_repeatable(record: &RunRecord, args: &VerifyArgs, agents: &Agents) -> anyhow::Result<()> {
    if let Some(reason) = &record.cannot_repeat {
        let run = args.run.display();
        anyhow::bail!("the agent of {run} cannot be run again: {reason}; leave --agent out");
    }
    check_agent(agents.get(&record.agent)?.as_ref(), &record.settings)
}

/// Compares the actions of the agent that is run again.
fn drive_again(
    record: &RunRecord,
    prepared: &Prepared,
    args: &VerifyArgs,
    agents: &Agents,
) -> anyhow::Result<()> {
    let factory = agents.get(&record.agent)?.as_ref();
    let memory = memory_of(&args.run)?;
    prepare_agent(factory, &record.settings)?;
    let bar = progress_bar(prepared.episodes.len(), "driving again");
    let request = RunRequest {
        jobs: usize::from(args.jobs),
        memory: memory.as_ref(),
        progress: &|end| bar.set_position(end.ended as u64),
        ..record.request(prepared, factory)
    };
    repeat(&request, &args.run)?;
    bar.finish_and_clear();
    Ok(())
}
