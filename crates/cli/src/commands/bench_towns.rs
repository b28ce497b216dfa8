//! `openbench bench towns`

use std::collections::BTreeMap;
use std::fmt::Write as _;

use openbench_bench::Agents;
use openbench_core::{FailureCause, LonLat};
use openbench_trials::towns::{
    DrawnWindow, PoseSum, Town, Towns, TownsPlan, TownsRequest, draw, run as run_towns,
};

use crate::args::BenchTownsArgs;
use crate::commands::run::{agent_named, check_agent, prepare_agent};
use crate::outcome::{Outcome, say, say_json, tell};
use crate::progress::progress_bar;

/// Delivers in neighbourhoods that a seed draws.
pub fn run(args: &BenchTownsArgs, agents: &Agents) -> anyhow::Result<Outcome> {
    let factory = agent_named(agents, &args.agent)?;
    let factory = factory.as_ref();
    let settings: BTreeMap<String, String> = args.settings.iter().cloned().collect();
    // With --draw nothing is driven, so nothing needs to be downloaded.
    if !args.draw {
        check_agent(factory, &settings)?;
        prepare_agent(factory, &settings)?;
    }
    // The folder keeps the plan, which must be equal in a continued run, from whichever folder that
    // is started.
    let absolute =
        |path: &std::path::PathBuf| std::path::absolute(path).unwrap_or_else(|_| path.clone());
    let plan = TownsPlan {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        maps: args.maps.iter().map(absolute).collect(),
        radius: args.radius,
        seed: args.seed,
        false_origin: args.false_origin * 1000.0,
        agent: args.agent.clone(),
        settings,
    };
    let windows = usize::from(args.windows);
    if args.draw {
        return draw_only(&plan, windows, args);
    }
    let bar = progress_bar(windows, "towns");
    let request = TownsRequest {
        plan: &plan,
        windows,
        factory,
        build: &crate::build(),
        jobs: usize::from(args.jobs),
        out: &args.out,
        progress: &|town, was_done| {
            bar.inc(1);
            let again = if was_done { " (done before)" } else { "" };
            bar.suspend(|| tell(&format!("{}{again}", line(town).trim_end())));
        },
    };
    let towns = run_towns(&request)?;
    bar.finish_and_clear();
    tell_of_room(towns.towns.len(), windows);
    if args.json {
        say_json(&towns)?;
    } else {
        say(&table(&towns))?;
    }
    tell(&format!(
        "reports: {}",
        args.out.join("*/run/report.html").display()
    ));
    Ok(Outcome::Done)
}

fn draw_only(plan: &TownsPlan, windows: usize, args: &BenchTownsArgs) -> anyhow::Result<Outcome> {
    let drawn = draw(plan, windows, &args.out)?;
    tell_of_room(drawn.len(), windows);
    if args.json {
        say_json(&drawn)?;
    } else {
        let line = |DrawnWindow { place, world }: &DrawnWindow| {
            let LonLat { lon, lat } = place.around;
            format!(
                "{:<22}  {lon:9.5}  {lat:9.5}  {}\n",
                place.name,
                world.display()
            )
        };
        say(&drawn.iter().map(line).collect::<String>())?;
    }
    Ok(Outcome::Done)
}

fn tell_of_room(found: usize, wanted: usize) {
    if found < wanted {
        tell(&format!(
            "the maps have room for {found} windows that do not overlap, of {wanted}"
        ));
    }
}

const HEAD: &str = "window                    SR   SPL   LSR  pose 95 %  largest  silent  \
                    odometry  NEES  coll     x  failures\n";

fn table(towns: &Towns) -> String {
    let mut text = HEAD.to_owned();
    towns
        .towns
        .iter()
        .for_each(|town| text.push_str(&line(town)));
    let Towns {
        metrics,
        failures,
        silent_divergences,
        ..
    } = towns;
    let _ = writeln!(
        text,
        "{:<22}  {}  {}  {}  {}  {silent_divergences:>6}  {:>8}  {:>4}  {:>4}  {}  {}",
        "all",
        percent(metrics.sr_2m),
        percent(metrics.spl),
        percent(metrics.lsr),
        pose(towns.pose),
        // Odometry errors of different drives are not summed up.
        "",
        "",
        metrics.collisions,
        factor(metrics.real_time_factor),
        causes(failures)
    );
    let interval = |name: &str| {
        let found = metrics.intervals.get(name).copied().flatten();
        found.map_or("–".to_owned(), |[low, high]| {
            format!("{:.0} to {:.0}", low * 100.0, high * 100.0)
        })
    };
    let deliveries: usize = towns
        .towns
        .iter()
        .map(|town| town.results.deliveries.len())
        .sum();
    let rms = towns
        .pose
        .map_or("–".to_owned(), |pose| format!("{:.3} m", pose.rms_m));
    let _ = writeln!(
        text,
        "\n{deliveries} deliveries; pose {rms} rms; 95 % intervals: SR {}, SPL {}, LSR {}\n\
         SR, SPL, LSR: percent, strict reading. Pose and odometry: metres; odometry over a drive \
         of 3 minutes.\nNEES: 6 if the covariance is right. Silent: divergences of more than a \
         metre \
         with good health.\nx: real-time factor of one core.",
        interval("sr_2m"),
        interval("spl"),
        interval("lsr")
    );
    text
}

fn line(town: &Town) -> String {
    let metrics = &town.results.metrics;
    let silent = metrics.localization.map_or(0, |sum| sum.silent_divergences);
    let nees = town
        .odometry
        .nees
        .map_or("–".to_owned(), |nees| format!("{:.1}", nees.mean));
    format!(
        "{:<22}  {}  {}  {}  {}  {silent:>6}  {:>8.4}  {nees:>4}  {:>4}  {}  {}\n",
        town.place.name,
        percent(metrics.sr_2m),
        percent(metrics.spl),
        percent(metrics.lsr),
        pose(PoseSum::of(&town.pose_errors)),
        town.odometry.rms_m,
        metrics.collisions,
        factor(metrics.real_time_factor),
        causes(&town.failures())
    )
}

fn percent(share: Option<f64>) -> String {
    share.map_or("   –".to_owned(), |share| {
        format!("{:4.0}", share * 100.0)
    })
}

fn factor(real_time: Option<f64>) -> String {
    real_time.map_or("   –".to_owned(), |factor| format!("{factor:4.1}"))
}

fn pose(sum: Option<PoseSum>) -> String {
    sum.map_or(format!("{:>9}  {:>7}", "–", "–"), |sum| {
        format!("{:9.3}  {:7.3}", sum.p95_m, sum.max_m)
    })
}

fn causes(failures: &BTreeMap<FailureCause, usize>) -> String {
    let words: Vec<String> = failures
        .iter()
        .map(|(cause, count)| format!("{count} {cause}"))
        .collect();
    words.join(", ")
}
