//! Where a plate is: the LiDAR's points behind the pixels of its text give its position and the
//! direction that it faces.

use nalgebra::Point3;
use openbench_core::frames::wrap_angle;
use openbench_core::{CameraIntrinsics, MapPoint, Pose2};
use openbench_geometry::Polygon;
use openbench_geometry::Segment;
use openbench_osm::OsmMap;
use openbench_vision::{PlateReading, parse_unit};

use crate::open::perception::Perception;

/// Plates farther than this from every outline belong to no building.
pub const OFF_BUILDING_M: f64 = 4.0;
/// Readings of lower confidence are ignored.
const LEAST_CONFIDENCE: f32 = 0.6;
/// Confidence, summed over agreeing readings, above which a plate is trusted.
const TRUSTED_CONFIDENCE: f32 = 0.9;
/// Sightings this near to each other are of one plate.
pub const SAME_PLATE_M: f64 = 1.2;
/// The box of the text is grown by this share of its size to include the wall around it.
const WALL_AROUND: f64 = 1.5;
/// Points farther than this from the depth of a surface belong to something else.
const DEPTH_M: f64 = 0.4;
/// A plate may hang on any wall of the outline within this distance.
const NEAR_WALL_M: f64 = 5.0;
/// Largest angle between the apparent facing of a plate and the normal of its wall.
const MISFIT_RAD: f64 = 0.9;
/// Points within this distance of a line belong to its wall: weatherboards and frames stand out.
const WALL_THICKNESS_M: f64 = 0.06;
/// Number of directions that are tried for a wall: three degrees apart.
const NORMALS: u32 = 60;
/// Only points within this distance of a plate count for its facing.
const AROUND_PLATE_M: f64 = 1.5;
/// Fewest points that locate a plate.
const FEWEST_POINTS: usize = 5;

/// Where a plate is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Location {
    /// Its position in `map`.
    pub position: MapPoint,
    /// Direction that it faces, radians.
    pub facing: f64,
}

/// A door plate that was read and located.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// Canonical name of the unit.
    pub unit: String,
    /// Index of the building in the map.
    pub building: usize,
    /// The plate's position in `map`.
    pub position: MapPoint,
    /// Direction that the plate faces, radians.
    pub facing: f64,
    /// The reader's confidence times how literally the text names the unit, 0 to 1.
    pub confidence: f32,
}

impl Sighting {
    /// Whether both are of a plate at the same position, whatever was read.
    fn same_place(&self, other: &Self) -> bool {
        self.building == other.building && self.position.distance(other.position) <= SAME_PLATE_M
    }
}

/// Whether `sighting` can be trusted, given all sightings so far. Readers err: one confident
/// reading or several agreeing ones are needed, and more evidence for it than against it.
pub fn is_trusted(sighting: &Sighting, all: &[Sighting]) -> bool {
    // The sighting itself is among `all`, so a single confident reading reaches the threshold.
    weight(sighting, all, true) >= TRUSTED_CONFIDENCE
        && weight(sighting, all, true) > weight(sighting, all, false)
}

/// Whether there is more evidence for `sighting` than against it, but too little to trust it.
pub fn is_doubtful(sighting: &Sighting, all: &[Sighting]) -> bool {
    let agreeing = weight(sighting, all, true);
    agreeing < TRUSTED_CONFIDENCE && agreeing > weight(sighting, all, false)
}

/// Summed confidence of readings of the same plate that agree with `sighting`, or disagree.
fn weight(sighting: &Sighting, all: &[Sighting], agree: bool) -> f32 {
    let there = all
        .iter()
        .filter(|s| s.same_place(sighting) && (s.unit == sighting.unit) == agree);
    there.map(|s| s.confidence).sum()
}

/// Position and facing of a reading, if the LiDAR saw the wall behind the text. `base` is the
/// robot's pose, `camera` the camera that took the image.
pub fn locate(
    reading: &PlateReading,
    perception: &Perception,
    base: Pose2,
    camera: &CameraIntrinsics,
) -> Option<Location> {
    // The x axis of the camera points ahead, so `c.x` below is the depth of a point.
    let to_camera = perception.camera_pose(base).inverse().cast::<f32>();
    let corner = |f: fn(f32, f32) -> f32, axis: usize| {
        f64::from(
            reading
                .corners
                .iter()
                .map(|c| c[axis])
                .fold(reading.corners[0][axis], f),
        )
    };
    // Corners may form a sheared box; the points are looked up in its upright bounding box.
    let (left, right) = (corner(f32::min, 0), corner(f32::max, 0));
    let (top, bottom) = (corner(f32::min, 1), corner(f32::max, 1));
    let behind = |grow: f64| -> Vec<(f64, MapPoint)> {
        let (dx, dy) = (grow * (right - left), grow * (bottom - top));
        let inside = |p: &Point3<f32>| {
            let c = to_camera * p;
            let (u, v) = camera.project([f64::from(c.x), f64::from(c.y), f64::from(c.z)])?;
            let within = u >= left - dx && u <= right + dx && v >= top - dy && v <= bottom + dy;
            within.then(|| {
                (
                    f64::from(c.x),
                    MapPoint::new(f64::from(p.x), f64::from(p.y)),
                )
            })
        };
        perception.points().filter_map(inside).collect()
    };
    // Far away few points fall into the box itself.
    let plate = [0.0, 0.3]
        .into_iter()
        .map(|grow| surface(behind(grow)))
        .find(|points| points.len() >= FEWEST_POINTS)?;
    let middle = mean(&plate);
    // The plate's own points are too few and too close together for a direction. The box grown on
    // all sides holds the wall around it, and the distance limit excludes what is seen beyond the
    // wall.
    let around = behind(WALL_AROUND).into_iter().map(|p| p.1);
    let around: Vec<MapPoint> = around
        .filter(|p| p.distance(middle) <= AROUND_PLATE_M)
        .collect();
    let facing = facing(&around, middle, base.point());
    Some(Location {
        position: middle,
        // Without a wall the best estimate is that the plate faces the robot: its text could be
        // read.
        facing: facing.unwrap_or_else(|| middle.bearing_to(base.point())),
    })
}

