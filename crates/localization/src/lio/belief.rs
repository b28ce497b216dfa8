//! What the filter knows at an instant.

use openbench_core::SimTime;

use super::state::{Covariance, State};

/// A state at an instant, and its covariance.
#[derive(Debug, Clone)]
pub(super) struct Belief {
    pub(super) stamp: SimTime,
    pub(super) state: State,
    pub(super) covariance: Covariance,
}

impl Belief {
    /// Adds the variance of a standard deviation to three components of the error; `first` is
    /// where they begin, see [`at`](super::state::at).
    pub(super) fn add_deviation(&mut self, first: usize, deviation: f64) {
        for i in first..first + 3 {
            self.covariance[(i, i)] += deviation * deviation;
        }
    }

    /// The same relative to the map as that is tilted. Of the covariance only the pose's part is
    /// converted.
    pub(super) fn in_map(&self) -> Self {
        let state = self.state.in_map();
        let jacobian = state.in_map_jacobian::<6>();
        let pose = jacobian * self.covariance * jacobian.transpose();
        let mut covariance = self.covariance;
        covariance.fixed_view_mut::<6, 6>(0, 0).copy_from(&pose);
        Self {
            stamp: self.stamp,
            state,
            covariance,
        }
    }
}
