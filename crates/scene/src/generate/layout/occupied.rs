//! Ground that is taken while a world is built: later things give way to earlier ones.

use openbench_core::MapPoint;
use openbench_geometry::Segment;

use super::clearance::{Clearance, Kinds, OBJECT};

/// What the map keeps free, and the objects that were placed so far.
pub(crate) struct Occupied<'a> {
    map: &'a Clearance,
    objects: Clearance,
}

impl<'a> Occupied<'a> {
    /// No objects yet.
    pub fn new(map: &'a Clearance) -> Self {
        Self {
            map,
            // Both grids together stay within the limit of entries.
            objects: map.with_remaining_room(),
        }
    }

    /// Records an object that stands within `radius` metres of a segment.
    pub fn add(&mut self, axis: Segment, radius: f64) {
        self.objects.add(axis, radius, OBJECT);
    }

    /// Records a round object.
    pub fn add_disc(&mut self, center: MapPoint, radius: f64) {
        self.objects.add_disc(center, radius, OBJECT);
    }

    /// Whether a capsule touches nothing of `kinds`.
    pub fn is_free(&self, axis: Segment, radius: f64, kinds: Kinds) -> bool {
        self.map.is_free(axis, radius, kinds)
            // `objects` holds objects alone, so other kinds need no search in it.
            && (kinds & OBJECT == 0 || self.objects.is_free(axis, radius, OBJECT))
    }

    /// Whether a disc touches nothing of `kinds`.
    pub fn is_free_at(&self, center: MapPoint, radius: f64, kinds: Kinds) -> bool {
        self.is_free(Segment::new(center, center), radius, kinds)
    }
}

#[cfg(test)]
mod tests {
    use super::super::clearance::{BUILDING, EVERYTHING};
    use super::*;

    #[test]
    fn objects_stand_beside_what_the_map_keeps_free() {
        let mut map = Clearance::default();
        map.add_disc(MapPoint::new(0.0, 0.0), 1.0, BUILDING);
        let mut occupied = Occupied::new(&map);
        let place = MapPoint::new(5.0, 0.0);
        assert!(occupied.is_free_at(place, 1.0, EVERYTHING));
        occupied.add_disc(place, 0.5);
        assert!(!occupied.is_free_at(place, 1.0, EVERYTHING));
        assert!(occupied.is_free_at(place, 1.0, BUILDING));
        assert!(!occupied.is_free_at(MapPoint::new(1.5, 0.0), 1.0, BUILDING));
    }
}
