//! Trees, lamps and playgrounds.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Segment, segments};
use openbench_osm::draws::{between, chance};

use crate::ground::Ground;
use crate::outline::{Footprint, Shape};
use crate::plan::{Class, Fence, Patch, Plan, Thing};
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
    let mut lamps = Vec::new();
    for (index, street) in plan.streets.iter().enumerate() {
        let mut draws = seed.stream(Purpose::Streets, (1 << 20) + index as u64);
        let side = if chance(&mut draws, 0.5) { 1.0 } else { -1.0 };
        let mut along = between(&mut draws, 4.0, BETWEEN_LAMPS_M);
        while along < street.length() {
            let out = match street.class {
                Class::Residential => street.edge() - 0.35,
                Class::Living | Class::Service => street.edge() + 0.3,
            };
            let at = street.pose_at(along).transform(0.0, side * out);
            // Not in a road that joins the street here.
            let others = plan.streets.iter().enumerate().filter(|(i, _)| *i != index);
            let clear = others
                .map(|(_, other)| other.nearest(at).point.distance(at) - other.edge())
                .all(|d| d > 0.3);
            let off_paths = plan
                .paths
                .iter()
                .all(|path| distance(&path.line, at) > path.width / 2.0 + 0.8);
            if clear && off_paths {
                lamps.push(Thing {
                    at,
                    key: "highway",
                    value: "street_lamp",
                });
            }
            along += BETWEEN_LAMPS_M;
        }
    }
    lamps
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
