//! The map as a robot uses it: buildings, roads, barriers, areas and entrances in metres.
//!
//! Heights and levels are left out, since a robot on the ground meets the outline, and so is
//! everything below the ground. Parts of buildings (`building:part=*`) are areas.

use std::collections::{BTreeMap, BTreeSet};

use openbench_core::{Georeference, MapPoint};

use crate::areas::{Shaper, Shapes, is_area, is_multipolygon};
use crate::data::OsmData;
use crate::element::{ElementId, ElementKind, Relation, Way};
use crate::name_index::NameIndex;
use crate::names::{building_name, fold, full_names, unit_names};
use crate::projection::Projection;
use crate::spatial::BoxTree;
use crate::tags::Tags;
use openbench_geometry::Polygon;

/// A door farther than this from every outline belongs to no building, metres: porches and canopies
/// stand so far in front of a wall, and many maps are no more exact.
const DOOR_REACH_M: f64 = 3.0;
/// Most nodes of a road or barrier. The OSM database allows 2,000; a way that goes back and forth a
/// hundred thousand times is no road.
const MOST_NODES: usize = 5_000;

/// A building.
#[derive(Debug, Clone, PartialEq)]
pub struct Building {
    /// The way or relation that it was made from.
    pub element: ElementId,
    /// Its usual name, see [`building_name`].
    pub name: Option<String>,
    /// Its outline.
    pub polygon: Polygon,
    /// The tags of the element.
    pub tags: Tags,
}

/// A way with `highway=*`, or the part of one between nodes that the data lacks. A routing profile
/// decides whether it may be used.
#[derive(Debug, Clone, PartialEq)]
pub struct Road {
    /// Number of the way.
    pub way: i64,
    /// The nodes in order, two or more.
    pub nodes: Vec<i64>,
    /// The positions of those nodes.
    pub points: Vec<MapPoint>,
    /// The tags of the way.
    pub tags: Tags,
}

/// A wall, fence, hedge, kerb or the like.
#[derive(Debug, Clone, PartialEq)]
pub struct Barrier {
    /// Number of the way.
    pub way: i64,
    /// Its line. The first and the last point are equal if it is closed.
    pub points: Vec<MapPoint>,
    /// Where it can be passed: nodes with `barrier=gate`, `barrier=entrance`, `kerb=lowered` and
    /// the like.
    pub gates: Vec<MapPoint>,
    /// The tags of the way.
    pub tags: Tags,
}

/// Water, grass, a car park, land use, a part of a building, …
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    /// The way or relation that it was made from.
    pub element: ElementId,
    /// Its outline.
    pub polygon: Polygon,
    /// The tags of the element.
    pub tags: Tags,
}

/// A door: a node with `entrance=*` or `building=entrance`, or with `addr:unit` and `door=*`.
#[derive(Debug, Clone, PartialEq)]
pub struct Entrance {
    /// Number of the node.
    pub node: i64,
    /// Its position.
    pub position: MapPoint,
    /// Index of the building that it belongs to, if it is on an outline or within 3 m of one.
    pub building: Option<usize>,
    /// Names of its unit: `addr:unit`, `ref`, `name`, in this order, each once.
    pub units: Vec<String>,
    /// The tags of the node.
    pub tags: Tags,
}

/// Elements that could not be used, counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct MapReport {
    /// Buildings without an outline: not closed, with too few nodes in the data, or without area.
    pub broken_buildings: usize,
    /// Multipolygons of other areas without an outline.
    pub broken_areas: usize,
    /// Stretches of roads and barriers that were skipped: they have more than 5,000 nodes, or very
    /// many of them share long lists of tags.
    pub long_lines: usize,
    /// Rings of multipolygons that were skipped: they do not close, are holes in nothing, or many
    /// rings reuse a few ways.
    pub open_rings: usize,
    /// Entrances near no building.
    pub stray_entrances: usize,
}

/// OSM data in the `map` frame.
#[derive(Debug, Clone)]
pub struct OsmMap {
    /// The projection from degrees to metres.
    pub projection: Projection,
    /// By element: ways, then relations; a relation with several outer rings gives several
    /// buildings.
    pub buildings: Vec<Building>,
    /// By number of the way.
    pub roads: Vec<Road>,
    /// By number of the way.
    pub barriers: Vec<Barrier>,
    /// By element: ways, then relations.
    pub areas: Vec<Area>,
    /// By number of the node.
    pub entrances: Vec<Entrance>,
    /// Elements that could not be used.
    pub report: MapReport,
    outlines: BoxTree,
    pub(crate) names: NameIndex,
}

