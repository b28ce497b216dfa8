//! The least squares of a graph, after Gauss and Newton, damped after Levenberg and Marquardt where a step would make it worse.

use nalgebra::SVector;

use super::pose::Pose;
use super::problem::{Graph, is_information, square};
use super::sparse::Normal;

/// Steps at most.
const STEPS: usize = 100;
/// A smaller part of chi² is not worth another step.
const LITTLE: f64 = 1e-5;
/// Damping as a part of the largest number on the diagonal: the least, and the most that is tried.
const DAMPING: [f64; 2] = [1e-9, 1e6];

/// What came of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solved {
    /// The sum of squared residuals in deviations.
    pub chi2: f64,
    /// Steps that were taken.
    pub steps: usize,
}

/// Why a graph could not be solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SolveError {
    /// An edge, a prior or a held pose names one that is not there.
    #[error("pose {0} is named, but there is none of that number")]
    NoSuchPose(usize),
    /// Something is no number, or information is not of a covariance.
    #[error("the graph holds what is no number, or information that is not positive")]
    NotFinite,
    /// The equations are too large.
    #[error("the graph's equations do not fit into memory")]
    TooLarge,
}

impl<P: Pose<D>, const D: usize> Graph<P, D> {
    /// Moves the poses to where they agree best with all that was measured, from where they are. Where nothing holds a part, its first pose is held.
    pub fn solve(&mut self) -> Result<Solved, SolveError> {
        self.solve_to(LITTLE)
    }

    /// The same until a step makes chi² less by no more than that part of it.
    pub fn solve_to(&mut self, little: f64) -> Result<Solved, SolveError> {
        self.check()?;
        let (mut chi2, mut damping) = (self.chi2(), 0.0);
        if !chi2.is_finite() {
            return Err(SolveError::NotFinite);
        }
        let Some(mut system) = System::new(self)? else {
            return Ok(Solved { chi2, steps: 0 });
        };
        for step in 0..STEPS {
            system.linearize(self);
            // What says nothing has no number on its diagonal to take a part of.
            let largest = system.normal.largest().max(f64::MIN_POSITIVE / DAMPING[0]);
            let (least, most) = (largest * DAMPING[0], largest * DAMPING[1]);
            if !most.is_finite() {
                return Err(SolveError::NotFinite);
            }
            let better = loop {
                let tried = system
                    .normal
                    .solve(damping)
                    .map(|motions| system.moved(self, &motions));
                if let Some((poses, after)) = tried.map(|poses| {
                    let before = std::mem::replace(&mut self.poses, poses);
                    let after = self.chi2();
                    (std::mem::replace(&mut self.poses, before), after)
                }) && after <= chi2 * (1.0 + 1e-12)
                {
                    self.poses = poses;
                    damping = if damping > least * 10.0 {
                        damping / 10.0
                    } else {
                        0.0
                    };
                    break Some(chi2 - after);
                }
                damping = (damping * 10.0).max(least);
                if damping > most {
                    break None;
                }
            };
            let Some(gain) = better else {
                return Ok(Solved { chi2, steps: step });
            };
            chi2 -= gain;
            if gain <= chi2 * little {
                return Ok(Solved {
                    chi2: self.chi2(),
                    steps: step + 1,
                });
            }
        }
        Ok(Solved { chi2, steps: STEPS })
    }

    fn check(&self) -> Result<(), SolveError> {
        let named = self.edges.iter().flat_map(|edge| [edge.from, edge.to]);
        let named = named
            .chain(self.priors.iter().map(|prior| prior.at))
            .chain(self.held.iter().copied());
        if let Some(missing) = named.into_iter().find(|at| *at >= self.poses.len()) {
            return Err(SolveError::NoSuchPose(missing));
        }
        let edges = self.edges.iter().map(|edge| &edge.information);
        if !edges
            .chain(self.priors.iter().map(|prior| &prior.information))
            .all(is_information)
        {
            return Err(SolveError::NotFinite);
        }
        Ok(())
    }
}

/// The equations of a graph.
struct System<const D: usize> {
    normal: Normal<D>,
    /// Which unknown a pose is; none of those that are held.
    unknown: Vec<Option<usize>>,
}

impl<const D: usize> System<D> {
    /// `None` if nothing is unknown.
    fn new<P: Pose<D>>(graph: &Graph<P, D>) -> Result<Option<Self>, SolveError> {
        let mut held = vec![false; graph.poses.len()];
        for pose in graph.held.iter().copied().chain(graph.anchors()) {
            held[pose] = true;
        }
        let mut unknowns = 0;
        let number = |held: &bool| {
            (!held).then(|| {
                unknowns += 1;
                unknowns - 1
            })
        };
        let unknown: Vec<Option<usize>> = held.iter().map(number).collect();
        if unknowns == 0 {
            return Ok(None);
        }
        let pairs = graph
            .edges
            .iter()
            .filter_map(|edge| Some((unknown[edge.from]?, unknown[edge.to]?)));
        let normal = Normal::new(unknowns, pairs).ok_or(SolveError::TooLarge)?;
        Ok(Some(Self { normal, unknown }))
    }

