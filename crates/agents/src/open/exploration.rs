//! Waypoints around a building, as in the paper: its outer boundary, inflated and sampled
//! uniformly, each waypoint facing the building. An OSM outline already is the outer boundary,
//! which the paper must first compute as a concave hull.

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, RobotDescription};
use openbench_motion::Costmap;
use openbench_osm::OsmMap;

use crate::open::terrain::Terrain;

/// Distance between two candidates along the wall.
const SPACING_M: f64 = 2.0;
/// Most candidates around a building.
const MOST_CANDIDATES: f64 = 400.0;
/// Length of wall that is seen well from a waypoint, over its distance from the wall. Plates are
/// read at up to 40 degrees.
const COVERAGE: f64 = 1.0;
/// Distance from which an unreadable plate is looked at.
const PLATE_DISTANCE_M: f64 = 3.0;
/// Share of the distance from which something is looked at again.
const NEARER: f64 = 0.6;
/// Clearance of a waypoint from every building of the map.
const CLEARANCE_M: f64 = 0.6;
/// Distance of a waypoint from an obstacle behind it.
const FROM_OBSTACLE_M: f64 = 0.5;
/// Least distance of a waypoint from the wall that it looks at.
const NEAREST_M: f64 = 1.0;
/// Height up to which plates are looked for: somewhat below the top of a door.
const PLATE_TOP_M: f64 = 1.9;
/// Largest angle between the view and the wall's normal: 60 degrees.
const STEEPEST_RAD: f64 = 1.05;
/// Plates seen at a larger angle are looked at again from nearer to their normal.
const ASIDE_RAD: f64 = 0.8;
/// Steps in which a waypoint is moved nearer to a wall until it has clearance.
const STEP_M: f64 = 0.1;
/// Clearance of a line of sight from every building of the map.
const SIGHT_CLEARANCE_M: f64 = 0.2;

/// A pose to look from, and the wall that it looks at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// The pose, facing the wall.
    pub place: Pose2,
    /// The point of the wall that is looked at.
    pub wall: MapPoint,
    /// Distance between them, metres.
    pub standoff: f64,
    /// Distance from the line of the wall, metres: less than `standoff` in an oblique view.
    pub from_wall: f64,
    /// Whether it replaces a waypoint that could not be reached or saw too little. It is not
    /// replaced in turn: each look shows obstacles that hide something, without end.
    pub second: bool,
}

impl Waypoint {
    /// The same view of a wall that turned out to be elsewhere.
    #[must_use]
    pub fn moved(&self, by: MapPoint) -> Self {
        let Self { place, wall, .. } = *self;
        Self {
            place: Pose2::new(place.x + by.x, place.y + by.y, place.yaw),
            wall: MapPoint::new(wall.x + by.x, wall.y + by.y),
            ..*self
        }
    }

    /// The same view from nearer, if an unmapped obstacle stands at the waypoint; `None` if it is
    /// near already.
    pub fn nearer(&self) -> Option<Self> {
        self.at_distance(NEARER * self.standoff)
    }

    /// The same view from in front of the first obstacle between the wall and the waypoint, such as
    /// a hedge or a parked car; `None` if there is none, or no room in front of it.
    pub fn before_obstacles(&self, costmap: &Costmap) -> Option<Self> {
        // From the wall outwards. In front of an obstacle nearer than `from` there is no room to
        // stand.
        let back = self.place.yaw + std::f64::consts::PI;
        let from = NEAREST_M + FROM_OBSTACLE_M;
        let steps = ((self.standoff - from) / 0.1).max(0.0) as usize;
        let distances = (0..steps).map(|i| from + 0.1 * i as f64);
        let blocked = |d: &f64| {
            costmap
                .grid()
                .cell_at(self.wall.offset(back, *d))
                .is_some_and(|cell| costmap.is_obstacle(cell))
        };
        self.at_distance(distances.into_iter().find(blocked)? - FROM_OBSTACLE_M)
    }

