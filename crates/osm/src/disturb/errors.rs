//! How wrong a map is.

use serde::{Deserialize, Serialize};

/// The errors of a map: standard deviations in metres and degrees, and shares from 0 to 1.
///
/// OpenStreetMap is drawn from aerial images, which are displaced as a whole. In addition each
/// outline has an error of its own. Haklay (2010) found 6 m for the roads of London, Fan et al.
/// (2014) 4 m for the buildings of Munich.
///
/// ```
/// use openbench_osm::disturb::MapErrors;
///
/// let city = MapErrors::CITY;
/// assert_eq!((city.shift_m, city.building_shift_m, city.missing), (1.5, 1.5, 0.03));
/// assert!(MapErrors { missing: 1.5, ..city }.check().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MapErrors {
    /// Shift of the whole map, standard deviation along each axis, metres.
    pub shift_m: f64,
    /// Rotation of the whole map about its middle, standard deviation, degrees.
    pub rotation_deg: f64,
    /// Shift of each building in addition, standard deviation along each axis, metres.
    pub building_shift_m: f64,
    /// Share of the buildings that the map lacks.
    pub missing: f64,
    /// Buildings that are not there, as a share of those that are.
    pub invented: f64,
    /// Share of the buildings with a wrong number.
    pub wrong_numbers: f64,
    /// Share of the buildings without name and number.
    pub unnamed: f64,
    /// Share of the buildings of which only the smallest rectangle around the outline is drawn.
    pub simplified: f64,
    /// Distance by which outlines are too large or too small, standard deviation, metres.
    pub swelling_m: f64,
    /// Shift of roads and paths in addition, standard deviation along each axis, metres.
    pub road_shift_m: f64,
    /// Share of the roads and paths that the map lacks.
    pub missing_roads: f64,
    /// Whether the buildings that get a delivery are in the map, under their right name.
    pub spares_ordered: bool,
}

impl MapErrors {
    /// A map without errors.
    pub const EXACT: Self = Self {
        shift_m: 0.0,
        rotation_deg: 0.0,
        building_shift_m: 0.0,
        missing: 0.0,
        invented: 0.0,
        wrong_numbers: 0.0,
        unnamed: 0.0,
        simplified: 0.0,
        swelling_m: 0.0,
        road_shift_m: 0.0,
        missing_roads: 0.0,
        spares_ordered: true,
    };
    /// A map that somebody measured.
    pub const GOOD: Self = Self {
        building_shift_m: 0.5,
        ..Self::EXACT
    };
    /// The map of an ordinary city: off by 3 m (root mean square).
    pub const CITY: Self = Self {
        shift_m: 1.5,
        building_shift_m: 1.5,
        missing: 0.03,
        ..Self::EXACT
    };
    /// A map drawn long ago from a displaced image: off by 6 m (root mean square).
    pub const POOR: Self = Self {
        shift_m: 4.0,
        building_shift_m: 1.5,
        missing: 0.1,
        invented: 0.05,
        wrong_numbers: 0.05,
        spares_ordered: false,
        ..Self::EXACT
    };

    /// Whether the map has no errors.
    pub fn is_exact(&self) -> bool {
        // Whom errors would spare does not matter where there are none.
        let spares_ordered = Self::EXACT.spares_ordered;
        Self {
            spares_ordered,
            ..*self
        } == Self::EXACT
    }

    /// Checks that all numbers are in their ranges.
    ///
    /// # Errors
    /// The first number that is not, by its name.
    pub fn check(&self) -> Result<(), MapErrorsError> {
        let deviations = [
            ("shift_m", self.shift_m, MOST_SHIFT_M),
            ("rotation_deg", self.rotation_deg, MOST_ROTATION_DEG),
            ("building_shift_m", self.building_shift_m, MOST_SHIFT_M),
            ("swelling_m", self.swelling_m, MOST_SHIFT_M),
            ("road_shift_m", self.road_shift_m, MOST_SHIFT_M),
        ];
        let shares = [
            ("missing", self.missing),
            ("invented", self.invented),
            ("wrong_numbers", self.wrong_numbers),
            ("unnamed", self.unnamed),
            ("simplified", self.simplified),
            ("missing_roads", self.missing_roads),
        ];
        let shares = shares.map(|(key, value)| (key, value, 1.0));
        let all = deviations.into_iter().chain(shares);
        for (key, value, most) in all {
            // False for NaN as well.
            if !(0.0..=most).contains(&value) {
                return Err(MapErrorsError { key, value, most });
            }
        }
        Ok(())
    }
}

impl Default for MapErrors {
    fn default() -> Self {
        Self::EXACT
    }
}

/// Largest standard deviation of a shift: beyond, a map shows another place.
const MOST_SHIFT_M: f64 = 100.0;
/// Largest standard deviation of a rotation.
const MOST_ROTATION_DEG: f64 = 45.0;

/// A number that is out of its range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key} = {value}: give a number from 0 to {most}")]
pub struct MapErrorsError {
    /// Its name.
    pub key: &'static str,
    /// The number.
    pub value: f64,
    /// The largest number there.
    pub most: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_their_ranges_are_named() {
        let bad = [
            MapErrors {
                shift_m: -1.0,
                ..MapErrors::EXACT
            },
            MapErrors {
                missing: 1.01,
                ..MapErrors::EXACT
            },
            MapErrors {
                rotation_deg: f64::NAN,
                ..MapErrors::EXACT
            },
        ];
        let keys = bad.map(|errors| errors.check().unwrap_err().key);
        assert_eq!(keys, ["shift_m", "missing", "rotation_deg"]);
        for level in [
            MapErrors::EXACT,
            MapErrors::GOOD,
            MapErrors::CITY,
            MapErrors::POOR,
        ] {
            assert_eq!(level.check(), Ok(()));
        }
    }

    #[test]
    fn a_map_without_errors_is_exact_whomever_they_would_spare() {
        let exact = MapErrors {
            spares_ordered: false,
            ..MapErrors::EXACT
        };
        assert!(exact.is_exact() && !MapErrors::GOOD.is_exact());
    }
}
