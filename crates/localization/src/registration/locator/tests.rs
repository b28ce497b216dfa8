//! Locators in towns of blocks, with exact sensors.

use openbench_geometry::Polygon;

use super::super::town::{block, map, village, way};
use super::*;

/// Poses along a road, five metres apart.
fn road(from: f64, y: f64, count: usize) -> Vec<Pose2> {
    let at = |i: usize| Pose2::new(from + 5.0 * i as f64, y, 0.05 * libm::sin(i as f64));
    (0..count).map(at).collect()
}

fn locator(houses: &[Polygon], start: Start) -> Locator {
    Locator::new(Arc::new(map(houses)), &start)
}

/// Drives along poses; gives what is accepted at each.
fn driven(locator: &mut Locator, houses: &[Polygon], poses: &[Pose2]) -> Vec<Option<Measured>> {
    let stretches = way(houses, poses);
    stretches
        .into_iter()
        .map(|stretch| locator.take(stretch))
        .collect()
}

#[test]
fn a_robot_that_knows_nothing_finds_itself_on_its_way() {
    let town = village(7);
    let poses = road(-40.0, 50.0, 12);
    let mut locator = locator(&town, Start::Anywhere);
    let found = driven(&mut locator, &town, &poses);
    let last = found.last().unwrap().as_ref().expect("it is localized");
    let truth = poses[poses.len() - 1];
    assert!(
        last.pose.point().distance(truth.point()) < 0.3,
        "{:?}",
        last.pose
    );
    for (located, truth) in found.iter().zip(&poses) {
        let error = located
            .as_ref()
            .map_or(0.0, |one| one.pose.point().distance(truth.point()));
        assert!(error < 0.5, "{error}");
    }
}

#[test]
fn in_another_town_nothing_is_accepted() {
    // The same rows of houses, but other houses; with more than one town, since in few of them
    // a good part of the houses is alike.
    let towns = (0..12).map(|i| (100 + i, 200 + i)).chain([(7, 8)]);
    for (driven_in, mapped) in towns {
        let mut locator = locator(&village(mapped), Start::Anywhere);
        let town = village(driven_in);
        let found = driven(&mut locator, &town, &road(-40.0, 50.0, 12));
        assert!(found.iter().all(Option::is_none), "{driven_in}: {found:#?}");
    }
}

#[test]
fn among_equal_houses_nothing_is_accepted() {
    // Two endless rows: each place is as all others.
    let row = |y: f64| (-20..20).map(move |i| block(f64::from(i) * 14.0, y, 8.0, 8.0));
    let houses: Vec<_> = row(-10.0).chain(row(10.0)).collect();
    let mut locator = locator(&houses, Start::Anywhere);
    let found = driven(&mut locator, &houses, &road(-30.0, 0.0, 12));
    assert!(found.iter().all(Option::is_none));
    assert_eq!(locator.presumed(), None);
}

#[test]
fn beside_a_single_house_nothing_is_accepted() {
    // From its opposite sides a rectangle looks the same.
    let house = [block(0.0, -12.0, 16.0, 9.0)];
    let mut locator = locator(&house, Start::Anywhere);
    let found = driven(&mut locator, &house, &road(-30.0, 0.0, 12));
    assert!(found.iter().all(Option::is_none), "{found:#?}");
}

#[test]
fn in_a_symmetric_courtyard_nothing_is_accepted() {
    let wide = [-20.0, 20.0].map(|y| block(0.0, y, 30.0, 8.0));
    let deep = [-20.0, 20.0].map(|x| block(x, 0.0, 8.0, 30.0));
    let court = [wide, deep].concat();
    let mut locator = locator(&court, Start::Anywhere);
    let found = driven(&mut locator, &court, &road(-9.0, 3.0, 4));
    assert!(found.iter().all(Option::is_none), "{found:#?}");
    // Each of the four sides is as good as the others.
    assert!(locator.hypotheses().len() >= 4);
    assert_eq!(locator.presumed(), None);
}

