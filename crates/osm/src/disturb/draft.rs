//! The map while it is being changed.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use openbench_core::{LonLat, MapPoint, Pose2};
use openbench_geometry::Polygon;

use crate::data::OsmData;
use crate::draws::{element_number, stream};
use crate::element::{ElementId, ElementKind, Member, Node, Relation, Way};
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
    /// The building of each way that belongs to one.
    owners: BTreeMap<i64, User>,
    next_node: i64,
    /// Buildings that are not there.
    invented: Vec<Polygon>,
    /// Names with numbers that buildings have or had.
    taken: BTreeSet<String>,
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
        let owners = owners(footprints);
        Self {
            positions: data.nodes.values().map(place).collect(),
            users: users(data, &owners),
            owners,
            next_node: data
                .nodes
                .keys()
                .next_back()
                .map_or(1, |id| id.saturating_add(1)),
            projection,
            data: data.clone(),
            invented: Vec::new(),
            taken: BTreeSet::new(),
        }
    }

    /// Gives buildings wrong numbers, or takes their names. One that has none is right as it is.
    pub(super) fn rename(
        &mut self,
        buildings: &mut BTreeMap<ElementId, BuildingError>,
        footprints: &BTreeMap<ElementId, Footprint>,
        seed: u64,
    ) {
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
                None => {
                    error.state = MapState::Right;
                    continue;
                }
            }
            taken.extend(numbered_names(tags));
            if let Some(footprint) = footprints.get(element) {
                self.forget_names_inside(*element, footprint);
            }
        }
        self.taken = taken;
    }

    /// Takes the names of all that belongs to a building but itself: they would tell its own.
    fn forget_names_inside(&mut self, element: ElementId, footprint: &Footprint) {
        let ways = footprint.ways.iter().map(|id| ElementId::way(*id));
        let relations = footprint
            .relations
            .iter()
            .map(|id| ElementId::relation(*id));
        let nodes = footprint.inside.iter().map(|id| ElementId::node(*id));
        let outline = footprint
            .ways
            .iter()
            .filter_map(|id| self.data.ways.get(id));
        let outline: Vec<i64> = outline.flat_map(|way| way.nodes.clone()).collect();
        let outline = outline.into_iter().map(ElementId::node);
        for other in ways.chain(relations).chain(nodes).chain(outline) {
            if other != element
                && let Some(tags) = self.tags_mut(other)
            {
                *tags = nameless(tags);
            }
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
        let ways = self.data.ways.values();
        // A way that is a building as well, such as a covered passage, stays one.
        let roads = ways.filter(|w| w.tags.says("highway") && !self.owners.contains_key(&w.id));
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
        // A way that another building's relation needs for its outline stays.
        let others = self.data.relations.values();
        let others = others.filter(|r| !footprint.relations.contains(&r.id));
        let needed: BTreeSet<i64> = others
            .filter(|relation| relation.tags.says("building"))
            .flat_map(|relation| &relation.members)
            .filter(|member| member.kind == ElementKind::Way)
            .map(|member| member.id)
            .collect();
        let own = footprint.ways.iter().copied();
        let own: Vec<i64> = own.filter(|way| !needed.contains(way)).collect();
        self.remove_elements(&own, &footprint.relations);
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
        self.next_node = self.next_node.saturating_add(1);
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
        self.add_invented(frame, seed);
        renumbered(&by_place(self.data))
    }

    /// Adds the buildings that are not there, each with the tags of the one nearest to it, and the
    /// nearest number that is free: who has no number must not stand out.
    fn add_invented(&mut self, frame: Pose2, seed: u64) {
        let real = self.buildings_by_place();
        let mut next_way = self
            .data
            .ways
            .keys()
            .next_back()
            .map_or(1, |id| id.saturating_add(1));
        for (number, outline) in (1..).zip(std::mem::take(&mut self.invented)) {
            let mut draws = stream(seed, Purpose::InventedNumber as u64, number);
            let middle = outline.centroid();
            let there = frame.transform(middle.x, middle.y);
            let nearest = real.iter().min_by(|a, b| {
                let [a, b] = [a, b].map(|(at, _)| at.distance(there));
                a.total_cmp(&b)
            });
            let tags = nearest.map_or(Tags::from([("building", "yes")]), |(_, tags)| {
                renumber(tags, &self.taken, &mut draws).unwrap_or_else(|| nameless(tags))
            });
            self.taken.extend(numbered_names(&tags));
            let mut nodes: Vec<i64> = Vec::new();
            for at in &outline.outer {
                let id = self.add_node(*at, User::Other);
                let at = self.projection.to_lonlat(frame.transform(at.x, at.y));
                if let Some(node) = self.data.nodes.get_mut(&id) {
                    node.position = LonLat::new(round7(at.lon), round7(at.lat));
                }
                nodes.push(id);
            }
            nodes.extend(nodes.first().copied());
            let way = Way {
                id: next_way,
                nodes,
                tags,
            };
            self.data.ways.insert(next_way, way);
            next_way = next_way.saturating_add(1);
        }
    }

    /// The buildings that are ways: their first corners in the wrong map, and their tags.
    fn buildings_by_place(&self) -> Vec<(MapPoint, Tags)> {
        let buildings = self.data.ways.values();
        let buildings = buildings.filter(|way| way.tags.says("building"));
        let placed = buildings.filter_map(|way| {
            let node = self.data.nodes.get(way.nodes.first()?)?;
            Some((self.projection.to_map(node.position), way.tags.clone()))
        });
        placed.collect()
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

/// The building of each way that belongs to one.
fn owners(footprints: &BTreeMap<ElementId, Footprint>) -> BTreeMap<i64, User> {
    let of_footprint = |(element, footprint): (&ElementId, &Footprint)| {
        let user = User::Building(*element);
        let ways = footprint.ways.clone().into_iter();
        ways.map(move |way| (way, user)).collect::<Vec<_>>()
    };
    footprints.iter().flat_map(of_footprint).collect()
}

/// What uses each node of the map.
fn users(data: &OsmData, owners: &BTreeMap<i64, User>) -> BTreeMap<i64, BTreeSet<User>> {
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

/// The same map with its ways and relations numbered from west to east: the order in which they
/// were drawn would tell the name of a nameless building, and which buildings were added.
/// Members that the data lacks are left out.
fn by_place(mut data: OsmData) -> OsmData {
    let west = |way: &Way| {
        let nodes = way.nodes.iter().filter_map(|id| data.nodes.get(id));
        let places = nodes.map(|node| [node.position.lon, node.position.lat]);
        places.min_by(compare).unwrap_or([f64::INFINITY; 2])
    };
    let places: BTreeMap<i64, [f64; 2]> =
        data.ways.values().map(|way| (way.id, west(way))).collect();
    let ways = numbers(&places);
    let of_relation = |relation: &Relation| {
        let members = relation
            .members
            .iter()
            .filter(|m| m.kind == ElementKind::Way);
        let places = members.filter_map(|member| places.get(&member.id)).copied();
        places.min_by(compare).unwrap_or([f64::INFINITY; 2])
    };
    let of_relations = data.relations.values();
    let of_relations = of_relations.map(|relation| (relation.id, of_relation(relation)));
    let relations = numbers(&of_relations.collect());
    let nodes = &data.nodes;
    for relation in data.relations.values_mut() {
        relation.id = relations[&relation.id];
        relation.members = std::mem::take(&mut relation.members)
            .into_iter()
            .filter_map(|member| {
                let id = match member.kind {
                    ElementKind::Node => nodes.contains_key(&member.id).then_some(member.id),
                    ElementKind::Way => ways.get(&member.id).copied(),
                    ElementKind::Relation => relations.get(&member.id).copied(),
                };
                Some(Member { id: id?, ..member })
            })
            .collect();
    }
    let renamed = std::mem::take(&mut data.relations).into_values();
    data.relations = renamed.map(|relation| (relation.id, relation)).collect();
    let renamed = std::mem::take(&mut data.ways).into_values();
    let renamed = renamed.map(|way| Way {
        id: ways[&way.id],
        ..way
    });
    data.ways = renamed.map(|way| (way.id, way)).collect();
    data
}

/// New numbers from 1 in the order of places.
fn numbers(places: &BTreeMap<i64, [f64; 2]>) -> BTreeMap<i64, i64> {
    let mut order: Vec<(&[f64; 2], i64)> = places.iter().map(|(id, at)| (at, *id)).collect();
    order.sort_by(|a, b| compare(a.0, b.0).then(a.1.cmp(&b.1)));
    (1..)
        .zip(order)
        .map(|(number, (_, id))| (id, number))
        .collect()
}

fn compare(a: &[f64; 2], b: &[f64; 2]) -> Ordering {
    a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
}
