//! Trees, lamps and playgrounds.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Segment, segments};
use openbench_osm::draws::{between, chance};
use openbench_osm::houses::DrawnDoor;

use crate::ground::Ground;
use crate::outline::{Footprint, Shape};
use crate::plan::{Class, Fence, Patch, Plan, Street, Thing};
use crate::purpose::{Purpose, Seed};
use crate::style::Style;

/// Ground for each tree that is tried, m².
const GROUND_OF_TREE_M2: f64 = 110.0;
/// Distance of trunks from buildings, metres.
const FROM_BUILDINGS_M: f64 = 3.0;
/// Distance of trunks from one another, metres.
const APART_M: f64 = 4.0;
/// Distance of trunks from paths and doors, metres.
const FROM_PATHS_M: f64 = 1.6;
const FROM_DOORS_M: f64 = 2.6;
/// Distance of lamps from the lines before a door and its plate, metres: as worlds keep free.
const LAMP_FROM_DOORS_M: f64 = 1.6;
/// Where plates may hang, metres along the wall from the middle of the door.
const PLATES_M: [f64; 3] = [-1.25, 0.0, 1.25];
/// Length of those lines, metres.
const BEFORE_DOOR_M: f64 = 1.5;
/// How far a lamp is moved along its street to be off a door, metres; in this order.
const LAMP_MOVES_M: [f64; 7] = [0.0, 2.0, -2.0, 4.0, -4.0, 6.0, -6.0];
/// Distance between street lamps, metres.
const BETWEEN_LAMPS_M: f64 = 27.0;

/// Playgrounds, where there is room for them.
pub(crate) fn playgrounds(style: Style, seed: Seed, plan: &Plan, ground: &Ground) -> Vec<Patch> {
    let wanted = match style {
        Style::Slabs | Style::Blocks => 2,
        Style::Suburb | Style::Terraces | Style::Village => 1,
    };
    let mut found: Vec<Patch> = Vec::new();
    for i in 0..12 {
        let mut draws = seed.stream(Purpose::Greenery, (1 << 30) + i);
        let x = between(&mut draws, -plan.half.x, plan.half.x);
        let y = between(&mut draws, -plan.half.y, plan.half.y);
        let pose = Pose2::new(x, y, between(&mut draws, 0.0, 6.0));
        let place = Footprint {
            width: between(&mut draws, 7.0, 13.0),
            depth: between(&mut draws, 6.0, 10.0),
            setback: 0.0,
            aside: 0.0,
        };
        let outer = place.outer(Shape::Rectangle, pose);
        if found.len() < wanted && ground.fits(&outer, 3.5, usize::MAX) && found.is_empty() {
            found.push(Patch {
                outer,
                key: "leisure",
                value: "playground",
            });
        }
    }
    found
}

/// Lamps along streets, trees everywhere else.
pub(crate) fn things(seed: Seed, plan: &Plan, ground: &Ground) -> Vec<Thing> {
    let mut things = lamps(seed, plan);
    things.extend(trees(seed, plan, ground));
    things
}

fn lamps(seed: Seed, plan: &Plan) -> Vec<Thing> {
    let fronts = fronts(plan);
    let mut lamps = Vec::new();
    for (index, street) in plan.streets.iter().enumerate() {
        let mut draws = seed.stream(Purpose::Streets, (1 << 20) + index as u64);
        let side = if chance(&mut draws, 0.5) { 1.0 } else { -1.0 };
        let mut along = between(&mut draws, 4.0, BETWEEN_LAMPS_M);
        while along < street.length() {
            let moved = LAMP_MOVES_M.map(|by| (along + by).clamp(0.0, street.length()));
            let places = moved.map(|along| place_of_lamp(street, along, side));
            let is_off_doors = |at: &&MapPoint| {
                let distance = |front: &Segment| front.distance_to_point(**at);
                fronts
                    .iter()
                    .all(|front| distance(front) > LAMP_FROM_DOORS_M)
            };
            let at = places.iter().find(is_off_doors).unwrap_or(&places[0]);
            if is_free_for_lamp(plan, index, *at) {
                lamps.push(Thing {
                    at: *at,
                    key: "highway",
                    value: "street_lamp",
                });
            }
            along += BETWEEN_LAMPS_M;
        }
    }
    lamps
}

