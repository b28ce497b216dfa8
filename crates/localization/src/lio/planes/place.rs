//! Cubes of the map's grid.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use nalgebra::Vector3;

/// How many sizes of cubes there are; each is half as large as the one before.
pub(in crate::lio) const SIZES: usize = 3;
/// Sides of cubes, metres. Where cubes of several sizes have a plane, the largest counts.
pub(in crate::lio) const SIDES_M: [f64; SIZES] = [1.0, 0.5, 0.25];
/// Corner of the grid on each axis, metres.
///
/// It keeps the ground that the robot stands on at the start, and all that is level with it, far
/// from the faces of cubes of each size. Noise would deal the points of a surface along a face to
/// both sides, and each side's plane would be tilted away from the surface.
pub(in crate::lio) const CORNER_M: f64 = 0.375;
/// Bits of a cube's number along one axis.
const AXIS_BITS: u32 = 21;
/// Cubes on each side of the origin along one axis.
const HALF: i64 = 1 << (AXIS_BITS - 1);

/// A cube of the map's grid of one size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Which size: 0 for the largest.
    pub size: usize,
    /// Which cube of that size.
    pub(super) number: u64,
    /// Its middle in `odom`, metres.
    pub middle: Vector3<f64>,
}

impl Place {
    /// The cube of a size that holds a point; `None` a million cubes from the origin.
    pub fn of(point: Vector3<f64>, size: usize) -> Option<Self> {
        let half = HALF as f64;
        let cell = point.map(|x| libm::floor((x - CORNER_M) / SIDES_M[size]));
        // NaN compares as false, and ends here too.
        if !cell.iter().all(|x| x.abs() < half) {
            return None;
        }
        let number = cell
            .iter()
            // Three axes of 21 bits fill 63 of 64.
            .fold(0, |number, x| number << AXIS_BITS | (x + half) as u64);
        Some(Self {
            size,
            number,
            middle: cell.map(|x| (x + 0.5) * SIDES_M[size] + CORNER_M),
        })
    }
}

/// Whether the middle of a cube of a size is within a distance of a place along each axis, metres.
pub(super) fn is_near(number: u64, side: f64, place: Vector3<f64>, distance: f64) -> bool {
    (0..3).all(|axis| {
        let shift = AXIS_BITS * (2 - axis as u32);
        let cell = (number >> shift & ((1 << AXIS_BITS) - 1)) as i64 - HALF;
        ((cell as f64 + 0.5) * side + CORNER_M - place[axis]).abs() <= distance
    })
}

/// Tables by the numbers of cubes.
pub(super) type ByCube<T> = HashMap<u64, T, BuildHasherDefault<NumberHasher>>;

/// Mixes the bits of a cube's number. The numbers come from our own arithmetic, so the hash needs
/// no protection against chosen keys.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct NumberHasher(u64);

impl Hasher for NumberHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes
            .iter()
            .for_each(|byte| self.write_u64(u64::from(*byte)));
    }

    fn write_u64(&mut self, number: u64) {
        // Fibonacci hashing: 2⁶⁴ over the golden ratio. A product mixes towards the high bits only,
        // and tables use the low ones as well: hence the shift.
        let mixed = (self.0 ^ number).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 = mixed ^ (mixed >> 32);
    }
}
