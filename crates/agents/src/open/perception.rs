//! LiDAR scans in the `map` frame.

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::Point3;
use openbench_core::{LidarScan, MapPoint, Pose2, RobotDescription, SimTime};
use openbench_localization::Localizer;
use openbench_motion::{RangeRing, ScanPoint};

/// How long scans are kept.
const MEMORY: Duration = Duration::from_millis(1000);
/// Points within this time share a pose: the robot moves 5 mm in it.
const STRETCH_NS: u32 = 10_000_000;

/// The scans of the last second, undistorted: x and y in `map`, z above the robot's ground.
#[derive(Debug)]
pub struct Perception {
    robot: RobotDescription,
    scans: VecDeque<(SimTime, Vec<Point3<f32>>)>,
}

impl Perception {
    /// No scans yet.
    pub fn new(robot: RobotDescription) -> Self {
        Self {
            robot,
            scans: VecDeque::new(),
        }
    }

    /// Adds a scan, corrected for the robot's motion during it, and returns it as ranges around the
    /// LiDAR.
    pub fn observe(&mut self, scan: &LidarScan, localizer: &dyn Localizer) -> RangeRing {
        let mut points = Vec::with_capacity(scan.points.len());
        let (mut stretch, mut pose) = (u32::MAX, nalgebra::Isometry3::identity());
        for point in &scan.points {
            // One pose for each run of points of the same stretch, not one for each point.
            if point.offset_ns / STRETCH_NS != stretch {
                stretch = point.offset_ns / STRETCH_NS;
                // The pose in the middle of the stretch halves the largest error of its points.
                let middle = Duration::from_nanos(u64::from(stretch * STRETCH_NS + STRETCH_NS / 2));
                pose = (localizer.pose_at(scan.stamp + middle).to_pose3(0.0) * self.robot.lidar)
                    .cast::<f32>();
            }
            points.push(pose * Point3::from(point.xyz));
        }
        let lidar = self.robot.lidar.translation.vector;
        // The points are undistorted by now, as if seen from where the LiDAR is at the end of the
        // scan.
        let center = localizer.pose().transform(lidar.x, lidar.y);
        let flat = points.iter().map(|p| {
            ScanPoint::new(
                MapPoint::new(f64::from(p.x), f64::from(p.y)),
                f64::from(p.z),
            )
        });
        let ring = RangeRing::new(center, lidar.z, flat);
        self.scans.push_back((scan.stamp, points));
        while self
            .scans
            .front()
            .is_some_and(|(stamp, _)| scan.stamp.since(*stamp) >= MEMORY)
        {
            self.scans.pop_front();
        }
        ring
    }

    /// All points that are kept.
    pub fn points(&self) -> impl Iterator<Item = &Point3<f32>> {
        self.scans.iter().flat_map(|(_, points)| points)
    }

    /// The camera's pose in the frame of the points, for a robot at `base`.
    pub fn camera_pose(&self, base: Pose2) -> nalgebra::Isometry3<f64> {
        base.to_pose3(0.0) * self.robot.camera
    }
}
