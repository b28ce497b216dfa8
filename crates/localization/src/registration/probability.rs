//! How probable poses are, from how well they explain what was seen.
//!
//! A conditional logit (D. McFadden, *Conditional logit analysis of qualitative choice behavior*,
//! 1974): the robot is at one of the candidates, or at none of them. The logit of a candidate is
//! the sum of its features times the weights, and the logit of none is zero. The weights are fitted
//! to drives in training worlds (`benchmarks/localization/fit.py`).

use super::explain::Explained;
use super::refine::Refined;

/// Number of features.
pub const FEATURES: usize = 14;
/// What a probability is computed from, in the order of the weights.
pub type Features = [f64; FEATURES];

/// What each feature says.
const WEIGHTS: Features = [
    -1.978, -0.055, 0.209, -0.301, 1.677, 2.015, 0.646, -1.102, -1.523, 0.496, 0.664, 1.668,
    -1.020, -1.536,
];

/// What speaks for a candidate.
#[derive(Debug, Clone, Copy)]
pub struct Merits<'a> {
    /// Where it is, refined.
    pub refined: &'a Refined,
    /// What it explains.
    pub explained: &'a Explained,
    /// What it costs, nats,
    pub cost: f64,
    /// and how much more than the cheapest one.
    pub more: f64,
    /// How much more the distances of facades from walls cost than at the pose that they fit best,
    /// nats.
    pub more_misfit: f64,
    /// Number of pieces of facades that voted.
    pub pieces: usize,
    /// How improbable it was beforehand, nats: minus the logarithm of the prior's density. In a
    /// larger space more poses fit by chance.
    pub surprise: f64,
}

impl Merits<'_> {
    /// As numbers to weigh.
    pub fn features(&self) -> Features {
        let pieces = self.pieces as f64;
        [
            1.0,
            self.more / 10.0,
            self.cost / (pieces + 10.0),
            self.more_misfit / 10.0,
            // Apart from each other: what the map lacks leaves facades on no wall, and those on
            // walls as close to them as ever.
            logit(self.refined.closeness_of_matched()),
            logit(self.refined.matched_share()),
            logit(self.explained.met),
            libm::log(0.01 + self.explained.through),
            libm::log(0.02 + self.explained.towards),
            libm::log(1.0 + pieces),
            libm::log(1.0 + self.refined.buildings.len() as f64),
            libm::log(0.1 + self.refined.weakest()),
            self.refined.building_m,
            self.surprise,
        ]
    }
}

/// Of a share; finite at its ends.
fn logit(share: f64) -> f64 {
    libm::log((share + 0.02) / (1.02 - share))
}

/// The probability of each candidate of an attempt. They sum up to less than one, since the robot
/// may be at none of them.
pub fn probabilities(candidates: &[Features]) -> Vec<f64> {
    let logit = |features: &Features| -> f64 {
        let weighted = features.iter().zip(WEIGHTS);
        let sum: f64 = weighted.map(|(feature, weight)| feature * weight).sum();
        if sum.is_nan() { f64::NEG_INFINITY } else { sum }
    };
    let logits: Vec<f64> = candidates.iter().map(logit).collect();
    // Relative to the largest, so that none overflows.
    let most = logits.iter().copied().fold(0.0, f64::max);
    let odds: Vec<f64> = logits.iter().map(|logit| libm::exp(logit - most)).collect();
    let all = odds.iter().sum::<f64>() + libm::exp(-most);
    odds.into_iter().map(|odds| odds / all).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A good pose, but for what is changed.
    fn good(change: impl Fn(&mut Features)) -> Features {
        let mut features = [
            1.0,
            0.0,
            0.5,
            0.0,
            logit(0.9),
            logit(0.95),
            logit(0.9),
            -4.6,
            -0.5,
            5.0,
            2.0,
            1.0,
            0.8,
            9.0,
        ];
        change(&mut features);
        features
    }

    #[test]
    fn the_better_one_of_two_is_more_probable_and_both_leave_room_for_none() {
        let poor = good(|features| features[5] = logit(0.5));
        let found = probabilities(&[poor, good(|_| {})]);
        assert!(
            found[1] > found[0] && found.iter().sum::<f64>() < 1.0,
            "{found:?}"
        );
        // Alone, it is more probable than beside another one.
        assert!(probabilities(&[good(|_| {})])[0] > found[1]);
    }

    #[test]
    fn what_was_improbable_beforehand_still_is() {
        let far = good(|features| features[13] = 14.0);
        assert!(probabilities(&[far])[0] < probabilities(&[good(|_| {})])[0]);
    }

    #[test]
    fn no_logit_is_too_large() {
        let huge = good(|features| features[11] = 1e6);
        assert_eq!(probabilities(&[huge, good(|_| {})]), [1.0, 0.0]);
        let none = good(|features| features[12] = f64::NAN);
        assert_eq!(probabilities(&[none, huge]), [0.0, 1.0]);
        assert!(probabilities(&[]).is_empty());
    }
}