fn place_of_lamp(street: &Street, along: f64, side: f64) -> MapPoint {
    let out = match street.class {
        Class::Residential => street.edge() - 0.35,
        Class::Living | Class::Service => street.edge() + 0.3,
    };
    street.pose_at(along).transform(0.0, side * out)
}

fn is_free_for_lamp(plan: &Plan, street: usize, at: MapPoint) -> bool {
    // Not in a road that joins the street here.
    let others = plan.streets.iter().enumerate();
    let others = others.filter(|(i, _)| *i != street);
    let is_clear = others
        .map(|(_, other)| other.nearest(at).point.distance(at) - other.edge())
        .all(|d| d > 0.3);
    let mut paths = plan.paths.iter();
    is_clear && paths.all(|path| distance(&path.line, at) > path.width / 2.0 + 0.8)
}

/// The lines before all doors and the places of their plates.
fn fronts(plan: &Plan) -> Vec<Segment> {
    let doors = plan.homes.iter().flat_map(|home| &home.doors);
    doors.flat_map(fronts_of).collect()
}

fn fronts_of(door: &DrawnDoor) -> [Segment; 3] {
    let (out, along) = (door.wall.outward(), door.wall.bearing());
    PLATES_M.map(|aside| {
        let foot = door.at.offset(along, aside);
        Segment::new(foot, foot.offset(out, BEFORE_DOOR_M))
    })
}

fn trees(seed: Seed, plan: &Plan, ground: &Ground) -> Vec<Thing> {
    let half = plan.half;
    let count = (4.0 * half.x * half.y / GROUND_OF_TREE_M2) as u64;
    let fences: Vec<Segment> = plan.fences.iter().flat_map(Fence::standing).collect();
    let doors: Vec<MapPoint> = plan
        .homes
        .iter()
        .flat_map(|home| home.doors.iter())
        .map(|door| door.at.offset(door.wall.outward(), 1.2))
        .collect();
    let gates: Vec<MapPoint> = plan.fences.iter().filter_map(|fence| fence.gate).collect();
    let mut trees: Vec<Thing> = Vec::new();
    for i in 0..count {
        let mut draws = seed.stream(Purpose::Greenery, i);
        let x = between(&mut draws, -half.x, half.x);
        let at = MapPoint::new(x, between(&mut draws, -half.y, half.y));
        let here = Segment::new(at, at);
        let free = ground.is_clear_of_buildings(here, FROM_BUILDINGS_M)
            && ground.is_off_streets(here, 0.8)
            && fences.iter().all(|f| f.distance_to_point(at) > 1.5)
            && plan
                .paths
                .iter()
                .all(|path| distance(&path.line, at) > FROM_PATHS_M)
            && doors
                .iter()
                .chain(&gates)
                .all(|d| d.distance(at) > FROM_DOORS_M)
            && trees.iter().all(|tree| tree.at.distance(at) > APART_M);
        if free {
            trees.push(Thing {
                at,
                key: "natural",
                value: "tree",
            });
        }
    }
    trees
}

fn distance(line: &[MapPoint], point: MapPoint) -> f64 {
    let stretches = segments(line).map(|s| s.distance_to_point(point));
    stretches.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::Kind;

    #[test]
    fn hardly_a_lamp_stands_before_a_door() {
        let (mut lamps, mut before_doors) = (0, 0);
        for seed in 0..40 {
            let seed = Seed::new(Kind::Medium, seed);
            let plan = crate::tests::plan_of(Kind::Medium, seed);
            let fronts = fronts(&plan);
            let street_lamps = plan.things.iter().filter(|t| t.value == "street_lamp");
            for lamp in street_lamps {
                lamps += 1;
                let is_before = |f: &Segment| f.distance_to_point(lamp.at) <= LAMP_FROM_DOORS_M;
                before_doors += usize::from(fronts.iter().any(is_before));
            }
        }
        assert!(lamps > 400, "{lamps}");
        assert!(before_doors * 200 < lamps, "{before_doors} of {lamps}");
    }
}
