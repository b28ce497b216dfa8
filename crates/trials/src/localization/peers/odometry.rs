//! Nothing but odometry.

use openbench_core::Pose2;
use openbench_localization::registration::Stretch;

use super::peer::{Peer, PeerError};

/// The start, carried on by odometry.
pub(super) struct Odometry {
    pose: Pose2,
    last: Option<Pose2>,
}

impl Odometry {
    /// From a start.
    pub(super) const fn new(start: Pose2) -> Self {
        Self {
            pose: start,
            last: None,
        }
    }
}

impl Peer for Odometry {
    fn take(&mut self, stretch: &Stretch) -> Result<Pose2, PeerError> {
        let last = self.last.replace(stretch.end).unwrap_or(stretch.end);
        self.pose = self.pose.compose(stretch.end.seen_from(last));
        Ok(self.pose)
    }
}
