//! How probable poses are, from how well they explain what was seen.
//!
//! A conditional logit (D. McFadden, *Conditional logit analysis of qualitative choice behavior*,
//! 1974): the robot is at one of the candidates, or at none of them. The logit of a candidate is
//! the sum of its features times the weights, and the logit of none is zero. The weights are fitted
//! to drives in training worlds (`benchmarks/localization/fit.py`).

use super::explain::Explained;
use super::nearness::Nearness;
use super::refine::Refined;

/// Number of quantities that each have a weight,
const SINGLE: usize = 14;
/// and those whose products have one too, as indices: closeness, facades on walls over those near
/// and around walls, least information, and how far buildings are off.
const PAIRED: [usize; 5] = [3, 4, 5, 11, 12];
/// Number of features.
pub const FEATURES: usize = SINGLE + PAIRED.len() * (PAIRED.len() + 1) / 2;
/// What a probability is computed from, in the order of the weights.
pub type Features = [f64; FEATURES];

/// The weight of each feature.
#[rustfmt::skip]
const WEIGHTS: Features = [
    -1.762, -0.062, -0.598, -0.700, -0.372, 2.088, 0.542, -0.961, -0.216, -0.480, 1.472, -0.884,
    -1.040, -1.087,
    // Products of closeness, its square first,
    -0.102, 0.089, 0.008, 0.640, 1.533,
    // of facades on walls over those near walls,
    0.446, -1.233, 0.882, 0.665,
    // and over those around walls,
    0.532, -0.540, 0.153,
    // of the least information,
    0.212, -0.840,
    // and of how far buildings are off.
    -2.362,
];

/// Attempts beside the map count a fifth in the fit, as if few robots were there. Of a robot that
/// may be anywhere they should count as much as others. By Bayes' rule the odds of none of the
/// candidates are five times as high then.
const BESIDE_ODDS: f64 = 5.0;

/// What speaks for a candidate.
#[derive(Debug, Clone, Copy)]
pub struct Merits<'a> {
    /// Where it is, refined.
    pub refined: &'a Refined,
    /// Where facades are relative to walls.
    pub nearness: Nearness,
    /// What it explains of the free ground.
    pub explained: &'a Explained,
    /// How much more it costs than the cheapest one, nats.
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
        with_products([
            1.0,
            self.more / 10.0,
            self.more_misfit / 10.0,
            // Not the share of all facades that are on walls, nor the cost, which falls with it: of
            // a right pose too it is small, where the map lacks much of what is seen.
            logit(self.refined.closeness_of_matched()),
            self.nearness.on_over_near(),
            self.nearness.on_over_around(),
            logit(self.explained.met),
            libm::log(0.01 + self.explained.through),
            libm::log(0.02 + self.explained.towards),
            libm::log(1.0 + self.pieces as f64),
            libm::log(1.0 + self.nearness.on_wall as f64),
            libm::log(0.1 + self.refined.weakest()),
            self.refined.building_m,
            self.surprise,
        ])
    }
}

/// Appends the products of the paired ones, squares among them. In a sum of single quantities a
/// close fit counts as much for a pose that a single wall determines as for one that many do.
fn with_products(single: [f64; SINGLE]) -> Features {
    let mut features = [0.0; FEATURES];
    let (singles, products) = features.split_at_mut(SINGLE);
    singles.copy_from_slice(&single);
    let pairs = (0..PAIRED.len()).flat_map(|i| (i..PAIRED.len()).map(move |j| (i, j)));
    for (product, (i, j)) in products.iter_mut().zip(pairs) {
        *product = single[PAIRED[i]] * single[PAIRED[j]];
    }
    features
}

/// Of a share; finite at its ends.
fn logit(share: f64) -> f64 {
    libm::log((share + 0.02) / (1.02 - share))
}

/// The probability of each candidate of an attempt. They sum up to less than one, since the robot
/// may be at none of them. `is_bounded` tells whether more is known of its start than that it may
/// be anywhere.
pub fn probabilities(candidates: &[Features], is_bounded: bool) -> Vec<f64> {
    let logit = |features: &Features| -> f64 {
        let weighted = features.iter().zip(WEIGHTS);
        let sum: f64 = weighted.map(|(feature, weight)| feature * weight).sum();
        if sum.is_nan() { f64::NEG_INFINITY } else { sum }
    };
    let logits: Vec<f64> = candidates.iter().map(logit).collect();
    // Relative to the largest, so that none overflows.
    let most = logits.iter().copied().fold(0.0, f64::max);
    let odds: Vec<f64> = logits.iter().map(|logit| libm::exp(logit - most)).collect();
    let of_none = if is_bounded { 1.0 } else { BESIDE_ODDS };
    let all = odds.iter().sum::<f64>() + of_none * libm::exp(-most);
    odds.into_iter().map(|odds| odds / all).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A good pose, but for what is changed.
    fn good(change: impl Fn(&mut [f64; SINGLE])) -> Features {
        let mut single = [
            1.0,
            0.0,
            0.0,
            logit(0.95),
            3.0,
            2.5,
            logit(0.9),
            -4.6,
            -0.5,
            5.0,
            5.5,
            1.0,
            0.8,
            9.0,
        ];
        change(&mut single);
        with_products(single)
    }

    #[test]
    fn the_better_one_of_two_is_more_probable_and_both_leave_room_for_none() {
        let poor = good(|features| {
            features[4] = 0.5;
            features[5] = 0.3;
        });
        let found = probabilities(&[poor, good(|_| {})], true);
        assert!(
            found[1] > found[0] && found.iter().sum::<f64>() < 1.0,
            "{found:?}"
        );
        // Alone, it is more probable than beside another one.
        assert!(probabilities(&[good(|_| {})], true)[0] > found[1]);
    }

    #[test]
    fn a_robot_that_may_be_anywhere_is_likelier_at_none() {
        let odds = |is_bounded: bool| {
            let probability = probabilities(&[good(|_| {})], is_bounded)[0];
            probability / (1.0 - probability)
        };
        assert!((odds(true) / odds(false) - BESIDE_ODDS).abs() < 1e-6);
    }

    #[test]
    fn products_follow_the_single_ones_each_pair_once() {
        let single = std::array::from_fn(|i| i as f64);
        let features = with_products(single);
        assert_eq!(features[..SINGLE], single);
        assert_eq!(
            features[SINGLE..],
            [
                9.0, 12.0, 15.0, 33.0, 36.0, 16.0, 20.0, 44.0, 48.0, 25.0, 55.0, 60.0, 121.0,
                132.0, 144.0
            ]
        );
    }

    #[test]
    fn the_same_fit_says_more_where_more_facades_are_on_walls() {
        let of = |on_wall: f64| {
            let merits = good(|single| single[10] = libm::log(1.0 + on_wall));
            probabilities(&[merits], true)[0]
        };
        assert!(of(50.0) < of(150.0) && of(150.0) < of(400.0));
    }

    #[test]
    fn what_was_improbable_beforehand_still_is() {
        let far = good(|features| features[13] = 14.0);
        let near = good(|_| {});
        assert!(probabilities(&[far], true)[0] < probabilities(&[near], true)[0]);
    }

    #[test]
    fn no_logit_is_too_large() {
        let huge = good(|features| features[10] = 1e6);
        assert_eq!(probabilities(&[huge, good(|_| {})], true), [1.0, 0.0]);
        let none = good(|features| features[12] = f64::NAN);
        assert_eq!(probabilities(&[none, huge], true), [0.0, 1.0]);
        assert!(probabilities(&[], true).is_empty());
    }
}