/// The sighting of a reading, if it names a unit, was located, and is at a building.
pub fn recognise(
    reading: &PlateReading,
    located: Option<Location>,
    map: &OsmMap,
) -> Option<Sighting> {
    // Readers see bare numbers in window frames and pipes.
    let unit = parse_unit(&reading.text).filter(|u| u.worded)?;
    // "UNIT!" may be unit 1: another reading must agree.
    let confidence = reading.confidence * unit.score;
    if confidence < LEAST_CONFIDENCE {
        return None;
    }
    let Location { position, facing } = located?;
    let building = building_at(map, position)?;
    Some(Sighting {
        unit: unit.unit,
        building,
        position,
        facing: along_wall(facing, position, &map.buildings[building].polygon),
        confidence,
    })
}

/// The building at which a plate is, if it is near one.
pub fn building_at(map: &OsmMap, plate: MapPoint) -> Option<usize> {
    let building = map.nearest_building(plate)?;
    let is_near = map.distance_to_building(building, plate) <= OFF_BUILDING_M;
    is_near.then_some(building)
}

/// Whether a reading that names no unit may still be of a plate that does: it has a letter and a
/// digit.
pub fn is_puzzling(reading: &PlateReading) -> bool {
    let unread = parse_unit(&reading.text).is_none_or(|unit| !unit.worded);
    let has = |of_kind: fn(char) -> bool| reading.text.chars().any(of_kind);
    unread && has(char::is_alphabetic) && has(|c| c.is_ascii_digit())
}

/// `facing` replaced by the normal of the nearby wall that fits it best: porches and shutters
/// around a plate distort what the LiDAR sees of its wall.
fn along_wall(facing: f64, plate: MapPoint, outline: &Polygon) -> f64 {
    let near = |side: &Segment| side.nearest_point(plate).point.distance(plate) <= NEAR_WALL_M;
    // Outer rings are counter-clockwise, so the outside is on the right of each side.
    let normal = |side: Segment| side.start.bearing_to(side.end) - std::f64::consts::FRAC_PI_2;
    let normals = outline.sides().filter(near).map(normal);
    let off = |normal: &f64| wrap_angle(normal - facing).abs();
    let best = normals
        .min_by(|a, b| off(a).total_cmp(&off(b)))
        .filter(|n| off(n) <= MISFIT_RAD);
    best.map_or(facing, wrap_angle)
}

/// The points at about the median depth: where a text can be read, most of its pixels are visible.
fn surface(mut points: Vec<(f64, MapPoint)>) -> Vec<MapPoint> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let depth = points
        .get(points.len() / 2)
        .map(|p| p.0)
        .unwrap_or_default();
    points
        .into_iter()
        .filter(|p| (p.0 - depth).abs() <= DEPTH_M)
        .map(|p| p.1)
        .collect()
}

fn mean(points: &[MapPoint]) -> MapPoint {
    let n = points.len() as f64;
    MapPoint::new(
        points.iter().map(|p| p.x).sum::<f64>() / n,
        points.iter().map(|p| p.y).sum::<f64>() / n,
    )
}

