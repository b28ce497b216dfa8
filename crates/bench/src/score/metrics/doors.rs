//! The doors that an agent wrote into its copy of the map, against those of the world.

use openbench_core::{Address, MapPoint};
use serde::{Deserialize, Serialize};

/// How far from its true place a written door may be and still count as found, metres.
pub const DOOR_TOLERANCE: f64 = 2.0;

/// Score of the written doors.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct DoorScore {
    /// Doors of the world that were written at their place.
    pub found: usize,
    /// Written doors that the world does not have, or has elsewhere.
    pub wrong: usize,
    /// Doors of the world.
    pub of: usize,
    /// Mean distance of the found doors from their true places, metres; null if none was found.
    pub mean_distance_m: Option<f64>,
}

/// Scores `written` doors against the `true_doors` of a world, both where a map has them: on the outlines of buildings. A door that was written twice at its place is found once,
/// as far off as the nearer of the two.
pub fn score_doors(
    written: &[(Address, MapPoint)],
    true_doors: &[(Address, MapPoint)],
) -> DoorScore {
    let error = |(address, at): &(Address, MapPoint), door: &(Address, MapPoint)| {
        let distance = at.distance(door.1);
        (address.same_door(&door.0) && distance <= DOOR_TOLERANCE).then_some(distance)
    };
    let nearest = |door: &(Address, MapPoint)| {
        written
            .iter()
            .filter_map(|w| error(w, door))
            .min_by(f64::total_cmp)
    };
    let errors: Vec<f64> = true_doors.iter().filter_map(nearest).collect();
    let wrong = written
        .iter()
        .filter(|w| !true_doors.iter().any(|d| error(w, d).is_some()))
        .count();
    let mean = (!errors.is_empty()).then(|| errors.iter().sum::<f64>() / errors.len() as f64);
    DoorScore {
        found: errors.len(),
        wrong,
        of: true_doors.len(),
        mean_distance_m: mean,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn door(unit: &str, x: f64) -> (Address, MapPoint) {
        (Address::new("building1", unit), MapPoint::new(x, 0.0))
    }

    #[test]
    fn doors_are_found_at_their_place_and_under_their_name() {
        let world = [door("unit1", 0.0), door("unit2", 10.0), door("unit3", 20.0)];
        let written = [
            door("Unit 1", 0.5),
            door("unit1", 1.0),
            door("unit2", 13.0),
            door("unit3", 10.0),
            door("unit9", 0.0),
        ];
        let score = score_doors(&written, &world);
        assert_eq!(
            score,
            DoorScore {
                found: 1,
                wrong: 3,
                of: 3,
                mean_distance_m: Some(0.5)
            }
        );
        assert_eq!(score_doors(&[], &world).mean_distance_m, None);
    }
}
