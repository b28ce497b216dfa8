//! Recovery of a robot that does not get on: its steps with their causes, and how long it tries,
//! alone and near moving obstacles.

use std::time::Duration;

use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::FailureReason;
use openbench_motion::recovery::{Recovery, Step};
use openbench_motion::{
    Blocked, Guide, LocalPlanner, Navigation, Navigator, Obstacle, PlanError, Progress, Situation,
    Surroundings, Vector2,
};

struct Straight;

impl Guide for Straight {
    fn path(&mut self, from: MapPoint, to: MapPoint) -> Result<Vec<MapPoint>, PlanError> {
        Ok(vec![from, to])
    }

    fn is_blocked(&self, _path: &[MapPoint], _from: MapPoint) -> bool {
        false
    }
}

/// Never finds a velocity.
struct Timid;

impl LocalPlanner for Timid {
    fn plan(&mut self, _situation: &Situation<'_>) -> Result<Progress, Blocked> {
        Err(Blocked::Obstacle(0.5))
    }

    fn limit_near_people(&self, _situation: &Situation<'_>, _velocity: Velocity) -> Velocity {
        Velocity::ZERO
    }

    fn reset(&mut self) {}
}

/// Seconds until a robot that never gets anywhere gives up, with somebody near it for the first
/// `somebody_for` seconds, and the steps that it took.
fn gives_up_after(somebody_for: f64) -> (f64, Vec<Step>) {
    let mut navigator = Navigator::new(&RobotDescription::sentry(), Box::new(Timid)).unwrap();
    navigator.set_goal(MapPoint::new(5.0, 0.0), None);
    let walker = [Obstacle::new(&[MapPoint::new(0.0, 1.5)], 0.3, Vector2::new(0.3, 0.0)).unwrap()];
    let mut steps = Vec::new();
    for cycle in 0..4000 {
        let seconds = 0.05 * f64::from(cycle);
        let now = Surroundings {
            time: SimTime::ZERO + Duration::from_millis(50) * cycle,
            pose: Pose2::default(),
            velocity: Velocity::ZERO,
            obstacles: if seconds < somebody_for { &walker } else { &[] },
        };
        let decided = navigator.drive(&now, &mut Straight);
        steps.extend(
            navigator
                .take_recoveries()
                .iter()
                .map(|recovery| recovery.step),
        );
        match decided {
            Navigation::Drive(velocity) => assert_eq!(velocity, Velocity::ZERO),
            Navigation::Arrived => panic!("it has not moved"),
            Navigation::Failed(_) => return (seconds, steps),
        }
    }
    (f64::INFINITY, steps)
}

#[test]
fn a_robot_that_does_not_get_on_stops_replans_maneuvers_and_gives_up() {
    let (seconds, steps) = gives_up_after(0.0);
    assert!((3.0..26.0).contains(&seconds), "{seconds}");
    assert!(
        steps.starts_with(&[Step::Stop, Step::Replan]) && steps.len() > 2,
        "{steps:?}"
    );
}

#[test]
fn a_robot_does_not_give_up_while_people_are_near() {
    let alone = gives_up_after(0.0).0;
    for near in [20.0, 60.0] {
        let seconds = gives_up_after(near).0;
        assert!(
            seconds > near + 3.0 && seconds < near + 26.0,
            "{near}: {seconds}, alone {alone}"
        );
    }
    // But not for ever.
    let always = gives_up_after(f64::INFINITY).0;
    assert!((100.0..140.0).contains(&always), "{always}");
}

/// Always decides the same.
struct Stubborn(Result<Progress, Blocked>);

impl LocalPlanner for Stubborn {
    fn plan(&mut self, _situation: &Situation<'_>) -> Result<Progress, Blocked> {
        self.0
    }

    fn reset(&mut self) {}
}

fn now(cycle: u32, pose: Pose2, obstacles: &[Obstacle]) -> Surroundings<'_> {
    let time = SimTime::ZERO + Duration::from_millis(50) * cycle;
    Surroundings {
        time,
        pose,
        velocity: Velocity::ZERO,
        obstacles,
    }
}

