//! `openbench verify`

use std::path::Path;

use openbench_bench::{Agents, Prepared, RunRecord, RunRequest, memory_of, repeat, verify};

use crate::args::VerifyArgs;
use crate::outcome::{Outcome, say, tell};
use crate::progress::progress_bar;

/// Drives a run's actions again and compares its files; with `--agent` it runs the agent, too.
pub fn run(args: &VerifyArgs, agents: &Agents) -> anyhow::Result<Outcome> {
    let record = RunRecord::read(&args.run)?;
    check_version(&record, &args.run)?;
    if record.episodes == 0 {
        anyhow::bail!("{} contains no episodes to verify", args.run.display());
    }
    let run = args.run.display();
    let episodes = record.episodes;
    let mut said = if args.agent {
        drive_again(&record, args, agents)?;
        format!("{run}: {episodes} episodes: files and actions agree, and the agent repeats them\n")
    } else {
        let prepared = Prepared::new(record.suite.clone(), record.truth.as_deref())?;
        replay(&record, &prepared, args)?;
        format!("{run}: {episodes} episodes: files and actions agree\n")
    };
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

/// Compares the files, and the actions of the agent that is run again.
fn drive_again(record: &RunRecord, args: &VerifyArgs, agents: &Agents) -> anyhow::Result<()> {
    if let Some(reason) = &record.cannot_repeat {
        let run = args.run.display();
        anyhow::bail!("the agent of {run} cannot be run again: {reason}; leave --agent out");
    }
    let factory = agents.get(&record.agent)?.as_ref();
    // In the order of `run`: settings before the world, downloads after it.
    super::run::check_agent(factory, &record.settings)?;
    let prepared = Prepared::new(record.suite.clone(), record.truth.as_deref())?;
    replay(record, &prepared, args)?;
    let memory = memory_of(&args.run)?;
    super::run::prepare_agent(factory, &record.settings)?;
    let bar = progress_bar(prepared.episodes.len(), "driving again");
    let request = RunRequest {
        jobs: usize::from(args.jobs),
        memory: memory.as_ref(),
        progress: &|end| bar.set_position(end.ended as u64),
        ..record.request(&prepared, factory)
    };
    repeat(&request, &args.run)?;
    bar.finish_and_clear();
    Ok(())
}
