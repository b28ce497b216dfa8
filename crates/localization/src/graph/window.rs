//! A pose graph that goes on for ever: the newest poses are kept, what older ones said is kept as a prior of the oldest one that is left.
//!
//! Odometry is a chain, fixes hang on it. Fixes that are false are found by graduated non-convexity: H. Yang, P. Antonante, V. Tzoumas, L. Carlone, *Graduated Non-Convexity for
//! Robust Spatial Perception*, 2020, with truncated least squares (its equations 11 to 14).

use std::collections::VecDeque;

use nalgebra::{SMatrix, SVector};

use super::pose::Pose;
use super::problem::{Edge, Graph, Prior, square};
use super::solve::SolveError;

/// How much less convex the cost becomes from one solution to the next.
const GRADUATION: f64 = 2.0;
/// Solutions at most.
const ROUNDS: usize = 100;
/// A smaller part of chi² is not worth another step: on the way, and at its end.
const LITTLE: [f64; 2] = [1e-3, 1e-10];
/// Fixes of one pose at most; older ones are dropped. A robot that stands would gather them without end.
const FIXES: usize = 8;

/// A fix, and how far it is believed: 1 true, 0 false.
#[derive(Debug, Clone)]
struct Believed<P, const D: usize> {
    fix: Prior<P, D>,
    weight: f64,
}

/// The newest poses of a drive.
#[derive(Debug, Clone)]
pub struct Window<P, const D: usize> {
    capacity: usize,
    poses: VecDeque<P>,
    /// From each pose to the next.
    ways: VecDeque<(P, SMatrix<f64, D, D>)>,
    /// Of a pose counted from the oldest one.
    fixes: VecDeque<Believed<P, D>>,
    /// What is known of the oldest pose.
    anchor: Prior<P, D>,
}

impl<P: Pose<D>, const D: usize> Window<P, D> {
    /// Begins at a pose; so many poses are kept, two at least.
    pub fn new(start: P, information: SMatrix<f64, D, D>, capacity: usize) -> Self {
        let anchor = Prior {
            at: 0,
            measured: start.clone(),
            information,
            credible: f64::INFINITY,
        };
        Self {
            capacity: capacity.max(2),
            poses: VecDeque::from([start]),
            ways: VecDeque::new(),
            fixes: VecDeque::new(),
            anchor,
        }
    }

    /// The newest pose.
    pub fn newest(&self) -> &P {
        &self.poses[self.poses.len() - 1]
    }

    /// Goes on by what odometry says: a way, and one over its covariance in the frame of its end.
    pub fn advance(&mut self, way: P, information: SMatrix<f64, D, D>) {
        self.poses.push_back(self.newest().then(&way));
        self.ways.push_back((way, information));
        if self.poses.len() > self.capacity {
            self.drop_oldest();
        }
    }

    /// The newest pose is where something says, with one over its covariance in the frame of the pose; beyond `credible` deviations it is thought to be false. A pose keeps
    /// its eight newest fixes.
    pub fn fix(&mut self, measured: P, information: SMatrix<f64, D, D>, credible: f64) {
        let at = self.poses.len() - 1;
        let first = self.fixes.partition_point(|fix| fix.fix.at < at);
        if self.fixes.len() - first == FIXES {
            self.fixes.remove(first);
        }
        let fix = Prior {
            at,
            measured,
            information,
            credible,
        };
        self.fixes.push_back(Believed { fix, weight: 1.0 });
    }

    /// Of the fixes in the window those that are thought to be true, and all.
    pub fn believed(&self) -> (usize, usize) {
        (
            self.fixes.iter().filter(|fix| fix.weight > 0.5).count(),
            self.fixes.len(),
        )
    }