fn navigator(says: Result<Progress, Blocked>, goal: MapPoint) -> Navigator {
    let mut navigator =
        Navigator::new(&RobotDescription::sentry(), Box::new(Stubborn(says))).unwrap();
    navigator.set_goal(goal, None);
    navigator
}

/// The steps until a maneuver has begun, by a planner that is blocked.
fn first_steps(goal: MapPoint, obstacles: &[Obstacle]) -> Vec<Recovery> {
    let mut navigator = navigator(Err(Blocked::Obstacle(0.5)), goal);
    let mut steps = Vec::new();
    for cycle in 0..100 {
        navigator.drive(&now(cycle, Pose2::default(), obstacles), &mut Straight);
        steps.extend(navigator.take_recoveries());
        if steps.len() == 3 {
            break;
        }
    }
    steps
}

#[test]
fn a_maneuver_begins_as_there_is_room_and_has_a_cause() {
    let wall = |y: f64| Obstacle::wall(MapPoint::new(-4.0, y), MapPoint::new(4.0, y)).unwrap();
    let corridor = [wall(-0.18), wall(0.18)];
    let (behind, ahead) = (MapPoint::new(-2.0, 0.0), MapPoint::new(2.0, 0.0));
    for (goal, obstacles, wanted) in [
        (behind, &corridor[..], Step::Back),
        (behind, &[], Step::Turn),
        (ahead, &[], Step::Maneuver),
    ] {
        let taken = first_steps(goal, obstacles);
        let steps: Vec<Step> = taken.iter().map(|recovery| recovery.step).collect();
        assert_eq!(steps, [Step::Stop, Step::Replan, wanted]);
        assert!(
            taken
                .iter()
                .all(|recovery| recovery.cause == Blocked::Obstacle(0.5)),
            "{taken:?}"
        );
    }
}

#[test]
fn slowing_down_is_recorded_once() {
    let velocity = Velocity::new(0.1, 0.0);
    let mut navigator = navigator(
        Ok(Progress::Slowed(velocity, Blocked::Yielding)),
        MapPoint::new(9.0, 0.0),
    );
    for cycle in 0..100 {
        let pose = Pose2::new(0.005 * f64::from(cycle), 0.0, 0.0);
        assert_eq!(
            navigator.drive(&now(cycle, pose, &[]), &mut Straight),
            Navigation::Drive(velocity)
        );
    }
    let taken: Vec<_> = navigator
        .take_recoveries()
        .iter()
        .map(|r| (r.step, r.cause))
        .collect();
    assert_eq!(taken, [(Step::Slow, Blocked::Yielding)]);
}

#[test]
fn a_robot_that_is_driven_and_does_not_move_stops() {
    let mut navigator = navigator(
        Ok(Progress::Drive(Velocity::new(0.5, 0.0))),
        MapPoint::new(9.0, 0.0),
    );
    for cycle in 0..60 {
        navigator.drive(&now(cycle, Pose2::default(), &[]), &mut Straight);
    }
    let taken = navigator.take_recoveries();
    assert_eq!(
        (taken[0].step, taken[0].cause),
        (Step::Stop, Blocked::Creeping)
    );
}

/// Stands for so many cycles, then drives.
struct Patient(u32, Velocity);

impl LocalPlanner for Patient {
    fn plan(&mut self, _situation: &Situation<'_>) -> Result<Progress, Blocked> {
        self.0 = self.0.saturating_sub(1);
        let waits = Progress::Slowed(Velocity::ZERO, Blocked::Yielding);
        Ok(if self.0 > 0 {
            waits
        } else {
            Progress::Drive(self.1)
        })
    }

    fn reset(&mut self) {}
}

