//! The robot's start: anywhere on a street or pavement from which the doors are reached.

use openbench_core::Pose2;
use openbench_geometry::Segment;
use openbench_osm::draws::{between, chance, whole};

use crate::ground::Ground;
use crate::plan::{Class, Plan};
use crate::purpose::{Purpose, Seed};
use crate::reach::Reach;

/// Places that are tried.
const TRIES: u64 = 400;
/// Distance from buildings and from things that stand around, metres.
const FREE_M: f64 = 1.6;

/// Draws the start, in the frame of the plan.
pub(crate) fn draw(seed: Seed, plan: &Plan, ground: &Ground, reach: &Reach) -> Pose2 {
    let tries = (0..TRIES).map(|i| {
        let mut draws = seed.stream(Purpose::Start, i);
        let street = &plan.streets[whole(&mut draws, 0, plan.streets.len() as u32 - 1) as usize];
        let at = street.pose_at(between(&mut draws, 0.0, street.length()));
        let side = if chance(&mut draws, 0.5) { 1.0 } else { -1.0 };
        let out = match street.class {
            Class::Residential => street.edge() - 0.9,
            Class::Living | Class::Service => street.edge() - 1.0,
        };
        let back = if chance(&mut draws, 0.5) {
            std::f64::consts::PI
        } else {
            0.0
        };
        let point = at.transform(0.0, side * out);
        Pose2::new(point.x, point.y, at.yaw + back)
    });
    let fallback = plan.streets[0].pose_at(plan.streets[0].length() / 2.0);
    let is_good = |pose: &Pose2| {
        let p = pose.point();
        p.x.abs() < plan.half.x
            && p.y.abs() < plan.half.y
            && reach.holds(p)
            && ground.is_clear_of_buildings(Segment::new(p, p), FREE_M)
            && plan
                .things
                .iter()
                .all(|thing| thing.at.distance(p) > FREE_M)
    };
    let mut tries = tries;
    tries.find(is_good).unwrap_or(fallback)
}
