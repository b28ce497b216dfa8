//! From the light of a picture to its bytes: motion blur, vignetting, noise, the tone curve.

use openbench_scene::bvh::{Kernel, widest};

use super::block::SIDE;
use super::lens::Lens;
use super::planes::{LightPlanes, MARGIN};
use crate::rounding::whole;

/// Pixels of a block.
const PIXELS: usize = SIDE * SIDE;
/// A number for each pixel of a block, row by row.
type Rows = [f32; PIXELS];
/// Most samples along a pixel's path.
const MOST_TAPS: usize = 16;
/// Longest path of a pixel while the shutter is open, pixels: twice the margin.
const LONGEST_PATH: f32 = 2.0 * (MARGIN as f32 - 1.0);
/// A shorter path blurs nothing.
const SHORTEST_PATH: f32 = 0.5;

/// Movement of the camera while the shutter is open, in its own axes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Movement {
    /// Rotation vector, radians.
    pub(crate) turn: [f32; 3],
    /// Metres.
    pub(crate) shift: [f32; 3],
}

/// How the light of a picture becomes an image.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Development<'a> {
    pub(crate) lens: &'a Lens,
    pub(crate) movement: Movement,
    /// Factor on the light, of exposure and gain together.
    pub(crate) factor: f32,
    /// Variance of the signal for each unit of it: photons that come by chance. 1 is white.
    pub(crate) shot: f32,
    /// Variance of a black signal.
    pub(crate) read: f32,
    /// Share of the light that the corners lose.
    pub(crate) vignetting: f32,
    /// Random numbers of this image.
    pub(crate) key: [u32; 2],
}

/// The image of a picture's light: RGB, rows from the top.
pub(crate) fn develop(planes: &LightPlanes, development: Development<'_>) -> Vec<u8> {
    let mut rgb = vec![0; 3 * planes.size.pixels()];
    widest(Developing {
        planes,
        development,
        rgb: &mut rgb,
    });
    rgb
}

/// An image that is being developed.
struct Developing<'a> {
    planes: &'a LightPlanes,
    development: Development<'a>,
    rgb: &'a mut [u8],
}

impl Kernel for Developing<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            planes,
            development,
            rgb,
        } = self;
        let rows = (planes.size.height as usize).div_ceil(SIDE);
        for row in 0..rows {
            for column in 0..planes.columns {
                let path = development.path(planes, column, row);
                let mut light = blurred(planes, [column, row], path);
                development.weaken_edges(planes, [column, row], &mut light);
                development.add_noise(planes, [column, row], &mut light);
                put(rgb, planes, [column, row], &light);
            }
        }
    }
}

/// Way of a block's content over the image, pixels to the right and down.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Path {
    right: f32,
    down: f32,
}

impl Development<'_> {
    /// Way of what a block shows, from the camera's movement and the block's depth: the optical
    /// flow of a standing world (Longuet-Higgins and Prazdny 1980).
    #[inline(always)]
    fn path(&self, planes: &LightPlanes, column: usize, row: usize) -> Path {
        let near = planes.nearness[row * planes.columns + column];
        let (first, last) = (
            self.lens.corner(column, row),
            self.lens.corner(column + 1, row + 1),
        );
        let (left, up) = (0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1]));
        let ([wx, wy, wz], [vx, vy, vz]) = (self.movement.turn, self.movement.shift);
        // A point (1, left, up) / near moves by minus the shift and minus turn × point.
        let ahead = -vx * near - (wy * up - wz * left);
        let to_left = -vy * near - (wz - wx * up) - left * ahead;
        let upwards = -vz * near - (wx * left - wy) - up * ahead;
        let f = self.lens.focal_length;
        let (right, down) = (-f * to_left, -f * upwards);
        let length = (right * right + down * down).sqrt();
        // False for NaN as well.
        let shortened = if length <= LONGEST_PATH {
            1.0
        } else {
            LONGEST_PATH / length
        };
        Path {
            right: right * shortened,
            down: down * shortened,
        }
    }

    /// Vignetting grows with the square of the distance from the middle.
    #[inline(always)]
    fn weaken_edges(&self, planes: &LightPlanes, at: [usize; 2], light: &mut [Rows; 3]) {
        if self.vignetting <= 0.0 {
            return;
        }
        let (width, height) = (planes.size.width as f32, planes.size.height as f32);
        let corner = 0.25 * (width * width + height * height);
        let mut share = [0.0; PIXELS];
        for (i, share) in share.iter_mut().enumerate() {
            let x = (SIDE * at[0] + i % SIDE) as f32 + 0.5 - 0.5 * width;
            let y = (SIDE * at[1] + i / SIDE) as f32 + 0.5 - 0.5 * height;
            *share = 1.0 - self.vignetting * (x * x + y * y) / corner;
        }
        for channel in light {
            for (light, share) in channel.iter_mut().zip(&share) {
                *light *= share;
            }
        }
    }

    /// The signal: light times the factor, with a variance that grows with it.
    #[inline(always)]
    fn add_noise(&self, planes: &LightPlanes, at: [usize; 2], light: &mut [Rows; 3]) {
        let is_noisy = self.shot > 0.0 || self.read > 0.0;
        for (channel, light) in light.iter_mut().enumerate() {
            for value in light.iter_mut() {
                *value *= self.factor;
            }
            if !is_noisy {
                continue;
            }
            let mut normal = [0.0; PIXELS];
            for (i, normal) in normal.iter_mut().enumerate() {
                let (x, y) = (SIDE * at[0] + i % SIDE, SIDE * at[1] + i / SIDE);
                let number = (y * planes.stride + x) as u32 * 3 + channel as u32;
                *normal = near_normal(number, self.key);
            }
            for (value, normal) in light.iter_mut().zip(&normal) {
                // What overflows is cut off afterwards, and has no need of a larger variance.
                let signal = if *value < 2.0 { *value } else { 2.0 };
                *value = signal + (self.shot * signal + self.read).sqrt() * normal;
            }
        }
    }
}