    fn at_distance(&self, standoff: f64) -> Option<Self> {
        let back = self.place.yaw + std::f64::consts::PI;
        let at = self.wall.offset(back, standoff);
        let place = Pose2::new(at.x, at.y, self.place.yaw);
        // Along the same line of sight both distances shrink in proportion.
        let from_wall = self.from_wall * standoff / self.standoff;
        (standoff >= NEAREST_M && !self.second).then_some(Self {
            place,
            standoff,
            from_wall,
            second: true,
            ..*self
        })
    }
}

/// Distance from a wall at which plates at door height are in the camera's image, metres.
pub fn sees_plates_from(robot: &RobotDescription) -> f64 {
    let optics = robot.camera_intrinsics;
    let upwards = f64::from(optics.height) / 2.0 / optics.focal_length();
    // A level camera sees up to `upwards` metres above itself per metre of distance. A camera above
    // the plates sees them from anywhere.
    ((PLATE_TOP_M - robot.camera.translation.z) / upwards).max(0.0)
}

/// Waypoints around a building, facing it, in the order of its wall.
///
/// They are `standoff` metres from the wall or, in narrow yards, as far as there is room. Where
/// that is nearer than `sees_from` metres, plates would be above the image: the wall is then looked
/// at obliquely, from both sides.
pub fn waypoints(map: &OsmMap, building: usize, standoff: f64, sees_from: f64) -> Vec<Waypoint> {
    let Some(outline) = map.buildings.get(building).map(|b| &b.polygon) else {
        return Vec::new();
    };
    let ring = &outline.outer[..outline.outer.len().min(MOST_CANDIDATES as usize)];
    // A mapping error can make an outline of any length: the number of candidates is bounded.
    let spacing = SPACING_M.max(outline.perimeter() / MOST_CANDIDATES);
    let mut views = Vec::new();
    for i in 0..ring.len() {
        let (a, b, c) = (
            ring[i],
            ring[(i + 1) % ring.len()],
            ring[(i + 2) % ring.len()],
        );
        let length = a.distance(b);
        if length < 1e-6 {
            continue;
        }
        // The outside is on the right of a counter-clockwise outline.
        let outwards = a.bearing_to(b) - std::f64::consts::FRAC_PI_2;
        let count = (length / spacing).ceil().max(1.0) as usize;
        for k in 0..count {
            // In the middle of equal parts: no candidate lies on a corner, where the normal
            // changes.
            let t = (k as f64 + 0.5) / count as f64;
            let wall = MapPoint::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y));
            views.extend(look_at(map, wall, outwards, standoff, sees_from));
        }
        // A convex corner of a counter-clockwise ring. The views of its two walls diverge there, so
        // one more looks at the corner along its bisector.
        if turns_left(a, b, c) {
            let next = b.bearing_to(c) - std::f64::consts::FRAC_PI_2;
            let between = wrap_angle(next - outwards) / 2.0;
            views.extend(look_at(map, b, outwards + between, standoff, sees_from));
        }
    }
    thinned(&views)
}

/// Waypoints for a plate at `plate` that faces `facing` (radians): in front of it and near or,
/// where that is nearer than `sees_from` metres, from both sides.
pub fn before_plate(map: &OsmMap, plate: MapPoint, facing: f64, sees_from: f64) -> Vec<Waypoint> {
    let views = look_at(map, plate, facing, PLATE_DISTANCE_M, sees_from);
    views
        .into_iter()
        .map(|waypoint| Waypoint {
            second: true,
            ..waypoint
        })
        .collect()
}

