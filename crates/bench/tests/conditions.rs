//! What makes a run harder than the paper's, and how it is scored.

use openbench_bench::suite::Condition;
use openbench_bench::{Prepared, Rollout, Suite, builtin_suite};
use openbench_core::{Action, Event, Health, MapPoint, Pose2, PoseEstimate, Start, Velocity};
use openbench_osm::Projection;
use openbench_osm::disturb::MapState;

fn suite(conditions: &[(&str, &str)], seed: u64) -> Suite {
    let mut suite = builtin_suite("small").unwrap();
    for (key, value) in conditions {
        suite.conditions.set(key, value).unwrap();
    }
    suite.with_seed(seed)
}

fn prepared(conditions: &[(&str, &str)], seed: u64) -> Prepared {
    Prepared::new(suite(conditions, seed), None).unwrap()
}

/// The error of an estimate at the start of an episode, metres.
fn error_of(prepared: &Prepared, estimate: Pose2) -> f64 {
    let mut rollout = Rollout::new(prepared, 0, 1).unwrap();
    rollout.record(Event::PoseEstimate(PoseEstimate {
        pose: estimate,
        health: Health::Good,
    }));
    let trace = rollout.finish(None).unwrap();
    trace.pose_errors[0].distance()
}

#[test]
fn agents_get_the_wrong_map_and_the_world_stays_as_it_is() {
    let right = prepared(&[], 3);
    let wrong = prepared(&[("map", "city")], 3);
    assert_eq!(wrong.world.map.to_xml(), right.world.map.to_xml());
    assert_eq!(wrong.approach, right.approach);
    let rollout = Rollout::new(&wrong, 0, 1).unwrap();
    assert_eq!(rollout.briefing().map_osm, wrong.public_data().to_xml());
    assert_ne!(rollout.briefing().map_osm, right.world.map.to_xml());
    // The same map for the same seed, another one for another.
    let again = prepared(&[("map", "city")], 3);
    assert_eq!(again.public_data().to_xml(), wrong.public_data().to_xml());
    let other = wrong.of_seed(4).unwrap().unwrap();
    assert_ne!(other.public_data().to_xml(), wrong.public_data().to_xml());
    assert!(wrong.of_seed(3).unwrap().is_none() && right.of_seed(4).unwrap().is_none());
}

#[test]
fn poses_are_measured_in_the_frame_of_the_public_map() {
    let wrong = prepared(&[("map.shift_m", "3"), ("map.rotation_deg", "2")], 5);
    let start = wrong.world.start;
    let on_map = wrong.on_map().pose(start);
    let shift = on_map.point().distance(start.point());
    assert!(shift > 0.5, "{shift}");
    assert!(error_of(&wrong, on_map) < 0.01);
    assert!((error_of(&wrong, start) - shift).abs() < 0.01);
    // An exact start is exact on the map that the agent has.
    let rollout = Rollout::new(&wrong, 0, 1).unwrap();
    assert_eq!(rollout.briefing().start, Start::exact(on_map));
}

#[test]
fn starts_are_given_as_the_suite_says() {
    let told = |level: &str, seed| {
        let prepared = prepared(&[("start", level)], 0);
        let at = prepared.on_map().pose(prepared.world.start);
        let rollout = Rollout::new(&prepared, 0, seed).unwrap();
        (at, rollout.briefing().start)
    };
    let (at, Start::Pose { pose, covariance }) = told("10m", 1) else {
        panic!("a pose is given")
    };
    assert_eq!(covariance[1][1], 100.0);
    let error = pose.point().distance(at.point());
    assert!((0.1..60.0).contains(&error), "{error}");
    assert_eq!(told("10m", 1), told("10m", 1));
    assert_ne!(told("10m", 1), told("10m", 2));
    assert!(matches!(told("block", 1).1, Start::Area { radius_m, .. } if radius_m == 75.0));
    assert_eq!(told("map", 1).1, Start::Anywhere);
}

#[test]
fn the_origin_does_not_tell_where_the_robot_starts() {
    let origin_from_start = |prepared: &Prepared| {
        let start = prepared.on_map().pose(prepared.world.start);
        start.point().distance(MapPoint::default())
    };
    let wrong: Vec<f64> = (0..20)
        .map(|seed| {
            let prepared = prepared(&[("map", "city")], seed);
            let rollout = Rollout::new(&prepared, 0, seed).unwrap();
            let georeference = rollout.briefing().georeference;
            assert_eq!(georeference, prepared.public_georeference());
            assert_ne!(georeference, prepared.world.georeference);
            origin_from_start(&prepared)
        })
        .collect();
    let near = wrong.iter().filter(|distance| **distance < 20.0).count();
    assert!(near <= 2, "{wrong:?}");
    // It follows from the public map, so it tells nothing about the seed of the run.
    let vague = |seed| prepared(&[("start", "map")], seed);
    assert!(origin_from_start(&vague(1)) > 1.0);
    assert_eq!(
        vague(1).public_georeference(),
        vague(2).public_georeference()
    );
    assert_ne!(vague(1).public_georeference(), vague(1).world.georeference);
}

#[test]
fn satellite_fixes_are_in_the_frame_that_agents_have() {
    let fix = |conditions: &[(&str, &str)]| {
        let mut suite = suite(conditions, 3);
        suite.sensors.gnss = true;
        let prepared = Prepared::new(suite, None).unwrap();
        let mut rollout = Rollout::new(&prepared, 0, 3).unwrap();
        loop {
            rollout.step(Action::Drive(Velocity::ZERO));
            if let Some(fix) = rollout.observation().gnss {
                let at = MapPoint::new(fix.position[0], fix.position[1]);
                let georeference = rollout.briefing().georeference;
                return Projection::new(georeference).to_lonlat(at);
            }
        }
    };
    // The same place on the Earth, whatever the frame and whatever is wrong with the map.
    let (told, hidden) = (fix(&[]), fix(&[("start", "map")]));
    let wrong = fix(&[("map.shift_m", "5")]);
    for other in [hidden, wrong] {
        assert!((told.lon - other.lon).abs() < 1e-9 && (told.lat - other.lat).abs() < 1e-9);
    }
}

#[test]
fn buildings_that_get_a_delivery_are_mapped_at_levels_below_poor() {
    let states = |prepared: &Prepared| -> Vec<MapState> {
        let targets = prepared.episodes.iter().flat_map(|e| &e.targets);
        let doors = targets.filter_map(|target| target.door);
        doors
            .map(|door| prepared.on_map().state(prepared.building(door)))
            .collect()
    };
    let keep = prepared(&[("map", "city"), ("map.missing", "0.99")], 1);
    assert!(states(&keep).iter().all(MapState::is_right));
    let poor = prepared(&[("map", "poor"), ("map.wrong_numbers", "0.9")], 1);
    assert!(!states(&poor).iter().all(MapState::is_right));
}

#[test]
fn a_map_without_buildings_is_refused() {
    let conditions = [("map", "poor"), ("map.missing", "1")];
    let refused = Prepared::new(suite(&conditions, 1), None).err().unwrap();
    let error = openbench_core::with_causes(&refused);
    assert!(
        error.contains("[map] missing = 1: none of the map's 3 buildings"),
        "{error}"
    );
}

#[test]
fn what_is_off_is_not_in_suites() {
    assert_eq!(suite(&[], 9), builtin_suite("small").unwrap());
    let hard = suite(&[("map", "city")], 9);
    assert_eq!(hard.conditions.map.level(), Some("city"));
    assert!(hard.to_toml().contains("map = \"city\""));
}