    fn linearize<P: Pose<D>>(&mut self, graph: &Graph<P, D>) {
        self.normal.clear();
        for edge in &graph.edges {
            let off = edge.disagreement(&graph.poses);
            let (residual, at_end) = (off.distance(), off.distance_jacobian());
            // The first pose moves the other way, seen from the second.
            let way = graph.poses[edge.to].back().then(&graph.poses[edge.from]);
            let at_start = -at_end * way.adjoint();
            let (weighed_end, weighed_start) = (
                at_end.transpose() * edge.information,
                at_start.transpose() * edge.information,
            );
            let [from, to] = [edge.from, edge.to].map(|pose| self.unknown[pose]);
            if let Some(from) = from {
                self.normal.add(from, from, &(weighed_start * at_start));
                self.normal.add_right(from, &-(weighed_start * residual));
            }
            if let Some(to) = to {
                self.normal.add(to, to, &(weighed_end * at_end));
                self.normal.add_right(to, &-(weighed_end * residual));
            }
            if let (Some(from), Some(to)) = (from, to) {
                self.normal.add(to, from, &(weighed_end * at_start));
            }
        }
        for prior in &graph.priors {
            let off = prior.disagreement(&graph.poses);
            let (residual, jacobian) = (off.distance(), off.distance_jacobian());
            // Beyond what is credible it counts for nothing.
            let credible = square(&residual, &prior.information) < prior.credible * prior.credible;
            if let Some(at) = self.unknown[prior.at].filter(|_| credible) {
                let weighed = jacobian.transpose() * prior.information;
                self.normal.add(at, at, &(weighed * jacobian));
                self.normal.add_right(at, &-(weighed * residual));
            }
        }
    }

    fn moved<P: Pose<D>>(&self, graph: &Graph<P, D>, motions: &[SVector<f64, D>]) -> Vec<P> {
        let poses = graph.poses.iter().zip(&self.unknown);
        poses
            .map(|(pose, unknown)| {
                unknown.map_or_else(|| pose.clone(), |i| pose.moved(&motions[i]))
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

    /// A round of four corners, each way a little too long, and a start that is guessed badly.
    fn round() -> Graph<Isometry2<f64>, 3> {
        let quarter = std::f64::consts::FRAC_PI_2;
        let way = pose(10.1, 0.0, quarter);
        let edge = |from, to| Edge {
            from,
            to,
            measured: way,
            information: Matrix3::identity(),
        };
        let poses = vec![
            pose(0.0, 0.0, 0.0),
            pose(9.0, 1.0, 1.0),
            pose(12.0, 8.0, 3.0),
            pose(0.0, 12.0, -1.0),
        ];
        Graph {
            poses,
            edges: vec![edge(0, 1), edge(1, 2), edge(2, 3), edge(3, 0)],
            priors: vec![],
            held: vec![],
        }
    }

    #[test]
    fn a_round_closes() {
        let mut graph = round();
        let solved = graph.solve().unwrap();
        assert!(solved.chi2 < 1e-9, "{solved:?}");
        assert!((graph.poses[2].translation.vector - Vector2::new(10.1, 10.1)).norm() < 1e-4);
        assert!((graph.poses[0].translation.vector).norm() == 0.0);
    }

    #[test]
    fn a_false_prior_bends_nothing_and_a_true_one_moves_all() {
        let mut graph = round();
        let prior = |at, x, y| Prior {
            at,
            measured: pose(x, y, 0.0),
            information: Matrix3::identity() * 4.0,
            credible: 3.0,
        };
        graph.priors = vec![prior(0, 0.5, 0.0), prior(0, 40.0, 3.0)];
        graph.solve().unwrap();
        assert!((graph.poses[0].translation.vector - Vector2::new(0.5, 0.0)).norm() < 1e-6);
    }

    #[test]
    fn nonsense_is_an_error() {
        let mut graph = round();
        graph.edges[1].to = 9;
        assert_eq!(graph.solve(), Err(SolveError::NoSuchPose(9)));
        let mut graph = round();
        graph.edges[1].information[(0, 0)] = f64::NAN;
        assert_eq!(graph.solve(), Err(SolveError::NotFinite));
        graph.edges[1].information[(0, 0)] = 1e308;
        assert!(graph.solve().is_err());
        let mut graph = round();
        graph.poses[1].translation.x = f64::NAN;
        assert_eq!(graph.solve(), Err(SolveError::NotFinite));
        // Edges that say nothing leave the poses where they are.
        let mut graph = round();
        graph
            .edges
            .iter_mut()
            .for_each(|edge| edge.information = Matrix3::zeros());
        assert_eq!(graph.solve().unwrap().chi2, 0.0);
        let mut graph = Graph::<Isometry2<f64>, 3>::default();
        assert_eq!(graph.solve().unwrap().steps, 0);
    }
}
