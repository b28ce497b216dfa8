//! The map while it is being changed.

use std::collections::{BTreeMap, BTreeSet};

use openbench_core::{LonLat, MapPoint, Pose2};
use openbench_geometry::Polygon;
use rand::RngExt;

use crate::data::OsmData;
use crate::draws::{element_number, pick, stream};
use crate::element::{ElementId, ElementKind, Node, Way};
use crate::map::OsmMap;
use crate::projection::Projection;
use crate::renumber::renumbered;
use crate::tags::Tags;
use crate::write::round7;

use super::building_error::{BuildingError, MapState};
use super::footprint::Footprint;
use super::numbers::{nameless, numbered_names, renumber};
use super::outline::{Swelling, rectangle_around};
use super::purpose::Purpose;

/// A map that is being changed. Positions are in metres in the true `map` frame until the end.
pub(super) struct Draft {
    data: OsmData,
    projection: Projection,
    positions: BTreeMap<i64, MapPoint>,
    users: BTreeMap<i64, BTreeSet<User>>,
    next_node: i64,
    /// Buildings that are not there.
    invented: Vec<Polygon>,
}

/// What uses a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum User {
    Building(ElementId),
    Road,
    Other,
}

impl Draft {
    /// A draft of a map whose buildings have these footprints.
    pub(super) fn new(
        data: &OsmData,
        map: &OsmMap,
        footprints: &BTreeMap<ElementId, Footprint>,
    ) -> Self {
        let projection = map.projection.clone();
        let place = |node: &Node| (node.id, projection.to_map(node.position));
        Self {
            positions: data.nodes.values().map(place).collect(),
            users: users(data, footprints),
            next_node: data.nodes.keys().next_back().map_or(1, |id| id + 1),
            projection,
            data: data.clone(),
            invented: Vec::new(),
        }
    }

    /// Gives buildings wrong numbers, or takes their names. One that has none is right as it is.
    pub(super) fn rename(&mut self, buildings: &mut BTreeMap<ElementId, BuildingError>, seed: u64) {
        let tags = buildings.keys().filter_map(|id| self.data.tags(*id));
        let mut taken: BTreeSet<String> = tags.flat_map(numbered_names).collect();
        for (element, error) in buildings {
            let Some(tags) = self.tags_mut(*element) else {
                continue;
            };
            let wrong = match error.state {
                MapState::WrongNumber => {
                    let number = element_number(*element);
                    let mut draws = stream(seed, Purpose::Number as u64, number);
                    renumber(tags, &taken, &mut draws)
                }
                MapState::Unnamed => Some(nameless(tags)).filter(|wrong| wrong != tags),
                MapState::Right | MapState::Missing => continue,
            };
            match wrong {
                Some(wrong) => *tags = wrong,
                None => error.state = MapState::Right,
            }
            taken.extend(numbered_names(tags));
        }
    }

    fn tags_mut(&mut self, element: ElementId) -> Option<&mut Tags> {
        match element.kind {
            ElementKind::Node => self.data.nodes.get_mut(&element.id).map(|n| &mut n.tags),
            ElementKind::Way => self.data.ways.get_mut(&element.id).map(|w| &mut w.tags),
            ElementKind::Relation => {
                let relation = self.data.relations.get_mut(&element.id);
                relation.map(|relation| &mut relation.tags)
            }
        }
    }

    /// Removes the roads and paths for which `is_missing` holds, and returns how many.
    pub(super) fn remove_roads(&mut self, is_missing: impl Fn(i64) -> bool) -> usize {
        let roads = self.data.ways.values().filter(|w| w.tags.says("highway"));
        let missing: Vec<i64> = roads.map(|w| w.id).filter(|id| is_missing(*id)).collect();
        self.remove_elements(&missing, &[]);
        missing.len()
    }

    /// Moves the nodes of roads that belong to nothing else.
    pub(super) fn move_roads(&mut self, moved: impl Fn(MapPoint) -> MapPoint) {
        for (node, position) in &mut self.positions {
            let users = self.users.get(node);
            let is_of_roads = |u: &BTreeSet<User>| u.iter().all(|user| *user == User::Road);
            if users.is_some_and(is_of_roads) {
                *position = moved(*position);
            }
        }
    }

    /// Removes a building with all that is its own.
    pub(super) fn remove(&mut self, footprint: &Footprint) {
        self.remove_elements(&footprint.ways, &footprint.relations);
        for node in &footprint.inside {
            self.data.nodes.remove(node);
            let is_it = |kind, id| kind == ElementKind::Node && id == *node;
            self.forget_members(is_it);
        }
    }

