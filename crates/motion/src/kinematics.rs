//! How a robot with two driven sides moves: along arcs, its rims as fast as their acceleration allows.

use openbench_core::{Pose2, Velocity};

use crate::limits::Limits;

/// A robot in motion and what it is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Where it is.
    pub pose: Pose2,
    /// How it moves.
    pub velocity: Velocity,
    /// How it is told to move.
    pub command: Velocity,
}

impl Motion {
    /// The next `seconds`: rims change their speeds as fast as they can until they are as told.
    pub fn step(&mut self, limits: &Limits, seconds: f64) {
        let half = limits.half_track;
        let rim = |v: Velocity, side: f64| v.linear + side * half * v.angular;
        let most = limits.acceleration * seconds;
        let next = |side: f64| {
            let (now, told) = (rim(self.velocity, side), rim(self.command, side));
            now + (told - now).clamp(-most, most)
        };
        let (left, right) = (next(-1.0), next(1.0));
        self.velocity = Velocity::new((left + right) / 2.0, (right - left) / (2.0 * half));
        self.pose = arc(self.pose, self.velocity, seconds);
    }

    pub(crate) fn stands(&self) -> bool {
        self.velocity.linear.abs() < 1e-9 && self.velocity.angular.abs() < 1e-9
    }
}

/// Where a robot gets that drives with a velocity for some seconds.
pub fn arc(pose: Pose2, velocity: Velocity, seconds: f64) -> Pose2 {
    let turn = velocity.angular * seconds;
    let half = turn / 2.0;
    let chord = velocity.linear * seconds * if half.abs() < 1e-6 { 1.0 } else { libm::sin(half) / half };
    let (sin, cos) = libm::sincos(pose.yaw + half);
    Pose2::new(pose.x + chord * cos, pose.y + chord * sin, pose.yaw + turn)
}

/// The velocity that leads along an arc from one pose to another.
pub fn velocity(from: Pose2, to: Pose2, seconds: f64) -> Velocity {
    let turn = to.yaw - from.yaw;
    let (sin, cos) = libm::sincos((from.yaw + to.yaw) / 2.0);
    let chord = (to.x - from.x) * cos + (to.y - from.y) * sin;
    Velocity::new(chord * bulge(turn) / seconds, turn / seconds)
}

/// Length of an arc that turns by `turn`, as a multiple of its chord.
fn bulge(turn: f64) -> f64 {
    let half = turn / 2.0;
    if half.abs() < 1e-4 { 1.0 } else { half / libm::sin(half) }
}

/// The pose at a share of the way from `a` to `b`: straight on or around, the yaw in proportion.
pub fn on_arc(a: Pose2, b: Pose2, share: f64) -> Pose2 {
    let turn = b.yaw - a.yaw;
    let yaw = a.yaw + share * turn;
    if turn.abs() < 1e-4 {
        return Pose2::new(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), yaw);
    }
    // Chords of one circle: their lengths are as the sines of half their turns, and each is turned by half its turn.
    let ratio = libm::sin(share * turn / 2.0) / libm::sin(turn / 2.0);
    let (sin, cos) = libm::sincos((share - 1.0) * turn / 2.0);
    let (dx, dy) = (ratio * (b.x - a.x), ratio * (b.y - a.y));
    Pose2::new(a.x + cos * dx - sin * dy, a.y + sin * dx + cos * dy, yaw)
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::MapPoint;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn points_of_an_arc_are_on_one_circle(x in -2.0..2.0_f64, turn in -3.0..3.0_f64, share in 0.0..1.0_f64) {
            // From the origin along the x axis with a constant ratio of speed and turn.
            let radius = x / turn;
            let (sin, cos) = libm::sincos(turn);
            let end = Pose2::new(radius * sin, radius * (1.0 - cos), turn);
            let found = on_arc(Pose2::default(), end, share);
            let (sin, cos) = libm::sincos(share * turn);
            prop_assert!(found.point().distance(MapPoint::new(radius * sin, radius * (1.0 - cos))) < 1e-3 * x.abs() + 1e-9);
        }
    }
}
