//! The *location query* of the OpenBench paper.
//!
//! An address is looked up level by level, from the lowest (unit) to the highest (building). The
//! robot drives to the first level that the map knows; what is below must be found by exploration.

use std::borrow::Cow;
use std::ops::RangeInclusive;

use openbench_core::Address;

use crate::hierarchy::{EnclosingPlace, called};
use crate::map::{Entrance, OsmMap};
use crate::names::fold_unit;
use crate::tags::Tags;

/// The most levels above a building that a name may hold.
const MOST_LEVELS: usize = 4;

/// What the map knows of an address.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Location {
    /// The map knows the door.
    Unit {
        /// Index into [`OsmMap::entrances`].
        entrance: usize,
        /// Index into [`OsmMap::buildings`].
        building: usize,
    },
    /// The map knows the building but not the door. Index into [`OsmMap::buildings`].
    Building(usize),
    /// The map knows neither.
    Unknown,
    /// Several buildings match equally well: indices into [`OsmMap::buildings`], in order.
    Ambiguous(Vec<usize>),
}

/// Looks an address up from the lowest level to the highest.
///
/// A building is looked for by its full names, then by the addresses of its doors, then by its bare
/// number (`ref`, `addr:housenumber`). The first of these that matches any building counts. Commas
/// may be followed by what the building lies in, as in `building3, Rose Estate`: streets, quarters
/// and towns by its tags, and named areas.
///
/// A unit is looked for by the names of doors, then by the numbers of the flats behind them
/// (`addr:flats`). Of several doors to one unit the one with `entrance=main` is taken, else the one
/// with the lowest node number.
///
/// ```
/// use openbench_core::{Address, Georeference, LonLat};
/// use openbench_osm::{Location, OsmData, OsmMap, locate};
///
/// // A house of 11 m by 11 m on the equator, with one door.
/// let data = OsmData::from_xml(
///     br#"<osm version="0.6">
///       <node id="1" lat="0" lon="0"/><node id="2" lat="0" lon="0.0001"/>
///       <node id="3" lat="0.0001" lon="0.0001"/><node id="4" lat="0.0001" lon="0"/>
///       <node id="5" lat="0" lon="0.00005"><tag k="entrance" v="yes"/><tag k="ref" v="1"/></node>
///       <way id="9"><nd ref="1"/><nd ref="5"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/>
///         <tag k="building" v="yes"/><tag k="name" v="building3"/></way>
///     </osm>"#,
/// )?;
/// let map = OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(0.0, 0.0)));
/// let door = Location::Unit { entrance: 0, building: 0 };
/// assert_eq!(locate(&map, &Address::new("Building 3", "unit 1")), door);
/// assert_eq!(locate(&map, &Address::new("Building 3", "unit 2")), Location::Building(0));
/// assert_eq!(locate(&map, &Address::new("Building 4", "unit 1")), Location::Unknown);
/// # Ok::<(), openbench_osm::OsmError>(())
/// ```
pub fn locate(map: &OsmMap, address: &Address) -> Location {
    let matching = &*matching(map, &address.building);
    let Some(first) = matching.first() else {
        return Location::Unknown;
    };
    // A multipolygon with several outer rings is several buildings of one name. They are one
    // address, not an ambiguous one.
    let element = map.buildings[*first].element;
    if matching
        .iter()
        .any(|i| map.buildings[*i].element != element)
    {
        return Location::Ambiguous(matching.to_vec());
    }
    // All matches are parts of one multipolygon.
    match address
        .unit
        .as_ref()
        .and_then(|unit| door(map, matching, unit))
    {
        Some(door) => Location::Unit {
            entrance: door.entrance,
            building: door.building,
        },
        None => Location::Building(largest(map, matching)),
    }
}

/// The buildings with a name. If there are none, the name may end as in `building3, Rose Estate`:
/// then the buildings named before the comma that lie in the place behind it.
fn matching<'a>(map: &'a OsmMap, name: &str) -> Cow<'a, [usize]> {
    let (mut inner, mut around): (&str, Vec<EnclosingPlace>) = (name, Vec::new());
    loop {
        // The whole name comes first: it may contain a comma itself. Then one part after another is
        // taken off its end.
        let found = map.names.buildings(inner);
        if !found.is_empty() || around.len() == MOST_LEVELS {
            return lying_in(map, found, &around);
        }
        let Some((rest, last)) = inner.rsplit_once(',') else {
            return Cow::Borrowed(&[]);
        };
        around.push(called(map, last));
        inner = rest;
    }
}

/// Those of the buildings that lie in all of `around`.
fn lying_in<'a>(
    map: &'a OsmMap,
    buildings: &'a [usize],
    around: &[EnclosingPlace],
) -> Cow<'a, [usize]> {
    if around.is_empty() {
        return Cow::Borrowed(buildings);
    }
    let lies_in_all = |b: &usize| around.iter().all(|above| above.holds(map, *b));
    buildings.iter().copied().filter(lies_in_all).collect()
}