impl OsmMap {
    /// Projects `data` into the `map` frame of `georeference`.
    pub fn new(data: &OsmData, georeference: Georeference) -> Self {
        let mut map = Self {
            projection: Projection::new(georeference),
            buildings: Vec::new(),
            roads: Vec::new(),
            barriers: Vec::new(),
            areas: Vec::new(),
            entrances: Vec::new(),
            report: MapReport::default(),
            outlines: BoxTree::default(),
            names: NameIndex::default(),
        };
        // A copy, since the shaper borrows it while `map` is filled.
        let projection = map.projection.clone();
        let shaper = Shaper::new(data, &projection);
        // In this order: doors look for their building among the outlines, and names include the
        // addresses of doors.
        map.add_areas(&shaper);
        map.outlines = outlines(&map.buildings);
        map.add_lines(&shaper);
        map.add_entrances(&shaper);
        map.names = map.name_index();
        map
    }

    /// The same with some buildings, and their entrances, so many metres further east and north.
    /// Indices stay.
    #[must_use]
    pub fn with_buildings_moved(&self, shifts: &BTreeMap<usize, MapPoint>) -> Self {
        let mut map = self.clone();
        for (index, building) in map.buildings.iter_mut().enumerate() {
            if let Some(shift) = shifts.get(&index) {
                building.polygon = building.polygon.moved(*shift);
            }
        }
        for entrance in &mut map.entrances {
            if let Some(shift) = entrance.building.and_then(|index| shifts.get(&index)) {
                let at = entrance.position;
                entrance.position = MapPoint::new(at.x + shift.x, at.y + shift.y);
            }
        }
        map.outlines = outlines(&map.buildings);
        map
    }

    /// Index of the building nearest to `point`, whose distance is 0 inside and otherwise that to
    /// the outline. `None` only if there are no buildings.
    pub fn nearest_building(&self, point: MapPoint) -> Option<usize> {
        let nearest = self
            .outlines
            .nearest(point, |i| self.distance_to_building(i, point))?;
        Some(nearest.index)
    }

    /// Indices of the buildings within `radius` metres of `point`, in order.
    pub fn buildings_within(&self, point: MapPoint, radius: f64) -> Vec<usize> {
        let mut near = self.outlines.within(point, radius);
        near.retain(|i| self.distance_to_building(*i, point) <= radius);
        near
    }

    /// Metres from `point` to building `index`, 0 inside.
    ///
    /// # Panics
    /// If there is no such building.
    pub fn distance_to_building(&self, index: usize, point: MapPoint) -> f64 {
        let polygon = &self.buildings[index].polygon;
        if polygon.contains(point) {
            0.0
        } else {
            polygon.distance_to_boundary(point)
        }
    }

    fn name_index(&self) -> NameIndex {
        let buildings = self.buildings.iter().map(|building| &building.tags);
        let doors = self
            .entrances
            .iter()
            .filter_map(|door| Some((door.building?, &door.tags)));
        NameIndex::new(buildings, doors)
    }

    fn add_areas(&mut self, shaper: &Shaper<'_>) {
        // Relations are read first, because they decide which ways are mere outlines. They are
        // appended last, because ways come first in the lists.
        let mut relations = Vec::new();
        let mut other_areas = Vec::new();
        // Some old outlines repeat the building's tags.
        let mut outlines_of_relations = BTreeSet::new();
        for relation in shaper
            .data
            .relations
            .values()
            .filter(|relation| is_multipolygon(relation))
        {
            if relation.tags.says("building") {
                let found = self.relation_buildings(shaper, relation);
                // A broken multipolygon takes no way's place: the way may still be a building.
                if !found.is_empty() {
                    outlines_of_relations.extend(outline_ways(relation));
                }
                relations.extend(found);
            } else if is_area(&relation.tags) {
                other_areas.extend(self.relation_areas(shaper, relation));
            }
        }
        for way in shaper.data.ways.values() {
            if way.tags.says("building") && !outlines_of_relations.contains(&way.id) {
                self.add_way_building(shaper, way);
            } else if !way.tags.says("building") && is_area(&way.tags) {
                let element = ElementId::way(way.id);
                let polygon = shaper.way(way);
                self.areas
                    .extend(polygon.map(|polygon| area(element, polygon, &way.tags)));
            }
        }
        self.buildings.append(&mut relations);
        self.areas.append(&mut other_areas);
    }

