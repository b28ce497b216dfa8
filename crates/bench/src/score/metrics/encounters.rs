//! Encounters with moving people and cars. Distances are measured between hulls.

use openbench_sim::traffic::EncounterTotals;
use serde::{Deserialize, Serialize};

/// The encounters of a delivery or of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct EncounterSum {
    /// Encounters with people with a time to collision below 1.5 s.
    pub near_misses_people: usize,
    /// Encounters with cars with a time to collision below 1.5 s.
    pub near_misses_cars: usize,
    /// Smallest time to collision, seconds; null if nobody was on a collision course.
    pub least_time_to_collision_s: Option<f64>,
    /// Time with a person in intimate space, less than 0.45 m away, seconds.
    pub intimate_seconds: f64,
    /// Time with a person in personal space, less than 1.2 m away, intimate space included,
    /// seconds.
    pub personal_seconds: f64,
    /// Smallest distance to a person, metres; null without people.
    pub nearest_person_m: Option<f64>,
    /// Smallest distance to a car, metres; null without cars.
    pub nearest_car_m: Option<f64>,
}

impl From<EncounterTotals> for EncounterSum {
    fn from(totals: EncounterTotals) -> Self {
        // Minima start at infinity, which JSON cannot express.
        let finite = |value: f64| value.is_finite().then_some(value);
        Self {
            near_misses_people: totals.near_misses_people,
            near_misses_cars: totals.near_misses_cars,
            least_time_to_collision_s: finite(totals.least_time_to_collision_s),
            intimate_seconds: totals.intimate_seconds,
            personal_seconds: totals.personal_seconds,
            nearest_person_m: finite(totals.nearest_person_m),
            nearest_car_m: finite(totals.nearest_car_m),
        }
    }
}

impl EncounterSum {
    /// The sum of both.
    pub fn plus(self, other: Self) -> Self {
        let least = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (one, None) | (None, one) => one,
        };
        Self {
            near_misses_people: self.near_misses_people + other.near_misses_people,
            near_misses_cars: self.near_misses_cars + other.near_misses_cars,
            least_time_to_collision_s: least(
                self.least_time_to_collision_s,
                other.least_time_to_collision_s,
            ),
            intimate_seconds: self.intimate_seconds + other.intimate_seconds,
            personal_seconds: self.personal_seconds + other.personal_seconds,
            nearest_person_m: least(self.nearest_person_m, other.nearest_person_m),
            nearest_car_m: least(self.nearest_car_m, other.nearest_car_m),
        }
    }

    /// The encounters in words, for reports.
    pub fn describe(&self) -> String {
        let metres =
            |name: &str, value: Option<f64>| value.map(|m| format!(", nearest {name} {m:.1} m"));
        format!(
            "near misses: {} with people, {} with cars; {:.0} s in personal space, \
             {:.0} s in intimate space{}{}",
            self.near_misses_people,
            self.near_misses_cars,
            self.personal_seconds,
            self.intimate_seconds,
            metres("person", self.nearest_person_m).unwrap_or_default(),
            metres("car", self.nearest_car_m).unwrap_or_default(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_summed_and_distances_are_minimized() {
        let first = EncounterSum {
            near_misses_people: 1,
            personal_seconds: 2.0,
            ..EncounterSum::default()
        };
        let second = EncounterSum {
            near_misses_people: 2,
            nearest_person_m: Some(0.5),
            least_time_to_collision_s: Some(1.0),
            ..EncounterSum::default()
        };
        let third = EncounterSum {
            nearest_person_m: Some(0.25),
            ..EncounterSum::default()
        };
        let sum = first.plus(second).plus(third);
        assert_eq!((sum.near_misses_people, sum.personal_seconds), (3, 2.0));
        assert_eq!(
            (sum.nearest_person_m, sum.nearest_car_m),
            (Some(0.25), None)
        );
        assert_eq!(sum.least_time_to_collision_s, Some(1.0));
    }

    #[test]
    fn infinity_becomes_null_in_json() {
        let json = serde_json::to_value(EncounterSum::from(EncounterTotals::default())).unwrap();
        assert!(json["nearest_car_m"].is_null() && json["least_time_to_collision_s"].is_null());
    }
}
