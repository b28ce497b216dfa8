//! Names of the buildings: instructions, the public map and doors must agree on them, and no two
//! buildings may have the same.
//!
//! A name of the map is kept if it is the building's alone; else street and house number, if they
//! are. A building without a name gets the address of a node in it or at its door, else an invented
//! number in the nearest named street, else `building<N>`. Invented numbers count along the street,
//! even ones on the right. Where doors are drawn, numbers are too, see
//! [`numbering`](super::numbering).

use std::collections::{BTreeMap, BTreeSet};

use openbench_core::{Address, MapPoint};
use openbench_geometry::line::length;
use openbench_osm::draws::{self, mix};
use openbench_osm::names::{building_name, fold};
use openbench_osm::{
    Building, ElementId, ElementKind, Location, OsmData, OsmMap, Road, Tags, locate,
};

use super::numbering::{Beside, DrawnNumber, StreetSides};
use crate::generate::layout::lanes::Lanes;
use crate::generate::streets::profile::profile;

/// A street farther than this from a door is not the door's street, metres.
const NEAR_STREET_M: f64 = 60.0;
/// A node with an address within this distance of a building is that building's, metres.
const NEAR_NODE_M: f64 = 3.0;
/// Stream of the run's seed for the house numbers of a street.
const NUMBERS_STREAM: u64 = 113;
/// Length of street in which house numbers go up by two, metres.
const PLOT_M: f64 = 12.0;
/// The highest house number that is tried.
const MOST_NUMBERS: u32 = 20_000;
/// Longest name that instructions can use, characters.
const LONGEST_NAME: usize = 60;

/// Gives names to buildings.
pub(super) struct Names<'a> {
    map: &'a OsmMap,
    streets: Lanes,
    /// For each road the position along its street at which it begins, metres.
    begins: Vec<f64>,
    /// Addresses on nodes, by building.
    addresses: BTreeMap<usize, StreetAddress>,
    /// Names that were given, folded.
    taken: BTreeSet<String>,
    given: BTreeMap<ElementId, String>,
    /// House numbers that were drawn, by building.
    drawn: BTreeMap<usize, StreetAddress>,
    added: Vec<AddedTags>,
}

/// Street and house number.
struct StreetAddress {
    street: String,
    number: String,
}

/// A place beside a street.
struct InStreet<'a> {
    street: &'a str,
    /// Metres along the street.
    along: f64,
    is_left: bool,
}

/// Tags that an element of the public map gets.
struct AddedTags {
    element: ElementId,
    tags: Tags,
}

/// A name, and the tags that the public map needs for it.
struct Named {
    name: String,
    tags: Tags,
}

impl<'a> Names<'a> {
    /// No names yet for the buildings of `map`, which was made of `data`.
    pub fn new(map: &'a OsmMap, data: &OsmData) -> Self {
        let is_street = |r: &Road| r.tags.has("name") && profile(&r.tags).is_some();
        let mut lengths: BTreeMap<&str, f64> = BTreeMap::new();
        let mut begins = Vec::with_capacity(map.roads.len());
        for road in &map.roads {
            let street = road.tags.get("name").unwrap_or_default();
            // A street is often mapped in several ways; its numbers go on from one to the next.
            let so_far = lengths.entry(street).or_default();
            begins.push(*so_far);
            *so_far += length(&road.points);
        }
        Self {
            map,
            streets: Lanes::new(&map.roads, is_street),
            begins,
            addresses: addresses(map, data),
            taken: BTreeSet::new(),
            given: BTreeMap::new(),
            drawn: BTreeMap::new(),
            added: Vec::new(),
        }
    }

    /// Draws house numbers for those of the buildings, in ascending order, that the map gives none.
    /// Returns how many.
    pub fn draw_numbers(&mut self, buildings: &[usize], seed: u64) -> usize {
        for (street, sides) in self.sides_of_streets(buildings) {
            let name = street.bytes().fold(0, |n, byte| mix(n ^ u64::from(byte)));
            let is_taken = |number: &str| self.address(&street, number).is_none();
            let mut draws = draws::stream(seed, NUMBERS_STREAM, name);
            let numbered = sides.number(is_taken, &mut draws);
            for DrawnNumber { building, number } in numbered {
                let street = street.clone();
                self.drawn
                    .insert(building, StreetAddress { street, number });
            }
        }
        self.drawn.len()
    }

