//! `openbench run --seeds`: a suite with several seeds, and the means over them.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use openbench_bench::report::means_table;
use openbench_bench::score::across::{Means, System, means};
use openbench_bench::{
    BenchError, FinishedBefore, Prepared, Results, RunRequest, Unfinished, interrupted,
};
use openbench_osm::write_atomically;

use super::driving::drive_with_progress;
use crate::args::RunArgs;
use crate::outcome::{Outcome, say, say_json, tell};
use crate::signals::StopSignal;

/// Name of the file with the means.
pub const MEANS: &str = "means.json";
/// Name of a seed's folder, up to its number.
const SEED: &str = "seed-";

/// Builds the world of a seed, where it differs from that of the first one.
pub type WorldOfSeed<'a> = &'a dyn Fn(u64) -> anyhow::Result<Option<Prepared>>;

/// A seed and the folder of its run.
struct Seed {
    number: u64,
    out: PathBuf,
}

/// Runs the request with each seed, in a folder for each. What is done already is kept, so the same
/// command continues after an interruption.
pub fn drive_each(
    seeds: &RangeInclusive<u64>,
    request: &RunRequest<'_>,
    world_of: WorldOfSeed<'_>,
    args: &RunArgs,
    stop: &StopSignal,
) -> anyhow::Result<Outcome> {
    refuse_single_run(&args.out)?;
    let seeds: Vec<Seed> = seeds
        .clone()
        .map(|number| Seed {
            number,
            out: folder(&args.out, number),
        })
        .collect();
    // All of them first, before hours are driven for some.
    if !args.discard {
        spare_other_runs(request, world_of, &seeds)?;
    }
    let mut runs = Vec::new();
    for Seed { number, out } in &seeds {
        let own = world_of(*number)?;
        let request = of_seed(request, own.as_ref(), *number, out);
        let request = RunRequest {
            unfinished: unfinished(&request, out, args)?,
            ..request
        };
        match one(request) {
            Err(BenchError::Interrupted) => {
                tell(&format!(
                    "stopped; {} of {} seeds are finished; the same command continues",
                    runs.len(),
                    seeds.len()
                ));
                return Ok(Outcome::Stopped(stop.number()));
            }
            results => runs.push(results?),
        }
    }
    let name = args.out.display().to_string();
    finish(&means(&System { name, runs }, 0), args)
}

/// Refuses a folder with a single run, which would be taken for all the seeds.
fn refuse_single_run(out: &Path) -> anyhow::Result<()> {
    if out.join(Results::FILE).exists() {
        anyhow::bail!(
            "{} has a single run; choose another folder for the seeds with --out",
            out.display()
        );
    }
    Ok(())
}

/// Refuses a folder with the runs of several seeds for a single run, whose files would lie between
/// theirs.
pub fn refuse_several_runs(out: &Path) -> anyhow::Result<()> {
    let Ok(entries) = std::fs::read_dir(out) else {
        // A folder that does not exist holds no runs; others are reported where they are written.
        return Ok(());
    };
    let mut names = entries.flatten().map(|entry| entry.file_name());
    let is_number = |text: &str| text.parse::<u64>().is_ok();
    let is_of_seeds = |name: &str| name == MEANS || name.strip_prefix(SEED).is_some_and(is_number);
    if names.any(|name| name.to_str().is_some_and(is_of_seeds)) {
        anyhow::bail!(
            "{} has the runs of several seeds; choose another folder with --out, or remove it",
            out.display()
        );
    }
    Ok(())
}

/// The folders of the runs that the arguments ask for.
pub fn folders(args: &RunArgs) -> Vec<PathBuf> {
    match &args.seeds {
        None => vec![args.out.clone()],
        Some(seeds) => seeds.clone().map(|seed| folder(&args.out, seed)).collect(),
    }
}

/// The folder of a seed's run.
pub fn folder(out: &Path, seed: u64) -> PathBuf {
    out.join(format!("{SEED}{seed}"))
}

/// What is done with the remains of a seed that was interrupted: what the request would give is
/// continued, --discard or not.
fn unfinished(request: &RunRequest<'_>, out: &Path, args: &RunArgs) -> anyhow::Result<Unfinished> {
    Ok(match interrupted(out) {
        Ok(Some(left)) if left.finished > 0 && left.is_continued_by(request)? => Unfinished::Resume,
        _ if args.discard => Unfinished::Discard,
        // Refused with the difference.
        Ok(Some(left)) if left.finished > 0 => Unfinished::Resume,
        Ok(_) => Unfinished::Keep,
        Err(damaged) => return Err(damaged.into()),
    })
}

/// The results of one seed.
fn one(request: RunRequest<'_>) -> Result<Results, BenchError> {
    let seed = request.seed;
    if let FinishedBefore::Same(results) = FinishedBefore::of(&request)? {
        tell(&format!("seed {seed} is done already"));
        return Ok(*results);
    }
    tell(&format!("seed {seed}"));
    drive_with_progress(request)
}

/// The request for one seed, which may have a world or map of its own.
fn of_seed<'a>(
    request: &RunRequest<'a>,
    own: Option<&'a Prepared>,
    seed: u64,
    out: &'a Path,
) -> RunRequest<'a> {
    RunRequest {
        prepared: own.unwrap_or(request.prepared),
        seed,
        out: Some(out),
        ..*request
    }
}

/// Refuses to replace finished seeds of another run: they may have taken hours.
fn spare_other_runs(
    request: &RunRequest<'_>,
    world_of: WorldOfSeed<'_>,
    seeds: &[Seed],
) -> anyhow::Result<()> {
    // A folder that does not exist holds no run, and worlds take a while to build.
    for Seed { number, out } in seeds.iter().filter(|seed| seed.out.exists()) {
        let own = world_of(*number)?;
        let request = of_seed(request, own.as_ref(), *number, out);
        // What it replaces was agreed to when it was begun.
        let is_begun = match interrupted(out)? {
            Some(left) => left.finished > 0 && left.is_continued_by(&request)?,
            None => false,
        };
        if is_begun {
            continue;
        }
        if let FinishedBefore::Other { difference } = FinishedBefore::of(&request)? {
            anyhow::bail!(
                "{} has another run: {difference}; choose another folder with --out, or replace \
                 it with --discard",
                out.display()
            );
        }
    }
    Ok(())
}

fn finish(means: &Means, args: &RunArgs) -> anyhow::Result<Outcome> {
    let path = args.out.join(MEANS);
    write_atomically(&path, &written(means)?)?;
    if args.json {
        say_json(means)?;
    } else {
        say(&means_table(means))?;
    }
    tell(&format!("means: {}", path.display()));
    Ok(Outcome::Done)
}

/// The content of the file of means.
pub fn written(means: &Means) -> serde_json::Result<Vec<u8>> {
    let mut json = serde_json::to_vec_pretty(means)?;
    json.push(b'\n');
    Ok(json)
}
