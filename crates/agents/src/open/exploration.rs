//! Where to look at a building from, as in the paper: its outer boundary, inflated, sampled uniformly, each waypoint facing
//! the building. An OSM outline already is the outer boundary, which the paper must first compute as a concave hull.

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2};
use openbench_motion::Costmap;
use openbench_osm::OsmMap;

use crate::open::terrain::Terrain;

/// Distance between two places along the wall that are considered, metres.
const SPACING: f64 = 2.0;
/// Most places along a wall that are considered.
const MOST: f64 = 400.0;
/// Stretch of wall that is seen well from a place: so many times its distance from the wall. Plates are read at up to 40 degrees.
const COVERAGE: f64 = 1.0;
/// Distance from which a plate is looked at that could not be read, metres.
const PLATE: f64 = 3.0;
/// Share of the distance from which something is looked at again.
const NEARER: f64 = 0.6;
/// Room that a waypoint keeps from every building of the map, metres.
const ROOM: f64 = 0.6;
/// Distance that a place keeps from an obstacle behind it, metres.
const AWAY: f64 = 0.5;
/// Nearest that a waypoint is put to the wall that it looks at, metres.
const NEAREST: f64 = 1.0;

/// A place to look from, and the wall that it looks at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// The place, facing the wall.
    pub place: Pose2,
    /// The middle of what is looked at.
    pub wall: MapPoint,
    /// Distance between them, metres.
    pub standoff: f64,
    /// Whether it stands in for a place that could not be reached or saw too little. Nothing stands in for it in turn: each look shows
    /// obstacles that hide something, and there would be no end of places.
    pub second: bool,
}

impl Waypoint {
    /// The same view from nearer by, for when something unmapped stands where the place is; `None` if it is near already.
    pub fn nearer(&self) -> Option<Self> {
        self.at_distance(NEARER * self.standoff)
    }

    /// The same view from in front of the first obstacle that stands between the wall and the place, a hedge or a parked car, if there is
    /// room to stand; `None` if nothing is known to stand there.
    pub fn before_obstacles(&self, costmap: &Costmap) -> Option<Self> {
        let back = self.place.yaw + std::f64::consts::PI;
        let from = NEAREST + AWAY;
        let steps = ((self.standoff - from) / 0.1).max(0.0) as usize;
        let distances = (0..steps).map(|i| from + 0.1 * i as f64);
        let blocked = |d: &f64| {
            costmap.grid().cell_at(self.wall.offset(back, *d)).is_some_and(|cell| costmap.is_obstacle(cell))
        };
        self.at_distance(distances.into_iter().find(blocked)? - AWAY)
    }

    fn at_distance(&self, standoff: f64) -> Option<Self> {
        let back = self.place.yaw + std::f64::consts::PI;
        let at = self.wall.offset(back, standoff);
        let place = Pose2::new(at.x, at.y, self.place.yaw);
        (standoff >= NEAREST && !self.second).then_some(Self { place, standoff, second: true, ..*self })
    }
}

/// Places around a building, facing it, `standoff` metres from its wall or, in narrow yards, as far from it as there is room;
/// in the order of the wall.
pub fn waypoints(map: &OsmMap, building: usize, standoff: f64) -> Vec<Waypoint> {
    let Some(outline) = map.buildings.get(building).map(|b| &b.polygon) else { return Vec::new() };
    let ring = &outline.outer[..outline.outer.len().min(MOST as usize)];
    // A mapping error can make an outline of any length: its places are bounded.
    let spacing = SPACING.max(outline.perimeter() / MOST);
    let mut views = Vec::new();
    for i in 0..ring.len() {
        let (a, b, c) = (ring[i], ring[(i + 1) % ring.len()], ring[(i + 2) % ring.len()]);
        let length = a.distance(b);
        if length < 1e-6 {
            continue;
        }
        // Outwards is on the right of a counter-clockwise outline.
        let outwards = a.bearing_to(b) - std::f64::consts::FRAC_PI_2;
        let count = (length / spacing).ceil().max(1.0) as usize;
        for k in 0..count {
            let t = (k as f64 + 0.5) / count as f64;
            let wall = MapPoint::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y));
            views.extend(look_at(map, wall, outwards, standoff));
        }
        if turns_left(a, b, c) {
            let next = b.bearing_to(c) - std::f64::consts::FRAC_PI_2;
            let between = wrap_angle(next - outwards) / 2.0;
            views.extend(look_at(map, b, outwards + between, standoff));
        }
    }
    thinned(&views)
}

/// A place to look at a plate from that hangs at `plate` and faces `facing`, in front of it and near.
pub fn before_plate(map: &OsmMap, plate: MapPoint, facing: f64) -> Option<Waypoint> {
    look_at(map, plate, facing, PLATE).map(|waypoint| Waypoint { second: true, ..waypoint })
}

/// A place to look at a plate from that was seen from `viewer`, nearer to it: in front of it or, if it was seen from near or the map leaves no room there, on the line between them, where it can be seen whatever the map says.
pub fn nearer_to_plate(map: &OsmMap, plate: MapPoint, facing: f64, viewer: MapPoint) -> Waypoint {
    let standoff = (NEARER * plate.distance(viewer)).clamp(NEAREST, PLATE);
    let at = plate.offset(plate.bearing_to(viewer), standoff);
    let place = Pose2::new(at.x, at.y, at.bearing_to(plate));
    let on_line = Waypoint { place, wall: plate, standoff, second: true };
    if standoff < PLATE { on_line } else { before_plate(map, plate, facing).unwrap_or(on_line) }
}