    fn add_way_building(&mut self, shaper: &Shaper<'_>, way: &Way) {
        let polygon = shaper.way(way);
        self.report.broken_buildings += usize::from(polygon.is_none());
        let element = ElementId::way(way.id);
        self.buildings
            .extend(polygon.map(|polygon| building(element, polygon, &way.tags)));
    }

    fn relation_buildings(&mut self, shaper: &Shaper<'_>, relation: &Relation) -> Vec<Building> {
        let Shapes {
            polygons,
            unused_rings,
        } = shaper.relation(relation);
        self.report.open_rings += unused_rings;
        self.report.broken_buildings += usize::from(polygons.is_empty());
        let element = ElementId::relation(relation.id);
        polygons
            .into_iter()
            .map(|polygon| building(element, polygon, &relation.tags))
            .collect()
    }

    fn relation_areas(&mut self, shaper: &Shaper<'_>, relation: &Relation) -> Vec<Area> {
        let Shapes {
            polygons,
            unused_rings,
        } = shaper.relation(relation);
        self.report.open_rings += unused_rings;
        self.report.broken_areas += usize::from(polygons.is_empty());
        let element = ElementId::relation(relation.id);
        polygons
            .into_iter()
            .map(|polygon| area(element, polygon, &relation.tags))
            .collect()
    }

    fn add_lines(&mut self, shaper: &Shaper<'_>) {
        for way in shaper.data.ways.values() {
            if way.tags.says("highway") {
                let runs = self.runs(shaper, way).into_iter();
                self.roads.extend(runs.map(|run| road(way, run)));
            }
            if is_barrier(&way.tags) {
                let runs = self.runs(shaper, way).into_iter();
                self.barriers
                    .extend(runs.map(|run| barrier(shaper.data, way, run)));
            }
        }
    }

    /// The stretches of a way between nodes that the data lacks. Joining across a gap would invent
    /// a road.
    fn runs(&mut self, shaper: &Shaper<'_>, way: &Way) -> Vec<Run> {
        let found: Vec<Option<(i64, MapPoint)>> = way
            .nodes
            .iter()
            .map(|node| shaper.point(*node).map(|point| (*node, point)))
            .collect();
        let mut runs = Vec::new();
        for stretch in found.split(Option::is_none).filter(|s| s.len() > 1) {
            let mut stretch: Vec<(i64, MapPoint)> = stretch.iter().flatten().copied().collect();
            // A road that stays at a node has no direction there.
            stretch.dedup_by_key(|(node, _)| *node);
            if stretch.len() > MOST_NODES || !shaper.afford(stretch.len(), &way.tags) {
                self.report.long_lines += 1;
            } else if stretch.len() > 1 {
                let (nodes, points) = stretch.into_iter().unzip();
                runs.push(Run { nodes, points });
            }
        }
        runs
    }

    fn add_entrances(&mut self, shaper: &Shaper<'_>) {
        for node in shaper
            .data
            .nodes
            .values()
            .filter(|node| is_door(&node.tags))
        {
            let position = shaper.projection.to_map(node.position);
            let building = self.building_of_door(position, &node.tags);
            self.report.stray_entrances += usize::from(building.is_none());
            let units = unit_names(&node.tags);
            self.entrances.push(Entrance {
                node: node.id,
                position,
                building,
                units,
                tags: node.tags.clone(),
            });
        }
    }

    /// The building whose outline is nearest. Where outlines touch, the door's own address decides,
    /// then the lower index.
    fn building_of_door(&self, position: MapPoint, tags: &Tags) -> Option<usize> {
        let distance = |i: &usize| self.buildings[*i].polygon.distance_to_boundary(position);
        let near: Vec<usize> = self.outlines.within(position, DOOR_REACH_M);
        let nearest = near
            .iter()
            .map(distance)
            .min_by(f64::total_cmp)
            // So far only the boxes are known to be within reach.
            .filter(|d| *d <= DOOR_REACH_M)?;
        let touching: Vec<usize> = near
            .into_iter()
            // Files give positions to a centimetre, so outlines that share a wall may differ by
            // that.
            .filter(|i| distance(i) <= nearest + 0.01)
            .collect();
        let address: Vec<String> = tags
            .get("addr:housename")
            .map(fold)
            .into_iter()
            .chain(street_addresses(tags))
            .collect();
        let named = touching.iter().find(|i| {
            full_names(&self.buildings[**i].tags)
                .iter()
                .any(|n| address.contains(n))
        });
        named.or(touching.first()).copied()
    }
}

