//! What keeps a robot out of water: low walls round the sea, lakes, rivers and pools. They are open where a road or path leads over
//! water, and there go along both its edges instead: bridges lie on the ground.

use std::collections::BTreeMap;

use openbench_core::{MapPoint, Pose2};
use openbench_osm::polygon::Segment;
use openbench_osm::{OsmMap, Polygon, Tags};

use super::barriers::{GATE_MARGIN, between_gates};
use super::clearance::{Clearance, WATER};
use super::coast::inside;
use super::ground::SEA_LEVEL;
use super::lanes::Lanes;
use super::shapes::{along, cuboid, parallel};
use super::streets::profile;
use super::{Extent, GROUND_MARGIN, Site};
use crate::material::SemanticClass;
use crate::scene::Layer;

/// Height and thickness of the walls, metres: a robot and its LiDAR see them.
const HEIGHT: f64 = 0.38;
const THICKNESS: f64 = 0.3;
/// Length of the pieces in which a road is looked at, metres.
const PIECE: f64 = 2.0;
/// How far beyond the end of a road over water the wall across it stands, metres.
const BEYOND: f64 = 0.5;
/// Pieces of one segment at most.
const MAX_PIECES: usize = 2_500;
/// Longest shore that is built in one piece, metres.
const LONGEST: f64 = 100.0;
/// Walls at most.
const MAX_KERBS: usize = 200_000;

/// Whether an area is open water.
pub(super) fn is_water(tags: &Tags) -> bool {
    let below = tags.says("tunnel")
        || tags.says("covered")
        || tags.is("location", "underground")
        || tags.get("layer").is_some_and(|l| l.starts_with('-'));
    let open = tags.is("natural", "water")
        || tags.says("water")
        || tags.is("waterway", "riverbank")
        || tags.is("leisure", "swimming_pool")
        || tags.is("amenity", "fountain");
    open && !below
}

/// Where the walls stand.
pub(super) fn kerbs(
    (map, lanes): (&OsmMap, &Lanes),
    sea: &[Polygon],
    (clearance, extent): (&Clearance, Extent),
) -> Vec<(MapPoint, MapPoint)> {
    let is_wet = |p: MapPoint| !clearance.is_free(p, p, 0.0, WATER);
    let lines = shores(map, sea, extent, &is_wet).into_iter().chain(edges(map, extent, &is_wet));
    let open = |line| between_gates((&map.roads, lanes), &[], line, 0.0);
    lines.flat_map(open).take(MAX_KERBS).collect()
}

/// Where water ends, in short pieces.
fn shores(
    map: &OsmMap,
    sea: &[Polygon],
    extent: Extent,
    is_wet: &impl Fn(MapPoint) -> bool,
) -> Vec<(MapPoint, MapPoint)> {
    let world = extent.grown(GROUND_MARGIN);
    let lakes = map.areas.iter().filter(|a| is_water(&a.tags)).map(|a| &a.polygon);
    let waters = sea.iter().chain(lakes.filter(|p| extent.meets(p, GROUND_MARGIN)));
    let mut found = Vec::new();
    for Segment { start: a, end: b } in waters.flat_map(Polygon::sides) {
        let Some((from, to)) = inside(a, b, world) else { continue };
        let (a, b) = (along(a, b, from), along(a, b, to));
        let pieces = ((a.distance(b) / LONGEST).ceil() as usize).max(1);
        let at = |i: usize| along(a, b, i as f64 / pieces as f64);
        // Where the water goes on, in another area or beyond the world, is no shore.
        let is_shore = |(a, b): &(MapPoint, MapPoint)| {
            let out = a.bearing_to(*b) - std::f64::consts::FRAC_PI_2;
            let beyond = along(*a, *b, 0.5).offset(out, 0.5);
            world.holds(beyond, 0.0) && !is_wet(beyond)
        };
        found.extend((0..pieces).map(|i| (at(i), at(i + 1))).filter(is_shore));
    }
    found
}

