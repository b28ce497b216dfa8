//! `openbench verify`

use openbench_bench::run::recording::{Recording, RunRecord, verify};
use openbench_bench::{Agents, Level, Prepared, RunRequest, memory_of, repeat};

use crate::args::VerifyArgs;
use crate::outcome::{Outcome, say};
use crate::progress::progress_bar;

/// Drives a run's actions again, and its agent if that is asked for.
pub fn run(args: &VerifyArgs, agents: &Agents) -> anyhow::Result<Outcome> {
    let record = RunRecord::read(&args.run)?;
    if record.version != env!("CARGO_PKG_VERSION") {
        anyhow::bail!(
            "{} was made by version {}, this is version {}; runs repeat within one version only",
            args.run.display(),
            record.version,
            env!("CARGO_PKG_VERSION")
        );
    }
    if record.episodes == 0 {
        anyhow::bail!("{} contains no episodes to verify", args.run.display());
    }
    // All recordings first: a missing one is found before the world is built.
    let recordings: Result<Vec<Recording>, _> = (0..record.episodes)
        .map(|i| Recording::read(&args.run, i))
        .collect();
    let recordings = recordings?;
    if args.agent {
        drive_again(&record, args, agents)?;
        say(&format!(
            "{}: the agent of {} episodes repeats to the bit\n",
            args.run.display(),
            record.episodes
        ))?;
        return Ok(Outcome::Done);
    }
    let prepared = Prepared::new(record.suite, record.truth.as_deref())?;
    let bar = progress_bar(recordings.len(), "verifying");
    for (number, recording) in recordings.iter().enumerate() {
        verify(&prepared, number, recording)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    say(&format!(
        "{}: {} episodes repeat to the bit\n",
        args.run.display(),
        recordings.len()
    ))?;
    Ok(Outcome::Done)
}

/// Runs the agent again. What its actions do to the world is compared with the same stroke.
fn drive_again(record: &RunRecord, args: &VerifyArgs, agents: &Agents) -> anyhow::Result<()> {
    let factory = agents.get(&record.agent)?.as_ref();
    // In the order of `run`: settings before the world, downloads after it.
    super::run::check_agent(factory, &record.settings)?;
    let prepared = Prepared::new(record.suite.clone(), record.truth.as_deref())?;
    let memory = memory_of(&args.run)?;
    super::run::prepare_agent(factory, &record.settings)?;
    let bar = progress_bar(prepared.episodes.len(), "driving again");
    let request = RunRequest {
        prepared: &prepared,
        agent: &record.agent,
        factory,
        settings: &record.settings,
        seed: record.seed,
        jobs: usize::from(args.jobs),
        level: Level::None,
        out: None,
        memory: memory.as_ref(),
        command: "",
        progress: &|done| bar.set_position(done as u64),
    };
    repeat(&request, &args.run)?;
    bar.finish_and_clear();
    Ok(())
}