/// To find buildings by a place.
fn outlines(buildings: &[Building]) -> BoxTree {
    BoxTree::new(buildings.iter().map(|building| building.polygon.bounds()))
}

/// The full names in a door's address. Its own `name` is left out: it names the unit.
fn street_addresses(tags: &Tags) -> Vec<String> {
    let mut address = tags.clone();
    address.retain(|key, _| key.starts_with("addr:"));
    full_names(&address)
}

fn road(way: &Way, run: Run) -> Road {
    Road {
        way: way.id,
        nodes: run.nodes,
        points: run.points,
        tags: way.tags.clone(),
    }
}

fn barrier(data: &OsmData, way: &Way, run: Run) -> Barrier {
    let points = run.nodes.iter().zip(&run.points);
    let gates = points.filter(|(node, _)| is_gate(data, **node, &way.tags));
    let gates = gates.map(|(_, point)| *point).collect();
    Barrier {
        way: way.id,
        gates,
        points: run.points,
        tags: way.tags.clone(),
    }
}

/// The ways of a multipolygon that are not holes.
fn outline_ways(relation: &Relation) -> impl Iterator<Item = i64> {
    let outline = relation
        .members
        .iter()
        .filter(|m| m.kind == ElementKind::Way && m.role != "inner");
    outline.map(|member| member.id)
}

fn area(element: ElementId, polygon: Polygon, tags: &Tags) -> Area {
    Area {
        element,
        polygon,
        tags: tags.clone(),
    }
}

fn building(element: ElementId, polygon: Polygon, tags: &Tags) -> Building {
    Building {
        element,
        name: building_name(tags),
        polygon,
        tags: tags.clone(),
    }
}

/// Whether a node is a door of a building.
pub(crate) fn is_door(tags: &Tags) -> bool {
    tags.says("entrance")
        || tags.is("building", "entrance")
        || tags.has("addr:unit") && tags.says("door")
}

/// Whether a way is an obstacle.
fn is_barrier(tags: &Tags) -> bool {
    tags.says("barrier") && !(tags.is("barrier", "kerb") && kerb_height(tags) <= LOW_KERB_M)
        || tags.is("historic", "citywalls")
        || tags.is("man_made", "retaining_wall")
        || tags.is("natural", "hedge")
        || tags.is("landuse", "hedge")
}

fn is_gate(data: &OsmData, node: i64, barrier: &Tags) -> bool {
    const GATES: [&str; 7] = [
        "gate",
        "entrance",
        "lift_gate",
        "swing_gate",
        "sliding_gate",
        "kissing_gate",
        "wicket_gate",
    ];
    let Some(node) = data.nodes.get(&node) else {
        return false;
    };
    let is_lowered_kerb = barrier.is("barrier", "kerb")
        && node.tags.has("kerb")
        && kerb_height(&node.tags) <= LOW_KERB_M;
    node.tags
        .get("barrier")
        .is_some_and(|kind| GATES.contains(&kind))
        || is_lowered_kerb
}

/// The height of kerbs that can be driven over, metres. The OSM wiki calls higher ones raised.
const LOW_KERB_M: f64 = 0.03;

/// Height of a kerb, metres: `height`, else `kerb:height`, else the usual height for the value of
/// `kerb`.
pub fn kerb_height(tags: &Tags) -> f64 {
    tags.metres("height")
        .or(tags.metres("kerb:height"))
        .unwrap_or_else(|| usual_kerb_height(tags))
}

fn usual_kerb_height(tags: &Tags) -> f64 {
    match tags.get("kerb") {
        Some("flush" | "no") => 0.0,
        Some("lowered") => LOW_KERB_M,
        Some("rolled") => 0.07,
        _ => 0.12,
    }
}

/// A stretch of a way whose nodes the data has, two or more.
struct Run {
    nodes: Vec<i64>,
    points: Vec<MapPoint>,
}

#[cfg(test)]
mod tests {
    use openbench_core::LonLat;

    use super::*;

