//! Low walls around water, which keep a robot out of it: around the sea, lakes, rivers and pools.
//! They are open where a road or path leads over water, and there follow both its edges instead:
//! bridges lie on the ground.

use std::collections::BTreeMap;

use openbench_core::MapPoint;
use openbench_geometry::line::parallel;
use openbench_geometry::{Bounds, Polygon, Segment, segments};
use openbench_osm::{OsmMap, Road};

use super::coast::SEA_LEVEL_M;
use super::open_water::is_water;
use crate::generate::barriers::gates::{GATE_MARGIN_M, between_gates};
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{Clearance, WATER};
use crate::generate::layout::extent::GROUND_MARGIN_M;
use crate::generate::layout::lanes::Lanes;
use crate::generate::output::Output;
use crate::generate::shapes::{Block, cuboid};
use crate::generate::streets::profile::{Profile, profile};
use crate::material::SemanticClass;
use crate::scene::Layer;

/// Height of the walls, metres: a robot and its LiDAR see them.
const HEIGHT_M: f64 = 0.38;
/// Thickness of the walls, metres.
const THICKNESS_M: f64 = 0.3;
/// Length of the pieces in which a road is tested for water, metres.
const PIECE_M: f64 = 2.0;
/// Distance of the wall across a dead end from the end of the road, metres.
const BEYOND_END_M: f64 = 0.5;
/// Pieces of one segment at most.
const MAX_PIECES: usize = 2_500;
/// Longest shore that is built in one piece, metres.
const LONGEST_M: f64 = 100.0;
/// Walls at most.
const MAX_WALLS: usize = 200_000;

/// Where the walls stand.
pub(crate) fn lines(
    map: &OsmMap,
    lanes: &Lanes,
    sea: &[Polygon],
    clearance: &Clearance,
    extent: Bounds,
) -> Vec<Segment> {
    let is_wet = |p: MapPoint| !clearance.is_free_at(p, 0.0, WATER);
    let shores = shores(map, sea, extent, &is_wet);
    let edges = edges(map, extent, &is_wet);
    let all = shores.into_iter().chain(edges);
    // Opened where roads lead over water; their own edges were added as walls instead.
    let open = all.flat_map(|line| between_gates(&map.roads, lanes, &[], line, 0.0));
    open.take(MAX_WALLS).collect()
}

/// Where water ends, in short pieces.
fn shores(
    map: &OsmMap,
    sea: &[Polygon],
    extent: Bounds,
    is_wet: &impl Fn(MapPoint) -> bool,
) -> Vec<Segment> {
    let world = extent.grown(GROUND_MARGIN_M);
    let lakes = map
        .areas
        .iter()
        .filter(|a| is_water(&a.tags))
        .map(|a| &a.polygon);
    let near = lakes.filter(|lake| extent.meets(lake.bounds(), GROUND_MARGIN_M));
    let sides = sea.iter().chain(near).flat_map(Polygon::sides);
    // There is no shore where the water continues, in another area or beyond the world.
    let is_shore = |piece: &Segment| {
        // Areas have their inside on the left, so land is on the right of a shore.
        let beyond = piece.middle().offset(piece.outward(), 0.5);
        world.holds(beyond, 0.0) && !is_wet(beyond)
    };
    let mut found = Vec::new();
    for side in sides {
        let Some(inside) = world.clip(side) else {
            continue;
        };
        let side = side.part(inside.start, inside.end);
        let count = ((side.length() / LONGEST_M).ceil() as usize).max(1);
        let share = |i: usize| i as f64 / count as f64;
        let pieces = (0..count).map(|i| side.part(share(i), share(i + 1)));
        found.extend(pieces.filter(is_shore));
    }
    found
}

/// The edges of roads where they lead over water, and lines across the roads that end there.
fn edges(map: &OsmMap, extent: Bounds, is_wet: &impl Fn(MapPoint) -> bool) -> Vec<Segment> {
    let arms = arms_of_nodes(map);
    // Where another road goes on there is no end to close.
    let is_dead_end = |node: Option<&i64>| node.is_some_and(|n| arms.get(n) == Some(&1));
    let mut found = Vec::new();
    for road in &map.roads {
        let Some(profile) = profile(&road.tags) else {
            continue;
        };
        let dead_ends = [
            is_dead_end(road.nodes.first()),
            is_dead_end(road.nodes.last()),
        ];
        for line in outline(road, profile, dead_ends) {
            let near = segments(&line).filter(|s| extent.holds(s.start, GROUND_MARGIN_M));
            found.extend(near.flat_map(|segment| stretches(segment, is_wet)));
        }
    }
    found
}

