//! How far the odometry can be trusted: whether scans, IMU and wheels contradict each other, and
//! the restart of a filter that has diverged.

use std::time::Duration;

use openbench_core::{Pose3, SimTime};

use super::belief::Belief;
use super::drift::Drift;
use super::reckoning::Reckoned;
use super::scan_match::ScanMatch;
use super::state::at;
use super::watchdog::{Verdict, Watchdog};
use crate::deviation::PoseDeviation;

/// Weight of a new scan in the mean innovation: one over the number of scans that it is taken over.
const SCAN_WEIGHT: f64 = 1.0 / 30.0;
/// A single scan's innovation counts as no more than this.
const MAX_INNOVATION: f64 = 100.0;
/// Mean innovation above which scans and IMU contradict each other.
///
/// In a dozen seconds of turns (`tests/lio.rs`) a LiDAR that is rotated by 0.1 rad about a level
/// axis brings the mean to 22 and more, by 0.4 about the vertical one to 14. In eighteen drives
/// with right sensors it stays below 2: windows of two towns, the built-in worlds, `avenue` of
/// `benchmarks/odometry`, full turns, an IMU at its limits. Straight on nothing is noticed.
const DISPUTED_INNOVATION: f64 = 6.0;

/// How far off a pose may be that wheels and gyroscope alone reckoned,
const RECKONED: PoseDeviation = PoseDeviation {
    metres: 0.05,
    radians: 0.01,
};
/// and this share of the distance driven,
const RECKONED_PER_METRE: f64 = 0.05;
/// and this share of the angle turned.
const RECKONED_PER_RADIAN: f64 = 0.05;
/// The filter is not trusted for this time after a restart.
const SETTLING: Duration = Duration::from_secs(3);

/// What says how far the odometry can be trusted.
#[derive(Debug, Clone, Default)]
pub(super) struct Trust {
    /// Mean of [`ScanMatch::innovation`] over the last scans.
    innovation: f64,
    watchdog: Watchdog,
    /// When the filter was restarted last, since it had diverged.
    restarted: Option<SimTime>,
}

impl Trust {
    /// Takes the innovation of an accepted scan into the mean.
    pub(super) fn note_innovation(&mut self, matched: &ScanMatch) {
        let innovation = matched.innovation.min(MAX_INNOVATION);
        self.innovation += (innovation - self.innovation) * SCAN_WEIGHT;
    }

    /// Compares the filter's trajectory with wheels and gyroscope, see [`Watchdog::judge`].
    pub(super) fn judge(
        &mut self,
        belief: &Belief,
        reckoned: &Reckoned,
        is_supported: bool,
        imu: &Pose3,
    ) -> Verdict {
        self.watchdog.judge(belief, reckoned, is_supported, imu)
    }

    /// Restarts from the last state that agreed with everything, moved on by wheels and gyroscope;
    /// `None` if there is no such state. `imu` is the IMU's pose on the robot.
    pub(super) fn restart(
        &mut self,
        reckoned: &Reckoned,
        imu: &Pose3,
        drift: &mut Drift,
    ) -> Option<Belief> {
        let restart = self.watchdog.recover(imu)?;
        let deviation = PoseDeviation {
            metres: RECKONED.metres + RECKONED_PER_METRE * restart.metres,
            radians: RECKONED.radians + RECKONED_PER_RADIAN * restart.radians,
        };
        let mut belief = restart.belief;
        // The belief's velocity is from when it last agreed; the wheels know the present one.
        let robot = belief.state.rotation * imu.rotation.inverse();
        belief.state.velocity = robot * reckoned.velocity;
        belief.add_deviation(at::ROTATION, RECKONED.radians);
        // The same number, in m/s.
        belief.add_deviation(at::VELOCITY, deviation.metres);
        drift.lose(&mut belief, deviation);
        // Otherwise the jump itself would look like a contradiction.
        self.watchdog.restart(&belief, imu);
        self.innovation = 0.0;
        self.restarted = Some(belief.stamp);
        Some(belief)
    }

    /// Whether the sensors contradict each other at `time`, or the filter has not settled after a
    /// restart.
    pub(super) fn is_disputed(&self, time: SimTime, verdict: Verdict) -> bool {
        let is_settling = self.restarted.is_some_and(|at| time.since(at) < SETTLING);
        is_settling || verdict == Verdict::Contradicted || self.innovation > DISPUTED_INNOVATION
    }

    /// Forgets the trajectory: what comes is not connected with it.
    pub(super) fn forget_trajectory(&mut self) {
        self.watchdog.clear();
    }
}
