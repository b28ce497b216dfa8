//! Position fixes simulated by adding noise and outliers to the true pose.
//!
//! They test localizers before a real source of fixes exists. They are made here, injected into
//! the agent by name, and named in the results.

use std::str::FromStr;

use nalgebra::{Isometry2, Matrix3, Vector2};
use openbench_core::{Observation, Pose2, SimTime};
use openbench_localization::{Fix, FixSource, Track};
use openbench_sim::noise::Noise;

use crate::run::PosesOnMap;

/// Time between two fixes.
const INTERVAL_S: f64 = 1.0;
/// Normalized innovation above which a fix should be rejected, standard deviations.
const GATE_STANDARD_DEVIATIONS: f64 = 3.0;
/// Stream of random numbers, distinct from those of sensors and traffic.
const RANDOM_STREAM: u64 = 32;

/// Noise, outliers and bias of the simulated fixes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixNoise {
    /// Standard deviation along x and along y, metres.
    pub noise_m: f64,
    /// Share of fixes that are outliers, 0 to 1.
    pub outlier_share: f64,
    /// Maximum error of an outlier, metres; uniform in distance and direction.
    pub outlier_max_m: f64,
    /// Offset of all fixes to the east, metres.
    pub bias_m: f64,
}

impl Default for FixNoise {
    fn default() -> Self {
        Self {
            noise_m: 1.0,
            outlier_share: 0.3,
            outlier_max_m: 50.0,
            bias_m: 0.0,
        }
    }
}

/// A text that does not describe the noise of fixes.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` does not describe noise of fixes; write NOISE,SHARE,FAR or NOISE,SHARE,FAR,BIAS: \
     standard deviation in metres (above 0), share of outliers (0 to 1), maximum error of an \
     outlier in metres, offset to the east in metres"
)]
pub struct FixNoiseError(pub String);

impl FromStr for FixNoise {
    type Err = FixNoiseError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let numbers: Option<Vec<f64>> = text
            .split(',')
            .map(|number| number.trim().parse().ok())
            .collect();
        let noise = match numbers.as_deref() {
            Some(&[noise_m, outlier_share, outlier_max_m]) => Self {
                noise_m,
                outlier_share,
                outlier_max_m,
                bias_m: 0.0,
            },
            Some(&[noise_m, outlier_share, outlier_max_m, bias_m]) => Self {
                noise_m,
                outlier_share,
                outlier_max_m,
                bias_m,
            },
            _ => return Err(FixNoiseError(text.to_owned())),
        };
        if noise.is_valid() {
            Ok(noise)
        } else {
            Err(FixNoiseError(text.to_owned()))
        }
    }
}

impl FixNoise {
    /// Whether all numbers are in their ranges; NaN is in none.
    fn is_valid(&self) -> bool {
        // Without any noise, the information of a fix would be infinite.
        (1e-3..1e4).contains(&self.noise_m)
            && (0.0..=1.0).contains(&self.outlier_share)
            && (0.0..1e6).contains(&self.outlier_max_m)
            && self.bias_m.abs() < 1e6
    }
}

/// A source of fixes around the true pose.
#[derive(Debug, Clone)]
pub struct SimulatedFixes {
    truth: PosesOnMap,
    noise: FixNoise,
    seed: u64,
    random: Noise,
    last: Option<SimTime>,
}

impl SimulatedFixes {
    /// Fixes around the poses of `truth`; noise and outliers are drawn from `seed`.
    pub fn new(truth: PosesOnMap, noise: FixNoise, seed: u64) -> Self {
        Self {
            truth,
            noise,
            seed,
            random: Noise::new(seed, RANDOM_STREAM),
            last: None,
        }
    }
}

impl SimulatedFixes {
    fn is_due(&self, now: SimTime) -> bool {
        self.last
            // `since` is zero for an earlier time, so stamps that go back give no fix.
            .is_none_or(|last| now > last && now.since(last).as_secs_f64() >= INTERVAL_S)
    }

    /// The error of a fix, metres, without the bias.
    fn draw_error(&mut self) -> Vector2<f64> {
        let FixNoise {
            noise_m,
            outlier_share,
            outlier_max_m,
            ..
        } = self.noise;
        if self.random.uniform() < outlier_share {
            let angle = self.random.uniform() * std::f64::consts::TAU;
            let distance = self.random.uniform() * outlier_max_m;
            Vector2::new(libm::cos(angle), libm::sin(angle)) * distance
        } else {
            Vector2::new(self.random.normal(), self.random.normal()) * noise_m
        }
    }
}

impl FixSource for SimulatedFixes {
    fn name(&self) -> &str {
        "disturbed-truth"
    }

    fn reset(&mut self) {
        // From the start of the stream: after a reset, a localizer gets the same fixes again.
        self.random = Noise::new(self.seed, RANDOM_STREAM);
        self.last = None;
    }

    fn update(
        &mut self,
        observation: &Observation<'_>,
        near: Pose2,
        _track: &dyn Track,
    ) -> Option<Fix> {
        let stamp = observation.time;
        if !self.is_due(stamp) {
            return None;
        }
        self.last = Some(stamp);
        let FixNoise {
            noise_m, bias_m, ..
        } = self.noise;
        let error = self.draw_error();
        let truth = self.truth.pose_at(stamp);
        // The fix reports its regular noise only. A receiver does not know its outliers and its
        // bias.
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
    use openbench_core::{Camera, Image, Pose3};

    use crate::run::truth::{Instant, TruthHandle};
    use std::sync::Arc;

    struct Still;
    impl Track for Still {
        fn pose3_at(&self, _: SimTime) -> Pose3 {
            Pose3::identity()
        }
    }

    struct Blind;
    impl Camera for Blind {
        fn image(&self) -> Option<Arc<Image>> {
            None
        }
    }

    #[test]
    fn the_noise_of_fixes_is_parsed_or_rejected() {
        assert_eq!("1,0.3,50".parse(), Ok(FixNoise::default()));
        assert_eq!("2, 0, 0, -1".parse::<FixNoise>().unwrap().bias_m, -1.0);
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
                    .parse::<FixNoise>()
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
        let mut fixes = SimulatedFixes::new(truth.clone().into(), FixNoise::default(), 5);
        let mut off = Vec::new();
        for tick in 0..40_000_u64 {
            let time = SimTime::from_millis(50 * tick);
            truth.set(Instant {
                time,
                base_link: Pose2::new(7.0, 3.0, 0.0).to_pose3(0.0),
                ..Instant::default()
            });
            let seen = Observation {
                time,
                imu: &[],
                wheels: &[],
                scan: None,
                gnss: None,
                camera: &Blind,
            };
            let fix = fixes.update(&seen, Pose2::default(), &Still);
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
