//! The levels above a building: its street, quarter and town, from tags and named areas.

use std::collections::BTreeMap;

use openbench_core::{AddressLevel, Level, MapPoint};

use crate::map::{Area, OsmMap};
use crate::names::fold;
use crate::tags::Tags;

/// Keys of the levels above a building, the widest first.
const LEVEL_KEYS: [(&str, Level); 9] = [
    ("addr:city", Level::District),
    ("addr:district", Level::District),
    ("addr:suburb", Level::District),
    ("addr:quarter", Level::District),
    ("addr:neighbourhood", Level::District),
    ("addr:hamlet", Level::District),
    ("addr:place", Level::District),
    ("addr:block", Level::District),
    ("addr:street", Level::Street),
];

/// A street, quarter or town that the map names.
#[derive(Debug, Clone, PartialEq)]
pub struct EnclosingPlace {
    /// Its kind and its name.
    pub level: AddressLevel,
    /// Areas of that name: indices into [`OsmMap::areas`].
    areas: Vec<usize>,
    /// A point on a road of that name.
    on_road: Option<MapPoint>,
}

impl EnclosingPlace {
    /// Whether a building of [`OsmMap::buildings`] lies in it: by its tags, or because an area
    /// contains its centroid.
    pub fn holds(&self, map: &OsmMap, building: usize) -> bool {
        let Some(building) = map.buildings.get(building) else {
            return false;
        };
        let wanted = fold(&self.level.name);
        if tagged(&building.tags).any(|level| fold(&level.name) == wanted) {
            return true;
        }
        // The centroid, so that a building on the border of two neighbours lies in one of them.
        let middle = building.polygon.centroid();
        self.areas
            .iter()
            .any(|area| map.areas[*area].polygon.contains(middle))
    }

    /// A point in it: the centroid of an area, or a point on a road.
    pub fn place(&self, map: &OsmMap) -> Option<MapPoint> {
        let area = self.areas.first().and_then(|area| map.areas.get(*area));
        area.map(|area: &Area| area.polygon.centroid())
            .or(self.on_road)
    }
}

/// The levels above a building of [`OsmMap::buildings`] that its own tags name, the widest first.
pub fn enclosing_levels(map: &OsmMap, building: usize) -> Vec<AddressLevel> {
    map.buildings
        .get(building)
        .map(|building| tagged(&building.tags).collect())
        .unwrap_or_default()
}

/// All streets, quarters and towns that the map names, each once. Takes time proportional to the
/// number of roads, areas and buildings.
pub fn enclosing_places(map: &OsmMap) -> Vec<EnclosingPlace> {
    let mut found: BTreeMap<AddressLevel, EnclosingPlace> = BTreeMap::new();
    for (i, area) in map.areas.iter().enumerate() {
        if let Some(level) = own_name(&area.tags, Level::District) {
            place_of(&mut found, level).areas.push(i);
        }
    }
    for road in &map.roads {
        if let Some(level) = own_name(&road.tags, Level::Street) {
            let middle = road.points.get(road.points.len() / 2).copied();
            let street = place_of(&mut found, level);
            // The first of its roads: any point on the street will do.
            street.on_road = street.on_road.or(middle);
        }
    }
    for building in &map.buildings {
        for level in tagged(&building.tags) {
            place_of(&mut found, level);
        }
    }
    found.into_values().collect()
}

/// The place of a name, which is added without area and road if it is not there yet.
fn place_of(
    found: &mut BTreeMap<AddressLevel, EnclosingPlace>,
    level: AddressLevel,
) -> &mut EnclosingPlace {
    found
        .entry(level)
        .or_insert_with_key(|level| EnclosingPlace {
            level: level.clone(),
            areas: Vec::new(),
            on_road: None,
        })
}

fn own_name(tags: &Tags, level: Level) -> Option<AddressLevel> {
    named(level, tags.get("name")?)
}

/// Whatever has this name, as all levels at once.
pub(crate) fn called(map: &OsmMap, name: &str) -> EnclosingPlace {
    let wanted = fold(name);
    let areas = (0..map.areas.len())
        .filter(|i| {
            let name = map.areas[*i].tags.get("name");
            name.is_some_and(|name| fold(name) == wanted)
        })
        .collect();
    // `holds` compares the name alone, so the kind has no meaning here.
    let level = AddressLevel {
        level: Level::District,
        name: name.to_owned(),
    };
    EnclosingPlace {
        level,
        areas,
        on_road: None,
    }
}

fn tagged(tags: &Tags) -> impl Iterator<Item = AddressLevel> + '_ {
    LEVEL_KEYS
        .iter()
        .filter_map(|(key, level)| named(*level, tags.get(key)?))
}

fn named(level: Level, name: &str) -> Option<AddressLevel> {
    let name = name.trim();
    (!name.is_empty()).then(|| AddressLevel {
        level,
        name: name.to_owned(),
    })
}
