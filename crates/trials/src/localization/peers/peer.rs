//! What every way has, and what they share.

use std::path::PathBuf;

use openbench_core::{MapPoint, Pose2, Start};
use openbench_geometry::{Bounds, Segment};
use openbench_localization::registration::Stretch;
use openbench_osm::OsmMap;
use thiserror::Error;

/// A way to find out where the robot is.
pub(super) trait Peer {
    /// Takes in what the robot saw, and says its pose at the end.
    ///
    /// # Errors
    /// [`PeerError`] of a program of one's own.
    fn take(&mut self, stretch: &Stretch) -> Result<Pose2, PeerError>;
}

/// Why a program of one's own says no pose.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PeerError {
    /// It cannot be started, ended, answered too much, or did not answer for a minute.
    #[error(
        "{}: no answer; it must be executable and answer each line with one of its own",
        path.display()
    )]
    Program {
        /// The program.
        path: PathBuf,
        /// What happened.
        source: std::io::Error,
    },
    /// Its answer is no pose.
    #[error(
        "{}: `{answer}` is no pose; the answer must be {{\"pose\": [x, y, yaw]}}",
        path.display()
    )]
    Answer {
        /// The program.
        path: PathBuf,
        /// The beginning of its answer.
        answer: String,
        /// What is wrong with it.
        source: serde_json::Error,
    },
}

/// The most likely start: without a pose the middle of what is known, heading east.
pub(super) fn guess(map: &OsmMap, start: &Start) -> Pose2 {
    start.pose().unwrap_or_else(|| {
        let middle = start.about().or_else(|| Some(bounds(map)?.middle()));
        let middle = middle.unwrap_or_default();
        Pose2::new(middle.x, middle.y, 0.0)
    })
}

/// The box around all buildings; `None` if there are none.
pub(super) fn bounds(map: &OsmMap) -> Option<Bounds> {
    let boxes = map.buildings.iter().map(|one| one.polygon.bounds());
    boxes.reduce(Bounds::union)
}

/// The walls of all buildings.
pub(super) fn walls(map: &OsmMap) -> Vec<Segment> {
    let sides = map.buildings.iter().flat_map(|one| one.polygon.sides());
    sides.collect()
}

/// A point of the frame of odometry in the frame of the robot.
pub(super) fn seen_from(robot: Pose2, point: MapPoint) -> MapPoint {
    let (forward, left) = robot.inverse_transform(point);
    MapPoint::new(forward, left)
}
