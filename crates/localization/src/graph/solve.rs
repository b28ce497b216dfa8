//! Least squares of a graph: Gauss-Newton, damped after Levenberg and Marquardt where a step would
//! make it worse.

use nalgebra::SVector;

use super::pose::Pose;
use super::problem::{Edge, Graph, Prior, is_information, normalized_square};
use super::sparse::{Coupling, Normal};

/// At most this many steps.
const MAX_STEPS: usize = 100;
/// A smaller share of chi² is not worth another step.
const MIN_GAIN: f64 = 1e-5;
/// The least damping, as a share of the largest number on the diagonal,
const MIN_DAMPING: f64 = 1e-9;
/// and the most that is tried.
const MAX_DAMPING: f64 = 1e6;
/// Factor between one damping and the next.
const DAMPING_STEP: f64 = 10.0;
/// Chi² may grow by this share by rounding alone.
const ROUNDING: f64 = 1e-12;

/// A solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solved {
    /// The sum of squared residuals in standard deviations.
    pub chi2: f64,
    /// Steps that were taken.
    pub steps: usize,
}

/// Why a graph could not be solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError {
    /// An edge, a prior or a held pose has an index beyond the poses.
    #[error("the graph refers to pose {0}, which it does not have")]
    NoSuchPose(usize),
    /// A number is NaN or infinite, or information is not the inverse of a covariance.
    #[error(
        "the graph contains NaN or infinity, or an information matrix that is not positive \
         semidefinite"
    )]
    NotFinite,
    /// The equations are too large.
    #[error("the graph's equations do not fit into memory")]
    TooLarge,
}

/// Damping that is worth trying.
#[derive(Debug, Clone, Copy)]
struct DampingRange {
    least: f64,
    most: f64,
}

impl<P: Pose<D>, const D: usize> Graph<P, D> {
    /// Moves the poses to where they agree best with all measurements, beginning where they are.
    /// Where nothing holds a part of the graph, its first pose is held.
    ///
    /// # Errors
    ///
    /// If an index is beyond the poses, a number is not finite, information is not the inverse of a
    /// covariance, or the equations do not fit into memory.
    pub fn solve(&mut self) -> Result<Solved, SolveError> {
        self.solve_to(MIN_GAIN)
    }

    /// The same until a step reduces chi² by no more than the share `min_gain` of it.
    ///
    /// # Errors
    ///
    /// Those of [`solve`](Self::solve).
    pub fn solve_to(&mut self, min_gain: f64) -> Result<Solved, SolveError> {
        self.check()?;
        let mut chi2 = self.chi2();
        if !chi2.is_finite() {
            return Err(SolveError::NotFinite);
        }
        let Some(mut system) = System::new(self)? else {
            return Ok(Solved { chi2, steps: 0 });
        };
        // Undamped at first: Gauss-Newton steps, until one of them makes chi² worse.
        let mut damping = 0.0;
        for step in 0..MAX_STEPS {
            system.linearize(self);
            let range = DampingRange::of(&system.normal)?;
            let Some(gain) = self.improve(&system, chi2, &mut damping, range) else {
                return Ok(Solved { chi2, steps: step });
            };
            chi2 -= gain;
            if gain <= chi2 * min_gain {
                return Ok(Solved {
                    // Anew, since the rounding of all gains has added up in the running value.
                    chi2: self.chi2(),
                    steps: step + 1,
                });
            }
        }
        Ok(Solved {
            chi2,
            steps: MAX_STEPS,
        })
    }

    /// Takes a step that does not increase chi², with as little damping as that needs. Returns by
    /// how much chi² decreased; `None` if no damping helps.
    fn improve(
        &mut self,
        system: &System<D>,
        chi2: f64,
        damping: &mut f64,
        range: DampingRange,
    ) -> Option<f64> {
        loop {
            if let Some(motions) = system.normal.solve(*damping) {
                let moved = system.moved(&self.poses, &motions);
                let before = std::mem::replace(&mut self.poses, moved);
                let after = self.chi2();
                if after <= chi2 * (1.0 + ROUNDING) {
                    *damping = range.less(*damping);
                    return Some(chi2 - after);
                }
                self.poses = before;
            }
            *damping = range.more(*damping)?;
        }
    }

