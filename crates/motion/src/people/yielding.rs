//! Whose way it is: nobody can stop at once, so ground that somebody is about to walk over is not to be entered.
//!
//! The way of somebody who moves is where the obstacle will be within some seconds, as fast and in the direction that it moves now. Who stands in it already may leave it any way but towards who comes.

use crate::kinematics::Motion;
use crate::limits::Limits;
use crate::shape::{Footprint, Obstacle, Placed};

use openbench_core::Velocity;

/// Distance to keep from somebody's way, metres.
const MARGIN: f64 = 0.2;
/// Speed against somebody that does not matter, m/s.
const AGAINST: f64 = 0.03;
/// Seconds between two looks along a motion.
const STEP: f64 = 0.05;
/// Looks along somebody's way.
const LOOKS: usize = 6;
/// Seconds after which no robot of ours still brakes.
const LONGEST: f64 = 5.0;
/// Coming nearer by less than this is none, metres.
const ROUNDING: f64 = 1e-3;

/// How far ahead of somebody ground is his.
#[derive(Debug, Clone, Copy)]
pub struct Ways<'a> {
    /// The robot's outline.
    pub footprint: &'a Footprint,
    /// Seconds that somebody who walks needs to stop.
    pub seconds: f64,
}

impl Ways<'_> {
    /// Whether a robot, told something for `hold` seconds and then to brake, gets into somebody's way, or nearer to it than 20 cm, where it would not by standing still; or drives at somebody in whose way it is.
    pub fn is_cut_off(&self, somebody: &Obstacle, motion: Motion, limits: &Limits, hold: f64) -> bool {
        let here = self.footprint.at(motion.pose);
        let off = self.off_way(somebody, &here, 0.0);
        let (velocity, mut time) = (somebody.velocity(), 0.0);
        let mut motion = motion;
        while time < hold || !motion.stands() && time < LONGEST {
            if time >= hold {
                motion.command = Velocity::ZERO;
            }
            motion.step(limits, STEP);
            time += STEP;
            let there = self.footprint.at(motion.pose);
            let against =
                -here.to(&there).dot(velocity) > AGAINST * time * libm::hypot(velocity.x, velocity.y);
            let then = self.off_way(somebody, &there, time);
            let deeper = then < MARGIN && then < self.off_way(somebody, &here, time) - ROUNDING;
            // Who is in somebody's way has to get out of it, to whichever side.
            if off < MARGIN && against || off > 0.0 && deeper {
                return true;
            }
        }
        false
    }

    /// Distance from the way that somebody has before himself then, at most [`MARGIN`].
    fn off_way(&self, somebody: &Obstacle, at: &Placed, time: f64) -> f64 {
        let after = |i: usize| time + self.seconds * i as f64 / LOOKS as f64;
        let off = |i: usize| somebody.contact(at, self.footprint.circumscribed(), after(i), MARGIN);
        (0..=LOOKS).filter_map(off).map(|contact| contact.distance).fold(MARGIN, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::{MapPoint, Pose2, RobotDescription};

    use super::*;
    use crate::vector::Vector2;

    /// Whether a robot at the origin that drives like this cuts off a walker who is somewhere and walks at 1.2 m/s in a direction.
    fn cuts_off(speed: f64, (x, y): (f64, f64), direction: f64) -> bool {
        let robot = RobotDescription::sentry();
        let (footprint, limits) = (Footprint::of(&robot).unwrap(), Limits::of(&robot).unwrap());
        let (sin, cos) = libm::sincos(direction);
        let walker = Obstacle::new(&[MapPoint::new(x, y)], 0.25, Vector2::new(1.2 * cos, 1.2 * sin)).unwrap();
        let velocity = Velocity::new(speed, 0.0);
        let motion = Motion { pose: Pose2::default(), velocity, command: velocity };
        Ways { footprint: &footprint, seconds: 0.6 }.is_cut_off(&walker, motion, &limits, 0.1)
    }

    const NORTH: f64 = std::f64::consts::FRAC_PI_2;

    #[test]
    fn who_drives_before_somebody_cuts_him_off() {
        for before in [0.45, 0.5, 0.58, 0.61, 0.64] {
            assert!(cuts_off(0.5, (before, -0.6), NORTH), "{before}");
            assert!(!cuts_off(0.0, (before, -0.6), NORTH) && !cuts_off(-0.2, (before, -0.6), NORTH));
        }
        // He is past, or there is room to stop.
        assert!(!cuts_off(0.5, (0.7, 0.6), NORTH) && !cuts_off(0.5, (0.7, -2.1), NORTH));
        assert!(!cuts_off(0.5, (0.9, -0.6), NORTH));
    }

    #[test]
    fn who_is_in_somebodys_way_may_leave_it_but_not_towards_him() {
        let ahead = (1.0, 0.0);
        for speed in [0.05, 0.3] {
            assert!(cuts_off(speed, ahead, std::f64::consts::PI), "{speed}");
        }
        assert!(!cuts_off(-0.2, ahead, std::f64::consts::PI));
        assert!(!cuts_off(0.0, ahead, std::f64::consts::PI));
        // Across, and on before who comes from behind.
        assert!(!cuts_off(0.5, (0.1, -0.9), NORTH) && !cuts_off(0.5, (-0.9, 0.0), 0.0));
    }
}
