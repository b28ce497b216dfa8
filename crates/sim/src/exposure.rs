//! Automatic exposure as in cheap cameras: the mean brightness of one image sets the exposure of
//! the next.
//!
//! It is a proportional controller on the logarithm of the light. Its target is the mid-grey to
//! which light meters are calibrated (18 % of white, ISO 2720; 118 of 255 in sRGB). Cameras for
//! robots expose in the same way, with a target grey value and bounds (FLIR Firefly, "Auto
//! Algorithm Control"; Basler, "Exposure Auto").

/// Target of the mean grey value, sRGB, 0 to 255.
const TARGET: f64 = 118.0;
/// Time in which the error of the exposure falls by the factor e, seconds.
const SETTLING_S: f64 = 0.3;
/// Largest deviation from the exposure of the scene's own light, in stops: powers of two.
const MAX_STOPS: f64 = 2.0;
/// One of this many pixels is measured. It divides no usual width, so that all columns are sampled.
const STRIDE: usize = 61;

/// The exposure of a camera that adjusts it automatically.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct AutoExposure {
    stops: f64,
}

impl AutoExposure {
    /// Factor on the light: 1/4 to 4.
    pub(crate) fn factor(&self) -> f32 {
        libm::exp2(self.stops) as f32
    }

    /// Adjusts the exposure by an image (RGB, sRGB) that was taken with it `seconds` ago.
    pub(crate) fn learn(&mut self, rgb: &[u8], seconds: f64) {
        // An exponential approach in closed form, so settling does not depend on how often images
        // are taken. The image was taken with the present exposure, so its error is relative to
        // that.
        let share = 1.0 - libm::exp(-seconds.max(0.0) / SETTLING_S);
        self.stops = (self.stops + share * error_stops(rgb)).clamp(-MAX_STOPS, MAX_STOPS);
    }

    /// The exposure at which the controller settles, by an image that was taken with the factor 1.
    pub(crate) fn settled(rgb: &[u8]) -> Self {
        Self {
            stops: error_stops(rgb).clamp(-MAX_STOPS, MAX_STOPS),
        }
    }
}

/// The exposure of a camera in light of any strength: powers of two of the factor on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LightMeter {
    stops: f64,
}

impl LightMeter {
    /// The exposure at which the mean grey value is the target; at most `most` stops. `mean` gives
    /// the mean grey value at a factor on the light, with which it grows.
    pub(crate) fn settled(most: f64, mean: impl Fn(f32) -> f64) -> Self {
        /// Halvings of the range until the rest is a hundredth of a stop.
        const HALVINGS: usize = 11;
        let (mut low, mut high) = (-MAX_STOPS, most);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if mean(libm::exp2(middle) as f32) < TARGET {
                low = middle;
            } else {
                high = middle;
            }
        }
        Self {
            stops: 0.5 * (low + high),
        }
    }

    /// This exposure after `seconds` in which it approached another one.
    pub(crate) fn towards(self, wanted: Self, seconds: f64, lag_s: f64) -> Self {
        // An exponential approach in closed form. Without lag the quotient is infinite, or NaN for
        // no time, and then the approach is whole.
        let left = libm::exp(-seconds.max(0.0) / lag_s);
        let left = if left.is_nan() { 0.0 } else { left };
        Self {
            stops: wanted.stops + left * (self.stops - wanted.stops),
        }
    }

    /// Factor on the light.
    pub(crate) fn factor(&self) -> f64 {
        libm::exp2(self.stops)
    }
}

/// Stops between an image's mean and the target. Grey values grow with the square root of the
/// light.
fn error_stops(rgb: &[u8]) -> f64 {
    // A black image has no logarithm; one grey value is dark enough to reach the bound.
    2.0 * libm::log2(TARGET / mean(rgb).max(1.0))
}

/// Mean grey value of the sampled pixels.
fn mean(rgb: &[u8]) -> f64 {
    let samples = rgb.chunks_exact(3).step_by(STRIDE);
    let (sum, count) = samples.fold((0, 0), |(sum, count), p| (sum + grey(p), count + 1));
    if count == 0 {
        TARGET
    } else {
        sum as f64 / count as f64
    }
}

/// Grey value of a pixel, weighted as in ITU-R BT.601.
fn grey(pixel: &[u8]) -> u64 {
    let [red, green, blue] = [0, 1, 2].map(|channel| u64::from(pixel[channel]));
    // 0.299, 0.587 and 0.114 in 256ths: integers add up to the same in any order.
    (77 * red + 150 * green + 29 * blue) >> 8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The image of a uniform surface that has this grey value at the exposure 1.
    fn seen(grey: f64, exposure: &AutoExposure) -> Vec<u8> {
        vec![(grey * f64::from(exposure.factor()).sqrt()) as u8; 3 * 640 * 48]
    }

    #[test]
    fn grey_becomes_mid_grey_within_a_second() {
        for grey in [70.0, 118.0, 220.0] {
            let mut exposure = AutoExposure::default();
            (0..10).for_each(|_| exposure.learn(&seen(grey, &exposure), 0.1));
            let adjusted = mean(&seen(grey, &exposure));
            assert!((adjusted - TARGET).abs() < 6.0, "{grey} became {adjusted}");
            let settled = AutoExposure::settled(&seen(grey, &AutoExposure::default()));
            assert!((mean(&seen(grey, &settled)) - TARGET).abs() < 2.0);
        }
    }

    #[test]
    fn a_meter_finds_the_exposure_of_any_light() {
        for light in [0.5, 1e-2, 1e-5] {
            let mean = |factor: f32| 255.0 * (light * f64::from(factor)).min(1.0).sqrt();
            let meter = LightMeter::settled(18.0, mean);
            assert!(
                (mean(meter.factor() as f32) - TARGET).abs() < 2.0,
                "{light}"
            );
        }
        let dark = LightMeter::settled(3.0, |_| 0.0);
        assert!((2.9..3.0).contains(&dark.stops));
        let before = LightMeter { stops: 1.0 };
        assert_eq!(before.towards(dark, 5.0, 0.0), dark);
        let half = before.towards(LightMeter { stops: 3.0 }, 1.0, 1.0 / std::f64::consts::LN_2);
        assert!((half.stops - 2.0).abs() < 1e-9);
    }

    #[test]
    fn exposure_changes_gradually() {
        let mut exposure = AutoExposure::default();
        exposure.learn(&seen(236.0, &exposure), 0.1);
        // 2 stops too bright, of which a quarter is corrected now.
        assert!((0.5..0.7).contains(&exposure.factor()), "{exposure:?}");
    }

    #[test]
    fn black_white_and_empty_images_stay_within_bounds() {
        let mut exposure = AutoExposure::default();
        (0..99).for_each(|_| exposure.learn(&[0; 3000], 1.0));
        assert_eq!(exposure.factor(), 4.0);
        (0..99).for_each(|_| exposure.learn(&[255; 3000], f64::INFINITY));
        assert_eq!(exposure.factor(), 0.25);
        let before = exposure;
        exposure.learn(&[], 1.0);
        assert_eq!(exposure, before);
    }
}
