//! Work that an agent does between an observation and its decision.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A piece of work of a built-in agent, as it reports it. Where a suite charges for computing, each
/// kind costs simulated time.
///
/// Requests to language and vision models are no `Work`: they are in
/// [`ModelUse`](crate::ModelUse).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Work {
    /// A LiDAR scan is registered, for odometry.
    Registration,
    /// What was seen on some metres is registered to the public map, near a known pose.
    MapRegistration,
    /// The same in all of the area in which the robot may be.
    MapSearch,
    /// A LiDAR scan enters the costmaps.
    Mapping,
    /// A path to a goal is searched.
    PathSearch,
    /// A local planner decides on a velocity.
    LocalPlan,
    /// An image is read.
    Reading,
}

impl Work {
    /// All kinds.
    pub const ALL: [Self; 7] = [
        Self::Registration,
        Self::MapRegistration,
        Self::MapSearch,
        Self::Mapping,
        Self::PathSearch,
        Self::LocalPlan,
        Self::Reading,
    ];

    /// As in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Registration => "registration",
            Self::MapRegistration => "map_registration",
            Self::MapSearch => "map_search",
            Self::Mapping => "mapping",
            Self::PathSearch => "path_search",
            Self::LocalPlan => "local_plan",
            Self::Reading => "reading",
        }
    }
}

impl fmt::Display for Work {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_files() {
        for work in Work::ALL {
            let json = serde_json::to_string(&work).unwrap();
            assert_eq!(json, format!("\"{work}\""));
        }
    }
}
