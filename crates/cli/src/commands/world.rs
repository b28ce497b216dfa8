//! `openbench world`

use std::path::Path;

use anyhow::Context;
use openbench_bench::plural::count;
use openbench_bench::worlds::Recipe;
use openbench_bench::worlds::folder::{DrawRequest, WrittenWorld, write};
use openbench_core::Image;
use openbench_neighbourhoods::draw;
use openbench_osm::default_georeference;
use openbench_scene::generate::GenerateOptions;
use openbench_scene::plates::contact_sheet;

use crate::args::{
    DrawArgs, GenerateArgs, ImportArgs, NeighbourhoodArgs, PlatesArgs, WorldArgs, WorldCommand,
};
use crate::commands::{
    public_map::public_map,
    read_data, read_part,
    show::{show, write_picture},
};
use crate::outcome::{Outcome, say, tell};
use crate::progress::doing_for_long;

/// JPEG quality of contact sheets.
const SHEET_QUALITY: u8 = 80;

/// Does what is asked with worlds.
pub fn run(args: &WorldArgs) -> anyhow::Result<Outcome> {
    match &args.command {
        WorldCommand::Generate(args) => generate(args),
        WorldCommand::Draw(args) => neighbourhood(args),
        WorldCommand::Import(args) => import(args),
        WorldCommand::Show(args) => show(args),
        WorldCommand::Map(args) => public_map(args),
        WorldCommand::Plates(args) => plates(args),
    }
}

/// Draws a contact sheet of door plates.
fn plates(args: &PlatesArgs) -> anyhow::Result<Outcome> {
    let sheet = contact_sheet(args.seed, args.count.into());
    let rgb = sheet
        .rgba
        .chunks_exact(4)
        .flat_map(|texel| texel[..3].to_vec());
    let image = Image {
        stamp: Default::default(),
        width: sheet.width,
        height: sheet.height,
        rgb: rgb.collect(),
    };
    write_picture(&args.out, image, SHEET_QUALITY)?;
    say(&format!(
        "{} plates of seed {}; picture in {}\n",
        args.count,
        args.seed,
        args.out.display()
    ))?;
    Ok(Outcome::Done)
}

fn generate(args: &GenerateArgs) -> anyhow::Result<Outcome> {
    refuse_inside(&args.map, &args.out)?;
    let (map, georeference) = read_part(&args.map, &args.cut)?;
    let file = args.map.display();
    let source = args.map.file_name().unwrap_or_default().to_string_lossy();
    let recipe = Recipe::Generated {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        name: args.name.clone().unwrap_or_else(|| folder_name(&args.out)),
        map: Recipe::map_file(),
        seed: args.seed,
        georeference: georeference.to_string(),
        start: args.start.map(|p| [p.x, p.y, p.yaw.to_degrees()]),
        parked_cars: args.parked_cars,
        planting: args.planting,
        invent_doors: !args.mapped_doors_only,
        attribution: vec![format!(
            "Map `{source}`: © OpenStreetMap contributors, ODbL 1.0, where it comes from there"
        )],
    };
    let request = draw_request(&args.drawn, args.seed);
    let written = doing_for_long(&format!("generating a world from {file}"), || {
        write(&args.out, &recipe, &map, request)
    });
    report(&written.with_context(|| file.to_string())?, &args.out)
}

fn neighbourhood(args: &NeighbourhoodArgs) -> anyhow::Result<Outcome> {
    let here = draw(args.kind, args.seed);
    let start = here.start;
    let options = GenerateOptions::default();
    let recipe = Recipe::Generated {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        name: here.name(),
        map: Recipe::map_file(),
        seed: args.seed,
        georeference: here.georeference.to_string(),
        start: Some([start.x, start.y, start.yaw.to_degrees()]),
        parked_cars: options.parked_cars,
        planting: options.planting,
        // The map has all doors.
        invent_doors: false,
        attribution: vec![here.attribution()],
    };
    let request = draw_request(&args.drawn, args.seed);
    let written = doing_for_long(&format!("drawing {}", here.name()), || {
        write(&args.out, &recipe, &here.map, request)
    });
    report(&written?, &args.out)
}

fn import(args: &ImportArgs) -> anyhow::Result<Outcome> {
    // Relative paths of a recipe count from its folder, those of the command line do not.
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    for input in [&args.map, &args.world] {
        refuse_inside(input, &args.out)?;
    }
    let map = read_data(&args.map)?;
    let georeference = match args.georef {
        Some(georeference) => georeference,
        None => default_georeference(&map).with_context(|| args.map.display().to_string())?,
    };
    let recipe = Recipe::Imported {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        name: args
            .world
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        world: absolute(&args.world),
        map: Recipe::map_file(),
        models: args.models.iter().map(|m| absolute(m)).collect(),
        georeference: georeference.to_string(),
        start: args.start.map(|p| [p.x, p.y, p.yaw.to_degrees()]),
    };
    let written = write(
        &args.out,
        &recipe,
        &map,
        draw_request(&args.drawn, args.seed),
    )?;
    report(&written, &args.out)
}

/// Refuses to replace a folder that holds what the world is made from.
fn refuse_inside(input: &Path, out: &Path) -> anyhow::Result<()> {
    let (Ok(input), Ok(folder)) = (input.canonicalize(), out.canonicalize()) else {
        // A missing input is reported where it is read, and a new folder holds nothing.
        return Ok(());
    };
    // A file in place of the folder is refused where the folder is written.
    if folder.is_dir() && input.starts_with(&folder) {
        anyhow::bail!(
            "{} lies in {}, which the world replaces; choose another folder with --out",
            input.display(),
            out.display()
        );
    }
    Ok(())
}

fn draw_request(drawn: &DrawArgs, seed: u64) -> DrawRequest {
    let drawn_count = |i: usize| drawn.draw.get(i).map_or(0, |n| usize::from(*n));
    DrawRequest {
        singles: drawn_count(0),
        sequences: drawn_count(1),
        sequence_length: drawn_count(2),
        max_distance_m: drawn.reach,
        seed,
    }
}

fn report(written: &WrittenWorld, out: &Path) -> anyhow::Result<Outcome> {
    let (world, suite) = (&written.prepared.world, &written.prepared.suite);
    world.warnings.iter().for_each(|w| tell(w));
    say(&format!(
        "{}: {} triangles, {} doors, {} reachable, {} to deliver to; {} in {}\n",
        world.name,
        world.scene.triangles.len(),
        world.scene.doors.len(),
        written.reachable,
        written.candidates,
        count(suite.episodes.len(), "episode", "episodes"),
        out.display()
    ))?;
    Ok(Outcome::Done)
}

fn folder_name(path: &Path) -> String {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    absolute
        .file_name()
        .map_or("generated".into(), |n| n.to_string_lossy().into_owned())
}
