//! Where a parcel is put down: in front of a door's plate, as near to it as the robot can get.

use openbench_core::MapPoint;
use openbench_core::frames::wrap_angle;
use openbench_motion::Costmap;

use crate::open::sighting::Sighting;

/// Distance from a plate at which a parcel is put down on free ground.
pub const NEAREST_M: f64 = 0.8;
/// Largest distance of a doorstep from the plate.
pub const FARTHEST_M: f64 = 3.2;
/// A doorstep that cannot be reached is replaced by one this much farther from the plate.
const FARTHER_M: f64 = 0.8;
/// Step between the distances that are tried.
const STEP_M: f64 = 0.1;
/// Directions from the plate that are tried, measured from its normal.
const ASIDES_RAD: [f64; 7] = [0.0, 0.25, -0.25, 0.5, -0.5, 0.75, -0.75];
/// Largest angle from the plate's normal at which the robot is in front of the door.
const BESIDE_RAD: f64 = 0.9;

/// A place in front of a door.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Doorstep {
    /// The place.
    pub place: MapPoint,
    /// Least distance from the plate of the next doorstep, if this one cannot be reached, metres.
    pub next: f64,
}

/// The best free place at least `from` metres from a door's plate: near to it, and rather straight
/// in front than aside, where a metre aside costs as much as a metre farther out. The place
/// straight in front, if no place is known to be free.
///
/// A planner with a goal inside a porch would end at the nearest free place, which may be beside
/// the porch and nearer to the neighbours' door.
pub fn doorstep(door: &Sighting, from: f64, near: &Costmap) -> Doorstep {
    // Ground that the costmap does not cover counts as free.
    let is_free = |at: &MapPoint| {
        near.grid()
            .cell_at(*at)
            .is_none_or(|cell| near.cost(cell).is_some())
    };
    let steps = ((FARTHEST_M - from) / STEP_M).round().max(0.0) as u32;
    let distances = (0..=steps).map(|i| from + STEP_M * f64::from(i));
    let views = distances.flat_map(|distance| ASIDES_RAD.map(|aside| View { distance, aside }));
    let free = views.filter(|view| is_free(&view.of(door)));
    // Of equal costs the first wins: the nearest distance, then straight in front.
    let best = free.reduce(|best, view| {
        if view.cost() < best.cost() {
            view
        } else {
            best
        }
    });
    let view = best.unwrap_or(View {
        distance: from,
        aside: 0.0,
    });
    Doorstep {
        // Whether the place can be reached is known only by driving there. The next attempt begins
        // beyond this one, so attempts end at `FARTHEST_M`.
        place: view.of(door),
        next: view.distance + FARTHER_M,
    }
}

/// A place in polar coordinates about a plate.
#[derive(Debug, Clone, Copy)]
struct View {
    /// Metres.
    distance: f64,
    /// Angle from the plate's normal, counter-clockwise, radians.
    aside: f64,
}

impl View {
    fn of(self, door: &Sighting) -> MapPoint {
        door.position
            .offset(door.facing + self.aside, self.distance)
    }

    /// Metres.
    fn cost(self) -> f64 {
        self.distance * (1.0 + libm::sin(self.aside).abs())
    }
}

/// Whether `here` is in front of a door, not beside it.
pub fn is_in_front(door: &Sighting, here: MapPoint) -> bool {
    wrap_angle(door.position.bearing_to(here) - door.facing).abs() <= BESIDE_RAD
}

