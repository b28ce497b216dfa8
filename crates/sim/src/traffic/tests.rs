//! People in a corridor, cars that meet people and the robot, and built-in neighbourhoods.

use openbench_osm::{OsmData, OsmMap};
use openbench_scene::generate::{builtin, builtin_georeference};
use openbench_scene::{FreeSpace, RayCaster};
use std::sync::Arc;

use super::hull::CarHull;
use super::*;

pub(super) const DT: f64 = 0.05;
pub(super) const NOBODY: RobotState = RobotState {
    position: MapPoint::new(-200.0, 0.0),
    velocity: [0.0; 2],
    radius: 0.22,
};

/// A map of one straight way along x, 100 m long.
pub(super) fn street(tags: &str) -> OsmMap {
    let xml = format!(
        "<osm version='0.6'><node id='1' lon='0' lat='0'/><node id='2' lon='0.0008983' lat='0'/>\
         <way id='1'><nd ref='1'/><nd ref='2'/>{tags}</way></osm>"
    );
    let origin = "tangent:0,0".parse().unwrap();
    OsmMap::new(&OsmData::from_xml(xml.as_bytes()).unwrap(), origin)
}

pub(super) fn tag(key: &str, value: &str) -> String {
    format!("<tag k='{key}' v='{value}'/>")
}

fn medium(plan: TrafficPlan, seed: u64) -> Traffic {
    neighbourhood("medium", plan, seed)
}

fn neighbourhood(name: &str, plan: TrafficPlan, seed: u64) -> Traffic {
    let world = builtin(name, 1).unwrap().unwrap();
    let map = OsmMap::new(&world.map, builtin_georeference());
    let caster = RayCaster::new(Arc::new(world.scene));
    let space = FreeSpace::new(&caster, world.start.point(), PERSON_RADIUS_M);
    Traffic::new(
        &map,
        |p| space.is_reachable(p),
        plan,
        world.start.point(),
        seed,
    )
}

/// Deepest overlap of any two movers, metres: of two people, a person and a car, two cars.
pub(super) fn overlaps(movers: &[Mover]) -> [f64; 3] {
    let mut deepest = [0.0_f64; 3];
    for (i, a) in movers.iter().enumerate().filter(|(_, m)| m.present) {
        for b in movers[i + 1..].iter().filter(|m| m.present) {
            let (k, depth) = match (a.hull, b.hull) {
                (Hull::Disc { radius: r }, Hull::Disc { radius: q }) => {
                    (0, r + q - a.pose.point().distance(b.pose.point()))
                }
                (Hull::Disc { radius }, Hull::Box { .. }) => {
                    let car = CarHull::new(b.pose, 0.0);
                    (1, radius - car.distance(a.pose.point()))
                }
                _ => (2, boxes_overlap(a.pose, b.pose)),
            };
            deepest[k] = deepest[k].max(depth);
        }
    }
    deepest
}

