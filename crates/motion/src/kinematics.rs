//! Kinematics of a differential drive: it moves along arcs, and its rims change their speeds within
//! a limit.

use openbench_core::{Pose2, Velocity};

use crate::limits::Limits;

/// The state of a moving robot and its command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Its pose.
    pub pose: Pose2,
    /// Its velocity.
    pub velocity: Velocity,
    /// The velocity that it is commanded to have.
    pub command: Velocity,
}

impl Motion {
    /// Moves on by `seconds`: both rims approach the commanded speeds as fast as their acceleration
    /// allows.
    pub fn step(&mut self, limits: &Limits, seconds: f64) {
        let half = limits.half_track;
        let left = self.next_rim_speed(-half, limits, seconds);
        let right = self.next_rim_speed(half, limits, seconds);
        self.velocity = Velocity::new((left + right) / 2.0, (right - left) / (2.0 * half));
        self.pose = arc(self.pose, self.velocity, seconds);
    }

    /// The speed of the rim `side` metres to the right of the middle after `seconds`, m/s.
    fn next_rim_speed(&self, side: f64, limits: &Limits, seconds: f64) -> f64 {
        let now = self.velocity.linear + side * self.velocity.angular;
        let wanted = self.command.linear + side * self.command.angular;
        let most = limits.acceleration * seconds;
        now + (wanted - now).clamp(-most, most)
    }

    /// Whether the robot stands, up to rounding.
    pub(crate) fn stands(&self) -> bool {
        self.velocity.linear.abs() < 1e-9 && self.velocity.angular.abs() < 1e-9
    }
}

/// The pose after driving with a constant velocity for some seconds.
pub fn arc(pose: Pose2, velocity: Velocity, seconds: f64) -> Pose2 {
    let turn = velocity.angular * seconds;
    let half = turn / 2.0;
    // The chord of an arc is sin(h) / h as long, h being half its turn, and points along the mean
    // heading.
    let chord = velocity.linear
        * seconds
        * if half.abs() < 1e-6 {
            1.0
        } else {
            libm::sin(half) / half
        };
    let (sin, cos) = libm::sincos(pose.yaw + half);
    Pose2::new(pose.x + chord * cos, pose.y + chord * sin, pose.yaw + turn)
}

/// The constant velocity that leads along an arc from one pose to another.
pub fn velocity(from: Pose2, to: Pose2, seconds: f64) -> Velocity {
    let turn = to.yaw - from.yaw;
    let (sin, cos) = libm::sincos((from.yaw + to.yaw) / 2.0);
    // Only the part along the mean heading: a differential drive cannot drive the rest.
    let chord = (to.x - from.x) * cos + (to.y - from.y) * sin;
    Velocity::new(chord * bulge(turn) / seconds, turn / seconds)
}

/// Length of an arc that turns by `turn` radians, as a multiple of its chord.
fn bulge(turn: f64) -> f64 {
    let half = turn / 2.0;
    if half.abs() < 1e-4 {
        1.0
    } else {
        half / libm::sin(half)
    }
}

/// The pose at a share of the arc from `a` to `b`; the yaw changes in proportion.
pub fn on_arc(a: Pose2, b: Pose2, share: f64) -> Pose2 {
    let turn = b.yaw - a.yaw;
    let yaw = a.yaw + share * turn;
    if turn.abs() < 1e-4 {
        return Pose2::new(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), yaw);
    }
    // Chords of one circle: the lengths are in the ratio of the sines of half the turns, and each
    // chord is rotated by half its turn.
    let ratio = libm::sin(share * turn / 2.0) / libm::sin(turn / 2.0);
    let (sin, cos) = libm::sincos((share - 1.0) * turn / 2.0);
    let (dx, dy) = (ratio * (b.x - a.x), ratio * (b.y - a.y));
    Pose2::new(a.x + cos * dx - sin * dy, a.y + sin * dx + cos * dy, yaw)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn points_of_an_arc_are_on_one_circle(
            x in -2.0..2.0_f64,
            turn in -3.0..3.0_f64,
            share in 0.0..1.0_f64,
        ) {
            // From the origin along the x axis with a constant ratio of speed and turn rate.
            let radius = x / turn;
            let on_circle = |turn: f64| {
                let (sin, cos) = libm::sincos(turn);
                Pose2::new(radius * sin, radius * (1.0 - cos), turn)
            };
            let found = on_arc(Pose2::default(), on_circle(turn), share);
            let off = found.point().distance(on_circle(share * turn).point());
            prop_assert!(off < 1e-3 * x.abs() + 1e-9);
        }
    }
}
