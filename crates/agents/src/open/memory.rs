//! The agent's own copy of the map, into which it writes the doors that it finds.

use std::collections::BTreeMap;

use openbench_core::{Address, Event, Events, Georeference, MapPoint};
use openbench_geometry::Polygon;
use openbench_localization::registration::BuildingOffset;
use openbench_osm::{OsmData, OsmMap, add_entrance, merge_entrances};

use crate::open::sighting::Sighting;

/// How far inside the outline of its building a recessed door may lie.
const RECESS_M: f64 = 4.0;
/// A written door is moved if it is seen at least this far away.
const MOVED_M: f64 = 0.3;

/// An outline is moved once it is this far from where it is known to be, metres.
const DISPLACED_M: f64 = 0.3;

/// How far buildings moved, by their index: metres along x and y of `map`.
pub type Moves = BTreeMap<usize, MapPoint>;

/// The map as the agent knows it.
#[derive(Debug)]
pub struct Memory {
    data: OsmData,
    map: OsmMap,
    /// From where the map shows buildings to where they are.
    shifts: BTreeMap<usize, MapPoint>,
    /// The map with the buildings where they are, if that is elsewhere.
    corrected: Option<OsmMap>,
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
            shifts: BTreeMap::new(),
            corrected: None,
            written: Vec::new(),
        }
    }

    /// Takes over where buildings are. Gives how far which of them moved on [`Memory::ground`].
    pub fn correct(&mut self, offsets: &[BuildingOffset]) -> Moves {
        let mut moves = Moves::new();
        for one in offsets {
            let known = self.shifts.get(&one.building).copied().unwrap_or_default();
            let shift = MapPoint::new(one.offset.x, one.offset.y);
            if one.building < self.map.buildings.len() && shift.distance(known) > DISPLACED_M {
                self.shifts.insert(one.building, shift);
                let by = MapPoint::new(shift.x - known.x, shift.y - known.y);
                moves.insert(one.building, by);
            }
        }
        if !moves.is_empty() {
            self.corrected = Some(self.map.with_buildings_moved(&self.shifts));
        }
        moves
    }

    /// Forgets where buildings are: they are where the map shows them. Gives how far which of them
    /// moved by that.
    pub fn forget_corrections(&mut self) -> Moves {
        self.corrected = None;
        let shifts = std::mem::take(&mut self.shifts).into_iter();
        shifts
            .map(|(building, shift)| (building, MapPoint::new(-shift.x, -shift.y)))
            .collect()
    }

    /// The map with the buildings where they are.
    pub fn ground(&self) -> &OsmMap {
        self.corrected.as_ref().unwrap_or(&self.map)
    }

    /// The map in metres, as others know it.
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
        // Others know the building where the map shows it, and the door on its outline.
        let at = doorway(
            sighting,
            &self.ground().buildings[sighting.building].polygon,
        );
        let shift = self.shifts.get(&sighting.building).copied();
        let shift = shift.unwrap_or_default();
        let at = MapPoint::new(at.x - shift.x, at.y - shift.y);
        match add_entrance(&mut self.data, &projection, building.element, at, &address) {
            Ok(entrance) => {
                // Only once the map took the new position, so an error leaves the written door as
                // it was.
                before.map(|i| self.written.remove(i));
                self.written.push(sighting.clone());
                // Building indices stay: entrances add nodes, not buildings.
                self.map = OsmMap::new(&self.data, self.georeference);
                if self.corrected.is_some() {
                    self.corrected = Some(self.map.with_buildings_moved(&self.shifts));
                }
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

#[cfg(test)]
mod tests {
    use openbench_core::LonLat;

    use super::*;

    /// A house of 20 m by 10 m with its lower left corner at the origin.
    const MAP: &str = r#"<osm version="0.6">
      <node id="1" lat="0.0" lon="0.0"/><node id="2" lat="0.0" lon="0.00018"/>
      <node id="3" lat="0.00009" lon="0.00018"/><node id="4" lat="0.00009" lon="0.0"/>
      <way id="5"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/>
        <tag k="building" v="yes"/><tag k="name" v="House"/></way></osm>"#;

    fn memory() -> Memory {
        let data = OsmData::from_bytes(MAP.as_bytes()).unwrap();
        let origin = Georeference::tangent_plane(LonLat::new(0.0, 0.0));
        Memory::new(data, origin, None)
    }

    fn two_metres_south() -> [BuildingOffset; 1] {
        [BuildingOffset {
            building: 0,
            offset: nalgebra::Vector2::new(0.0, -2.0),
        }]
    }

    #[test]
    fn an_outline_is_where_the_building_is_until_that_is_forgotten() {
        let mut memory = memory();
        let before = MapPoint::new(10.0, -1.0);
        assert!(!memory.ground().buildings[0].polygon.contains(before));
        let south = Moves::from([(0, MapPoint::new(0.0, -2.0))]);
        assert_eq!(memory.correct(&two_metres_south()), south);
        assert!(
            memory.correct(&two_metres_south()).is_empty(),
            "it is known"
        );
        assert!(memory.ground().buildings[0].polygon.contains(before));
        assert!(!memory.map().buildings[0].polygon.contains(before));
        let north = Moves::from([(0, MapPoint::new(0.0, 2.0))]);
        assert_eq!(memory.forget_corrections(), north);
        assert!(!memory.ground().buildings[0].polygon.contains(before));
    }

    #[test]
    fn a_door_is_written_onto_the_outline_that_others_know() {
        let mut memory = memory();
        memory.correct(&two_metres_south());
        let door = Sighting {
            unit: "unit1".into(),
            building: 0,
            position: MapPoint::new(5.0, -2.1),
            facing: -std::f64::consts::FRAC_PI_2,
            confidence: 0.9,
        };
        memory.write(&door, &mut Vec::new());
        let [on_map] = &memory.map().entrances[..] else {
            panic!("one door")
        };
        assert!(on_map.position.distance(MapPoint::new(5.0, 0.0)) < 0.2);
        let there = memory.ground().entrances[0].position;
        assert!(there.distance(MapPoint::new(5.0, -2.0)) < 0.2, "{there}");
    }
}
