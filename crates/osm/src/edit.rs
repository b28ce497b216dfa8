//! Entrances added, merged and removed, in OSM's own form: a node on the building's outline with
//! `entrance=*`, and the unit in `ref` and `addr:unit`.
//!
//! Neighbours that share a wall continue to share it: a new node is added to every way along the
//! wall.

use std::collections::{BTreeMap, BTreeSet};

use openbench_core::{Address, Georeference, LonLat, MapPoint};

use crate::areas::is_multipolygon;
use crate::data::OsmData;
use crate::element::{ElementId, ElementKind, Node, Relation, Way};
use crate::map::is_door;
use crate::names::{fold_unit, unit_names};
use crate::projection::Projection;
use crate::tags::Tags;
use crate::write::round7;
use openbench_geometry::Segment;

/// The distance of a door from corners and other doors, metres; a third of a shorter wall. A node
/// at a corner would be of two walls.
const CLEARANCE_M: f64 = 0.05;
/// A node farther than this from the line between its neighbours is a corner, metres. Rounding to
/// seven decimals moves a node by up to 6 mm.
const CORNER_M: f64 = 0.05;
/// Two doors without a unit are the same door if they are no farther apart than this, metres: as
/// far as two sightings of one door differ, and less than two doors of one house are apart.
const SAME_DOOR_M: f64 = 2.0;

/// An entrance after it was written into the data.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct NewEntrance {
    /// Number of its node.
    pub node: i64,
    /// Its position on the building's outline, to the centimetre that OSM files resolve.
    pub position: MapPoint,
    /// The same position on the Earth, as written.
    pub lonlat: LonLat,
}

/// Why an entrance could not be written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// The data lacks the building.
    #[error("the map has no {0}; name a way or relation that is in it")]
    NoSuchBuilding(ElementId),
    /// The building has no wall to put a door in.
    #[error("{0} has no outline in the map, so it cannot have a door")]
    NoOutline(ElementId),
    /// The position is not finite.
    #[error("{0} is not a finite position; give the door's position in metres")]
    NoPosition(MapPoint),
}

/// Writes a door into the wall of `building` nearest to `at` (`map` frame).
///
/// A door of the same unit in that building's outline is moved, not doubled. Without a unit, a
/// nameless door within 2 m is moved.
///
/// # Errors
/// If the data lacks the building, the building has no outline, or `at` is not finite. Nothing has
/// changed then.
pub fn add_entrance(
    data: &mut OsmData,
    projection: &Projection,
    building: ElementId,
    at: MapPoint,
    address: &Address,
) -> Result<NewEntrance, EditError> {
    let mut tags = Tags::from([("entrance", "yes")]);
    if let Some(unit) = &address.unit {
        tags.insert("ref", unit);
        tags.insert("addr:unit", unit);
    }
    write_door(data, projection, building, at, tags)
}

/// Copies the doors of an edited map into `base`, and returns how many.
///
/// Doors are copied whose node `base` lacks or has otherwise, if `base` has their building. A door
/// of the same unit in `base` is moved. Doors are copied in the order in which they were made.
pub fn merge_entrances(base: &mut OsmData, from: &OsmData) -> usize {
    let mut merged = 0;
    let hosts = door_hosts(from);
    // New nodes have descending negative numbers.
    for node in from.nodes.values().rev().filter(|node| is_door(&node.tags)) {
        let Some(host) = hosts.get(&node.id) else {
            continue;
        };
        if base.nodes.get(&node.id) == Some(node) || !base.has(*host) {
            continue;
        }
        let plane = Projection::new(Georeference::tangent_plane(node.position));
        merged += usize::from(
            // The door is the origin of its own plane.
            write_door(base, &plane, *host, MapPoint::default(), node.tags.clone()).is_ok(),
        );
    }
    merged
}

/// How many elements of `from` a copy of `base` into which the doors of `from` are
/// [merged](merge_entrances) lacks, or has with other tags. Doors are not counted, nor what a door
/// that was moved has left: an edited node without tags.
pub fn lost_in_merge(base: &OsmData, from: &OsmData) -> usize {
    let nodes = from.nodes.values().filter(|node| {
        let known = base.nodes.get(&node.id);
        let is_of_door = is_door(&node.tags) || (node.id < 0 && node.tags.is_empty());
        !is_of_door && known.is_none_or(|known| known.tags != node.tags)
    });
    let ways = from.ways.values().filter(|way| {
        let known = base.ways.get(&way.id);
        known.is_none_or(|known| known.tags != way.tags)
    });
    let relations = from.relations.values().filter(|relation| {
        let known = base.relations.get(&relation.id);
        known.is_none_or(|known| known.tags != relation.tags)
    });
    nodes.count() + ways.count() + relations.count()
}

