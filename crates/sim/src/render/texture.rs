//! Textures at full, half, quarter … size, and the colour of a pixel that covers some of their texels.

use openbench_scene::Texture;

/// A pixel may cover this many texels before the next smaller image is taken.
const COVER: f32 = 1.5;
/// Steps between two texels: weights are whole numbers, so that colours are the same on every machine at no cost.
const STEPS: f32 = 16.0;

/// A texture at full, half, quarter … size.
#[derive(Debug)]
pub(super) struct Mipmaps {
    levels: Vec<Texture>,
}

impl Mipmaps {
    pub(super) fn new(texture: &Texture) -> Self {
        let mut levels = vec![texture.clone()];
        while let Some(last) = levels.last().filter(|t| t.width > 1 && t.height > 1) {
            levels.push(halved(last));
        }
        Self { levels }
    }

    /// Colour at `uv`, 0 to 255, for a pixel that covers `texels` texels of the full size, bilinear.
    #[inline]
    pub(super) fn sample(&self, uv: [f32; 2], texels: f32) -> [f32; 3] {
        bilinear(&self.levels[level(texels).min(self.levels.len() - 1)], uv)
    }
}

/// How often the image must be halved until a pixel covers few texels of it.
#[inline]
fn level(texels: f32) -> usize {
    let ratio = texels / COVER;
    if ratio <= 1.0 || ratio.is_nan() {
        return 0;
    }
    // The logarithm to base 2, rounded up: exponent, plus one if the mantissa is more than 1.
    let bits = ratio.to_bits();
    (bits >> 23) as usize - 127 + usize::from(bits & 0x7f_ffff != 0)
}

#[inline]
fn bilinear(image: &Texture, uv: [f32; 2]) -> [f32; 3] {
    let (x0, x1, fx) = neighbours(fraction(uv[0]), image.width);
    let (y0, y1, fy) = neighbours(1.0 - fraction(uv[1]), image.height);
    let texel = |x: u32, y: u32| {
        let at = 4 * (y as usize * image.width as usize + x as usize);
        let bytes: [u8; 4] = image.rgba[at..at + 4].try_into().unwrap_or_default();
        let packed = u32::from_le_bytes(bytes);
        // Red and blue, and green alone, each with room for a weight above it.
        (packed & 0xff_00ff, packed >> 8 & 0xff)
    };
    let corners = [
        (texel(x0, y0), (16 - fx) * (16 - fy)),
        (texel(x1, y0), fx * (16 - fy)),
        (texel(x0, y1), (16 - fx) * fy),
        (texel(x1, y1), fx * fy),
    ];
    let (mut red_blue, mut green) = (0, 0);
    for ((rb, g), weight) in corners {
        red_blue += rb * weight;
        green += g * weight;
    }
    const WHOLE: f32 = 1.0 / 256.0;
    [(red_blue & 0xffff) as f32 * WHOLE, green as f32 * WHOLE, (red_blue >> 16) as f32 * WHOLE]
}

/// The two texels beside a place in a row of `size` that repeats, and the weight of the second in sixteenths.
#[inline]
fn neighbours(place: f32, size: u32) -> (u32, u32, u32) {
    let steps = ((place * size as f32 - 0.5) * STEPS + STEPS) as u32;
    // One texel was added above, so that the cast rounds down.
    let (after, weight) = (steps / 16, steps % 16);
    let first = if after == 0 { size - 1 } else { (after - 1).min(size - 1) };
    (first, if first + 1 == size { 0 } else { first + 1 }, weight)
}

/// `x` less its floor.
#[inline]
fn fraction(x: f32) -> f32 {
    let rest = x - x as i32 as f32;
    if rest < 0.0 { rest + 1.0 } else { rest }
}

fn halved(image: &Texture) -> Texture {
    let (width, height) = (image.width / 2, image.height / 2);
    let texel = |x: u32, y: u32, c: u32| u32::from(image.rgba[(4 * (y * image.width + x) + c) as usize]);
    let mut rgba = Vec::with_capacity(4 * (width * height) as usize);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        for c in 0..4 {
            let sum = texel(2 * x, 2 * y, c) + texel(2 * x + 1, 2 * y, c);
            let sum = sum + texel(2 * x, 2 * y + 1, c) + texel(2 * x + 1, 2 * y + 1, c);
            rgba.push(((sum + 2) / 4) as u8);
        }
    }
    Texture { width, height, rgba: rgba.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[u8], width: u32) -> Texture {
        let rgba: Vec<u8> = values.iter().flat_map(|v| [*v, *v, *v, 255]).collect();
        Texture { width, height: values.len() as u32 / width, rgba: rgba.into() }
    }

    #[test]
    fn mipmaps_keep_the_mean() {
        let checks: Vec<u8> = (0..64).map(|i| if (i + i / 8) % 2 == 0 { 255 } else { 0 }).collect();
        let far = Mipmaps::new(&grey(&checks, 8)).sample([0.3, 0.7], 8.0);
        assert!(far.iter().all(|c| (c - 127.5).abs() < 2.0), "{far:?}");
    }

    #[test]
    fn colours_run_between_texels_and_round_the_edge() {
        let maps = Mipmaps::new(&grey(&[0, 160, 0, 160, 80, 80, 80, 80], 4));
        let at = |u: f32, v: f32| maps.sample([u, v], 1.0)[0];
        // Middles of the texels of the top row, which has v near 1, and places between them.
        assert_eq!((at(0.125, 0.75), at(0.375, 0.75), at(0.25, 0.75)), (0.0, 160.0, 80.0));
        assert_eq!(at(0.0, 0.75), 80.0, "between the last and the first");
        assert_eq!((at(1.375, 0.75), at(-0.625, 0.75)), (160.0, 160.0), "the image repeats");
        assert_eq!(at(0.375, 0.5), 120.0, "between the rows");
    }

    #[test]
    fn broken_coordinates_give_some_colour() {
        let maps = Mipmaps::new(&grey(&[10, 20, 30, 40], 2));
        for bad in [f32::NAN, f32::INFINITY, -1e30, 1e30] {
            assert!(maps.sample([bad, bad], bad).iter().all(|c| (10.0..=40.0).contains(c)), "{bad}");
        }
    }

    #[test]
    fn images_are_halved_until_a_pixel_covers_few_texels() {
        assert_eq!([0.0, 1.5, 1.6, 3.0, 3.1, 6.0, 6.1].map(level), [0, 0, 1, 1, 2, 2, 3]);
    }
}
