//! The points of a scan as if all were measured at its end.

use std::time::Duration;

use nalgebra::Vector3;
use openbench_core::{LidarPoint, LidarScan, SimTime};

use super::propagation::Node;
use super::state::State;

/// No LiDAR sees farther, metres.
const MAX_RANGE_M: f64 = 1e4;

/// Time of the last point of a scan.
pub(super) fn end_of(scan: &LidarScan) -> SimTime {
    // Points are nearly in the order of their time, not quite.
    let last = scan
        .points
        .iter()
        .map(|point| point.offset_ns)
        .max()
        .unwrap_or_default();
    scan.stamp + Duration::from_nanos(last.into())
}

/// The points of a scan that do not belong to the robot itself, as they were measured;
/// `min_range_m` is the distance up to which points do, metres.
pub(super) fn usable_points(scan: &LidarScan, min_range_m: f64) -> Vec<Vector3<f64>> {
    scan.points
        .iter()
        .map(position)
        .filter(|point| is_usable(point, min_range_m))
        .collect()
}

/// The usable points of a scan in the LiDAR's frame at its end: FAST-LIO, equation 10. `state` is
/// the one at the end, and `nodes` describe the motion that led to it.
pub(super) fn undistort(
    scan: &LidarScan,
    state: &State,
    nodes: &[Node],
    min_range_m: f64,
) -> Vec<Vector3<f64>> {
    let mut points = Vec::with_capacity(scan.points.len());
    let Some(first) = nodes.first() else {
        return points;
    };
    let mount = state.mount();
    let into_imu = mount.rotation.to_rotation_matrix();
    let at_end = state.lidar_pose();
    let motions: Vec<_> = nodes.iter().map(|node| node.relative_to(&at_end)).collect();
    let mut index = 0;
    for point in &scan.points {
        let measured = position(point);
        if !is_usable(&measured, min_range_m) {
            continue;
        }
        // Points from before the first node belong to the time of the last estimate, and count as
        // at the first node.
        let stamp = (scan.stamp + Duration::from_nanos(point.offset_ns.into())).max(first.stamp);
        index = node_at(nodes, stamp, index);
        let dt = stamp.since(nodes[index].stamp).as_secs_f64();
        let on_imu = into_imu * measured + mount.translation.vector;
        points.push(motions[index].transform(dt, on_imu));
    }
    points
}

/// Number of the last node at or before an instant. Points come in the order of their time, or
/// nearly, so the search begins at the node of the point before.
fn node_at(nodes: &[Node], stamp: SimTime, mut index: usize) -> usize {
    while index > 0 && nodes[index].stamp > stamp {
        index -= 1;
    }
    while nodes.get(index + 1).is_some_and(|next| next.stamp <= stamp) {
        index += 1;
    }
    index
}

fn position(point: &LidarPoint) -> Vector3<f64> {
    Vector3::from(point.xyz.map(f64::from))
}

fn is_usable(point: &Vector3<f64>, min_range_m: f64) -> bool {
    (min_range_m..=MAX_RANGE_M).contains(&point.norm())
}
