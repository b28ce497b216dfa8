//! How far a map displaces its buildings: the standard deviation of their offsets, estimated along
//! the way together with the offsets.

use std::collections::BTreeMap;

use super::refine::Assumptions;

/// With two degrees of freedom or fewer, Student's t distribution has no covariance.
const LEAST_FREEDOM: f64 = 3.0;
/// Larger offsets are not found, metres.
const FOUND_M: f64 = 3.0;

/// The spread of the offsets of a map's buildings along each axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spread {
    deviation_m: f64,
    /// Expected before any building was seen, metres,
    expected_m: f64,
    /// which counts as so many buildings.
    expected_buildings: f64,
    /// Squared offsets of buildings that are out of sight, by their index in the map: the mean over
    /// both axes, m².
    passed: BTreeMap<usize, f64>,
}

impl Spread {
    /// What is expected of a map, and a first estimate, metres.
    pub(super) fn new(assumed: &Assumptions, deviation_m: f64) -> Self {
        Self {
            deviation_m,
            expected_m: assumed.building_m,
            expected_buildings: assumed.expected_buildings,
            passed: BTreeMap::new(),
        }
    }

    /// The standard deviation of an offset along each axis, metres.
    pub(super) fn deviation_m(&self) -> f64 {
        self.deviation_m
    }

    /// Information about an offset that was not measured, along each axis, 1/m².
    pub(super) fn information(&self) -> f64 {
        1.0 / (self.deviation_m * self.deviation_m)
    }

    /// Remembers the squared offset of a building that went out of sight, m²: it still tells how
    /// wrong the map is.
    pub(super) fn pass(&mut self, building: usize, square: f64) {
        self.passed.insert(building, square);
    }

    /// A building that is in sight again counts once.
    pub(super) fn see(&mut self, building: usize) {
        self.passed.remove(&building);
    }

    /// Estimates the deviation anew from squared offsets of the buildings in sight, m², and those
    /// passed: a step of expectation maximization.
    pub(super) fn estimate(&mut self, in_sight: &[f64]) {
        let squares = in_sight.iter().chain(self.passed.values());
        let expected = self.expected_buildings * self.expected_m * self.expected_m;
        let sum = expected + squares.sum::<f64>();
        let found = sum / self.worth(in_sight.len());
        self.deviation_m = libm::sqrt(beyond(found, self.deviation_m, FOUND_M));
    }

    /// By which share the covariance of Student's t distribution exceeds the squared scale: what
    /// offsets contribute to the error of a pose, if their spread is estimated from so many
    /// buildings in sight and those passed. It has two degrees of freedom for each building, less
    /// the two that the position of the robot takes.
    pub(super) fn widening(&self, in_sight: usize) -> f64 {
        let freedom = (2.0 * self.worth(in_sight) - 2.0).max(LEAST_FREEDOM);
        freedom / (freedom - 2.0) - 1.0
    }

    /// How many buildings it is estimated from. What was expected counts too.
    fn worth(&self, in_sight: usize) -> f64 {
        self.expected_buildings + (in_sight + self.passed.len()) as f64
    }
}

/// The variance of all offsets, from that of those which are small enough to be found, up to
/// `limit`: a step of expectation maximization for a normal distribution that is cut off.
fn beyond(found: f64, deviation: f64, limit: f64) -> f64 {
    let scaled = limit / deviation;
    let share = libm::erfc(scaled / std::f64::consts::SQRT_2).min(0.5);
    let density = libm::exp(-0.5 * scaled * scaled) / libm::sqrt(std::f64::consts::TAU);
    let missing = deviation * deviation * (share + 2.0 * scaled * density);
    (1.0 - share) * found + missing
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread() -> Spread {
        Spread::new(&Assumptions::default(), 1.0)
    }

    #[test]
    fn few_buildings_say_less_about_a_map_than_many() {
        let spread = spread();
        assert_eq!(spread.widening(1), spread.widening(2));
        assert!(spread.widening(2) > 2.0 * spread.widening(4));
        assert!(spread.widening(100) < 0.02);
    }

    #[test]
    fn buildings_out_of_sight_count_and_those_seen_again_count_once() {
        let mut spread = spread();
        for building in 0..4 {
            spread.pass(building, 0.25);
        }
        assert_eq!(
            spread.widening(0),
            Spread::new(&Assumptions::default(), 1.0).widening(4)
        );
        for building in 0..4 {
            spread.see(building);
        }
        assert_eq!(
            spread.widening(4),
            Spread::new(&Assumptions::default(), 1.0).widening(4)
        );
    }

    #[test]
    fn the_deviation_is_that_of_the_offsets() {
        let mut spread = spread();
        for _ in 0..20 {
            spread.estimate(&[0.25; 200]);
        }
        let deviation = spread.deviation_m();
        assert!((deviation - 0.5).abs() < 0.005, "{deviation}");
        assert!((spread.information() - 4.0).abs() < 0.1);
        // An exact map stays exact, whatever is seen.
        let mut exact = Spread::new(&Assumptions::EXACT_MAP, 0.02);
        exact.estimate(&[0.25; 200]);
        assert!(exact.deviation_m() < 0.021, "{}", exact.deviation_m());
    }

    #[test]
    fn offsets_that_are_too_large_to_be_found_count_as_well() {
        // Of a normal distribution of 1.5 m that is cut off at 3 m, 1.32 m are left.
        let mut deviation: f64 = 1.0;
        for _ in 0..100 {
            deviation = beyond(1.319 * 1.319, deviation, 3.0).sqrt();
        }
        assert!((deviation - 1.5).abs() < 0.02, "{deviation}");
        assert!((beyond(0.25, 0.5, 3.0).sqrt() - 0.5).abs() < 1e-6);
    }
}
