//! What the buildings are called: instructions, public map and doors must agree on it, and no two may be called the same.
//!
//! A name of the map is kept if it is the building's alone; else street and house number are taken, if they are. A building
//! without a name gets the address that stands on a node in it or at its door, else an invented number in the nearest named
//! street, counted along it with even numbers on the right, else `building<N>`.

use std::collections::{BTreeMap, BTreeSet};

use openbench_core::{Address, MapPoint, Pose2};
use openbench_osm::names::fold;
use openbench_osm::{Building, ElementId, ElementKind, Location, OsmData, OsmMap, Tags, locate};

use super::lanes::{Lanes, ends};
use super::streets::profile;

/// A street further than this from a door is not the one that it is in, metres.
const NEAR_STREET: f64 = 60.0;
/// A node with an address within this distance of a building is that building's, metres.
const NEAR_NODE: f64 = 3.0;
/// House numbers go up by two in so many metres.
const PLOT: f64 = 12.0;
/// The highest house number that is tried.
const MOST_NUMBERS: u32 = 20_000;

/// Gives names to buildings.
pub(super) struct Names<'a> {
    map: &'a OsmMap,
    streets: Lanes,
    /// For each road how far along its street it begins, metres.
    begins: Vec<f64>,
    /// Addresses on nodes, by building.
    addresses: BTreeMap<usize, (String, String)>,
    /// Names that were given, folded.
    taken: BTreeSet<String>,
    given: BTreeMap<ElementId, String>,
    tags: Vec<(ElementId, Tags)>,
}

impl<'a> Names<'a> {
    pub fn new(map: &'a OsmMap, data: &OsmData) -> Self {
        let is_street = |r: &openbench_osm::Road| r.tags.has("name") && profile(&r.tags).is_some();
        let mut lengths: BTreeMap<&str, f64> = BTreeMap::new();
        let begins = map
            .roads
            .iter()
            .map(|road| {
                let length: f64 = road.points.windows(2).map(|p| p[0].distance(p[1])).sum();
                let so_far = lengths
                    .entry(road.tags.get("name").unwrap_or_default())
                    .or_default();
                std::mem::replace(so_far, *so_far + length)
            })
            .collect();
        Self {
            map,
            streets: Lanes::new(&map.roads, is_street),
            begins,
            addresses: addresses(map, data),
            taken: BTreeSet::new(),
            given: BTreeMap::new(),
            tags: Vec::new(),
        }
    }

    /// What a building is called so far.
    pub fn given(&self, index: usize) -> Option<String> {
        let building = &self.map.buildings[index];
        self.given.get(&building.element).cloned()
    }

    /// What a building with a door at `door` is called.
    pub fn of(&mut self, index: usize, door: MapPoint) -> String {
        let building = &self.map.buildings[index];
        if let Some(name) = self.given.get(&building.element) {
            return name.clone();
        }
        let (name, tags) = self.choose(index, building, door);
        if !tags.is_empty() {
            self.taken.insert(fold(&name));
            self.tags.push((building.element, tags));
        }
        self.given.insert(building.element, name.clone());
        name
    }

    /// Writes what was given into the public map.
    pub fn write(self, public: &mut OsmData) {
        for (element, added) in self.tags {
            let tags = match element.kind {
                ElementKind::Way => public.ways.get_mut(&element.id).map(|w| &mut w.tags),
                ElementKind::Relation => public.relations.get_mut(&element.id).map(|r| &mut r.tags),
                ElementKind::Node => None,
            };
            if let Some(tags) = tags {
                added
                    .iter()
                    .for_each(|(key, value)| drop(tags.insert(key, value)));
            }
        }
    }

