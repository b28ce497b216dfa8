//! A scene and its mirror image are driven alike.

use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::{LocalPlanner, Obstacle, Progress, Situation, Teb, TebSettings};
use proptest::prelude::*;

/// The decision among discs, with the scene mirrored by `side`: the velocity, and the cost of each
/// band, the cheapest first.
fn decided(
    discs: &[(f64, f64, f64)],
    goal: (f64, f64),
    yaw: f64,
    side: f64,
) -> (Progress, Vec<f64>) {
    let obstacles: Vec<Obstacle> = discs
        .iter()
        .map(|(x, y, r)| Obstacle::disc(MapPoint::new(*x, side * y), *r).unwrap())
        .collect();
    let mut teb = Teb::new(&RobotDescription::sentry(), TebSettings::default()).unwrap();
    let path = [MapPoint::default(), MapPoint::new(goal.0, side * goal.1)];
    let situation = Situation {
        time: SimTime::ZERO,
        pose: Pose2::default(),
        velocity: Velocity::ZERO,
        path: &path,
        final_yaw: Some(side * yaw),
        obstacles: &obstacles,
    };
    // Of paths over cells with equal costs another one may be the first: it takes some cycles until
    // the bands converge.
    let mut decided = teb.plan(&situation);
    for _ in 1..40 {
        decided = teb.plan(&situation);
    }
    let mut costs: Vec<f64> = teb.candidates().iter().map(|c| c.cost).collect();
    costs.sort_by(f64::total_cmp);
    (decided.unwrap(), costs)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn mirrored_scenes_have_mirrored_answers(
        discs in prop::collection::vec((0.8..2.6_f64, -1.2..1.2_f64, 0.05..0.25_f64), 0..6),
        goal in (3.0..3.6_f64, -0.6..0.6_f64),
        yaw in -1.5..1.5_f64,
    ) {
        let (left, right) = (decided(&discs, goal, yaw, 1.0), decided(&discs, goal, yaw, -1.0));
        let velocities = (left.0.velocity(), right.0.velocity());
        let (Some(a), Some(b)) = velocities else { panic!("{left:?} {right:?}") };
        prop_assert!((left.1[0] - right.1[0]).abs() < 0.02 * left.1[0], "{left:?} {right:?}");
        // Between two bands that are as good either may be driven.
        if left.1.len() < 2 || left.1[1] > 1.1 * left.1[0] {
            prop_assert!((a.linear - b.linear).abs() < 0.03, "{left:?} {right:?}");
            prop_assert!((a.angular + b.angular).abs() < 0.1, "{left:?} {right:?}");
        }
    }
}