#[test]
fn among_ten_thousand_houses_it_finds_itself_within_a_block() {
    // Villages side by side.
    let village_at = |tile: u64| {
        let (x, y) = (160.0 * (tile % 16) as f64, 160.0 * (tile / 16) as f64);
        village(tile).into_iter().map(move |house| {
            let moved = |at: &MapPoint| MapPoint::new(at.x + x, at.y + y);
            Polygon::new(house.outer.iter().map(moved).collect(), Vec::new()).unwrap()
        })
    };
    let houses: Vec<_> = (0..256).flat_map(village_at).collect();
    assert!(houses.len() >= 10_000, "{}", houses.len());
    let poses = road(1240.0, 1330.0, 12);
    let start = Start::Area {
        centre: MapPoint::new(1280.0, 1300.0),
        radius_m: 75.0,
    };
    let mut locator = locator(&houses, start);
    // What it sees is near.
    let is_near = |house: &&Polygon| house.outer[0].distance(poses[6].point()) < 120.0;
    let near: Vec<Polygon> = houses.iter().filter(is_near).cloned().collect();
    driven(&mut locator, &near, &poses);
    let found = locator.estimate().expect("it is localized").pose;
    let error = found.point().distance(poses[11].point());
    assert!(error < 0.3, "{error}");
}

#[test]
fn what_is_only_probable_is_presumed_until_a_pose_is_accepted() {
    // The start says which of the equal houses it is, though not for sure.
    let row = |y: f64| (-20..20).map(move |i| block(f64::from(i) * 14.0, y, 8.0, 8.0));
    let houses: Vec<_> = row(-10.0).chain(row(10.0)).collect();
    let variance = |deviation: f64| deviation * deviation;
    let start = Start::Pose {
        pose: Pose2::new(-28.0, 1.0, 0.1),
        covariance: [
            [variance(5.0), 0.0, 0.0],
            [0.0, variance(5.0), 0.0],
            [0.0, 0.0, variance(0.2)],
        ],
    };
    let mut locator = locator(&houses, start);
    let poses = road(-30.0, 0.0, 4);
    let found = driven(&mut locator, &houses, &poses);
    assert!(found.iter().all(Option::is_none), "{found:#?}");
    let presumed = locator.presumed().expect("one house is the most probable");
    let away = presumed.pose.point().distance(poses[3].point());
    assert!(away < 0.5, "{away}");
    locator.lose();
    assert_eq!(locator.presumed(), None);
}

/// A robot that was carried to another road, while odometry went on, and what it sees there.
fn carried_away() -> (Locator, Vec<Stretch>) {
    let town = village(7);
    let start = Start::exact(Pose2::new(-40.0, 50.0, 0.0));
    let mut locator = locator(&town, start);
    driven(&mut locator, &town, &road(-40.0, 50.0, 8));
    assert!(locator.is_located());
    let carried = Pose2::new(35.0, 0.0, 0.0);
    let there = way(&town, &road(-30.0, 100.0, 16));
    let there = there.iter().map(|stretch| stretch.moved(carried)).collect();
    (locator, there)
}

/// The same way, on which nothing is seen that tells where it is.
fn blind(stretch: &Stretch) -> Stretch {
    Stretch {
        facades: Vec::new(),
        panoramas: Vec::new(),
        ..stretch.clone()
    }
}

/// After how many stretches it notices.
fn notices(locator: &mut Locator, there: Vec<Stretch>) -> Option<usize> {
    let mut noticed = None;
    for (number, stretch) in there.into_iter().enumerate() {
        locator.take(stretch);
        assert_eq!(locator.is_lost(), !locator.is_located());
        if locator.is_lost() {
            noticed = noticed.or(Some(number + 1));
        }
    }
    noticed
}

#[test]
fn a_robot_that_was_carried_away_notices() {
    let (mut locator, there) = carried_away();
    assert!(!locator.comparison().is_refused);
    let mut doubts = 0;
    for stretch in &there {
        locator.take(stretch.clone());
        if locator.is_lost() {
            break;
        }
        doubts += usize::from(locator.comparison().is_refused);
    }
    assert!(doubts >= DOUBTS - 1, "{doubts}");
    let (mut locator, there) = carried_away();
    let stretches = notices(&mut locator, there);
    assert!(
        stretches.is_some_and(|count| count >= DOUBTS),
        "{stretches:?}"
    );
}

#[test]
fn after_odometry_contradicted_itself_it_notices_at_once() {
    let (mut locator, there) = carried_away();
    locator.distrust();
    assert!(locator.is_located());
    assert_eq!(notices(&mut locator, there), Some(1));
}