    /// The buildings beside each street, of those without a number only the ones asked for, which
    /// are in ascending order.
    fn sides_of_streets(&self, asked: &[usize]) -> BTreeMap<String, StreetSides> {
        let mut streets: BTreeMap<String, StreetSides> = BTreeMap::new();
        for building in 0..self.map.buildings.len() {
            let middle = self.map.buildings[building].polygon.centroid();
            let Some(InStreet {
                street,
                along,
                is_left,
            }) = self.place_in_street(middle)
            else {
                continue;
            };
            let beside = Beside {
                building,
                along,
                is_left,
            };
            let sides = streets.entry(street.to_owned()).or_default();
            match self.mapped_number(building, street) {
                Some(number) => sides.with.push((beside, number)),
                None if asked.binary_search(&building).is_ok() && !self.is_named(building) => {
                    sides.without.push(beside);
                }
                None => {}
            }
        }
        streets
    }

    /// The number that the map gives to a building in a street.
    fn mapped_number(&self, index: usize, street: &str) -> Option<String> {
        let tags = &self.map.buildings[index].tags;
        let own = tags.get("addr:housenumber").map(str::to_owned);
        let of_street = own.filter(|_| tags.is("addr:street", street));
        let on_node = self.addresses.get(&index).filter(|a| a.street == street);
        of_street.or_else(|| on_node.map(|address| address.number.clone()))
    }

    /// Whether the map has a name or number for a building that is its own.
    fn is_named(&self, index: usize) -> bool {
        let building = &self.map.buildings[index];
        let own = |key: &str| building.tags.get(key);
        let number = own("addr:housenumber");
        let street = own("addr:street").or_else(|| own("addr:place"));
        let known = known_names(building, street, number);
        number.is_some()
            || self.addresses.contains_key(&index)
            || known.iter().any(|name| self.is_unique(name))
    }

    /// The name that a building has so far.
    pub fn given(&self, index: usize) -> Option<String> {
        let building = &self.map.buildings[index];
        self.given.get(&building.element).cloned()
    }

    /// The name of a building with a door at `door`.
    pub fn of(&mut self, index: usize, door: MapPoint) -> String {
        let building = &self.map.buildings[index];
        if let Some(name) = self.given.get(&building.element) {
            return name.clone();
        }
        let Named { name, tags } = self.choose(index, building, door);
        // A name of the map itself needs no note: `locate` finds it.
        if !tags.is_empty() {
            self.taken.insert(fold(&name));
            self.added.push(AddedTags {
                element: building.element,
                tags,
            });
        }
        self.given.insert(building.element, name.clone());
        name
    }

    /// Writes the names that the map lacks into the public map.
    pub fn write(self, public: &mut OsmData) {
        for AddedTags {
            element,
            tags: added,
        } in self.added
        {
            let tags = match element.kind {
                ElementKind::Way => public.ways.get_mut(&element.id).map(|w| &mut w.tags),
                ElementKind::Relation => public.relations.get_mut(&element.id).map(|r| &mut r.tags),
                ElementKind::Node => None,
            };
            let Some(tags) = tags else { continue };
            for (key, value) in added.iter() {
                tags.insert(key, value);
            }
        }
    }

    fn choose(&self, index: usize, building: &Building, door: MapPoint) -> Named {
        let own = |key: &str| building.tags.get(key).map(str::to_owned);
        let street = own("addr:street").or_else(|| own("addr:place"));
        let number = own("addr:housenumber");
        let known = known_names(building, street.as_deref(), number.as_deref());
        // From the surest to the least sure: own name or address, address of a node, number in a
        // street.
        if let Some(name) = known.iter().find(|name| self.is_unique(name)) {
            return Named {
                name: name.clone(),
                tags: Tags::new(),
            };
        }
        let on_node = self.addresses.get(&index);
        if let Some(found) = on_node.and_then(|a| self.address(&a.street, &a.number)) {
            return found;
        }
        let drawn = self.drawn.get(&index);
        if let Some(found) = drawn.and_then(|a| self.address(&a.street, &a.number)) {
            return found;
        }
        // A number that belongs to another street is none in this one.
        if let Some(found) = self.in_street(number.filter(|_| street.is_none()), door) {
            return found;
        }
        match known.into_iter().next() {
            Some(name) => Named {
                name,
                tags: Tags::new(),
            },
            None => self.numbered(index),
        }
    }

    /// `building<N>`, with the first number from the building's index on that is free.
    fn numbered(&self, index: usize) -> Named {
        // One more number than there are buildings that could have taken one.
        let mut names = (index + 1..=index + self.map.buildings.len() + 1)
            .map(|number| format!("building{number}"));
        let name = names.find(|name| self.is_free(name)).unwrap_or_default();
        Named {
            name: name.clone(),
            tags: Tags::from([("name", name)]),
        }
    }

