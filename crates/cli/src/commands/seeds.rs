//! `openbench run --seeds`: a suite with several seeds, and the means over them.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use openbench_bench::report::means_table;
use openbench_bench::score::across::{Means, System, means};
use openbench_bench::{BenchError, Results, RunRequest, Unfinished, done_before, interrupted};
use openbench_osm::write_atomically;

use super::driving::drive_with_progress;
use crate::args::RunArgs;
use crate::outcome::{Outcome, say, say_json, tell};
use crate::signals::StopSignal;

/// Runs the request with each seed, in a folder for each. What is done already is kept, so the same
/// command continues after an interruption.
pub fn drive_each(
    seeds: &RangeInclusive<u64>,
    request: &RunRequest<'_>,
    args: &RunArgs,
    stop: &StopSignal,
) -> anyhow::Result<Outcome> {
    refuse_single_run(&args.out)?;
    let mut runs = Vec::new();
    for seed in seeds.clone() {
        let out = folder(&args.out, seed);
        let request = RunRequest {
            seed,
            out: Some(&out),
            unfinished: unfinished(&out, args)?,
            ..*request
        };
        match one(request) {
            Err(BenchError::Interrupted) => {
                tell(&format!(
                    "stopped; {} of {} seeds are finished; the same command continues, \
                     without --discard if it has that",
                    runs.len(),
                    seeds.clone().count()
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

fn folder(out: &Path, seed: u64) -> PathBuf {
    out.join(format!("seed-{seed}"))
}

/// What is done with the remains of a seed that was interrupted.
fn unfinished(out: &Path, args: &RunArgs) -> Result<Unfinished, BenchError> {
    if args.discard {
        return Ok(Unfinished::Discard);
    }
    let left = interrupted(out)?.filter(|left| left.finished > 0);
    Ok(left.map_or(Unfinished::Keep, |_| Unfinished::Resume))
}

/// The results of one seed.
fn one(request: RunRequest<'_>) -> Result<Results, BenchError> {
    let seed = request.seed;
    if let Some(results) = done_before(&request)? {
        tell(&format!("seed {seed} is done already"));
        return Ok(results);
    }
    tell(&format!("seed {seed}"));
    drive_with_progress(request)
}

fn finish(means: &Means, args: &RunArgs) -> anyhow::Result<Outcome> {
    let path = args.out.join("means.json");
    let mut json = serde_json::to_vec_pretty(means)?;
    json.push(b'\n');
    write_atomically(&path, &json)?;
    if args.json {
        say_json(means)?;
    } else {
        say(&means_table(means))?;
    }
    tell(&format!("means: {}", path.display()));
    Ok(Outcome::Done)
}
