//! The points of a scan in the order of the cubes that they lie in.
//!
//! Points are sorted by a key of 64 bits. From the highest bit on it holds the largest cube's
//! number, then which part of each cube the next smaller one is, then the point's number. Points of
//! one cube of any size stand together then.

use nalgebra::{Isometry3, Vector3};

use crate::lio::planes::{CORNER_M, SIDES_M, SIZES};

/// Bits of a point's number.
const POINT_BITS: u32 = 31;
/// How often a largest cube is halved.
const SPLITS: u32 = SIZES as u32 - 1;
/// Bits of a largest cube's number along one axis.
const AXIS_BITS: u32 = 9;

/// Buffers for sorting, which are used again for each scan.
#[derive(Debug, Clone, Default)]
pub(super) struct CubeOrder {
    /// Where the points are in `odom`, as they came.
    unsorted_places: Vec<Vector3<f64>>,
    /// One for each point.
    pub(super) keys: Vec<u64>,
    /// The points in the LiDAR's frame.
    pub(super) points: Vec<Vector3<f64>>,
    /// Where they are in `odom`.
    pub(super) places: Vec<Vector3<f64>>,
}

impl CubeOrder {
    /// Sorts points of the LiDAR's frame about the robot's position in `odom`. Points hundreds of
    /// metres away are left out.
    pub(super) fn sort(
        &mut self,
        points: &[Vector3<f64>],
        lidar: &Isometry3<f64>,
        position: &Vector3<f64>,
    ) {
        let rotation = lidar.rotation.to_rotation_matrix();
        let corner = corner_about(position);
        self.unsorted_places.clear();
        self.keys.clear();
        for (number, point) in points.iter().enumerate().take(1 << POINT_BITS) {
            let place = rotation * point + lidar.translation.vector;
            self.unsorted_places.push(place);
            if let Some(cube) = cube_bits(place - corner) {
                // 27 bits of the largest cube, 3 for each of 2 splits and 31 of the point: 64 in
                // all.
                self.keys.push(cube << POINT_BITS | number as u64);
            }
        }
        // No two keys are equal, so the order does not depend on the algorithm.
        self.keys.sort_unstable();
        self.gather(points);
    }

    /// Puts points that are looked at together next to each other, and numbers them anew.
    fn gather(&mut self, points: &[Vector3<f64>]) {
        self.points.clear();
        self.places.clear();
        for (new, key) in self.keys.iter_mut().enumerate() {
            let old = point_number(*key);
            self.points.push(points[old]);
            self.places.push(self.unsorted_places[old]);
            // The number fills the lowest bits. New numbers rise with the keys, which therefore
            // stay sorted.
            *key = *key - old as u64 + new as u64;
        }
    }
}

/// The runs of keys whose points lie in the same cube of a size.
pub(super) fn cubes(keys: &[u64], size: usize) -> impl Iterator<Item = &[u64]> {
    // What is left of a key numbers the cubes of this size.
    let shift = POINT_BITS + 3 * (SPLITS - size as u32);
    keys.chunk_by(move |a, b| a >> shift == b >> shift)
}

/// The number of a key's point.
pub(super) fn point_number(key: u64) -> usize {
    (key & ((1 << POINT_BITS) - 1)) as usize
}

/// Corner of the region that the keys cover: the robot is in its middle.
fn corner_about(position: &Vector3<f64>) -> Vector3<f64> {
    let largest = SIDES_M[0];
    let cube = position.map(|x| libm::floor((x - CORNER_M) / largest) * largest + CORNER_M);
    cube.map(|x| x - f64::from(1 << (AXIS_BITS - 1)) * largest)
}

/// Bits of the smallest cube that holds a point, which is relative to the region's corner; `None`
/// outside the region.
fn cube_bits(point: Vector3<f64>) -> Option<u64> {
    let cell = point.map(|x| libm::floor(x / SIDES_M[SIZES - 1]));
    let end = f64::from(1 << (AXIS_BITS + SPLITS));
    let is_inside = cell.iter().all(|x| (0.0..end).contains(x));
    is_inside.then(|| interleaved(cell.map(|x| x as u64)))
}

/// A cell's coordinates as one number: the largest cube first, then the parts of each.
fn interleaved(cell: Vector3<u64>) -> u64 {
    // Without interleaving, since the points of one largest cube only need to be together.
    let mut bits = cell
        .iter()
        .fold(0, |bits, x| bits << AXIS_BITS | x >> SPLITS);
    // One bit an axis says which half: three bits say which eighth of the cube.
    for split in (0..SPLITS).rev() {
        bits = cell
            .iter()
            .fold(bits, |bits, x| bits << 1 | (x >> split & 1));
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_cube_stand_together_at_each_size() {
        let mut order = CubeOrder::default();
        let far = Vector3::new(9.2, 0.0, 0.0);
        let points = [
            Vector3::new(0.4, 0.4, 0.4),
            far,
            Vector3::new(0.5, 0.4, 0.4),
            Vector3::new(1.3, 0.4, 0.4),
            far,
            Vector3::new(1e6, 0.0, 0.0),
        ];
        order.sort(&points, &Isometry3::identity(), &Vector3::zeros());
        let sizes = |size| {
            cubes(&order.keys, size)
                .map(<[u64]>::len)
                .collect::<Vec<_>>()
        };
        assert_eq!(sizes(0), [3, 2]);
        assert_eq!(sizes(2), [2, 1, 2]);
        let numbers: Vec<_> = order.keys.iter().map(|key| point_number(*key)).collect();
        assert_eq!(numbers, [0, 1, 2, 3, 4]);
        assert_eq!(order.points[4], far);
    }
}
