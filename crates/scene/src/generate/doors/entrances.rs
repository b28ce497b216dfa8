//! Where the doors are: at the map's `entrance` nodes; else, if asked for, where a seed draws them
//! (see [`drawn`](super::drawn)), or one in the wall nearest to a street. The names of their
//! buildings, in the public map too, come from [`naming`](super::naming).

use std::collections::{BTreeMap, BTreeSet};

use openbench_core::{Address, MapPoint};
use openbench_geometry::Segment;
use openbench_osm::draws::{self, mix};
use openbench_osm::houses::{DrawnDoor, draw_doors};
use openbench_osm::names::{fold, fold_unit};
use openbench_osm::{Building, Entrance, OsmData, OsmMap};
use rand_pcg::Pcg64Mcg;

use super::doorway::{Doorway, LEAF_WIDTH_M};
use super::drawn::{DOORS_STREAM, Draw, PLATE_STREAM, wish};
use super::naming::Names;
use crate::drawn_doors::DrawnDoors;
use crate::generate::buildings::house::is_open_below;
use crate::generate::buildings::walls::walls;
use crate::generate::layout::clearance::{BUILDING, Clearance, PATH, ROAD};
use crate::generate::options::GenerateOptions;
use crate::generate::seeds::{Purpose, chance, element_number, stream};
use crate::plate::PLATE_WIDTH_M;

/// Middle of the plate from the middle of the door along the wall, metres.
// Half a leaf, the frame, a gap of 10 cm, and half a plate.
const PLATE_OFFSET_M: f64 = 1.25;
/// Space between a plate and the end of its wall, metres.
const PLATE_MARGIN_M: f64 = 0.1;
/// Depth behind a wall at which the buildings there are searched, metres.
const BEHIND_M: f64 = 0.3;
/// An entrance node farther than this from a wall is not in it, metres.
const REACH_M: f64 = 2.0;
/// Largest distance at which walls are compared by their distance from a road or path, metres.
const STREET_REACH_M: f64 = 60.0;
/// Shortest wall that gets an invented door, metres.
const SHORTEST_WALL_M: f64 = 2.5;
/// A smaller building has no door unless the map has one, m².
const SMALLEST_HOME_M2: f64 = 20.0;
/// Doors in a world at most.
const MAX_DOORS: usize = 20_000;
/// Longest unit on a plate, characters.
const LONGEST_UNIT: usize = 4;
/// Number of different units that the map may bring: each is an image.
const MAX_TEXTS: usize = 500;

/// The doors of a map.
pub(crate) struct Placed {
    /// In the order of buildings and their entrances.
    pub doorways: Vec<Doorway>,
    /// Those that were drawn; `None` if none were asked for.
    pub drawn: Option<DrawnDoors>,
    /// What had to be left out.
    pub warnings: Vec<String>,
}

/// A place for a door.
#[derive(Debug, Clone, Copy)]
struct Place {
    wall: Segment,
    /// Foot of the door, in the wall.
    foot: MapPoint,
}

/// The doors that were drawn for a building.
struct DoorsOfHome {
    /// Index of the building.
    building: usize,
    doors: Vec<DrawnDoor>,
}

/// A place, and its cost: the lower, the better.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    place: Place,
    cost: f64,
}

/// Places the doors of all buildings, and writes the names of their buildings into the public map.
/// Where the map has none, doors are drawn, or else invented if the options say so.
pub(crate) fn place(
    map: &OsmMap,
    public: &mut OsmData,
    seed: u64,
    options: &GenerateOptions,
    clearance: &Clearance,
    draw: Option<&Draw>,
) -> Placed {
    let mut placer = Placer {
        map,
        clearance,
        seed,
        names: Names::new(map, public),
        units: BTreeMap::new(),
        texts: BTreeSet::new(),
        unplaced: 0,
        repeated: 0,
        beyond: 0,
    };
    let mut found = BTreeMap::new();
    let mut without = Vec::new();
    for (index, entrances) in entrances_of_buildings(map).iter().enumerate() {
        if !entrances.is_empty() {
            found.insert(index, placer.mapped(index, entrances));
        } else if draw.is_some() {
            without.push(index);
        } else if options.invent_doors {
            found.insert(index, placer.invented(index).into_iter().collect());
        }
    }
    // After the mapped ones, so that those keep their names whatever is drawn.
    let drawn = draw.map(|draw| placer.draw(draw, &without, &mut found));
    let mut doorways = Vec::new();
    for doors in found.into_values() {
        // Names are drawn for doors beyond the limit too: the limit must not rename the others.
        let room = MAX_DOORS.saturating_sub(doorways.len());
        placer.beyond += doors.len().saturating_sub(room);
        doorways.extend(doors.into_iter().take(room));
    }
    let warnings = placer.warnings();
    placer.names.write(public);
    Placed {
        doorways,
        drawn,
        warnings,
    }
}

