//! How long a robot that cannot get on tries to, alone and where somebody moves near.

use std::time::Duration;

use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::navigator::Step;
use openbench_motion::{
    Blocked, Guide, LocalPlanner, Navigation, Navigator, Obstacle, PlanError, Progress, Situation,
    Surroundings,
};

struct Straight;

impl Guide for Straight {
    fn way(&mut self, from: MapPoint, to: MapPoint) -> Result<Vec<MapPoint>, PlanError> {
        Ok(vec![from, to])
    }

    fn is_blocked(&self, _path: &[MapPoint], _from: MapPoint) -> bool {
        false
    }
}

/// Never finds anything.
struct Timid;

impl LocalPlanner for Timid {
    fn plan(&mut self, _situation: &Situation<'_>) -> Result<Progress, Blocked> {
        Err(Blocked::Obstacle(0.5))
    }

    fn among_people(&self, _situation: &Situation<'_>, _velocity: Velocity) -> Velocity {
        Velocity::ZERO
    }

    fn reset(&mut self) {}
}

/// Seconds until a robot that never gets anywhere gives up, with somebody near it for the first so many, and the steps that it took.
fn gives_up_after(somebody_for: f64) -> (f64, Vec<Step>) {
    let mut navigator = Navigator::new(&RobotDescription::sentry(), Box::new(Timid)).unwrap();
    navigator.set_goal(MapPoint::new(5.0, 0.0), None);
    let walker = [Obstacle::new(&[MapPoint::new(0.0, 1.5)], 0.3, [0.3, 0.0]).unwrap()];
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
        steps.extend(navigator.take_recoveries().iter().map(|recovery| recovery.step));
        match decided {
            Navigation::Drive(velocity) => assert_eq!(velocity, Velocity::ZERO),
            Navigation::Arrived => panic!("it has not moved"),
            Navigation::Failed(_) => return (seconds, steps),
        }
    }
    (f64::INFINITY, steps)
}

#[test]
fn a_robot_that_does_not_get_on_stops_looks_again_maneuvers_and_gives_up() {
    let (seconds, steps) = gives_up_after(0.0);
    assert!((3.0..26.0).contains(&seconds), "{seconds}");
    assert!(steps.starts_with(&[Step::Stop, Step::Replan]) && steps.len() > 2, "{steps:?}");
}

#[test]
fn waiting_for_people_is_no_reason_to_give_up_nor_is_that_they_leave() {
    let alone = gives_up_after(0.0).0;
    for near in [20.0, 60.0] {
        let seconds = gives_up_after(near).0;
        assert!(seconds > near + 3.0 && seconds < near + 26.0, "{near}: {seconds}, alone {alone}");
    }
    // But not for ever.
    let always = gives_up_after(f64::INFINITY).0;
    assert!((100.0..140.0).contains(&always), "{always}");
}
