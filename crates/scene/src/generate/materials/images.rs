//! Procedural textures of walls, roofs and grounds. Mostly grey: the material's colour tints them.

use std::sync::Arc;

use crate::generate::seeds::mix;
use crate::material::Texture;

/// Side of the textures of surfaces, texels.
const SIDE: u32 = 256;

/// An image from a function of column and row (row 0 at the top).
pub(super) fn paint(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Texture {
    let mut rgba = Vec::with_capacity((4 * width * height) as usize);
    for y in 0..height {
        for x in 0..width {
            rgba.extend(texel(x, y));
        }
    }
    Texture {
        width,
        height,
        rgba: Arc::from(rgba),
    }
}

/// A colour from numbers between 0 and 1.
pub(super) fn rgb(color: [f32; 3], brightness: f32) -> [u8; 4] {
    let [red, green, blue] = color.map(|c| (c * brightness * 255.0).clamp(0.0, 255.0) as u8);
    [red, green, blue, 255]
}

fn grey(brightness: f32) -> [u8; 4] {
    rgb([1.0; 3], brightness)
}

/// White noise between 0 and 1.
pub(super) fn speck(x: u32, y: u32, seed: u64) -> f32 {
    // 24 bits, which single precision holds exactly.
    (mix(seed ^ (u64::from(x) << 32) ^ u64::from(y)) >> 40) as f32 / (1_u32 << 24) as f32
}

/// Smooth noise between 0 and 1 that repeats every [`SIDE`] texels. Its spots are `grain` texels
/// wide (a divisor of SIDE).
pub(super) fn cloud(x: u32, y: u32, grain: u32, seed: u64) -> f32 {
    // Value noise: random numbers at the knots of a grid, blended between them. Knots beyond the
    // edge are those of the other side, so that the image repeats.
    let period = SIDE / grain;
    let tx = smoothstep((x % grain) as f32 / grain as f32);
    let ty = smoothstep((y % grain) as f32 / grain as f32);
    let (cx, cy) = (x / grain, y / grain);
    let knot = |i: u32, j: u32| speck((cx + i) % period, (cy + j) % period, seed);
    let (top, bottom) = (
        knot(0, 0) + (knot(1, 0) - knot(0, 0)) * tx,
        knot(0, 1) + (knot(1, 1) - knot(0, 1)) * tx,
    );
    top + (bottom - top) * ty
}

/// A cubic from 0 to 1 that is level at both ends, so that no edge between cells shows.
fn smoothstep(t: f32) -> f32 {
    t * t * (3.0 - 2.0 * t)
}

/// Clouds of three sizes.
fn rough(x: u32, y: u32, seed: u64) -> f32 {
    0.5 * cloud(x, y, 64, seed) + 0.3 * cloud(x, y, 16, seed ^ 1) + 0.2 * cloud(x, y, 4, seed ^ 2)
}

/// Running bond, 8 bricks across and 24 courses (the image covers about 2 m).
pub(super) fn bricks(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        let course = y * 24 / SIDE;
        // Every second course begins with half a brick. Numbers of bricks are those of the shifted
        // row, so a brick keeps its tone across the edge.
        let shifted = (x + (course % 2) * 16) % SIDE;
        let (in_brick, in_course) = (shifted % 32, (y * 24) % SIDE);
        // Mortar: two texels across, and 44/256 of a course high, which is nearly two texels.
        if in_brick < 2 || in_course < 44 {
            return rgb([1.0, 1.02, 1.04], 0.92 + 0.1 * speck(x, y, seed));
        }
        let tone = 0.62 + 0.22 * speck(shifted / 32, course, seed ^ 5);
        rgb([1.0, 0.97, 0.95], tone + 0.10 * speck(x, y, seed))
    })
}

/// Rendered wall with faint stains.
pub(super) fn plaster(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        grey(0.90 + 0.07 * rough(x, y, seed) + 0.04 * speck(x, y, seed))
    })
}

/// Horizontal boards, 10 in the image (about 2 m).
pub(super) fn siding(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        let (board, within) = (y * 10 / SIDE, (y * 10 % SIDE) as f32 / SIDE as f32);
        let edge = if within > 0.90 {
            0.55
        } else {
            0.86 + 0.12 * within
        };
        let tone = 0.05 * speck(0, board, seed) + 0.04 * cloud(x, y, 32, seed);
        grey(edge + tone)
    })
}

