//! `openbench bench`

use openbench_bench::speed::sim::{SimSpeed, measure};
use openbench_bench::{TrafficPlan, WorldSource};

use crate::args::{BenchArgs, BenchCommand, BenchSimArgs};
use crate::outcome::{Outcome, say, say_json};

/// Measures what is asked for.
pub fn run(args: &BenchArgs) -> anyhow::Result<Outcome> {
    match &args.command {
        BenchCommand::Sim(args) => sim(args),
    }
}

fn sim(args: &BenchSimArgs) -> anyhow::Result<Outcome> {
    let source = match (&args.world, &args.map) {
        (Some(world), Some(map)) => WorldSource::Imported {
            world: world.clone(),
            map: map.clone(),
            models: args.models.clone(),
            georeference: args.georef.clone(),
        },
        _ => WorldSource::Builtin { name: args.name.clone(), seed: 1 },
    };
    let plan = TrafficPlan { pedestrians: args.pedestrians.into(), cars: args.cars.into() };
    let speed = measure(&source, plan, args.dump.as_deref())?;
    if args.json {
        say_json(&speed)?;
    } else {
        say(&table(&speed))?;
    }
    Ok(Outcome::Done)
}

fn table(speed: &SimSpeed) -> String {
    let memory = speed.peak_memory_mb.map_or("unknown".to_owned(), |mb| format!("{mb:.0} MB"));
    format!(
        "{}, {} triangles, {} people and {} cars, one core\n\
         LiDAR          {:8.2} million rays a second, noise and points included\n\
         casting alone  {:8.2} million rays a second\n\
         camera         {:8.1} images of 640 x 480 a second\n\
         with LiDAR     {:8.1} x real time\n\
         and images     {:8.1} x real time, ten a second\n\
         loading        {:8.2} s\n\
         memory         {memory:>8}\n",
        speed.world,
        speed.triangles,
        speed.pedestrians,
        speed.cars,
        speed.lidar_mrays_per_core_second,
        speed.cast_mrays_per_core_second,
        speed.camera_fps_per_core,
        speed.rtf_lidar,
        speed.rtf_camera,
        speed.load_seconds,
    )
}
