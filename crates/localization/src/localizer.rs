//! What every localizer offers.

use nalgebra::Matrix3;
use openbench_core::{Health, MapComparison, Observation, Pose2, SimTime};

use crate::registration::BuildingOffset;

/// Estimates the robot's pose from each observation in turn.
///
/// Agents know only this trait, so that localizers can be exchanged.
pub trait Localizer {
    /// Short name, as in results.
    fn name(&self) -> &str;

    /// Begins anew at `start` in `map`.
    fn reset(&mut self, start: Pose2);

    /// Whether poses are those on the map. While the start is not known well enough, poses are in a
    /// frame of their own, which becomes `map` with a jump once the robot is found.
    fn is_located(&self) -> bool {
        true
    }

    /// Whether poses are probably those on the map, while the robot is not located: it may go on
    /// with them. A pose that turns out to be more probable replaces them with a jump.
    fn is_presumed(&self) -> bool {
        false
    }

    /// How far buildings are from where the map shows them, as far as it is known.
    fn building_offsets(&self) -> &[BuildingOffset] {
        &[]
    }

    /// Takes in sensor data.
    fn update(&mut self, observation: &Observation<'_>);

    /// Pose of `base_link` in `map` at an instant within the last second; otherwise the pose
    /// nearest in time.
    fn pose_at(&self, time: SimTime) -> Pose2;

    /// The newest pose of `base_link` in `map`.
    fn pose(&self) -> Pose2;

    /// Whether the pose can be trusted already. A robot should stand still until then.
    fn ready(&self) -> bool;

    /// How far the pose can be trusted. A localizer that detects faults must not report
    /// [`Health::Good`] for more than two seconds after a sensor began to fail. The default is for
    /// localizers that detect none; `openbench bench health` shows what that costs.
    fn health(&self) -> Health {
        Health::Good
    }

    /// Pose of `odom` in `map` (REP 105). Only corrections change it: a path planned in `odom`
    /// stays where the robot sees it. Identity if the localizer makes no corrections.
    fn odom(&self) -> Pose2 {
        Pose2::default()
    }

    /// Whether it registers LiDAR scans, which is most of the work of those that do.
    fn registers_scans(&self) -> bool {
        true
    }

    /// How often it compared what was seen with a map since it began.
    fn map_registrations(&self) -> u64 {
        0
    }

    /// What was found at the last of these comparisons.
    fn comparison(&self) -> Option<MapComparison> {
        None
    }

    /// Covariance of the newest pose as of the last scan: x and y in `map`, then yaw; m² and rad².
    /// `None` if the localizer estimates none.
    fn covariance(&self) -> Option<Matrix3<f64>> {
        None
    }

    /// Distance from the newest pose to the best estimate, metres. Corrections are applied slowly,
    /// and this is the part still to be applied.
    fn pending(&self) -> f64 {
        0.0
    }
}