/// The public map: the same map without doors and units.
///
/// Door nodes lose all their tags. They are removed altogether unless an outline has its corner
/// there or a path leads there.
pub fn without_doors(data: &OsmData) -> OsmData {
    let mut public = data.clone();
    // More than entrances: `door=*` alone also shows where to look.
    let doors: BTreeSet<i64> = data
        .nodes
        .values()
        .filter(|n| is_door(&n.tags) || n.tags.says("door"))
        .map(|n| n.id)
        .collect();
    // Looked up once, since a search of all ways for each door takes the product of both.
    let users = ways_of(data, &doors);
    for id in &doors {
        let ways = users.get(id).map_or(&[][..], Vec::as_slice);
        if detach(&mut public, *id, ways) {
            public.nodes.remove(id);
        } else if let Some(node) = public.nodes.get_mut(id) {
            node.tags = Tags::new();
        }
    }
    for relation in public.relations.values_mut() {
        relation
            .members
            .retain(|m| m.kind != ElementKind::Node || !doors.contains(&m.id));
    }
    public
        .nodes
        .values_mut()
        .for_each(|node| forget_units(&mut node.tags));
    public
        .ways
        .values_mut()
        .for_each(|way| forget_units(&mut way.tags));
    public
        .relations
        .values_mut()
        .for_each(|relation| forget_units(&mut relation.tags));
    public
}

fn forget_units(tags: &mut Tags) {
    tags.retain(|key, _| {
        !matches!(
            key,
            "addr:unit" | "addr:flats" | "addr:door" | "addr:floor" | "entrance"
        )
    });
}

fn write_door(
    data: &mut OsmData,
    projection: &Projection,
    building: ElementId,
    at: MapPoint,
    tags: Tags,
) -> Result<NewEntrance, EditError> {
    if !(at.x.is_finite() && at.y.is_finite()) {
        return Err(EditError::NoPosition(at));
    }
    let outline = outline(data, building)?;
    // Checked before anything changes.
    nearest_wall(data, projection, &outline, at).ok_or(EditError::NoOutline(building))?;
    let (id, mut tags) = match same_door(data, projection, &outline, at, &tags) {
        Some(old) => remove_door(data, old, tags),
        None => (free_id(data), tags),
    };
    // Once more: an old door that was removed is no end of a wall any longer.
    let wall =
        nearest_wall(data, projection, &outline, at).ok_or(EditError::NoOutline(building))?;
    // A node in a shared wall is on both outlines. The name tells a reader of the map which house
    // the door belongs to.
    if let Some(name) = data.tags(building).and_then(|tags| tags.get("name"))
        && is_shared(data, &outline, &wall)
    {
        tags.insert("addr:housename", name);
    }
    // Files hold seven decimals, so the door is where a reader of the file will see it.
    let exact = projection.to_lonlat(wall.place);
    let lonlat = LonLat::new(round7(exact.lon), round7(exact.lat));
    insert_between(data, &wall, id);
    data.nodes.insert(
        id,
        Node {
            id,
            position: lonlat,
            tags,
        },
    );
    Ok(NewEntrance {
        node: id,
        position: projection.to_map(lonlat),
        lonlat,
    })
}

/// The ways of a building's outline and its courtyards.
fn outline(data: &OsmData, building: ElementId) -> Result<Vec<i64>, EditError> {
    let missing = EditError::NoSuchBuilding(building);
    match building.kind {
        ElementKind::Node => Err(missing),
        ElementKind::Way if data.ways.contains_key(&building.id) => Ok(vec![building.id]),
        ElementKind::Way => Err(missing),
        ElementKind::Relation => data
            .relations
            .get(&building.id)
            .map(|r| member_ways(r).collect())
            .ok_or(missing),
    }
}

fn member_ways(relation: &Relation) -> impl Iterator<Item = i64> {
    relation
        .members
        .iter()
        .filter(|m| m.kind == ElementKind::Way)
        .map(|m| m.id)
}

/// The side of an outline between two nodes, and a place on it.
struct Wall {
    ends: [i64; 2],
    place: MapPoint,
}

