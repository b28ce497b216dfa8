//! Where the robot starts: where it was told to, at the origin, or at a clear place on a path near the middle.

use openbench_core::{MapPoint, Pose2};
use openbench_osm::OsmMap;

use super::clearance::{BARRIER, BUILDING, Clearance};
use super::shapes::along;
use super::streets::profile;
use super::{Extent, GenerateError, GenerateOptions};

/// Free radius that a start needs, metres.
const RADIUS: f64 = 1.5;
/// A start is at most this far outside the rectangle of the buildings, metres.
const NEAR: f64 = 15.0;
/// Distance between candidates along a way, metres.
const STEP: f64 = 2.0;

pub(super) fn choose(
    map: &OsmMap,
    clearance: &Clearance,
    extent: Extent,
    options: &GenerateOptions,
) -> Result<Pose2, GenerateError> {
    let is_clear = |p: MapPoint| clearance.is_free(p, p, RADIUS, BUILDING | BARRIER);
    let origin = Pose2::default();
    if let Some(start) = options.start {
        return Ok(start);
    }
    if extent.holds(origin.point(), NEAR) && is_clear(origin.point()) {
        return Ok(origin);
    }
    let middle = extent.middle();
    let mut candidates: Vec<Pose2> = map
        .roads
        .iter()
        .filter(|r| profile(&r.tags).is_some())
        .flat_map(|r| r.points.windows(2))
        .flat_map(|w| places(w[0], w[1]))
        .filter(|p| extent.holds(p.point(), NEAR))
        .collect();
    candidates.sort_by(|a, b| middle.distance(a.point()).total_cmp(&middle.distance(b.point())));
    candidates.into_iter().find(|p| is_clear(p.point())).ok_or(GenerateError::NoStart)
}

fn places(a: MapPoint, b: MapPoint) -> impl Iterator<Item = Pose2> {
    let steps = (a.distance(b) / STEP).clamp(0.0, 10_000.0) as usize;
    (0..=steps).map(move |i| {
        let p = along(a, b, (i as f64 + 0.5) / (steps as f64 + 1.0));
        Pose2::new(p.x, p.y, a.bearing_to(b))
    })
}
