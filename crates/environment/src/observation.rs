//! What a policy gets, as arrays.

use std::sync::Arc;

use openbench_core::{Health, Image, ImuSample, LidarScan, MapPoint, Pose2};

use crate::options::RangeImage;
use crate::range_image;

/// Samples of the IMU in a step of 50 ms.
pub const IMU_SAMPLES: usize = 5;

/// What a policy gets. Arrays that were not asked for are empty.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observation {
    /// The last image.
    pub image: Option<Arc<Image>>,
    /// The points of the last scan in `livox_frame`, metres: x, y, z of each.
    pub points: Vec<f32>,
    /// The last scan as an image of distances, metres, row by row.
    pub range_image: Vec<f32>,
    /// The samples since the last observation, oldest first: angular velocity, rad/s, and specific
    /// force, m/s², along x, y and z.
    pub imu: Vec<f32>,
    /// Speeds from the wheels: forward, m/s, and counter-clockwise, rad/s.
    pub wheels: [f32; 2],
    /// The estimated pose in `map`.
    pub pose: Option<Pose2>,
    /// How far the estimate can be trusted.
    pub health: Health,
    /// A goal that is a point, in the estimated frame of the robot, metres: forward, left.
    pub goal: Option<[f32; 2]>,
}

/// The points of a scan, one after the other.
pub fn points_of(scan: &LidarScan) -> Vec<f32> {
    scan.points.iter().flat_map(|point| point.xyz).collect()
}

/// A scan as an image of distances; without a scan, all far.
pub fn range_image_of(scan: Option<&LidarScan>, size: RangeImage) -> Vec<f32> {
    let mut pixels = vec![range_image::FARTHEST_M; size.rows * size.columns];
    if let Some(scan) = scan {
        range_image::fill(scan, size, &mut pixels);
    }
    pixels
}

/// The last samples of the IMU as rows of six; zeros before there are enough.
pub fn imu_of(samples: &[ImuSample], rows: usize) -> Vec<f32> {
    let mut values = vec![0.0; 6 * rows];
    let last = &samples[samples.len().saturating_sub(rows)..];
    let begin = rows - last.len();
    for (row, sample) in values[6 * begin..].chunks_exact_mut(6).zip(last) {
        for (value, measured) in row.iter_mut().zip(sample.gyro.iter().chain(&sample.accel)) {
            *value = *measured as f32;
        }
    }
    values
}

/// A place as a robot with that pose sees it.
pub fn seen_from(pose: Pose2, place: MapPoint) -> [f32; 2] {
    let (forward, left) = pose.inverse_transform(place);
    [forward as f32, left as f32]
}
