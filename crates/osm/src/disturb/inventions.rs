//! Buildings that are in the map, but not in the world.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Bounds, Polygon, Segment, segments};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::draws::{between, stream};
use crate::map::{Area, OsmMap};
use crate::spatial::BoxTree;

use super::purpose::Purpose;

/// Places that are tried for one building.
const TRIES: usize = 200;
/// Distance from the middle of a building that is there, metres.
const DISTANCE_M: [f64; 2] = [12.0, 60.0];
/// Length and width, metres: sheds up to family houses.
const LENGTH_M: [f64; 2] = [6.0, 15.0];
const WIDTH_M: [f64; 2] = [4.0, 10.0];
/// Distance from buildings, barriers, shores and the middle lines of roads, metres.
const CLEARANCE_M: f64 = 2.0;

/// The outlines of up to `count` buildings, in free places of the map. They stand parallel to a
/// building nearby. Crowded maps have places for fewer.
pub(super) fn inventions(map: &OsmMap, count: usize, seed: u64) -> Vec<Polygon> {
    let mut found: Vec<Polygon> = Vec::new();
    // Beside the town nobody would meet them.
    let Some(area) = area(map) else {
        return found;
    };
    let lines = Lines::of(map);
    for number in 0..count {
        let mut draws = stream(seed, Purpose::Invented as u64, number as u64);
        let place = (0..TRIES).find_map(|_| {
            let outline = outline(map, &mut draws)?;
            let is_inside = area.holds(outline.centroid(), 0.0);
            let is_free =
                is_inside && lines.spare(&outline) && is_beside_buildings(map, &found, &outline);
            is_free.then_some(outline)
        });
        found.extend(place);
    }
    found
}

/// A rectangle near a building; `None` if the map has none.
fn outline(map: &OsmMap, draws: &mut Pcg64Mcg) -> Option<Polygon> {
    if map.buildings.is_empty() {
        return None;
    }
    let like = draws.random_range(0..map.buildings.len() as u32) as usize;
    let like = &map.buildings[like].polygon;
    let wall = like
        .sides()
        .max_by(|a, b| a.length().total_cmp(&b.length()))?;
    let direction = between(draws, 0.0, std::f64::consts::TAU);
    let distance = between(draws, DISTANCE_M[0], DISTANCE_M[1]);
    let middle = like.centroid().offset(direction, distance);
    let [half_length, half_width] = [LENGTH_M, WIDTH_M].map(|[a, b]| between(draws, a, b) / 2.0);
    let pose = Pose2::new(middle.x, middle.y, wall.bearing());
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let ring = corners.map(|(u, v)| pose.transform(u * half_length, v * half_width));
    Polygon::new(ring.to_vec(), Vec::new())
}

/// Roads, barriers and the shores of water, by place.
struct Lines {
    pieces: Vec<Segment>,
    boxes: BoxTree,
    water: Vec<Polygon>,
}

impl Lines {
    fn of(map: &OsmMap) -> Self {
        let roads = map.roads.iter().map(|road| &road.points);
        let barriers = map.barriers.iter().map(|barrier| &barrier.points);
        let lines = roads.chain(barriers).flat_map(|points| segments(points));
        let is_water = |area: &&Area| area.tags.get("natural") == Some("water");
        let water = map.areas.iter().filter(is_water);
        let water: Vec<Polygon> = water.map(|area| area.polygon.clone()).collect();
        let pieces: Vec<Segment> = lines.chain(water.iter().flat_map(Polygon::sides)).collect();
        let bounds =
            |piece: &Segment| Bounds::of_point(piece.start).union(Bounds::of_point(piece.end));
        Self {
            boxes: BoxTree::new(pieces.iter().map(bounds)),
            pieces,
            water,
        }
    }

    /// Whether nothing of it is in an outline or near it.
    fn spare(&self, outline: &Polygon) -> bool {
        let middle = outline.centroid();
        let reach = outline.outer[0].distance(middle) + CLEARANCE_M;
        let near = self.boxes.within(middle, reach).into_iter();
        let mut near = near.map(|number| self.pieces[number]);
        let is_clear = |piece: Segment| {
            let mut sides = outline.sides();
            !outline.contains(piece.start)
                && sides.all(|side| side.distance_to(piece) > CLEARANCE_M)
        };
        near.all(is_clear) && !self.water.iter().any(|water| water.contains(middle))
    }
}

/// Whether an outline keeps its distance from all buildings, and from those that were invented
/// before.
fn is_beside_buildings(map: &OsmMap, invented: &[Polygon], outline: &Polygon) -> bool {
    let middle = outline.centroid();
    let reach = outline.outer[0].distance(middle) + CLEARANCE_M;
    let near = map.buildings_within(middle, reach).into_iter();
    let mut buildings = near.map(|i| &map.buildings[i].polygon).chain(invented);
    buildings.all(|other: &Polygon| {
        let is_far = |wall: Segment| {
            let mut others = other.sides();
            others.all(|other| wall.distance_to(other) > CLEARANCE_M)
        };
        let holds = other.contains(middle) || outline.contains(other.outer[0]);
        !holds && outline.sides().all(is_far)
    })
}

/// The middle of all buildings' bounds; the origin if there are none.
pub(super) fn middle(map: &OsmMap) -> MapPoint {
    area(map).map_or(MapPoint::default(), |area| area.middle())
}

/// The bounds of all buildings; `None` if there are none.
fn area(map: &OsmMap) -> Option<Bounds> {
    let bounds = map.buildings.iter().map(|b| b.polygon.bounds());
    bounds.reduce(|a, b| a.union(b))
}
