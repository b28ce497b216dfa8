//! Buildings whose parts are mapped (`building:part=*`), after OSM's
//! [Simple 3D Buildings](https://wiki.openstreetmap.org/wiki/Simple_3D_Buildings).
//!
//! Where parts cover most of an outline, the outline itself is only built as high as the lowest of
//! them: a base without gaps, in which the doors are, and which the robot meets. The parts rise
//! from it, each with its own height and roof; a part that hangs in the air (`min_height`) begins
//! there. Where parts cover less, say the tower of a church, they rise from the whole building.

use std::collections::BTreeMap;
use std::rc::Rc;

use openbench_core::MapPoint;
use openbench_geometry::{Polygon, Segment, sides};
use openbench_osm::{Area, Building, OsmMap};
use rand_pcg::Pcg64Mcg;

use super::facades;
use super::house::{House, Roof, foot_of, roof_of, storeys};
use super::roofs;
use super::walls::straightened;
use crate::generate::inputs::Inputs;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, element_number, stream};
use crate::generate::shapes::floor;

/// Share of an outline from which on its parts stand for it.
const COVERED: f64 = 0.5;
/// Lowest base, metres: a door must fit.
const LOWEST_BASE_M: f64 = 2.8;
/// Usual height of a storey, metres.
const STOREY_M: f64 = 3.0;
/// A part that rises less above its foot is left out, metres.
const LOWEST_PART_M: f64 = 0.3;
/// Parts of one building at most.
const MAX_PARTS: usize = 500;

/// A part as it is built, with the outlines and tops of all parts of its building.
pub(super) struct Part {
    house: House,
    all: Rc<Vec<Mass>>,
}

/// Outline of a part and the height of its top.
struct Mass {
    outline: Polygon,
    /// Metres.
    top: f64,
}

/// The mapped parts by building; parts in no building are counted in a warning.
pub(super) fn of_buildings<'a>(
    map: &'a OsmMap,
    warnings: &mut Vec<String>,
) -> BTreeMap<usize, Vec<&'a Area>> {
    let mut found: BTreeMap<usize, Vec<&Area>> = BTreeMap::new();
    let mut stray = 0;
    for area in map.areas.iter().filter(|a| a.tags.says("building:part")) {
        // A point inside the part, since its corners lie on walls that buildings share.
        let around = map.buildings_within(area.polygon.interior_point(), 0.0);
        let Some(index) = around.first() else {
            stray += 1;
            continue;
        };
        let list = found.entry(*index).or_default();
        if list.len() < MAX_PARTS {
            list.push(area);
        } else {
            stray += 1;
        }
    }
    if stray > 0 {
        warnings.push(format!(
            "{stray} parts of buildings lie in no building, or in one of more than {MAX_PARTS} \
             parts, and were left out"
        ));
    }
    found
}

/// The parts of a building; `house` is lowered where they stand for it.
pub(super) fn design_parts(
    inputs: &Inputs,
    house: &mut House,
    building: &Building,
    areas: &[&Area],
) -> Vec<Part> {
    if areas.is_empty() {
        return Vec::new();
    }
    let mut houses: Vec<House> = areas
        .iter()
        .map(|area| design_part(inputs, house, area))
        .collect();
    // Parts that lie over each other count twice: exact enough for a share.
    let covered: f64 = areas.iter().map(|a| a.polygon.area()).sum();
    if covered >= COVERED * building.polygon.area() {
        lower_to_base(house, &houses);
    }
    let base = house.eaves;
    for part in &mut houses {
        // What is below the base's top is inside the base.
        let foot = part.foot.max(base);
        part.levels = (((part.eaves - foot) / STOREY_M).round() as usize).clamp(1, 200);
        part.foot = foot;
    }
    let masses = areas.iter().zip(&houses);
    let masses = masses.map(|(a, p)| Mass {
        outline: a.polygon.clone(),
        top: p.eaves,
    });
    let all = Rc::new(masses.collect::<Vec<_>>());
    houses
        .into_iter()
        .map(|house| Part {
            house,
            all: Rc::clone(&all),
        })
        .collect()
}

/// Lowers a building to the base that its parts stand on.
fn lower_to_base(house: &mut House, parts: &[House]) {
    let lowest = parts
        .iter()
        // A part on the ground ends the base at its top; one that hangs in the air, at its foot.
        .map(|p| if p.foot < 1.0 { p.eaves } else { p.foot });
    let top = lowest.fold(house.eaves, f64::min).max(LOWEST_BASE_M);
    house.eaves = top;
    house.levels = ((top / STOREY_M) as usize).max(1);
    house.roof = Roof::Terrace;
}

/// A part in the style of its building.
fn design_part(inputs: &Inputs, house: &House, area: &Area) -> House {
    let mut rng = stream(inputs.seed, Purpose::Building, element_number(area.element));
    let rings: Vec<Vec<MapPoint>> = area.polygon.rings().map(straightened).collect();
    let has_height = ["height", "building:levels"]
        .iter()
        .any(|key| area.tags.has(key));
    // Without a height of its own, a part is as high as its building.
    let eaves = if has_height {
        // The area decides drawn floors only, and these are mapped.
        storeys(&area.tags, 0.0, false, &mut rng).eaves
    } else {
        house.eaves
    };
    let roof = if area.tags.has("roof:shape") {
        roof_of(&area.tags, &rings, house.levels, &mut rng)
    } else {
        Roof::Flat
    };
    let is_flat = roof == Roof::Flat;
    let roofing = if is_flat {
        inputs.palette.flat_roof
    } else {
        house.roofing
    };
    let foot = foot_of(&area.tags).unwrap_or(0.0);
    House {
        rings,
        foot,
        eaves,
        roof,
        roofing,
        balconies: false,
        ..house.clone()
    }
}

/// Builds a part of a building.
pub(super) fn build(
    inputs: &Inputs,
    out: &mut Output,
    Part { house, all }: &Part,
    building: &Building,
    rng: &mut Pcg64Mcg,
) {
    if house.eaves < house.foot + LOWEST_PART_M {
        // No higher than the base: its top is the part's.
        return;
    }
    floor(
        &mut out.scene,
        house.facade,
        house.outer(),
        house.holes(),
        // A centimetre above the base's top, since two faces in one plane show through each other.
        house.foot + 0.01,
    );
    for wall in house.rings.iter().flat_map(|ring| sides(ring)) {
        let hidden = hidden_to(all, wall);
        facades::build_above(inputs, out, house, wall, &building.polygon, hidden, rng);
    }
    roofs::build(inputs, out, house, rng);
}

/// Height up to which other parts stand before the middle of a wall, metres.
fn hidden_to(parts: &[Mass], wall: Segment) -> f64 {
    let before = wall.middle().offset(wall.outward(), 0.3);
    let in_front = parts.iter().filter(|part| part.outline.contains(before));
    in_front.map(|part| part.top).fold(0.0, f64::max)
}
