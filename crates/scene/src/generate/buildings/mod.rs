//! Buildings: walls, roofs, parts and doors, each in the look that was designed for it.
//!
//! | file | contents |
//! |---|---|
//! | `house` | the look of a building, from its tags and the seed |
//! | `walls` | the straight walls of a building |
//! | `parts` | buildings whose parts are mapped (`building:part=*`) |
//! | `facades` | plinths, bands between storeys, corner stones, downpipes |
//! | `windows` | windows, balconies, shops |
//! | `roofs`, `pitched` | roofs, and the geometry of gabled and hipped ones |

mod facades;
pub(super) mod house;
mod parts;
mod pitched;
mod roofs;
pub(super) mod walls;
mod windows;

use openbench_geometry::Segment;
use openbench_osm::{Area, Building};
use rand_pcg::Pcg64Mcg;

use crate::generate::doors::door;
use crate::generate::doors::doorway::Doorway;
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::ROAD;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, element_number, pick, stream};
use crate::generate::shapes::{panel, wall};
use crate::material::SemanticClass;
use crate::scene::Layer;
use house::{House, design, foot_of, is_open_below};
use walls::walls;

/// Shortest wall with a garage door, metres.
const SHORTEST_GARAGE_WALL_M: f64 = 3.0;
/// Half the width of a garage door, metres.
const GARAGE_HALF_WIDTH_M: f64 = 1.25;
/// Height of a garage door, metres.
const GARAGE_HEIGHT_M: f64 = 2.1;
/// A garage door looks for a road this far, metres.
const ROAD_REACH_M: f64 = 60.0;
/// Lowest floor under which a robot drives, metres.
const LOWEST_FLOOR_M: f64 = 0.5;

/// Builds all buildings.
pub(super) fn build(inputs: &Inputs, out: &mut Output) {
    let mut parts = parts::of_buildings(inputs.map, &mut out.warnings);
    let mut doorways = inputs.doorways.as_slice();
    // Doorways are in the order of the buildings, so each building's own are at the front.
    for (index, building) in inputs.map.buildings.iter().enumerate() {
        let name = building.name.clone().unwrap_or("building".into());
        out.scene.begin_object(name, SemanticClass::Building);
        let count = doorways.iter().take_while(|d| d.building == index).count();
        let (own, others) = doorways.split_at(count);
        doorways = others;
        if out.admits() {
            let areas = parts.remove(&index).unwrap_or_default();
            build_one(inputs, out, building, &areas, own);
        }
    }
}

fn build_one(
    inputs: &Inputs,
    out: &mut Output,
    building: &Building,
    areas: &[&Area],
    doors: &[Doorway],
) {
    let element = element_number(building.element);
    // By the map's element, not by its place in the list, which other buildings shift.
    let mut rng = stream(inputs.seed, Purpose::Building, element);
    let mut house = design(building, &inputs.palette, inputs.detailed, &mut rng);
    // Nothing solid: robot and people pass below.
    if is_open_below(&building.tags) {
        raised_walls(out, &house, building);
        roofs::shelter(out, &house);
        return;
    }
    // Parts may lower the house itself, so they are designed before its walls are built.
    let parts = parts::design_parts(inputs, &mut house, building, areas);
    for wall in walls(building) {
        facades::build(inputs, out, &house, wall, doors, &mut rng);
    }
    if house.plain {
        garage_door(inputs, out, building, &mut rng);
    }
    roofs::build(inputs, out, &house, &mut rng);
    for part in parts {
        parts::build(inputs, out, &part, building, &mut rng);
    }
    for doorway in doors {
        door::build(inputs, out, &house, doorway, &mut rng);
    }
}

/// The walls of a building on stilts, from its `min_height` up: visible only, since a robot drives
/// below.
fn raised_walls(out: &mut Output, house: &House, building: &Building) {
    let floor = foot_of(&building.tags);
    let Some(floor) = floor.filter(|floor| (LOWEST_FLOOR_M..house.eaves).contains(floor)) else {
        return;
    };
    for line in walls(building) {
        wall(
            &mut out.scene,
            Layer::Visible,
            house.facade,
            line,
            floor..house.eaves,
        );
    }
}

/// A door in the middle of the wall nearest to a road.
fn garage_door(inputs: &Inputs, out: &mut Output, building: &Building, rng: &mut Pcg64Mcg) {
    let to_road = |wall: &Segment| {
        let before = wall.middle().offset(wall.outward(), 1.0);
        inputs.clearance.distance(before, ROAD, ROAD_REACH_M)
    };
    let wide = walls(building)
        .into_iter()
        .filter(|wall| wall.length() > SHORTEST_GARAGE_WALL_M);
    // From before the wall, where the house itself is not in between.
    let nearest = wide.min_by(|s, t| to_road(s).total_cmp(&to_road(t)));
    let Some(wall) = nearest else { return };
    let pose = wall.facing_out(0.5);
    let line = Segment::across(pose, 0.04, GARAGE_HALF_WIDTH_M);
    let leaf = pick(rng, &inputs.palette.garages);
    panel(
        &mut out.scene,
        Layer::Visible,
        leaf,
        line,
        0.0..GARAGE_HEIGHT_M,
    );
}
