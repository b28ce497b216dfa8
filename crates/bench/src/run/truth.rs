//! What only the judge knows, for yardsticks. It reaches an agent only if its factory says that it
//! uses the truth, and the results say so, too.

use std::collections::VecDeque;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use openbench_core::frames::wrap_angle;
use openbench_core::{Pose2, Pose3, SimTime, Velocity};
use openbench_scene::Movers;
use openbench_sim::Simulator;

use super::observer::Observer;
use crate::BenchError;
use crate::worlds::Prepared;

/// The truth about an episode.
#[derive(Clone)]
pub struct Truth<'a> {
    /// Where everything is, while the episode runs.
    pub handle: TruthHandle,
    /// The suite and its world.
    pub prepared: &'a Prepared,
    /// Number of the episode, from 0.
    pub episode: usize,
}

impl fmt::Debug for Truth<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Not the world, which has millions of triangles.
        f.debug_struct("Truth")
            .field("episode", &self.episode)
            .finish_non_exhaustive()
    }
}

impl Truth<'_> {
    /// The true poses on the public map.
    pub fn poses_on_map(&self) -> PosesOnMap {
        PosesOnMap {
            handle: self.handle.clone(),
            frame: self.prepared.on_map().frame(),
        }
    }
}

/// The true poses as they are on the public map, which may be displaced.
#[derive(Debug, Clone, Default)]
pub struct PosesOnMap {
    handle: TruthHandle,
    /// The world in the frame of the public map; `None` if both are the same.
    frame: Option<Pose2>,
}

impl PosesOnMap {
    /// The pose at a time, see [`TruthHandle::pose_at`].
    pub fn pose_at(&self, time: SimTime) -> Pose2 {
        let pose = self.handle.pose_at(time);
        self.frame.map_or(pose, |frame| frame.compose(pose))
    }
}

/// On a map that is right.
impl From<TruthHandle> for PosesOnMap {
    fn from(handle: TruthHandle) -> Self {
        Self {
            handle,
            frame: None,
        }
    }
}

/// Shared access to where everything was in the last second.
#[derive(Debug, Clone, Default)]
pub struct TruthHandle(Arc<Mutex<VecDeque<Instant>>>);

/// Where everything is at an instant.
#[derive(Debug, Clone, Default)]
pub struct Instant {
    /// When.
    pub time: SimTime,
    /// Pose of the robot's `base_link` in `map`.
    pub base_link: Pose3,
    /// People and cars.
    pub movers: Arc<Movers>,
}

impl Instant {
    fn pose(&self) -> Pose2 {
        Pose2::from_pose3(&self.base_link)
    }
}

/// Number of stored instants: three seconds at 20 Hz. Agents ask for the pose at the time of a scan
/// or an image, which is in the past, and where computing takes time up to two seconds more.
const MAX_INSTANTS: usize = 60;

impl TruthHandle {
    /// Stores an instant, later than those before.
    pub fn set(&self, instant: Instant) {
        // A lock that another thread poisoned by a panic is still used: instants are stored whole
        // or not at all.
        let mut instants = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        instants.push_back(instant);
        if instants.len() > MAX_INSTANTS {
            instants.pop_front();
        }
    }

    /// Stores where everything in a simulation is now.
    pub fn store(&self, simulator: &Simulator) {
        self.set(Instant {
            time: simulator.time(),
            base_link: simulator.base_link(),
            movers: simulator.placed_movers(),
        });
    }

    /// The pose at a time, linearly interpolated between the stored instants; outside their
    /// interval the nearest one.
    pub fn pose_at(&self, time: SimTime) -> Pose2 {
        let instants = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Times ascend, since each step appends a later one.
        let after = instants.partition_point(|known| known.time < time);
        let before = after.checked_sub(1).and_then(|i| instants.get(i));
        match (before, instants.get(after)) {
            (Some(before), Some(after)) => interpolated(before, after, time),
            (one, other) => one.or(other).map(Instant::pose).unwrap_or_default(),
        }
    }

    /// The stored instant of exactly that time.
    pub fn instant(&self, time: SimTime) -> Option<Instant> {
        let instants = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        instants.iter().find(|known| known.time == time).cloned()
    }
}

fn interpolated(before: &Instant, after: &Instant, time: SimTime) -> Pose2 {
    let (a, b) = (before.pose(), after.pose());
    // `pose_at` searches so that `before.time < time <= after.time`: the divisor is positive.
    let elapsed = time.since(before.time).as_secs_f64();
    let s = elapsed / after.time.since(before.time).as_secs_f64();
    // The difference is wrapped first, so the yaw turns along the shorter arc.
    let yaw = wrap_angle(a.yaw + s * wrap_angle(b.yaw - a.yaw));
    Pose2::new(a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), yaw)
}

/// Stores each step.
impl Observer for TruthHandle {
    fn begin(&mut self, simulator: &Simulator) -> Result<(), BenchError> {
        self.store(simulator);
        Ok(())
    }

    fn step(&mut self, simulator: &Simulator, _velocity: Velocity) -> Result<(), BenchError> {
        self.begin(simulator)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(milliseconds: u64, pose: Pose2) -> Instant {
        Instant {
            time: SimTime::from_millis(milliseconds),
            base_link: pose.to_pose3(0.0),
            movers: Arc::default(),
        }
    }

    #[test]
    fn poses_on_a_displaced_map_are_displaced() {
        let handle = TruthHandle::default();
        handle.set(at(0, Pose2::new(1.0, 2.0, 0.0)));
        let poses = PosesOnMap {
            handle,
            frame: Some(Pose2::new(10.0, 0.0, std::f64::consts::FRAC_PI_2)),
        };
        let pose = poses.pose_at(SimTime::ZERO);
        assert!(
            pose.point()
                .distance(openbench_core::MapPoint::new(8.0, 1.0))
                < 1e-9
        );
        assert!((pose.yaw - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
    }

    #[test]
    fn poses_between_two_steps_are_interpolated_across_the_wrap_of_the_yaw() {
        let handle = TruthHandle::default();
        assert_eq!(handle.pose_at(SimTime::ZERO), Pose2::default());
        handle.set(at(0, Pose2::new(0.0, 0.0, 3.1)));
        handle.set(at(50, Pose2::new(1.0, 2.0, -3.1)));
        let middle = handle.pose_at(SimTime::from_millis(25));
        assert!((middle.x - 0.5).abs() < 1e-9 && (middle.y - 1.0).abs() < 1e-9);
        assert!(
            (middle.yaw.abs() - std::f64::consts::PI).abs() < 1e-9,
            "{middle:?}"
        );
        assert_eq!(handle.pose_at(SimTime::from_millis(99)).x, 1.0);
    }
}
