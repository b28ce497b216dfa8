//! Where episodes of training begin.

use std::f64::consts::TAU;

use openbench_bench::worlds::PreparedEpisode;
use openbench_core::Pose2;
use rand::{Rng, RngExt};

use crate::error::EnvironmentError;
use crate::options::StartDistance;
use crate::world::World;

/// Places that are tried.
const TRIES: usize = 10_000;

/// A pose at some distance from the door of an episode, by the shortest way, with any heading.
///
/// # Errors
/// [`EnvironmentError::NoStart`].
pub fn draw(
    world: &World,
    episode: &PreparedEpisode,
    distance: StartDistance,
    random: &mut impl Rng,
) -> Result<Pose2, EnvironmentError> {
    let no_start = || EnvironmentError::NoStart {
        door: episode.targets[0].address.to_string(),
        least: distance.least,
        largest: distance.largest,
    };
    let prepared = world.prepared();
    let goal = prepared.point_goal(episode).ok_or_else(no_start)?;
    let door = episode.targets[0].door.ok_or_else(no_start)?;
    let field = world.way_field(door).ok_or_else(no_start)?;
    for _ in 0..TRIES {
        // A way is never shorter than the straight line.
        let radius = distance.largest * libm::sqrt(random.random::<f64>());
        let place = goal.offset(TAU * random.random::<f64>(), radius);
        let yaw = TAU * random.random::<f64>();
        let length = field
            .length(place)
            .filter(|_| prepared.free_space.is_reachable(place));
        if length.is_some_and(|length| (distance.least..=distance.largest).contains(&length)) {
            return Ok(Pose2::new(place.x, place.y, yaw));
        }
    }
    Err(no_start())
}
