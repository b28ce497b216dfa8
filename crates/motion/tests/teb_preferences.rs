//! Preferences of the Timed Elastic Band planner: via points, a side to turn to, and caution of
//! people.

use std::time::Duration;

use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::Limits;
use openbench_motion::Motion;
use openbench_motion::feasible::clearance;
use openbench_motion::{
    Footprint, LocalPlanner, Obstacle, Progress, Situation, Teb, TebSettings, Vector2,
};

fn situation(path: &[MapPoint]) -> Situation<'_> {
    let (time, pose, velocity) = (SimTime::ZERO, Pose2::default(), Velocity::ZERO);
    Situation {
        time,
        pose,
        velocity,
        path,
        final_yaw: None,
        obstacles: &[],
    }
}

#[test]
fn bands_pass_via_points_of_the_path_on_request() {
    let path = [(0.0, 0.0), (1.5, 1.0), (3.0, 0.0)].map(|(x, y)| MapPoint::new(x, y));
    let furthest_aside = |via: Option<f64>, weight: f64| {
        let mut settings = TebSettings {
            via,
            ..TebSettings::default()
        };
        settings.band.weights.via = weight;
        let mut teb = Teb::new(&RobotDescription::sentry(), settings).unwrap();
        for cycle in 0..20 {
            let time = SimTime::ZERO + Duration::from_millis(50) * cycle;
            teb.plan(&Situation {
                time,
                ..situation(&path)
            })
            .unwrap();
        }
        let knots = teb.candidates()[0].band.poses();
        knots.iter().map(|k| k.pose.y).fold(0.0, f64::max)
    };
    assert!(furthest_aside(None, 0.0) < 0.1);
    let aside = furthest_aside(Some(0.6), 50.0);
    assert!(aside > 0.6, "{aside}");
}

#[test]
fn a_robot_makes_a_u_turn_to_the_preferred_side() {
    let back = [MapPoint::new(0.0, 0.0), MapPoint::new(-3.0, 0.0)];
    for side in [-1.0, 1.0] {
        let mut settings = TebSettings {
            side,
            ..TebSettings::default()
        };
        settings.band.weights.side = 5.0;
        let mut teb = Teb::new(&RobotDescription::sentry(), settings).unwrap();
        teb.plan(&situation(&back)).unwrap();
        let turn = teb.candidates()[0].band.velocity(0).angular;
        assert!(turn * side > 0.1, "{side}: {turn}");
    }
}

#[test]
fn impossible_preferences_are_refused() {
    let good = TebSettings::default();
    let odd = [
        TebSettings {
            via: Some(0.0),
            ..good
        },
        TebSettings {
            via: Some(f64::NAN),
            ..good
        },
        TebSettings {
            side: f64::INFINITY,
            ..good
        },
        TebSettings {
            approach_margin_mps: Some(-1.0),
            ..good
        },
        TebSettings {
            stopping_time_s: Some(0.0),
            ..good
        },
    ];
    for settings in odd {
        assert!(
            Teb::new(&RobotDescription::sentry(), settings).is_err(),
            "{settings:?}"
        );
    }
}

/// The robot's speed when it is touched by somebody who walks beside it and approaches with
/// `comes_nearer` m/s, though they seem to walk straight on.
fn touched_at(approach_margin_mps: Option<f64>, comes_nearer: f64) -> f64 {
    let robot = RobotDescription::sentry();
    let mut teb = Teb::new(
        &robot,
        TebSettings {
            approach_margin_mps,
            ..TebSettings::default()
        },
    )
    .unwrap();
    let (limits, footprint) = (Limits::of(&robot).unwrap(), Footprint::of(&robot).unwrap());
    let mut motion = Motion {
        pose: Pose2::default(),
        velocity: Velocity::ZERO,
        command: Velocity::ZERO,
    };
    let path = [MapPoint::default(), MapPoint::new(30.0, 0.0)];
    // A wall on the other side: there is no room to evade.
    let wall = Obstacle::wall(MapPoint::new(-1.0, -0.22), MapPoint::new(31.0, -0.22)).unwrap();
    let mut aside = 1.2;
    for cycle in 0..400 {
        let place = MapPoint::new(motion.pose.x, aside);
        let walker = Obstacle::new(
            &[place],
            0.25,
            Vector2::new(motion.velocity.linear.max(0.01), 0.0),
        )
        .unwrap();
        let seen = [walker, wall.clone()];
        if clearance(&footprint, seen[..1].iter(), motion.pose, 0.0, 1.0) <= 0.0 {
            return motion.velocity.linear.abs();
        }
        let time = SimTime::ZERO + Duration::from_millis(50) * cycle;
        let now = Situation {
            time,
            pose: motion.pose,
            velocity: motion.velocity,
            ..situation(&path)
        };
        motion.command = match teb.plan(&Situation {
            obstacles: &seen,
            ..now
        }) {
            Ok(Progress::Drive(velocity) | Progress::Slowed(velocity, _)) => velocity,
            _ => Velocity::ZERO,
        };
        motion.step(&limits, 0.05);
        aside -= 0.05 * comes_nearer;
    }
    panic!("nobody was touched");
}

