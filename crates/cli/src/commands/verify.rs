//! `openbench verify`

use std::path::Path;

use anyhow::Context;
use openbench_bench::plural::count;
use openbench_bench::score::across::{Means, System, means};
use openbench_bench::{
    Agents, BenchError, Prepared, Results, RunRecord, RunRequest, memory_of, repeat, verify,
    verify_agent,
};
use openbench_core::input;

use crate::args::VerifyArgs;
use crate::commands::run::{agent_named, check_agent, prepare_agent};
use crate::commands::seeds;
use crate::outcome::{Outcome, say, tell};
use crate::progress::progress_bar;

/// Bound for a file of means, bytes: it has some numbers for each of at most a thousand seeds.
const MOST_BYTES_OF_MEANS: u64 = 16 << 20;

/// Verifies a run, or the runs of several seeds and their means.
pub fn run(args: &VerifyArgs, agents: &Agents) -> anyhow::Result<Outcome> {
    let path = args.run.join(seeds::MEANS);
    if !path.exists() {
        seeds::refuse_several_runs(&args.run)
            .context("its means are not there yet: the same `run --seeds` continues")?;
        return verify_run(args, agents);
    }
    let text = input::read(&path, MOST_BYTES_OF_MEANS)
        .with_context(|| format!("{} cannot be read", path.display()))?;
    let recorded: Means = serde_json::from_slice(&text)
        .with_context(|| format!("{} has no means", path.display()))?;
    for seed in &recorded.seeds {
        let run = seeds::folder(&args.run, *seed);
        verify_run(&VerifyArgs { run, ..*args }, agents)?;
    }
    if text != seeds::written(&means_of(&args.run, &recorded)?)? {
        let detail = "the runs of its seeds have other means".to_owned();
        return Err(BenchError::Altered { path, detail }.into());
    }
    say(&format!(
        "{}: they are the means of these runs\n",
        path.display()
    ))?;
    Ok(Outcome::Done)
}

/// The means over the seeds that a file of means names.
fn means_of(folder: &Path, recorded: &Means) -> anyhow::Result<Means> {
    let seeds = recorded.seeds.iter();
    let runs = seeds.map(|seed| Results::read(&seeds::folder(folder, *seed).join(Results::FILE)));
    let runs = runs.collect::<Result<_, _>>()?;
    // The folder's name then, which may have another one now.
    let name = recorded.system.name.clone();
    Ok(means(&System { name, runs }, 0))
}

/// Drives a run's actions again and compares its files; with `--agent` it runs the agent, too.
fn verify_run(args: &VerifyArgs, agents: &Agents) -> anyhow::Result<Outcome> {
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
        Ok(factory) => factory,
        Err(unknown) => return Ok(Some(unknown.to_string())),
    };
    if let Err(unknown) = factory.check(&record.settings) {
        return Ok(Some(unknown.to_string()));
    }
    match verify_agent(&args.run, record, prepared, factory.as_ref()) {
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
    check_agent(
        agent_named(agents, &record.agent)?.as_ref(),
        &record.settings,
    )
}

/// Compares the actions of the agent that is run again.
fn drive_again(
    record: &RunRecord,
    prepared: &Prepared,
    args: &VerifyArgs,
    agents: &Agents,
) -> anyhow::Result<()> {
    let factory = agent_named(agents, &record.agent)?;
    let factory = factory.as_ref();
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