/// Overlap of two cars along the axis on which it is least (separating axes), metres.
fn boxes_overlap(a: Pose2, b: Pose2) -> f64 {
    let axes = [a.yaw, b.yaw]
        .into_iter()
        .flat_map(|yaw| [yaw, yaw + std::f64::consts::FRAC_PI_2]);
    let reach = |yaw: f64, axis: f64| {
        let (sin, cos) = libm::sincos(yaw - axis);
        CAR_HALF_LENGTH_M * cos.abs() + CAR_HALF_WIDTH_M * sin.abs()
    };
    let along = |axis: f64| {
        let (sin, cos) = libm::sincos(axis);
        ((b.x - a.x) * cos + (b.y - a.y) * sin).abs()
    };
    axes.map(|axis| reach(a.yaw, axis) + reach(b.yaw, axis) - along(axis))
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn a_map_without_roads_has_no_traffic() {
    let map = street(&tag("barrier", "fence"));
    let plan = TrafficPlan {
        pedestrians: 5,
        cars: 5,
    };
    let mut traffic = Traffic::new(&map, |_| true, plan, MapPoint::default(), 1);
    assert_eq!(traffic.placed(), TrafficPlan::default());
    traffic.step(DT, NOBODY);
    assert!(traffic.movers().is_empty());
}

#[test]
fn all_people_get_through_a_corridor_with_counter_flow() {
    // 100 m long, 3 m wide between walls; half the people come from each end.
    let map = street(&(tag("highway", "footway") + &tag("width", "3")));
    let free = |p: MapPoint| p.y.abs() < 1.5 - PERSON_RADIUS_M && (-1.0..101.0).contains(&p.x);
    let plan = TrafficPlan {
        pedestrians: 24,
        cars: 0,
    };
    let mut traffic = Traffic::new(&map, free, plan, MapPoint::new(0.0, 50.0), 3);
    assert_eq!(traffic.placed().pedestrians, 24);
    let ends = [
        traffic.pedestrians.end_at(MapPoint::new(0.0, 0.0)),
        traffic.pedestrians.end_at(MapPoint::new(100.0, 0.0)),
    ];
    for i in 0..24 {
        let from = MapPoint::new(
            if i % 2 == 0 {
                1.0 + i as f64
            } else {
                100.0 - i as f64
            },
            0.5 * (i % 3) as f64 - 0.5,
        );
        traffic.pedestrians.send(i, from, ends[(i + 1) % 2]);
    }
    traffic.pedestrians.update_neighbours();
    let mut arrived = [false; 24];
    let mut deepest = 0.0_f64;
    for _ in 0..3000 {
        traffic.step(DT, NOBODY);
        for (i, mover) in traffic.movers().iter().enumerate() {
            arrived[i] |= if i % 2 == 0 {
                mover.pose.x > 90.0
            } else {
                mover.pose.x < 10.0
            };
        }
        deepest = deepest.max(overlaps(traffic.movers())[0]);
    }
    assert!(arrived.iter().all(|a| *a), "{arrived:?}");
    assert!(deepest < 0.05, "{deepest}");
}

#[test]
fn a_car_stops_for_a_robot_and_goes_on_when_it_is_gone() {
    let map = street(&(tag("highway", "residential") + &tag("oneway", "yes")));
    let plan = TrafficPlan {
        pedestrians: 0,
        cars: 1,
    };
    let mut traffic = Traffic::new(&map, |_| true, plan, MapPoint::new(100.0, 0.0), 5);
    assert_eq!(traffic.placed().cars, 1);
    let x = traffic.movers()[0].pose.x;
    let stop = RobotState {
        position: MapPoint::new(x + 25.0, 0.0),
        velocity: [0.0; 2],
        radius: 0.22,
    };
    (0..400).for_each(|_| traffic.step(DT, stop));
    let car = traffic.movers()[0];
    let gap = measures::distance(&stop, &car);
    assert!(
        car.present && (0.5..3.0).contains(&gap) && car.velocity[0] < 0.05,
        "{gap} {car:?}"
    );
    (0..60).for_each(|_| traffic.step(DT, NOBODY));
    assert!(traffic.movers()[0].pose.x > car.pose.x + 3.0);
}

#[test]
fn a_car_lets_a_person_cross_and_goes_on() {
    let map = street(&(tag("highway", "residential") + &tag("oneway", "yes")));
    let plan = TrafficPlan {
        pedestrians: 1,
        cars: 1,
    };
    let mut traffic = Traffic::new(&map, |_| true, plan, MapPoint::new(100.0, 0.0), 5);
    assert_eq!(traffic.placed(), plan);
    let x = traffic.movers()[1].pose.x;
    // A person stands on the carriageway for ten seconds.
    let end = traffic.pedestrians.end_at(MapPoint::new(x + 25.0, 3.6));
    traffic
        .pedestrians
        .send(0, MapPoint::new(x + 25.0, -0.5), end);
    traffic.pedestrians.pace(0, 0.0);
    traffic.pedestrians.update_neighbours();
    let (mut slowest, mut went_on) = (f64::INFINITY, false);
    for i in 0..500 {
        if i == 200 {
            traffic.pedestrians.pace(0, 1.3);
        }
        traffic.step(DT, NOBODY);
        let movers = traffic.movers();
        slowest = if movers[1].present {
            slowest.min(movers[1].velocity[0])
        } else {
            slowest
        };
        assert!(overlaps(movers)[1] < 0.01);
        went_on |= movers[1].pose.x > x + 30.0;
    }
    assert!(slowest < 0.1 && went_on, "{slowest} {went_on}");
}

#[test]
fn traffic_of_a_built_in_neighbourhood_moves_for_a_minute() {
    let plan = TrafficPlan {
        pedestrians: 50,
        cars: 20,
    };
    let mut traffic = medium(plan, 1);
    assert_eq!(traffic.placed(), plan);
    let before: Vec<Mover> = traffic.movers().to_vec();
    let mut last = before.clone();
    let mut walked = vec![0.0; before.len()];
    let mut deepest = [0.0_f64; 3];
    for _ in 0..1200 {
        traffic.step(DT, NOBODY);
        for ((mover, last), walked) in traffic.movers().iter().zip(&last).zip(&mut walked) {
            let speed = libm::hypot(mover.velocity[0], mover.velocity[1]);
            assert!(
                mover.pose.x.is_finite() && mover.pose.y.is_finite() && mover.pose.yaw.is_finite()
            );
            let fastest = if mover.kind == MoverKind::Car {
                30.0 / 3.6 + 0.2
            } else {
                2.7
            };
            assert!(speed <= fastest, "{mover:?}");
            if mover.present && last.present {
                *walked += mover.pose.point().distance(last.pose.point());
                let change = (speed - libm::hypot(last.velocity[0], last.velocity[1])) / DT;
                assert!(
                    mover.kind != MoverKind::Car || (-8.1..1.6).contains(&change) || speed == 0.0,
                    "{change}"
                );
            }
            assert!(mover.kind == MoverKind::Car || traffic.ground.fits(mover.pose.point()));
        }
        let now = overlaps(traffic.movers());
        (0..3).for_each(|k| deepest[k] = deepest[k].max(now[k]));
        last.copy_from_slice(traffic.movers());
    }
    assert!(
        deepest[0] < 0.05 && deepest[1] < 0.05 && deepest[2] < 0.05,
        "{deepest:?}"
    );
    let moved = walked[..50].iter().filter(|w| **w > 20.0).count();
    assert!(moved >= 48, "{moved} of 50 people walked on: {walked:?}");
    let drove = walked[50..].iter().filter(|w| **w > 20.0).count();
    assert!(drove >= 12, "{drove} of 20 cars drove: {:?}", &walked[50..]);
}

#[test]
fn nobody_is_run_over_whatever_the_place_and_the_seed() {
    let plan = TrafficPlan {
        pedestrians: 60,
        cars: 15,
    };
    for (name, seed) in [("small", 2), ("medium", 3), ("large", 4), ("large", 5)] {
        let mut traffic = neighbourhood(name, plan, seed);
        let mut deepest = [0.0_f64; 3];
        // The robot stands in the path of one mover, then of another.
        for i in 0..2400 {
            let other = traffic.movers()[i / 400].pose.point();
            let robot = RobotState {
                position: MapPoint::new(other.x + 1.0, other.y),
                ..NOBODY
            };
            traffic.step(DT, if i % 400 < 200 { robot } else { NOBODY });
            let now = overlaps(traffic.movers());
            (0..3).for_each(|k| deepest[k] = deepest[k].max(now[k]));
        }
        assert!(
            deepest[0] < 0.05 && deepest[1] < 0.05 && deepest[2] < 0.05,
            "{name} {seed}: {deepest:?}"
        );
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let plan = TrafficPlan {
        pedestrians: 20,
        cars: 8,
    };
    let run = |seed| {
        let mut traffic = medium(plan, seed);
        (0..200).for_each(|_| traffic.step(DT, NOBODY));
        format!("{:?}", traffic.movers())
    };
    assert_eq!(run(7), run(7));
    assert_ne!(run(7), run(8));
}

#[test]
fn broken_steps_and_robots_do_no_harm() {
    let mut traffic = medium(
        TrafficPlan {
            pedestrians: 10,
            cars: 4,
        },
        1,
    );
    let broken = RobotState {
        position: MapPoint::new(f64::NAN, 0.0),
        velocity: [f64::INFINITY; 2],
        radius: -1.0,
    };
    for dt in [f64::NAN, -1.0, 0.0, f64::INFINITY, 1e9, 1e-12] {
        traffic.step(dt, broken);
    }
    assert!(
        traffic
            .movers()
            .iter()
            .all(|m| m.pose.x.is_finite() && m.velocity[0].is_finite())
    );
}
