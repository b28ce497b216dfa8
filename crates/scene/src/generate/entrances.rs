//! Where the doors are: at the map's `entrance` nodes; else, if asked for, one in the wall nearest to a street. What their
//! buildings are called, in the public map too, is for [`naming`](super::naming) to say.

use std::collections::{BTreeMap, BTreeSet};

use openbench_core::{Address, MapPoint, Pose2};
use openbench_osm::names::{fold, fold_unit};
use openbench_osm::{Building, Entrance, OsmData, OsmMap};

use super::buildings::is_open_below;
use super::clearance::{BUILDING, Clearance, PATH, ROAD};
use super::naming::Names;
use super::seeds::{Purpose, chance, stream};
use super::shapes::along;
use super::{GenerateOptions, element_number};
use crate::plate::PLATE_WIDTH;

/// Width of a door leaf, metres.
pub(super) const LEAF: f64 = 1.0;
/// Middle of the plate from the middle of the door along the wall, metres.
const BESIDE: f64 = 1.25;
/// So far behind a wall it is looked up which buildings are there, metres.
const BEHIND: f64 = 0.3;
/// An entrance node farther than this from a wall is not taken for one in it, metres.
const REACH: f64 = 2.0;
/// Doors in a world at most.
const MAX_DOORS: usize = 20_000;
/// Longest unit on a plate, characters, and how many different ones the map may bring: each is an image.
const LONGEST_UNIT: usize = 4;
const MAX_TEXTS: usize = 500;

/// A door in a wall.
#[derive(Debug, Clone)]
pub(super) struct Doorway {
    /// Building and unit.
    pub address: Address,
    /// Words on the plate.
    pub text: String,
    /// Index of the building.
    pub building: usize,
    /// Foot of the door, in the wall.
    position: MapPoint,
    /// Direction out of the wall, radians.
    pub facing: f64,
    /// The wall, the building on its left.
    wall: (MapPoint, MapPoint),
    /// Where the plate is, metres along the wall from the middle of the door; 0 is on the leaf.
    pub plate_offset: f64,
}

impl Doorway {
    /// Foot of the door, in the wall.
    pub fn middle(&self) -> MapPoint {
        self.position
    }

    /// Facing out of the wall; left is along the wall.
    pub fn pose(&self) -> Pose2 {
        Pose2::new(self.position.x, self.position.y, self.facing)
    }

    /// Foot of the plate, in the wall.
    pub fn plate_point(&self) -> MapPoint {
        self.pose().transform(0.0, self.plate_offset)
    }

    /// What door and plate take of a wall from `a` to `b`: from and to, metres from `a`; `None` if they are in another.
    pub fn span_on(&self, (a, b): (MapPoint, MapPoint)) -> Option<(f64, f64)> {
        let direction = a.bearing_to(b);
        let (along, aside) = Pose2::new(a.x, a.y, direction).inverse_transform(self.position);
        let parallel = libm::cos(self.facing + std::f64::consts::FRAC_PI_2 - direction) > 0.99;
        if !parallel || aside.abs() > 0.1 || along < 0.0 || along > a.distance(b) {
            return None;
        }
        let plate = along + self.plate_offset;
        let half = PLATE_WIDTH / 2.0;
        Some((
            (along - LEAF / 2.0 - 0.15).min(plate - half),
            (along + LEAF / 2.0 + 0.15).max(plate + half),
        ))
    }
}

/// The doors of all buildings, in the order of buildings and entrances, and what had to be left out, in words.
pub(super) fn place(
    map: &OsmMap,
    public: &mut OsmData,
    (seed, options): (u64, &GenerateOptions),
    clearance: &Clearance,
) -> (Vec<Doorway>, Vec<String>) {
    let mut doors = Vec::new();
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
    let mut of_building: Vec<Vec<&Entrance>> = vec![Vec::new(); map.buildings.len()];
    for entrance in &map.entrances {
        if let Some(list) = entrance.building.and_then(|b| of_building.get_mut(b)) {
            list.push(entrance);
        }
    }
    for (index, entrances) in of_building.iter().enumerate() {
        let found = if entrances.is_empty() {
            placer.invented(index, options).into_iter().collect()
        } else {
            placer.mapped(index, entrances)
        };
        let room = MAX_DOORS.saturating_sub(doors.len());
        placer.beyond += found.len().saturating_sub(room);
        doors.extend(found.into_iter().take(room));
    }
    let warnings = placer.warnings();
    placer.names.write(public);
    (doors, warnings)
}