/// Squared stones of uneven tone, 4 by 8.
pub(super) fn stones(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        let row = y / 32;
        let shifted = (x + (row % 2) * 32) % SIDE;
        if shifted % 64 < 2 || y % 32 < 2 {
            return grey(0.52);
        }
        grey(0.72 + 0.18 * speck(shifted / 64, row, seed) + 0.10 * rough(x, y, seed))
    })
}

/// Rows of roof tiles, 12 by 12 (about 3 m).
pub(super) fn tiles(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        let row = y * 12 / SIDE;
        let shifted = (x + (row % 2) * 10) % SIDE;
        let within = (y * 12 % SIDE) as f32 / SIDE as f32;
        let across = (shifted * 12 % SIDE) as f32 / SIDE as f32;
        let bulge = 1.0 - (across - 0.5) * (across - 0.5);
        let lip = if within > 0.86 { 0.55 } else { 1.0 };
        grey(
            (0.62 + 0.16 * speck(shifted * 12 / SIDE, row, seed) + 0.08 * speck(x, y, seed))
                * bulge
                * lip
                + 0.08,
        )
    })
}

/// Small stones: asphalt, roof gravel.
pub(super) fn grit(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        grey(0.70 + 0.16 * rough(x, y, seed) + 0.22 * speck(x, y, seed))
    })
}

/// Paving slabs, 4 by 4 (about 2 m).
pub(super) fn slabs(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        let row = y / 64;
        let shifted = (x + (row % 2) * 32) % SIDE;
        if shifted % 64 < 2 || y % 64 < 2 {
            return grey(0.56 + 0.12 * speck(x, y, seed));
        }
        let stain = if cloud(x, y, 16, seed ^ 9) > 0.80 {
            0.06
        } else {
            0.0
        };
        let tone = 0.78 + 0.13 * speck(shifted / 64, row, seed) + 0.08 * rough(x, y, seed);
        grey(tone - stain + 0.10 * (speck(x, y, seed) - 0.5))
    })
}

/// Herringbone-like small setts, 16 by 16.
pub(super) fn setts(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        let row = y / 16;
        let shifted = (x + (row % 2) * 8) % SIDE;
        if shifted % 16 < 1 || y % 16 < 1 {
            return grey(0.5);
        }
        grey(0.68 + 0.24 * speck(shifted / 16, row, seed) + 0.06 * speck(x, y, seed))
    })
}

/// Lawn: short blades upright in the image, worn and lush places.
pub(super) fn grass(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        // Blades five texels high, moved sideways by a cloud, so that no columns are seen.
        let lean = (8.0 * cloud(x, y, 32, seed ^ 11)) as u32;
        let blades = 0.6 * speck((x + lean) % SIDE, y / 5, seed) + 0.4 * speck(x, y / 2, seed ^ 3);
        let patch = rough(x, y, seed);
        rgb(
            [0.32 + 0.16 * patch, 0.45 + 0.06 * patch, 0.20],
            0.56 + 0.52 * blades,
        )
    })
}

/// Bark chips and earth.
pub(super) fn earth(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        let chips = speck(x / 3, y / 2, seed);
        rgb(
            [0.36, 0.27, 0.19],
            0.55 + 0.4 * chips + 0.25 * rough(x, y, seed),
        )
    })
}

/// The leaf that covers a texel.
struct Leaf {
    number: u64,
    /// Distance of the texel from the middle of the leaf, from 0 to 1 at its edge.
    from_middle: f32,
}

/// The leaf that covers a texel. Leaves lie about a jittered grid of `grain` texels (a divisor of
/// SIDE), the nearest in front (Worley, *A Cellular Texture Basis Function*, 1996).
fn leaf(x: u32, y: u32, grain: u32, seed: u64) -> Leaf {
    let cells = SIDE / grain;
    let (cx, cy) = (x / grain, y / grain);
    let (mut number_of_nearest, mut first, mut second) = (0, f32::MAX, f32::MAX);
    for (dx, dy) in (0..3).flat_map(|dx| (0..3).map(move |dy| (dx, dy))) {
        // The cell itself and its neighbours, across the edge too. `cells` is added since unsigned
        // numbers must not fall below zero.
        let (kx, ky) = ((cx + cells + dx - 1) % cells, (cy + cells + dy - 1) % cells);
        let number = mix(seed ^ (u64::from(kx) << 32) ^ u64::from(ky));
        let px = (cx as f32 + dx as f32 - 1.0 + share_of_byte(number)) * grain as f32;
        let py = (cy as f32 + dy as f32 - 1.0 + share_of_byte(number >> 8)) * grain as f32;
        let (u, v) = (px - x as f32, (py - y as f32) * 1.4);
        let distance = (u * u + v * v).sqrt();
        if distance < first {
            second = first;
            first = distance;
            number_of_nearest = number;
        } else {
            second = second.min(distance);
        }
    }
    Leaf {
        number: number_of_nearest,
        // 1 where two leaves are equally near: at the edge between them.
        from_middle: first / second.max(1e-3),
    }
}

