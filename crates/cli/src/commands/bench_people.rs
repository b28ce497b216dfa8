//! `openbench bench people`

use std::fmt::Write as _;

use openbench_agents::open::{Catalogue, settings};
use openbench_bench::worlds::suite_named;
use openbench_bench::{Prepared, TrafficPlan};
use openbench_motion::local::make_planner;
use openbench_trials::motion::people::{PeopleRequest, PeopleResult, drive, drives};

use crate::args::BenchPeopleArgs;
use crate::outcome::{Outcome, say, say_json, tell};
use crate::progress::progress_bar;

/// Most collisions that the table lists by themselves.
const SHOWN: usize = 20;

/// Drives among people, once for each number of them.
pub fn run(args: &BenchPeopleArgs, parts: &Catalogue) -> anyhow::Result<Outcome> {
    let planner = parts.local_planner(&args.planner)?;
    let request = PeopleRequest {
        kilometres: args.km,
        seed: args.seed,
        planner: &|robot| make_planner(&planner, &settings::planning(robot)).map_err(Into::into),
        threads: usize::from(args.jobs),
    };
    let bar = progress_bar(args.pedestrians.len() * drives(args.km), "drives");
    let mut rows = Vec::new();
    for &pedestrians in &args.pedestrians {
        let mut suite = suite_named(&args.world)?;
        suite.traffic = TrafficPlan {
            pedestrians: usize::from(pedestrians),
            cars: usize::from(args.cars),
        };
        let prepared = Prepared::world_of(suite)?;
        prepared.warnings().iter().for_each(|w| tell(w));
        rows.push(drive(&prepared, &request, &mut || bar.inc(1))?);
    }
    bar.finish_and_clear();
    if args.json {
        say_json(&rows)?
    } else {
        say(&table(&rows))?
    }
    Ok(Outcome::Done)
}

fn table(rows: &[PeopleResult]) -> String {
    let mut text = String::from(
        "people  cars     km  hours  doors reached  given up  collisions  driven into  cut off  \
         near misses/km  stops/km\n",
    );
    for row in rows {
        let total = |count: fn(&openbench_bench::score::metrics::CollisionSum) -> usize| {
            row.collisions.values().map(count).sum::<usize>()
        };
        let km = row.metres / 1000.0;
        let each = |count: usize| if km > 0.0 { count as f64 / km } else { 0.0 };
        let near = row.encounters.near_misses_people + row.encounters.near_misses_cars;
        let _ = writeln!(
            text,
            "{:6}  {:4}  {km:5.2}  {:5.1}  {:13}  {:8}  {:10}  {:11}  {:7}  {:14.1}  {:8.0}",
            row.traffic.pedestrians,
            row.traffic.cars,
            row.seconds / 3600.0,
            row.reached,
            row.given_up,
            total(|c| c.count),
            total(|c| c.driven_into),
            total(|c| c.cut_off),
            each(near),
            each(row.smoothness.stops),
        );
    }
    text.push_str(
        "\nDriven into: the robot was faster than 5 cm/s. Cut off: it stood, but had entered the \
         other's path within the braking distance.\n",
    );
    let worst = rows
        .iter()
        .flat_map(|row| row.bumps.iter().map(move |bump| (row, bump)));
    for (row, bump) in worst.filter(|(_, bump)| bump.at_fault).take(SHOWN) {
        let _ = writeln!(
            text,
            "  among {:3}, drive {:2}, {:7.2} s: {} at {:.2} m/s, ({:.1}, {:.1})",
            row.traffic.pedestrians,
            bump.drive,
            bump.seconds,
            bump.class,
            bump.speed_mps,
            bump.pose.x,
            bump.pose.y
        );
    }
    text
}
