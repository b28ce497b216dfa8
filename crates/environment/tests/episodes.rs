//! Environments over whole episodes.

use std::num::NonZeroU32;

use openbench_bench::Rollout;
use openbench_bench::suite::GoalKind;
use openbench_bench::worlds::suite_named;
use openbench_core::{
    Action, Briefing, FailureCause, MapPoint, Pose2, Velocity, frames::wrap_angle,
};
use openbench_environment::{
    Actions, Adapter, Declaration, Environment, EnvironmentError, Observe, Options, PoseSource,
    RangeImage, StartDistance, Step, World,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn environment(options: Options) -> Environment {
    let world = World::new(suite_named("small").unwrap(), &options).unwrap();
    Environment::new(world, options).unwrap()
}

/// A point goal near by, seen from an estimated pose.
fn point_goal() -> Options {
    Options {
        goal: GoalKind::Point,
        start: Some(StartDistance {
            least: 2.0,
            largest: 6.0,
        }),
        observe: Observe {
            range_image: Some(RangeImage::default()),
            pose: Some(PoseSource::Wheels),
            imu: true,
            ..Observe::default()
        },
        steps_per_action: 2,
        ..Options::default()
    }
}

/// Turns towards a place in the robot's frame, then drives there.
fn towards(forward: f64, left: f64) -> [f64; 3] {
    let bearing = libm::atan2(left, forward);
    let speed = if bearing.abs() < 0.3 { 0.4 } else { 0.0 };
    [speed, 2.0 * bearing, 0.0]
}

/// Follows the shortest way by the truth to within half a metre, declares there, and returns the
/// steps.
fn deliver(environment: &mut Environment) -> Vec<Step> {
    let mut steps = Vec::new();
    loop {
        let prepared = environment.world().prepared();
        let (pose, left) = environment.privileged().unwrap();
        let address = environment.open_address().unwrap();
        let doors = &prepared.world.scene.doors;
        let door = doors
            .iter()
            .position(|door| door.address.same_door(address));
        let goal = prepared.approach[door.unwrap()].unwrap();
        let action = if left.unwrap() < 0.5 {
            [0.0, 0.0, 1.0]
        } else {
            let ahead = ahead(environment, pose, goal);
            let (forward, left) = pose.inverse_transform(ahead);
            towards(forward, left)
        };
        let step = environment.step(action).unwrap();
        let ended = step.outcome.is_some();
        steps.push(step);
        if ended {
            return steps;
        }
    }
}

/// A place half a metre along the shortest way.
fn ahead(environment: &Environment, pose: Pose2, goal: MapPoint) -> MapPoint {
    let space = &environment.world().prepared().free_space;
    let here = space.nearest_reachable(pose.point(), 1.0).unwrap();
    let path = space.path(here, goal).unwrap();
    let far = path.iter().find(|corner| corner.distance(here) > 0.5);
    *far.unwrap_or(&goal)
}

#[test]
fn a_robot_that_follows_the_way_is_rewarded_for_its_length_and_for_success() {
    let mut environment = environment(Options::default());
    environment.reset(Some(3), Some(0)).unwrap();
    let (_, way) = environment.privileged().unwrap();
    let steps = deliver(&mut environment);
    let last = steps.last().unwrap();
    let outcome = last.outcome.as_ref().unwrap();
    assert!(outcome.is_success && last.terminated && !last.truncated);
    let total: f64 = steps.iter().map(|step| step.reward).sum();
    let time = 0.05 * outcome.sim_seconds;
    let touched = outcome.deliveries[0].contact_s;
    let expected = way.unwrap() - 0.5 - time - touched + 10.0;
    assert!((total - expected).abs() < 1.0, "{total}, not {expected}");
}

#[test]
fn the_same_seed_and_actions_give_the_same_episode() {
    let drive = |seed| {
        let mut environment = environment(point_goal());
        let mut seen = vec![environment.reset(Some(seed), None).unwrap()];
        for i in 0..40 {
            let step = environment
                .step([0.2, 0.1 * f64::from(i % 5), 0.0])
                .unwrap();
            seen.push(step.observation);
        }
        seen
    };
    assert_eq!(drive(1), drive(1));
    assert_ne!(drive(1), drive(2));
}

#[test]
fn a_point_goal_is_seen_from_where_the_robot_takes_itself_to_be() {
    let mut environment = environment(point_goal());
    for seed in 0..5 {
        let observation = environment.reset(Some(seed), None).unwrap();
        let [forward, left] = observation.goal.unwrap().map(f64::from);
        let (pose, way) = environment.privileged().unwrap();
        let way = way.unwrap();
        assert!((1.9..6.2).contains(&way), "{way}");
        // The way is at most 8 % longer than the shortest, and no shorter than the straight line.
        assert!(libm::hypot(forward, left) < way + 0.2);
        let goal = pose.transform(forward, left);
        let prepared = environment.world().prepared();
        let nearest = prepared.approach.iter().flatten().map(|p| p.distance(goal));
        assert!(nearest.fold(f64::INFINITY, f64::min) < 0.1);
        assert_eq!(observation.range_image.len(), 8 * 120);
        assert_eq!(observation.imu.len(), 2 * 5 * 6);
    }
}

#[test]
fn an_adapter_in_a_run_sees_what_the_environment_shows() {
    let mut options = Options {
        start: None,
        ..point_goal()
    };
    options.observe.one_firing_in = NonZeroU32::new(8).unwrap();
    let mut environment = environment(options.clone());
    let shown = environment.reset(Some(5), None).unwrap();
    // As the environment draws the episode and the seed of its noise.
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let world = environment.world().clone();
    let prepared = world.prepared();
    let episode = random.random_range(0..prepared.episodes.len());
    let mut rollout = Rollout::new(prepared, episode, random.random()).unwrap();
    let Briefing { robot, start, .. } = rollout.briefing();
    let goal = prepared.point_goal(&prepared.episodes[episode]);
    let mut adapter = Adapter::new(&options, robot, start.pose().unwrap(), goal).unwrap();
    let drive = |rollout: &mut Rollout<'_>, adapter: &mut Adapter, velocity| {
        rollout.step(Action::Drive(velocity));
        adapter.take(&rollout.observation());
    };
    while !adapter.is_ready(rollout.observation().time) {
        drive(&mut rollout, &mut adapter, Velocity::ZERO);
    }
    assert_eq!(adapter.observation(), shown);
    for i in 0..20 {
        let action = [0.3, 0.1 * f64::from(i % 5)];
        adapter.begin(action);
        for _ in 0..options.steps_per_action {
            let velocity = adapter.velocity(rollout.observation().time);
            drive(&mut rollout, &mut adapter, velocity);
        }
        let step = environment.step([action[0], action[1], 0.0]).unwrap();
        assert_eq!(adapter.observation(), step.observation);
    }
}