struct Placer<'a> {
    map: &'a OsmMap,
    clearance: &'a Clearance,
    seed: u64,
    names: Names<'a>,
    /// Units that each building name has already, both folded.
    units: BTreeMap<String, BTreeSet<String>>,
    /// Units that plates were painted for.
    texts: BTreeSet<String>,
    unplaced: usize,
    repeated: usize,
    beyond: usize,
}

impl Placer<'_> {
    fn mapped(&mut self, index: usize, entrances: &[&Entrance]) -> Vec<Doorway> {
        let mut doors: Vec<Doorway> = Vec::new();
        let given: Vec<Option<String>> = entrances.iter().map(|e| self.unit_of(e)).collect();
        for (entrance, own) in entrances.iter().zip(&given) {
            let known = self.names.given(index).map(|name| fold(&name));
            let used = known
                .and_then(|name| self.units.get(&name))
                .cloned()
                .unwrap_or_default();
            let Some(unit) = own
                .clone()
                .or_else(|| free_unit(&used, &given))
                .filter(|u| !used.contains(u))
            else {
                self.repeated += 1;
                continue;
            };
            let Some((wall, position)) = self.wall_at(index, entrance.position, &doors) else {
                self.unplaced += 1;
                continue;
            };
            let mut rng = stream(self.seed, Purpose::Doorway, entrance.node as u64);
            let name = self.take(index, position, &unit);
            doors.push(doorway(
                index,
                (name, &unit),
                (wall, position),
                &mut rng,
                &doors,
            ));
        }
        doors
    }

    /// The name of a building with a door at `position`, which gets the unit.
    fn take(&mut self, index: usize, position: MapPoint, unit: &str) -> String {
        let name = self.names.of(index, position);
        self.units
            .entry(fold(&name))
            .or_default()
            .insert(unit.to_owned());
        name
    }

    /// The unit that the map gives to a door, folded, if it is short enough for a plate.
    fn unit_of(&mut self, entrance: &Entrance) -> Option<String> {
        let units = entrance.units.iter().map(|u| fold_unit(u));
        let unit = { units }.find(|u| {
            (1..=LONGEST_UNIT).contains(&u.len()) && u.bytes().all(|b| b.is_ascii_alphanumeric())
        })?;
        let painted = self.texts.contains(&unit) || self.texts.len() < MAX_TEXTS;
        painted.then(|| {
            self.texts.insert(unit.clone());
            unit
        })
    }

    /// The wall that a door at `point` is in, and where in it: the nearest wall with free ground in front.
    fn wall_at(
        &self,
        index: usize,
        point: MapPoint,
        others: &[Doorway],
    ) -> Option<((MapPoint, MapPoint), MapPoint)> {
        let walls = walls(&self.map.buildings[index]);
        let mut near: Vec<(f64, (MapPoint, MapPoint), MapPoint)> = walls
            .into_iter()
            .filter(|(a, b)| a.distance(*b) > LEAF + 0.6)
            .map(|wall| {
                let length = wall.0.distance(wall.1);
                let share = nearest_share(wall, point) * length;
                let foot = along(
                    wall.0,
                    wall.1,
                    share.clamp(LEAF / 2.0 + 0.25, length - LEAF / 2.0 - 0.25) / length,
                );
                (foot.distance(point), wall, foot)
            })
            .filter(|(distance, _, _)| *distance <= REACH)
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let fits = |wall: (MapPoint, MapPoint), foot: MapPoint| {
            self.front_is_free(wall, foot)
                && others
                    .iter()
                    .all(|d| d.position.distance(foot) > LEAF + 0.4)
        };
        near.into_iter()
            .find(|(_, wall, foot)| fits(*wall, *foot))
            .map(|(_, wall, foot)| (wall, foot))
    }

    fn front_is_free(&self, (a, b): (MapPoint, MapPoint), foot: MapPoint) -> bool {
        let out = a.bearing_to(b) - std::f64::consts::FRAC_PI_2;
        self.clearance
            .is_free(foot.offset(out, 0.4), foot.offset(out, 1.4), 0.3, BUILDING)
    }

    /// Whether one building alone is behind a wall. Maps draw some buildings over each other; to
    /// which of them a door in such a wall belongs, nobody could tell.
    fn is_unshared(&self, (a, b): (MapPoint, MapPoint), foot: MapPoint) -> bool {
        let inward = a.bearing_to(b) + std::f64::consts::FRAC_PI_2;
        self.clearance
            .areas_at(foot.offset(inward, BEHIND), BUILDING)
            < 2
    }

    fn invented(&mut self, index: usize, options: &GenerateOptions) -> Option<Doorway> {
        let building = &self.map.buildings[index];
        if !options.invent_doors || !is_lived_in(building) || is_open_below(&building.tags) {
            return None;
        }
        let candidates = walls(building)
            .into_iter()
            .filter(|(a, b)| a.distance(*b) > 2.5);
        let ranked = candidates.filter_map(|wall| {
            let middle = along(wall.0, wall.1, 0.5);
            let out = wall.0.bearing_to(wall.1) - std::f64::consts::FRAC_PI_2;
            let free = self.front_is_free(wall, middle) && self.is_unshared(wall, middle);
            free.then(|| {
                (
                    self.clearance
                        .distance(middle.offset(out, 1.0), ROAD | PATH, 60.0),
                    wall,
                    middle,
                )
            })
        });
        let (_, wall, middle) = ranked.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let mut rng = stream(
            self.seed,
            Purpose::Doorway,
            element_number(building.element),
        );
        let name = self.names.of(index, middle);
        let used = self.units.get(&fold(&name)).cloned().unwrap_or_default();
        let unit = free_unit(&used, &[])?;
        let name = self.take(index, middle, &unit);
        Some(doorway(index, (name, &unit), (wall, middle), &mut rng, &[]))
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

/// The lowest number that is no unit yet.
fn free_unit(used: &BTreeSet<String>, given: &[Option<String>]) -> Option<String> {
    let is_given = |n: &String| given.iter().flatten().any(|g| g == n);
    (1..1_000)
        .map(|n: u32| n.to_string())
        .find(|n| !used.contains(n) && !is_given(n))
}

fn doorway(
    building: usize,
    (name, unit): (String, &str),
    (wall, position): ((MapPoint, MapPoint), MapPoint),
    rng: &mut rand_pcg::Pcg64Mcg,
    others: &[Doorway],
) -> Doorway {
    let mut door = Doorway {
        address: Address::new(name, format!("unit{unit}")),
        text: format!("UNIT {}", unit.to_uppercase()),
        building,
        position,
        facing: openbench_core::frames::wrap_angle(
            wall.0.bearing_to(wall.1) - std::f64::consts::FRAC_PI_2,
        ),
        wall,
        plate_offset: 0.0,
    };
    let first = if chance(rng, 0.5) { BESIDE } else { -BESIDE };
    if !chance(rng, 0.3) {
        door.plate_offset = [first, -first]
            .into_iter()
            .find(|o| has_room(&door, *o, others))
            .unwrap_or(0.0);
    }
    door
}

fn has_room(door: &Doorway, offset: f64, others: &[Doorway]) -> bool {
    let (a, b) = door.wall;
    let place = door.position.distance(a) + offset;
    let on_wall =
        place > PLATE_WIDTH / 2.0 + 0.1 && place < a.distance(b) - PLATE_WIDTH / 2.0 - 0.1;
    let taken =
        |span: (f64, f64)| place + PLATE_WIDTH / 2.0 > span.0 && place - PLATE_WIDTH / 2.0 < span.1;
    on_wall
        && !others
            .iter()
            .filter_map(|d| d.span_on(door.wall))
            .any(taken)
}

fn nearest_share((a, b): (MapPoint, MapPoint), p: MapPoint) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    (((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy).max(1e-9)).clamp(0.0, 1.0)
}

fn is_lived_in(building: &Building) -> bool {
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
    !building
        .tags
        .get("building")
        .is_some_and(|kind| OTHER.contains(&kind))
        && building.polygon.area() > 20.0
}

/// The straight walls of a building, the building on the left of each: an entrance node in a wall does not divide it.
pub(super) fn walls(building: &Building) -> Vec<(MapPoint, MapPoint)> {
    let rings = building.polygon.rings().map(straightened);
    rings
        .flat_map(|ring| {
            (0..ring.len())
                .map(|i| (ring[i], ring[(i + 1) % ring.len()]))
                .collect::<Vec<_>>()
        })
        .collect()
}

/// A ring without the corners at which it does not bend.
pub(super) fn straightened(ring: &[MapPoint]) -> Vec<MapPoint> {
    let mut kept = ring.to_vec();
    let mut i = 0;
    while i < kept.len() && kept.len() > 3 {
        let n = kept.len();
        let (before, after) = (kept[(i + n - 1) % n], kept[(i + 1) % n]);
        if super::clearance::point_distance(kept[i], (before, after)) < 0.05 {
            kept.remove(i);
        } else {
            i += 1;
        }
    }
    kept
}
