//! A graph: poses, and what was measured of them.

use nalgebra::{SMatrix, SVector};

use super::pose::Pose;

/// A measured way between two poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge<P, const D: usize> {
    /// From which pose.
    pub from: usize,
    /// To which.
    pub to: usize,
    /// The way, in the frame of the first.
    pub measured: P,
    /// One over covariance; its frame is that of the measured end.
    pub information: SMatrix<f64, D, D>,
}

/// A measured pose. Its information may lack directions that were not measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Prior<P, const D: usize> {
    /// Which pose.
    pub at: usize,
    /// Where it is.
    pub measured: P,
    /// One over covariance; its frame is that of the measured pose.
    pub information: SMatrix<f64, D, D>,
    /// Deviations beyond which it is thought to be false: truncated least squares. Infinite for what is always right.
    pub credible: f64,
}

/// Poses, edges and priors.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Graph<P, const D: usize> {
    /// Where the poses are thought to be.
    pub poses: Vec<P>,
    /// Ways between them.
    pub edges: Vec<Edge<P, D>>,
    /// Measured poses.
    pub priors: Vec<Prior<P, D>>,
    /// Poses that stay where they are.
    pub held: Vec<usize>,
}

impl<P: Pose<D>, const D: usize> Edge<P, D> {
    /// How far the poses disagree with it.
    pub fn residual(&self, poses: &[P]) -> SVector<f64, D> {
        self.disagreement(poses).distance()
    }

    /// Z⁻¹ Xᵢ⁻¹ Xⱼ
    pub(super) fn disagreement(&self, poses: &[P]) -> P {
        self.measured
            .back()
            .then(&poses[self.from].back().then(&poses[self.to]))
    }
}

impl<P: Pose<D>, const D: usize> Prior<P, D> {
    /// How far the pose disagrees with it.
    pub fn residual(&self, poses: &[P]) -> SVector<f64, D> {
        self.disagreement(poses).distance()
    }

    /// Z⁻¹ X
    pub(super) fn disagreement(&self, poses: &[P]) -> P {
        self.measured.back().then(&poses[self.at])
    }
}

/// Whether it may be one over a covariance, or nothing along some directions, but for rounding.
pub(super) fn is_information<const D: usize>(information: &SMatrix<f64, D, D>) -> bool {
    const ROUNDING: f64 = 1e-9;
    let largest = information.amax();
    // Scaled, so that none of the numbers overflows.
    largest == 0.0
        || (information / largest + SMatrix::<f64, D, D>::identity() * ROUNDING)
            .cholesky()
            .is_some()
}

impl<P: Pose<D>, const D: usize> Graph<P, D> {
    /// The sum of squared residuals in deviations. A prior counts no more than if it were just credible.
    pub fn chi2(&self) -> f64 {
        let edges = self
            .edges
            .iter()
            .map(|edge| square(&edge.residual(&self.poses), &edge.information));
        let priors = self.priors.iter().map(|prior| {
            square(&prior.residual(&self.poses), &prior.information)
                .min(prior.credible * prior.credible)
        });
        edges.sum::<f64>() + priors.sum::<f64>()
    }

    /// Poses that nothing would keep from drifting off: the first one of each part that hangs together, where no prior says where it is.
    pub(super) fn anchors(&self) -> Vec<usize> {
        let mut parent: Vec<usize> = (0..self.poses.len()).collect();
        fn root(parent: &mut [usize], mut i: usize) -> usize {
            while parent[i] != i {
                parent[i] = parent[parent[i]];
                i = parent[i];
            }
            i
        }
        for edge in &self.edges {
            let (a, b) = (root(&mut parent, edge.from), root(&mut parent, edge.to));
            parent[a.max(b)] = a.min(b);
        }
        let mut kept = vec![false; self.poses.len()];
        for at in self
            .priors
            .iter()
            .map(|prior| prior.at)
            .chain(self.held.iter().copied())
        {
            kept[root(&mut parent, at)] = true;
        }
        (0..self.poses.len())
            .filter(|i| parent[*i] == *i && !kept[*i])
            .collect()
    }
}

/// A residual in deviations, squared.
pub(super) fn square<const D: usize>(
    residual: &SVector<f64, D>,
    information: &SMatrix<f64, D, D>,
) -> f64 {
    let square = residual.dot(&(information * residual));
    // Rounding may leave it below; `max` would make a number of what is none.
    if square < 0.0 { 0.0 } else { square }
}