    fn court() -> OsmMap {
        let data = OsmData::from_xml(include_bytes!("../tests/fixtures/court.osm")).unwrap();
        OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(0.0, 0.0)))
    }

    #[test]
    fn a_moved_building_is_found_where_it_is_now() {
        let map = court();
        let at = map.buildings[0].polygon.centroid();
        let far = MapPoint::new(at.x + 1000.0, at.y);
        let moved = map.with_buildings_moved(&BTreeMap::from([(0, MapPoint::new(1000.0, 0.0))]));
        assert_eq!(map.buildings_within(at, 0.0), [0]);
        assert!(moved.buildings_within(at, 0.0).is_empty());
        assert_eq!(moved.nearest_building(far), Some(0));
        assert_eq!(moved.buildings[1], map.buildings[1]);
    }

    #[test]
    fn buildings_are_ways_then_multipolygons_with_holes_and_several_outlines() {
        let map = court();
        let found: Vec<_> = map
            .buildings
            .iter()
            .map(|b| (b.element.to_string(), b.name.as_deref()))
            .collect();
        let [house, court] = [
            ("way 24".to_owned(), Some("House")),
            ("relation 40".to_owned(), Some("Court")),
        ];
        assert_eq!(found, [house, court.clone(), court]);
        let big = &map.buildings[1].polygon;
        assert_eq!(
            (big.outer.len(), big.holes.len(), big.holes[0].len()),
            (4, 1, 4)
        );
        // 33.4 m by 33.2 m without a courtyard of a third of that each way.
        assert!(
            (big.area() - 33.4 * 33.2 * 8.0 / 9.0).abs() < 5.0,
            "{}",
            big.area()
        );
        assert_eq!(map.buildings[2].polygon.outer.len(), 3);
    }

    #[test]
    fn elements_without_an_outline_are_counted() {
        let expected = MapReport {
            long_lines: 0,
            broken_buildings: 4,
            broken_areas: 0,
            open_rings: 1,
            stray_entrances: 1,
        };
        assert_eq!(court().report, expected);
    }

    #[test]
    fn roads_and_barriers_with_too_many_nodes_are_counted() {
        let counted = |nodes: usize| {
            let mut text = String::from("<osm version='0.6'>");
            for node in 1..=nodes {
                text += &format!("<node id='{node}' lat='0' lon='{}'/>", node as f64 * 1e-5);
            }
            for (way, tag) in [(1, "highway' v='path"), (2, "barrier' v='fence")] {
                let ends: String = (1..=nodes).map(|n| format!("<nd ref='{n}'/>")).collect();
                text += &format!("<way id='{way}'>{ends}<tag k='{tag}'/></way>");
            }
            let data = OsmData::from_xml((text + "</osm>").as_bytes()).unwrap();
            let map = OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(0.0, 0.0)));
            (map.roads.len(), map.barriers.len(), map.report.long_lines)
        };
        assert_eq!(counted(MOST_NODES), (1, 1, 0));
        assert_eq!(counted(MOST_NODES + 1), (0, 0, 2));
    }

    #[test]
    fn a_road_breaks_where_nodes_are_missing() {
        let roads: Vec<_> = court()
            .roads
            .into_iter()
            .map(|road| (road.way, road.nodes))
            .collect();
        assert_eq!(roads, [(28, vec![1, 9]), (28, vec![11, 14])]);
    }

    #[test]
    fn fences_have_gates_and_grass_and_water_are_areas() {
        let map = court();
        assert_eq!(
            (
                map.barriers.len(),
                map.barriers[0].points.len(),
                map.barriers[0].gates.len()
            ),
            (1, 3, 1)
        );
        let areas: Vec<_> = map
            .areas
            .iter()
            .map(|area| area.element.to_string())
            .collect();
        assert_eq!(areas, ["way 30", "relation 42"]);
    }

    #[test]
    fn doors_are_assigned_to_their_building() {
        let doors: Vec<_> = court()
            .entrances
            .into_iter()
            .map(|e| (e.node, e.building, e.units))
            .collect();
        assert_eq!(
            doors,
            [(13, Some(0), vec!["1".to_owned()]), (14, None, vec![])]
        );
    }

    #[test]
    fn distances_to_buildings_count_from_the_wall_and_courtyards_are_outside() {
        let map = court();
        let at = |lon, lat| map.projection.to_map(LonLat::new(lon, lat));
        assert_eq!(map.nearest_building(at(0.0006, 0.0001)), Some(0));
        assert_eq!(map.nearest_building(at(0.0001, 0.00055)), Some(2));
        let yard = at(0.00015, 0.00015);
        assert_eq!(map.nearest_building(yard), Some(1));
        assert!((map.distance_to_building(1, yard) - 5.5).abs() < 0.1);
        assert_eq!(map.distance_to_building(1, at(0.00005, 0.00005)), 0.0);
        assert_eq!(map.buildings_within(yard, 20.0), [0, 1]);
        assert_eq!(
            OsmMap::new(&OsmData::default(), map.projection.georeference()).nearest_building(yard),
            None
        );
    }
}