    fn check(&self) -> Result<(), SolveError> {
        let of_edges = self.edges.iter().flat_map(|edge| [edge.from, edge.to]);
        let of_priors = self.priors.iter().map(|prior| prior.at);
        let mut named = of_edges.chain(of_priors).chain(self.held.iter().copied());
        if let Some(missing) = named.find(|pose| *pose >= self.poses.len()) {
            return Err(SolveError::NoSuchPose(missing));
        }
        let of_edges = self.edges.iter().map(|edge| &edge.information);
        let of_priors = self.priors.iter().map(|prior| &prior.information);
        // With anything else chi² may be negative, and has no least value.
        if !of_edges.chain(of_priors).all(is_information) {
            return Err(SolveError::NotFinite);
        }
        Ok(())
    }
}

impl DampingRange {
    fn of<const D: usize>(normal: &Normal<D>) -> Result<Self, SolveError> {
        // Measurements without information leave zeros on the diagonal, of which a share is zero.
        let largest = normal.largest().max(f64::MIN_POSITIVE / MIN_DAMPING);
        let range = Self {
            least: largest * MIN_DAMPING,
            most: largest * MAX_DAMPING,
        };
        if range.most.is_finite() {
            Ok(range)
        } else {
            Err(SolveError::NotFinite)
        }
    }

    /// The damping after a step that helped.
    fn less(&self, damping: f64) -> f64 {
        if damping > self.least * DAMPING_STEP {
            damping / DAMPING_STEP
        } else {
            0.0
        }
    }

    /// The damping after a step that did not help; `None` beyond the range.
    fn more(&self, damping: f64) -> Option<f64> {
        let more = (damping * DAMPING_STEP).max(self.least);
        (more <= self.most).then_some(more)
    }
}

/// The equations of a graph.
struct System<const D: usize> {
    normal: Normal<D>,
    /// Index of the unknown that a pose is; none for a pose that is held.
    unknown: Vec<Option<usize>>,
}

impl<const D: usize> System<D> {
    /// `None` if nothing is unknown.
    fn new<P: Pose<D>>(graph: &Graph<P, D>) -> Result<Option<Self>, SolveError> {
        let mut is_held = vec![false; graph.poses.len()];
        for pose in graph.held.iter().copied().chain(graph.anchors()) {
            is_held[pose] = true;
        }
        let mut unknown = Vec::with_capacity(is_held.len());
        let mut count = 0;
        for is_held in is_held {
            unknown.push((!is_held).then_some(count));
            count += usize::from(!is_held);
        }
        if count == 0 {
            return Ok(None);
        }
        let couplings = graph.edges.iter().filter_map(|edge| {
            Some(Coupling {
                from: unknown[edge.from]?,
                to: unknown[edge.to]?,
            })
        });
        let normal = Normal::new(count, couplings).ok_or(SolveError::TooLarge)?;
        Ok(Some(Self { normal, unknown }))
    }

    /// Sets up the equations about the graph's poses.
    fn linearize<P: Pose<D>>(&mut self, graph: &Graph<P, D>) {
        self.normal.clear();
        for edge in &graph.edges {
            self.add_edge(edge, &graph.poses);
        }
        for prior in &graph.priors {
            self.add_prior(prior, &graph.poses);
        }
    }

    fn add_edge<P: Pose<D>>(&mut self, edge: &Edge<P, D>, poses: &[P]) {
        let linear = edge.linearized(poses);
        let weighted_to = linear.to.transpose() * edge.information;
        let weighted_from = linear.from.transpose() * edge.information;
        let from = self.unknown[edge.from];
        let to = self.unknown[edge.to];
        if let Some(from) = from {
            self.normal.add(from, from, &(weighted_from * linear.from));
            self.normal
                .add_right(from, &-(weighted_from * linear.residual));
        }
        if let Some(to) = to {
            self.normal.add(to, to, &(weighted_to * linear.to));
            self.normal.add_right(to, &-(weighted_to * linear.residual));
        }
        if let (Some(from), Some(to)) = (from, to) {
            // One of the two mixed blocks: the other is its transpose, and not stored.
            self.normal.add(to, from, &(weighted_to * linear.from));
        }
    }

