//! Doors of buildings without mapped entrances, drawn by a seed: some buildings have one, some
//! twenty, in any wall before which a robot can stand and to which the streets lead.

use openbench_core::MapPoint;
use openbench_geometry::Segment;
use openbench_osm::Building;
use openbench_osm::draws::{between, chance};
use openbench_osm::houses::{DoorWish, FaceWeights};
use rand_pcg::Pcg64Mcg;

use crate::generate::buildings::walls::walls;
use crate::generate::layout::clearance::{BARRIER, BUILDING, Clearance, PATH, ROAD, WATER};
use crate::generate::layout::reach::Reach;

/// Streams of the run's seed: the doors of a building, and the plate of each.
pub(super) const DOORS_STREAM: u64 = 111;
pub(super) const PLATE_STREAM: u64 = 112;
/// Where in front of a door a robot must be able to stand, metres.
const BEFORE_M: [f64; 2] = [1.1, 1.6];
/// Free space to each side of the line in front of a door, metres.
const HALF_WIDTH_M: f64 = 0.5;
/// Ground for each door of a large building, m².
const GROUND_OF_DOOR_M2: [f64; 2] = [150.0, 400.0];
/// Most doors of a building.
const MOST_DOORS: f64 = 20.0;
/// Share of the small houses with a second door.
const SECOND: f64 = 0.18;
/// A house of flats that is so many times as long as it is deep is a slab.
const SLAB: f64 = 2.2;
/// Largest distance at which walls are compared by their distance from a street, metres.
const STREET_REACH_M: f64 = 60.0;

/// What doors are drawn from.
pub(crate) struct Draw {
    /// The seed of the run.
    pub seed: u64,
    /// The ground to which streets lead.
    pub reach: Reach,
}

impl Draw {
    /// Whether a robot can stand before a door and drive there.
    pub(super) fn fits(&self, clearance: &Clearance, wall: Segment, at: MapPoint) -> bool {
        let out = wall.outward();
        let front = Segment::new(
            at.offset(out, HALF_WIDTH_M + 0.05),
            at.offset(out, BEFORE_M[1]),
        );
        BEFORE_M
            .iter()
            .all(|before| self.reach.serves(at.offset(out, *before)))
            && clearance.is_free(front, HALF_WIDTH_M, BUILDING | BARRIER | WATER)
    }
}

/// The doors that a building shall have.
pub(super) fn wish(building: &Building, clearance: &Clearance, draws: &mut Pcg64Mcg) -> DoorWish {
    // In this order whatever the building is.
    let ground = between(draws, GROUND_OF_DOOR_M2[0], GROUND_OF_DOOR_M2[1]);
    let has_second = chance(draws, SECOND);
    let is_front = chance(draws, 0.5);
    let by_size = (building.polygon.area() / ground).round();
    let count = if is_small(building) {
        1 + usize::from(has_second)
    } else {
        by_size.clamp(1.0, MOST_DOORS) as usize
    };
    let walls = walls(building);
    let long = longest(&walls).filter(|wall| count > 2 && is_slab(building, *wall));
    let (front, weights) = match long {
        Some(long) => (long.outward(), FaceWeights::of_slab(is_front)),
        None if is_in_row(building) => (front(&walls, clearance), FaceWeights::IN_ROW),
        None => (front(&walls, clearance), FaceWeights::USUAL),
    };
    DoorWish {
        count,
        front,
        weights,
    }
}

/// The direction of the wall that is nearest to a street, radians.
fn front(walls: &[Segment], clearance: &Clearance) -> f64 {
    let cost = |wall: &Segment| {
        // From before the wall: a road behind the building is farther off.
        let before = wall.middle().offset(wall.outward(), 1.0);
        clearance.distance(before, ROAD | PATH, STREET_REACH_M)
    };
    let nearest = walls.iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
    nearest.map_or(0.0, |wall| wall.outward())
}

fn longest(walls: &[Segment]) -> Option<Segment> {
    let longest = walls
        .iter()
        .max_by(|a, b| a.length().total_cmp(&b.length()));
    longest.copied()
}

fn is_slab(building: &Building, long: Segment) -> bool {
    let of_flats = ["apartments", "residential", "dormitory"];
    let depth = building.polygon.area() / long.length();
    of_flats
        .iter()
        .any(|kind| building.tags.is("building", kind))
        && long.length() > SLAB * depth
}

fn is_small(building: &Building) -> bool {
    let small = [
        "house",
        "detached",
        "semidetached_house",
        "bungalow",
        "farm",
        "cabin",
    ];
    small.iter().any(|kind| building.tags.is("building", kind))
}

fn is_in_row(building: &Building) -> bool {
    building.tags.is("building", "terrace")
}

#[cfg(test)]
mod tests {
    use openbench_geometry::Polygon;
    use openbench_osm::draws::stream;
    use openbench_osm::{ElementId, ElementKind, Tags};

    use super::*;

    fn counts(kind: &str, width: f64, depth: f64) -> Vec<usize> {
        let corners = [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)];
        let corners = corners.map(|(x, y)| MapPoint::new(x, y)).to_vec();
        let building = Building {
            element: ElementId {
                kind: ElementKind::Way,
                id: 1,
            },
            name: None,
            polygon: Polygon::new(corners, Vec::new()).unwrap(),
            tags: Tags::from([("building", kind)]),
        };
        let wish = |seed| wish(&building, &Clearance::default(), &mut stream(seed, 1, 1)).count;
        (0..100).map(wish).collect()
    }

    #[test]
    fn a_building_has_one_to_twenty_doors_by_its_size() {
        assert!(
            counts("house", 30.0, 20.0)
                .iter()
                .all(|n| (1..=2).contains(n))
        );
        assert!(counts("yes", 9.0, 8.0).iter().all(|n| *n == 1));
        let block = counts("apartments", 60.0, 14.0);
        assert!(block.iter().all(|n| (2..=6).contains(n)), "{block:?}");
        let mall = counts("retail", 150.0, 90.0);
        assert!(mall.iter().all(|n| *n == 20), "{mall:?}");
    }
}