/// The edges of roads as far as they lead over water, and across those that end there.
fn edges(map: &OsmMap, extent: Extent, is_wet: &impl Fn(MapPoint) -> bool) -> Vec<(MapPoint, MapPoint)> {
    let uses = uses_of_nodes(map);
    let is_dead = |node: Option<&i64>| node.is_some_and(|n| uses.get(n) == Some(&1));
    let mut found = Vec::new();
    for road in &map.roads {
        let Some(profile) = profile(&road.tags) else { continue };
        let aside = profile.width / 2.0 + profile.pavement + GATE_MARGIN - THICKNESS;
        let (left, right) = (parallel(&road.points, aside), parallel(&road.points, -aside));
        let ends = caps(&left, &right, [is_dead(road.nodes.first()), is_dead(road.nodes.last())]);
        for line in [left, right].iter().chain(&ends) {
            let near = line.windows(2).filter(|pair| extent.holds(pair[0], GROUND_MARGIN));
            found.extend(near.flat_map(|pair| stretches((pair[0], pair[1]), is_wet)));
        }
    }
    found
}

/// How many arms roads have at each node.
fn uses_of_nodes(map: &OsmMap) -> BTreeMap<i64, u32> {
    let mut uses = BTreeMap::new();
    for road in &map.roads {
        for (i, node) in road.nodes.iter().enumerate() {
            let is_end = i == 0 || i + 1 == road.nodes.len();
            *uses.entry(*node).or_default() += if is_end { 1 } else { 2 };
        }
    }
    uses
}

/// Lines round the dead ends of a road with these edges: at its beginning, at its end.
fn caps(left: &[MapPoint], right: &[MapPoint], [first, last]: [bool; 2]) -> Vec<Vec<MapPoint>> {
    let n = left.len().min(right.len());
    let round = |end: usize, before: usize| {
        let beyond = |edge: &[MapPoint]| edge[end].offset(edge[before].bearing_to(edge[end]), BEYOND);
        vec![left[end], beyond(left), beyond(right), right[end]]
    };
    let mut found = Vec::new();
    if n > 1 && first {
        found.push(round(0, 1));
    }
    if n > 1 && last {
        found.push(round(n - 1, n - 2));
    }
    found
}

/// The stretches of a segment that `is_wet`, longer by up to a piece at both ends.
fn stretches((a, b): (MapPoint, MapPoint), is_wet: impl Fn(MapPoint) -> bool) -> Vec<(MapPoint, MapPoint)> {
    let count = ((a.distance(b) / PIECE).ceil() as usize).clamp(1, MAX_PIECES);
    let at = |i: usize| along(a, b, i as f64 / count as f64);
    let wet: Vec<bool> = (0..=count).map(|i| is_wet(at(i))).collect();
    let (mut found, mut from) = (Vec::new(), None);
    for i in 0..count {
        if wet[i] || wet[i + 1] {
            from.get_or_insert(i);
        } else if let Some(first) = from.take() {
            found.push((at(first), at(i)));
        }
    }
    found.extend(from.map(|first| (at(first), b)));
    found
}

impl Site {
    /// Builds the walls round water.
    pub(super) fn kerbs(&mut self) {
        let half = THICKNESS / 2.0;
        self.builder.object("quay wall", SemanticClass::Wall);
        for (a, b) in std::mem::take(&mut self.kerbs) {
            let pose = Pose2::new(a.x, a.y, a.bearing_to(b));
            let block = |low: f64| ([-half, -half, low], [a.distance(b) + half, half, HEIGHT]);
            cuboid(&mut self.builder, Layer::Solid, self.palette.quay, pose, block(0.0));
            if self.builder.triangles() < self.limits.bare {
                cuboid(&mut self.builder, Layer::Visible, self.palette.quay, pose, block(SEA_LEVEL));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wet_part_of_a_road_is_found() {
        let (a, b) = (MapPoint::new(0.0, 0.0), MapPoint::new(20.0, 0.0));
        let wet = |p: MapPoint| (7.0..11.0).contains(&p.x) || p.x > 17.0;
        let found: Vec<_> = stretches((a, b), wet).iter().map(|(p, q)| (p.x, q.x)).collect();
        assert_eq!(found, [(6.0, 12.0), (16.0, 20.0)]);
        assert!(stretches((a, b), |_| false).is_empty());
    }

    #[test]
    fn water_under_the_ground_is_none() {
        assert!(is_water(&Tags::from([("natural", "water")])));
        assert!(!is_water(&Tags::from([("natural", "water"), ("tunnel", "yes")])));
        assert!(!is_water(&Tags::from([("natural", "wood")])));
    }
}