/// Normal of the wall through `plate`, on the side of `viewer`: of all lines through the plate, the
/// one with most points. Beside a corner the points of two walls are seen, and only one
/// of the walls goes through the plate. `None` where no line has a third of the points.
fn facing(points: &[MapPoint], plate: MapPoint, viewer: MapPoint) -> Option<f64> {
    // Normals over half a turn are all lines. The candidates only select the points of the wall;
    // the fit below gives its direction more finely than three degrees.
    let normals = (0..NORMALS).map(|i| {
        let (sin, cos) = libm::sincos(f64::from(i) * std::f64::consts::PI / f64::from(NORMALS));
        MapPoint::new(cos, sin)
    });
    let is_on = |p: &MapPoint, n: MapPoint| {
        ((p.x - plate.x) * n.x + (p.y - plate.y) * n.y).abs() <= WALL_THICKNESS_M
    };
    let on = |normal: MapPoint| points.iter().filter(move |p| is_on(p, normal));
    let (_, best) = normals
        .map(|n| (on(n).count(), n))
        .reduce(|a, b| if b.0 > a.0 { b } else { a })?;
    let wall: Vec<MapPoint> = on(best).copied().collect();
    if wall.len() < FEWEST_POINTS || 3 * wall.len() < points.len() {
        return None;
    }
    let normal = normal_of_line(&wall);
    // The normal of a line has two directions. The plate was seen, so it faces the viewer.
    let ahead = libm::cos(normal - plate.bearing_to(viewer)) >= 0.0;
    Some(wrap_angle(if ahead {
        normal
    } else {
        normal + std::f64::consts::PI
    }))
}

/// Normal of the line through points (total least squares), radians, to either side.
fn normal_of_line(points: &[MapPoint]) -> f64 {
    let m = mean(points);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for p in points {
        let (dx, dy) = (p.x - m.x, p.y - m.y);
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
    }
    // The first term is the angle of the principal axis of the scatter matrix, along the line.
    0.5 * libm::atan2(2.0 * xy, xx - yy) + std::f64::consts::FRAC_PI_2
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a wall from `a` to `b`, 5 cm apart, up to a centimetre beside it.
    fn wall(a: MapPoint, b: MapPoint) -> Vec<MapPoint> {
        let (count, along) = ((a.distance(b) / 0.05) as u32, a.bearing_to(b));
        let aside = |i: u32| f64::from(i % 3) * 0.01 - 0.01;
        let across = along + std::f64::consts::FRAC_PI_2;
        (0..count)
            .map(|i| {
                a.offset(along, 0.05 * f64::from(i))
                    .offset(across, aside(i))
            })
            .collect()
    }

    #[test]
    fn a_wall_faces_its_viewer() {
        let points = wall(MapPoint::new(3.0, 0.0), MapPoint::new(3.0, 2.0));
        let plate = MapPoint::new(3.0, 1.0);
        let west = facing(&points, plate, MapPoint::new(0.0, 1.0)).unwrap();
        assert!((west.abs() - std::f64::consts::PI).abs() < 0.05, "{west}");
        let east = facing(&points, plate, MapPoint::new(6.0, 1.0)).unwrap();
        assert!(east.abs() < 0.05, "{east}");
    }

    #[test]
    fn beside_a_corner_a_plate_faces_as_its_own_wall_does() {
        // A viewer in the south-west sees 1.5 m of a wall that faces west, aslant, and 2 m of one
        // that faces south.
        let mut points = wall(MapPoint::new(0.0, 0.0), MapPoint::new(0.0, 1.5));
        points.extend(wall(MapPoint::new(-2.0, 1.5), MapPoint::new(0.0, 1.5)));
        let viewer = MapPoint::new(-3.8, -5.6);
        let west = facing(&points, MapPoint::new(0.0, 0.8), viewer).unwrap();
        assert!((west.abs() - std::f64::consts::PI).abs() < 0.05, "{west}");
    }

    #[test]
    fn a_heap_of_points_faces_nowhere() {
        let heap: Vec<MapPoint> = (0..25)
            .map(|i| MapPoint::new(f64::from(i % 5), f64::from(i / 5)))
            .collect();
        assert_eq!(
            facing(&heap, MapPoint::new(2.0, 2.0), MapPoint::new(9.0, 9.0)),
            None
        );
    }

    #[test]
    fn readings_of_one_plate_are_weighed_against_each_other() {
        let seen = |unit: &str, x: f64, confidence: f32| Sighting {
            unit: unit.into(),
            building: 0,
            position: MapPoint::new(x, 0.0),
            facing: 0.0,
            confidence,
        };
        let weak = seen("unit1", 0.0, 0.7);
        assert!(!is_trusted(&weak, std::slice::from_ref(&weak)));
        assert!(is_doubtful(&weak, std::slice::from_ref(&weak)));
        assert!(is_trusted(&weak, &[weak.clone(), seen("unit1", 0.5, 0.6)]));
        assert!(is_trusted(
            &weak,
            &[
                seen("unit1", 0.2, 0.95),
                weak.clone(),
                seen("unit11", 5.0, 0.99)
            ]
        ));
        let better = [
            weak.clone(),
            seen("unit1", 0.2, 0.6),
            seen("unit11", 0.3, 0.95),
            seen("unit11", 0.1, 0.9),
        ];
        assert!(!is_trusted(&weak, &better) && !is_doubtful(&weak, &better));
    }

    #[test]
    fn the_surface_of_most_points_counts() {
        let at =
            |depth: f64| move |i: i32| (depth + 0.01 * f64::from(i), MapPoint::new(depth, 0.0));
        let points: Vec<_> = (0..4).map(at(4.0)).chain((0..10).map(at(7.0))).collect();
        assert_eq!(surface(points).len(), 10);
        assert!(surface(Vec::new()).is_empty());
    }
}
