//! What belongs to each building of a map: its ways, its parts, and the nodes inside.

use std::collections::{BTreeMap, BTreeSet};

use openbench_core::MapPoint;
use openbench_geometry::Polygon;

use crate::data::OsmData;
use crate::element::{ElementId, ElementKind};
use crate::map::OsmMap;

/// The elements that move and vanish with a building.
#[derive(Debug, Clone, Default)]
pub(super) struct Footprint {
    /// Its outline, the first one of several.
    pub(super) polygon: Polygon,
    /// Its outline's ways, and those of its parts.
    pub(super) ways: Vec<i64>,
    /// Relations that are the building, or parts of it.
    pub(super) relations: Vec<i64>,
    /// Nodes of no way that lie inside, such as its address.
    pub(super) inside: Vec<i64>,
}

/// The footprints of all buildings, by element. A way that two buildings share is the first one's.
pub(super) fn footprints(data: &OsmData, map: &OsmMap) -> BTreeMap<ElementId, Footprint> {
    let mut found: BTreeMap<ElementId, Footprint> = BTreeMap::new();
    let mut taken = BTreeSet::new();
    for building in &map.buildings {
        found.entry(building.element).or_insert_with(|| Footprint {
            polygon: building.polygon.clone(),
            ..own_elements(data, building.element, &mut taken)
        });
    }
    add_parts(data, map, &mut found, &mut taken);
    add_nodes(data, map, &mut found);
    found
}

/// The way or relation of a building, with the ways that make the relation's rings.
fn own_elements(data: &OsmData, element: ElementId, taken: &mut BTreeSet<i64>) -> Footprint {
    match element.kind {
        ElementKind::Relation => Footprint {
            ways: rings_of(data, element.id)
                .into_iter()
                .filter(|way| taken.insert(*way))
                .collect(),
            relations: vec![element.id],
            ..Footprint::default()
        },
        _ => Footprint {
            ways: Vec::from_iter(taken.insert(element.id).then_some(element.id)),
            ..Footprint::default()
        },
    }
}

/// The ways among the members of a relation that the data has.
fn rings_of(data: &OsmData, relation: i64) -> Vec<i64> {
    let members = data.relations.get(&relation).map(|r| &r.members[..]);
    let ways = members.unwrap_or_default().iter();
    ways.filter(|m| m.kind == ElementKind::Way && data.ways.contains_key(&m.id))
        .map(|m| m.id)
        .collect()
}

/// Adds parts of buildings (`building:part=*`) to the building in which they lie.
fn add_parts(
    data: &OsmData,
    map: &OsmMap,
    found: &mut BTreeMap<ElementId, Footprint>,
    taken: &mut BTreeSet<i64>,
) {
    for part in map.areas.iter().filter(|a| a.tags.says("building:part")) {
        let host = building_around(map, part.polygon.interior_point());
        let Some(footprint) = host.and_then(|host| found.get_mut(&host)) else {
            continue;
        };
        match part.element.kind {
            ElementKind::Relation => {
                let rings = rings_of(data, part.element.id).into_iter();
                footprint
                    .ways
                    .extend(rings.filter(|way| taken.insert(*way)));
                footprint.relations.push(part.element.id);
            }
            _ => {
                let way = part.element.id;
                footprint.ways.extend(taken.insert(way).then_some(way));
            }
        }
    }
}

/// Adds nodes that no way uses to the building in which they lie.
fn add_nodes(data: &OsmData, map: &OsmMap, found: &mut BTreeMap<ElementId, Footprint>) {
    let of_ways: BTreeSet<i64> = data
        .ways
        .values()
        .flat_map(|way| way.nodes.iter().copied())
        .collect();
    let alone = data.nodes.values().filter(|n| !of_ways.contains(&n.id));
    for node in alone {
        let host = building_around(map, map.projection.to_map(node.position));
        if let Some(footprint) = host.and_then(|host| found.get_mut(&host)) {
            footprint.inside.push(node.id);
        }
    }
}

/// The building in which a point lies.
fn building_around(map: &OsmMap, point: MapPoint) -> Option<ElementId> {
    let nearest = map.nearest_building(point)?;
    let building = &map.buildings[nearest];
    building.polygon.contains(point).then_some(building.element)
}