impl Wall {
    fn is_between(&self, pair: &[i64]) -> bool {
        let [a, b] = self.ends;
        pair == [a, b] || pair == [b, a]
    }
}

fn nearest_wall(
    data: &OsmData,
    projection: &Projection,
    outline: &[i64],
    at: MapPoint,
) -> Option<Wall> {
    let mut nearest = None;
    let mut least = f64::INFINITY;
    for way in outline.iter().filter_map(|id| data.ways.get(id)) {
        // Closed ways repeat their first node, so this has all of their sides.
        for pair in way.nodes.windows(2) {
            let Some(side) = side_between(data, projection, pair[0], pair[1]) else {
                continue;
            };
            let distance = side.nearest_point(at).point.distance(at);
            if nearest.is_none() || distance < least {
                least = distance;
                nearest = Some(Wall {
                    ends: [pair[0], pair[1]],
                    place: clear_of_ends(side, at),
                });
            }
        }
    }
    nearest
}

/// The line between two nodes; `None` if the data lacks one of them.
fn side_between(data: &OsmData, projection: &Projection, a: i64, b: i64) -> Option<Segment> {
    let start = data.nodes.get(&a)?.position;
    let end = data.nodes.get(&b)?.position;
    Some(Segment::new(
        projection.to_map(start),
        projection.to_map(end),
    ))
}

fn clear_of_ends(side: Segment, at: MapPoint) -> MapPoint {
    let Segment { start: a, end: b } = side;
    let length = side.length();
    let margin = if length > 3.0 * CLEARANCE_M {
        CLEARANCE_M / length
    } else {
        1.0 / 3.0
    };
    let t = side.nearest_point(at).share.clamp(margin, 1.0 - margin);
    MapPoint::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y))
}

/// Whether another building is on the other side of the wall.
fn is_shared(data: &OsmData, outline: &[i64], wall: &Wall) -> bool {
    let mut others = data
        .ways
        .values()
        .filter(|way| way.tags.says("building") && !outline.contains(&way.id));
    others.any(|way| way.nodes.windows(2).any(|pair| wall.is_between(pair)))
}

fn insert_between(data: &mut OsmData, wall: &Wall, node: i64) {
    for way in data.ways.values_mut() {
        let places: Vec<usize> = (1..way.nodes.len())
            .filter(|i| wall.is_between(&way.nodes[i - 1..=*i]))
            .collect();
        // From the end, so that indices stay right.
        for i in places.into_iter().rev() {
            way.nodes.insert(i, node);
        }
    }
}

/// The door in the outline that leads to the same unit, the nearest if there are several.
fn same_door(
    data: &OsmData,
    projection: &Projection,
    outline: &[i64],
    at: MapPoint,
    tags: &Tags,
) -> Option<i64> {
    let wanted = folded_units(tags);
    let nodes = outline
        .iter()
        .filter_map(|id| data.ways.get(id))
        .flat_map(|way| &way.nodes);
    let doors = nodes
        .filter_map(|id| data.nodes.get(id))
        .filter(|node| is_door(&node.tags));
    let distance = |node: &Node| projection.to_map(node.position).distance(at);
    let same = doors.filter(|node| {
        let units = folded_units(&node.tags);
        // Without names only the place can tell, and only nearby.
        let both_nameless = units.is_empty() && wanted.is_empty();
        both_nameless && distance(node) <= SAME_DOOR_M || !units.is_disjoint(&wanted)
    });
    // The number breaks ties: outlines list a node of a shared wall twice.
    let by_distance = same.map(|node| (distance(node), node.id));
    let nearest = by_distance.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    nearest.map(|(_, id)| id)
}

fn folded_units(tags: &Tags) -> BTreeSet<String> {
    unit_names(tags)
        .iter()
        .map(|name| fold_unit(name))
        .collect()
}

/// Removes a door from the outlines, to be inserted elsewhere. Returns the number and the tags for
/// its new place, where `tags` override the door's old ones. A door at a corner or at the end of a
/// path leaves its node behind and gets a new number.
fn remove_door(data: &mut OsmData, door: i64, tags: Tags) -> (i64, Tags) {
    let ways = ways_of(data, &BTreeSet::from([door]))
        .remove(&door)
        .unwrap_or_default();
    let movable = detach(data, door, &ways);
    let id = if movable { door } else { free_id(data) };
    let mut merged = data
        .nodes
        .get_mut(&door)
        .map(|node| std::mem::take(&mut node.tags))
        .unwrap_or_default();
    for (key, value) in tags.iter() {
        // `entrance=main` is more specific than `entrance=yes`, and stays.
        if key != "entrance" || !merged.has(key) {
            merged.insert(key, value);
        }
    }
    (id, merged)
}

