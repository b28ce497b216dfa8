//! Where the yardsticks are tested: the suite *small*, and a person who stands where a test wants.

use std::sync::{Arc, LazyLock};

use openbench_core::{MapPoint, Pose2, Sensed, SimTime};
use openbench_scene::{Movers, Placed};

use crate::Prepared;
use crate::run::TruthHandle;
use crate::run::truth::{Instant, Truth};
use crate::worlds::builtin_suite;

/// The suite, in which one person may walk.
pub(super) static PEOPLED: LazyLock<Prepared> = LazyLock::new(|| {
    let mut suite = builtin_suite("small").unwrap();
    suite.traffic.pedestrians = 1;
    Prepared::new(suite, None).unwrap()
});

/// An observation at time 0.
pub(super) static NOTHING_SENSED: Sensed = Sensed {
    time: SimTime::ZERO,
    imu: Vec::new(),
    wheels: Vec::new(),
    scan: None,
    gnss: None,
    image: None,
};

/// The truth about its first episode, with the robot and the person at these places at time 0.
pub(super) fn truth_with(robot: Pose2, person: Option<MapPoint>) -> Truth<'static> {
    let handle = TruthHandle::default();
    let ground = PEOPLED.free_space.ground();
    let mut movers = Movers::default();
    let placed = person.map(|at| Placed {
        figure: 0,
        pose: Pose2::new(at.x, at.y, 0.0).to_pose3(ground),
        velocity: [0.0; 3],
    });
    movers.place(PEOPLED.stage.caster().figures(), placed.into_iter());
    handle.set(Instant {
        time: SimTime::ZERO,
        base_link: robot.to_pose3(ground),
        movers: Arc::new(movers),
    });
    Truth {
        handle,
        prepared: &PEOPLED,
        episode: 0,
    }
}
