//! Addresses of deliveries, by the names of buildings and units.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The address of a door: a building and, where the building has several doors, a unit. Both are
/// the map's own names where the map has them, else `building<N>` and `unit<N>`.
///
/// ```
/// use openbench_core::Address;
///
/// let address = Address::new("building3", "unit1");
/// assert_eq!(address.to_string(), "unit1, building3");
/// assert!(address.same_door(&Address::new("Building 3", "Unit 1")));
/// ```
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Address {
    /// Name of the building. Where several have the name, the area follows:
    /// `building3, Rose Estate`.
    pub building: String,
    /// Name of the unit, if the address has one.
    pub unit: Option<String>,
}

impl Address {
    /// An address with a building and a unit.
    pub fn new(building: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            building: building.into(),
            unit: Some(unit.into()),
        }
    }

    /// Whether both are the same door, without regard to case and white space: `Building 3` is
    /// `building3`.
    pub fn same_door(&self, other: &Self) -> bool {
        self.same_building(other)
            && self.unit.as_deref().map(fold_name) == other.unit.as_deref().map(fold_name)
    }

    /// Whether both are in the same building, compared as by [`same_door`](Self::same_door).
    pub fn same_building(&self, other: &Self) -> bool {
        fold_name(&self.building) == fold_name(&other.building)
    }
}

/// `name` without white space and in lower case, for comparison.
pub fn fold_name(name: &str) -> String {
    name.chars()
        .filter(|c| !c.is_whitespace())
        .flat_map(char::to_lowercase)
        .collect()
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.unit {
            Some(unit) => write!(f, "{unit}, {}", self.building),
            None => write!(f, "{}", self.building),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doors_are_compared_without_case_and_space() {
        assert!(
            Address::new("Building 3", "Unit1").same_door(&Address::new("building3", "unit 1"))
        );
        assert!(
            !Address::new("building3", "unit1").same_door(&Address::new("building3", "unit11"))
        );
        assert!(!Address::new("b", "1").same_door(&Address {
            building: "b".into(),
            unit: None
        }));
    }
}
