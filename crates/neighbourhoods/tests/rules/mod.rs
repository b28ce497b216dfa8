//! Simple rules on the public map that say where the door of a building is, and which doors they
//! find. Tests of other crates read this file too.

use openbench_core::MapPoint;
use openbench_geometry::{Segment, segments};
use openbench_osm::{Building, OsmMap, Road};

/// A door within this distance of a prediction is found, metres.
const FOUND_M: f64 = 1.0;
/// Doors in shorter walls are left out, metres: there any guess is near.
const SHORTEST_WALL_M: f64 = 8.0;
/// A corner this near to the line between its neighbours divides no wall, metres.
const STRAIGHT_M: f64 = 0.05;

/// A rule that says where the door of a building is.
pub type Rule = fn(&OsmMap, &Building) -> Option<MapPoint>;

pub const RULES: [(&str, Rule); 5] = [
    (
        "middle of the wall nearest to a road",
        middle_of_wall_nearest_to_a_road,
    ),
    ("middle of the longest wall", middle_of_the_longest_wall),
    ("point of the outline nearest to a road", nearest_to_a_road),
    (
        "middle of the wall that faces its street",
        middle_of_wall_facing_its_street,
    ),
    (
        "point of the outline nearest to the end of a path",
        nearest_to_a_path,
    ),
];

/// The doors that each of the [`RULES`] finds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Found {
    /// Doors in walls that are long enough.
    pub all: u32,
    /// Those of them that each rule finds.
    pub by_rule: [u32; RULES.len()],
}

impl Found {
    /// Adds the doors of a building of the public map.
    pub fn add(&mut self, public: &OsmMap, building: &Building, doors: &[MapPoint]) {
        let is_counted = |at: &&MapPoint| wall_of(building, **at).length() >= SHORTEST_WALL_M;
        let doors: Vec<MapPoint> = doors.iter().filter(is_counted).copied().collect();
        self.all += doors.len() as u32;
        for ((_, rule), found) in RULES.iter().zip(&mut self.by_rule) {
            let Some(guess) = rule(public, building) else {
                continue;
            };
            let is_found = |at: &&MapPoint| at.distance(guess) <= FOUND_M;
            *found += doors.iter().filter(is_found).count() as u32;
        }
    }

    /// Prints what share of the doors each rule finds, and returns the largest.
    pub fn report(&self) -> f64 {
        println!("{} doors in walls of {SHORTEST_WALL_M} m or more", self.all);
        let shares = self
            .by_rule
            .map(|found| f64::from(found) / f64::from(self.all));
        for ((rule, _), share) in RULES.iter().zip(shares) {
            println!("{:5.1} %  {rule}", 100.0 * share);
        }
        shares.into_iter().fold(0.0, f64::max)
    }
}

/// The walls of a building, without corners that do not bend.
fn walls(building: &Building) -> Vec<Segment> {
    let mut ring = building.polygon.outer.clone();
    let mut i = 0;
    while i < ring.len() && ring.len() > 3 {
        let n = ring.len();
        let neighbours = Segment::new(ring[(i + n - 1) % n], ring[(i + 1) % n]);
        if neighbours.distance_to_point(ring[i]) < STRAIGHT_M {
            ring.remove(i);
        } else {
            i += 1;
        }
    }
    openbench_geometry::sides(&ring).collect()
}

fn wall_of(building: &Building, at: MapPoint) -> Segment {
    least(walls(building), |wall| wall.distance_to_point(at)).unwrap()
}

fn least(walls: Vec<Segment>, cost: impl Fn(&Segment) -> f64) -> Option<Segment> {
    walls.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

/// Stretches of the roads that cars use.
fn streets(map: &OsmMap) -> impl Iterator<Item = Segment> + '_ {
    let roads = map
        .roads
        .iter()
        .filter(|road| !road.tags.is("highway", "footway"));
    roads.flat_map(|road: &Road| segments(&road.points))
}

fn distance_to(stretches: impl Iterator<Item = Segment>, point: MapPoint) -> f64 {
    let distances = stretches.map(|stretch| stretch.distance_to_point(point));
    distances.fold(f64::INFINITY, f64::min)
}

fn middle_of_wall_nearest_to_a_road(map: &OsmMap, building: &Building) -> Option<MapPoint> {
    let nearest = least(walls(building), |wall| {
        distance_to(streets(map), wall.middle())
    });
    nearest.map(Segment::middle)
}

fn middle_of_the_longest_wall(_: &OsmMap, building: &Building) -> Option<MapPoint> {
    least(walls(building), |wall| -wall.length()).map(Segment::middle)
}

fn nearest_to_a_road(map: &OsmMap, building: &Building) -> Option<MapPoint> {
    nearest_to(streets(map), building)
}

/// The point of the outline that is nearest to any of the stretches.
fn nearest_to(stretches: impl Iterator<Item = Segment>, building: &Building) -> Option<MapPoint> {
    let mut best: Option<(f64, MapPoint)> = None;
    for stretch in stretches {
        for wall in walls(building) {
            // Segments are nearest at an end of one of them.
            let tries = [
                wall.start,
                wall.end,
                wall.nearest_point(stretch.start).point,
                wall.nearest_point(stretch.end).point,
            ];
            for point in tries {
                let distance = stretch.distance_to_point(point);
                if best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, point));
                }
            }
        }
    }
    best.map(|(_, point)| point)
}

fn middle_of_wall_facing_its_street(map: &OsmMap, building: &Building) -> Option<MapPoint> {
    let street = building.tags.get("addr:street")?;
    let own = map.roads.iter().filter(|road| road.tags.is("name", street));
    let stretches: Vec<Segment> = own.flat_map(|road| segments(&road.points)).collect();
    let nearest = least(walls(building), |wall| {
        let before = wall.middle().offset(wall.outward(), 1.0);
        distance_to(stretches.iter().copied(), before)
    });
    nearest.map(Segment::middle)
}

fn nearest_to_a_path(map: &OsmMap, building: &Building) -> Option<MapPoint> {
    let ways = map.roads.iter().filter(|road| !road.tags.has("name"));
    let ends = ways.flat_map(|road| [road.points.first(), road.points.last()]);
    let ends: Vec<Segment> = ends.flatten().map(|end| Segment::new(*end, *end)).collect();
    nearest_to(ends.into_iter(), building)
}
