//! What the Timed Elastic Band planner keeps from cycle to cycle: its classes, which of them it
//! drives, and its motion when the estimate jumps.

use std::time::Duration;

use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::Limits;
use openbench_motion::Motion;
use openbench_motion::{LocalPlanner, Obstacle, Situation, Teb, TebSettings};

/// Seconds between two calls.
const STEP: f64 = 0.05;

fn time(cycle: u32) -> SimTime {
    SimTime::ZERO + Duration::from_millis(50) * cycle
}

/// The largest distance of a band to the left of the x axis, less that to the right, metres.
fn aside(teb: &Teb, class: usize) -> f64 {
    let knots = teb.candidates()[class].band.poses();
    let y = |sign: f64| knots.iter().map(|k| sign * k.pose.y).fold(0.0, f64::max);
    y(1.0) - y(-1.0)
}

#[test]
fn both_classes_around_a_disc_are_kept_and_the_choice_is_stable() {
    let robot = RobotDescription::sentry();
    let (limits, mut teb) = (
        Limits::of(&robot).unwrap(),
        Teb::new(&robot, TebSettings::default()).unwrap(),
    );
    let path = [MapPoint::default(), MapPoint::new(6.0, 0.0)];
    let stone = [Obstacle::disc(MapPoint::new(3.5, 0.0), 0.3).unwrap()];
    let mut motion = Motion {
        pose: Pose2::default(),
        velocity: Velocity::ZERO,
        command: Velocity::ZERO,
    };
    let mut chosen = Vec::new();
    for cycle in 0..60 {
        // The estimate is noisy, so that either side is the shorter in turn.
        let shake = if cycle % 6 < 3 { 0.01 } else { -0.01 };
        let pose = Pose2 {
            y: motion.pose.y + shake,
            ..motion.pose
        };
        let velocity = motion.velocity;
        let situation = Situation {
            time: time(cycle),
            pose,
            velocity,
            path: &path,
            final_yaw: None,
            obstacles: &stone,
        };
        motion.command = teb.plan(&situation).unwrap().velocity().unwrap();
        motion.step(&limits, STEP);
        let sides: Vec<bool> = (0..teb.candidates().len())
            .map(|class| aside(&teb, class) > 0.0)
            .collect();
        assert!(
            sides.contains(&true) && sides.contains(&false),
            "{cycle}: {sides:?}"
        );
        let mut signatures: Vec<_> = teb.candidates().iter().map(|c| c.signature).collect();
        signatures.sort_unstable();
        signatures.dedup();
        assert_eq!(signatures.len(), teb.candidates().len());
        chosen.push(sides[0]);
    }
    assert!(
        motion.pose.x > 0.8 && chosen.iter().all(|side| *side == chosen[0]),
        "{chosen:?}"
    );
}

/// The largest changes of the commanded speed and turn rate between cycles, from a second before
/// the estimate jumps aside until two seconds after it.
fn changes(jump: f64) -> (f64, f64) {
    let robot = RobotDescription::sentry();
    let mut teb = Teb::new(&robot, TebSettings::default()).unwrap();
    let limits = Limits::of(&robot).unwrap();
    let path = [MapPoint::default(), MapPoint::new(8.0, 0.0)];
    let mut motion = Motion {
        pose: Pose2::default(),
        velocity: Velocity::ZERO,
        command: Velocity::ZERO,
    };
    let mut most = (0.0_f64, 0.0_f64);
    for cycle in 0..100 {
        let by = if cycle >= 60 { jump } else { 0.0 };
        let pose = Pose2 {
            y: motion.pose.y + by,
            ..motion.pose
        };
        let (velocity, obstacles) = (motion.velocity, &[]);
        let situation = Situation {
            time: time(cycle),
            pose,
            velocity,
            path: &path,
            final_yaw: None,
            obstacles,
        };
        let told = teb.plan(&situation).unwrap().velocity().unwrap();
        if cycle >= 40 {
            let before = motion.command;
            most.0 = most.0.max((told.linear - before.linear).abs());
            most.1 = most.1.max((told.angular - before.angular).abs());
        }
        motion.command = told;
        motion.step(&limits, STEP);
    }
    most
}

#[test]
fn a_jump_of_the_estimate_does_not_jerk_the_robot() {
    let (limits, most) = (Limits::of(&RobotDescription::sentry()).unwrap(), 2.0 * STEP);
    for jump in [0.0, 0.5, -0.5] {
        let (linear, angular) = changes(jump);
        assert!(linear <= most * limits.acceleration, "{jump}: {linear}");
        assert!(
            angular <= most * limits.acceleration / limits.half_track,
            "{jump}: {angular}"
        );
    }
}