/// The lowest eight bits, from 0 to 1.
fn share_of_byte(bits: u64) -> f32 {
    (bits & 0xff) as f32 / 255.0
}

/// Brightness of a texel among leaves: each leaf has its own, and shades those below it.
fn leafage(x: u32, y: u32, seed: u64) -> f32 {
    let large = leaf(x, y, 16, seed);
    let small = leaf(x, y, 8, seed ^ 21);
    let tone = |leaf: &Leaf| share_of_byte(leaf.number >> 24);
    let bright = 0.52 + 0.46 * tone(&large) + 0.22 * tone(&small);
    bright
        * (1.0 - 0.50 * large.from_middle * large.from_middle)
        * (1.0 - 0.25 * small.from_middle * small.from_middle)
}

/// Dense small leaves.
pub(super) fn foliage(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        let depth = 0.72 + 0.4 * cloud(x, y, 32, seed ^ 4);
        rgb(
            [0.62, 0.86, 0.44],
            (leafage(x, y, seed) * depth + 0.10).min(1.1),
        )
    })
}

/// Leaves with flowers among them; the material's colour tints the flowers.
pub(super) fn blossoms(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        let Leaf {
            number,
            from_middle,
        } = leaf(x, y, 16, seed);
        let bright = leafage(x, y, seed) + 0.12;
        if number >> 40 & 0xff < 105 && from_middle < 0.75 {
            return rgb([1.0; 3], 1.0 - 0.35 * from_middle);
        }
        rgb([0.36, 0.52, 0.30], bright)
    })
}

/// Leaves with holes between them, for crowns.
pub(super) fn leaves(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        let Leaf {
            number,
            from_middle,
        } = leaf(x, y, 16, seed);
        let gap = cloud(x, y, 32, seed ^ 4) + 0.35 * ((number >> 48 & 0xff) as f32 / 255.0 - 0.5);
        let mut texel = rgb([0.62, 0.86, 0.44], leafage(x, y, seed) + 0.16);
        // Holes in spots of the cloud, and at the edges of leaves around them.
        texel[3] = if gap < 0.34 || gap < 0.46 && from_middle > 0.8 {
            0
        } else {
            255
        };
        texel
    })
}

/// Small waves.
pub(super) fn ripples(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        let swell = 0.6 * cloud(x, y, 32, seed) + 0.4 * cloud(x, (3 * y) % SIDE, 16, seed ^ 1);
        let crest = if swell > 0.68 { 0.16 } else { 0.0 };
        grey(0.86 + 0.16 * swell + crest + 0.03 * speck(x, y, seed))
    })
}

/// Stones end to end, one in the image (about 1 m).
pub(super) fn kerbstones(seed: u64) -> Texture {
    paint(SIDE, SIDE, |x, y| {
        grey(if x < 5 {
            0.58
        } else {
            0.86 + 0.12 * rough(x, y, seed)
        })
    })
}

/// Upright furrows.
pub(super) fn bark(seed: u64) -> Texture {
    paint(64, 64, |x, y| {
        let furrow = speck(x / 3, y / 12, seed);
        rgb(
            [0.42, 0.33, 0.26],
            0.55 + 0.45 * furrow + 0.15 * speck(x, y, seed),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_noise_has_no_seam() {
        for y in 0..SIDE {
            assert!((cloud(SIDE - 1, y, 16, 9) - cloud(0, y, 16, 9)).abs() < 0.15);
        }
    }

    #[test]
    fn crowns_have_holes_and_leaves() {
        let image = leaves(3);
        let holes = image.rgba.chunks(4).filter(|t| t[3] == 0).count();
        let share = holes as f64 / f64::from(SIDE * SIDE);
        assert!((0.1..0.6).contains(&share), "{share}");
    }
}
