//! What every `PathFollower` keeps to, checked on each implementation.

use openbench_core::{Georeference, LonLat, MapPoint, Pose2, RobotDescription, Velocity};
use openbench_motion::{Blocked, Costmap, FollowInput, Follower, PathFollower, Progress, RangeRing};
use openbench_osm::{OsmData, OsmMap};
use proptest::prelude::*;

type Make = fn() -> Box<dyn PathFollower>;

const FOLLOWERS: [Make; 1] = [|| Box::new(Follower::new(RobotDescription::sentry()))];

/// Seconds between two calls.
const STEP: f64 = 0.05;

/// Empty ground of 20 m x 20 m, with a wall where points are given.
fn ground(wall: impl Iterator<Item = MapPoint>) -> Costmap {
    let map = OsmMap::new(&OsmData::default(), Georeference::TangentPlane(LonLat::new(8.0, 50.0)));
    let (low, high) = (MapPoint::new(-10.0, -10.0), MapPoint::new(10.0, 10.0));
    let mut costmap = Costmap::new(&map, low, high, &RobotDescription::sentry()).unwrap();
    costmap.observe(&RangeRing::new(MapPoint::default(), 0.235, wall.map(|p| (p, 0.3))));
    costmap.inflate();
    costmap
}

fn move_on(pose: Pose2, v: Velocity) -> Pose2 {
    pose.compose(Pose2::new(v.linear * STEP, 0.0, v.angular * STEP))
}

fn points(corners: &[(f64, f64)]) -> Vec<MapPoint> {
    corners.iter().map(|(x, y)| MapPoint::new(*x, *y)).collect()
}

#[test]
fn a_free_way_is_driven_to_its_end() {
    let costmap = ground(std::iter::empty());
    let path = points(&[(0.0, 0.0), (3.0, 0.5), (3.0, 3.0), (-2.0, 3.0)]);
    for make in FOLLOWERS {
        let (mut follower, mut pose, mut arrived) = (make(), Pose2::default(), false);
        for _ in 0..(60.0 / STEP) as usize {
            match follower.follow(&FollowInput { pose, path: &path, final_yaw: Some(0.0), costmap: &costmap })
            {
                Ok(Progress::Drive(v)) => pose = move_on(pose, v),
                Ok(Progress::Arrived) => arrived = true,
                Err(blocked) => panic!("{blocked} at {pose:?}"),
            }
        }
        assert!(arrived && pose.point().distance(path[3]) < 0.3 && pose.yaw.abs() < 0.15, "{pose:?}");
    }
}

#[test]
fn what_stands_in_the_way_is_not_touched_and_announced() {
    let costmap = ground((-100..=100).map(|i| MapPoint::new(2.0, f64::from(i) / 20.0)));
    let path = points(&[(0.0, 0.0), (4.0, 0.0)]);
    for make in FOLLOWERS {
        let (mut follower, mut pose, mut announced) = (make(), Pose2::default(), false);
        for _ in 0..(20.0 / STEP) as usize {
            match follower.follow(&FollowInput { pose, path: &path, final_yaw: None, costmap: &costmap }) {
                Ok(Progress::Drive(v)) => pose = move_on(pose, v),
                Ok(Progress::Arrived) => panic!("arrived behind a wall"),
                Err(blocked) => announced = matches!(blocked, Blocked::Obstacle(_)),
            }
        }
        let gap = 2.0 - pose.x;
        assert!(announced && gap > RobotDescription::sentry().inscribed_radius() && gap < 0.6, "{pose:?}");
    }
}

#[test]
fn without_a_way_nothing_is_driven() {
    let costmap = ground(std::iter::empty());
    let nowhere = Pose2::new(f64::NAN, 0.0, 0.0);
    let broken = points(&[(0.0, 0.0), (f64::INFINITY, 0.0)]);
    let plain = points(&[(0.0, 0.0), (1.0, 0.0)]);
    for make in FOLLOWERS {
        let here = Pose2::default();
        let (no_path, no_pose) = (Blocked::NoPath, Blocked::NoPose);
        for (pose, path, why) in
            [(here, &[][..], no_path), (here, &broken, no_path), (nowhere, &plain, no_pose)]
        {
            let input = FollowInput { pose, path, final_yaw: None, costmap: &costmap };
            assert_eq!(make().follow(&input), Err(why), "{pose:?} {path:?}");
        }
    }
}

proptest! {
    #[test]
    fn velocities_are_within_the_limits_and_repeat(
        corners in prop::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64), 1..6),
        (x, y, yaw) in (-9.0..9.0_f64, -9.0..9.0_f64, -4.0..4.0_f64),
    ) {
        let (robot, costmap) = (RobotDescription::sentry(), ground(std::iter::empty()));
        let (path, pose) = (points(&corners), Pose2::new(x, y, yaw));
        for make in FOLLOWERS {
            let decide = || make().follow(&FollowInput { pose, path: &path, final_yaw: Some(1.0), costmap: &costmap });
            prop_assert_eq!(decide(), decide());
            if let Ok(Progress::Drive(v)) = decide() {
                prop_assert!(v.linear <= robot.max_forward && v.linear >= -robot.max_backward, "{v:?}");
                prop_assert!(v.angular.abs() <= robot.max_turn, "{v:?}");
            }
        }
    }
}
