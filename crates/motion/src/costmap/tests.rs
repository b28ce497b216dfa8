use super::*;
use crate::costmap::map_server::Occupancy;
use crate::obstacles::{Beam, ScanPoint};
use openbench_core::{Georeference, LonLat};
use openbench_geometry::Polygon;
use openbench_osm::{Area, Barrier, ElementId, ElementKind, OsmData};

pub(crate) fn empty_map() -> OsmMap {
    OsmMap::new(
        &OsmData::default(),
        Georeference::tangent_plane(LonLat::new(8.0, 50.0)),
    )
}

pub(crate) fn open_ground() -> Costmap {
    let (low, high) = (MapPoint::new(-10.0, -10.0), MapPoint::new(10.0, 10.0));
    Costmap::new(&empty_map(), low, high, &RobotDescription::sentry()).unwrap()
}

pub(crate) fn see_wall(costmap: &mut Costmap, from: MapPoint, to: MapPoint) {
    let points = (0..=200).map(|i| {
        let t = f64::from(i) / 200.0;
        ScanPoint::new(
            MapPoint::new(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)),
            0.3,
        )
    });
    costmap.observe(&RangeRing::new(MapPoint::default(), 0.25, points));
    costmap.inflate();
}

#[test]
fn kerbs_block_except_where_a_road_leads_over_them() {
    let line = |points: [(f64, f64); 2]| points.map(|(x, y)| MapPoint::new(x, y)).to_vec();
    let mut map = empty_map();
    let kerb = [("barrier", "kerb")].into_iter().collect();
    map.barriers.push(Barrier {
        way: 1,
        points: line([(-8.0, 0.0), (8.0, 0.0)]),
        gates: vec![],
        tags: kerb,
    });
    let path = [("highway", "footway")].into_iter().collect();
    let points = line([(2.0, -9.0), (2.0, 9.0)]);
    map.roads.push(openbench_osm::Road {
        way: 2,
        nodes: vec![1, 2],
        points,
        tags: path,
    });
    let (low, high) = (MapPoint::new(-10.0, -10.0), MapPoint::new(10.0, 10.0));
    let costmap = Costmap::new(&map, low, high, &RobotDescription::sentry()).unwrap();
    let closed = |x: f64| costmap.is_obstacle(costmap.grid.cell_at(MapPoint::new(x, 0.0)).unwrap());
    assert!(closed(-5.0) && closed(6.0) && !closed(2.0) && !closed(1.3));
}

#[test]
fn a_seen_obstacle_blocks_until_beams_pass_through_it() {
    let mut costmap = open_ground();
    see_wall(
        &mut costmap,
        MapPoint::new(2.0, -1.0),
        MapPoint::new(2.0, 1.0),
    );
    let beside = costmap.grid().cell_at(MapPoint::new(1.9, 0.0)).unwrap();
    assert_eq!(costmap.cost(beside), None);
    assert!(!costmap.is_clear(MapPoint::new(0.0, 0.0), MapPoint::new(4.0, 0.0)));
    // The wall has gone: beams reach the ground behind it.
    let ground = |i: i32| ScanPoint::new(MapPoint::new(5.0, f64::from(i) / 20.0), 0.0);
    for _ in 0..12 {
        costmap.observe(&RangeRing::new(
            MapPoint::default(),
            0.25,
            (-60..60).map(ground),
        ));
    }
    assert!(costmap.is_clear(MapPoint::new(0.0, 0.0), MapPoint::new(4.0, 0.0)));
}

#[test]
fn an_obstacle_that_is_not_seen_for_a_minute_is_forgotten() {
    let mut costmap = open_ground();
    see_wall(
        &mut costmap,
        MapPoint::new(2.0, -1.0),
        MapPoint::new(2.0, 1.0),
    );
    let wall = costmap.grid().cell_at(MapPoint::new(2.0, 0.0)).unwrap();
    let elsewhere = || {
        RangeRing::new(
            MapPoint::new(-9.0, 0.0),
            0.25,
            std::iter::once(ScanPoint::new(MapPoint::new(-9.5, 0.0), 0.3)),
        )
    };
    for (scans, is_known) in [(599, true), (2, false)] {
        (0..scans).for_each(|_| costmap.observe(&elsewhere()));
        costmap.inflate();
        assert_eq!(
            (costmap.is_obstacle(wall), costmap.cost(wall).is_none()),
            (is_known, is_known)
        );
    }
}

