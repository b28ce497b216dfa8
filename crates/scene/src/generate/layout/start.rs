//! The robot's start: the one that is asked for, else a clear place on a pavement or path from
//! which most doors are reached, as near as possible to the middle of them; where there is no
//! street, in front of a door.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Bounds, Segment, segments};
use openbench_osm::{OsmMap, Road};

use super::clearance::{BARRIER, BUILDING, Clearance, WATER};
use super::reach::Reach;
use crate::generate::doors::doorway::Doorway;
use crate::generate::error::GenerateError;
use crate::generate::streets::profile::{Profile, profile};

/// Free radius that a start needs, metres.
const RADIUS_M: f64 = 1.5;
/// A start is at most this far outside the rectangle of the buildings, metres.
const NEAR_M: f64 = 15.0;
/// Distance between candidates along a way, metres.
const STEP_M: f64 = 2.0;
/// Candidates on one segment at most.
const MAX_STEPS: f64 = 10_000.0;
/// Distance from a carriageway's edge where there is no pavement, metres.
const FROM_EDGE_M: f64 = 0.4;
/// Distance in front of a door at which a robot must be able to stand, metres.
const STAND_M: f64 = 1.2;
/// Distance in front of a door at which a robot starts where there is no street, metres.
const BEFORE_DOOR_M: f64 = 2.5;

/// Chooses a start between `walls`.
///
/// # Errors
/// [`GenerateError::NoStart`] if no candidate is clear.
pub(crate) fn choose(
    map: &OsmMap,
    clearance: &Clearance,
    extent: Bounds,
    doorways: &[Doorway],
    walls: impl Iterator<Item = Segment>,
) -> Result<Pose2, GenerateError> {
    let fronts = doorways
        .iter()
        .map(|door| door.position.offset(door.facing, STAND_M));
    let reach = Reach::new(extent, walls, fronts);
    // A median, since one remote building must not draw the start away from the others.
    let middle = middle_of(doorways).unwrap_or_else(|| extent.middle());
    // Doors come after all streets: a start on a pavement is preferred even if it is farther off.
    let in_streets = map.roads.iter().flat_map(places);
    let in_streets = in_streets
        .filter(|p| extent.holds(p.point(), NEAR_M))
        .collect();
    let before_doors = doorways.iter().map(before_door).collect();
    let mut candidates = nearest_first(in_streets, middle)
        .into_iter()
        .chain(nearest_first(before_doors, middle));
    let is_good = |pose: &Pose2| {
        let p = pose.point();
        clearance.is_free_at(p, RADIUS_M, BUILDING | BARRIER | WATER)
            && (doorways.is_empty() || reach.serves(p))
    };
    candidates.find(is_good).ok_or(GenerateError::NoStart)
}

/// The ground between `walls` to which most places in streets lead.
pub(crate) fn reach_of_streets(
    map: &OsmMap,
    extent: Bounds,
    walls: impl Iterator<Item = Segment>,
) -> Reach {
    let in_streets = map.roads.iter().flat_map(places);
    Reach::new(extent, walls, in_streets.map(|pose| pose.point()))
}

fn nearest_first(mut poses: Vec<Pose2>, middle: MapPoint) -> Vec<Pose2> {
    poses.sort_by(|a, b| {
        middle
            .distance(a.point())
            .total_cmp(&middle.distance(b.point()))
    });
    poses
}

/// The median of the doors: half of them lie to each side of it.
fn middle_of(doorways: &[Doorway]) -> Option<MapPoint> {
    let x = median(doorways.iter().map(|d| d.position.x))?;
    let y = median(doorways.iter().map(|d| d.position.y))?;
    Some(MapPoint::new(x, y))
}

/// The upper median of numbers; `None` if there are none.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// A place in front of a door, looking away from it.
fn before_door(door: &Doorway) -> Pose2 {
    let p = door.position.offset(door.facing, BEFORE_DOOR_M);
    Pose2::new(p.x, p.y, door.facing)
}

/// Places along a road: on its pavement, or near its right edge if it has none; in the middle of a
/// path.
fn places(road: &Road) -> Vec<Pose2> {
    let Some(profile) = profile(&road.tags) else {
        return Vec::new();
    };
    let left = left_of_middle(profile);
    segments(&road.points)
        .flat_map(|segment| along_segment(segment, left))
        .collect()
}

/// Distance of a start to the left of a road's middle, metres; negative on the right.
fn left_of_middle(profile: Profile) -> f64 {
    match (profile.for_cars, profile.sides) {
        (false, _) => 0.0,
        // In the middle of the right pavement, else of the left one, else inside the right edge.
        (true, [_, true]) => -(profile.width + profile.pavement) / 2.0,
        (true, [true, false]) => (profile.width + profile.pavement) / 2.0,
        (true, _) => -(profile.width / 2.0 - FROM_EDGE_M),
    }
}

fn along_segment(segment: Segment, left: f64) -> impl Iterator<Item = Pose2> {
    let steps = (segment.length() / STEP_M).clamp(0.0, MAX_STEPS) as usize;
    let yaw = segment.bearing();
    (0..=steps).map(move |i| {
        // In the middle of equal parts: the ends of segments may be junctions.
        let p = segment.at((i as f64 + 0.5) / (steps as f64 + 1.0));
        let p = Pose2::new(p.x, p.y, yaw).transform(0.0, left);
        Pose2::new(p.x, p.y, yaw)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_far_door_does_not_move_the_middle() {
        assert_eq!(median([2.0, 900.0, 1.0].into_iter()), Some(2.0));
        assert_eq!(median(std::iter::empty()), None);
    }
}
