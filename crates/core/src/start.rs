//! What an agent knows about where it starts.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::frames::{MapPoint, Pose2};

/// What an agent knows about the pose of the robot at the start, in the `map` frame of its
/// briefing.
///
/// ```
/// use openbench_core::{MapPoint, Pose2, Start};
///
/// let exact = Start::exact(Pose2::new(3.0, 4.0, 0.0));
/// assert_eq!(exact.pose(), Some(Pose2::new(3.0, 4.0, 0.0)));
/// let block = Start::Area { centre: MapPoint::new(3.0, 4.0), radius_m: 75.0 };
/// assert_eq!(block.pose(), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// A pose with an error of known size.
    Pose {
        /// The pose.
        pose: Pose2,
        /// Covariance of x, y and yaw: m², m rad, rad². Zero for an exact pose.
        covariance: [[f64; 3]; 3],
    },
    /// A place in a disc, with any heading.
    Area {
        /// Its middle.
        centre: MapPoint,
        /// Its radius, metres.
        radius_m: f64,
    },
    /// A place anywhere in the map, with any heading.
    Anywhere,
}

impl Start {
    /// A pose without an error.
    pub const fn exact(pose: Pose2) -> Self {
        Self::Pose {
            pose,
            covariance: [[0.0; 3]; 3],
        }
    }

    /// The pose, if one is given.
    pub const fn pose(&self) -> Option<Pose2> {
        match self {
            Self::Pose { pose, .. } => Some(*pose),
            Self::Area { .. } | Self::Anywhere => None,
        }
    }

    /// The point about which the start is: the pose's, or the middle of the area.
    pub const fn about(&self) -> Option<MapPoint> {
        match self {
            Self::Pose { pose, .. } => Some(pose.point()),
            Self::Area { centre, .. } => Some(*centre),
            Self::Anywhere => None,
        }
    }

    /// The same in a frame in which all positions are moved by `shift`.
    #[must_use]
    pub fn shifted(self, shift: MapPoint) -> Self {
        match self {
            Self::Pose { pose, covariance } => Self::Pose {
                pose: Pose2::new(pose.x + shift.x, pose.y + shift.y, pose.yaw),
                covariance,
            },
            Self::Area { centre, radius_m } => Self::Area {
                centre: MapPoint::new(centre.x + shift.x, centre.y + shift.y),
                radius_m,
            },
            Self::Anywhere => Self::Anywhere,
        }
    }
}

impl fmt::Display for Start {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pose { pose, .. } => write!(f, "the start is at {}", pose.point()),
            Self::Area { centre, radius_m } => {
                write!(
                    f,
                    "the start is only known to be within {radius_m} m of {centre}"
                )
            }
            Self::Anywhere => f.write_str("the start is anywhere in the map"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_move_and_headings_stay() {
        let shift = MapPoint::new(10.0, -5.0);
        let moved = Start::exact(Pose2::new(1.0, 2.0, 0.5)).shifted(shift);
        assert_eq!(moved.pose(), Some(Pose2::new(11.0, -3.0, 0.5)));
        let area = Start::Area {
            centre: MapPoint::new(1.0, 2.0),
            radius_m: 75.0,
        };
        assert_eq!(area.shifted(shift).about(), Some(MapPoint::new(11.0, -3.0)));
        assert_eq!(Start::Anywhere.shifted(shift).about(), None);
    }
}
