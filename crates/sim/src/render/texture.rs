//! Textures at full, half, quarter … size, and the colours of pixels that cover some of their
//! texels.

use openbench_scene::Texture;

use super::block::{BLOCK, Block};
use crate::rounding::{fraction, whole};

/// A pixel that covers more texels than this takes the next smaller image.
const COVER: f32 = 1.5;
/// Steps between two texels. Weights are integers, so that colours are the same on every machine at
/// no cost.
const STEPS: u32 = 16;

/// A texture at full, half, quarter … size.
#[derive(Debug)]
pub(super) struct Mipmaps {
    levels: Vec<Level>,
}

/// A texture at one size.
#[derive(Debug)]
pub(super) struct Level {
    pub(super) width: u32,
    pub(super) height: u32,
    rgba: std::sync::Arc<[u8]>,
}

impl Mipmaps {
    pub(super) fn new(texture: &Texture) -> Self {
        let mut images = vec![texture.clone()];
        // A side of one texel cannot be halved, so narrow textures have fewer levels.
        while let Some(last) = images.last().filter(|t| t.width > 1 && t.height > 1) {
            images.push(halved(last));
        }
        let level = |image: Texture| Level {
            width: image.width,
            height: image.height,
            rgba: image.rgba,
        };
        Self {
            levels: images.into_iter().map(level).collect(),
        }
    }

    /// The image halved this many times, or the smallest.
    #[inline(always)]
    pub(super) fn level(&self, halvings: u32) -> &Level {
        &self.levels[(halvings as usize).min(self.levels.len() - 1)]
    }
}

impl Level {
    /// Red, green, blue and alpha from the lowest byte up.
    #[inline(always)]
    pub(super) fn texel(&self, index: u32) -> u32 {
        let at = 4 * index as usize;
        u32::from_le_bytes(self.rgba[at..at + 4].try_into().unwrap_or_default())
    }
}

/// How often the image must be halved until a pixel covers few texels of it.
#[inline(always)]
pub(super) fn levels(texels: &Block) -> [u32; BLOCK] {
    let mut levels = [0; BLOCK];
    for lane in 0..BLOCK {
        let bits = (texels[lane] * (1.0 / COVER)).to_bits();
        // The logarithm to base 2, rounded up: the exponent, plus one if the mantissa is more than
        // 1. NaN, negative numbers and numbers below 1 give 0.
        let exponent = (bits >> 23).wrapping_sub(127);
        let up = if bits & 0x7f_ffff == 0 {
            exponent
        } else {
            exponent.wrapping_add(1)
        };
        levels[lane] = if exponent < 127 { up } else { 0 };
    }
    levels
}

/// The four texels round each pixel's place: upper left, upper right, lower left, lower right.
pub(super) struct Corners {
    /// Indices in the image.
    pub(super) index: [[u32; BLOCK]; 4],
    /// Weights of the right and of the lower texels, in sixteenths.
    weight: [[u32; BLOCK]; 2],
}

/// The texels round the places `uv` of images with these widths and heights. Images repeat, and v
/// runs upwards.
#[inline(always)]
pub(super) fn corners(uv: &[Block; 2], size: &[[u32; BLOCK]; 2]) -> Corners {
    let mut beside = [[[0; BLOCK]; 2]; 2];
    let mut weight = [[0; BLOCK]; 2];
    for axis in 0..2 {
        for i in 0..BLOCK {
            let place = if axis == 0 { uv[0][i] } else { 1.0 - uv[1][i] };
            let pair = neighbours(fraction(place), size[axis][i]);
            (beside[axis][0][i], beside[axis][1][i]) = (pair.first, pair.second);
            weight[axis][i] = pair.weight;
        }
    }
    let mut index = [[0; BLOCK]; 4];
    for corner in 0..4 {
        for i in 0..BLOCK {
            index[corner][i] = beside[1][corner / 2][i] * size[0][i] + beside[0][corner % 2][i];
        }
    }
    Corners { index, weight }
}

/// Red, green and blue, 0 to 255, of places with these four texels.
#[inline(always)]
pub(super) fn blend(packed: &[[u32; BLOCK]; 4], corners: &Corners) -> [Block; 3] {
    const WHOLE: f32 = 1.0 / (STEPS * STEPS) as f32;
    let [mut red, mut green, mut blue] = [[0.0; BLOCK]; 3];
    for i in 0..BLOCK {
        let (right, low) = (corners.weight[0][i], corners.weight[1][i]);
        let (left, high) = (STEPS - right, STEPS - low);
        let (a, b, c, d) = (left * high, right * high, left * low, right * low);
        let [p, q, r, s] = packed;
        let (p, q, r, s) = (p[i], q[i], r[i], s[i]);
        // Red and blue together, and green alone: each has room for a weight above it.
        // The weights add up to 256, so a sum is at most 255 times 256: it does not carry into the
        // next half.
        const RED_BLUE: u32 = 0xff_00ff;
        let red_blue =
            (p & RED_BLUE) * a + (q & RED_BLUE) * b + (r & RED_BLUE) * c + (s & RED_BLUE) * d;
        let just_green =
            (p >> 8 & 0xff) * a + (q >> 8 & 0xff) * b + (r >> 8 & 0xff) * c + (s >> 8 & 0xff) * d;
        // Through a signed integer, for which every machine has a conversion.
        red[i] = (red_blue & 0xffff) as i32 as f32 * WHOLE;
        green[i] = just_green as i32 as f32 * WHOLE;
        blue[i] = (red_blue >> 16) as i32 as f32 * WHOLE;
    }
    [red, green, blue]
}

