//! Scans without distortion, out of a log with the truth.

use std::error::Error;
use std::time::Duration;

use nalgebra::{Isometry3, Point3, Vector3};
use openbench_core::{Pose3, RobotDescription, SimTime};
use openbench_logs::LogReader;
use openbench_logs::messages::{Odometry, PointCloud2};

/// Nearer points are the robot's own, metres.
const BLIND: f32 = 0.3;

/// A scan in the LiDAR's frame of its end.
pub struct Scan {
    pub truth: Isometry3<f64>,
    pub points: Vec<Vector3<f64>>,
}

/// All scans of a log from when the robot has been put down.
pub fn read(path: &str) -> Result<Vec<Scan>, Box<dyn Error>> {
    let lidar = RobotDescription::sentry().lidar;
    let mut way = Vec::new();
    for message in LogReader::open(path)?.messages::<Odometry>("/ground_truth/odom") {
        let (stamp, odometry) = message?;
        way.push((
            stamp,
            odometry.pose.to_pose3().ok_or("a pose that is none")? * lidar,
        ));
    }
    let mut scans = Vec::new();
    for message in LogReader::open(path)?.messages::<PointCloud2>("/livox/lidar") {
        let scan = message?.1.to_scan()?;
        let end = scan.stamp + Duration::from_millis(100);
        let Some(truth) = at(&way, end).filter(|_| scan.stamp > SimTime::from_millis(1500)) else {
            continue;
        };
        let back = truth.inverse();
        let usable = scan
            .points
            .iter()
            .filter(|point| point.xyz.iter().map(|x| x * x).sum::<f32>() > BLIND * BLIND);
        let points = usable.filter_map(|point| {
            let there = at(
                &way,
                scan.stamp + Duration::from_nanos(point.offset_ns.into()),
            )?;
            Some((back * there * Point3::from(point.xyz.map(f64::from))).coords)
        });
        scans.push(Scan {
            truth,
            points: points.collect(),
        });
    }
    if scans.is_empty() {
        Err("no scans with the truth".into())
    } else {
        Ok(scans)
    }
}

/// The true pose at an instant, between two that are recorded.
fn at(way: &[(SimTime, Pose3)], time: SimTime) -> Option<Pose3> {
    let after = way.partition_point(|(stamp, _)| *stamp < time);
    let ((t0, a), (t1, b)) = (way.get(after.checked_sub(1)?)?, way.get(after)?);
    a.try_lerp_slerp(
        b,
        time.since(*t0).as_secs_f64() / t1.since(*t0).as_secs_f64(),
        1e-9,
    )
}
