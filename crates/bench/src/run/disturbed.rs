//! Fixes made from the truth by disturbing it, to try localizers with before there are real ones: made here, handed to an agent from outside, named in the results.

use std::str::FromStr;

use nalgebra::{Isometry2, Matrix3, Vector2};
use openbench_core::{Observation, Pose2, SimTime};
use openbench_localization::{Fix, FixSource};
use openbench_sim::noise::Noise;

use crate::run::truth::TruthHandle;

/// Seconds between two fixes.
const EVERY: f64 = 1.0;
/// Deviations beyond which one is to be thought false.
const CREDIBLE: f64 = 3.0;
/// Stream of random numbers, beside those of sensors and traffic.
const STREAM: u64 = 32;

/// How the truth is disturbed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disturbance {
    /// Deviation along x and along y, metres.
    pub noise: f64,
    /// Share of fixes that are false,
    pub falsehoods: f64,
    /// and how far off they are at most, metres.
    pub far: f64,
    /// How far off all of them are, metres, to the east.
    pub bias: f64,
}

impl Default for Disturbance {
    fn default() -> Self {
        Self {
            noise: 1.0,
            falsehoods: 0.3,
            far: 50.0,
            bias: 0.0,
        }
    }
}

/// Words that are no disturbance.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no disturbance; write NOISE,SHARE,FAR or NOISE,SHARE,FAR,BIAS: metres above 0, a share from 0 to 1 of false fixes, up to how many metres these are off, metres"
)]
pub struct DisturbanceError(pub String);

impl FromStr for Disturbance {
    type Err = DisturbanceError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let numbers: Option<Vec<f64>> = text
            .split(',')
            .map(|word| word.trim().parse().ok())
            .collect();
        let it = match numbers.as_deref() {
            Some(&[noise, falsehoods, far]) => Self {
                noise,
                falsehoods,
                far,
                bias: 0.0,
            },
            Some(&[noise, falsehoods, far, bias]) => Self {
                noise,
                falsehoods,
                far,
                bias,
            },
            _ => return Err(DisturbanceError(text.to_owned())),
        };
        let sound = (1e-3..1e4).contains(&it.noise)
            && (0.0..=1.0).contains(&it.falsehoods)
            && (0.0..1e6).contains(&it.far)
            && it.bias.abs() < 1e6;
        sound
            .then_some(it)
            .ok_or_else(|| DisturbanceError(text.to_owned()))
    }
}

/// The truth, disturbed.
#[derive(Debug, Clone)]
pub struct DisturbedTruth {
    truth: TruthHandle,
    disturbance: Disturbance,
    seed: u64,
    noise: Noise,
    last: Option<SimTime>,
}

impl DisturbedTruth {
    /// Fixes from `truth`.
    pub fn new(truth: TruthHandle, disturbance: Disturbance, seed: u64) -> Self {
        Self {
            truth,
            disturbance,
            seed,
            noise: Noise::new(seed, STREAM),
            last: None,
        }
    }
}

impl FixSource for DisturbedTruth {
    fn name(&self) -> &str {
        "disturbed-truth"
    }

    fn reset(&mut self) {
        (self.noise, self.last) = (Noise::new(self.seed, STREAM), None);
    }

    fn update(&mut self, observation: &Observation<'_>, near: Pose2) -> Option<Fix> {
        let (
            stamp,
            Disturbance {
                noise,
                falsehoods,
                far,
                bias,
            },
        ) = (observation.time, self.disturbance);
        if self
            .last
            .is_some_and(|last| stamp <= last || stamp.since(last).as_secs_f64() < EVERY)
        {
            return None;
        }
        self.last = Some(stamp);
        let off = if self.noise.uniform() < falsehoods {
            let (angle, distance) = (
                self.noise.uniform() * std::f64::consts::TAU,
                self.noise.uniform() * far,
            );
            Vector2::new(libm::cos(angle), libm::sin(angle)) * distance
        } else {
            Vector2::new(self.noise.normal(), self.noise.normal()) * noise
        };
        let there = self.truth.at(stamp);
        let information = 1.0 / (noise * noise);
        Some(Fix {
            stamp,
            // Headings are not measured.
            pose: Isometry2::new(Vector2::new(there.x + bias, there.y) + off, near.yaw),
            information: Matrix3::from_diagonal(&[information, information, 0.0].into()),
            credible: CREDIBLE,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::{Camera, Image};
    use std::sync::Arc;

    struct Blind;
    impl Camera for Blind {
        fn image(&self) -> Option<Arc<Image>> {
            None
        }
    }

    #[test]
    fn words_are_read_or_refused() {
        assert_eq!("1,0.3,50".parse(), Ok(Disturbance::default()));
        assert_eq!("2, 0, 0, -1".parse::<Disturbance>().unwrap().bias, -1.0);
        for wrong in [
            "",
            "1",
            "0,0.3,50",
            "1,1.1,50",
            "1,0.3,nan",
            "1,0.3,50,inf",
            "1,2,3,4,5",
        ] {
            assert!(
                wrong
                    .parse::<Disturbance>()
                    .unwrap_err()
                    .to_string()
                    .contains("NOISE"),
                "{wrong}"
            );
        }
    }

    #[test]
    fn the_truth_is_disturbed_as_much_as_was_asked() {
        let truth = TruthHandle::default();
        let mut fixes = DisturbedTruth::new(truth.clone(), Disturbance::default(), 5);
        let mut off = Vec::new();
        for tick in 0..40_000_u64 {
            let time = SimTime::from_millis(50 * tick);
            truth.set(time, Pose2::new(7.0, 3.0, 0.0));
            let seen = Observation {
                time,
                imu: &[],
                wheels: &[],
                scan: None,
                gnss: None,
                camera: &Blind,
            };
            let fix = fixes.update(&seen, Pose2::default());
            off.extend(
                fix.map(|fix| (fix.pose.translation.vector - Vector2::new(7.0, 3.0)).norm()),
            );
        }
        assert_eq!(off.len(), 2000);
        let far = off.iter().filter(|off| **off > 4.0).count();
        // Of three in ten 46 of 50 are farther.
        assert!(
            (490..620).contains(&far) && off.iter().all(|off| *off < 50.0),
            "{far}"
        );
    }
}