/// Whether `here` is near enough to a door to put the parcel down if no doorstep can be reached.
pub fn is_at_door(door: &Sighting, here: MapPoint) -> bool {
    here.distance(door.position) <= FARTHEST_M + FARTHER_M
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use super::*;
    use openbench_core::{Georeference, LonLat, RobotDescription};
    use openbench_motion::{RangeRing, ScanPoint};
    use openbench_osm::{OsmData, OsmMap};

    /// A door whose plate faces east.
    fn door() -> Sighting {
        Sighting {
            unit: "unit1".into(),
            building: 0,
            position: MapPoint::new(0.0, 0.0),
            facing: 0.0,
            confidence: 1.0,
        }
    }

    /// Open ground round the door on which low things in the given places were seen.
    fn ground(seen: &[MapPoint]) -> Costmap {
        let map = OsmMap::new(
            &OsmData::default(),
            Georeference::tangent_plane(LonLat {
                lon: 8.0,
                lat: 50.0,
            }),
        );
        let (low, high) = (MapPoint::new(-10.0, -10.0), MapPoint::new(10.0, 10.0));
        let mut costmap = Costmap::new(&map, low, high, &RobotDescription::sentry()).unwrap();
        let points = seen.iter().map(|point| ScanPoint::new(*point, 0.3));
        costmap.observe(&RangeRing::new(MapPoint::new(6.0, 0.0), 0.25, points));
        costmap.inflate();
        costmap
    }

    /// Every 0.1 m of a range.
    fn tenths(range: Range<f64>) -> impl Iterator<Item = f64> {
        let count = ((range.end - range.start) / 0.1) as u32;
        (0..=count).map(move |i| range.start + 0.1 * f64::from(i))
    }

    /// Points of an obstacle: `out` metres from the door's wall, `north` metres north of the plate.
    fn heap(out: Range<f64>, north: Range<f64>) -> Vec<MapPoint> {
        tenths(out)
            .flat_map(|x| tenths(north.clone()).map(move |y| MapPoint::new(x, y)))
            .collect()
    }

    fn found(from: f64, ground: &Costmap) -> Doorstep {
        doorstep(&door(), from, ground)
    }

    #[test]
    fn on_open_ground_a_parcel_is_put_down_straight_before_the_plate() {
        let step = found(NEAREST_M, &ground(&[]));
        assert_eq!(step.place, MapPoint::new(NEAREST_M, 0.0));
        assert!((step.next - 1.6).abs() < 1e-9);
    }

    #[test]
    fn before_a_porch_it_is_put_down_in_front_of_the_porch() {
        let ground = ground(&heap(0.0..1.2, -1.5..1.5));
        let step = found(NEAREST_M, &ground);
        assert!((1.3..2.0).contains(&step.place.x), "{step:?}");
        assert!(is_in_front(&door(), step.place));
        let cell = ground.grid().cell_at(step.place).unwrap();
        assert!(ground.cost(cell).is_some());
        // The next one is farther out than that.
        assert!(found(step.next, &ground).place.x > step.place.x + 0.5);
    }

    #[test]
    fn a_bush_in_front_is_passed_by_aside() {
        let bush = heap(0.8..1.4, -0.2..-0.1);
        let step = found(NEAREST_M, &ground(&bush));
        assert!(
            step.place.y > 0.1 && is_in_front(&door(), step.place),
            "{step:?}"
        );
        assert!(step.place.distance(door().position) < 1.5, "{step:?}");
    }

    #[test]
    fn straight_in_front_is_better_than_a_little_nearer_and_aside() {
        // From 1.6 m away one could stand beside this porch, with the door aslant.
        let ground = ground(&heap(0.0..1.6, -0.9..1.5));
        let step = found(NEAREST_M, &ground);
        assert!(
            step.place.y == 0.0 && (1.7..2.0).contains(&step.place.x),
            "{step:?}"
        );
    }

    #[test]
    fn where_nothing_is_free_it_is_tried_straight_in_front() {
        let crowd = heap(0.0..4.0, -4.0..4.0);
        assert_eq!(found(1.6, &ground(&crowd)).place, MapPoint::new(1.6, 0.0));
        assert_eq!(
            found(FARTHEST_M + 0.5, &ground(&crowd)).place,
            MapPoint::new(FARTHEST_M + 0.5, 0.0)
        );
    }

    #[test]
    fn beside_a_door_is_not_in_front_of_it() {
        assert!(is_in_front(&door(), MapPoint::new(1.0, 0.5)));
        assert!(!is_in_front(&door(), MapPoint::new(0.5, 1.5)));
        assert!(!is_in_front(&door(), MapPoint::new(-1.0, 0.0)));
        assert!(is_at_door(&door(), MapPoint::new(0.5, 1.5)));
        assert!(!is_at_door(&door(), MapPoint::new(4.5, 0.0)));
    }
}