#[test]
fn an_estimated_pose_follows_the_true_one_from_the_first_action() {
    for seed in 0..4 {
        let mut environment = environment(point_goal());
        environment.reset(Some(seed), None).unwrap();
        for step in 0..60 {
            let turn = if step < 30 { 0.9 } else { -0.5 };
            let observation = environment.step([0.2, turn, 0.0]).unwrap().observation;
            let (estimated, (true_pose, _)) =
                (observation.pose.unwrap(), environment.privileged().unwrap());
            let off = estimated.point().distance(true_pose.point());
            let turned_off = wrap_angle(estimated.yaw - true_pose.yaw).abs();
            // A skid-steered robot drives a little less far than its wheels say.
            assert!(
                off < 0.2 && turned_off < 0.02,
                "{estimated:?} {true_pose:?}"
            );
        }
    }
}

#[test]
fn a_robot_that_arrives_has_delivered_where_the_environment_declares() {
    let options = Options {
        declaration: Declaration::Arrival(0.7),
        ..point_goal()
    };
    let mut environment = environment(options);
    environment.reset(Some(5), None).unwrap();
    for _ in 0..1000 {
        let (pose, _) = environment.privileged().unwrap();
        let address = environment.open_address().unwrap().clone();
        let prepared = environment.world().prepared();
        let doors = &prepared.world.scene.doors;
        let door = doors
            .iter()
            .position(|door| door.address.same_door(&address));
        let goal = prepared.approach[door.unwrap()].unwrap();
        let ahead = ahead(&environment, pose, goal);
        let (forward, left) = pose.inverse_transform(ahead);
        assert!(wrap_angle(pose.yaw).is_finite());
        let step = environment.step(towards(forward, left)).unwrap();
        if let Some(outcome) = step.outcome {
            assert!(outcome.is_success, "{outcome:?}");
            return;
        }
    }
    panic!("it never arrived");
}

