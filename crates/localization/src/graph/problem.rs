//! A graph: poses, and what was measured of them.

use nalgebra::{SMatrix, SVector};

use super::pose::Pose;

/// Rounding errors of information are no larger than this share of its largest entry.
const ROUNDING: f64 = 1e-9;

/// A measured motion between two poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge<P, const D: usize> {
    /// Index of the first pose.
    pub from: usize,
    /// Index of the second pose.
    pub to: usize,
    /// The second pose in the frame of the first.
    pub measured: P,
    /// Inverse of the covariance; its frame is that of the measured end.
    pub information: SMatrix<f64, D, D>,
}

/// A measured pose. Its information may lack directions that were not measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Prior<P, const D: usize> {
    /// Index of the pose.
    pub at: usize,
    /// Where it was measured to be.
    pub measured: P,
    /// Inverse of the covariance; its frame is that of the measured pose.
    pub information: SMatrix<f64, D, D>,
    /// A residual of more standard deviations than this makes it an outlier (truncated least
    /// squares). Infinite for a measurement that is always right.
    pub max_deviations: f64,
}

/// Poses, edges and priors.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Graph<P, const D: usize> {
    /// Estimated poses.
    pub poses: Vec<P>,
    /// Measured motions between them.
    pub edges: Vec<Edge<P, D>>,
    /// Measured poses.
    pub priors: Vec<Prior<P, D>>,
    /// Indices of poses that stay where they are.
    pub held: Vec<usize>,
}

/// An edge about the current poses: its residual, and how it changes with a small motion of each
/// pose in its own frame.
pub(super) struct LinearEdge<const D: usize> {
    pub(super) residual: SVector<f64, D>,
    pub(super) from: SMatrix<f64, D, D>,
    pub(super) to: SMatrix<f64, D, D>,
}

impl<P: Pose<D>, const D: usize> Edge<P, D> {
    /// By which motion the poses disagree with it.
    pub fn residual(&self, poses: &[P]) -> SVector<f64, D> {
        self.disagreement(poses).distance()
    }

    /// Z⁻¹ Xᵢ⁻¹ Xⱼ
    fn disagreement(&self, poses: &[P]) -> P {
        self.measured
            .back()
            .then(&poses[self.from].back().then(&poses[self.to]))
    }

    pub(super) fn linearized(&self, poses: &[P]) -> LinearEdge<D> {
        let off = self.disagreement(poses);
        let to = off.distance_jacobian();
        // Seen from the second pose, the first moves in the opposite direction.
        let back = poses[self.to].back().then(&poses[self.from]);
        let from = -to * back.adjoint();
        LinearEdge {
            residual: off.distance(),
            from,
            to,
        }
    }
}

impl<P: Pose<D>, const D: usize> Prior<P, D> {
    /// By which motion the pose disagrees with it.
    pub fn residual(&self, poses: &[P]) -> SVector<f64, D> {
        self.disagreement(poses).distance()
    }

    /// Z⁻¹ X
    pub(super) fn disagreement(&self, poses: &[P]) -> P {
        self.measured.back().then(&poses[self.at])
    }
}

/// Whether a matrix may be the inverse of a covariance, or zero along some directions, except for
/// rounding.
pub(super) fn is_information<const D: usize>(information: &SMatrix<f64, D, D>) -> bool {
    let largest = information.amax();
    if largest == 0.0 {
        return true;
    }
    // Scaled, so that no entry overflows.
    let rounding = SMatrix::<f64, D, D>::identity() * ROUNDING;
    (information / largest + rounding).cholesky().is_some()
}

impl<P: Pose<D>, const D: usize> Graph<P, D> {
    /// The sum of squared residuals in standard deviations. A prior counts no more than if it were
    /// just within its [`max_deviations`](Prior::max_deviations).
    pub fn chi2(&self) -> f64 {
        let edges = self.edges.iter().map(|edge| self.edge_chi2(edge));
        let priors = self.priors.iter().map(|prior| self.prior_chi2(prior));
        edges.sum::<f64>() + priors.sum::<f64>()
    }

    fn edge_chi2(&self, edge: &Edge<P, D>) -> f64 {
        normalized_square(&edge.residual(&self.poses), &edge.information)
    }

    fn prior_chi2(&self, prior: &Prior<P, D>) -> f64 {
        let square = normalized_square(&prior.residual(&self.poses), &prior.information);
        square.min(prior.max_deviations * prior.max_deviations)
    }

    /// Poses that nothing would keep from drifting off: the first one of each connected part of
    /// which no pose is held or has a prior.
    pub(super) fn anchors(&self) -> Vec<usize> {
        let mut parts = Parts::new(self.poses.len());
        for edge in &self.edges {
            parts.join(edge.from, edge.to);
        }
        let mut is_kept = vec![false; self.poses.len()];
        let known = self
            .priors
            .iter()
            .map(|prior| prior.at)
            .chain(self.held.iter().copied());
        for pose in known {
            is_kept[parts.first(pose)] = true;
        }
        (0..self.poses.len())
            .filter(|i| parts.is_first(*i) && !is_kept[*i])
            .collect()
    }
}

/// Connected parts of a graph: disjoint sets with path halving.
struct Parts {
    /// A pose of the same part with a lower index, or the pose itself if it is the first.
    parent: Vec<usize>,
}

impl Parts {
    fn new(poses: usize) -> Self {
        Self {
            parent: (0..poses).collect(),
        }
    }

    /// The first pose of a pose's part.
    fn first(&mut self, mut pose: usize) -> usize {
        while self.parent[pose] != pose {
            self.parent[pose] = self.parent[self.parent[pose]];
            pose = self.parent[pose];
        }
        pose
    }

    fn is_first(&self, pose: usize) -> bool {
        self.parent[pose] == pose
    }

    fn join(&mut self, a: usize, b: usize) {
        let a = self.first(a);
        let b = self.first(b);
        // The lower index stays the root: the first pose of a part stands for it, and `anchors`
        // holds that pose.
        self.parent[a.max(b)] = a.min(b);
    }
}

/// The square of a residual in standard deviations.
pub(super) fn normalized_square<const D: usize>(
    residual: &SVector<f64, D>,
    information: &SMatrix<f64, D, D>,
) -> f64 {
    let square = residual.dot(&(information * residual));
    // Rounding may leave it below zero. `max` would turn NaN into a number.
    if square < 0.0 { 0.0 } else { square }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry2, Matrix3};

    #[test]
    fn the_first_pose_of_each_part_that_nothing_holds_is_an_anchor() {
        let edge = |from, to| Edge {
            from,
            to,
            measured: Isometry2::identity(),
            information: Matrix3::identity(),
        };
        let graph = Graph {
            poses: vec![Isometry2::identity(); 7],
            edges: vec![edge(4, 3), edge(0, 2), edge(3, 1)],
            priors: vec![],
            held: vec![2, 6],
        };
        assert_eq!(graph.anchors(), [1, 5]);
    }
}