    fn remove_elements(&mut self, ways: &[i64], relations: &[i64]) {
        for way in ways {
            self.data.ways.remove(way);
        }
        for relation in relations {
            self.data.relations.remove(relation);
        }
        if !(ways.is_empty() && relations.is_empty()) {
            self.forget_members(|kind, id| match kind {
                ElementKind::Node => false,
                ElementKind::Way => ways.contains(&id),
                ElementKind::Relation => relations.contains(&id),
            });
        }
    }

    fn forget_members(&mut self, is_gone: impl Fn(ElementKind, i64) -> bool) {
        for relation in self.data.relations.values_mut() {
            relation.members.retain(|m| !is_gone(m.kind, m.id));
        }
    }

    /// Draws a building as it is in the wrong map, apart from the shift of the whole map. Returns
    /// whether its outline was simplified.
    pub(super) fn change(
        &mut self,
        element: ElementId,
        footprint: &Footprint,
        error: &BuildingError,
        swelling: Swelling,
    ) -> bool {
        let is_simplified = error.is_simplified && self.simplify(element, footprint);
        let moved = |at: MapPoint| {
            let swollen = swelling.apply(at);
            MapPoint::new(swollen.x + error.shift.x, swollen.y + error.shift.y)
        };
        let own = self.take_nodes(element, footprint);
        for node in own.iter().chain(&footprint.inside) {
            if let Some(position) = self.positions.get_mut(node) {
                *position = moved(*position);
            }
        }
        is_simplified
    }

    /// Gives a building nodes of its own in place of those that it shares; returns all its nodes.
    fn take_nodes(&mut self, element: ElementId, footprint: &Footprint) -> BTreeSet<i64> {
        let mut own: BTreeMap<i64, i64> = BTreeMap::new();
        for way in &footprint.ways {
            let nodes = self.data.ways.get(way).map(|way| way.nodes.clone());
            let nodes = nodes.unwrap_or_default().into_iter();
            let nodes = nodes
                .map(|node| match own.get(&node) {
                    Some(copy) => *copy,
                    None => {
                        let copy = self.own_node(element, node);
                        own.insert(node, copy);
                        copy
                    }
                })
                .collect();
            if let Some(way) = self.data.ways.get_mut(way) {
                way.nodes = nodes;
            }
        }
        own.into_values().collect()
    }

    /// The node itself if nothing else uses it, else a copy without tags.
    fn own_node(&mut self, element: ElementId, node: i64) -> i64 {
        let is_shared = self.users.get(&node).is_some_and(|users| {
            let own = User::Building(element);
            users.iter().any(|user| *user != own)
        });
        match self.positions.get(&node).copied() {
            Some(at) if is_shared => self.add_node(at, User::Building(element)),
            // Its own, or one that the data lacks.
            _ => node,
        }
    }

    fn add_node(&mut self, at: MapPoint, user: User) -> i64 {
        let id = self.next_node;
        self.next_node += 1;
        let node = Node {
            id,
            ..Node::default()
        };
        self.data.nodes.insert(id, node);
        self.positions.insert(id, at);
        self.users.insert(id, BTreeSet::from([user]));
        id
    }

    /// Replaces the outline of a building that is one closed way by the smallest rectangle around
    /// it; false for others, and for rectangles.
    fn simplify(&mut self, element: ElementId, footprint: &Footprint) -> bool {
        let [way] = footprint.ways[..] else {
            return false;
        };
        // Four corners: the last node is the first one.
        let corners = self.data.ways.get(&way).map_or(0, |way| way.nodes.len());
        if corners <= 5 || !footprint.relations.is_empty() {
            return false;
        }
        let Some(rectangle) = rectangle_around(&footprint.polygon.outer) else {
            return false;
        };
        let corners = rectangle.map(|at| self.add_node(at, User::Building(element)));
        if let Some(way) = self.data.ways.get_mut(&way) {
            way.nodes = corners.into_iter().chain([corners[0]]).collect();
        }
        true
    }

    /// Adds buildings that are not there.
    pub(super) fn invent(&mut self, outlines: Vec<Polygon>) {
        self.invented.extend(outlines);
    }