/// Index of the waypoint that is cheapest to get to over what is known of the ground; `None` without a way to any.
pub fn nearest(waypoints: &[Waypoint], from: MapPoint, terrain: &Terrain) -> Option<usize> {
    let places: Vec<MapPoint> = waypoints.iter().map(|w| w.place.point()).collect();
    let costs = terrain.costs(from, &places);
    let known = (0..places.len()).filter_map(|i| Some((i, costs[i]?)));
    known.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
}

/// The view of `wall` from in front of it, nearer where other buildings leave no more room; `None` in a gap too narrow to stand in.
fn look_at(map: &OsmMap, wall: MapPoint, outwards: f64, standoff: f64) -> Option<Waypoint> {
    let clear = |d: &f64| {
        let at = wall.offset(outwards, *d);
        map.nearest_building(at).is_none_or(|i| map.distance_to_building(i, at) >= ROOM)
    };
    let distances = (0..).map(|i| standoff - 0.4 * f64::from(i)).take_while(|d| *d >= NEAREST);
    let standoff = distances.into_iter().find(clear)?;
    let at = wall.offset(outwards, standoff);
    Some(Waypoint { place: Pose2::new(at.x, at.y, at.bearing_to(wall)), wall, standoff, second: false })
}

fn turns_left(a: MapPoint, b: MapPoint, c: MapPoint) -> bool {
    let turn = (b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x);
    turn > 0.3 * a.distance(b) * b.distance(c)
}

/// Leaves out what a neighbour sees as well.
fn thinned(views: &[Waypoint]) -> Vec<Waypoint> {
    let mut kept: Vec<Waypoint> = Vec::new();
    for view in views {
        let seen = |k: &Waypoint| {
            let apart = k.wall.distance(view.wall);
            let turn = wrap_angle(k.place.yaw - view.place.yaw).abs();
            apart < COVERAGE * k.standoff.min(view.standoff) && turn < 0.5
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
    use openbench_motion::costmap::ground::Preferences;
    use openbench_osm::OsmData;

    /// A house of about 14 m x 11 m.
    fn map() -> OsmMap {
        let xml = r#"<osm version="0.6">
          <node id="1" lat="50.0" lon="8.0"/><node id="2" lat="50.0" lon="8.0002"/>
          <node id="3" lat="50.0001" lon="8.0002"/><node id="4" lat="50.0001" lon="8.0"/>
          <way id="5"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/>
            <tag k="building" v="yes"/><tag k="name" v="building1"/></way></osm>"#;
        let data = OsmData::from_xml(xml.as_bytes()).unwrap();
        OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(8.0, 50.0)))
    }

    #[test]
    fn waypoints_go_round_the_house_and_face_it() {
        let map = map();
        let places = waypoints(&map, 0, 4.0);
        assert!((12..20).contains(&places.len()), "{}", places.len());
        let outline = &map.buildings[0].polygon;
        for place in places.iter().map(|w| w.place) {
            let distance = outline.distance_to_boundary(place.point());
            assert!((3.9..4.1).contains(&distance), "{distance}");
            let ahead = place.transform(distance + 0.2, 0.0);
            assert!(outline.contains(ahead) || outline.distance_to_boundary(ahead) < 0.3, "{place:?}");
        }
        for side in [-1.0, 1.0] {
            let middle = outline.centroid();
            assert!(places.iter().map(|w| w.place).any(|p| (p.x - middle.x) * side > 8.0));
            assert!(places.iter().map(|w| w.place).any(|p| (p.y - middle.y) * side > 8.0));
        }
    }

    #[test]
    fn a_nearer_place_has_the_same_view() {
        let place = waypoints(&map(), 0, 4.0)[0];
        let nearer = place.nearer().unwrap();
        assert!((nearer.place.point().distance(place.wall) - 2.4).abs() < 1e-9);
        assert!(nearer.place.transform(2.4, 0.0).distance(place.wall) < 1e-9);
        assert_eq!(nearer.nearer(), None);
    }

    #[test]
    fn a_plate_is_looked_at_from_where_it_was_seen_if_the_map_has_a_wall_there() {
        let map = map();
        let plate = map.buildings[0].polygon.centroid();
        assert_eq!(before_plate(&map, plate, 0.0), None);
        for (away, standoff) in [(8.0, 3.0), (2.0, 1.2), (0.9, 1.0)] {
            let view = nearer_to_plate(&map, plate, 0.0, plate.offset(2.0, away));
            assert!(view.place.point().distance(plate.offset(2.0, standoff)) < 1e-9);
            assert!(view.place.transform(standoff, 0.0).distance(plate) < 1e-9);
        }
        // In front of a wall that the map has where it is.
        let (wall, facing) = map.buildings[0].polygon.nearest_boundary_point(MapPoint::new(-9.0, 5.0));
        let view = nearer_to_plate(&map, wall, facing, wall.offset(facing + 0.6, 8.0));
        assert!(view.place.point().distance(wall.offset(facing, 3.0)) < 1e-6, "{view:?}");
    }

    #[test]
    fn the_nearest_comes_first() {
        let places = waypoints(&map(), 0, 4.0);
        let from = MapPoint::new(-20.0, 5.0);
        let robot = openbench_core::RobotDescription::sentry();
        let terrain = Terrain::new(map(), None, from, &robot, Preferences::NONE).unwrap();
        let first = places[nearest(&places, from, &terrain).unwrap()].place;
        let nearest_by_far = places.iter().map(|w| w.place.point().distance(from)).reduce(f64::min).unwrap();
        assert!(first.point().distance(from) < nearest_by_far + 1.0);
        assert_eq!(nearest(&[], from, &terrain), None);
    }
}
