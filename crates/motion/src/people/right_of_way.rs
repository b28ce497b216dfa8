//! Right of way: nobody can stop at once, so ground that somebody is about to walk over is not to
//! be entered.
//!
//! The path of a moving obstacle is where it will be within some seconds at its present velocity. A
//! robot that is already in it may leave it in any direction but towards the obstacle.

use crate::kinematics::Motion;
use crate::limits::Limits;
use crate::shape::{Footprint, Obstacle, Placed};

use openbench_core::Velocity;

/// Distance to keep from the path of a moving obstacle, metres.
const MARGIN_M: f64 = 0.2;
/// Speed towards a moving obstacle that does not matter, m/s.
const AGAINST_MPS: f64 = 0.03;
/// Seconds between two checks along a motion.
const STEP_S: f64 = 0.05;
/// Checks along the path of a moving obstacle.
const CHECKS: usize = 6;
/// Seconds after which no robot is still braking.
const LONGEST_S: f64 = 5.0;
/// Coming nearer by less than this does not count, metres.
const ROUNDING_M: f64 = 1e-3;

/// How far ahead of a moving obstacle ground is reserved for it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RightOfWay<'a> {
    /// The robot's outline.
    pub footprint: &'a Footprint,
    /// Seconds that a walking person needs to stop.
    pub seconds: f64,
}

impl RightOfWay<'_> {
    /// Whether a robot that is driven as commanded for `hold` seconds and then brakes cuts somebody
    /// off.
    ///
    /// It does if it gets into their path, or nearer to it than 20 cm, where it would not by
    /// standing still; or if it drives towards somebody in whose path it is.
    pub(crate) fn is_cut_off(
        &self,
        somebody: &Obstacle,
        motion: Motion,
        limits: &Limits,
        hold: f64,
    ) -> bool {
        let here = self.footprint.at(motion.pose);
        // With a margin, since velocities of people are known to a few tenths of a m/s only.
        let off = self.distance_from_path(somebody, &here, 0.0);
        let (velocity, mut time) = (somebody.velocity(), 0.0);
        let mut motion = motion;
        while time < hold || !motion.stands() && time < LONGEST_S {
            if time >= hold {
                motion.command = Velocity::ZERO;
            }
            motion.step(limits, STEP_S);
            time += STEP_S;
            let there = self.footprint.at(motion.pose);
            // The mean speed against somebody's direction of motion, with both divisors multiplied
            // out.
            let against = -here.to(&there).dot(velocity)
                > AGAINST_MPS * time * libm::hypot(velocity.x, velocity.y);
            let then = self.distance_from_path(somebody, &there, time);
            // Somebody's path moves along with them, so the robot is compared with one that stands,
            // at the same time.
            let deeper = then < MARGIN_M
                && then < self.distance_from_path(somebody, &here, time) - ROUNDING_M;
            // A robot in somebody's path has to leave it, to whichever side.
            if off < MARGIN_M && against || off > 0.0 && deeper {
                return true;
            }
        }
        false
    }

    /// Distance of a footprint, `time` seconds ahead, from the path that somebody has before them
    /// then, at most [`MARGIN_M`], metres.
    fn distance_from_path(&self, somebody: &Obstacle, at: &Placed, time: f64) -> f64 {
        let circle = self.footprint.circumscribed();
        let times = (0..=CHECKS).map(|i| time + self.seconds * i as f64 / CHECKS as f64);
        let contacts = times.filter_map(|time| somebody.contact(at, circle, time, MARGIN_M));
        contacts
            .map(|contact| contact.distance)
            .fold(MARGIN_M, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::{MapPoint, Pose2, RobotDescription};

    use super::*;
    use crate::vector::Vector2;

    /// Whether a robot at the origin that drives with `speed` cuts off a walker at `from` who walks
    /// at 1.2 m/s in a direction.
    fn cuts_off(speed: f64, from: MapPoint, direction: f64) -> bool {
        let robot = RobotDescription::sentry();
        let (footprint, limits) = (Footprint::of(&robot).unwrap(), Limits::of(&robot).unwrap());
        let (sin, cos) = libm::sincos(direction);
        let walker = Obstacle::new(&[from], 0.25, Vector2::new(1.2 * cos, 1.2 * sin)).unwrap();
        let velocity = Velocity::new(speed, 0.0);
        let motion = Motion {
            pose: Pose2::default(),
            velocity,
            command: velocity,
        };
        RightOfWay {
            footprint: &footprint,
            seconds: 0.6,
        }
        .is_cut_off(&walker, motion, &limits, 0.1)
    }

    const NORTH: f64 = std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_robot_that_drives_before_somebody_cuts_them_off() {
        for before in [0.45, 0.5, 0.58, 0.61, 0.64] {
            assert!(
                cuts_off(0.5, MapPoint::new(before, -0.6), NORTH),
                "{before}"
            );
            assert!(
                !cuts_off(0.0, MapPoint::new(before, -0.6), NORTH)
                    && !cuts_off(-0.2, MapPoint::new(before, -0.6), NORTH)
            );
        }
        // The walker is past, or there is room to stop.
        assert!(
            !cuts_off(0.5, MapPoint::new(0.7, 0.6), NORTH)
                && !cuts_off(0.5, MapPoint::new(0.7, -2.1), NORTH)
        );
        assert!(!cuts_off(0.5, MapPoint::new(0.9, -0.6), NORTH));
    }

    #[test]
    fn a_robot_in_somebodys_path_may_leave_it_but_not_towards_them() {
        let ahead = MapPoint::new(1.0, 0.0);
        for speed in [0.05, 0.3] {
            assert!(cuts_off(speed, ahead, std::f64::consts::PI), "{speed}");
        }
        assert!(!cuts_off(-0.2, ahead, std::f64::consts::PI));
        assert!(!cuts_off(0.0, ahead, std::f64::consts::PI));
        // Across the path, and ahead of somebody who comes from behind.
        assert!(
            !cuts_off(0.5, MapPoint::new(0.1, -0.9), NORTH)
                && !cuts_off(0.5, MapPoint::new(-0.9, 0.0), 0.0)
        );
    }
}