/// The left and the right edge of a road, and lines around its dead ends.
fn outline(road: &Road, profile: Profile, [first, last]: [bool; 2]) -> Vec<Vec<MapPoint>> {
    // A shore wall is open from GATE_MARGIN_M beside the road and reaches half its thickness into
    // that. There it meets the outer face of this wall, so no gap is left.
    let aside = profile.width / 2.0 + profile.pavement + GATE_MARGIN_M - THICKNESS_M;
    let left = parallel(&road.points, aside);
    let right = parallel(&road.points, -aside);
    let n = left.len().min(right.len());
    let mut caps = Vec::new();
    if n > 1 && first {
        caps.push(cap(&left, &right, 0, 1));
    }
    if n > 1 && last {
        caps.push(cap(&left, &right, n - 1, n - 2));
    }
    [vec![left, right], caps].concat()
}

/// A line around the end of a road from its left to its right edge. `end` and `before` number the
/// last point of both edges and the one before it.
fn cap(left: &[MapPoint], right: &[MapPoint], end: usize, before: usize) -> Vec<MapPoint> {
    // Both edges go on a little beyond the end, and meet there.
    let beyond = |edge: &[MapPoint]| {
        let ahead = edge[before].bearing_to(edge[end]);
        edge[end].offset(ahead, BEYOND_END_M)
    };
    vec![left[end], beyond(left), beyond(right), right[end]]
}

/// Number of arms that roads have at each node.
fn arms_of_nodes(map: &OsmMap) -> BTreeMap<i64, u32> {
    let mut arms = BTreeMap::new();
    for road in &map.roads {
        for (i, node) in road.nodes.iter().enumerate() {
            let is_end = i == 0 || i + 1 == road.nodes.len();
            *arms.entry(*node).or_default() += if is_end { 1 } else { 2 };
        }
    }
    arms
}

/// The stretches of a segment that `is_wet`, longer by up to a piece at both ends.
fn stretches(segment: Segment, is_wet: impl Fn(MapPoint) -> bool) -> Vec<Segment> {
    let count = ((segment.length() / PIECE_M).ceil() as usize).clamp(1, MAX_PIECES);
    let at = |i: usize| segment.at(i as f64 / count as f64);
    let wet: Vec<bool> = (0..=count).map(|i| is_wet(at(i))).collect();
    let (mut found, mut from) = (Vec::new(), None);
    for i in 0..count {
        if wet[i] || wet[i + 1] {
            // A piece counts if either of its ends is wet: the wall begins before the water and
            // ends after it.
            from.get_or_insert(i);
        } else if let Some(first) = from.take() {
            found.push(Segment::new(at(first), at(i)));
        }
    }
    found.extend(from.map(|first| Segment::new(at(first), segment.end)));
    found
}

/// Builds the walls around water.
pub(crate) fn build(inputs: &Inputs, out: &mut Output) {
    let half = THICKNESS_M / 2.0;
    let surface = inputs.palette.quay;
    out.scene.begin_object("quay wall", SemanticClass::Wall);
    for line in &inputs.quays {
        let above = |low: f64| Block {
            min: [-half, -half, low],
            max: [line.length() + half, half, HEIGHT_M],
        };
        // Solid even in a world without room for more triangles to see: it keeps robots dry.
        cuboid(
            &mut out.scene,
            Layer::Solid,
            surface,
            line.pose(),
            above(0.0),
        );
        if !out.is_closed() {
            cuboid(
                &mut out.scene,
                Layer::Visible,
                surface,
                line.pose(),
                above(SEA_LEVEL_M),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wet_part_of_a_road_is_found() {
        let segment = Segment::new(MapPoint::new(0.0, 0.0), MapPoint::new(20.0, 0.0));
        let wet = |p: MapPoint| (7.0..11.0).contains(&p.x) || p.x > 17.0;
        let found = stretches(segment, wet);
        let found: Vec<[f64; 2]> = found
            .iter()
            .map(|part| [part.start.x, part.end.x])
            .collect();
        assert_eq!(found, [[6.0, 12.0], [16.0, 20.0]]);
        assert!(stretches(segment, |_| false).is_empty());
    }
}
