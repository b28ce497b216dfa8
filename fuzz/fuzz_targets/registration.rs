#![no_main]
//! Registration to the map among whatever map, start, odometry and LiDAR say. Numbers are of a size
//! that happens, or any.

use std::fmt::Write;
use std::sync::Arc;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use openbench_core::{
    Camera, Image, LidarPoint, LidarScan, MapPoint, Observation, Pose2, Pose3, SimTime, Start,
};
use openbench_fuzz::number;
use openbench_localization::registration::Registrar;
use openbench_localization::{FixSource, Track};
use openbench_osm::{OsmData, OsmMap, Projection};

/// Height of the LiDAR, metres.
const LIDAR_M: f64 = 0.5;

fn pose(input: &mut Unstructured<'_>, size: f64) -> Result<Pose2> {
    Ok(Pose2 {
        x: number(input, size)?,
        y: number(input, size)?,
        yaw: number(input, 3.2)?,
    })
}

fn start(input: &mut Unstructured<'_>) -> Result<Start> {
    Ok(match input.int_in_range(0..=2)? {
        0 => Start::Anywhere,
        1 => Start::Area {
            centre: pose(input, 100.0)?.point(),
            radius_m: number(input, 75.0)?,
        },
        _ => {
            let mut covariance = [[0.0; 3]; 3];
            for value in covariance.iter_mut().flatten() {
                *value = number(input, 10.0)?;
            }
            Start::Pose {
                pose: pose(input, 100.0)?,
                covariance,
            }
        }
    })
}

/// Buildings of three to six corners. `None` where a corner is nowhere on Earth.
fn map(input: &mut Unstructured<'_>) -> Result<Option<OsmMap>> {
    let place = "utm:31N,-500000,0".parse().expect("it is a georeference");
    let projection = Projection::new(place);
    let (mut nodes, mut ways) = (String::new(), String::new());
    for house in 0..input.int_in_range(0..=40_u32)? {
        let middle = pose(input, 100.0)?;
        let mut way = String::new();
        let corners = input.int_in_range(3..=6_u32)?;
        for corner in 0..corners {
            let turn = f64::from(corner) / f64::from(corners) * std::f64::consts::TAU;
            let reach = number(input, 12.0)?;
            let (sine, cosine) = (middle.yaw + turn).sin_cos();
            let at = MapPoint::new(middle.x + reach * cosine, middle.y + reach * sine);
            let at = projection.to_lonlat(at);
            let id = 10 * house + corner + 1;
            let _ = writeln!(
                nodes,
                r#"<node id="{id}" lat="{}" lon="{}"/>"#,
                at.lat, at.lon
            );
            let _ = write!(way, r#"<nd ref="{id}"/>"#);
        }
        let _ = writeln!(
            ways,
            r#"<way id="{}">{way}<nd ref="{}"/><tag k="building" v="house"/></way>"#,
            house + 1,
            10 * house + 1
        );
    }
    let xml = format!(r#"<osm version="0.6">{nodes}{ways}</osm>"#);
    let data = OsmData::from_xml(xml.as_bytes());
    Ok(data.ok().map(|data| OsmMap::new(&data, place)))
}

/// Walls of a few metres about the robot, the ground before them, and points anywhere.
fn scan(input: &mut Unstructured<'_>, stamp: SimTime) -> Result<LidarScan> {
    let mut points = Vec::new();
    let mut put = |xyz: [f64; 3]| {
        points.push(LidarPoint {
            xyz: xyz.map(|value| value as f32),
            offset_ns: 10_000 * points.len() as u32,
            reflectivity: 0,
            line: 0,
        });
    };
    for _ in 0..input.int_in_range(0..=12)? {
        let (from, to) = (pose(input, 40.0)?, pose(input, 20.0)?);
        for step in 0..60 {
            let along = f64::from(step) / 60.0;
            let (x, y) = (from.x + along * to.x, from.y + along * to.y);
            put([0.5 * x, 0.5 * y, -LIDAR_M]);
            for level in 0..8 {
                put([x, y, 0.4 * f64::from(level) - LIDAR_M]);
            }
        }
    }
    for _ in 0..input.int_in_range(0..=4)? {
        let height = number(input, 4.0)?;
        let at = pose(input, 60.0)?;
        put([at.x, at.y, height]);
    }
    Ok(LidarScan { stamp, points })
}

struct Blind;

impl Camera for Blind {
    fn image(&self) -> Option<Arc<Image>> {
        None
    }
}

struct Still(Pose2);

impl Track for Still {
    fn pose3_at(&self, _: SimTime) -> Pose3 {
        self.0.to_pose3(0.0)
    }
}

fn run(input: &mut Unstructured<'_>) -> Result<()> {
    let start = start(input)?;
    let Some(map) = map(input)? else {
        return Ok(());
    };
    let mut registrar = Registrar::new(Arc::new(map), start, Pose3::translation(0.0, 0.0, LIDAR_M));
    let (mut odom, mut stamp) = (Pose2::default(), SimTime::ZERO);
    for _ in 0..60 {
        if input.is_empty() {
            break;
        }
        let step = pose(input, 3.0)?;
        odom = Pose2 {
            x: odom.x + step.x,
            y: odom.y + step.y,
            yaw: odom.yaw + step.yaw,
        };
        stamp = SimTime(stamp.0 + 100_000_000);
        match input.int_in_range(0..=60)? {
            0 => registrar.lose(),
            1 => registrar.distrust(),
            2 => registrar.reset(),
            _ => {}
        }
        let scan = scan(input, stamp)?;
        let observation = Observation {
            time: stamp,
            imu: &[],
            wheels: &[],
            scan: Some(&scan),
            gnss: None,
            camera: &Blind,
        };
        if let Some(fix) = registrar.update(&observation, Pose2::default(), &Still(odom)) {
            let at = fix.pose;
            let numbers = at.translation.vector.iter().chain(fix.information.iter());
            assert!(numbers.copied().all(f64::is_finite), "{fix:?}");
            assert!(at.rotation.angle().is_finite(), "{fix:?}");
            let least = fix.information.symmetric_eigenvalues().min();
            assert!(least >= -1e-6 * fix.information.norm(), "{fix:?}");
        }
        let _ = registrar.comparison();
    }
    Ok(())
}

fuzz_target!(|bytes: &[u8]| {
    let _ = run(&mut Unstructured::new(bytes));
});