#[test]
fn a_robot_that_is_not_found_is_searched_in_a_larger_area() {
    let (mut locator, there) = carried_away();
    locator.lose();
    let radius = |locator: &Locator| match locator.prior.unwrap().start() {
        Start::Area { radius_m, .. } => *radius_m,
        other => panic!("{other:?}"),
    };
    assert_eq!(radius(&locator), LOST_M);
    let way = there.iter().cycle().take(60).map(blind);
    let radii: Vec<f64> = way
        .map(|stretch| {
            locator.take(stretch);
            radius(&locator)
        })
        .collect();
    assert!(radii.contains(&(2.0 * LOST_M)));
    assert_eq!(radii.last(), Some(&(4.0 * LOST_M)));
}

#[test]
fn a_robot_that_was_carried_away_before_it_was_found_is_searched_farther_off() {
    let town = village(7);
    let mut locator = locator(&town, Start::exact(Pose2::new(-40.0, 50.0, 0.0)));
    let nothing = blind(&way(&town, &road(-40.0, 50.0, 1))[0]);
    assert_eq!(locator.look(&nothing), None);
    locator.lose();
    assert!(locator.is_lost());
    let there = road(-30.0, 100.0, 12);
    driven(&mut locator, &town, &there);
    let found = locator.estimate().expect("it is found").pose;
    let error = found.point().distance(there[11].point());
    assert!(error < 0.3, "{error}");
}

#[test]
fn a_robot_that_may_be_anywhere_still_may_when_it_is_lost() {
    let town = village(7);
    let mut locator = locator(&town, Start::Anywhere);
    locator.look(&blind(&way(&town, &road(-40.0, 50.0, 1))[0]));
    locator.lose();
    assert_eq!(locator.prior.unwrap().start(), &Start::Anywhere);
}

#[test]
fn walls_that_no_map_shows_do_not_end_what_is_known() {
    let town = village(7);
    let mut locator = locator(&town, Start::exact(Pose2::new(-40.0, 50.0, 0.0)));
    driven(&mut locator, &town, &road(-40.0, 50.0, 6));
    assert!(locator.is_located());
    // Further along the road, walls hide many of the houses.
    let wall = |i: usize, y: f64| block(-5.0 + 12.0 * i as f64, 50.0 + y, 9.0, 0.4);
    let walls = (0..8).flat_map(|i| [wall(i, -3.0), wall(i, 3.0)]);
    let walled: Vec<Polygon> = town.iter().cloned().chain(walls).collect();
    let (before, after) = (road(-40.0, 50.0, 6), road(-10.0, 50.0, 10));
    let odom = after[0].seen_from(before[0]);
    for stretch in way(&walled, &after) {
        locator.take(stretch.moved(odom));
        assert!(locator.is_located());
    }
}

#[test]
fn too_large_an_area_is_not_searched() {
    let far = [
        block(0.0, 0.0, 10.0, 10.0),
        block(9000.0, 9000.0, 10.0, 10.0),
    ];
    let mut anywhere = locator(&far, Start::Anywhere);
    driven(&mut anywhere, &far, &road(-20.0, 10.0, 2));
    assert!(anywhere.chart().is_none() && anywhere.comparisons() == 0);
    let mut here = locator(&far, Start::exact(Pose2::new(-20.0, 10.0, 0.0)));
    driven(&mut here, &far, &road(-20.0, 10.0, 2));
    assert_eq!(here.comparisons(), 2);
}

#[test]
fn without_buildings_or_a_start_nothing_is_accepted() {
    let town = village(7);
    let poses = road(-40.0, 50.0, 3);
    let nan = Start::exact(Pose2::new(f64::NAN, 0.0, 0.0));
    let mut none = locator(&town, nan);
    assert!(driven(&mut none, &town, &poses).iter().all(Option::is_none));
    let mut empty = locator(&[], Start::Anywhere);
    assert!(
        driven(&mut empty, &town, &poses)
            .iter()
            .all(Option::is_none)
    );
    let mut blind = locator(&town, Start::Anywhere);
    let mut nothing = way(&town, &poses[..1]).remove(0);
    nothing.facades.clear();
    nothing.panoramas.clear();
    assert_eq!(blind.look(&nothing), None);
    nothing.end = Pose2::new(f64::NAN, f64::NAN, f64::NAN);
    assert_eq!(blind.take(nothing), None);
}