/// Removes a node from `ways`, which are all ways through it, and returns whether it could. It
/// stays if it is a corner or an end of a way, if a road needs it, or if too few nodes would
/// remain.
fn detach(data: &mut OsmData, node: i64, ways: &[i64]) -> bool {
    let shorter: Option<Vec<Vec<i64>>> = ways
        .iter()
        .map(|id| without(data, &data.ways[id], node))
        .collect();
    let Some(shorter) = shorter else { return false };
    for (id, nodes) in ways.iter().zip(shorter) {
        if let Some(way) = data.ways.get_mut(id) {
            way.nodes = nodes;
        }
    }
    true
}

/// The nodes of a way without one that its line does not need; `None` if the line needs it.
fn without(data: &OsmData, way: &Way, node: i64) -> Option<Vec<i64>> {
    let closed = way.is_closed();
    let mut line = way.nodes.clone();
    if closed {
        line.pop();
        // Moves the seam of the ring away from the node.
        // Its neighbours are then before and after it in the list.
        if line[0] == node || line[line.len() - 1] == node {
            let half = line.len() / 2;
            line.rotate_left(half);
        }
    }
    let place = line
        .iter()
        .position(|id| *id == node)
        .filter(|i| (1..line.len() - 1).contains(i))?;
    let straight = is_straight(data, line[place - 1], node, line[place + 1])?;
    line.remove(place);
    let least = if closed { 3 } else { 2 };
    // A road keeps its nodes. A node that the line passes twice is still in it.
    if way.tags.says("highway") || !straight || line.len() < least || line.contains(&node) {
        return None;
    }
    if !closed {
        return Some(line);
    }
    // The ring begins where it began, or with the node after.
    let start = line
        .iter()
        .position(|id| *id == way.nodes[0] || way.nodes[0] == node && *id == way.nodes[1])?;
    line.rotate_left(start);
    line.push(line[0]);
    Some(line)
}

/// Whether `node` lies on the straight line between its neighbours; `None` if the data lacks one of
/// them.
fn is_straight(data: &OsmData, before: i64, node: i64, after: i64) -> Option<bool> {
    let plane = Projection::new(Georeference::tangent_plane(data.nodes.get(&node)?.position));
    let line = side_between(data, &plane, before, after)?;
    let here = MapPoint::default();
    Some(line.nearest_point(here).point.distance(here) <= CORNER_M)
}

/// For each of `nodes` the ways through it, each once.
fn ways_of(data: &OsmData, nodes: &BTreeSet<i64>) -> BTreeMap<i64, Vec<i64>> {
    let mut found: BTreeMap<i64, Vec<i64>> = BTreeMap::new();
    for way in data.ways.values() {
        for node in way.nodes.iter().filter(|node| nodes.contains(node)) {
            let ways = found.entry(*node).or_default();
            // A closed way has its first node twice. Ways are visited one by one, so only the last
            // can be the same.
            if ways.last() != Some(&way.id) {
                ways.push(way.id);
            }
        }
    }
    found
}

/// For each door in an outline its building: a way with `building=*`, else a multipolygon with it.
/// In a shared wall the building named by the door's `addr:housename`, else the first.
fn door_hosts(data: &OsmData) -> BTreeMap<i64, ElementId> {
    let doors = data
        .nodes
        .values()
        .filter(|node| is_door(&node.tags))
        .map(|node| node.id)
        .collect();
    let relations = building_relations(data);
    let mut door_hosts = BTreeMap::new();
    for (door, ways) in ways_of(data, &doors) {
        // A door in a shared wall has several.
        let hosts: Vec<ElementId> = ways
            .iter()
            .filter_map(|way| host_of_way(data, &relations, *way))
            .collect();
        let house = data
            .nodes
            .get(&door)
            .and_then(|node| node.tags.get("addr:housename"));
        let named = hosts
            .iter()
            .find(|host| house.is_some() && name_of(data, **host) == house);
        if let Some(host) = named.or(hosts.first()) {
            door_hosts.insert(door, *host);
        }
    }
    door_hosts
}

