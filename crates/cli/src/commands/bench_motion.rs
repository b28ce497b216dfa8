//! `openbench bench motion`

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Context as _;
use openbench_core::RobotDescription;
use openbench_trials::motion::comparison::{
    Comparison, ComparisonRequest, PlannerDrive, Row, SceneOutcome, compare, planners,
};
use openbench_trials::motion::picture::picture;

use crate::Extensions;
use crate::args::BenchMotionArgs;
use crate::outcome::{Outcome, say, say_json};
use crate::progress::progress_bar;

/// Most drives that the table lists by themselves.
const SHOWN: usize = 20;

/// Drives planners through scenes.
pub fn run(args: &BenchMotionArgs, extensions: &Extensions) -> anyhow::Result<Outcome> {
    // The planners of the comparison, not those of OPEN: some have tolerances of their own here.
    let known = extensions.planners_beside(planners());
    let planners = known.select(&args.planners)?;
    let request = ComparisonRequest {
        first: args.first as usize,
        count: args.scenes as usize,
        seed: args.seed,
        planners: &planners,
        threads: usize::from(args.jobs),
    };
    if let Some(folder) = &args.pictures {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    let bar = progress_bar(request.count, "scenes");
    let robot = RobotDescription::sentry();
    let comparison = compare(&request, &robot, &mut |outcome| {
        bar.inc(1);
        match &args.pictures {
            Some(folder) => draw(folder, outcome, &robot),
            None => Ok(()),
        }
    });
    // Before an error is returned, so that its message begins on an empty line.
    bar.finish_and_clear();
    let comparison = comparison?;
    if args.json {
        say_json(&comparison)?
    } else {
        say(&table(&comparison))?
    }
    Ok(Outcome::Done)
}

fn draw(folder: &Path, outcome: &SceneOutcome, robot: &RobotDescription) -> anyhow::Result<()> {
    for PlannerDrive { planner, drive } in &outcome.drives {
        let Some(scene) = &outcome.scene else {
            continue;
        };
        let name = format!("{:05}_{}.svg", outcome.number, planner.name());
        openbench_osm::write_atomically(
            &folder.join(name),
            picture(scene, drive, robot).as_bytes(),
        )?;
    }
    Ok(())
}

fn table(comparison: &Comparison) -> String {
    let mut text = format!(
        "{} scenes of seed {}; for {} more neither a motion nor a proof was found\n\n\
         planner   feasible  reached  collisions  refused    cycle ms p50   p99  time ratio   max  \
         slow  swerves   max\n",
        comparison.scenes, comparison.seed, comparison.undecided
    );
    for (planner, row) in &comparison.planners {
        line(&mut text, planner.name(), row);
    }
    for (planner, kinds) in &comparison.kinds {
        let _ = write!(text, "\n{}\n", planner.name());
        for (kind, row) in kinds {
            line(&mut text, kind.name(), row);
        }
    }
    if !comparison.failures.is_empty() {
        text.push_str("\nFailures:\n");
    }
    for failure in comparison.failures.iter().take(SHOWN) {
        let (who, what) = (failure.planner.name(), &failure.what);
        let _ = writeln!(
            text,
            "  scene {:4} {:10} {who:8}  {what}",
            failure.scene,
            failure.kind.name()
        );
    }
    if let Some(more) = comparison
        .failures
        .len()
        .checked_sub(SHOWN)
        .filter(|more| *more > 0)
    {
        let _ = writeln!(text, "  and {more} more, which --json lists");
    }
    text
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
}

fn line(text: &mut String, name: &str, row: &Row) {
    let _ = writeln!(
        text,
        "{name:10}{:8}  {:7}  {:10}  {:3} of {:3}  {:11.2}  {:5.2}  {:>10}  {:>4}  {:4}  {:>7}  \
         {:4}",
        row.feasible,
        row.reached,
        row.collisions,
        row.refused,
        row.infeasible,
        row.cycle_ms_p50,
        row.cycle_ms_p99,
        number(row.time_ratio_mean, 2),
        number(row.time_ratio_max, 2),
        row.slow,
        number(row.swerves_mean, 1),
        row.swerves_max
    );
}
