//! Automatic exposure, as cheap cameras have it: the mean brightness of one image sets the exposure of the next.
//!
//! A proportional controller on the logarithm of the light, whose target is the mid-grey that light meters are calibrated to
//! (18 % of white, ISO 2720; 118 of 255 in sRGB). Cameras for robots expose in the same way, with a target grey value and bounds
//! (FLIR Firefly, "Auto Algorithm Control"; Basler, "Exposure Auto").

/// Mean grey value that is aimed at, sRGB, 0 to 255.
const TARGET: f64 = 118.0;
/// Time in which the exposure comes nearer to what it should be by the factor e, seconds.
const SETTLING: f64 = 0.3;
/// How far the exposure leaves that of the scene's own light, in stops: powers of two.
const STOPS: f64 = 2.0;
/// One pixel of so many is measured. No divisor of usual widths, so that all columns have their turn.
const STRIDE: usize = 61;

/// The exposure of a camera that adjusts it by itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AutoExposure {
    stops: f64,
}

impl AutoExposure {
    /// By how much the light is multiplied: 1/4 to 4.
    pub fn factor(&self) -> f32 {
        libm::exp2(self.stops) as f32
    }

    /// Learns from an image (RGB, sRGB) taken with the present exposure, the next coming `seconds` later or so.
    pub fn learn(&mut self, rgb: &[u8], seconds: f64) {
        let share = 1.0 - libm::exp(-seconds.max(0.0) / SETTLING);
        self.stops = (self.stops + share * missing(rgb)).clamp(-STOPS, STOPS);
    }

    /// The exposure that such an image, taken with the factor 1, asks for in the long run.
    pub fn settled(rgb: &[u8]) -> Self {
        Self {
            stops: missing(rgb).clamp(-STOPS, STOPS),
        }
    }
}

/// Stops between an image's mean and the target. Grey values go with the square root of the light.
fn missing(rgb: &[u8]) -> f64 {
    2.0 * libm::log2(TARGET / mean(rgb).max(1.0))
}

/// Mean grey value of some of the pixels, weighted as ITU-R BT.601 does.
fn mean(rgb: &[u8]) -> f64 {
    let grey =
        |p: &[u8]| (77 * u64::from(p[0]) + 150 * u64::from(p[1]) + 29 * u64::from(p[2])) >> 8;
    let (sum, count) = rgb
        .chunks_exact(3)
        .step_by(STRIDE)
        .fold((0, 0), |(s, n), p| (s + grey(p), n + 1));
    if count == 0 {
        TARGET
    } else {
        sum as f64 / count as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a camera sees of a grey that has this value at the exposure 1.
    fn seen(grey: f64, exposure: &AutoExposure) -> Vec<u8> {
        vec![(grey * f64::from(exposure.factor()).sqrt()) as u8; 3 * 640 * 48]
    }

    #[test]
    fn grey_becomes_mid_grey_within_a_second() {
        for grey in [70.0, 118.0, 220.0] {
            let mut exposure = AutoExposure::default();
            (0..10).for_each(|_| exposure.learn(&seen(grey, &exposure), 0.1));
            let then = mean(&seen(grey, &exposure));
            assert!((then - TARGET).abs() < 6.0, "{grey} became {then}");
            assert!(
                (mean(&seen(
                    grey,
                    &AutoExposure::settled(&seen(grey, &AutoExposure::default()))
                )) - TARGET)
                    .abs()
                    < 2.0
            );
        }
    }

    #[test]
    fn it_does_not_leap() {
        let mut exposure = AutoExposure::default();
        exposure.learn(&seen(236.0, &exposure), 0.1);
        assert!(
            (0.5..0.7).contains(&exposure.factor()),
            "2 stops too bright, a quarter of them now: {exposure:?}"
        );
    }

    #[test]
    fn black_white_and_no_images_stay_within_bounds() {
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