/// For each member way of a multipolygon with `building=*` the number of the first such relation.
fn building_relations(data: &OsmData) -> BTreeMap<i64, i64> {
    let mut relations = BTreeMap::new();
    for relation in data
        .relations
        .values()
        .filter(|r| is_multipolygon(r) && r.tags.says("building"))
    {
        for way in member_ways(relation) {
            relations.entry(way).or_insert(relation.id);
        }
    }
    relations
}

/// The building whose outline a way is.
fn host_of_way(data: &OsmData, relations: &BTreeMap<i64, i64>, way: i64) -> Option<ElementId> {
    if data.ways[&way].tags.says("building") {
        return Some(ElementId::way(way));
    }
    relations.get(&way).map(|id| ElementId::relation(*id))
}

fn name_of(data: &OsmData, element: ElementId) -> Option<&str> {
    data.tags(element)?.get("name")
}

/// A negative number below all others: editors number new elements like this.
fn free_id(data: &OsmData) -> i64 {
    let lowest = data
        .nodes
        .first_key_value()
        .map_or(0, |(id, _)| (*id).min(0));
    lowest
        .checked_sub(1)
        // A map may use even the lowest number. Then the highest free negative one is taken. It is
        // found after one step more than there are nodes at most.
        .or_else(|| (i64::MIN..0).rev().find(|id| !data.nodes.contains_key(id)))
        .unwrap_or(i64::MIN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::address::{Location, locate};
    use crate::map::OsmMap;

    const ORIGIN: Georeference = Georeference::tangent_plane(LonLat::new(0.0, 0.0));
    const COURT: ElementId = ElementId::relation(40);
    const HOUSE: ElementId = ElementId::way(24);

    fn data() -> OsmData {
        OsmData::from_xml(include_bytes!("../tests/fixtures/court.osm")).unwrap()
    }

    fn add(data: &mut OsmData, building: ElementId, lon: f64, lat: f64, unit: &str) -> NewEntrance {
        let plane = Projection::new(ORIGIN);
        let at = plane.to_map(LonLat::new(lon, lat));
        add_entrance(data, &plane, building, at, &Address::new("", unit)).unwrap()
    }

    fn find(data: &OsmData, building: &str, unit: &str) -> Option<(i64, MapPoint)> {
        let map = OsmMap::new(data, ORIGIN);
        match locate(&map, &Address::new(building, unit)) {
            Location::Unit { entrance, .. } => Some((
                map.entrances[entrance].node,
                map.entrances[entrance].position,
            )),
            _ => None,
        }
    }

    #[test]
    fn a_door_is_inserted_into_the_nearest_wall() {
        let mut data = data();
        let door = add(&mut data, HOUSE, 0.0004, -0.00002, "unit 7");
        assert_eq!(door.node, -1);
        assert_eq!(door.lonlat, LonLat::new(0.0004, 0.0));
        assert_eq!(data.ways[&24].nodes, [2, -1, 12, 13, 3, 2]);
        assert_eq!(
            data.nodes[&-1].tags.to_string(),
            "addr:unit=unit 7 entrance=yes ref=unit 7"
        );
        assert_eq!(find(&data, "house", "7"), Some((-1, door.position)));
    }

    #[test]
    fn a_door_of_a_multipolygon_is_inserted_into_a_member_way_even_in_a_courtyard() {
        let mut data = data();
        add(&mut data, COURT, -0.00001, 0.0001, "2");
        assert_eq!(data.ways[&21].nodes, [1, -1, 4, 3]);
        add(&mut data, COURT, 0.00015, 0.00012, "3");
        assert_eq!(data.ways[&22].nodes, [5, -2, 6, 7, 8, 5]);
        assert_eq!(
            find(&data, "Court", "unit3").map(|(node, _)| node),
            Some(-2)
        );
    }

    #[test]
    fn a_merged_map_loses_what_the_base_lacks_or_calls_otherwise() {
        let base = without_doors(&data());
        let mut edited = base.clone();
        add(&mut edited, HOUSE, 0.0004, -0.00002, "7");
        let left = edited.nodes[&2].clone();
        edited.nodes.insert(
            -9,
            Node {
                id: -9,
                tags: Tags::new(),
                ..left
            },
        );
        assert_eq!(lost_in_merge(&base, &edited), 0);
        edited
            .ways
            .get_mut(&24)
            .unwrap()
            .tags
            .insert("name", "Mine");
        let corner = edited.nodes[&2].clone();
        edited.nodes.insert(99, Node { id: 99, ..corner });
        edited.relations.clear();
        assert_eq!(lost_in_merge(&base, &edited), 2);
        assert!(lost_in_merge(&OsmData::default(), &base) > 2);
    }

    #[test]
    fn a_shared_wall_stays_shared_and_the_door_names_its_building() {
        let mut data = data();
        add(&mut data, COURT, 0.0003, 0.0001, "9");
        assert_eq!(data.ways[&20].nodes, [1, 2, -1, 3]);
        assert_eq!(data.ways[&24].nodes, [2, 12, 13, 3, -1, 2]);
        assert_eq!(find(&data, "Court", "9").map(|(node, _)| node), Some(-1));
        assert_eq!(find(&data, "House", "9"), None);
    }

    #[test]
    fn a_known_door_is_moved_not_doubled() {
        let mut data = data();
        add(&mut data, HOUSE, 0.0004, 0.0, "7");
        let moved = add(&mut data, HOUSE, 0.0005, 0.0001, "Unit 7");
        assert_eq!(moved.node, -1);
        assert_eq!(data.ways[&24].nodes, [2, 12, -1, 13, 3, 2]);
        assert_eq!(data.nodes[&-1].tags.get("ref"), Some("Unit 7"));
    }

    #[test]
    fn a_door_at_a_corner_leaves_the_corner_behind() {
        let mut data = data();
        let moved = add(&mut data, HOUSE, 0.0004, 0.0, "1");
        assert_eq!(moved.node, -1);
        assert_eq!(data.ways[&24].nodes, [2, -1, 12, 13, 3, 2]);
        assert!(data.nodes[&13].tags.is_empty());
        assert!(data.nodes[&-1].tags.is("entrance", "main"));
    }

    #[test]
    fn two_doors_at_one_place_stay_apart() {
        let mut data = data();
        let a = add(&mut data, HOUSE, 0.0004, 0.0, "7");
        let b = add(&mut data, HOUSE, 0.0004, 0.0, "8");
        assert!((0.03..0.1).contains(&a.position.distance(b.position)));
    }

    #[test]
    fn buildings_without_a_wall_get_no_door() {
        let mut data = data();
        let plane = Projection::new(ORIGIN);
        let mut add = |building, x| {
            add_entrance(
                &mut data,
                &plane,
                building,
                MapPoint::new(x, 0.0),
                &Address::new("", "1"),
            )
            .unwrap_err()
        };
        assert_eq!(
            add(ElementId::way(5), 0.0),
            EditError::NoSuchBuilding(ElementId::way(5))
        );
        assert_eq!(
            add(ElementId::way(27), 0.0),
            EditError::NoOutline(ElementId::way(27))
        );
        assert!(matches!(add(HOUSE, f64::NAN), EditError::NoPosition(_)));
    }

    #[test]
    fn doors_of_two_edited_maps_are_merged() {
        let (mut base, mut other) = (data(), data());
        add(&mut base, HOUSE, 0.0004, 0.0, "7");
        add(&mut other, COURT, 0.0001, 0.0, "2");
        add(&mut other, HOUSE, 0.00045, 0.0003, "7");
        assert_eq!(merge_entrances(&mut base, &other), 2);
        assert_eq!(find(&base, "Court", "2").map(|(node, _)| node), Some(-2));
        let (node, place) = find(&base, "House", "7").unwrap();
        assert_eq!(node, -1);
        assert!(place.distance(find(&other, "House", "7").unwrap().1) < 0.02);
        let merged = base.clone();
        merge_entrances(&mut base, &other);
        assert_eq!(
            (base.ways, base.nodes),
            (merged.ways, merged.nodes),
            "merging again changes nothing"
        );
    }

    #[test]
    fn the_public_map_has_no_doors_and_the_same_outlines() {
        let plain = without_doors(&data());
        let mut edited = data();
        add(&mut edited, HOUSE, 0.0004, 0.0, "7");
        add(&mut edited, COURT, 0.00015, 0.0001, "3");
        edited
            .ways
            .get_mut(&24)
            .unwrap()
            .tags
            .insert("addr:unit", "7");
        let public = without_doors(&edited);
        assert_eq!(
            String::from_utf8(public.to_xml()),
            String::from_utf8(plain.to_xml())
        );
        assert!(public.nodes.contains_key(&13), "the corner stays");
        let map = OsmMap::new(&public, ORIGIN);
        assert!(map.entrances.is_empty());
        assert_eq!(map.buildings.len(), 3);
    }
}