/// A waypoint for a plate that was seen from `viewer`: in front of it if it was seen from afar or
/// from the side, else nearer on the line between them. On that line it is visible whatever the map
/// has, so this is also the result where the map leaves no room in front of the plate.
pub fn nearer_to_plate(
    map: &OsmMap,
    plate: MapPoint,
    facing: f64,
    viewer: MapPoint,
    sees_from: f64,
) -> Waypoint {
    let (distance, towards) = (plate.distance(viewer), plate.bearing_to(viewer));
    // Nearer than now, but not so near that a plate at door height leaves the image. It is not
    // farther than the viewer was, since only up to there the line is known to be free; the least
    // standoff comes before that.
    let standoff = (NEARER * distance)
        .clamp(sees_from.min(PLATE_DISTANCE_M), PLATE_DISTANCE_M)
        .min(distance)
        .max(NEAREST_M);
    let at = plate.offset(towards, standoff);
    let place = Pose2::new(at.x, at.y, at.bearing_to(plate));
    let from_wall = standoff * libm::cos(wrap_angle(towards - facing));
    let on_line = Waypoint {
        place,
        wall: plate,
        standoff,
        from_wall,
        second: true,
    };
    // Already near and roughly in front: a shorter distance on the same line helps most.
    if standoff < PLATE_DISTANCE_M && wrap_angle(towards - facing).abs() < ASIDE_RAD {
        return on_line;
    }
    // Otherwise the first look failed for its angle or distance, so a view from in front is taken.
    // Of two oblique ones it is the one with the shorter drive.
    let away = |view: &Waypoint| view.place.point().distance(viewer);
    let views = before_plate(map, plate, facing, sees_from).into_iter();
    views
        .min_by(|a, b| away(a).total_cmp(&away(b)))
        .unwrap_or(on_line)
}

/// Index of the waypoint with the cheapest path over the terrain; `None` if none can be reached.
pub fn nearest(waypoints: &[Waypoint], from: MapPoint, terrain: &Terrain) -> Option<usize> {
    let places: Vec<MapPoint> = waypoints.iter().map(|w| w.place.point()).collect();
    let costs = terrain.costs(from, &places);
    let known = (0..places.len()).filter_map(|i| Some((i, costs[i]?)));
    known.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
}

/// The view of `wall` from in front of it, nearer where other buildings leave less room, or the
/// views from both sides where a plate would be above the image. None in a gap too narrow to stand
/// in.
fn look_at(
    map: &OsmMap,
    wall: MapPoint,
    outwards: f64,
    standoff: f64,
    sees_from: f64,
) -> Vec<Waypoint> {
    let has_room = |d: &f64| is_clear(map, wall.offset(outwards, *d), CLEARANCE_M);
    let mut distances = (0..)
        .map(|i| standoff - STEP_M * f64::from(i))
        .take_while(|d| *d >= NEAREST_M);
    let Some(from_wall) = distances.find(has_room) else {
        return Vec::new();
    };
    // The line of sight is `from_wall / cos(aslant)` long. This is the least angle at which it is
    // `sees_from` long, and zero where the wall is far enough anyway.
    let aslant = libm::acos((from_wall / sees_from.min(standoff)).min(1.0)).min(STEEPEST_RAD);
    let view = |turned: f64| {
        let standoff = from_wall / libm::cos(turned);
        let at = wall.offset(outwards + turned, standoff);
        let place = Pose2::new(at.x, at.y, at.bearing_to(wall));
        Waypoint {
            place,
            wall,
            standoff,
            from_wall,
            second: false,
        }
    };
    // The last fifth before the wall is not tested: the building of the wall itself is near there.
    let is_open = |view: &Waypoint| {
        let (at, steps) = (
            view.place.point(),
            (view.standoff / SIGHT_CLEARANCE_M) as usize,
        );
        let on_line = |i: usize| at.offset(view.place.yaw, i as f64 * SIGHT_CLEARANCE_M);
        is_clear(map, at, CLEARANCE_M)
            && (0..steps * 4 / 5).all(|i| is_clear(map, on_line(i), SIGHT_CLEARANCE_M))
    };
    let sides: Vec<Waypoint> = [aslant, -aslant]
        .map(view)
        .into_iter()
        .filter(is_open)
        .collect();
    // At an angle of zero both sides are the same view. Where neither side is open, a straight view
    // from too near still shows low plates.
    if aslant > 0.0 && !sides.is_empty() {
        sides
    } else {
        vec![view(0.0)]
    }
}

/// Whether a point is at least `room` metres from every building of the map.
fn is_clear(map: &OsmMap, at: MapPoint, room: f64) -> bool {
    map.nearest_building(at)
        .is_none_or(|i| map.distance_to_building(i, at) >= room)
}

