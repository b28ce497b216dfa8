//! What is wrong with a camera: noise, blur, a rolling shutter, a lens that bends and is dirty.

use openbench_core::{CameraIntrinsics, Distortion};
use serde::{Deserialize, Serialize};

/// Time in which the error of the exposure falls by the factor e, unless a suite says otherwise,
/// seconds.
const EXPOSURE_LAG_S: f64 = 0.3;

/// What is wrong with cameras of a kind. Shares are between 0 and 1; 0 is a perfect camera but for
/// the lag of the exposure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraErrors {
    /// Electrons of a white pixel; 0 without shot noise.
    pub full_well: f64,
    /// Standard deviation of reading a pixel, electrons.
    pub read_noise: f64,
    /// Time for which the shutter is open in the light of noon, milliseconds. Half the light takes
    /// twice as long.
    pub exposure_ms: f64,
    /// The longest such time, milliseconds. What is missing is amplified, and noise with it.
    pub longest_exposure_ms: f64,
    /// Time from reading the first row to reading the last one, milliseconds.
    pub readout_ms: f64,
    /// Time in which the error of the exposure falls by the factor e, seconds.
    pub exposure_lag_s: f64,
    /// Radial distortion with the square of the radius, as described in the briefing.
    pub k1: f64,
    /// The same with the fourth power.
    pub k2: f64,
    /// Tangential distortion, upright.
    pub p1: f64,
    /// Tangential distortion, across.
    pub p2: f64,
    /// Standard deviation of the focal length, a share of it.
    pub focal_error: f64,
    /// Standard deviation of each number of the distortion, a share of it.
    pub distortion_error: f64,
    /// Share of the light that the corners lose.
    pub vignetting: f64,
    /// Drops or smudges on the lens.
    pub drops: u32,
}

impl CameraErrors {
    /// A perfect camera.
    pub const PERFECT: Self = Self {
        full_well: 0.0,
        read_noise: 0.0,
        exposure_ms: 0.0,
        longest_exposure_ms: 0.0,
        readout_ms: 0.0,
        exposure_lag_s: EXPOSURE_LAG_S,
        k1: 0.0,
        k2: 0.0,
        p1: 0.0,
        p2: 0.0,
        focal_error: 0.0,
        distortion_error: 0.0,
        vignetting: 0.0,
        drops: 0,
    };

    /// Distortion of the lens as it is described.
    pub fn distortion(&self) -> Distortion {
        Distortion {
            k1: self.k1,
            k2: self.k2,
            p1: self.p1,
            p2: self.p2,
        }
    }

    /// How long the shutter is open, and how much the signal is amplified, at `factor` times the
    /// exposure of noon.
    pub(crate) fn exposure(&self, factor: f64) -> Exposure {
        let wanted_ms = self.exposure_ms * factor;
        let open_ms = wanted_ms.min(self.longest_exposure_ms.max(self.exposure_ms));
        let gain = if open_ms > 0.0 {
            wanted_ms / open_ms
        } else {
            factor
        };
        Exposure {
            seconds: open_ms * 1e-3,
            gain: gain.max(1.0),
        }
    }

    /// Variance of the signal for each unit of it, where 1 is white.
    pub(crate) fn shot_variance(&self, gain: f64) -> f64 {
        if self.full_well > 0.0 {
            gain / self.full_well
        } else {
            0.0
        }
    }

    /// Variance of a black signal, where 1 is white.
    pub(crate) fn read_variance(&self, gain: f64) -> f64 {
        if self.full_well > 0.0 {
            let deviation = gain * self.read_noise / self.full_well;
            deviation * deviation
        } else {
            0.0
        }
    }
}

impl Default for CameraErrors {
    fn default() -> Self {
        Self::PERFECT
    }
}

/// How an image is exposed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Exposure {
    /// Time for which the shutter is open.
    pub(crate) seconds: f64,
    /// Amplification of the signal, at least 1.
    pub(crate) gain: f64,
}

/// The lens of one camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LensBuild {
    /// Focal length relative to the described one.
    pub focal: f64,
    /// Distortion as it is.
    pub distortion: Distortion,
    /// What is on the glass.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drops: Vec<LensDrop>,
}

impl LensBuild {
    /// A described camera as it is with this lens.
    #[must_use]
    pub fn of(&self, described: CameraIntrinsics) -> CameraIntrinsics {
        // Exactly the same without errors, whatever the rounding of the angle.
        if self.focal == 1.0 {
            return CameraIntrinsics {
                distortion: self.distortion,
                ..described
            };
        }
        let half = f64::from(described.width) / 2.0;
        let focal_length = self.focal * described.focal_length();
        CameraIntrinsics {
            horizontal_fov: 2.0 * libm::atan(half / focal_length),
            distortion: self.distortion,
            ..described
        }
    }
}

impl Default for LensBuild {
    /// A clean lens as described, without distortion.
    fn default() -> Self {
        Self {
            focal: 1.0,
            distortion: Distortion::default(),
            drops: Vec::new(),
        }
    }
}

/// A drop or smudge on the lens, which blurs what is behind it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LensDrop {
    /// Middle, a share of the image's width from the left.
    pub x: f64,
    /// Middle, a share of the image's height from the top.
    pub y: f64,
    /// Radius, a share of the image's width.
    pub radius: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shutter_opens_longer_before_the_signal_is_amplified() {
        let camera = CameraErrors {
            full_well: 10_000.0,
            read_noise: 5.0,
            exposure_ms: 0.5,
            longest_exposure_ms: 20.0,
            ..CameraErrors::PERFECT
        };
        let noon = camera.exposure(1.0);
        assert_eq!((noon.seconds, noon.gain), (0.5e-3, 1.0));
        let night = camera.exposure(400.0);
        assert_eq!((night.seconds, night.gain), (20e-3, 10.0));
        assert!(camera.shot_variance(10.0) > 9.0 * camera.shot_variance(1.0));
        // A bright view is exposed shorter, and never with less than no gain.
        let glare = camera.exposure(0.25);
        assert_eq!((glare.seconds, glare.gain), (0.125e-3, 1.0));
    }

    #[test]
    fn a_perfect_camera_has_no_noise() {
        let exposure = CameraErrors::PERFECT.exposure(100.0);
        assert_eq!(exposure.seconds, 0.0);
        assert_eq!(CameraErrors::PERFECT.shot_variance(exposure.gain), 0.0);
        assert_eq!(CameraErrors::PERFECT.read_variance(exposure.gain), 0.0);
    }
}
