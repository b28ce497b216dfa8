//! Where the pixels of a lens with distortion look.

use openbench_core::{CameraIntrinsics, Distortion};

use super::block::SIDE;
use super::view::ImageSize;

/// Directions through the corners of an image's blocks, in `camera_link`, with x = 1. Within a
/// block they are interpolated: over eight pixels, distortion bends a line by hundredths of one.
#[derive(Debug, Clone)]
pub(crate) struct Lens {
    pub(super) size: ImageSize,
    /// Pixels for a distance of 1 m at 1 m.
    pub(crate) focal_length: f32,
    /// Corners in a row.
    columns: usize,
    /// To the left and up, row by row.
    corners: Vec<[f32; 2]>,
}

impl Lens {
    /// A lens with these intrinsics and a focal length that differs by the factor `focal`.
    pub(crate) fn new(optics: &CameraIntrinsics, focal: f64, distortion: Distortion) -> Self {
        let size = ImageSize::new(optics.width, optics.height);
        // Half of the width is seen under half of the field of view.
        let half = libm::tan(optics.horizontal_fov / 2.0) / focal;
        let bent = CameraIntrinsics {
            horizontal_fov: 2.0 * libm::atan(half),
            distortion,
            ..*optics
        };
        let along = |pixels: u32| pixels.div_ceil(SIDE as u32) + 1;
        let (columns, rows) = (along(size.width), along(size.height));
        let corner = |column: u32, row: u32| {
            // A pixel's middle is half a pixel from its edges.
            let [u, v] = [column, row].map(|at| f64::from(at * SIDE as u32) + 0.5);
            let [_, left, up] = bent.ray(u, v);
            [left as f32, up as f32]
        };
        let corners = (0..rows).flat_map(|row| (0..columns).map(move |column| corner(column, row)));
        Self {
            size,
            focal_length: bent.focal_length() as f32,
            columns: columns as usize,
            corners: corners.collect(),
        }
    }

    /// The lens in an image whose sides are smaller by `factor`.
    pub(crate) fn smaller(optics: &CameraIntrinsics, factor: u32) -> Self {
        let small = CameraIntrinsics {
            width: optics.width.div_ceil(factor),
            height: optics.height.div_ceil(factor),
            ..*optics
        };
        Self::new(&small, 1.0, Distortion::default())
    }

    /// Directions through the first pixel of the block at a column and row of blocks.
    #[inline(always)]
    pub(super) fn corner(&self, column: usize, row: usize) -> [f32; 2] {
        self.corners[row * self.columns + column]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::RobotDescription;

    #[test]
    fn directions_between_corners_are_those_of_the_pixels() {
        let optics = RobotDescription::sentry().camera_intrinsics;
        let distortion = Distortion {
            k1: -0.15,
            k2: 0.02,
            p1: 0.001,
            p2: 0.0,
        };
        let lens = Lens::new(&optics, 1.0, distortion);
        let bent = CameraIntrinsics {
            distortion,
            ..optics
        };
        for (column, row) in [(0, 0), (40, 30), (79, 59), (79, 2)] {
            let corners = [(0, 0), (1, 0), (0, 1), (1, 1)]
                .map(|(right, down)| lens.corner(column + right, row + down));
            let middle: f32 = corners.iter().map(|corner| corner[0]).sum::<f32>() / 4.0;
            let [u, v] = [column, row].map(|at| (SIDE * at) as f64 + 4.5);
            let off = f64::from(middle) - bent.ray(u, v)[1];
            assert!(
                off.abs() * optics.focal_length() < 0.05,
                "{column} {row}: {off}"
            );
        }
    }
}