fn turns_left(a: MapPoint, b: MapPoint, c: MapPoint) -> bool {
    let turn = (b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x);
    // The cross product is the product of the lengths times the sine of the turn: more than 17
    // degrees. Flatter corners are covered by the views of their walls.
    turn > 0.3 * a.distance(b) * b.distance(c)
}

/// Drops waypoints whose wall a neighbour covers.
fn thinned(views: &[Waypoint]) -> Vec<Waypoint> {
    let mut kept: Vec<Waypoint> = Vec::new();
    for view in views {
        let seen = |k: &Waypoint| {
            let apart = k.wall.distance(view.wall);
            let turn = wrap_angle(k.place.yaw - view.place.yaw).abs();
            apart < COVERAGE * k.from_wall.min(view.from_wall) && turn < 0.5
        };
        if !kept.iter().any(seen) {
            kept.push(*view);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::{Georeference, LonLat};
    use openbench_motion::costmap::Preferences;
    use openbench_osm::{OsmData, Projection};

    /// Distance from which plates are in the picture, metres.
    const SEES_FROM: f64 = 2.6;

    /// A house of about 14 m x 11 m.
    fn map() -> OsmMap {
        houses(&[(0.0, 0.0, 14.3, 11.1)])
    }

    /// Houses from west, south to east, north, metres from the origin.
    fn houses(boxes: &[(f64, f64, f64, f64)]) -> OsmMap {
        let georeference = Georeference::tangent_plane(LonLat::new(8.0, 50.0));
        let projection = Projection::new(georeference);
        let (mut nodes, mut ways) = (String::new(), String::new());
        for (i, &(west, south, east, north)) in boxes.iter().enumerate() {
            let corners = [(west, south), (east, south), (east, north), (west, north)];
            for (k, (x, y)) in corners.into_iter().enumerate() {
                let at = projection.to_lonlat(MapPoint::new(x, y));
                nodes += &format!(
                    r#"<node id="{}" lat="{}" lon="{}"/>"#,
                    10 * i + k + 1,
                    at.lat,
                    at.lon
                );
            }
            let ends = [1, 2, 3, 4, 1]
                .map(|k| format!(r#"<nd ref="{}"/>"#, 10 * i + k))
                .concat();
            ways += &format!(
                r#"<way id="{}">{ends}<tag k="building" v="yes"/></way>"#,
                i + 1
            );
        }
        let data =
            OsmData::from_xml(format!(r#"<osm version="0.6">{nodes}{ways}</osm>"#).as_bytes());
        OsmMap::new(&data.unwrap(), georeference)
    }

    #[test]
    fn waypoints_go_round_the_house_and_face_it() {
        let map = map();
        let places = waypoints(&map, 0, 4.0, SEES_FROM);
        assert!((12..20).contains(&places.len()), "{}", places.len());
        let outline = &map.buildings[0].polygon;
        for place in places.iter().map(|w| w.place) {
            let distance = outline.distance_to_boundary(place.point());
            assert!((3.9..4.1).contains(&distance), "{distance}");
            let ahead = place.transform(distance + 0.2, 0.0);
            assert!(
                outline.contains(ahead) || outline.distance_to_boundary(ahead) < 0.3,
                "{place:?}"
            );
        }
        for side in [-1.0, 1.0] {
            let middle = outline.centroid();
            assert!(
                places
                    .iter()
                    .map(|w| w.place)
                    .any(|p| (p.x - middle.x) * side > 8.0)
            );
            assert!(
                places
                    .iter()
                    .map(|w| w.place)
                    .any(|p| (p.y - middle.y) * side > 8.0)
            );
        }
    }

    #[test]
    fn a_nearer_place_has_the_same_view() {
        let place = waypoints(&map(), 0, 4.0, SEES_FROM)[0];
        let nearer = place.nearer().unwrap();
        assert!((nearer.place.point().distance(place.wall) - 2.4).abs() < 1e-9);
        assert!(nearer.place.transform(2.4, 0.0).distance(place.wall) < 1e-9);
        assert_eq!(nearer.nearer(), None);
    }

    #[test]
    fn a_plate_is_looked_at_from_where_it_was_seen_if_the_map_has_a_wall_there() {
        let map = map();
        let plate = map.buildings[0].polygon.centroid();
        assert_eq!(before_plate(&map, plate, 0.0, SEES_FROM), []);
        for (away, standoff) in [(8.0, 3.0), (4.0, 2.6), (2.0, 2.0), (0.9, 1.0)] {
            let view = nearer_to_plate(&map, plate, 0.0, plate.offset(2.0, away), SEES_FROM);
            assert!(view.place.point().distance(plate.offset(2.0, standoff)) < 1e-9);
            assert!(view.place.transform(standoff, 0.0).distance(plate) < 1e-9);
        }
        // In front of a wall that the map has where it is.
        let wall = map.buildings[0]
            .polygon
            .nearest_boundary_point(MapPoint::new(-9.0, 5.0));
        let (wall, facing) = (wall.point, wall.normal);
        for (away, aside) in [(8.0, 0.6), (4.0, 1.2)] {
            let view = nearer_to_plate(
                &map,
                wall,
                facing,
                wall.offset(facing + aside, away),
                SEES_FROM,
            );
            assert!(
                view.place.point().distance(wall.offset(facing, 3.0)) < 1e-6,
                "{view:?}"
            );
        }
    }

    #[test]
    fn in_an_alley_walls_are_looked_at_aslant() {
        // The second house leaves an alley of 2.4 m to the east of the first.
        let map = houses(&[(0.0, 0.0, 14.0, 11.0), (16.4, 0.0, 30.0, 11.0)]);
        let at_wall =
            |w: &&Waypoint| (w.wall.x - 14.0).abs() < 0.1 && w.wall.y > 3.0 && w.wall.y < 8.0;
        let views = waypoints(&map, 0, 4.0, SEES_FROM);
        let views: Vec<_> = views.iter().filter(at_wall).collect();
        for side in [-1.0, 1.0] {
            assert!(
                views.iter().any(|w| side * (w.place.y - w.wall.y) > 1.5),
                "{views:?}"
            );
        }
        for view in views {
            assert!((15.0..15.9).contains(&view.place.x), "{view:?}");
            assert!(view.standoff > 0.9 * SEES_FROM, "{view:?}");
        }
    }

    #[test]
    fn a_corner_hides_what_is_looked_at_aslant() {
        // The alley ends 1 m beyond the plate, so there is one side to look from.
        let map = houses(&[
            (0.0, 0.0, 14.0, 11.0),
            (16.4, 0.0, 30.0, 11.0),
            (14.0, 6.0, 16.4, 11.0),
        ]);
        let views = before_plate(&map, MapPoint::new(14.05, 5.0), 0.0, SEES_FROM);
        assert_eq!(views.len(), 1, "{views:?}");
        assert!(views[0].place.y < 4.0, "{views:?}");
    }

    #[test]
    fn plates_are_in_the_picture_from_two_and_a_half_metres() {
        let robot = openbench_core::RobotDescription::sentry();
        assert!(
            (sees_plates_from(&robot) - 2.6).abs() < 0.1,
            "{}",
            sees_plates_from(&robot)
        );
    }

    #[test]
    fn the_nearest_comes_first() {
        let places = waypoints(&map(), 0, 4.0, SEES_FROM);
        let from = MapPoint::new(-20.0, 5.0);
        let robot = openbench_core::RobotDescription::sentry();
        let terrain = Terrain::new(map(), None, from, &robot, Preferences::NONE).unwrap();
        let first = places[nearest(&places, from, &terrain).unwrap()].place;
        let nearest_by_far = places
            .iter()
            .map(|w| w.place.point().distance(from))
            .reduce(f64::min)
            .unwrap();
        assert!(first.point().distance(from) < nearest_by_far + 1.0);
        assert_eq!(nearest(&[], from, &terrain), None);
    }
}
