//! The public map as a registration sees it: the walls that can be seen from outside.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Bounds, Polygon, Segment};
use openbench_osm::{Building, OsmMap};

/// Walls are tested for what stands in front of them in pieces of this length, metres.
const PIECE_M: f64 = 0.5;
/// Something this far in front of a wall hides it, metres.
const IN_FRONT_M: f64 = 0.25;
/// Shorter walls are left out, metres.
const SHORTEST_M: f64 = 0.3;
/// An outline of more corners is left out: each of its walls is compared with all of them.
const MOST_CORNERS: usize = 5000;

/// A wall that can be seen from outside. Its building lies to its left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// From corner to corner, or the part that no other building hides; metres from the chart's
    /// origin.
    pub segment: Segment,
    /// Index of its building in the chart.
    pub building: usize,
}

/// Buildings around a place, in metres from an origin near them.
#[derive(Debug, Clone, Default)]
pub struct Chart {
    /// Where the chart's coordinates are zero, in `map`.
    pub origin: MapPoint,
    /// The walls that can be seen.
    pub walls: Vec<Wall>,
    /// Outlines of the buildings.
    pub outlines: Vec<Polygon>,
    /// For each outline, the index of its building in the map.
    pub buildings: Vec<usize>,
}

impl Chart {
    /// The buildings of a map that are at most `radius` metres from `centre`, which becomes the
    /// origin.
    pub fn around(map: &OsmMap, centre: MapPoint, radius: f64) -> Self {
        let mut chart = Self {
            origin: centre,
            ..Self::default()
        };
        let area = Bounds::of_point(centre).grown(radius);
        let near = map.buildings_within(centre, radius);
        for index in near.into_iter().filter(|i| has_walls(&map.buildings[*i])) {
            let building = chart.outlines.len();
            let outline = &map.buildings[index].polygon;
            // Only what is near: a side may be hundreds of kilometres long.
            let sides = outline.sides().filter_map(|side| {
                let inside = area.clip(side)?;
                Some(side.part(inside.start, inside.end))
            });
            for side in sides {
                for part in seen_parts(map, side) {
                    let segment = relative_segment(part, centre);
                    chart.walls.push(Wall { segment, building });
                }
            }
            chart
                .outlines
                .push(outline.moved(MapPoint::new(-centre.x, -centre.y)));
            chart.buildings.push(index);
        }
        chart
    }

    /// A pose of the chart in `map`.
    pub fn in_map(&self, pose: Pose2) -> Pose2 {
        Pose2::new(pose.x + self.origin.x, pose.y + self.origin.y, pose.yaw)
    }

    /// A pose of `map` in the chart's coordinates.
    pub fn from_map(&self, pose: Pose2) -> Pose2 {
        let at = relative(pose.point(), self.origin);
        Pose2::new(at.x, at.y, pose.yaw)
    }

    /// The box around all outlines; `None` without buildings.
    pub fn bounds(&self) -> Option<Bounds> {
        let boxes = self.outlines.iter().map(Polygon::bounds);
        boxes.reduce(Bounds::union)
    }
}

/// Whether a building has walls down to the ground.
fn has_walls(building: &Building) -> bool {
    let tag = |key| building.tags.get(key).unwrap_or_default();
    let is_roof = matches!(
        tag("building"),
        "roof" | "carport" | "canopy" | "no" | "bridge"
    );
    let is_raised = ["min_height", "building:min_level"].iter().any(|key| {
        tag(key)
            .trim_start()
            .starts_with(|c: char| ('1'..='9').contains(&c))
    });
    let corners =
        building.polygon.outer.len() + building.polygon.holes.iter().map(Vec::len).sum::<usize>();
    !is_roof && !is_raised && corners <= MOST_CORNERS
}

