//! Blocks of pixels that are cast and coloured together, in tiles of one packet each.

use openbench_scene::bvh::LANES;

use super::view::ImageSize;

/// Side of the square of pixels that one packet covers.
pub(super) const TILE: usize = 4;
/// Side of the block of pixels that are cast and coloured together.
pub(super) const SIDE: usize = 8;
/// Pixels in a block.
pub(super) const BLOCK: usize = SIDE * SIDE;
/// Packets in a block.
pub(super) const PACKETS: usize = BLOCK / LANES;
/// A number for each pixel of a block, tile after tile.
pub(super) type Block = [f32; BLOCK];
/// Columns and rows of a block's pixels.
pub(super) const PLACES: [Block; 2] = {
    let mut places = [[0.0; BLOCK]; 2];
    let mut i = 0;
    while i < BLOCK {
        let (column, row) = (i % SIDE, i / SIDE);
        places[0][pixel(column, row)] = column as f32;
        places[1][pixel(column, row)] = row as f32;
        i += 1;
    }
    places
};

/// Index of a pixel within its block.
pub(super) const fn pixel(column: usize, row: usize) -> usize {
    // A packet is a square tile rather than a row of pixels: its rays stay closer together.
    let tile = row / TILE * (SIDE / TILE) + column / TILE;
    LANES * tile + row % TILE * TILE + column % TILE
}

/// The top left pixel of a block in an image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    pub(super) x: u32,
    pub(super) y: u32,
}

impl Corner {
    /// Corners of the blocks that cover an image, row by row.
    pub(super) fn covering(size: ImageSize) -> impl Iterator<Item = Self> {
        let columns = move |y| (0..size.width).step_by(SIDE).map(move |x| Self { x, y });
        (0..size.height).step_by(SIDE).flat_map(columns)
    }

    /// Columns of the block that lie inside an image.
    #[inline(always)]
    pub(super) fn columns(self, size: ImageSize) -> usize {
        SIDE.min((size.width - self.x) as usize)
    }

    /// Rows of the block that lie inside an image.
    #[inline(always)]
    pub(super) fn rows(self, size: ImageSize) -> usize {
        SIDE.min((size.height - self.y) as usize)
    }

    /// Index in an image, rows from the top, of the block's pixel at `column` and `row`.
    #[inline(always)]
    pub(super) fn index(self, size: ImageSize, column: usize, row: usize) -> usize {
        (self.y as usize + row) * size.width as usize + self.x as usize + column
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_each_pixel_of_an_image_once() {
        let size = ImageSize::new(19, 10);
        let mut covered = vec![0; size.pixels()];
        for corner in Corner::covering(size) {
            for row in 0..corner.rows(size) {
                for column in 0..corner.columns(size) {
                    covered[corner.index(size, column, row)] += 1;
                }
            }
        }
        assert!(covered.iter().all(|count| *count == 1));
        assert_eq!(Corner::covering(ImageSize::new(0, 5)).count(), 0);
    }
}