/// A door of a building.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Door {
    /// Lower is better: a door named for the unit, then the main entrance, then the lowest number.
    rank: (UnitMatch, bool),
    entrance: usize,
    building: usize,
}

/// How an entrance is known to lead to a unit. The better match is the lesser value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum UnitMatch {
    /// It bears the unit's name.
    Name,
    /// The unit is the number of a flat behind it.
    Flat,
}

/// The best entrance of these buildings that leads to `unit`.
fn door(map: &OsmMap, buildings: &[usize], unit: &str) -> Option<Door> {
    let unit = Unit::new(unit);
    let doors = map
        .entrances
        .iter()
        .enumerate()
        .filter_map(|(i, entrance)| {
            let building = entrance.building.filter(|b| buildings.contains(b))?;
            let rank = (
                unit.is_behind(entrance)?,
                // `false` sorts first: the main entrance.
                !entrance.tags.is("entrance", "main"),
            );
            Some(Door {
                rank,
                entrance: i,
                building,
            })
        });
    doors.min()
}

/// A unit that is looked for.
struct Unit {
    folded: String,
    /// The number of the flat, if the unit's name can be one.
    flat: Option<u32>,
}

impl Unit {
    fn new(name: &str) -> Self {
        let folded = fold_unit(name);
        let bare = ["flat", "apartment", "apt"]
            .iter()
            .find_map(|word| folded.strip_prefix(word));
        // `addr:flats` lists bare numbers.
        let flat = bare.unwrap_or(&folded).parse().ok();
        Self { folded, flat }
    }

    fn is_behind(&self, entrance: &Entrance) -> Option<UnitMatch> {
        if entrance
            .units
            .iter()
            .any(|name| fold_unit(name) == self.folded)
        {
            return Some(UnitMatch::Name);
        }
        let has_flat = self.flat.is_some_and(|flat| has_flat(&entrance.tags, flat));
        has_flat.then_some(UnitMatch::Flat)
    }
}

/// Whether a flat is among those of `addr:flats`: `1-8;10`.
fn has_flat(tags: &Tags, flat: u32) -> bool {
    let Some(flats) = tags.get("addr:flats") else {
        return false;
    };
    flats
        .split([';', ','])
        .filter_map(flat_range)
        // A range is compared, never listed, so that `1-4000000000` costs nothing.
        .any(|range| range.contains(&flat))
}

/// The flats of `10` or `1-8`.
fn flat_range(text: &str) -> Option<RangeInclusive<u32>> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    Some(first.trim().parse().ok()?..=last.trim().parse().ok()?)
}

