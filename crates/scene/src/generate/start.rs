//! Where the robot starts: where it was told to, else at a clear place on a pavement or path from which most doors are reached,
//! as near as can be to the middle of them; where there is no street, in front of a door.

use openbench_core::{MapPoint, Pose2};
use openbench_osm::{OsmMap, Road};

use super::clearance::{BARRIER, BUILDING, Clearance, WATER};
use super::entrances::Doorway;
use super::reach::Reach;
use super::shapes::along;
use super::streets::profile;
use super::{Extent, GenerateError, GenerateOptions};

/// Free radius that a start needs, metres.
const RADIUS: f64 = 1.5;
/// A start is at most this far outside the rectangle of the buildings, metres.
const NEAR: f64 = 15.0;
/// Distance between candidates along a way, metres.
const STEP: f64 = 2.0;
/// How far in front of a door a robot starts where there is no street, metres.
const BEFORE_DOOR: f64 = 2.5;

pub(super) fn choose(
    map: &OsmMap,
    (clearance, extent): (&Clearance, Extent),
    (doors, walls): (&[Doorway], impl Iterator<Item = (MapPoint, MapPoint)>),
    options: &GenerateOptions,
) -> Result<Pose2, GenerateError> {
    if let Some(start) = options.start {
        return Ok(start);
    }
    let reach = Reach::new(extent, walls, doors);
    let middle = middle_of(doors).unwrap_or_else(|| extent.middle());
    let nearest_first = |mut all: Vec<Pose2>| {
        all.sort_by(|a, b| {
            middle
                .distance(a.point())
                .total_cmp(&middle.distance(b.point()))
        });
        all
    };
    let in_streets: Vec<Pose2> = map
        .roads
        .iter()
        .flat_map(places)
        .filter(|p| extent.holds(p.point(), NEAR))
        .collect();
    let before_doors = doors.iter().map(|d| {
        let p = d.middle().offset(d.facing, BEFORE_DOOR);
        Pose2::new(p.x, p.y, d.facing)
    });
    let candidates = nearest_first(in_streets)
        .into_iter()
        .chain(nearest_first(before_doors.collect()));
    let is_clear = |p: MapPoint| clearance.is_free(p, p, RADIUS, BUILDING | BARRIER | WATER);
    let mut good =
        candidates.filter(|p| is_clear(p.point()) && (doors.is_empty() || reach.serves(p.point())));
    good.next().ok_or(GenerateError::NoStart)
}

/// Half of the doors lie to each side of it.
fn middle_of(doors: &[Doorway]) -> Option<MapPoint> {
    let median = |get: fn(MapPoint) -> f64| {
        let mut values: Vec<f64> = doors.iter().map(|d| get(d.middle())).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    Some(MapPoint::new(median(|p| p.x)?, median(|p| p.y)?))
}

/// Places along a road: on its pavement, or near its right edge if it has none; in the middle of a path.
fn places(road: &Road) -> Vec<Pose2> {
    let Some(profile) = profile(&road.tags) else {
        return Vec::new();
    };
    let aside = match (profile.for_cars, profile.sides) {
        (false, _) => 0.0,
        (true, [_, true]) => -(profile.width + profile.pavement) / 2.0,
        (true, [true, false]) => (profile.width + profile.pavement) / 2.0,
        (true, _) => -(profile.width / 2.0 - 0.4),
    };
    road.points
        .windows(2)
        .flat_map(|w| along_segment(w[0], w[1], aside))
        .collect()
}

fn along_segment(a: MapPoint, b: MapPoint, aside: f64) -> impl Iterator<Item = Pose2> {
    let steps = (a.distance(b) / STEP).clamp(0.0, 10_000.0) as usize;
    (0..=steps).map(move |i| {
        let p = along(a, b, (i as f64 + 0.5) / (steps as f64 + 1.0));
        let yaw = a.bearing_to(b);
        let p = Pose2::new(p.x, p.y, yaw).transform(0.0, aside);
        Pose2::new(p.x, p.y, yaw)
    })
}
