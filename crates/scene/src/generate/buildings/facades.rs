//! Walls of buildings: plinth, bands between storeys, corner stones, downpipes. Windows and shops
//! are built by [`windows`](super::windows).

use std::ops::Range;

use openbench_geometry::{Polygon, Segment};
use rand_pcg::Pcg64Mcg;

use super::house::{House, PARAPET_M, RELIEF_M, Roof};
use super::windows;
use crate::generate::doors::doorway::Doorway;
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::BUILDING;
use crate::generate::output::Output;
use crate::generate::shapes::{panel, wall};
use crate::scene::Layer;

/// Height of the plinth, metres.
const PLINTH_M: f64 = 0.5;
/// Width of corner stones, metres.
const QUOIN_WIDTH_M: f64 = 0.38;
/// Width of a downpipe, metres.
const PIPE_WIDTH_M: f64 = 0.09;
/// A wall that is shorter has neither windows nor ornaments, metres.
const SHORTEST_M: f64 = 1.6;
/// A wall of a part that is lower has no windows, metres.
const LOWEST_M: f64 = 2.2;

/// Builds a wall that stands on the ground.
pub(super) fn build(
    inputs: &Inputs,
    out: &mut Output,
    house: &House,
    line: Segment,
    doors: &[Doorway],
    rng: &mut Pcg64Mcg,
) {
    bare_wall(out, house, line);
    // On a low wall, at most a quarter of it.
    let plinth = 0.0..PLINTH_M.min(house.eaves / 4.0);
    wall(
        &mut out.scene,
        Layer::Visible,
        house.plinth,
        raised(line, RELIEF_M),
        plinth,
    );
    // Windows on a party wall would be seen by nobody, and cost triangles.
    let is_bare = house.plain || out.is_full() || line.length() < SHORTEST_M;
    if is_bare || is_party_wall(inputs, line) {
        return;
    }
    let spans: Vec<Range<f64>> = doors.iter().filter_map(|d| d.span_on(line)).collect();
    ornaments(inputs, out, house, line, &spans);
    windows::build(inputs, out, house, line, &spans, 0.0, rng);
}

/// Builds a wall of a part that stands on another part of the building with this `outline`; other
/// parts hide it up to `hidden` metres.
pub(super) fn build_above(
    inputs: &Inputs,
    out: &mut Output,
    house: &House,
    line: Segment,
    outline: &Polygon,
    hidden: f64,
    rng: &mut Pcg64Mcg,
) {
    bare_wall(out, house, line);
    let is_low = house.eaves - house.foot < LOWEST_M;
    if house.plain || out.is_full() || is_low || line.length() < SHORTEST_M {
        return;
    }
    // A part's wall may look over the roof of its own building, which also counts as a building
    // before it.
    let is_inside = outline.contains(line.middle().offset(line.outward(), 0.4));
    if is_inside || !is_party_wall(inputs, line) {
        windows::build(inputs, out, house, line, &[], hidden, rng);
    }
}

fn bare_wall(out: &mut Output, house: &House, line: Segment) {
    let parapet = if house.roof == Roof::Flat {
        PARAPET_M
    } else {
        0.0
    };
    // A robot collides only with walls that stand on the ground.
    let layer = if house.foot == 0.0 {
        Layer::Both
    } else {
        Layer::Visible
    };
    let z = house.foot..house.eaves + parapet;
    wall(&mut out.scene, layer, house.facade, line, z);
}

fn ornaments(
    inputs: &Inputs,
    out: &mut Output,
    house: &House,
    line: Segment,
    doors: &[Range<f64>],
) {
    bands(out, house, line);
    let length = line.length();
    let is_free = |span: &Range<f64>| {
        doors
            .iter()
            .all(|d| span.end < d.start || span.start > d.end)
    };
    if house.quoins && length > 3.0 {
        for span in [0.0..QUOIN_WIDTH_M, length - QUOIN_WIDTH_M..length] {
            // Corner stones leave room for a door and its plate.
            if is_free(&span) {
                let stones = raised(line.part(span.start / length, span.end / length), RELIEF_M);
                let z = PLINTH_M..house.eaves;
                wall(
                    &mut out.scene,
                    Layer::Visible,
                    inputs.palette.quoins,
                    stones,
                    z,
                );
            }
        }
    }
    // Beside the corner stones, and in front of what is raised by one relief.
    let pipe = QUOIN_WIDTH_M + 0.1..QUOIN_WIDTH_M + 0.1 + PIPE_WIDTH_M;
    if house.detailed && length > 4.0 && is_free(&pipe) {
        let foot = |run: f64| line.at(run / length).offset(line.outward(), 2.0 * RELIEF_M);
        let face = Segment::new(foot(pipe.start), foot(pipe.end));
        let material = inputs.palette.downpipe.material;
        panel(
            &mut out.scene,
            Layer::Visible,
            material,
            face,
            0.1..house.eaves,
        );
    }
}

/// Bands between the storeys, and one below a flat roof.
fn bands(out: &mut Output, house: &House, line: Segment) {
    let storey = house.storey();
    let count = if house.levels > 1 {
        house.bands.min(house.levels - 1)
    } else {
        0
    };
    for level in 1..=count {
        let z = storey * level as f64;
        let band = raised(line, RELIEF_M);
        wall(
            &mut out.scene,
            Layer::Visible,
            house.trim,
            band,
            z - 0.1..z + 0.08,
        );
    }
    if house.roof == Roof::Flat && house.bands > 0 {
        let cornice = raised(line, 2.0 * RELIEF_M);
        let z = house.eaves - 0.1..house.eaves + 0.14;
        wall(&mut out.scene, Layer::Visible, house.trim, cornice, z);
    }
}

/// Whether another building stands right before the middle of a wall.
fn is_party_wall(inputs: &Inputs, line: Segment) -> bool {
    let before = |distance: f64| line.middle().offset(line.outward(), distance);
    !inputs
        .clearance
        .is_free(Segment::new(before(0.4), before(0.8)), 0.2, BUILDING)
}

/// The line moved out of the wall by `relief` metres, and longer by as much, so that it closes
/// around the corners.
fn raised(line: Segment, relief: f64) -> Segment {
    let over = relief / line.length().max(relief);
    let out = line.outward();
    Segment::new(
        line.at(-over).offset(out, relief),
        line.at(1.0 + over).offset(out, relief),
    )
}
