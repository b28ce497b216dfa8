//! How far an estimated pose can be trusted.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A localizer's report on its own pose. An agent that drives by the pose checks it at every
/// observation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Health {
    /// The error of the pose agrees with its covariance.
    #[default]
    Good,
    /// The pose is worse than usual, or cannot be checked. Drive slowly or stop.
    Degraded(Doubt),
    /// The pose is unknown.
    Lost,
}

/// Why a pose is degraded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Doubt {
    /// Scans show too little, or nothing known: the pose follows wheels and IMU.
    FewFeatures,
    /// Sensors contradict each other: one is mounted differently than described, or shows what
    /// does not exist.
    Contradiction,
    /// Sensors are noisier than in their data sheets.
    Noise,
}

impl fmt::Display for Health {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Good => f.write_str("good"),
            Self::Degraded(doubt) => write!(f, "degraded: {doubt}"),
            Self::Lost => f.write_str("lost"),
        }
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::FewFeatures => "scans show too little",
            Self::Contradiction => "sensors contradict each other",
            Self::Noise => "sensors are noisier than usual",
        })
    }
}
