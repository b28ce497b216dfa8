//! Position fixes simulated by adding noise and outliers to the true pose.
//!
//! They test localizers before a real source of fixes exists. They are made here, injected into
//! the agent by name, and named in the results.

use std::str::FromStr;

use nalgebra::{Isometry2, Matrix3, Vector2};
use openbench_core::{Observation, Pose2, SimTime};
use openbench_localization::{Fix, FixSource};
use openbench_sim::noise::Noise;

use crate::run::truth::TruthHandle;

/// Time between two fixes.
const INTERVAL_S: f64 = 1.0;
/// Normalized innovation above which a fix should be rejected, standard deviations.
const GATE_STANDARD_DEVIATIONS: f64 = 3.0;
/// Stream of random numbers, distinct from those of sensors and traffic.
const RANDOM_STREAM: u64 = 32;

/// Noise, outliers and bias of the simulated fixes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disturbance {
    /// Standard deviation along x and along y, metres.
    pub noise_m: f64,
    /// Share of fixes that are outliers, 0 to 1.
    pub outlier_share: f64,
    /// Maximum error of an outlier, metres; uniform in distance and direction.
    pub outlier_max_m: f64,
    /// Offset of all fixes to the east, metres.
    pub bias_m: f64,
}

impl Default for Disturbance {
    fn default() -> Self {
        Self {
            noise_m: 1.0,
            outlier_share: 0.3,
            outlier_max_m: 50.0,
            bias_m: 0.0,
        }
    }
}

/// A text that does not describe a disturbance.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no disturbance; write NOISE,SHARE,FAR or NOISE,SHARE,FAR,BIAS: standard deviation \
     in metres (above 0), share of outliers (0 to 1), maximum error of an outlier in metres, \
     offset to the east in metres"
)]
pub struct DisturbanceError(pub String);

impl FromStr for Disturbance {
    type Err = DisturbanceError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let numbers: Option<Vec<f64>> = text
            .split(',')
            .map(|number| number.trim().parse().ok())
            .collect();
        let (noise_m, outlier_share, outlier_max_m, bias_m) = match numbers.as_deref() {
            Some(&[noise, share, far]) => (noise, share, far, 0.0),
            Some(&[noise, share, far, bias]) => (noise, share, far, bias),
            _ => return Err(DisturbanceError(text.to_owned())),
        };
        let it = Self {
            noise_m,
            outlier_share,
            outlier_max_m,
            bias_m,
        };
        let is_valid = (1e-3..1e4).contains(&it.noise_m)
            && (0.0..=1.0).contains(&it.outlier_share)
            && (0.0..1e6).contains(&it.outlier_max_m)
            && it.bias_m.abs() < 1e6;
        is_valid
            .then_some(it)
            .ok_or_else(|| DisturbanceError(text.to_owned()))
    }
}

/// A source of fixes around the true pose.
#[derive(Debug, Clone)]
pub struct DisturbedTruth {
    truth: TruthHandle,
    disturbance: Disturbance,
    seed: u64,
    noise: Noise,
    last: Option<SimTime>,
}

impl DisturbedTruth {
    /// Fixes around the poses of `truth`; noise and outliers are drawn from `seed`.
    pub fn new(truth: TruthHandle, disturbance: Disturbance, seed: u64) -> Self {
        Self {
            truth,
            disturbance,
            seed,
            noise: Noise::new(seed, RANDOM_STREAM),
            last: None,
        }
    }
}

impl FixSource for DisturbedTruth {
    fn name(&self) -> &str {
        "disturbed-truth"
    }

    fn reset(&mut self) {
        (self.noise, self.last) = (Noise::new(self.seed, RANDOM_STREAM), None);
    }

    fn update(&mut self, observation: &Observation<'_>, near: Pose2) -> Option<Fix> {
        let Disturbance {
            noise_m,
            outlier_share,
            outlier_max_m,
            bias_m,
        } = self.disturbance;
        let stamp = observation.time;
        if self
            .last
            .is_some_and(|last| stamp <= last || stamp.since(last).as_secs_f64() < INTERVAL_S)
        {
            return None;
        }
        self.last = Some(stamp);
        let error = if self.noise.uniform() < outlier_share {
            let (angle, distance) = (
                self.noise.uniform() * std::f64::consts::TAU,
                self.noise.uniform() * outlier_max_m,
            );
            Vector2::new(libm::cos(angle), libm::sin(angle)) * distance
        } else {
            Vector2::new(self.noise.normal(), self.noise.normal()) * noise_m
        };
        let truth = self.truth.at(stamp);
        let information = 1.0 / (noise_m * noise_m);
        Some(Fix {
            stamp,
            // The heading is not measured: the estimate's own, with zero information.
            pose: Isometry2::new(Vector2::new(truth.x + bias_m, truth.y) + error, near.yaw),
            information: Matrix3::from_diagonal(&[information, information, 0.0].into()),
            max_deviations: GATE_STANDARD_DEVIATIONS,
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
    fn a_disturbance_is_parsed_or_rejected() {
        assert_eq!("1,0.3,50".parse(), Ok(Disturbance::default()));
        assert_eq!("2, 0, 0, -1".parse::<Disturbance>().unwrap().bias_m, -1.0);
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
    fn the_fixes_have_the_requested_share_of_outliers() {
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
        // Three in ten are outliers up to 50 m; 46 of 50 of these are beyond 4 m.
        assert!(
            (490..620).contains(&far) && off.iter().all(|off| *off < 50.0),
            "{far}"
        );
    }
}
