//! What viewers draw beside the robot: the public map, the true doors, and what the agent found.

use openbench_core::{Address, MapPoint, SimTime};
use openbench_geometry::Polygon;
use openbench_logs::messages::{Header, Marker, MarkerArray, Shape};
use openbench_osm::OsmMap;
use openbench_scene::Door;

/// Height at which lines of the map are drawn, metres: above the ground, which would hide them.
const LINE_HEIGHT_M: f64 = 0.05;
/// Height of letters, metres.
const LETTERS_M: f64 = 0.8;
/// Height of a name above what it names, metres.
const NAME_HEIGHT_M: f64 = 3.0;
/// Height at which plates hang that are known by their position alone, metres.
const PLATE_HEIGHT_M: f64 = 1.6;
/// Height of the lines that stand for facades, metres.
const FACADE_HEIGHT_M: f64 = 2.0;

const WALLS: [f32; 4] = [0.45, 0.45, 0.5, 1.0];
const ROADS: [f32; 4] = [0.75, 0.65, 0.35, 1.0];
const TRUTH: [f32; 4] = [0.2, 0.6, 0.3, 1.0];
const FOUND: [f32; 4] = [0.85, 0.35, 0.15, 1.0];

/// The outlines and names of buildings and the roads of the public map.
pub(super) fn of_map(map: &OsmMap) -> MarkerArray {
    let header = Header::new(SimTime::ZERO, "map");
    let outlines = map.buildings.iter().flat_map(|b| sides(&b.polygon));
    let roads = map.roads.iter().flat_map(|road| pairs(&road.points));
    let mut markers = vec![
        lines(&header, "buildings", outlines.collect(), WALLS),
        lines(&header, "roads", roads.collect(), ROADS),
    ];
    let names = map.buildings.iter().filter_map(|building| {
        let name = building.name.as_deref()?;
        Some((name, building.polygon.interior_point()))
    });
    for (id, (name, at)) in (0..).zip(names) {
        let place = [at.x, at.y, NAME_HEIGHT_M];
        markers.push(text(&header, "names", id, name, place, WALLS));
    }
    MarkerArray(markers)
}

/// The true doors of the world.
pub(super) fn of_doors(doors: &[Door]) -> MarkerArray {
    let header = Header::new(SimTime::ZERO, "map");
    let labels = (0..).zip(doors).map(|(id, door)| {
        let [x, y, z] = door.plate;
        let place = [x, y, z + LETTERS_M];
        text(
            &header,
            "doors",
            id,
            &door.address.to_string(),
            place,
            TRUTH,
        )
    });
    MarkerArray(labels.collect())
}

/// Facades that the agent saw, where it takes them to be.
pub(super) fn of_facades(time: SimTime, facades: &[MapPoint]) -> MarkerArray {
    let upright = |at: &MapPoint| [[at.x, at.y, 0.0], [at.x, at.y, FACADE_HEIGHT_M]];
    let points = facades.iter().flat_map(upright).collect();
    let header = Header::new(time, "map");
    MarkerArray(vec![lines(&header, "facades", points, FOUND)])
}

/// A plate that was read, and the place where the agent takes it to be.
pub(super) fn of_plate(time: SimTime, id: i32, said: &str, at: MapPoint) -> MarkerArray {
    found(time, "plates", id, said, at, Shape::Sphere)
}

/// A door that the agent wrote into its map.
pub(super) fn of_door(time: SimTime, id: i32, address: &Address, at: MapPoint) -> MarkerArray {
    found(time, "doors", id, &address.to_string(), at, Shape::Cube)
}

/// A shape at a place, and a text above it.
fn found(
    time: SimTime,
    namespace: &str,
    id: i32,
    said: &str,
    at: MapPoint,
    shape: Shape,
) -> MarkerArray {
    let header = Header::new(time, "map");
    let mut marker = Marker::new(header.clone(), namespace, id, shape);
    marker.pose.position = [at.x, at.y, PLATE_HEIGHT_M];
    (marker.scale, marker.color) = ([0.3; 3], FOUND);
    let place = [at.x, at.y, PLATE_HEIGHT_M + LETTERS_M];
    let label = text(
        &header,
        &format!("{namespace}_text"),
        id,
        said,
        place,
        FOUND,
    );
    MarkerArray(vec![marker, label])
}

fn lines(header: &Header, namespace: &str, points: Vec<[f64; 3]>, color: [f32; 4]) -> Marker {
    Marker {
        scale: [0.12, 1.0, 1.0],
        color,
        points,
        ..Marker::new(header.clone(), namespace, 0, Shape::LineList)
    }
}

fn text(
    header: &Header,
    namespace: &str,
    id: i32,
    text: &str,
    position: [f64; 3],
    color: [f32; 4],
) -> Marker {
    let mut marker = Marker::new(header.clone(), namespace, id, Shape::Text);
    marker.pose.position = position;
    (marker.scale, marker.color) = ([LETTERS_M; 3], color);
    marker.text = text.to_owned();
    marker
}

/// Both ends of each side of a polygon.
fn sides(polygon: &Polygon) -> Vec<[f64; 3]> {
    polygon
        .sides()
        .flat_map(|side| [point(side.start), point(side.end)])
        .collect()
}

/// Both ends of each part of a line.
fn pairs(line: &[MapPoint]) -> Vec<[f64; 3]> {
    line.windows(2)
        .flat_map(|ends| [point(ends[0]), point(ends[1])])
        .collect()
}

fn point(at: MapPoint) -> [f64; 3] {
    [at.x, at.y, LINE_HEIGHT_M]
}