    /// A number in the nearest named street: the one that is given, or an invented one.
    fn in_street(&self, given: Option<String>, door: MapPoint) -> Option<Named> {
        let InStreet {
            street,
            along,
            is_left,
        } = self.place_in_street(door)?;
        if let Some(found) = given.and_then(|number| self.address(street, &number)) {
            return Some(found);
        }
        let plot = (along / PLOT_M).min(1e6) as u32;
        // Odd numbers on the left. On streets of absurd length the numbers begin again.
        let first = 2 * (plot % (MOST_NUMBERS / 2)) + if is_left { 1 } else { 2 };
        (first..=MOST_NUMBERS + 2)
            // By two, so that the number stays on its side of the street.
            .step_by(2)
            .find_map(|number| self.address(street, &number.to_string()))
    }

    /// Where a point is in the nearest named street.
    fn place_in_street(&self, point: MapPoint) -> Option<InStreet<'_>> {
        let lane = self
            .streets
            .nearest(&self.map.roads, point, NEAR_STREET_M)?
            .lane;
        let road = &self.map.roads[lane.road as usize];
        let street = road.tags.get("name").filter(|name| is_plain(name))?;
        // In the axes of the street's segment: how far along it, and on which side.
        let (run, aside) = lane.ends(&self.map.roads).pose().inverse_transform(point);
        let before = length(&road.points[..=lane.segment as usize]);
        Some(InStreet {
            street,
            along: self.begins[lane.road as usize] + before + run.max(0.0),
            is_left: aside > 0.0,
        })
    }

    /// Street and number as a name with its tags, if no building has it yet.
    fn address(&self, street: &str, number: &str) -> Option<Named> {
        let name = format!("{street} {number}");
        let tags = Tags::from([("addr:street", street), ("addr:housenumber", number)]);
        (is_plain(&name) && self.is_free(&name)).then_some(Named { name, tags })
    }

    fn is_unique(&self, name: &str) -> bool {
        let found = matches!(
            self.locate(name),
            Location::Building(_) | Location::Unit { .. }
        );
        found && !self.taken.contains(&fold(name))
    }

    fn is_free(&self, name: &str) -> bool {
        let found = match self.locate(name) {
            Location::Unknown => false,
            // The address on a door or node of the building itself is lost with the doors.
            Location::Building(i) | Location::Unit { building: i, .. } => {
                let tags = &self.map.buildings[i].tags;
                building_name(tags).is_some_and(|n| fold(&n) == fold(name))
            }
            Location::Ambiguous(_) => true,
        };
        !found && !self.taken.contains(&fold(name))
    }

    fn locate(&self, name: &str) -> Location {
        let address = Address {
            building: name.to_owned(),
            unit: None,
        };
        locate(self.map, &address)
    }
}

/// The names that the map has for a building: its own, then street and number. A house number alone
/// is no name.
fn known_names(building: &Building, street: Option<&str>, number: Option<&str>) -> Vec<String> {
    let address = street
        .zip(number)
        .map(|(street, number)| format!("{street} {number}"));
    let is_number = building.name.is_some() && building.name.as_deref() == number;
    let name = building.name.clone().filter(|_| !is_number);
    name.into_iter()
        .chain(address)
        .filter(|name| is_plain(name))
        .collect()
}

/// The lowest address on a node in or at each building.
fn addresses(map: &OsmMap, data: &OsmData) -> BTreeMap<usize, StreetAddress> {
    let mut found = BTreeMap::new();
    for node in data.nodes.values() {
        let tags = &node.tags;
        let street = tags.get("addr:street").or_else(|| tags.get("addr:place"));
        let Some((street, number)) = street.zip(tags.get("addr:housenumber")) else {
            continue;
        };
        let point = map.projection.to_map(node.position);
        let nearest = map.nearest_building(point);
        let near = nearest.filter(|i| map.distance_to_building(*i, point) <= NEAR_NODE_M);
        if let Some(building) = near {
            found.entry(building).or_insert_with(|| StreetAddress {
                street: street.to_owned(),
                number: number.to_owned(),
            });
        }
    }
    found
}

/// Whether a name is one that instructions can use: no list, no paragraph.
fn is_plain(name: &str) -> bool {
    let short = name.chars().count() <= LONGEST_NAME;
    !name.trim().is_empty() && short && !name.contains([';', '\n', '|'])
}