    /// The wrong map, with the whole of it displaced by `frame`.
    pub(super) fn finish(mut self, frame: Pose2, seed: u64) -> OsmData {
        self.remove_unused_nodes();
        for (id, node) in &mut self.data.nodes {
            let Some(at) = self.positions.get(id) else {
                continue;
            };
            let moved = self.projection.to_lonlat(frame.transform(at.x, at.y));
            let (lon, lat) = (round7(moved.lon), round7(moved.lat));
            // False for NaN: far outside its zone, a projection has no inverse.
            if lon.abs() <= 180.0 && lat.abs() <= 90.0 {
                (node.position.lon, node.position.lat) = (lon, lat);
            }
        }
        let places = self.invented.iter().map(|outline| {
            let ring = outline.outer.iter();
            let moved = ring.map(|at| frame.transform(at.x, at.y));
            moved.map(|at| self.projection.to_lonlat(at)).collect()
        });
        let places: Vec<Vec<LonLat>> = places.collect();
        with_buildings(renumbered(&self.data), &places, seed)
    }

    /// Removes nodes that ways used before, that nothing uses now, and that say nothing.
    fn remove_unused_nodes(&mut self) {
        let ways = self.data.ways.values().flat_map(|way| &way.nodes);
        let relations = self.data.relations.values().flat_map(|r| &r.members);
        let members = relations.filter(|m| m.kind == ElementKind::Node);
        let used: BTreeSet<i64> = ways.copied().chain(members.map(|m| m.id)).collect();
        let users = &self.users;
        self.data.nodes.retain(|id, node| {
            used.contains(id) || !node.tags.is_empty() || !users.contains_key(id)
        });
    }
}

/// What uses each node of the map.
fn users(
    data: &OsmData,
    footprints: &BTreeMap<ElementId, Footprint>,
) -> BTreeMap<i64, BTreeSet<User>> {
    let of_footprint = |(element, footprint): (&ElementId, &Footprint)| {
        let user = User::Building(*element);
        let ways = footprint.ways.clone().into_iter();
        ways.map(move |way| (way, user)).collect::<Vec<_>>()
    };
    let owners: BTreeMap<i64, User> = footprints.iter().flat_map(of_footprint).collect();
    let mut users: BTreeMap<i64, BTreeSet<User>> = BTreeMap::new();
    for way in data.ways.values() {
        let user = match owners.get(&way.id) {
            Some(owner) => *owner,
            None if way.tags.says("highway") => User::Road,
            None => User::Other,
        };
        for node in &way.nodes {
            users.entry(*node).or_default().insert(user);
        }
    }
    let members = data.relations.values().flat_map(|r| &r.members);
    for member in members.filter(|m| m.kind == ElementKind::Node) {
        users.entry(member.id).or_default().insert(User::Other);
    }
    users
}

/// A renumbered map with more buildings, whose numbers lie anywhere among those of the others: at
/// the end they would tell which were added.
fn with_buildings(data: OsmData, outlines: &[Vec<LonLat>], seed: u64) -> OsmData {
    if outlines.is_empty() {
        return data;
    }
    let kinds: Vec<String> = data
        .ways
        .values()
        .filter(|way| way.tags.says("building"))
        .filter_map(|way| way.tags.get("building").map(str::to_owned))
        .collect();
    let last = data.ways.len() as i64;
    let gap = outlines.len() as i64 + 1;
    let mut data = spread_ways(data, gap);
    let mut next_node = data.nodes.keys().next_back().map_or(1, |id| id + 1);
    for (number, outline) in (1_i64..).zip(outlines) {
        let mut draws = stream(seed, Purpose::InventedNumber as u64, number as u64);
        let place = draws.random_range(0..last as u64 + 1) as i64;
        let first = next_node;
        for position in outline {
            let (lon, lat) = (round7(position.lon), round7(position.lat));
            let node = Node {
                id: next_node,
                position: LonLat::new(lon, lat),
                tags: Tags::new(),
            };
            data.nodes.insert(next_node, node);
            next_node += 1;
        }
        let kinds: Vec<&str> = kinds.iter().map(String::as_str).collect();
        let kind = if kinds.is_empty() {
            "yes"
        } else {
            pick(&mut draws, &kinds)
        };
        let way = Way {
            id: place * gap + number,
            nodes: (first..next_node).chain([first]).collect(),
            tags: Tags::from([("building", kind)]),
        };
        data.ways.insert(way.id, way);
    }
    data
}

/// The same map with gaps between the numbers of its ways, of which each is a multiple of `gap`.
fn spread_ways(mut data: OsmData, gap: i64) -> OsmData {
    let ways = std::mem::take(&mut data.ways).into_values();
    data.ways = ways
        .map(|way| Way {
            id: way.id * gap,
            ..way
        })
        .map(|way| (way.id, way))
        .collect();
    let members = data.relations.values_mut().flat_map(|r| &mut r.members);
    for member in members.filter(|m| m.kind == ElementKind::Way) {
        member.id *= gap;
    }
    data
}
