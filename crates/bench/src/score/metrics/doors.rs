//! The doors that an agent added to its copy of the map, compared with those of the world.

use serde::{Deserialize, Serialize};

use crate::trace::PlacedDoor;

/// Maximum distance of a mapped door from its true position to count as found, metres.
pub const DOOR_TOLERANCE_M: f64 = 2.0;

/// Score of the doors in an agent's map.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct DoorScore {
    /// Doors of the world that the agent mapped within [`DOOR_TOLERANCE_M`].
    pub found: usize,
    /// Mapped doors that the world does not have, or has elsewhere.
    pub wrong: usize,
    /// Doors of the world.
    pub of: usize,
    /// Mean distance of the found doors from their true positions, metres; null if none was found.
    pub mean_distance_m: Option<f64>,
}

impl DoorScore {
    /// The score in words, for reports.
    pub fn describe(&self) -> String {
        let error = self
            .mean_distance_m
            .map(|m| format!(", mean error {m:.2} m"))
            .unwrap_or_default();
        let Self {
            found, of, wrong, ..
        } = self;
        format!("{found} of {of} found, {wrong} wrong{error}")
    }
}

/// Scores the `written` doors against the `true_doors` of a world.
///
/// A door that was written twice within the tolerance is found once, with the smaller of the two
/// errors.
pub fn score_doors(written: &[PlacedDoor], true_doors: &[PlacedDoor]) -> DoorScore {
    let errors: Vec<f64> = true_doors
        .iter()
        .filter_map(|door| least_error(written, door))
        .collect();
    let wrong = written
        .iter()
        .filter(|w| !true_doors.iter().any(|door| error(w, door).is_some()))
        .count();
    let mean = (!errors.is_empty()).then(|| errors.iter().sum::<f64>() / errors.len() as f64);
    DoorScore {
        found: errors.len(),
        wrong,
        of: true_doors.len(),
        mean_distance_m: mean,
    }
}

/// The least error of the written doors that are a door of the world; `None` if it was not found.
fn least_error(written: &[PlacedDoor], door: &PlacedDoor) -> Option<f64> {
    written
        .iter()
        .filter_map(|w| error(w, door))
        .min_by(f64::total_cmp)
}

/// Distance of a written door from a door of the world, metres; `None` if they are not the same.
fn error(written: &PlacedDoor, door: &PlacedDoor) -> Option<f64> {
    let distance = written.position.distance(door.position);
    let is_same = written.address.same_door(&door.address) && distance <= DOOR_TOLERANCE_M;
    is_same.then_some(distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::{Address, MapPoint};

    fn door(unit: &str, x: f64) -> PlacedDoor {
        PlacedDoor {
            address: Address::new("building1", unit),
            position: MapPoint::new(x, 0.0),
        }
    }

    #[test]
    fn a_door_is_found_by_position_and_address() {
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