/// The two texels beside a place in a row.
struct TexelPair {
    first: u32,
    second: u32,
    /// Of the second, in [`STEPS`].
    weight: u32,
}

/// The two texels beside a place in a row of `size` that repeats.
#[inline(always)]
fn neighbours(place: f32, size: u32) -> TexelPair {
    // One texel is added, so that no number is below zero.
    // `whole` saturates at 2^22 steps, which are 262,144 texels.
    let steps = whole(place * (size * STEPS) as i32 as f32 + (STEPS / 2) as f32);
    let (after, weight) = (steps / STEPS, steps % STEPS);
    let first = if after == 0 { size - 1 } else { after - 1 };
    let first = if first < size { first } else { size - 1 };
    let second = if first + 1 == size { 0 } else { first + 1 };
    TexelPair {
        first,
        second,
        weight,
    }
}

fn halved(image: &Texture) -> Texture {
    // An odd last row or column is left out.
    let (width, height) = (image.width / 2, image.height / 2);
    let texel =
        |x: u32, y: u32, c: u32| u32::from(image.rgba[(4 * (y * image.width + x) + c) as usize]);
    let mut rgba = Vec::with_capacity(4 * (width * height) as usize);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        for c in 0..4 {
            let sum = texel(2 * x, 2 * y, c) + texel(2 * x + 1, 2 * y, c);
            let sum = sum + texel(2 * x, 2 * y + 1, c) + texel(2 * x + 1, 2 * y + 1, c);
            rgba.push(((sum + 2) / 4) as u8);
        }
    }
    Texture {
        width,
        height,
        rgba: rgba.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[u8], width: u32) -> Texture {
        let rgba: Vec<u8> = values.iter().flat_map(|v| [*v, *v, *v, 255]).collect();
        Texture {
            width,
            height: values.len() as u32 / width,
            rgba: rgba.into(),
        }
    }

    /// Colour at `uv`, 0 to 255, for a pixel that covers `texels` texels of the full size.
    fn sample(maps: &Mipmaps, uv: [f32; 2], texels: f32) -> [f32; 3] {
        let image = maps.level(levels(&[texels; BLOCK])[3]);
        let corners = corners(
            &uv.map(|c| [c; BLOCK]),
            &[[image.width; BLOCK], [image.height; BLOCK]],
        );
        let packed = corners.index.map(|index| [image.texel(index[3]); BLOCK]);
        blend(&packed, &corners).map(|channel| channel[3])
    }

    #[test]
    fn mipmaps_keep_the_mean() {
        let checks: Vec<u8> = (0..64)
            .map(|i| if (i + i / 8) % 2 == 0 { 255 } else { 0 })
            .collect();
        let far = sample(&Mipmaps::new(&grey(&checks, 8)), [0.3, 0.7], 8.0);
        assert!(far.iter().all(|c| (c - 127.5).abs() < 2.0), "{far:?}");
    }

    #[test]
    fn colours_run_between_texels_and_round_the_edge() {
        let maps = Mipmaps::new(&grey(&[0, 160, 0, 160, 80, 80, 80, 80], 4));
        let at = |u: f32, v: f32| sample(&maps, [u, v], 1.0)[0];
        // Middles of the texels of the top row, which has v near 1, and places between them.
        assert_eq!(
            (at(0.125, 0.75), at(0.375, 0.75), at(0.25, 0.75)),
            (0.0, 160.0, 80.0)
        );
        assert_eq!(at(0.0, 0.75), 80.0, "between the last and the first");
        assert_eq!(
            (at(1.375, 0.75), at(-0.625, 0.75)),
            (160.0, 160.0),
            "the image repeats"
        );
        assert_eq!(at(0.375, 0.5), 120.0, "between the rows");
    }

    #[test]
    fn red_green_and_blue_keep_apart() {
        let texture = Texture {
            width: 1,
            height: 1,
            rgba: vec![10, 200, 255, 255].into(),
        };
        assert_eq!(
            sample(&Mipmaps::new(&texture), [0.3, 0.4], 1.0),
            [10.0, 200.0, 255.0]
        );
    }

    #[test]
    fn broken_coordinates_give_some_colour() {
        let maps = Mipmaps::new(&grey(&[10, 20, 30, 40], 2));
        for bad in [f32::NAN, f32::INFINITY, -1e30, 1e30] {
            assert!(
                sample(&maps, [bad, bad], bad)
                    .iter()
                    .all(|c| (10.0..=40.0).contains(c)),
                "{bad}"
            );
        }
    }

    #[test]
    fn images_are_halved_until_a_pixel_covers_few_texels() {
        let level = |texels: f32| levels(&[texels; BLOCK])[0];
        assert_eq!(
            [0.0, 1.5, 1.6, 3.0, 3.1, 6.0, 6.1].map(level),
            [0, 0, 1, 1, 2, 2, 3]
        );
        assert_eq!([-5.0, f32::NAN, f32::NEG_INFINITY].map(level), [0, 0, 0]);
    }
}