    /// A name, and the tags that the public map needs for it.
    fn choose(&self, index: usize, building: &Building, door: MapPoint) -> (String, Tags) {
        let tags = &building.tags;
        let own = |key: &str| tags.get(key).map(str::to_owned);
        let street = own("addr:street").or_else(|| own("addr:place"));
        let address = street
            .clone()
            .zip(own("addr:housenumber"))
            .map(|(s, n)| format!("{s} {n}"));
        let bare = building.name.is_some() && building.name == own("addr:housenumber");
        let known = building
            .name
            .clone()
            .filter(|_| !bare)
            .into_iter()
            .chain(address);
        let known: Vec<String> = known.filter(|name| is_plain(name)).collect();
        if let Some(name) = known.iter().find(|name| self.is_unique(name)) {
            return (name.clone(), Tags::new());
        }
        if let Some((street, number)) = self.addresses.get(&index)
            && let Some(found) = self.address(street, number)
        {
            return found;
        }
        if let Some(found) =
            self.in_street(own("addr:housenumber").filter(|_| street.is_none()), door)
        {
            return found;
        }
        if let Some(name) = known.into_iter().next() {
            return (name, Tags::new());
        }
        let numbers = index + 1..=index + self.map.buildings.len() + 1;
        let name = numbers
            .map(|n| format!("building{n}"))
            .find(|name| self.is_free(name))
            .unwrap_or_default();
        (name.clone(), Tags::from([("name", name)]))
    }

    /// A number in the nearest named street: the one that is told, or an invented one.
    fn in_street(&self, told: Option<String>, door: MapPoint) -> Option<(String, Tags)> {
        let (segment, _) = self.streets.nearest(&self.map.roads, door, NEAR_STREET)?;
        let road = &self.map.roads[segment.0 as usize];
        let street = road.tags.get("name").filter(|name| is_plain(name))?;
        if let Some(found) = told.and_then(|number| self.address(street, &number)) {
            return Some(found);
        }
        let (a, b) = ends(&self.map.roads, segment);
        let (run, aside) = Pose2::new(a.x, a.y, a.bearing_to(b)).inverse_transform(door);
        let before: f64 = road.points[..=segment.1 as usize]
            .windows(2)
            .map(|p| p[0].distance(p[1]))
            .sum::<f64>();
        let plot =
            ((self.begins[segment.0 as usize] + before + run.max(0.0)) / PLOT).min(1e6) as u32;
        let first = 2 * (plot % (MOST_NUMBERS / 2)) + if aside > 0.0 { 1 } else { 2 };
        (first..=MOST_NUMBERS + 2)
            .step_by(2)
            .find_map(|number| self.address(street, &number.to_string()))
    }

    /// Street and number as a name with its tags, if it is nobody's yet.
    fn address(&self, street: &str, number: &str) -> Option<(String, Tags)> {
        let name = format!("{street} {number}");
        let tags = Tags::from([("addr:street", street), ("addr:housenumber", number)]);
        (is_plain(&name) && self.is_free(&name)).then_some((name, tags))
    }

    fn is_unique(&self, name: &str) -> bool {
        let address = Address {
            building: name.to_owned(),
            unit: None,
        };
        matches!(
            locate(self.map, &address),
            Location::Building(_) | Location::Unit { .. }
        ) && !self.taken.contains(&fold(name))
    }

    fn is_free(&self, name: &str) -> bool {
        let address = Address {
            building: name.to_owned(),
            unit: None,
        };
        let found = match locate(self.map, &address) {
            Location::Unknown => false,
            // The address on a door or node of the building itself is lost with the doors.
            Location::Building(i) | Location::Unit { building: i, .. } => {
                let tags = &self.map.buildings[i].tags;
                openbench_osm::names::building_name(tags).is_some_and(|n| fold(&n) == fold(name))
            }
            Location::Ambiguous(_) => true,
        };
        !found && !self.taken.contains(&fold(name))
    }
}

/// The lowest address on a node in or at each building.
fn addresses(map: &OsmMap, data: &OsmData) -> BTreeMap<usize, (String, String)> {
    let mut found = BTreeMap::new();
    for node in data.nodes.values() {
        let street = node
            .tags
            .get("addr:street")
            .or_else(|| node.tags.get("addr:place"));
        let Some((street, number)) = street.zip(node.tags.get("addr:housenumber")) else {
            continue;
        };
        let point = map.projection.to_map(node.position);
        let near = map
            .nearest_building(point)
            .filter(|i| map.distance_to_building(*i, point) <= NEAR_NODE);
        if let Some(building) = near {
            found
                .entry(building)
                .or_insert_with(|| (street.to_owned(), number.to_owned()));
        }
    }
    found
}

/// Whether a name can be said in one breath: no list, no paragraph.
fn is_plain(name: &str) -> bool {
    !name.trim().is_empty() && name.chars().count() <= 60 && !name.contains([';', '\n', '|'])
}