#[test]
fn a_cautious_robot_stands_when_it_is_touched() {
    // People who approach more slowly than this are braked for without caution, too.
    for comes_nearer in [0.15, 0.25, 0.4, 0.6] {
        let speeds = [Some(0.4), None]
            .map(|approach_margin_mps| touched_at(approach_margin_mps, comes_nearer));
        assert!(
            speeds[0] < 0.05 && speeds[1] > 0.3,
            "{comes_nearer}: {speeds:?}"
        );
    }
}

/// Seconds until a standing robot sets out for a place straight ahead (1) or behind it (-1) while
/// somebody is `away` metres aside.
fn sets_out_after(approach_margin_mps: Option<f64>, away: f64, ahead: f64) -> f64 {
    let mut teb = Teb::new(
        &RobotDescription::sentry(),
        TebSettings {
            approach_margin_mps,
            ..TebSettings::default()
        },
    )
    .unwrap();
    let path = [MapPoint::default(), MapPoint::new(30.0 * ahead, 0.0)];
    let seen = [Obstacle::new(&[MapPoint::new(0.0, away)], 0.25, Vector2::new(0.05, 0.0)).unwrap()];
    let told = (0..40).find(|cycle| {
        let time = SimTime::ZERO + Duration::from_millis(50) * *cycle;
        match teb.plan(&Situation {
            time,
            obstacles: &seen,
            ..situation(&path)
        }) {
            Ok(Progress::Drive(velocity) | Progress::Slowed(velocity, _)) => {
                velocity.linear.abs() + 0.2 * velocity.angular.abs() > 0.01
            }
            _ => false,
        }
    });
    told.map_or(f64::INFINITY, |cycle| 0.05 * f64::from(cycle))
}

#[test]
fn a_cautious_robot_near_somebody_waits_before_it_sets_out() {
    for ahead in [1.0, -1.0] {
        let near = sets_out_after(Some(0.4), 1.4, ahead);
        assert!((0.4..0.7).contains(&near), "{near}");
        assert!(
            sets_out_after(Some(0.4), 4.0, ahead) < 0.2 && sets_out_after(None, 1.4, ahead) < 0.2
        );
    }
}

/// The least distance between a robot that drives east and somebody who walks north across its path
/// without looking, and whether the robot reaches its goal.
fn crosses(stopping_time_s: Option<f64>, begins: f64) -> (f64, bool) {
    let robot = RobotDescription::sentry();
    let mut settings = TebSettings {
        approach_margin_mps: Some(0.4),
        stopping_time_s,
        ..TebSettings::default()
    };
    settings.band.margins.moving = 0.3;
    let mut teb = Teb::new(&robot, settings).unwrap();
    let (limits, footprint) = (Limits::of(&robot).unwrap(), Footprint::of(&robot).unwrap());
    let mut motion = Motion {
        pose: Pose2::default(),
        velocity: Velocity::ZERO,
        command: Velocity::ZERO,
    };
    let path = [MapPoint::default(), MapPoint::new(4.0, 0.0)];
    let mut least = 1.0;
    for cycle in 0..400 {
        let place = MapPoint::new(2.0, begins + 0.05 * 1.2 * f64::from(cycle));
        let seen = [Obstacle::new(&[place], 0.25, Vector2::new(0.0, 1.2)).unwrap()];
        least = clearance(&footprint, seen.iter(), motion.pose, 0.0, least);
        let time = SimTime::ZERO + Duration::from_millis(50) * cycle;
        let now = Situation {
            time,
            pose: motion.pose,
            velocity: motion.velocity,
            ..situation(&path)
        };
        motion.command = match teb.plan(&Situation {
            obstacles: &seen,
            ..now
        }) {
            Ok(Progress::Drive(velocity) | Progress::Slowed(velocity, _)) => velocity,
            Ok(Progress::Arrived) => return (least, true),
            Err(_) => Velocity::ZERO,
        };
        motion.step(&limits, 0.05);
    }
    (least, false)
}

#[test]
fn a_robot_that_yields_passes_before_somebody_or_lets_them_pass() {
    for from in (0..24).map(|i| -8.0 + 0.25 * f64::from(i)) {
        let (least, there) = crosses(Some(0.6), from);
        assert!(least > 0.1 && there, "{from}: {least}");
    }
}