#[test]
fn a_waypoint_is_driven_to_within_an_action() {
    let mut options = point_goal();
    options.actions = Actions::Waypoint;
    options.steps_per_action = 60;
    let mut environment = environment(options);
    let begun = environment.reset(Some(1), Some(0)).unwrap();
    let (before, _) = environment.privileged().unwrap();
    let step = environment.step([0.3, 0.1, 0.0]).unwrap();
    let (after, _) = environment.privileged().unwrap();
    // It stops within 5 cm of where its wheels say that the waypoint is, and rolls on for as much.
    let wanted = before.transform(0.3, 0.1);
    assert!(
        after.point().distance(wanted) < 0.2,
        "{after:?} for {wanted:?}"
    );
    assert_ne!(step.observation.goal, begun.goal);
}

#[test]
fn the_end_of_time_truncates() {
    let mut options = Options {
        time_limit_s: Some(1.0),
        ..Options::default()
    };
    // The gyroscope rests for four seconds, which do not count.
    options.observe.pose = Some(PoseSource::Wheels);
    let mut environment = environment(options);
    environment.reset(Some(1), None).unwrap();
    for _ in 0..19 {
        assert!(!environment.step([0.0; 3]).unwrap().truncated);
    }
    let last = environment.step([0.0; 3]).unwrap();
    assert!(last.truncated && !last.terminated);
    let outcome = last.outcome.unwrap();
    assert_eq!(outcome.deliveries[0].failure, Some(FailureCause::Timeout));
    let after = environment.step([0.0; 3]);
    assert!(matches!(after, Err(EnvironmentError::NoEpisode)));
}

#[test]
fn a_wrong_declaration_fails() {
    let mut environment = environment(point_goal());
    environment.reset(Some(1), None).unwrap();
    let step = environment.step([0.0, 0.0, 1.0]).unwrap();
    assert!(step.terminated && step.reward < -4.0);
    assert!(!step.outcome.unwrap().is_success);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let mut environment = environment(Options::default());
    assert!(matches!(
        environment.step([0.0; 3]),
        Err(EnvironmentError::NoEpisode)
    ));
    environment.reset(None, None).unwrap();
    assert!(matches!(
        environment.step([f64::NAN, 0.0, 0.0]),
        Err(EnvironmentError::Action(_))
    ));
    // The episode goes on.
    environment.step([0.1, 0.0, 0.0]).unwrap();
    assert!(environment.reset(None, Some(1_000_000)).is_err());
    let world = environment.world().clone();
    let options = Options {
        steps_per_action: 0,
        ..Options::default()
    };
    assert!(Environment::new(world, options).is_err());
}

#[test]
fn a_suite_that_charges_for_computing_is_refused() {
    let mut suite = suite_named("small").unwrap();
    suite.conditions.set("compute", "charged").unwrap();
    let refused = World::new(suite, &Options::default());
    let error = refused.err().unwrap().to_string();
    assert!(error.contains("compute = free"), "{error}");
}