    /// Brings all into agreement.
    pub fn settle(&mut self) -> Result<(), SolveError> {
        let mut graph = self.graph();
        self.fixes.iter_mut().for_each(|fix| fix.weight = 1.0);
        let mut control = None;
        for _ in 0..ROUNDS {
            self.weigh(&mut graph);
            graph.solve_to(LITTLE[0])?;
            let squares: Vec<f64> = self.squares(&graph.poses);
            // μ, from where the cost is convex over all residuals.
            let mu = control.unwrap_or_else(|| self.convex(&squares));
            let mut certain = true;
            for (fix, square) in self.fixes.iter_mut().zip(&squares) {
                fix.weight = weight(mu, *square, fix.fix.credible);
                certain &= fix.weight == 0.0 || fix.weight == 1.0;
            }
            if certain {
                break;
            }
            control = Some(mu * GRADUATION);
        }
        self.fixes
            .iter_mut()
            .for_each(|fix| fix.weight = fix.weight.round());
        self.weigh(&mut graph);
        graph.solve_to(LITTLE[1])?;
        self.poses = graph.poses.into();
        Ok(())
    }

    /// Covariance of the newest pose, in its own frame, by the fixes that are believed: along a chain what a filter would have at its end. `None` if what is known does not
    /// say where it is.
    pub fn covariance(&self) -> Option<SMatrix<f64, D, D>> {
        let mut information = self.anchor.information;
        for at in 0..self.poses.len() {
            if at > 0 {
                let (way, known) = &self.ways[at - 1];
                // A motion of the pose before, seen from this one.
                let carried = way.back().adjoint();
                let covariance = carried * information.try_inverse()? * carried.transpose();
                information = (covariance + known.try_inverse()?).try_inverse()?;
            }
            let fixes = self.fixes.iter().filter(|fix| fix.fix.at == at);
            information += fixes
                .map(|fix| fix.fix.information * fix.weight)
                .sum::<SMatrix<f64, D, D>>();
        }
        information.try_inverse()
    }

    /// Squares of the fixes' residuals, in deviations.
    fn squares(&self, poses: &[P]) -> Vec<f64> {
        self.fixes
            .iter()
            .map(|fix| square(&fix.fix.residual(poses), &fix.fix.information))
            .collect()
    }

    fn convex(&self, squares: &[f64]) -> f64 {
        let ratios = self
            .fixes
            .iter()
            .zip(squares)
            .map(|(fix, square)| square / (fix.fix.credible * fix.fix.credible));
        let largest = ratios.fold(0.0, f64::max);
        if 2.0 * largest > 1.0 {
            1.0 / (2.0 * largest - 1.0)
        } else {
            f64::INFINITY
        }
    }

    fn graph(&self) -> Graph<P, D> {
        let ways = self.ways.iter().enumerate();
        let edges = ways.map(|(i, (way, information))| Edge {
            from: i,
            to: i + 1,
            measured: way.clone(),
            information: *information,
        });
        Graph {
            poses: self.poses.iter().cloned().collect(),
            edges: edges.collect(),
            priors: Vec::new(),
            held: Vec::new(),
        }
    }

    /// Gives a graph the priors as far as they are believed now.
    fn weigh(&self, graph: &mut Graph<P, D>) {
        let fixes = self.fixes.iter().filter(|fix| fix.weight > 0.0);
        let weighed = fixes.map(|Believed { fix, weight }| Prior {
            information: fix.information * *weight,
            credible: f64::INFINITY,
            ..fix.clone()
        });
        graph.priors = std::iter::once(self.anchor.clone())
            .chain(weighed)
            .collect();
    }

