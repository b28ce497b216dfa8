//! What is wrong with the camera.

use openbench_core::{Distortion, PlanePoint};
use openbench_sim::noise::Noise;
use openbench_sim::{CameraErrors, LensBuild, LensDrop};

use super::level::{Condition, check_ranges};

/// Stream of random numbers, distinct from those of sensors, traffic, fixes, starts and robots.
const RANDOM_STREAM: u64 = 35;
/// Distance of an image's corners from its middle, in focal lengths, with some room for the errors
/// of a lens.
const CORNER: f64 = 1.1;
/// Radii of drops, shares of the image's width.
const DROP_RADII: [f64; 2] = [0.02, 0.06];
/// Largest numbers of radial and of tangential distortion.
const MOST_RADIAL: f64 = 0.5;
const MOST_TANGENTIAL: f64 = 0.02;

/// Whether the corner of an image is found again after the lens has moved it: the iteration that
/// straightens images must converge.
fn straightens(distortion: &Distortion) -> bool {
    const PRECISION: f64 = 1e-6;
    let corner = PlanePoint {
        x: 0.8 * CORNER,
        y: 0.6 * CORNER,
    };
    let again = distortion.distort(distortion.undistort(corner));
    again.is_some_and(|again| {
        // False for NaN as well.
        libm::hypot(again.x - corner.x, again.y - corner.y) < PRECISION
    })
}

/// The lens of one camera of a kind, with drops of rain besides its own.
pub(crate) fn draw_lens(errors: &CameraErrors, rain: u32, seed: u64) -> LensBuild {
    let mut noise = Noise::new(seed, RANDOM_STREAM);
    // In this order whatever is off, so that one number changes nothing about the others.
    let [focal, k1, k2, p1, p2] = std::array::from_fn(|_| noise.normal());
    let off = |number: f64, drawn: f64| number * (1.0 + errors.distortion_error * drawn);
    let drawn = Distortion {
        k1: off(errors.k1, k1),
        k2: off(errors.k2, k2),
        p1: off(errors.p1, p1),
        p2: off(errors.p2, p2),
    };
    let drop = |_| {
        let [x, y, size] = std::array::from_fn(|_| noise.uniform());
        let [least, most] = DROP_RADII;
        LensDrop {
            x,
            y,
            radius: least + size * (most - least),
        }
    };
    let drops = (0..errors.drops + rain).map(drop).collect();
    LensBuild {
        focal: (1.0 + errors.focal_error * focal).clamp(0.8, 1.25),
        // A lens that folds shows no picture. None of the levels comes near to that.
        distortion: if drawn.reaches(CORNER) && straightens(&drawn) {
            drawn
        } else {
            errors.distortion()
        },
        drops,
    }
}

impl Condition for CameraErrors {
    const KEY: &'static str = "camera";
    const LEVELS: &'static [(&'static str, Self)] = &[
        ("perfect", Self::PERFECT),
        (
            "good",
            Self {
                full_well: 12_000.0,
                read_noise: 4.0,
                exposure_ms: 0.2,
                longest_exposure_ms: 15.0,
                readout_ms: 10.0,
                k1: -0.05,
                focal_error: 0.001,
                distortion_error: 0.02,
                vignetting: 0.15,
                ..Self::PERFECT
            },
        ),
        (
            "cheap",
            Self {
                full_well: 4000.0,
                read_noise: 8.0,
                exposure_ms: 0.5,
                longest_exposure_ms: 33.0,
                readout_ms: 25.0,
                exposure_lag_s: 1.0,
                k1: -0.15,
                k2: 0.02,
                p1: 0.0005,
                p2: -0.0005,
                focal_error: 0.003,
                distortion_error: 0.05,
                vignetting: 0.35,
                drops: 4,
            },
        ),
    ];

    fn check(&self) -> Result<(), String> {
        let numbers = [
            ("full_well", self.full_well, 1e6),
            ("read_noise", self.read_noise, 1e4),
            ("exposure_ms", self.exposure_ms, 50.0),
            ("longest_exposure_ms", self.longest_exposure_ms, 50.0),
            ("readout_ms", self.readout_ms, 50.0),
            ("exposure_lag_s", self.exposure_lag_s, 60.0),
            ("focal_error", self.focal_error, 0.1),
            ("distortion_error", self.distortion_error, 1.0),
            ("vignetting", self.vignetting, 1.0),
            ("drops", f64::from(self.drops), 100.0),
        ];
        check_ranges(&numbers)?;
        let either_way = [
            ("k1", self.k1, MOST_RADIAL),
            ("k2", self.k2, MOST_RADIAL),
            ("p1", self.p1, MOST_TANGENTIAL),
            ("p2", self.p2, MOST_TANGENTIAL),
        ];
        for (key, value, most) in either_way {
            // False for NaN as well.
            if !(-most..=most).contains(&value) {
                return Err(format!(
                    "{key} = {value}: give a number from -{most} to {most}"
                ));
            }
        }
        if self.read_noise > 0.0 && self.full_well == 0.0 {
            return Err("read_noise needs a full_well above 0".to_owned());
        }
        if !self.distortion().reaches(CORNER) || !straightens(&self.distortion()) {
            return Err(format!(
                "k1 = {}, k2 = {}: the image would fold before its corners; give smaller numbers",
                self.k1, self.k2
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perfect_camera_has_a_perfect_lens() {
        assert_eq!(
            draw_lens(&CameraErrors::PERFECT, 0, 5),
            LensBuild::default()
        );
    }

    #[test]
    fn a_lens_is_nearly_as_described_and_differs_between_seeds() {
        let cheap = CameraErrors::LEVELS[2].1;
        let (lens, other) = (draw_lens(&cheap, 0, 5), draw_lens(&cheap, 0, 6));
        assert_ne!(lens, other);
        assert_eq!(lens.drops.len(), 4);
        assert!((lens.focal - 1.0).abs() < 0.02 && lens.focal != 1.0);
        assert!((lens.distortion.k1 / cheap.k1 - 1.0).abs() < 0.3);
        let dry = CameraErrors { drops: 0, ..cheap };
        assert_eq!(draw_lens(&dry, 9, 5).distortion, lens.distortion);
    }

    #[test]
    fn every_level_passes_its_own_check() {
        for (name, level) in CameraErrors::LEVELS {
            assert_eq!(level.check(), Ok(()), "{name}");
        }
        let folding = CameraErrors {
            k1: -0.4,
            ..CameraErrors::PERFECT
        };
        assert!(folding.check().unwrap_err().contains("would fold"));
        // Does not fold, but is not straightened by the iteration.
        let stubborn = CameraErrors {
            k1: -0.5,
            k2: 0.5,
            ..CameraErrors::PERFECT
        };
        assert!(stubborn.check().unwrap_err().contains("would fold"));
        let hissing = CameraErrors {
            read_noise: 8.0,
            ..CameraErrors::PERFECT
        };
        assert!(hissing.check().unwrap_err().contains("full_well"));
        let wild = CameraErrors {
            p1: f64::NAN,
            ..CameraErrors::PERFECT
        };
        assert!(wild.check().unwrap_err().contains("p1 = NaN"));
    }
}