/// The parts of a wall with no building in front of them.
fn seen_parts(map: &OsmMap, side: Segment) -> Vec<Segment> {
    let length = side.length();
    let count = (length / PIECE_M).ceil().max(1.0) as usize;
    let out = side.outward();
    let is_seen = |piece: usize| {
        let middle = side.at((piece as f64 + 0.5) / count as f64);
        let before = middle.offset(out, IN_FRONT_M);
        let hides = |i: &usize| has_walls(&map.buildings[*i]);
        !map.buildings_within(before, 0.0).iter().any(hides)
    };
    let mut parts = Vec::new();
    let mut begin = None;
    for piece in 0..=count {
        let seen = piece < count && is_seen(piece);
        match (begin, seen) {
            (None, true) => begin = Some(piece),
            (Some(first), false) => {
                let (from, to) = (first as f64 / count as f64, piece as f64 / count as f64);
                parts.push(side.part(from, to));
                begin = None;
            }
            _ => {}
        }
    }
    parts.retain(|part| part.length() >= SHORTEST_M);
    parts
}

fn relative_segment(segment: Segment, origin: MapPoint) -> Segment {
    Segment::new(
        relative(segment.start, origin),
        relative(segment.end, origin),
    )
}

fn relative(point: MapPoint, origin: MapPoint) -> MapPoint {
    MapPoint::new(point.x - origin.x, point.y - origin.y)
}

#[cfg(test)]
mod tests {
    use openbench_osm::OsmData;

    use super::*;

    /// Houses of 10 m by 10 m in a row from the origin eastwards, with these tags.
    fn row(tags: &[&str]) -> OsmMap {
        let mut xml = String::from("<osm version=\"0.6\">");
        for (i, tag) in tags.iter().enumerate() {
            let (west, east) = (i as f64 * 10.0, i as f64 * 10.0 + 10.0);
            let corners = [(west, 0.0), (east, 0.0), (east, 10.0), (west, 10.0)];
            for (corner, (x, y)) in corners.iter().enumerate() {
                let (lat, lon) = (y / 110_574.0, x / 111_320.0);
                let id = 4 * i + corner + 1;
                xml += &format!("<node id=\"{id}\" lat=\"{lat:.9}\" lon=\"{lon:.9}\"/>");
            }
            xml += &format!("<way id=\"{}\">", 100 + i);
            for corner in [0, 1, 2, 3, 0] {
                xml += &format!("<nd ref=\"{}\"/>", 4 * i + corner + 1);
            }
            xml += &format!("<tag k=\"building\" v=\"{tag}\"/></way>");
        }
        let data = OsmData::from_xml((xml + "</osm>").as_bytes()).unwrap();
        let place = openbench_osm::default_georeference(&data).unwrap();
        OsmMap::new(&data, place)
    }

    fn middle(map: &OsmMap) -> MapPoint {
        map.buildings[0].polygon.bounds().middle()
    }

    #[test]
    fn walls_between_neighbours_are_left_out() {
        let map = row(&["house", "house"]);
        let chart = Chart::around(&map, middle(&map), 50.0);
        assert_eq!(chart.outlines.len(), 2);
        assert_eq!(chart.walls.len(), 6, "{:?}", chart.walls);
        let seen: f64 = chart.walls.iter().map(|wall| wall.segment.length()).sum();
        assert!((seen - 60.0).abs() < 1.0, "{seen}");
        // Coordinates are relative to the first house's middle.
        let bounds = chart.bounds().unwrap();
        let here = Pose2::new(2.0, -3.0, 0.5);
        assert_eq!(chart.in_map(Pose2::default()).point(), middle(&map));
        let back = chart.from_map(chart.in_map(here));
        assert!(back.point().distance(here.point()) < 1e-9 && back.yaw == here.yaw);
        assert!((bounds.low.x + 5.0).abs() < 0.1 && (bounds.high.x - 15.0).abs() < 0.1);
    }

    #[test]
    fn roofs_without_walls_and_distant_houses_are_left_out() {
        let map = row(&["house", "carport", "house", "house", "house"]);
        let chart = Chart::around(&map, middle(&map), 26.0);
        assert_eq!(chart.buildings, [0, 2, 3]);
        assert_eq!(
            chart.walls.iter().filter(|wall| wall.building == 0).count(),
            4
        );
    }

    #[test]
    fn a_map_without_buildings_gives_an_empty_chart() {
        let chart = Chart::around(&row(&["roof"]), MapPoint::default(), 1e5);
        assert_eq!((chart.walls.len(), chart.bounds()), (0, None));
    }
}
