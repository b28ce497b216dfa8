//! Suites whose goal is a point.

use openbench_bench::suite::GoalKind;
use openbench_bench::worlds::PreparedEpisode;
use openbench_bench::{Prepared, Rollout, Status, Suite, builtin_suite};
use openbench_core::{Action, Address, Goal, Pose2, Start};

fn suite() -> Suite {
    let mut suite = builtin_suite("small").unwrap();
    suite.goal = GoalKind::Point;
    suite
        .episodes
        .retain(|episode| episode.deliveries.len() == 1);
    suite
}

/// An episode that begins at its goal.
fn at_the_goal(prepared: &Prepared) -> PreparedEpisode {
    let episode = prepared.episodes[0].clone();
    let goal = prepared.point_goal(&episode).unwrap();
    prepared.starting_at(Pose2::new(goal.x, goal.y, 0.0), episode)
}

#[test]
fn agents_are_told_the_place_before_the_door() {
    let prepared = Prepared::new(suite(), None).unwrap();
    let rollout = Rollout::new(&prepared, 0, 1).unwrap();
    let door = prepared.episodes[0].targets[0].door.unwrap();
    let place = prepared.approach[door].unwrap();
    assert_eq!(rollout.briefing().goal, Goal::Point(place));
}

#[test]
fn any_address_declares_the_delivery_of_a_point() {
    let prepared = Prepared::new(suite(), None).unwrap();
    let mut rollout = Rollout::of(&prepared, at_the_goal(&prepared), 1).unwrap();
    let declared = Action::Delivered(Address::new("", ""));
    assert_eq!(rollout.step(declared), Status::Ended);
    let trace = rollout.finish(None).unwrap();
    assert!(trace.tasks[0].declared && trace.tasks[0].failure.is_none());
}

#[test]
fn an_episode_from_another_start_has_the_limit_of_its_own_way() {
    let prepared = Prepared::new(suite(), None).unwrap();
    let near = at_the_goal(&prepared);
    assert_eq!(near.time_limit.as_secs(), 120);
    assert!(prepared.episodes[0].time_limit > near.time_limit);
    let rollout = Rollout::of(&prepared, near.clone(), 1).unwrap();
    assert_eq!(rollout.briefing().start, Start::exact(near.start));
}

#[test]
fn sequences_have_no_single_point() {
    let mut suite = builtin_suite("small").unwrap();
    suite.goal = GoalKind::Point;
    let error = Prepared::new(suite, None).err().unwrap().to_string();
    assert!(error.contains("several deliveries"), "{error}");
}

#[test]
fn the_goal_stands_in_suite_files() {
    let text = suite().to_toml();
    assert!(text.contains("goal = \"point\""), "{text}");
    assert!(!builtin_suite("small").unwrap().to_toml().contains("goal"));
}
