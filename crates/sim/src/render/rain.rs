//! Streaks of rain before the camera.

use super::planes::LightPlanes;

/// Speed of drops of 2 mm, m/s (Gunn and Kinzer 1949).
const FALL_M_S: f32 = 6.5;
/// Distances at which drops are seen as streaks, metres.
const NEAREST_M: f32 = 0.4;
const FARTHEST_M: f32 = 6.0;
/// Shortest streak, pixels.
const SHORTEST: f32 = 2.0;
/// Longest streak, a share of the image's height.
const LONGEST: f32 = 0.5;
/// Share of the light behind it that a streak hides.
const OPACITY: f32 = 0.3;

/// The rain before one image.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Streaks {
    /// How many.
    pub(crate) count: u32,
    /// Time for which the shutter is open, seconds.
    pub(crate) seconds: f32,
    /// Focal length, pixels.
    pub(crate) focal_length: f32,
    /// Light of the sky, which drops gather.
    pub(crate) light: [f32; 3],
    /// Random numbers of this image.
    pub(crate) key: [u32; 2],
}

/// Draws streaks over a picture.
pub(crate) fn rain(planes: &mut LightPlanes, streaks: Streaks) {
    let (width, height) = (planes.size.width as f32, planes.size.height as f32);
    for number in 0..streaks.count {
        let drawn = |purpose: u32| share(streaks.key, 4 * number + purpose);
        // Most drops are far away: their number grows with the square of the distance.
        let distance = NEAREST_M + (FARTHEST_M - NEAREST_M) * drawn(0).sqrt();
        let length = streaks.focal_length * FALL_M_S * streaks.seconds / distance;
        let length = length.clamp(SHORTEST, LONGEST * height);
        let wide = if distance < 1.0 { 2 } else { 1 };
        let (column, top) = (drawn(1) * width, drawn(2) * (height + length) - length);
        // Wind tilts all of them a little.
        let lean = 0.06 * (drawn(3) - 0.2);
        for step in 0..length as usize {
            let row = top + step as f32;
            let middle = column + lean * step as f32;
            for beside in 0..wide {
                let x = middle + beside as f32;
                if (0.0..height).contains(&row) && (0.0..width).contains(&x) {
                    tint(planes, [x as usize, row as usize], streaks.light);
                }
            }
        }
    }
}

fn tint(planes: &mut LightPlanes, [column, row]: [usize; 2], light: [f32; 3]) {
    let at = planes.index(column, row);
    for (channel, light) in planes.channels.iter_mut().zip(light) {
        channel[at] += OPACITY * (light - channel[at]);
    }
}

/// A number from 0 to 1.
fn share(key: [u32; 2], number: u32) -> f32 {
    let mut bits = number ^ key[1];
    bits ^= bits >> 16;
    bits = bits.wrapping_mul(0x7feb_352d);
    bits ^= (bits >> 15) ^ key[0];
    bits = bits.wrapping_mul(0x846c_a68b);
    bits ^= bits >> 16;
    (bits >> 8) as f32 / 16_777_216.0
}

#[cfg(test)]
mod tests {
    use super::super::view::ImageSize;
    use super::*;

    #[test]
    fn streaks_stay_within_the_picture_and_differ_between_images() {
        let drawn = |key| {
            let mut planes = LightPlanes::new(ImageSize::new(100, 80));
            let streaks = Streaks {
                count: 200,
                seconds: 0.02,
                focal_length: 381.0,
                light: [1.0; 3],
                key,
            };
            rain(&mut planes, streaks);
            planes
        };
        let (one, other) = (drawn([1, 2]), drawn([3, 4]));
        assert_ne!(one, other);
        assert_eq!(one, drawn([1, 2]));
        let wet = one.channels[0].iter().filter(|light| **light > 0.0).count();
        assert!(wet > 500, "{wet}");
        // Nothing is drawn into the margin.
        assert_eq!(one.channels[0][0], 0.0);
    }
}
