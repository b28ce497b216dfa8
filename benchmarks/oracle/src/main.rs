//! Compares the pictures of `openbench_sim::render` with those that a Vulkan driver draws of the same triangles.
//!
//!     openbench-oracle                      # the built-in worlds
//!     openbench-oracle WORLD MAP MODELS     # and one from elsewhere

mod compare;
mod exact;
mod rasterizer;
mod views;

use std::process::ExitCode;
use std::sync::Arc;

use openbench_scene::generate::{builtin, builtin_names};
use openbench_scene::{ImportRequest, RayCaster, World, import_world};

use compare::{Both, Comparison};

/// Pixels of a frame that may differ.
const ALLOWED: usize = 5;
/// Frames of each built-in world, and of one from elsewhere.
const FRAMES: (usize, usize) = (12, 32);

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let elsewhere = match words.as_slice() {
        [] => None,
        [world, map, models] => {
            let models = vec![models.into()];
            let request = ImportRequest {
                world: world.into(),
                map: map.into(),
                models,
                georeference: None,
                start: None,
            };
            match import_world(&request) {
                Ok(world) => Some((world, FRAMES.1)),
                Err(error) => return bad_input(&error.to_string()),
            }
        }
        _ => return bad_input("usage: openbench-oracle [WORLD MAP MODELS]"),
    };
    let built_in = |name| {
        builtin(name, 1)
            .expect("a name of theirs")
            .expect("built-in worlds can be built")
    };
    let built_in = builtin_names().map(|name| (built_in(name), FRAMES.0));
    let mut all = Vec::new();
    for (world, frames) in elsewhere.into_iter().chain(built_in) {
        let Some(frames) = compare_world(world, frames) else {
            eprintln!(
                "skipped: no Vulkan driver draws on the processor (Debian: apt-get install mesa-vulkan-drivers)"
            );
            return ExitCode::SUCCESS;
        };
        all.extend(frames);
    }
    println!("all {} frames: {}", all.len(), summary(&all));
    let right = all.iter().all(|frame| frame.differing <= ALLOWED);
    if right {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn bad_input(problem: &str) -> ExitCode {
    eprintln!("{problem}");
    ExitCode::from(2)
}

/// Compares frames of a world and prints how; `None` if there is no driver.
fn compare_world(world: World, frames: usize) -> Option<Vec<Comparison>> {
    let views = views::views(&world, frames);
    let triangles = world.scene.triangles.len();
    let both = Both::new(RayCaster::new(Arc::new(world.scene)))?;
    println!(
        "{}: {triangles} triangles, {} frames, {}",
        world.name,
        views.len(),
        both.driver()
    );
    let mut compared = Vec::new();
    for (i, view) in views.iter().enumerate() {
        let frame = both.compare(view);
        println!(
            "  frame {i}: {} pixels covered, {} differ at once, {} through the lens ({} ours), {} ties, depths within {:.1e}",
            frame.covered, frame.at_once, frame.differing, frame.wrong, frame.ties, frame.depth
        );
        frame.described.iter().for_each(|d| println!("    {d}"));
        compared.push(frame);
    }
    println!("  {}", summary(&compared));
    Some(compared)
}

fn summary(frames: &[Comparison]) -> String {
    let median_and_worst = |count: fn(&Comparison) -> usize| {
        let mut counts: Vec<usize> = frames.iter().map(count).collect();
        counts.sort_unstable();
        (
            counts.get(counts.len() / 2).copied().unwrap_or(0),
            counts.last().copied().unwrap_or(0),
        )
    };
    let (at_once, through) = (
        median_and_worst(|f| f.at_once),
        median_and_worst(|f| f.differing),
    );
    let ours: usize = frames.iter().map(|f| f.wrong).sum();
    format!(
        "differing pixels a frame: median {}, worst {} at once; median {}, worst {} through the lens ({ours} ours in all); {ALLOWED} allowed",
        at_once.0, at_once.1, through.0, through.1
    )
}
