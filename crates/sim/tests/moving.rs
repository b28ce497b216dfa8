//! People and cars as the robot's sensors and body meet them.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use openbench_core::{LidarScan, MapPoint, Pose2, RobotDescription, Velocity};
use openbench_osm::{OsmData, OsmMap};
use openbench_scene::{Layer, Material, Scene, SceneBuilder, SemanticClass};
use openbench_sim::traffic::{Mover, MoverKind, Traffic, TrafficPlan};
use openbench_sim::{Simulator, Stage};

/// Level ground of 400 m x 200 m.
fn ground() -> Scene {
    let mut builder = SceneBuilder::new();
    let grey = builder.material(Material::plain(SemanticClass::Ground, [0.5; 3]));
    let (x, y) = (Vector3::x() * 400.0, Vector3::y() * 200.0);
    builder.rectangle(
        Layer::Both,
        grey,
        Point3::new(-200.0, -100.0, 0.0),
        x,
        y,
        [1.0; 2],
    );
    builder.build()
}

/// A footway or a road of 100 m along x, from the origin.
fn street(highway: &str) -> OsmMap {
    let xml = format!(
        "<osm version='0.6'><node id='1' lon='0' lat='0'/><node id='2' lon='0.0008983' lat='0'/>\
         <way id='1'><nd ref='1'/><nd ref='2'/><tag k='highway' v='{highway}'/></way></osm>"
    );
    OsmMap::new(
        &OsmData::from_xml(xml.as_bytes()).unwrap(),
        "tangent:0,0".parse().unwrap(),
    )
}

/// A robot at `start` on a street with this traffic.
fn among(highway: &str, plan: TrafficPlan, start: Pose2, seed: u64) -> Simulator {
    let stage = Stage::with_figures(ground(), plan).unwrap();
    let traffic = Traffic::new(&street(highway), |_| true, plan, start.point(), seed);
    assert_eq!(traffic.placed(), plan);
    Simulator::new(stage, RobotDescription::sentry(), start, seed)
        .with_traffic(traffic)
        .unwrap()
}

fn people(pedestrians: usize) -> TrafficPlan {
    TrafficPlan {
        pedestrians,
        cars: 0,
    }
}

/// Points of a scan that lie well above the ground, in `map` by the robot's pose at the scan's end.
fn above_ground(simulator: &Simulator, scan: &LidarScan) -> Vec<MapPoint> {
    let sensor = simulator.base_link() * RobotDescription::sentry().lidar;
    let points = scan
        .points
        .iter()
        .map(|p| sensor * Point3::from(p.xyz.map(f64::from)));
    points
        .filter(|p| p.z > 0.15)
        .map(|p| MapPoint::new(p.x, p.y))
        .collect()
}

fn distance(mover: &Mover, point: MapPoint) -> f64 {
    mover.pose.point().distance(point)
}

#[test]
fn the_lidar_sees_people_in_place_and_nothing_else() {
    let mut simulator = among("footway", people(6), Pose2::new(50.0, 0.0, 0.0), 3);
    let mut seen = 0;
    for _ in 0..200 {
        simulator.step(Velocity::ZERO);
        let Some(scan) = simulator.observation().scan.cloned() else {
            continue;
        };
        for point in above_ground(&simulator, &scan) {
            let nearest = simulator
                .movers()
                .iter()
                .map(|m| distance(m, point))
                .fold(f64::INFINITY, f64::min);
            // Arms and feet swing up to 0.6 m from the middle; in the 0.1 s of a scan a person
            // walks 0.2 m.
            assert!(
                nearest < 0.85,
                "a point {nearest:.2} m from everybody at {}",
                simulator.time()
            );
            seen += 1;
        }
    }
    assert!(seen > 1000, "{seen}");
}

#[test]
fn the_camera_sees_a_passing_car() {
    let plan = TrafficPlan {
        pedestrians: 0,
        cars: 2,
    };
    let mut simulator = among("residential", plan, Pose2::new(50.0, -8.0, 1.57), 1);
    let mut images = Vec::new();
    for _ in 0..600 {
        simulator.step(Velocity::ZERO);
        let ahead = |m: &Mover| m.present && (m.pose.x - 50.0).abs() < 2.0;
        if simulator.movers().iter().any(ahead) == images.is_empty() {
            images.extend(simulator.observation().camera.image());
        }
        if images.len() == 2 {
            break;
        }
    }
    let [with, without] = images.as_slice() else {
        panic!("no car came by")
    };
    let differing = with
        .rgb
        .iter()
        .zip(&without.rgb)
        .filter(|(a, b)| a.abs_diff(**b) > 20)
        .count();
    assert!(differing > 5000, "{differing}");
}

