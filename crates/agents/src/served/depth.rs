//! A depth image out of LiDAR scans, for policies of robots with a depth camera.

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::Point3;
use openbench_core::{LidarScan, Pose2, RobotDescription};
use openbench_localization::Localizer;

/// How many scans are seen together: half a second.
const SCANS: usize = 5;
/// How long a scan lasts.
const SCAN_TIME: Duration = Duration::from_millis(100);
/// Pixels on each side of a point that have its depth: the next points are further apart.
const REACH: i64 = 2;

/// Depths along the axis of the camera, metres, rows from the top; 0 where nothing was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthImage {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` depths.
    pub metres: Vec<f32>,
}

/// The newest scans as points in `map`, with heights over the ground.
#[derive(Debug, Clone)]
pub struct RecentScans {
    robot: RobotDescription,
    scans: VecDeque<Vec<Point3<f64>>>,
}

impl RecentScans {
    /// None yet.
    pub fn new(robot: RobotDescription) -> Self {
        Self {
            robot,
            scans: VecDeque::new(),
        }
    }

    /// Takes in a scan. The localizer has taken it in before.
    pub fn take(&mut self, scan: &LidarScan, localizer: &dyn Localizer) {
        let first = localizer.pose_at(scan.stamp);
        let last = localizer.pose_at(scan.stamp + SCAN_TIME);
        let moved = first.inverse_transform(last.point());
        let turned = openbench_core::frames::wrap_angle(last.yaw - first.yaw);
        let in_map = |point: &openbench_core::LidarPoint| {
            // Each point at the place where the robot was when it was measured.
            let share = f64::from(point.offset_ns) / SCAN_TIME.as_nanos() as f64;
            let way = Pose2::new(share * moved.0, share * moved.1, share * turned);
            let at = Point3::from(point.xyz.map(f64::from));
            first.compose(way).to_pose3(0.0) * (self.robot.lidar * at)
        };
        let points = scan.points.iter().map(in_map).collect();
        self.scans.truncate(SCANS - 1);
        self.scans.push_front(points);
    }

    /// What the camera of a robot at this pose would see of them; the nearest point counts.
    pub fn depth(&self, pose: Pose2) -> DepthImage {
        let intrinsics = self.robot.camera_intrinsics;
        let (width, height) = (intrinsics.width as usize, intrinsics.height as usize);
        let mut metres = vec![0.0_f32; width * height];
        let to_camera = (pose.to_pose3(0.0) * self.robot.camera).inverse();
        for point in self.scans.iter().flatten() {
            let seen = to_camera * point;
            let Some((u, v)) = intrinsics.project([seen.x, seen.y, seen.z]) else {
                continue;
            };
            let depth = seen.x as f32;
            for row in around(v, height) {
                for pixel in &mut metres[row * width..][around(u, width)] {
                    if *pixel == 0.0 || depth < *pixel {
                        *pixel = depth;
                    }
                }
            }
        }
        DepthImage {
            width,
            height,
            metres,
        }
    }
}

/// The pixels about a coordinate, of so many.
fn around(at: f64, length: usize) -> std::ops::Range<usize> {
    let middle = at as i64;
    let within = |pixel: i64| pixel.clamp(0, length as i64) as usize;
    within(middle - REACH)..within(middle + REACH + 1)
}

#[cfg(test)]
mod tests {
    use openbench_core::{LidarPoint, SimTime};
    use openbench_localization::LidarInertial;

    use super::*;

    fn scan(points: impl IntoIterator<Item = [f32; 3]>) -> LidarScan {
        let point = |xyz| LidarPoint {
            xyz,
            offset_ns: 0,
            reflectivity: 100,
            line: 0,
        };
        LidarScan {
            stamp: SimTime::ZERO,
            points: points.into_iter().map(point).collect(),
        }
    }

    #[test]
    fn a_wall_ahead_has_its_distance_from_the_camera() {
        let robot = RobotDescription::sentry();
        let mut localizer = LidarInertial::new(robot.clone());
        let pose = Pose2::new(30.0, -20.0, 1.0);
        localizer.reset(pose);
        let mut scans = RecentScans::new(robot);
        // Four metres before the LiDAR, which is 3 cm behind the camera and lower than it.
        scans.take(&scan([[4.0, 0.0, 0.0], [-4.0, 0.0, 0.0]]), &localizer);
        let depth = scans.depth(pose);
        let middle = depth.metres[242 * depth.width + 320];
        assert!((middle - 3.97).abs() < 1e-3, "{middle}");
        // Behind it there is nothing to see.
        let seen = depth.metres.iter().filter(|metres| **metres > 0.0).count();
        assert_eq!(seen as i64, (2 * REACH + 1).pow(2));
    }

    #[test]
    fn the_nearer_of_two_points_counts_and_old_scans_are_forgotten() {
        let robot = RobotDescription::sentry();
        let mut localizer = LidarInertial::new(robot.clone());
        localizer.reset(Pose2::default());
        let mut scans = RecentScans::new(robot);
        scans.take(&scan([[2.0, 0.0, 0.0], [4.0, 0.0, 0.0]]), &localizer);
        let depth = |scans: &RecentScans| {
            let depth = scans.depth(Pose2::default());
            // Both points reach this pixel.
            depth.metres[244 * depth.width + 320]
        };
        assert!((depth(&scans) - 1.97).abs() < 1e-3);
        for _ in 0..SCANS {
            scans.take(&scan([]), &localizer);
        }
        assert_eq!(depth(&scans), 0.0);
    }
}
