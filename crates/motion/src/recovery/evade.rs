//! Out of somebody's way: what to do at once when no plan keeps off those who move. Standing still is not always safe.

use openbench_core::Velocity;

use crate::feasible::clearance;
use crate::kinematics::Motion;
use crate::limits::Limits;
use crate::local::Situation;
use crate::shape::{Footprint, Obstacle};

/// Seconds that a way out is driven before the robot brakes.
const HOLD: f64 = 1.5;
/// Seconds ahead that are looked at.
const HORIZON: f64 = 2.5;
/// Seconds between two looks.
const STEP: f64 = 0.05;
/// Distance that counts as free, metres.
const FREE: f64 = 0.05;
/// Distances above this do not matter, metres.
const REACH: f64 = 0.5;

/// The velocity that keeps longest, and then furthest, off those who move, without touching what stands; `None` if standing still does as well as any.
pub fn evade(footprint: &Footprint, limits: &Limits, situation: &Situation<'_>) -> Option<Velocity> {
    if !situation.obstacles.iter().any(Obstacle::is_moving) {
        return None;
    }
    let speeds = [limits.forward, 0.5 * limits.forward, 0.0, -limits.backward];
    let turns = [0.0, -0.5, 0.5, -1.0, 1.0].map(|share| share * limits.turn);
    let stand = worth(footprint, limits, situation, Velocity::ZERO)?;
    let mut best = (stand, None);
    for command in speeds.iter().flat_map(|v| turns.map(|w| Velocity::new(*v, w))) {
        let Some(worth) = worth(footprint, limits, situation, command) else { continue };
        if worth > best.0 + 0.01 {
            best = (worth, Some(command));
        }
    }
    best.1
}

/// Seconds until somebody is touched, and then the least distance to anybody; `None` if what stands would be touched, or somebody while the robot moves because it was told to.
fn worth(
    footprint: &Footprint,
    limits: &Limits,
    situation: &Situation<'_>,
    command: Velocity,
) -> Option<f64> {
    let mut motion = Motion { pose: situation.pose, velocity: situation.velocity, command };
    let standing = || situation.obstacles.iter().filter(|o| !o.is_moving());
    let moving = || situation.obstacles.iter().filter(|o| o.is_moving());
    let start = clearance(footprint, standing(), motion.pose, 0.0, REACH);
    let (somebody, drives) =
        (clearance(footprint, moving(), motion.pose, 0.0, REACH), command != Velocity::ZERO);
    let mut least = REACH;
    for i in 1..=(HORIZON / STEP) as usize {
        let time = i as f64 * STEP;
        if time > HOLD {
            motion.command = Velocity::ZERO;
        }
        motion.step(limits, STEP);
        let stands = motion.velocity == situation.velocity && motion.velocity == Velocity::ZERO;
        if !stands && clearance(footprint, standing(), motion.pose, 0.0, REACH) < (0.5 * start).min(FREE) {
            return None;
        }
        let near = clearance(footprint, moving(), motion.pose, time, REACH);
        if drives && !motion.stands() && near < somebody.min(0.0) {
            return None;
        }
        least = least.min(near);
        if least <= 0.0 {
            return Some(time);
        }
    }
    Some(HORIZON + least)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::Vector2;
    use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime};

    fn out_of(obstacles: &[Obstacle]) -> Option<Velocity> {
        let robot = RobotDescription::sentry();
        let situation = Situation {
            time: SimTime::ZERO,
            pose: Pose2::default(),
            velocity: Velocity::ZERO,
            path: &[MapPoint::new(3.0, 0.0)],
            final_yaw: None,
            obstacles,
        };
        evade(&Footprint::of(&robot).unwrap(), &Limits::of(&robot).unwrap(), &situation)
    }

    fn somebody(from: MapPoint, velocity: Vector2) -> Obstacle {
        Obstacle::new(&[from], 0.3, velocity).unwrap()
    }

    #[test]
    fn the_robot_leaves_the_way_of_one_who_comes_from_the_side() {
        let away = out_of(&[somebody(MapPoint::new(0.1, 1.4), Vector2::new(0.0, -0.8))]).unwrap();
        assert!(away.linear != 0.0, "{away:?}");
    }

    #[test]
    fn nothing_is_done_where_nothing_helps_or_nobody_comes() {
        assert_eq!(out_of(&[]), None);
        assert_eq!(out_of(&[somebody(MapPoint::new(3.0, 3.0), Vector2::new(1.0, 0.0))]), None);
    }

    #[test]
    fn what_stands_is_not_driven_into() {
        let wall = Obstacle::wall(MapPoint::new(0.2, -3.0), MapPoint::new(0.2, 3.0)).unwrap();
        let away = out_of(&[wall, somebody(MapPoint::new(0.1, 1.4), Vector2::new(0.0, -0.8))]);
        assert!(away.is_none_or(|v| v.linear <= 0.0), "{away:?}");
    }
}
