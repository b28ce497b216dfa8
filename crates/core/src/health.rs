//! How far a pose can be trusted.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What a localizer says of its own pose. Who drives by a pose asks for it at every observation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Health {
    /// The pose is about as far off as its covariance says.
    #[default]
    Good,
    /// The pose is worse than usual, or cannot be checked. Drive slowly or stand.
    Degraded(Doubt),
    /// Nobody knows where the robot is.
    Lost,
}

/// Why a pose is not to be trusted as usual.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Doubt {
    /// Scans show too little, or nothing that was seen before: the pose goes on by wheels and IMU.
    FewFeatures,
    /// Sensors contradict each other: one sits elsewhere than is believed, or shows what is not
    /// there.
    Contradiction,
    /// Sensors are noisier than their data sheets say.
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
