//! How well a pose explains the ground that was seen to be free: how far it reaches towards walls,
//! and through them.

use nalgebra::Vector2;

use super::chart::{Chart, Wall};
use super::refine::Refined;
use super::submap::Submap;

/// Rays are followed so far, metres.
const RANGE_M: f64 = 25.0;
/// The way of a submap is no longer than this, metres.
const WAY_M: f64 = 45.0;
/// One direction in so many is followed.
const STRIDE: usize = 4;
/// Free ground this far behind a wall contradicts it, metres: displaced buildings and open doors
/// are no contradiction.
const BEHIND_M: f64 = 2.0;
/// Free ground that ends this near to a wall ends at it, metres.
const AT_WALL_M: f64 = 1.0;

/// What a pose explains.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Explained {
    /// Share of the rays towards walls along which free ground ends at the wall.
    pub met: f64,
    /// Share of the rays towards walls along which free ground goes on behind the wall.
    pub through: f64,
    /// Share of all rays that lead towards a wall near by.
    pub towards: f64,
}

/// A wall as a ray meets it.
struct Barrier {
    start: Vector2<f64>,
    along: Vector2<f64>,
}

/// Compares a submap with the map at a refined pose.
pub fn explain(chart: &Chart, submap: &Submap, refined: &Refined) -> Explained {
    let barriers = barriers(chart, refined);
    let mut rays = 0;
    let mut towards = 0;
    let mut met = 0;
    let mut through = 0;
    for panorama in &submap.panoramas {
        let from = refined.pose.transform(panorama.from.x, panorama.from.y);
        let from = Vector2::new(from.x, from.y);
        for (bearing, free) in panorama.rays().step_by(STRIDE) {
            let (sine, cosine) = libm::sincos(refined.pose.yaw + bearing);
            let ray = Vector2::new(cosine, sine);
            rays += 1;
            if let Some(range) = first_wall(&barriers, from, ray) {
                towards += 1;
                let behind = free - range;
                met += usize::from(behind.abs() < AT_WALL_M);
                through += usize::from(behind > BEHIND_M);
            }
        }
    }
    let share = |count: usize, all: usize| count as f64 / (all.max(1)) as f64;
    Explained {
        met: share(met, towards),
        through: share(through, towards),
        towards: share(towards, rays),
    }
}

/// The walls around the pose, where the buildings are estimated to be.
fn barriers(chart: &Chart, refined: &Refined) -> Vec<Barrier> {
    let offsets = refined.offsets(chart.outlines.len());
    let here = refined.pose.point();
    let near = |wall: &&Wall| wall.segment.distance_to_point(here) < RANGE_M + WAY_M;
    let barrier = |wall: &Wall| {
        let (a, b) = (wall.segment.start, wall.segment.end);
        Barrier {
            start: Vector2::new(a.x, a.y) + offsets[wall.building],
            along: Vector2::new(b.x - a.x, b.y - a.y),
        }
    };
    chart.walls.iter().filter(near).map(barrier).collect()
}

/// Distance along a ray to the first wall that faces it.
fn first_wall(barriers: &[Barrier], from: Vector2<f64>, ray: Vector2<f64>) -> Option<f64> {
    let mut first = RANGE_M;
    let mut is_met = false;
    for barrier in barriers {
        // The building is to the left of its wall, so a ray from outside crosses it to the left.
        let across = ray.perp(&barrier.along);
        if across > -1e-9 {
            continue;
        }
        let to = barrier.start - from;
        let range = to.perp(&barrier.along) / across;
        let share = to.perp(&ray) / across;
        if (0.0..=1.0).contains(&share) && range > 0.0 && range < first {
            first = range;
            is_met = true;
        }
    }
    is_met.then_some(first)
}

#[cfg(test)]
mod tests {
    use openbench_core::Pose2;

    use super::super::refine::{Assumptions, refine};
    use super::super::town::{chart, stretch_at, town};
    use super::*;

    /// What a pose explains of what is seen from the middle of the town.
    fn explained(at: Pose2) -> Explained {
        let submap = Submap::of(&[stretch_at(&town(), Pose2::default())]);
        let chart = chart(&town());
        let refined = refine(&chart, &submap, at, &Assumptions::default()).unwrap();
        explain(&chart, &submap, &refined)
    }

    #[test]
    fn the_right_pose_explains_all() {
        let right = explained(Pose2::new(0.5, -0.3, 0.02));
        assert!(right.met > 0.9 && right.through == 0.0, "{right:?}");
        assert!((0.2..0.9).contains(&right.towards), "{right:?}");
    }

    #[test]
    fn from_a_wrong_pose_free_ground_ends_before_walls_or_goes_on_behind_them() {
        let wrong = explained(Pose2::new(6.0, 1.0, 1.6));
        assert!(wrong.met < 0.5 && wrong.through > 0.1, "{wrong:?}");
    }
}
