//! What a user of the band's planner may prefer: points to pass by, and a side to turn to.

use std::time::Duration;

use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::{LocalPlanner, Situation, Teb, TebSettings};

fn situation(path: &[MapPoint]) -> Situation<'_> {
    let (time, pose, velocity) = (SimTime::ZERO, Pose2::default(), Velocity::ZERO);
    Situation { time, pose, velocity, path, final_yaw: None, obstacles: &[] }
}

#[test]
fn bands_pass_by_the_points_of_the_way_where_that_is_wanted() {
    let path = [(0.0, 0.0), (1.5, 1.0), (3.0, 0.0)].map(|(x, y)| MapPoint::new(x, y));
    let furthest_aside = |via: Option<f64>, weight: f64| {
        let mut settings = TebSettings { via, ..TebSettings::default() };
        settings.band.weights.via = weight;
        let mut teb = Teb::new(&RobotDescription::sentry(), settings).unwrap();
        for cycle in 0..20 {
            let time = SimTime::ZERO + Duration::from_millis(50) * cycle;
            teb.plan(&Situation { time, ..situation(&path) }).unwrap();
        }
        let knots = teb.candidates()[0].band.knots();
        knots.iter().map(|k| k.pose.y).fold(0.0, f64::max)
    };
    assert!(furthest_aside(None, 0.0) < 0.1);
    let aside = furthest_aside(Some(0.6), 50.0);
    assert!(aside > 0.6, "{aside}");
}

#[test]
fn a_robot_turns_about_to_the_side_that_is_preferred() {
    let back = [MapPoint::new(0.0, 0.0), MapPoint::new(-3.0, 0.0)];
    for side in [-1.0, 1.0] {
        let mut settings = TebSettings { side, ..TebSettings::default() };
        settings.band.weights.side = 5.0;
        let mut teb = Teb::new(&RobotDescription::sentry(), settings).unwrap();
        teb.plan(&situation(&back)).unwrap();
        let turn = teb.candidates()[0].band.velocity(0).angular;
        assert!(turn * side > 0.1, "{side}: {turn}");
    }
}

#[test]
fn absurd_preferences_are_refused() {
    for (via, side) in [(Some(0.0), 0.0), (Some(f64::NAN), 0.0), (None, f64::INFINITY)] {
        let settings = TebSettings { via, side, ..TebSettings::default() };
        assert!(Teb::new(&RobotDescription::sentry(), settings).is_err(), "{via:?} {side}");
    }
}