/// The map's entrances, by building.
fn entrances_of_buildings(map: &OsmMap) -> Vec<Vec<&Entrance>> {
    let mut of_building: Vec<Vec<&Entrance>> = vec![Vec::new(); map.buildings.len()];
    for entrance in &map.entrances {
        if let Some(list) = entrance.building.and_then(|b| of_building.get_mut(b)) {
            list.push(entrance);
        }
    }
    of_building
}

struct Placer<'a> {
    map: &'a OsmMap,
    clearance: &'a Clearance,
    seed: u64,
    names: Names<'a>,
    /// Units that each building name has already, both folded.
    units: BTreeMap<String, BTreeSet<String>>,
    /// Units of the map that have a plate.
    texts: BTreeSet<String>,
    unplaced: usize,
    repeated: usize,
    beyond: usize,
}

impl Placer<'_> {
    /// Doors at the entrances that the map has.
    fn mapped(&mut self, index: usize, entrances: &[&Entrance]) -> Vec<Doorway> {
        let mut doors: Vec<Doorway> = Vec::new();
        // All mapped units first, so that a door without one does not take a number that a later
        // door has.
        let given: Vec<Option<String>> = entrances.iter().map(|e| self.unit_of(e)).collect();
        for (entrance, own) in entrances.iter().zip(&given) {
            let known = self.names.given(index).map(|name| fold(&name));
            let used = known
                .and_then(|name| self.units.get(&name))
                .cloned()
                .unwrap_or_default();
            let unit = own.clone().or_else(|| free_unit(&used, &given));
            // An address names one door: a second door of that unit could not be told from it.
            let Some(unit) = unit.filter(|u| !used.contains(u)) else {
                self.repeated += 1;
                continue;
            };
            // Before the unit is taken: an entrance without a place leaves its unit free.
            let Some(place) = self.place_near(index, entrance.position, &doors) else {
                self.unplaced += 1;
                continue;
            };
            // By the map's node, so that other doors do not change these draws.
            let mut rng = stream(self.seed, Purpose::Doorway, entrance.node as u64);
            let address = self.take(index, place.foot, &unit);
            doors.push(doorway(index, address, &unit, place, &mut rng, &doors));
        }
        doors
    }

    /// The address of a unit of a building with a door at `foot`; the unit is then used.
    fn take(&mut self, index: usize, foot: MapPoint, unit: &str) -> Address {
        let name = self.names.of(index, foot);
        self.units
            .entry(fold(&name))
            .or_default()
            .insert(unit.to_owned());
        Address::new(name, format!("unit{unit}"))
    }

    /// The unit that the map gives to a door, folded, if it is short enough for a plate.
    fn unit_of(&mut self, entrance: &Entrance) -> Option<String> {
        let unit = entrance
            .units
            .iter()
            .map(|u| fold_unit(u))
            .find(|u| fits_on_plate(u))?;
        // Such a door gets a number instead, and numbers are few.
        if !self.texts.contains(&unit) && self.texts.len() >= MAX_TEXTS {
            return None;
        }
        self.texts.insert(unit.clone());
        Some(unit)
    }

    /// The place for a door at `point`: in the nearest wall with free ground in front.
    fn place_near(&self, index: usize, point: MapPoint, others: &[Doorway]) -> Option<Place> {
        let mut near: Vec<Candidate> = walls(&self.map.buildings[index])
            .into_iter()
            // More than twice the margin of `candidate_near`, so that the bounds there are in
            // order.
            .filter(|wall| wall.length() > LEAF_WIDTH_M + 0.6)
            .map(|wall| candidate_near(wall, point))
            .filter(|candidate| candidate.cost <= REACH_M)
            .collect();
        // A stable sort: walls at one distance keep the order of the outline.
        near.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let fits = |place: &Place| {
            let apart = |d: &Doorway| d.position.distance(place.foot) > LEAF_WIDTH_M + 0.4;
            self.front_is_free(place) && others.iter().all(apart)
        };
        near.into_iter().map(|candidate| candidate.place).find(fits)
    }

    fn front_is_free(&self, place: &Place) -> bool {
        let out = place.wall.outward();
        let front = Segment::new(place.foot.offset(out, 0.4), place.foot.offset(out, 1.4));
        self.clearance.is_free(front, 0.3, BUILDING)
    }

    /// Whether one building alone is behind a wall. Maps draw some buildings over each other; a
    /// door in such a wall would belong to several of them.
    fn is_unshared(&self, place: &Place) -> bool {
        let inward = place.wall.bearing() + std::f64::consts::FRAC_PI_2;
        self.clearance
            .areas_at(place.foot.offset(inward, BEHIND_M), BUILDING)
            < 2
    }

    /// Draws the doors of buildings without mapped entrances, and adds them to those `found`.
    fn draw(
        &mut self,
        draw: &Draw,
        buildings: &[usize],
        found: &mut BTreeMap<usize, Vec<Doorway>>,
    ) -> DrawnDoors {
        let mut counts = DrawnDoors {
            mapped: found.values().map(Vec::len).sum(),
            ..DrawnDoors::default()
        };
        let is_home = |index: &usize| {
            let building = &self.map.buildings[*index];
            is_home(building) && !is_open_below(&building.tags)
        };
        let homes = buildings.iter().copied().filter(is_home);
        let drawn: Vec<DoorsOfHome> = homes.map(|home| self.doors_of(draw, home)).collect();
        let (with, without): (Vec<_>, Vec<_>) =
            drawn.into_iter().partition(|home| !home.doors.is_empty());
        counts.without = without.len();
        counts.buildings = with.len();
        // Neighbours in a street are numbered together.
        let numbered: Vec<usize> = with.iter().map(|home| home.building).collect();
        counts.numbers = self.names.draw_numbers(&numbered, draw.seed);
        for home in with {
            found.insert(home.building, self.hang(draw.seed, home, &mut counts));
        }
        counts
    }

    fn doors_of(&self, draw: &Draw, index: usize) -> DoorsOfHome {
        let building = &self.map.buildings[index];
        let number = element_number(building.element);
        let mut draws = draws::stream(draw.seed, DOORS_STREAM, number);
        let wish = wish(building, self.clearance, &mut draws);
        let is_free = |wall: Segment, foot: MapPoint| {
            draw.fits(self.clearance, wall, foot) && self.is_unshared(&Place { wall, foot })
        };
        let walls = walls(building).into_iter();
        DoorsOfHome {
            building: index,
            doors: draw_doors(walls, wish, is_free, &mut draws),
        }
    }

    /// Drawn doors with their addresses and the places of their plates, counted.
    fn hang(&mut self, seed: u64, home: DoorsOfHome, counts: &mut DrawnDoors) -> Vec<Doorway> {
        let building = &self.map.buildings[home.building];
        let number = element_number(building.element);
        // Not by a door, which the number in the public map would give away.
        let middle = building.polygon.centroid();
        let name = fold(&self.names.of(home.building, middle));
        let mut doors: Vec<Doorway> = Vec::new();
        for (i, door) in home.doors.into_iter().enumerate() {
            let used = self.units.get(&name).cloned().unwrap_or_default();
            let unit = Some(fold_unit(&door.unit)).filter(|unit| !used.contains(unit));
            let Some(unit) = unit.or_else(|| free_unit(&used, &[])) else {
                continue;
            };
            counts.count(door.face);
            let place = Place {
                wall: door.wall,
                foot: door.at,
            };
            let mut rng = draws::stream(seed, PLATE_STREAM, mix(number) ^ i as u64);
            let address = self.take(home.building, middle, &unit);
            doors.push(doorway(
                home.building,
                address,
                &unit,
                place,
                &mut rng,
                &doors,
            ));
        }
        doors
    }

    /// A door for a building without a mapped entrance, in the wall nearest to a street.
    fn invented(&mut self, index: usize) -> Option<Doorway> {
        let building = &self.map.buildings[index];
        if !is_home(building) || is_open_below(&building.tags) {
            return None;
        }
        let place = self.place_towards_street(building)?;
        let mut rng = stream(
            self.seed,
            Purpose::Doorway,
            element_number(building.element),
        );
        let name = self.names.of(index, place.foot);
        let used = self.units.get(&fold(&name)).cloned().unwrap_or_default();
        let unit = free_unit(&used, &[])?;
        let address = self.take(index, place.foot, &unit);
        Some(doorway(index, address, &unit, place, &mut rng, &[]))
    }

    fn place_towards_street(&self, building: &Building) -> Option<Place> {
        let long = walls(building)
            .into_iter()
            .filter(|wall| wall.length() > SHORTEST_WALL_M);
        let places = long.map(|wall| Place {
            wall,
            foot: wall.middle(),
        });
        places
            .filter(|place| self.front_is_free(place) && self.is_unshared(place))
            .map(|place| {
                // From before the wall: a road behind the building is farther off.
                let before = place.foot.offset(place.wall.outward(), 1.0);
                let cost = self.clearance.distance(before, ROAD | PATH, STREET_REACH_M);
                Candidate { place, cost }
            })
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
            .map(|candidate| candidate.place)
    }

    fn warnings(&self) -> Vec<String> {
        let counts = [
            (
                self.unplaced,
                "entrances have no free wall nearby and got no door",
            ),
            (
                self.repeated,
                "entrances repeat a unit of their building and got no door",
            ),
            (
                self.beyond,
                "doors are more than a world may have and were left out",
            ),
        ];
        counts
            .iter()
            .filter(|(n, _)| *n > 0)
            .map(|(n, words)| format!("{n} {words}"))
            .collect()
    }
}