/// A random number for a pixel: nearly normal, mean 0, standard deviation 1. It depends on its
/// number and the key alone, so pixels may come in any order.
#[inline(always)]
fn near_normal(number: u32, key: [u32; 2]) -> f32 {
    // A hash by multiplications and shifts, whose constants are those of `lowbias32` (Wellons,
    // "Hash Prospector").
    let mut bits = number ^ key[0];
    bits ^= bits >> 16;
    bits = bits.wrapping_mul(0x7feb_352d);
    bits ^= (bits >> 15) ^ key[1];
    bits = bits.wrapping_mul(0x846c_a68b);
    bits ^= bits >> 16;
    // The sum of four uniform numbers (Irwin and Hall) from 0 to 255.
    let sum = (bits & 0xff) + (bits >> 8 & 0xff) + (bits >> 16 & 0xff) + (bits >> 24);
    // Four times the variance (256² - 1) / 12, and its root.
    const DEVIATION: f32 = 147.800_54;
    (sum as i32 - 510) as f32 * (1.0 / DEVIATION)
}

/// A block's light, averaged along its path.
#[inline(always)]
fn blurred(planes: &LightPlanes, at: [usize; 2], path: Path) -> [Rows; 3] {
    let length = (path.right * path.right + path.down * path.down).sqrt();
    let taps = if length > SHORTEST_PATH {
        (whole(length) as usize + 1).min(MOST_TAPS)
    } else {
        1
    };
    let mut starts = [0; MOST_TAPS];
    for (tap, start) in starts.iter_mut().enumerate().take(taps) {
        let along = (tap as f32 + 0.5) / taps as f32 - 0.5;
        let (x, y) = (SIDE * at[0] + MARGIN, SIDE * at[1] + MARGIN);
        // The margin keeps sums above zero, and half a pixel rounds to the nearest.
        let column = whole(x as f32 + along * path.right + 0.5) as usize;
        let row = whole(y as f32 + along * path.down + 0.5) as usize;
        *start = row * planes.stride + column;
    }
    let share = 1.0 / taps as f32;
    let mut light = [[0.0; PIXELS]; 3];
    for (light, channel) in light.iter_mut().zip(&planes.channels) {
        // Row by row, so that a sum stays in a register.
        for (y, line) in light.chunks_exact_mut(SIDE).enumerate() {
            let mut sum = [0.0; SIDE];
            for start in &starts[..taps] {
                let first = start + y * planes.stride;
                let seen = &channel[first..first + SIDE];
                for x in 0..SIDE {
                    sum[x] += seen[x];
                }
            }
            for x in 0..SIDE {
                line[x] = sum[x] * share;
            }
        }
    }
    light
}

