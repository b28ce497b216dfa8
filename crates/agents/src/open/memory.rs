//! The agent's own copy of the map, into which it writes the doors that it finds.

use openbench_core::{Address, Event, Events, Georeference, MapPoint};
use openbench_geometry::Polygon;
use openbench_osm::{OsmData, OsmMap, add_entrance, merge_entrances};

use crate::open::sighting::Sighting;

/// How far inside the outline of its building a recessed door may lie.
const RECESS_M: f64 = 4.0;
/// A written door is moved if it is seen at least this far away.
const MOVED_M: f64 = 0.3;

/// The map as the agent knows it.
#[derive(Debug)]
pub struct Memory {
    data: OsmData,
    map: OsmMap,
    georeference: Georeference,
    written: Vec<Sighting>,
}

impl Memory {
    /// The public map, with the doors of an earlier copy of it.
    pub fn new(public: OsmData, georeference: Georeference, remembered: Option<&OsmData>) -> Self {
        let mut data = public;
        if let Some(remembered) = remembered {
            merge_entrances(&mut data, remembered);
        }
        Self {
            map: OsmMap::new(&data, georeference),
            data,
            georeference,
            written: Vec::new(),
        }
    }

    /// The map in metres.
    pub fn map(&self) -> &OsmMap {
        &self.map
    }

    /// The map as OSM data.
    pub fn data(&self) -> &OsmData {
        &self.data
    }

    /// Writes a door, or moves it if it was written before and is now seen elsewhere.
    pub fn write(&mut self, sighting: &Sighting, events: &mut dyn Events) {
        let same = |w: &Sighting| w.building == sighting.building && w.unit == sighting.unit;
        let before = self.written.iter().position(same);
        if before.is_some_and(|i| self.written[i].position.distance(sighting.position) < MOVED_M) {
            return;
        }
        let building = &self.map.buildings[sighting.building];
        // The address has to find the building again; one without a name is found by its element.
        let name = building
            .name
            .clone()
            .unwrap_or_else(|| building.element.to_string());
        let address = Address::new(name, sighting.unit.clone());
        let projection = self.map.projection.clone();
        let at = doorway(sighting, &building.polygon);
        match add_entrance(&mut self.data, &projection, building.element, at, &address) {
            Ok(entrance) => {
                // Only once the map took the new position, so an error leaves the written door as
                // it was.
                before.map(|i| self.written.remove(i));
                self.written.push(sighting.clone());
                // Building indices stay: entrances add nodes, not buildings.
                self.map = OsmMap::new(&self.data, self.georeference);
                events.record(Event::DoorWritten {
                    address,
                    position: entrance.position,
                });
            }
            Err(error) => events.record(Event::Note(format!("door not written: {error}"))),
        }
    }
}

/// The point of the outline in front of a plate. Recessed doors lie inside the outline.
fn doorway(sighting: &Sighting, outline: &Polygon) -> MapPoint {
    // Outwards along the facing, until the outline is left. A plate outside the outline ends the
    // search at once, and one deeper inside than any recess stays where it was seen.
    let steps = (0..=(RECESS_M / 0.1) as usize)
        .map(|i| sighting.position.offset(sighting.facing, i as f64 * 0.1));
    let inside = outline.contains(sighting.position);
    steps
        .into_iter()
        .find(|p| !inside || !outline.contains(*p))
        .unwrap_or(sighting.position)
}
