//! `openbench bench health`

use std::fmt::Write as _;
use std::time::Duration;

use openbench_agents::open::Catalogue;
use openbench_agents::open::parts::Situation;
use openbench_bench::Prepared;
use openbench_bench::worlds::suite_named;
use openbench_core::RobotDescription;
use openbench_trials::degraded::{DegradedResult, trials};

use crate::args::BenchHealthArgs;
use crate::outcome::{Outcome, say, say_json, tell};

/// Drives with each kind of trouble.
pub fn run(args: &BenchHealthArgs, parts: &Catalogue) -> anyhow::Result<Outcome> {
    let localizer = parts.localizer(&args.localizer, None)?;
    let prepared = Prepared::world_of(suite_named(&args.world)?)?;
    prepared.warnings().iter().for_each(|w| tell(w));
    let robot = RobotDescription::sentry();
    let make = || localizer(&Situation::without_map(&robot));
    let time = Duration::from_secs_f64(args.minutes * 60.0);
    let trials = trials(&prepared, args.seed, time, usize::from(args.jobs), &make)?;
    if args.json {
        say_json(&trials)?;
    } else {
        say(&table(&trials))?;
    }
    Ok(Outcome::Done)
}

fn table(trials: &[DegradedResult]) -> String {
    let mut text = format!(
        "{:<40}  {:>8}  {:>8}  {:>12}  {:>6}  {:>6}  {:>6}\n",
        "degradation", "rms m", "largest", "called good", "good %", "lost %", "silent"
    );
    for trial in trials {
        let number =
            |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("{value:.3}"));
        let _ = writeln!(
            text,
            "{:<40}  {:>8}  {:>8}  {:>12.3}  {:>6.1}  {:>6.1}  {:>6}",
            trial.degradation.to_string(),
            number(trial.errors.map(|errors| errors.rmse_m)),
            number(trial.errors.map(|errors| errors.max_m)),
            trial.largest_good_m,
            trial.good * 100.0,
            trial.lost * 100.0,
            trial.errors.map_or(0, |errors| errors.silent_divergences)
        );
    }
    text.push_str(
        "\nErrors in metres. Called good: largest error of a pose with good health. Silent: number \
         of times that\nthe error came to exceed a metre with good health.\n",
    );
    text
}
