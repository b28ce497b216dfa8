//! The iterated Kalman filter's update on the manifold of the state.
//!
//! W. Xu, F. Zhang, *FAST-LIO*, 2021, equations 16 to 20. The gain of equation 20 is used in its
//! information form, in the dimension of the state: sums over points are all that is needed of
//! them.

use nalgebra::{Cholesky, Const, SMatrix, SVector, Vector3};

use super::belief::Belief;
use super::matching::Cluster;
use super::plane_measurement::{Summary, measure};
use super::state::{Covariance, Error, SIZE, State, at};

/// At most this many iterations.
const MAX_ITERATIONS: usize = 6;
/// A smaller step ends the iterations: norm of metres and radians.
const CONVERGED: f64 = 1e-5;
/// Information that holds the position along degenerate directions, 1/m².
const HOLDING_INFORMATION: f64 = 1e10;

/// The belief before an update.
pub(super) struct Prior {
    state: State,
    information: Covariance,
    covariance: Covariance,
}

/// The state after an update.
pub(super) struct Posterior {
    pub(super) state: State,
    pub(super) covariance: Covariance,
    pub(super) summary: Summary,
}

impl Prior {
    /// `None` if the covariance has no inverse.
    pub(super) fn new(belief: &Belief) -> Option<Self> {
        let covariance = belief.covariance;
        let information = covariance.cholesky()?.inverse();
        Some(Self {
            state: belief.state.clone(),
            information,
            covariance,
        })
    }

    /// The normalized innovation squared (Y. Bar-Shalom, X. R. Li, T. Kirubarajan 2001, section
    /// 5.4) by the state after an update, over its expected value.
    ///
    /// The expected value is the number of dimensions that the scan measures; those that it
    /// measures in part are counted in part.
    pub(super) fn innovation(&self, state: &State, posterior: &Covariance) -> f64 {
        let error = state.minus(&self.state);
        // The entrywise product of symmetric matrices sums up to the trace of their product. For
        // each dimension that is 1 where the scan says nothing, and 0 where it says all.
        let measured = SIZE as f64 - self.information.component_mul(posterior).sum();
        error.dot(&(self.information * error)) / measured.max(1.0)
    }

    /// The state that agrees best with the prior and with the clusters of a scan, which observe `N`
    /// dimensions. The iterations begin at `state`. `None` if the equations have no solution.
    pub(super) fn update<const N: usize>(
        &self,
        mut state: State,
        clusters: &[Cluster],
    ) -> Option<Posterior> {
        let mut last = None;
        for _ in 0..MAX_ITERATIONS {
            let in_map = state.in_map();
            let measured = measure::<N>(&in_map, clusters);
            let jacobian = in_map.in_map_jacobian::<N>();
            let prior = self.about(&state, &measured.summary.degenerate);
            // Equation 20 in its information form: (P⁻¹ + Hᵀ R⁻¹ H) step = -gradient.
            let information =
                prior.information + jacobian.transpose() * measured.information * jacobian;
            let negative_gradient =
                prior.negative_gradient - jacobian.transpose() * measured.gradient;
            let factor = information.cholesky()?;
            let step = factor.solve(&negative_gradient);
            state = state.plus(&step);
            let summary = measured.summary;
            last = Some(Iteration {
                factor,
                prior_information: prior.information,
                summary,
            });
            if is_converged(&jacobian, &step) {
                break;
            }
        }
        last.map(|iteration| self.posterior(state, iteration))
    }

    /// The prior as equations for a step from `state`: equation 16 projects it there.
    fn about(&self, state: &State, degenerate: &[Vector3<f64>]) -> NormalEquations {
        let error = state.minus(&self.state);
        let projection = State::projection(&error);
        let mut equations = NormalEquations {
            information: projection.transpose() * self.information * projection,
            negative_gradient: -(projection.transpose() * (self.information * error)),
        };
        for direction in degenerate {
            equations.hold(direction, &error);
        }
        equations
    }

    fn posterior(&self, state: State, last: Iteration) -> Posterior {
        // Of the last linearization, which a step that has converged hardly changes.
        let covariance = last.factor.inverse();
        let kept = covariance * last.prior_information;
        let unmeasured = self.unmeasured(&last.summary.degenerate, &kept);
        Posterior {
            state,
            covariance: covariance + unmeasured,
            summary: last.summary,
        }
    }

    /// Covariance of what stays unknown since the position along degenerate directions is not
    /// measured. `kept` is how much the scan leaves of an error before it. (S. F. Schmidt's filter
    /// with states that are considered, not estimated.)
    fn unmeasured(&self, degenerate: &[Vector3<f64>], kept: &Covariance) -> Covariance {
        let mut sum = Covariance::zeros();
        let mut rest = self.covariance;
        // One direction after the other: the rest is independent of those before.
        for direction in degenerate {
            let column = rest.fixed_columns::<3>(at::POSITION) * direction;
            let variance = direction.dot(&column.fixed_rows::<3>(at::POSITION));
            if variance > 0.0 {
                let column = column / variance.sqrt();
                rest -= column * column.transpose();
                let column = kept * column;
                sum += column * column.transpose();
            }
        }
        sum
    }
}

/// Equations whose solution is a step of the state.
struct NormalEquations {
    information: Covariance,
    negative_gradient: Error,
}

impl NormalEquations {
    /// Holds the position along a degenerate direction at the prior; `error` is how far the state
    /// is from it.
    ///
    /// The direction itself is known to milliradians only. Where the position along it has long
    /// been unknown, the little that is measured across it would seem to measure it.
    fn hold(&mut self, direction: &Vector3<f64>, error: &Error) {
        let held = direction * HOLDING_INFORMATION;
        let mut block = self
            .information
            .fixed_view_mut::<3, 3>(at::POSITION, at::POSITION);
        block += held * direction.transpose();
        let offset = direction.dot(&error.fixed_rows::<3>(at::POSITION));
        let mut rows = self.negative_gradient.fixed_rows_mut::<3>(at::POSITION);
        rows -= held * offset;
    }
}

/// The equations of the last iteration, factored.
struct Iteration {
    factor: Cholesky<f64, Const<SIZE>>,
    prior_information: Covariance,
    summary: Summary,
}

/// Whether a step hardly changes what a scan observes.
fn is_converged<const N: usize>(jacobian: &SMatrix<f64, N, SIZE>, step: &Error) -> bool {
    let observed: SVector<f64, N> = jacobian * step;
    observed.norm() < CONVERGED
}
