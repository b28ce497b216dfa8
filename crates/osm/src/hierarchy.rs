//! The levels above a building: its street, quarter and town, from tags and named areas.

use std::collections::BTreeMap;

use openbench_core::{AddressLevel, Level, MapPoint};

use crate::map::{Area, OsmMap};
use crate::names::fold;
use crate::tags::Tags;

/// Keys of the levels above a building, the widest first.
const ABOVE: [(&str, Level); 9] = [
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
pub struct Above {
    /// Its kind and its name.
    pub level: AddressLevel,
    /// Areas of that name: indices into [`OsmMap::areas`].
    areas: Vec<usize>,
    /// A point on a road of that name.
    on_road: Option<MapPoint>,
}

impl Above {
    /// Whether a building of [`OsmMap::buildings`] lies in it: by its tags, or because an area
    /// contains its centroid.
    pub fn holds(&self, map: &OsmMap, building: usize) -> bool {
        let Some(building) = map.buildings.get(building) else {
            return false;
        };
        let wanted = fold(&self.level.name);
        let middle = || building.polygon.centroid();
        tagged(&building.tags).any(|level| fold(&level.name) == wanted)
            || self
                .areas
                .iter()
                .any(|area| map.areas[*area].polygon.contains(middle()))
    }

    /// A point in it: the centroid of an area, or a point on a road.
    pub fn place(&self, map: &OsmMap) -> Option<MapPoint> {
        let area = self.areas.first().and_then(|area| map.areas.get(*area));
        area.map(|area: &Area| area.polygon.centroid())
            .or(self.on_road)
    }
}

/// The levels above a building of [`OsmMap::buildings`] that its own tags name, the widest first.
pub fn above(map: &OsmMap, building: usize) -> Vec<AddressLevel> {
    map.buildings
        .get(building)
        .map(|building| tagged(&building.tags).collect())
        .unwrap_or_default()
}

/// All streets, quarters and towns that the map names, each once. Takes time proportional to the
/// number of roads, areas and buildings.
pub fn all_above(map: &OsmMap) -> Vec<Above> {
    let mut found: BTreeMap<AddressLevel, Above> = BTreeMap::new();
    let mut entry = |level: AddressLevel, area: Option<usize>, on_road: Option<MapPoint>| {
        let empty = || Above {
            level: level.clone(),
            areas: Vec::new(),
            on_road: None,
        };
        let above = found.entry(level.clone()).or_insert_with(empty);
        above.areas.extend(area);
        above.on_road = above.on_road.or(on_road);
    };
    let name_of = |tags: &Tags, level| named(level, tags.get("name")?);
    for (i, area) in map.areas.iter().enumerate() {
        name_of(&area.tags, Level::District)
            .into_iter()
            .for_each(|level| entry(level, Some(i), None));
    }
    for road in &map.roads {
        let middle = road.points.get(road.points.len() / 2).copied();
        name_of(&road.tags, Level::Street)
            .into_iter()
            .for_each(|level| entry(level, None, middle));
    }
    for building in &map.buildings {
        tagged(&building.tags).for_each(|level| entry(level, None, None));
    }
    found.into_values().collect()
}

/// Whatever has this name, as all levels at once.
pub(crate) fn called(map: &OsmMap, name: &str) -> Above {
    let wanted = fold(name);
    let is_named = |area: &Area| {
        area.tags
            .get("name")
            .is_some_and(|name| fold(name) == wanted)
    };
    let areas = map
        .areas
        .iter()
        .enumerate()
        .filter(|(_, area)| is_named(area))
        .map(|(i, _)| i)
        .collect();
    let level = AddressLevel {
        level: Level::District,
        name: name.to_owned(),
    };
    Above {
        level,
        areas,
        on_road: None,
    }
}

fn tagged(tags: &Tags) -> impl Iterator<Item = AddressLevel> + '_ {
    ABOVE
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
