//! A scan as an image of distances.

use std::f32::consts::{PI, TAU};

use openbench_core::LidarScan;

use crate::options::RangeImage;

/// Distance where a scan shows nothing, metres: the LiDAR's range.
pub const FARTHEST_M: f32 = 50.0;
/// Lowest and highest elevation of the LiDAR's rays, radians: -7 and 52 degrees.
const ELEVATION: [f32; 2] = [-7.0 / 180.0 * PI, 52.0 / 180.0 * PI];

/// The distance of the nearest return in each cell, metres, row by row. Rows go from the highest
/// rays to the lowest, columns from behind the robot by its left, front and right.
pub fn fill(scan: &LidarScan, size: RangeImage, pixels: &mut [f32]) {
    pixels.fill(FARTHEST_M);
    let [low, high] = ELEVATION;
    let rows_per_radian = size.rows as f32 / (high - low);
    let columns_per_radian = size.columns as f32 / TAU;
    for point in &scan.points {
        let [x, y, z] = point.xyz;
        let flat = (x * x + y * y).sqrt();
        let distance = (flat * flat + z * z).sqrt();
        let row = (high - libm::atan2f(z, flat)) * rows_per_radian;
        let column = (PI - libm::atan2f(y, x)) * columns_per_radian;
        // Rounded off at the edges, where a ray may be a little outside.
        let row = (row.max(0.0) as usize).min(size.rows - 1);
        let column = (column.max(0.0) as usize).min(size.columns - 1);
        let pixel = &mut pixels[row * size.columns + column];
        *pixel = pixel.min(distance);
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::LidarPoint;

    use super::*;

    const SIZE: RangeImage = RangeImage {
        rows: 4,
        columns: 8,
    };

    fn image(points: &[[f32; 3]]) -> Vec<f32> {
        let point = |xyz: &[f32; 3]| LidarPoint {
            xyz: *xyz,
            offset_ns: 0,
            reflectivity: 0,
            line: 0,
        };
        let scan = LidarScan {
            points: points.iter().map(point).collect(),
            ..LidarScan::default()
        };
        let mut pixels = vec![0.0; SIZE.rows * SIZE.columns];
        fill(&scan, SIZE, &mut pixels);
        pixels
    }

    #[test]
    fn the_nearest_return_of_a_cell_counts() {
        let pixels = image(&[[4.0, -0.1, 0.0], [3.0, -0.1, 0.0], [9.0, -0.1, 0.0]]);
        let near: Vec<usize> = (0..pixels.len()).filter(|i| pixels[*i] < 49.0).collect();
        // Level rays are in the lowest row; right of ahead begins the second half of it.
        assert_eq!(near, [3 * 8 + 4]);
        assert!((pixels[near[0]] - 3.0).abs() < 0.01);
    }

    #[test]
    fn columns_go_from_behind_by_the_left() {
        let column = |x: f32, y: f32| {
            let pixels = image(&[[x, y, 0.0]]);
            pixels.iter().position(|pixel| *pixel < 49.0).unwrap() % 8
        };
        assert_eq!(column(-1.0, 0.1), 0);
        assert_eq!(column(-0.1, 1.0), 1);
        assert_eq!(column(1.0, 0.1), 3);
        assert_eq!(column(0.1, -1.0), 5);
        assert_eq!(column(-1.0, -0.1), 7);
    }

    #[test]
    fn an_empty_scan_is_far_everywhere() {
        assert!(image(&[]).iter().all(|pixel| *pixel == FARTHEST_M));
    }
}
