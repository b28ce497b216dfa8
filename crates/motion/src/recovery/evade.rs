//! Evading people at once, where no plan keeps off them: standing still is not always safe.

use openbench_core::Velocity;

use crate::feasible::clearance;
use crate::kinematics::Motion;
use crate::limits::Limits;
use crate::local::Situation;
use crate::shape::{Footprint, Obstacle, moving, standing};

/// Seconds that a command is driven before the robot brakes.
const HOLD_S: f64 = 1.5;
/// Seconds that are predicted.
const HORIZON_S: f64 = 2.5;
/// Seconds between two checks.
const STEP_S: f64 = 0.05;
/// Distance from standing obstacles that counts as free, metres.
const FREE_M: f64 = 0.05;
/// Distances above this do not matter, metres.
const REACH_M: f64 = 0.5;
/// A command has to be better than standing by this, seconds or metres.
const GAIN: f64 = 0.01;

/// The velocity that keeps longest, and then furthest, off moving obstacles, without touching
/// standing ones; `None` if standing still does as well as any.
pub(crate) fn evade(
    footprint: &Footprint,
    limits: &Limits,
    situation: &Situation<'_>,
) -> Option<Velocity> {
    if !situation.obstacles.iter().any(Obstacle::is_moving) {
        return None;
    }
    let speeds = [limits.forward, 0.5 * limits.forward, 0.0, -limits.backward];
    let turns = [0.0, -0.5, 0.5, -1.0, 1.0].map(|share| share * limits.turn);
    // Where even braking touches what stands, there is nothing to compare with.
    let stand = worth(footprint, limits, situation, Velocity::ZERO)?;
    let (mut most, mut best) = (stand, None);
    for command in speeds
        .iter()
        .flat_map(|v| turns.map(|w| Velocity::new(*v, w)))
    {
        let Some(worth) = worth(footprint, limits, situation, command) else {
            continue;
        };
        if worth > most + GAIN {
            (most, best) = (worth, Some(command));
        }
    }
    best
}

/// What a command is worth: seconds until a moving obstacle is touched; without contact, the
/// horizon in seconds plus the least distance in metres. `None` if a standing obstacle would be
/// touched, or a moving one by a robot that moves on command.
fn worth(
    footprint: &Footprint,
    limits: &Limits,
    situation: &Situation<'_>,
    command: Velocity,
) -> Option<f64> {
    let mut motion = Motion {
        pose: situation.pose,
        velocity: situation.velocity,
        command,
    };
    let obstacles = situation.obstacles;
    let start = clearance(footprint, standing(obstacles), motion.pose, 0.0, REACH_M);
    let somebody = clearance(footprint, moving(obstacles), motion.pose, 0.0, REACH_M);
    let drives = command != Velocity::ZERO;
    let mut least = REACH_M;
    for i in 1..=(HORIZON_S / STEP_S) as usize {
        let time = i as f64 * STEP_S;
        if time > HOLD_S {
            motion.command = Velocity::ZERO;
        }
        motion.step(limits, STEP_S);
        // A robot that stands comes no nearer to what stands.
        let stands = motion.velocity == situation.velocity && motion.velocity == Velocity::ZERO;
        if !stands
            && clearance(footprint, standing(obstacles), motion.pose, 0.0, REACH_M)
                < (0.5 * start).min(FREE_M)
        {
            return None;
        }
        let near = clearance(footprint, moving(obstacles), motion.pose, time, REACH_M);
        // A robot that touches somebody already may move away, but not further in.
        if drives && !motion.stands() && near < somebody.min(0.0) {
            return None;
        }
        least = least.min(near);
        if least <= 0.0 {
            return Some(time);
        }
    }
    Some(HORIZON_S + least)
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
        evade(
            &Footprint::of(&robot).unwrap(),
            &Limits::of(&robot).unwrap(),
            &situation,
        )
    }

    fn somebody(from: MapPoint, velocity: Vector2) -> Obstacle {
        Obstacle::new(&[from], 0.3, velocity).unwrap()
    }

    #[test]
    fn the_robot_drives_out_of_the_path_of_somebody_from_the_side() {
        let away = out_of(&[somebody(MapPoint::new(0.1, 1.4), Vector2::new(0.0, -0.8))]).unwrap();
        assert!(away.linear != 0.0, "{away:?}");
    }

    #[test]
    fn the_robot_stands_where_nothing_helps_or_nobody_comes() {
        assert_eq!(out_of(&[]), None);
        assert_eq!(
            out_of(&[somebody(MapPoint::new(3.0, 3.0), Vector2::new(1.0, 0.0))]),
            None
        );
    }

    #[test]
    fn the_robot_does_not_evade_into_a_wall() {
        let wall = Obstacle::wall(MapPoint::new(0.2, -3.0), MapPoint::new(0.2, 3.0)).unwrap();
        let away = out_of(&[
            wall,
            somebody(MapPoint::new(0.1, 1.4), Vector2::new(0.0, -0.8)),
        ]);
        assert!(away.is_none_or(|v| v.linear <= 0.0), "{away:?}");
    }
}
