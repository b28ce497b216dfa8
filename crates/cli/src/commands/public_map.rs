//! `openbench world map`: the public map of a suite, and what is wrong with it.

use anyhow::Context;
use openbench_bench::Prepared;
use openbench_bench::report::public_map_svg;
use openbench_bench::worlds::suite_of_seed;
use openbench_osm::write_atomically;

use crate::args::PublicMapArgs;
use crate::commands::run::set_conditions;
use crate::outcome::{Outcome, say};

/// Draws the public map over the world.
pub fn public_map(args: &PublicMapArgs) -> anyhow::Result<Outcome> {
    let mut suite = suite_of_seed(&args.suite, args.seed)?;
    set_conditions(&mut suite, &args.conditions)?;
    let prepared = Prepared::new(suite.with_seed(args.noise_seed.unwrap_or(args.seed)), None)?;
    let svg = public_map_svg(&prepared).context("the map has no buildings to draw")?;
    write_atomically(&args.out, svg.as_bytes())?;
    if let Some(osm) = &args.osm {
        write_atomically(osm, &prepared.public_data().to_xml())?;
    }
    let drawn = prepared.on_map().drawn();
    let what = drawn.map_or("the public map is right".to_owned(), |map| map.describe());
    say(&format!("{what}; picture in {}\n", args.out.display()))?;
    Ok(Outcome::Done)
}