#[test]
fn costs_fall_from_the_inscribed_circle_to_beyond_the_circumscribed_one() {
    let mut costmap = open_ground();
    see_wall(
        &mut costmap,
        MapPoint::new(2.05, -10.0),
        MapPoint::new(2.05, 10.0),
    );
    let robot = Footprint::of(&RobotDescription::sentry()).unwrap();
    let costs: Vec<(f64, Option<f64>)> = (0..20)
        .map(|i| MapPoint::new(1.95 - 0.1 * f64::from(i), 0.05))
        .map(|p| {
            (
                costmap.clearance_at(p),
                costmap.cost(costmap.grid().cell_at(p).unwrap()),
            )
        })
        .collect();
    for (clearance, cost) in &costs {
        assert_eq!(
            cost.is_none(),
            *clearance < robot.inscribed() + MARGIN_M,
            "{clearance} {cost:?}"
        );
        assert_eq!(
            *cost == Some(1.0),
            *clearance >= robot.circumscribed() + COMFORT_M - 0.1,
            "{clearance} {cost:?}"
        );
    }
    let known: Vec<f64> = costs.iter().filter_map(|(_, cost)| *cost).collect();
    assert!(
        known[0] > 5.0 && known.windows(2).all(|w| w[0] >= w[1]),
        "{known:?}"
    );
}

#[test]
fn a_low_obstacle_stays_though_beams_pass_over_it() {
    let mut costmap = open_ground();
    // A kerb of 12 cm, seen from afar; then the robot stands before it, and its lowest beam
    // reaches the ground behind.
    let kerb =
        (0..=40).map(|i| ScanPoint::new(MapPoint::new(2.0, f64::from(i) * 0.05 - 1.0), 0.12));
    costmap.observe(&RangeRing::new(MapPoint::default(), 0.25, kerb));
    let behind = |i: i32| ScanPoint::new(MapPoint::new(3.7, f64::from(i) / 30.0), 0.0);
    for _ in 0..30 {
        costmap.observe(&RangeRing::new(
            MapPoint::new(1.4, 0.0),
            0.25,
            (-60..60).map(behind),
        ));
    }
    assert!(!costmap.is_clear(MapPoint::new(1.4, 0.0), MapPoint::new(3.0, 0.0)));
}

#[test]
fn missing_ground_stays_though_beams_pass_over_it() {
    let mut costmap = open_ground();
    // A light well from x = 2 m on, whose floor the beams reach; later they pass over it.
    let floor = |i: i32| ScanPoint::new(MapPoint::new(3.0, f64::from(i) * 0.05 - 1.0), -0.12);
    let beyond = |i: i32| ScanPoint::new(MapPoint::new(5.0, f64::from(i) / 30.0), 0.0);
    costmap.observe(&RangeRing::new(
        MapPoint::default(),
        0.25,
        (0..=40).map(floor),
    ));
    for _ in 0..30 {
        let ring = RangeRing::new(MapPoint::default(), 0.25, (-60..60).map(beyond));
        costmap.observe(&ring);
    }
    assert!(!costmap.is_clear(MapPoint::new(1.0, 0.0), MapPoint::new(4.0, 0.0)));
    assert!(costmap.is_clear(MapPoint::new(-1.0, 0.0), MapPoint::new(1.0, 0.0)));
}

#[test]
fn water_stays_though_beams_pass_over_it_and_the_robot_is_in_it() {
    let mut map = empty_map();
    let corners =
        [(2.0, -9.0), (9.0, -9.0), (9.0, 9.0), (2.0, 9.0)].map(|(x, y)| MapPoint::new(x, y));
    map.areas.push(Area {
        element: ElementId {
            kind: ElementKind::Way,
            id: 1,
        },
        polygon: Polygon::new(corners.to_vec(), vec![]).unwrap(),
        tags: [("natural", "water")].into_iter().collect(),
    });
    let (low, high) = (MapPoint::new(-10.0, -10.0), MapPoint::new(10.0, 10.0));
    let mut costmap = Costmap::new(&map, low, high, &RobotDescription::sentry()).unwrap();
    let beyond = |i: i32| ScanPoint::new(MapPoint::new(9.5, f64::from(i) / 20.0), 0.0);
    for _ in 0..12 {
        costmap.observe(&RangeRing::new(
            MapPoint::default(),
            0.25,
            (-60..60).map(beyond),
        ));
    }
    let is_clear =
        |costmap: &Costmap, x: f64| costmap.is_clear(MapPoint::new(x, 0.0), MapPoint::new(x, 0.0));
    assert!(is_clear(&costmap, 0.0) && !is_clear(&costmap, 5.0));
    let robot = Footprint::of(&RobotDescription::sentry()).unwrap();
    let at = Pose2::new(5.0, 0.0, 0.0);
    costmap.clear_below(&robot, at);
    assert!(costmap.is_obstacle(costmap.grid().cell_at(at.point()).unwrap()));
}