#[test]
fn a_robot_that_was_commanded_to_stand_is_not_creeping() {
    let velocity = Velocity::new(0.5, 0.0);
    let robot = RobotDescription::sentry();
    let mut navigator = Navigator::new(&robot, Box::new(Patient(100, velocity))).unwrap();
    navigator.set_goal(MapPoint::new(9.0, 0.0), None);
    for cycle in 0..120 {
        let told = if cycle < 99 { Velocity::ZERO } else { velocity };
        let decided = navigator.drive(&now(cycle, Pose2::default(), &[]), &mut Straight);
        assert_eq!(decided, Navigation::Drive(told), "{cycle}");
    }
}

#[test]
fn a_robot_that_lost_its_pose_waits_for_it_but_not_for_ever() {
    let (velocity, lost) = (Velocity::new(0.5, 0.0), Pose2::new(f64::NAN, 0.0, 0.0));
    let mut navigator = navigator(Ok(Progress::Drive(velocity)), MapPoint::new(9.0, 0.0));
    for cycle in 0..100 {
        assert_eq!(
            navigator.drive(&now(cycle, lost, &[]), &mut Straight),
            Navigation::Drive(Velocity::ZERO)
        );
    }
    let found = navigator.drive(&now(100, Pose2::default(), &[]), &mut Straight);
    assert_eq!(found, Navigation::Drive(velocity));
    let failed = Navigation::Failed(FailureReason::Stuck(Blocked::NoPose));
    assert!((101..160).all(|cycle| {
        let drives = navigator.drive(
            &now(cycle, Pose2::new(0.02 * f64::from(cycle), 0.0, 0.0), &[]),
            &mut Straight,
        );
        drives == Navigation::Drive(velocity)
    }));
    // Almost as long as possible, twice: that time counts against no timeout.
    let back = Pose2::new(3.2, 0.0, 0.0);
    for (from, until) in [(160, 640), (660, 1140)] {
        assert!((from..until).all(|cycle| {
            navigator.drive(&now(cycle, lost, &[]), &mut Straight)
                == Navigation::Drive(Velocity::ZERO)
        }));
        assert_eq!(
            navigator.drive(&now(until, back, &[]), &mut Straight),
            Navigation::Drive(velocity)
        );
    }
    let gave_up = (1141..2200)
        .find(|cycle| navigator.drive(&now(*cycle, lost, &[]), &mut Straight) == failed);
    assert!(gave_up.is_some_and(|cycle| cycle > 1600), "{gave_up:?}");
    // The answer stays the same when it is asked again.
    assert_eq!(
        navigator.drive(&now(2300, Pose2::default(), &[]), &mut Straight),
        failed
    );
}

#[test]
fn a_goal_that_is_not_finite_is_given_up_at_once() {
    for goal in [MapPoint::new(f64::NAN, 0.0), MapPoint::new(0.0, 1e300)] {
        let mut navigator = navigator(Ok(Progress::Arrived), goal);
        let failed = Navigation::Failed(FailureReason::Stuck(Blocked::NoPath));
        assert_eq!(
            navigator.drive(&now(0, Pose2::default(), &[]), &mut Straight),
            failed
        );
    }
}

#[test]
fn a_maneuver_is_driven_on_when_the_estimate_jumps() {
    let mut navigator = navigator(Err(Blocked::Obstacle(0.5)), MapPoint::new(3.0, 0.0));
    let (mut pose, mut told, mut jumped) = (Pose2::default(), Velocity::ZERO, 0);
    for cycle in 0..160 {
        let Navigation::Drive(velocity) = navigator.drive(&now(cycle, pose, &[]), &mut Straight)
        else {
            break;
        };
        if jumped > 0 && jumped < 10 {
            assert!(
                (velocity.linear - told.linear).abs() < 0.1 && velocity.angular.abs() < 0.1,
                "{velocity:?}"
            );
            jumped += 1;
        }
        told = velocity;
        pose = pose.compose(Pose2::new(
            0.05 * velocity.linear,
            0.0,
            0.05 * velocity.angular,
        ));
        if jumped == 0 && pose.x > 1.0 {
            pose.y += 0.5;
            jumped = 1;
        }
    }
    assert_eq!(jumped, 10);
}