fn fits_on_plate(unit: &str) -> bool {
    (1..=LONGEST_UNIT).contains(&unit.len()) && unit.bytes().all(|b| b.is_ascii_alphanumeric())
}

/// The place in a wall that is nearest to a point, far enough from its ends for a door.
fn candidate_near(wall: Segment, point: MapPoint) -> Candidate {
    let length = wall.length();
    // The nearest place, moved away from the corners so far that leaf and frame fit.
    let along = wall.nearest_point(point).share * length;
    let margin = LEAF_WIDTH_M / 2.0;
    let foot = wall.at(along.clamp(margin + 0.25, length - margin - 0.25) / length);
    Candidate {
        place: Place { wall, foot },
        cost: foot.distance(point),
    }
}

/// The lowest number that is no unit yet.
fn free_unit(used: &BTreeSet<String>, given: &[Option<String>]) -> Option<String> {
    let is_given = |n: &String| given.iter().flatten().any(|g| g == n);
    (1..1_000)
        .map(|n: u32| n.to_string())
        .find(|n| !used.contains(n) && !is_given(n))
}

fn doorway(
    building: usize,
    address: Address,
    unit: &str,
    Place { wall, foot }: Place,
    rng: &mut Pcg64Mcg,
    others: &[Doorway],
) -> Doorway {
    let mut door = Doorway {
        address,
        text: format!("UNIT {}", unit.to_uppercase()),
        building,
        position: foot,
        facing: openbench_core::frames::wrap_angle(wall.outward()),
        wall,
        plate_offset: 0.0,
    };
    let first = if chance(rng, 0.5) {
        PLATE_OFFSET_M
    } else {
        -PLATE_OFFSET_M
    };
    // Some plates hang on the leaf although there is room beside it. The draw comes before the
    // search for room, so that a neighbour's door does not change the rest of this one.
    if !chance(rng, 0.3) {
        let offset = [first, -first]
            .into_iter()
            .find(|o| has_room(&door, *o, others));
        door.plate_offset = offset.unwrap_or(0.0);
    }
    door
}

/// Whether a plate beside a door is on the wall and clear of other doors and plates.
fn has_room(door: &Doorway, offset: f64, others: &[Doorway]) -> bool {
    let place = door.position.distance(door.wall.start) + offset;
    let half = PLATE_WIDTH_M / 2.0;
    let on_wall =
        place > half + PLATE_MARGIN_M && place < door.wall.length() - half - PLATE_MARGIN_M;
    let mut spans = others.iter().filter_map(|d| d.span_on(door.wall));
    on_wall && !spans.any(|span| place + half > span.start && place - half < span.end)
}

/// Whether people may live or work in a building.
pub(crate) fn is_home(building: &Building) -> bool {
    const OTHER: [&str; 12] = [
        "garage",
        "garages",
        "shed",
        "roof",
        "carport",
        "hut",
        "greenhouse",
        "ruins",
        "bunker",
        "transformer_tower",
        "storage_tank",
        "service",
    ];
    let is_other = building
        .tags
        .get("building")
        .is_some_and(|kind| OTHER.contains(&kind));
    !is_other && building.polygon.area() > SMALLEST_HOME_M2
}
