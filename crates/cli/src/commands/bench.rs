//! `openbench bench`

use std::path::Path;

use anyhow::Context;
use cpu_time::ProcessTime;
use openbench_bench::TrafficPlan;
use openbench_bench::worlds::source_named;
use openbench_localization::graph::{GraphSize, PoseGraph};
use openbench_routing::Profile;
use openbench_trials::speed::routing::{RoutingSpeed, measure as measure_routing, read_pairs};
use openbench_trials::speed::sim::{SimSpeed, measure};
use serde::Serialize;

use crate::Extensions;
use crate::args::{BenchArgs, BenchCommand, BenchPosegraphArgs, BenchRoutingArgs, BenchSimArgs};
use crate::commands::{
    bench_health, bench_localization, bench_motion, bench_people, bench_towns, spare_inputs,
};
use crate::outcome::{Outcome, say, say_json};

/// Measures what is asked for.
pub fn run(args: &BenchArgs, extensions: &Extensions) -> anyhow::Result<Outcome> {
    match &args.command {
        BenchCommand::Sim(args) => sim(args),
        BenchCommand::Routing(args) => routing(args),
        BenchCommand::Posegraph(args) => posegraph(args),
        BenchCommand::Motion(args) => bench_motion::run(args, extensions),
        BenchCommand::People(args) => bench_people::run(args, extensions.parts()),
        BenchCommand::Localization(args) => bench_localization::run(args),
        BenchCommand::Health(args) => bench_health::run(args, extensions.parts()),
        BenchCommand::Towns(args) => bench_towns::run(args, &extensions.agents()),
    }
}

/// What a graph came to.
#[derive(Debug, Serialize)]
struct GraphSolved {
    /// The sum of squared residuals in deviations.
    chi2: f64,
    /// CPU time of solving, without reading.
    seconds: f64,
    vertices: usize,
    edges: usize,
    steps: usize,
}

fn posegraph(args: &BenchPosegraphArgs) -> anyhow::Result<Outcome> {
    spare_inputs(&[&args.graph], args.out.as_deref().as_slice())?;
    let file = || args.graph.display().to_string();
    let text = openbench_core::input::read_text(&args.graph).with_context(file)?;
    let mut graph = PoseGraph::parse(&text).with_context(file)?;
    let GraphSize {
        poses: vertices,
        edges,
    } = graph.size();
    let began = ProcessTime::now();
    let solved = graph.solve().with_context(file)?;
    let seconds = began.elapsed().as_secs_f64();
    if let Some(path) = &args.out {
        openbench_osm::write_atomically(path, graph.to_text().as_bytes())?;
    }
    let result = GraphSolved {
        chi2: solved.chi2,
        seconds,
        vertices,
        edges,
        steps: solved.steps,
    };
    if args.json {
        say_json(&result)?;
    } else {
        say(&format!(
            "{vertices} poses, {edges} edges: chi2 {:.6} after {} steps, {seconds:.3} s\n",
            result.chi2, result.steps
        ))?;
    }
    Ok(Outcome::Done)
}

fn routing(args: &BenchRoutingArgs) -> anyhow::Result<Outcome> {
    let read = [&args.roads.map, &args.pairs, Path::new(&args.roads.profile)];
    spare_inputs(&read, args.answers.as_deref().as_slice())?;
    let profile = Profile::open(&args.roads.profile)?;
    let pairs = read_pairs(&args.pairs)?;
    let speed = measure_routing(&args.roads.map, profile, &pairs, args.dump.as_deref())?;
    if let Some(path) = &args.answers {
        let rows = speed
            .answers
            .iter()
            .map(|answer| format!("{:.1},{:.2}\n", answer.distance_m, answer.duration_s));
        let text = format!("distance_m,duration_s\n{}", rows.collect::<String>());
        openbench_osm::write_atomically(path, text.as_bytes())?;
    }
    if args.json {
        say_json(&speed)?;
    } else {
        say(&routing_table(&speed))?;
    }
    Ok(Outcome::Done)
}

fn routing_table(speed: &RoutingSpeed) -> String {
    let memory = speed
        .peak_memory_mb
        .map_or("unknown".to_owned(), |mb| format!("{mb:.0} MB"));
    format!(
        "{} vertices, {} edges, {} pairs, {} without a way; CPU time of one thread\n\
         route            {:9.0} us, and {:.0} us in one case of 100\n\
         with steps       {:9.0} us, and {:.0} us: JSON with every turn and point\n\
         nearest          {:9.1} us, and {:.1} us\n\
         table 100 x 100  {:9.1} ms\n\
         building         {:9.2} s, from the file until routes are found\n\
         customizing      {:9.3} s, when the profile has changed\n\
         memory           {memory:>9}\n",
        speed.vertices,
        speed.edges,
        speed.pairs,
        speed.pairs_without_route,
        speed.route_us_p50,
        speed.route_us_p99,
        speed.steps_us_p50,
        speed.steps_us_p99,
        speed.nearest_us_p50,
        speed.nearest_us_p99,
        speed.table_100_ms,
        speed.build_seconds,
        speed.customize_seconds,
    )
}

fn sim(args: &BenchSimArgs) -> anyhow::Result<Outcome> {
    let imported = args.imported.source();
    let source = imported.unwrap_or_else(|| source_named(&args.name));
    let plan = TrafficPlan {
        pedestrians: args.pedestrians.into(),
        cars: args.cars.into(),
    };
    let speed = measure(&source, plan, args.dump.as_deref())?;
    if args.json {
        say_json(&speed)?;
    } else {
        say(&table(&speed))?;
    }
    Ok(Outcome::Done)
}

fn table(speed: &SimSpeed) -> String {
    let memory = speed
        .peak_memory_mb
        .map_or("unknown".to_owned(), |mb| format!("{mb:.0} MB"));
    format!(
        "{}, {} triangles, {} people and {} cars, one core\n\
         LiDAR          {:8.2} million rays a second, noise and points included\n\
         real LiDAR     {:8.2} the same with mixed pixels, panes, ghosts and rain\n\
         casting alone  {:8.2} million rays a second\n\
         camera         {:8.1} images of 640 x 480 a second\n\
         cheap, by day  {:8.1} the same with noise, blur, rolling shutter and shadows\n\
         cheap, night   {:8.1} the same at night, with 30 lamps\n\
         with LiDAR     {:8.1} x real time\n\
         and images     {:8.1} x real time, ten a second\n\
         loading        {:8.2} s\n\
         memory         {memory:>8}\n",
        speed.world,
        speed.triangles,
        speed.pedestrians,
        speed.cars,
        speed.lidar_mrays_per_core_second,
        speed.real_lidar_mrays_per_core_second,
        speed.cast_mrays_per_core_second,
        speed.camera_fps_per_core,
        speed.camera_day_fps_per_core,
        speed.camera_night_fps_per_core,
        speed.rtf_lidar,
        speed.rtf_camera,
        speed.load_seconds,
    )
}