#[test]
fn a_costmap_is_written_and_read_again() {
    let mut costmap = open_ground();
    see_wall(
        &mut costmap,
        MapPoint::new(2.0, -1.0),
        MapPoint::new(2.0, 1.0),
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ground.yaml");
    map_server::write(&path, &costmap.occupancy()).unwrap();
    let read = map_server::read(&path).unwrap();
    let again = Costmap::from_occupancy(&read, &RobotDescription::sentry()).unwrap();
    assert_eq!(again.grid(), costmap.grid());
    let blocked = |costmap: &Costmap| {
        (0..costmap.grid().len())
            .map(|c| costmap.cost(c).is_none())
            .collect::<Vec<_>>()
    };
    assert!(blocked(&again).contains(&true));
    assert_eq!(blocked(&again), blocked(&costmap));
}

#[test]
fn grids_that_cannot_be_used_are_refused() {
    let robot = RobotDescription::sentry();
    let grid = GridGeometry {
        origin: MapPoint::default(),
        width: 2,
        height: 1,
        cell: 0.1,
    };
    let sound = Occupancy {
        grid,
        yaw: 0.0,
        cells: vec![64, 65],
    };
    let costmap = Costmap::from_occupancy(&sound, &robot).unwrap();
    assert!(!costmap.is_obstacle(0) && costmap.is_obstacle(1));
    for cell in [0.0, 1e-300, f64::NAN, f64::INFINITY] {
        let odd = Occupancy {
            grid: GridGeometry { cell, ..grid },
            ..sound.clone()
        };
        assert_eq!(
            Costmap::from_occupancy(&odd, &robot).unwrap_err(),
            CostmapError::NoGrid(2, 1)
        );
    }
    let nowhere = GridGeometry {
        origin: MapPoint::new(f64::NAN, 0.0),
        ..grid
    };
    let nowhere = Occupancy {
        grid: nowhere,
        ..sound.clone()
    };
    assert_eq!(
        Costmap::from_occupancy(&nowhere, &robot).unwrap_err(),
        CostmapError::NoGrid(2, 1)
    );
    let empty = Occupancy {
        grid: GridGeometry { width: 0, ..grid },
        yaw: 0.0,
        cells: vec![],
    };
    assert_eq!(
        Costmap::from_occupancy(&empty, &robot).unwrap_err(),
        CostmapError::NoGrid(0, 1)
    );
    let few = Occupancy {
        cells: vec![0],
        ..sound.clone()
    };
    assert_eq!(
        Costmap::from_occupancy(&few, &robot).unwrap_err(),
        CostmapError::NoGrid(2, 1)
    );
    let turned = Occupancy { yaw: 0.5, ..sound };
    assert_eq!(
        Costmap::from_occupancy(&turned, &robot).unwrap_err(),
        CostmapError::Turned(0.5)
    );
}

#[test]
fn a_beam_without_an_end_is_cut_off() {
    let mut costmap = open_ground();
    let mut ring = RangeRing::new(MapPoint::default(), 0.25, std::iter::empty());
    ring.beams = vec![
        Beam {
            reach: f64::INFINITY,
            end_height: 0.0,
        },
        Beam {
            reach: f64::NAN,
            end_height: 0.0,
        },
    ];
    costmap.observe(&ring);
    assert!(costmap.is_clear(MapPoint::default(), MapPoint::new(5.0, 0.0)));
}

#[test]
fn impossible_areas_robots_and_preferences_are_refused() {
    let robot = RobotDescription::sentry();
    for (low, high) in [
        ((0.0, 0.0), (0.0, 5.0)),
        ((f64::NAN, 0.0), (1.0, 1.0)),
        ((5.0, 0.0), (0.0, 5.0)),
    ] {
        let corner = |c: (f64, f64)| MapPoint::new(c.0, c.1);
        let refused = Costmap::new(&empty_map(), corner(low), corner(high), &robot);
        assert!(matches!(refused, Err(CostmapError::NoArea { .. })));
    }
    let (low, high) = (MapPoint::default(), MapPoint::new(1.0, 1.0));
    for width in [f64::NAN, -1.0, 0.0] {
        let robot = RobotDescription {
            width,
            ..RobotDescription::sentry()
        };
        let refused = Costmap::new(&empty_map(), low, high, &robot);
        assert!(matches!(refused, Err(CostmapError::Robot(_))));
    }
    let odd = Preferences {
        road: 0.5,
        ..Preferences::NONE
    };
    let refused = Costmap::with_preferences(&empty_map(), low, high, &robot, odd);
    assert!(matches!(refused, Err(CostmapError::Preferences(_))));
}

#[test]
fn clearance_is_euclidean() {
    let mut costmap = open_ground();
    see_wall(
        &mut costmap,
        MapPoint::new(3.05, 0.05),
        MapPoint::new(3.05, 0.05),
    );
    let clearance = costmap.clearance_at(MapPoint::new(0.05, 4.05));
    assert!((clearance - 5.0).abs() < 1e-6, "{clearance}");
}
