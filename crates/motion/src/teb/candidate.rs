//! Bands that compete, one of each homotopy class.

use crate::teb::classes::{Clusters, Passing, Signature};
use crate::trajectory::Trajectory;

/// Cost by which a band with a conflict is worse than any without.
const CONFLICT: f64 = 1e6;
/// A band that costs more than this many times the best, and [`DEAREST_MORE`], is dropped.
const DEAREST: f64 = 2.0;
/// See [`DEAREST`].
const DEAREST_MORE: f64 = 5.0;

/// A band that is kept from cycle to cycle.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The band.
    pub band: Trajectory,
    /// Its class.
    pub signature: Signature,
    /// Its cost after optimization.
    pub cost: f64,
    /// Seconds until it meets an obstacle, if it does.
    pub conflict: Option<f64>,
    /// Whether it suddenly costs much more than before: it may be in a local minimum that small
    /// steps do not leave.
    pub(crate) tangled: bool,
}

impl Candidate {
    /// A candidate that was not optimized yet.
    pub(super) fn new(band: Trajectory, clusters: &Clusters) -> Self {
        let signature = signature(clusters, &band);
        Self {
            band,
            signature,
            cost: 0.0,
            conflict: None,
            tangled: false,
        }
    }

    /// Its cost, with a penalty for a conflict that is the larger the sooner it is.
    fn worth(&self) -> f64 {
        self.cost + self.conflict.map_or(0.0, |at| CONFLICT / (1.0 + at))
    }
}

/// The class of a band.
pub(super) fn signature(clusters: &Clusters, band: &Trajectory) -> Signature {
    let passing = band.poses().iter().map(|k| Passing {
        point: k.pose.point(),
        time: k.time,
    });
    clusters.signature(passing)
}

/// The best candidate of each class, the best of all first. The candidate that was first stays so
/// unless another costs less than `hysteresis` times as much.
pub(super) fn best_of_each_class(
    mut candidates: Vec<Candidate>,
    hysteresis: f64,
) -> Vec<Candidate> {
    let mut worths: Vec<f64> = candidates.iter().map(Candidate::worth).collect();
    if let Some(first) = worths.first_mut() {
        *first *= hysteresis;
    }
    let best = (0..worths.len()).min_by(|&a, &b| worths[a].total_cmp(&worths[b]));
    let Some(best) = best else { return candidates };
    candidates.swap(0, best);
    let mut kept: Vec<Candidate> = Vec::with_capacity(candidates.len());
    for candidate in candidates {
        // The first one stays, whatever another of its class is worth: hysteresis has decided
        // already.
        match kept.iter().position(|k| k.signature == candidate.signature) {
            Some(0) => {}
            Some(i) if candidate.worth() < kept[i].worth() => kept[i] = candidate,
            Some(_) => {}
            None => kept.push(candidate),
        }
    }
    let dearest = DEAREST * kept[0].cost + DEAREST_MORE;
    let mut is_first = true;
    kept.retain(|candidate| {
        // The first is kept even with a conflict: how soon that is decides what the robot does.
        let is_competitive = candidate.conflict.is_none() && candidate.cost < dearest;
        std::mem::take(&mut is_first) || is_competitive
    });
    kept
}
