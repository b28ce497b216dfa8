//! Blocks of pixels that are cast and coloured together, in tiles of one packet each.

use openbench_scene::bvh::LANES;

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

/// Place in its block of a pixel.
pub(super) const fn pixel(column: usize, row: usize) -> usize {
    let tile = row / TILE * (SIDE / TILE) + column / TILE;
    LANES * tile + row % TILE * TILE + column % TILE
}