    /// What the oldest pose was told goes over to the next one: Schur's complement at where they are thought to be.
    fn drop_oldest(&mut self) {
        let Some((way, information)) = self.ways.pop_front() else {
            return;
        };
        let poses: Vec<P> = self.poses.iter().take(2).cloned().collect();
        let edge = Edge {
            from: 0,
            to: 1,
            measured: way,
            information,
        };
        let (mut own, mut own_right) = (SMatrix::<f64, D, D>::zeros(), SVector::<f64, D>::zeros());
        let fixes = self.fixes.iter().filter(|fix| fix.fix.at == 0);
        for (prior, weight) in fixes
            .map(|fix| (&fix.fix, fix.weight))
            .chain([(&self.anchor, 1.0)])
        {
            let off = prior.disagreement(&poses);
            let weighed = off.distance_jacobian().transpose() * prior.information * weight;
            own += weighed * off.distance_jacobian();
            own_right -= weighed * off.distance();
        }
        let off = edge.disagreement(&poses);
        let (residual, at_end) = (off.distance(), off.distance_jacobian());
        let at_start = -at_end * poses[1].back().then(&poses[0]).adjoint();
        let (weighed_end, weighed_start) = (
            at_end.transpose() * information,
            at_start.transpose() * information,
        );
        own += weighed_start * at_start;
        own_right -= weighed_start * residual;
        let (next, mixed, next_right) = (
            weighed_end * at_end,
            weighed_end * at_start,
            -(weighed_end * residual),
        );
        self.poses.pop_front();
        self.fixes.retain(|fix| fix.fix.at > 0);
        self.fixes.iter_mut().for_each(|fix| fix.fix.at -= 1);
        self.anchor = Self::complement(&poses[1], own, own_right, next, mixed, next_right);
    }

    fn complement(
        at: &P,
        own: SMatrix<f64, D, D>,
        own_right: SVector<f64, D>,
        next: SMatrix<f64, D, D>,
        mixed: SMatrix<f64, D, D>,
        next_right: SVector<f64, D>,
    ) -> Prior<P, D> {
        let prior = |measured: P, information| Prior {
            at: 0,
            measured,
            information,
            credible: f64::INFINITY,
        };
        // Without a solution nothing is known of it, and the pose stays where it is.
        let nothing = prior(at.clone(), SMatrix::zeros());
        let Some(solved) = own.try_inverse() else {
            return nothing;
        };
        let information = next - mixed * solved * mixed.transpose();
        let information = (information + information.transpose()) * 0.5;
        let Some(covariance) = information.try_inverse() else {
            return nothing;
        };
        prior(
            at.moved(&(covariance * (next_right - mixed * solved * own_right))),
            information,
        )
    }
}