#[test]
fn driving_into_people_is_a_collision_with_a_person() {
    // The passage is so narrow that nobody can step aside.
    let start = Pose2::new(40.0, 0.0, 0.0);
    let stage = Stage::with_figures(ground(), people(20)).unwrap();
    let narrow = |p: MapPoint| p.y.abs() < 0.3;
    let traffic = Traffic::new(&street("footway"), narrow, people(20), start.point(), 5);
    assert!(traffic.placed().pedestrians > 10);
    let mut simulator = Simulator::new(stage, RobotDescription::sentry(), start, 5)
        .with_traffic(traffic)
        .unwrap();
    for _ in 0..1200 {
        simulator.step(Velocity::new(0.5, 0.0));
    }
    let classes: Vec<SemanticClass> = simulator.collisions().iter().map(|c| c.class).collect();
    assert!(
        !classes.is_empty() && classes.iter().all(|c| *c == SemanticClass::Person),
        "{classes:?}"
    );
}

#[test]
fn driving_into_a_car_that_waits_is_a_collision_with_a_vehicle() {
    let plan = TrafficPlan {
        pedestrians: 0,
        cars: 3,
    };
    let mut simulator = among(
        "residential",
        plan,
        Pose2::new(50.0, -1.6, std::f64::consts::PI),
        2,
    );
    for _ in 0..1200 {
        simulator.step(Velocity::new(0.5, 0.0));
    }
    let classes: Vec<SemanticClass> = simulator.collisions().iter().map(|c| c.class).collect();
    assert!(
        !classes.is_empty() && classes.iter().all(|c| *c == SemanticClass::Vehicle),
        "{classes:?}"
    );
}

#[test]
fn cars_stop_for_the_robot() {
    let plan = TrafficPlan {
        pedestrians: 0,
        cars: 3,
    };
    let mut simulator = among("residential", plan, Pose2::new(50.0, 1.6, 0.0), 2);
    for _ in 0..1200 {
        simulator.step(Velocity::ZERO);
    }
    assert!(
        simulator.collisions().is_empty(),
        "{:?}",
        simulator.collisions()
    );
    assert!(
        simulator
            .robot_state()
            .position
            .distance(MapPoint::new(50.0, 1.6))
            < 0.1
    );
    assert!(simulator.movers().iter().all(|m| m.kind == MoverKind::Car));
}

/// Hash over the robot's states, scans and images in two seconds among people.
fn bytes(seed: u64) -> blake3::Hash {
    let mut simulator = among("footway", people(20), Pose2::new(50.0, 0.3, 0.4), seed);
    let mut hasher = blake3::Hasher::new();
    for i in 0..40 {
        simulator.step(Velocity::new(0.4, if i % 20 < 10 { 0.3 } else { -0.3 }));
        if let Some(image) = simulator.observation().camera.image() {
            hasher.update(&image.rgb);
        }
    }
    hasher.update(&simulator.hash_chain()).finalize()
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let alone: Vec<_> = (0..6).map(bytes).collect();
    let together: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..6)
            .map(|seed| scope.spawn(move || bytes(seed)))
            .collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect()
    });
    assert_eq!(alone, together);
    assert!((1..6).all(|i| alone[i] != alone[0]));
}

/// Every profile and every set of vector instructions gives the same bytes. A change of sensors,
/// noise, figures or traffic models changes them; the failure shows the new ones.
#[test]
fn builds_and_machines_give_the_same_bytes() {
    let expected = ["884b0a542f0c2542", "71f640750da95845", "9188e6aec4859015"];
    let found: Vec<String> = (100..103)
        .map(|seed| bytes(seed).to_hex()[..16].to_owned())
        .collect();
    assert_eq!(found, expected);
}

#[test]
fn a_stage_without_figures_takes_no_traffic() {
    let stage = Stage::new(openbench_scene::RayCaster::new(Arc::new(ground()))).unwrap();
    let traffic = Traffic::new(
        &street("footway"),
        |_| true,
        people(1),
        MapPoint::new(50.0, 0.0),
        1,
    );
    let simulator = Simulator::new(
        stage,
        RobotDescription::sentry(),
        Pose2::new(50.0, 0.0, 0.0),
        1,
    );
    assert!(simulator.with_traffic(traffic).is_err());
}
