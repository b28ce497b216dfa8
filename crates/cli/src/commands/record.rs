//! `openbench record`: drives for the sake of their logs.

use std::ops::ControlFlow;
use std::time::Duration;

use openbench_bench::run::recorder::Recorder;
use openbench_bench::worlds::suite_of_seed;
use openbench_bench::{Faults, ImuRange, Level, Prepared};
use openbench_core::SimTime;
use openbench_trials::tour::{STANDSTILL, Style, Tour, drive};

use crate::args::RecordArgs;
use crate::outcome::{Outcome, tell};
use crate::progress::progress_bar;

/// Drives and records.
pub fn run(args: &RecordArgs) -> anyhow::Result<Outcome> {
    let mut suite = suite_of_seed(&args.world, args.seed)?;
    let seed = args.noise_seed.unwrap_or(args.seed);
    for (asked, planned) in [
        (args.pedestrians, &mut suite.traffic.pedestrians),
        (args.cars, &mut suite.traffic.cars),
    ] {
        *planned = asked.map_or(*planned, usize::from);
    }
    let prepared = Prepared::world_of(suite.with_seed(seed))?;
    prepared.warnings().iter().for_each(|w| tell(w));
    // A billion seconds: an instant, nanoseconds in 64 bits, holds the sum of two of them.
    let at = |seconds: f64| SimTime::ZERO + Duration::from_secs_f64(seconds.min(1e9));
    let faults = Faults {
        gap: args.gap.map(|(from, long)| [at(from), at(from + long)]),
        imu_range: args
            .imu_range
            .map(|(rate, acceleration)| ImuRange { rate, acceleration }),
    };
    let tour = Tour {
        time: Duration::from_secs_f64(args.minutes * 60.0),
        via: args.via.clone(),
        style: if args.wild {
            Style::Wild
        } else {
            Style::Smooth
        },
        seed,
        standstill: STANDSTILL,
    };
    let recorder = Recorder::create(&args.out, Level::Full, &prepared)?;
    let mut recorder = recorder.with_faults(faults);
    let bar = progress_bar(tour.time.as_secs() as usize, "driving");
    let driven = drive(&prepared, &tour, &mut |simulator, velocity| {
        bar.set_position(simulator.time().seconds() as u64);
        recorder.step(simulator, velocity)?;
        Ok(ControlFlow::Continue(()))
    })?;
    recorder.finish()?;
    bar.finish_and_clear();
    tell(&format!(
        "{}: {:.0} m in {:.0} s, {} bumps",
        args.out.display(),
        driven.metres,
        tour.time.as_secs_f64(),
        driven.collisions
    ));
    Ok(Outcome::Done)
}