/// How far a residual's square is believed under the control parameter μ: equation 14.
fn weight(mu: f64, square: f64, credible: f64) -> f64 {
    let limit = credible * credible;
    if mu.is_infinite() {
        return f64::from(u8::from(square <= limit));
    }
    if square <= mu / (mu + 1.0) * limit {
        1.0
    } else if square >= (mu + 1.0) / mu * limit {
        0.0
    } else {
        (credible / square.sqrt() * (mu * (mu + 1.0)).sqrt() - mu).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry2, Matrix3, Vector2, Vector3};
    use proptest::prelude::*;

    fn pose(x: f64, y: f64, yaw: f64) -> Isometry2<f64> {
        Isometry2::new(Vector2::new(x, y), yaw)
    }

    fn of(deviations: [f64; 3]) -> Matrix3<f64> {
        Matrix3::from_diagonal(&Vector3::from(deviations).map(|x| 1.0 / (x * x)))
    }

    /// Noise that is the same each time.
    struct Noise(u64);

    impl Noise {
        fn uniform(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 33) as f64 / (1_u64 << 31) as f64
        }

        fn normal(&mut self) -> f64 {
            (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
        }
    }

    /// Drives for so many steps with fixes of a metre's noise of which three in ten are false by up to fifty metres; errors in metres, and normalized ones squared.
    fn drive(
        seed: u64,
        start: [f64; 3],
        steps: usize,
    ) -> (Window<Isometry2<f64>, 3>, Vec<[f64; 2]>) {
        let mut noise = Noise(seed);
        let mut truth = pose(0.0, 0.0, 0.0);
        let off = Vector3::from(start).map(|x| x * noise.normal());
        let mut window = Window::new(truth.moved(&off), of(start), 100);
        let (step, deviations) = (pose(1.0, 0.0, 0.02), [0.005, 0.005, 0.0005]);
        let errors = (0..steps).map(|_| {
            truth = truth.then(&step);
            let told = step.moved(&Vector3::from(deviations).map(|x| x * noise.normal()));
            window.advance(told, of(deviations));
            let here = truth.translation.vector;
            let off = if noise.uniform() < 0.3 {
                Vector2::new(noise.uniform() - 0.5, noise.uniform() - 0.5) * 70.0
            } else {
                Vector2::new(noise.normal(), noise.normal())
            };
            let heading = window.newest().rotation.angle();
            window.fix(
                pose(here.x + off.x, here.y + off.y, heading),
                of([1.0, 1.0, 1e6]),
                3.0,
            );
            window.settle().unwrap();
            let error = truth.back().then(window.newest()).distance();
            let nees = error.dot(&(window.covariance().unwrap().try_inverse().unwrap() * error));
            [error.xy().norm(), nees]
        });
        let errors = errors.collect();
        (window, errors)
    }

    #[test]
    fn a_third_of_the_fixes_may_be_false() {
        let (window, errors) = drive(3, [0.1, 0.1, 0.02], 400);
        let mut metres: Vec<f64> = errors.iter().map(|e| e[0]).collect();
        metres.sort_by(f64::total_cmp);
        assert!(
            metres[380] < 0.5 && metres[399] < 0.8,
            "{:?}",
            &metres[380..]
        );
        let (believed, all) = window.believed();
        assert!(
            all == 100 && (55..85).contains(&believed),
            "{believed} of {all}"
        );
    }

    #[test]
    fn errors_are_as_large_as_the_covariance_says() {
        let ends = (0..40).map(|seed| drive(seed, [2.0, 2.0, 0.05], 60).1[59][1]);
        let sum: f64 = ends.sum();
        // χ² of 120 degrees of freedom: 95 in 100 lie between.
        assert!((91.6..152.2).contains(&sum), "{sum}");
    }

    #[test]
    fn one_pose_keeps_no_more_than_its_share_of_fixes() {
        let mut window = Window::new(pose(0.0, 0.0, 0.0), of([1.0; 3]), 5);
        (0..100).for_each(|_| window.fix(pose(1.0, 0.0, 0.0), of([1.0; 3]), 3.0));
        window.settle().unwrap();
        assert_eq!(window.believed(), (FIXES, FIXES));
    }

    #[test]
    fn a_fix_from_another_continent_takes_no_others_along() {
        let mut window = Window::new(pose(0.0, 0.0, 0.0), of([5.0, 5.0, 0.1]), 5);
        (0..4).for_each(|_| window.fix(pose(1.0, 0.0, 0.0), of([0.01, 0.01, 1e3]), 3.0));
        window.fix(pose(9e6, -4e6, 0.0), of([0.01, 0.01, 1e3]), 3.0);
        window.settle().unwrap();
        assert_eq!(window.believed(), (4, 5));
        assert!((window.newest().translation.vector - Vector2::new(1.0, 0.0)).norm() < 1e-3);
    }

    proptest! {
        /// What is dropped is kept as a prior: the newest pose is the same as that of the whole graph, but for terms of second order.
        #[test]
        fn a_short_window_says_what_a_long_one_says(n in proptest::collection::vec(-0.01_f64..0.01, 60)) {
            let start = pose(0.0, 0.0, 0.0);
            let mut windows = [5, 100].map(|size| Window::new(start, of([0.1, 0.1, 0.05]), size));
            for (i, n) in n.chunks(3).enumerate() {
                for window in &mut windows {
                    window.advance(pose(1.0, 0.1 * n[0], 0.1 * n[1]), of([0.05, 0.05, 0.02]));
                    window.fix(pose(i as f64 + 1.0 + n[0], n[1], 0.1 * n[2]), of([0.5, 0.5, 0.3]), 5.0);
                    window.settle().unwrap();
                }
            }
            let [short, long] = windows.each_ref().map(|window| *window.newest());
            let apart = (short.translation.vector - long.translation.vector).norm();
            prop_assert!(apart < 2e-4, "{apart}");
            let [short, long] = windows.map(|window| window.covariance().unwrap());
            prop_assert!((short - long).norm() < 0.02 * long.norm(), "{short} {long}");
        }
    }
}