    fn add_prior<P: Pose<D>>(&mut self, prior: &Prior<P, D>, poses: &[P]) {
        let off = prior.disagreement(poses);
        let residual = off.distance();
        let square = normalized_square(&residual, &prior.information);
        // Beyond the bound the truncated cost is constant, and has no gradient.
        let is_credible = square < prior.max_deviations * prior.max_deviations;
        if let Some(pose) = self.unknown[prior.at]
            && is_credible
        {
            let jacobian = off.distance_jacobian();
            let weighted = jacobian.transpose() * prior.information;
            self.normal.add(pose, pose, &(weighted * jacobian));
            self.normal.add_right(pose, &-(weighted * residual));
        }
    }

    /// The poses, the unknown ones moved.
    fn moved<P: Pose<D>>(&self, poses: &[P], motions: &[SVector<f64, D>]) -> Vec<P> {
        let poses = poses.iter().zip(&self.unknown);
        poses
            .map(|(pose, unknown)| match unknown {
                Some(index) => pose.moved(&motions[*index]),
                None => pose.clone(),
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Edge, Prior};
    use nalgebra::{Isometry2, Matrix3, Vector2};

    fn pose(x: f64, y: f64, yaw: f64) -> Isometry2<f64> {
        Isometry2::new(Vector2::new(x, y), yaw)
    }

    /// A square loop whose sides were measured a little too long, from a bad initial estimate.
    fn square_loop() -> Graph<Isometry2<f64>, 3> {
        let side = pose(10.1, 0.0, std::f64::consts::FRAC_PI_2);
        let information = Matrix3::identity();
        let edge = |from, to| Edge {
            from,
            to,
            measured: side,
            information,
        };
        let poses = [
            (0.0, 0.0, 0.0),
            (9.0, 1.0, 1.0),
            (12.0, 8.0, 3.0),
            (0.0, 12.0, -1.0),
        ];
        Graph {
            poses: poses.map(|(x, y, yaw)| pose(x, y, yaw)).to_vec(),
            edges: vec![edge(0, 1), edge(1, 2), edge(2, 3), edge(3, 0)],
            priors: vec![],
            held: vec![],
        }
    }

    #[test]
    fn a_loop_closes() {
        let mut graph = square_loop();
        let solved = graph.solve().unwrap();
        assert!(solved.chi2 < 1e-9, "{solved:?}");
        assert!((graph.poses[2].translation.vector - Vector2::new(10.1, 10.1)).norm() < 1e-4);
        assert!((graph.poses[0].translation.vector).norm() == 0.0);
    }

    #[test]
    fn an_outlier_changes_nothing_and_a_true_prior_moves_all() {
        let mut graph = square_loop();
        let information = Matrix3::identity() * 4.0;
        let prior = |x, y| {
            let measured = pose(x, y, 0.0);
            Prior {
                at: 0,
                measured,
                information,
                max_deviations: 3.0,
            }
        };
        graph.priors = vec![prior(0.5, 0.0), prior(40.0, 3.0)];
        graph.solve().unwrap();
        assert!((graph.poses[0].translation.vector - Vector2::new(0.5, 0.0)).norm() < 1e-6);
    }

    #[test]
    fn an_unsolvable_graph_is_an_error() {
        let mut graph = square_loop();
        graph.edges[1].to = 9;
        assert_eq!(graph.solve(), Err(SolveError::NoSuchPose(9)));
        let mut graph = square_loop();
        graph.edges[1].information[(0, 0)] = f64::NAN;
        assert_eq!(graph.solve(), Err(SolveError::NotFinite));
        graph.edges[1].information[(0, 0)] = 1e308;
        assert!(graph.solve().is_err());
        let mut graph = square_loop();
        graph.poses[1].translation.x = f64::NAN;
        assert_eq!(graph.solve(), Err(SolveError::NotFinite));
    }

    #[test]
    fn edges_without_information_leave_the_poses_where_they_are() {
        let mut graph = square_loop();
        for edge in &mut graph.edges {
            edge.information = Matrix3::zeros();
        }
        assert_eq!(graph.solve().unwrap().chi2, 0.0);
        let mut empty = Graph::<Isometry2<f64>, 3>::default();
        assert_eq!(empty.solve().unwrap().steps, 0);
    }
}