/// Writes a block's signal into the image; what lies beyond its edges is left out.
#[inline(always)]
fn put(rgb: &mut [u8], planes: &LightPlanes, [column, row]: [usize; 2], light: &[Rows; 3]) {
    // Red, green and blue from the lowest byte up.
    let mut packed = [0_u32; PIXELS];
    for (channel, light) in light.iter().enumerate() {
        for (packed, value) in packed.iter_mut().zip(light) {
            let value = if *value > 0.0 { *value } else { 0.0 };
            let value = if value < 1.0 { value } else { 1.0 };
            // Colours are sRGB, whose curve is near a square root. `whole` rounds down.
            *packed |= whole(255.0 * value.sqrt() + 0.5) << (8 * channel);
        }
    }
    let (width, height) = (planes.size.width as usize, planes.size.height as usize);
    let columns = SIDE.min(width - SIDE * column);
    for y in 0..SIDE.min(height - SIDE * row) {
        let mut bytes = [0; 3 * SIDE];
        for x in 0..SIDE {
            let [red, green, blue, _] = packed[SIDE * y + x].to_le_bytes();
            bytes[3 * x..3 * x + 3].copy_from_slice(&[red, green, blue]);
        }
        let at = 3 * ((SIDE * row + y) * width + SIDE * column);
        rgb[at..at + 3 * columns].copy_from_slice(&bytes[..3 * columns]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::{Distortion, RobotDescription};

    fn flat(light: f32) -> (LightPlanes, Lens) {
        let optics = RobotDescription::sentry().camera_intrinsics;
        let lens = Lens::new(&optics, 1.0, Distortion::default());
        let mut planes = LightPlanes::new(lens.size);
        planes.channels.iter_mut().for_each(|c| c.fill(light));
        (planes, lens)
    }

    fn still(lens: &Lens) -> Development<'_> {
        Development {
            lens,
            movement: Movement::default(),
            factor: 1.0,
            shot: 0.0,
            read: 0.0,
            vignetting: 0.0,
            key: [1, 2],
        }
    }

    #[test]
    fn noise_has_the_variance_of_photons_and_of_reading() {
        let (planes, lens) = flat(0.25);
        let noisy = Development {
            shot: 1e-3,
            read: 1e-4,
            ..still(&lens)
        };
        let rgb = develop(&planes, noisy);
        let light = rgb.iter().map(|value| (f64::from(*value) / 255.0).powi(2));
        let mean = light.clone().sum::<f64>() / rgb.len() as f64;
        let variance = light.map(|l| (l - mean) * (l - mean)).sum::<f64>() / rgb.len() as f64;
        assert!((mean - 0.25).abs() < 1e-3, "{mean}");
        assert!((variance / 3.5e-4 - 1.0).abs() < 0.03, "{variance}");
        let other = Development {
            key: [1, 3],
            ..noisy
        };
        let mut narrow = vec![0; rgb.len()];
        let baseline = Developing {
            planes: &planes,
            development: noisy,
            rgb: &mut narrow,
        };
        baseline.run();
        assert_eq!(narrow, rgb, "the width of vectors changes nothing");
        assert_ne!(develop(&planes, other), rgb);
    }

    #[test]
    fn neighbouring_pixels_have_independent_noise() {
        let key = [0x1234_5678, 0x9abc_def0];
        for apart in [1, 3, 8, 2016] {
            let product = |i: u32| near_normal(i, key) * near_normal(i + apart, key);
            let mean = (0..100_000).map(product).sum::<f32>() / 1e5;
            assert!(mean.abs() < 0.02, "{apart}: {mean}");
        }
    }

    #[test]
    fn a_turn_blurs_along_the_rows_by_its_angle() {
        let (mut planes, lens) = flat(0.0);
        // A bright column in the middle.
        for row in 0..480 {
            let at = planes.index(320, row);
            planes.channels.iter_mut().for_each(|c| c[at] = 1.0);
        }
        let movement = Movement {
            turn: [0.0, 0.0, 0.02],
            shift: [0.0; 3],
        };
        let turning = Development {
            movement,
            ..still(&lens)
        };
        let rgb = develop(&planes, turning);
        let bright = (0..640).filter(|x| rgb[3 * (240 * 640 + x)] > 0).count();
        // 0.02 rad of 381 pixels.
        assert!((7..=9).contains(&bright), "{bright}");
    }

    #[test]
    fn wild_movements_stay_within_the_picture() {
        let (planes, lens) = flat(0.5);
        for wild in [1e9, f32::NAN, f32::INFINITY] {
            let movement = Movement {
                turn: [wild; 3],
                shift: [wild; 3],
            };
            let moved = Development {
                movement,
                ..still(&lens)
            };
            assert_eq!(develop(&planes, moved).len(), 3 * 640 * 480);
        }
    }
}
