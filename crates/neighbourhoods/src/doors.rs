//! Doors: anywhere in the walls that a robot reaches, so that no rule finds them.

use std::f64::consts::FRAC_PI_2;

use openbench_core::MapPoint;
use openbench_geometry::{Segment, sides};
use openbench_osm::draws::chance;
use openbench_osm::houses::{DoorWish, DrawnDoor, FaceWeights, draw_doors};
use rand_pcg::Pcg64Mcg;

use crate::plan::{Home, HomeKind};
use crate::purpose::{Purpose, Seed};
use crate::reach::Reach;

/// Where in front of a door a robot must be able to stand, metres.
const BEFORE_M: [f64; 2] = [1.1, 1.6];
/// Free space to each side of the line in front of a door, metres.
const HALF_WIDTH_M: f64 = 0.5;

/// The walls of all homes, in their order.
pub(crate) fn walls_of(homes: &[Home]) -> Vec<Segment> {
    let rings = homes.iter().flat_map(|home| {
        let court = home.court.iter().map(Vec::as_slice);
        std::iter::once(home.outer.as_slice()).chain(court)
    });
    rings.flat_map(sides).collect()
}

/// Draws the doors of a home.
pub(crate) fn place(seed: Seed, home: &Home, reach: &Reach, walls: &[Segment]) -> Vec<DrawnDoor> {
    let mut draws = seed.stream(Purpose::Doors, home.stream);
    let wish = DoorWish {
        count: home.wanted_doors,
        // The front faces against the y axis of the home.
        front: home.pose.yaw - FRAC_PI_2,
        weights: weights(home, &mut draws),
    };
    let is_free = |wall, at| is_free(wall, at, reach, walls);
    draw_doors(sides(&home.outer), wish, is_free, &mut draws)
}

/// How often each side has a door.
fn weights(home: &Home, draws: &mut Pcg64Mcg) -> FaceWeights {
    // The staircases of a slab are on one of its long sides.
    let is_front = chance(draws, 0.5);
    match home.kind {
        HomeKind::Slab => FaceWeights::of_slab(is_front),
        HomeKind::Terraced | HomeKind::Row => FaceWeights::IN_ROW,
        _ => FaceWeights::USUAL,
    }
}

fn is_free(wall: Segment, at: MapPoint, reach: &Reach, walls: &[Segment]) -> bool {
    let out = wall.outward();
    let front = Segment::new(
        at.offset(out, HALF_WIDTH_M + 0.05),
        at.offset(out, BEFORE_M[1]),
    );
    BEFORE_M.iter().all(|d| reach.holds(at.offset(out, *d)))
        && walls
            .iter()
            .all(|other| front.distance_to(*other) > HALF_WIDTH_M)
}