fn largest(map: &OsmMap, buildings: &[usize]) -> usize {
    let area = |i: usize| map.buildings[i].polygon.area();
    let larger = |a, b| if area(b) > area(a) { b } else { a };
    buildings.iter().copied().reduce(larger).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use openbench_core::Georeference;
    use openbench_core::LonLat;

    use super::*;
    use crate::data::OsmData;
    use crate::element::{Node, Way};

    /// Square houses of 0.0001 degrees (11 m) in a row along the equator, one for each list of
    /// tags.
    fn street(houses: &[&[(&str, &str)]]) -> OsmData {
        let mut data = OsmData::default();
        for (house, tags) in (0..).zip(houses) {
            let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
            let id = |corner: usize| house * 10 + corner as i64 + 1;
            for (i, (x, y)) in corners.iter().enumerate() {
                let position = LonLat::new((house as f64 * 2.0 + x) * 1e-4, y * 1e-4);
                data.nodes.insert(
                    id(i),
                    Node {
                        id: id(i),
                        position,
                        tags: Tags::new(),
                    },
                );
            }
            let mut tags: Tags = tags.iter().copied().collect();
            tags.insert("building", "yes");
            data.ways.insert(
                house,
                Way {
                    id: house,
                    nodes: vec![id(0), id(1), id(2), id(3), id(0)],
                    tags,
                },
            );
        }
        data
    }

    fn tag_node(data: &mut OsmData, node: i64, tags: &[(&str, &str)]) {
        data.nodes.get_mut(&node).unwrap().tags = tags.iter().copied().collect();
    }

    fn look_up(data: &OsmData, building: &str, unit: Option<&str>) -> Location {
        let map = OsmMap::new(data, Georeference::tangent_plane(LonLat::new(0.0, 0.0)));
        locate(
            &map,
            &Address {
                building: building.into(),
                unit: unit.map(str::to_owned),
            },
        )
    }

    #[test]
    fn the_lowest_level_that_the_map_knows_is_found() {
        let mut data = street(&[&[("name", "building1")], &[("name", "building11")]]);
        tag_node(&mut data, 2, &[("entrance", "yes"), ("addr:unit", "unit1")]);
        assert_eq!(
            look_up(&data, "Building 1", Some("Unit 1")),
            Location::Unit {
                entrance: 0,
                building: 0
            }
        );
        assert_eq!(
            look_up(&data, "Building 1", Some("1")),
            Location::Unit {
                entrance: 0,
                building: 0
            }
        );
        assert_eq!(
            look_up(&data, "Building 1", Some("unit11")),
            Location::Building(0)
        );
        assert_eq!(look_up(&data, "Building 1", None), Location::Building(0));
        assert_eq!(
            look_up(&data, "building 11", Some("1")),
            Location::Building(1)
        );
        assert_eq!(
            look_up(&data, "building 2", Some("unit1")),
            Location::Unknown
        );
    }

    #[test]
    fn buildings_with_one_name_are_ambiguous_but_a_full_name_counts_before_a_number() {
        let data = street(&[
            &[("name", "3")],
            &[("addr:housenumber", "3"), ("addr:street", "Rua Alta")],
            &[("addr:housenumber", "3"), ("addr:street", "Rua Baixa")],
            &[("ref", "5")],
            &[("addr:housenumber", "5")],
        ]);
        assert_eq!(look_up(&data, "3", None), Location::Building(0));
        assert_eq!(look_up(&data, "rua baixa 3", None), Location::Building(2));
        assert_eq!(look_up(&data, "3 Rua Alta", None), Location::Building(1));
        assert_eq!(
            look_up(&data, "Building 5", None),
            Location::Ambiguous(vec![3, 4])
        );
    }

    #[test]
    fn a_building_is_found_by_the_address_on_its_door() {
        let mut data = street(&[&[], &[]]);
        let address = [
            ("addr:street", "Rua Alta"),
            ("addr:housenumber", "7"),
            ("entrance", "main"),
        ];
        tag_node(&mut data, 12, &address);
        assert_eq!(look_up(&data, "Rua Alta 7", None), Location::Building(1));
        assert_eq!(look_up(&data, "7", None), Location::Building(1));
    }

    #[test]
    fn the_estate_behind_a_comma_distinguishes_buildings_with_one_name() {
        let data = street(&[
            &[
                ("name", "building3"),
                ("addr:suburb", "Rose Estate"),
                ("addr:city", "Rivertown"),
            ],
            &[
                ("name", "building3"),
                ("addr:suburb", "Lily Estate"),
                ("addr:city", "Rivertown"),
            ],
            &[("name", "Tower, North"), ("addr:street", "Rua Alta")],
        ]);
        assert_eq!(
            look_up(&data, "building3", None),
            Location::Ambiguous(vec![0, 1])
        );
        assert_eq!(
            look_up(&data, "building 3, lily estate", None),
            Location::Building(1)
        );
        assert_eq!(
            look_up(&data, "building3, Rose Estate, Rivertown", None),
            Location::Building(0)
        );
        assert_eq!(
            look_up(&data, "building3, Rivertown", None),
            Location::Ambiguous(vec![0, 1])
        );
        assert_eq!(
            look_up(&data, "building3, Elsewhere", None),
            Location::Unknown
        );
        assert_eq!(
            look_up(&data, "Tower, North, Rua Alta", None),
            Location::Building(2)
        );
        assert_eq!(
            look_up(&data, &"building3,".repeat(10_000), None),
            Location::Unknown
        );
    }

    #[test]
    fn a_flat_leads_to_its_door() {
        let mut data = street(&[&[("name", "A")]]);
        tag_node(
            &mut data,
            1,
            &[("entrance", "yes"), ("ref", "1"), ("addr:flats", "1-8;20")],
        );
        tag_node(
            &mut data,
            3,
            &[
                ("entrance", "yes"),
                ("ref", "2"),
                ("addr:flats", "9-16, x, 30-18, 4294967296"),
            ],
        );
        for (unit, entrance) in [
            ("flat 12", Some(1)),
            ("12", Some(1)),
            ("unit20", Some(0)),
            ("2", Some(1)),
            ("8", Some(0)),
            ("17", None),
        ] {
            let wanted = entrance.map_or(Location::Building(0), |entrance| Location::Unit {
                entrance,
                building: 0,
            });
            assert_eq!(look_up(&data, "A", Some(unit)), wanted, "{unit}");
        }
    }

    #[test]
    fn of_two_doors_to_one_unit_the_main_entrance_is_taken() {
        let mut data = street(&[&[("name", "A")]]);
        tag_node(&mut data, 1, &[("entrance", "yes"), ("ref", "2")]);
        tag_node(&mut data, 3, &[("entrance", "main"), ("ref", "2")]);
        assert_eq!(
            look_up(&data, "A", Some("2")),
            Location::Unit {
                entrance: 1,
                building: 0
            }
        );
    }
}
