//! A pose graph without an end: the newest poses are kept, and what older ones said is kept as a
//! prior of the oldest one that is left.
//!
//! Odometry is a chain, and fixes are attached to it. Outliers among the fixes are found by
//! graduated non-convexity: H. Yang, P. Antonante, V. Tzoumas, L. Carlone, *Graduated Non-Convexity
//! for Robust Spatial Perception*, 2020, with truncated least squares (its equations 11 to 14).

use std::collections::VecDeque;

use nalgebra::{SMatrix, SVector};

use super::pose::Pose;
use super::problem::{Edge, Graph, Prior, normalized_square};
use super::solve::SolveError;

/// Factor by which the cost becomes less convex from one solution to the next.
const GRADUATION: f64 = 2.0;
/// At most this many solutions.
const MAX_ROUNDS: usize = 100;
/// A smaller share of chi² is not worth another step: in all solutions
const MIN_GAIN: f64 = 1e-3;
/// but the last, and in the last.
const MIN_FINAL_GAIN: f64 = 1e-10;
/// At most this many fixes of one pose; older ones are dropped. Otherwise a
/// robot that stands still would collect more and more.
const MAX_FIXES_PER_POSE: usize = 8;

/// A fix, and whether it is accepted: 1 for an inlier, 0 for an outlier.
#[derive(Debug, Clone)]
struct WeightedFix<P, const D: usize> {
    fix: Prior<P, D>,
    weight: f64,
}

/// A motion by odometry from one pose to the next.
#[derive(Debug, Clone)]
struct Motion<P, const D: usize> {
    measured: P,
    /// Inverse of its covariance in the frame of its end.
    information: SMatrix<f64, D, D>,
}

/// How many fixes a window has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FixCount {
    /// Those that are accepted as true.
    pub accepted: usize,
    /// All of them.
    pub total: usize,
}

/// The newest poses of a drive.
///
/// # Example
///
/// Ten metres by odometry that is good to a decimetre, and a good fix and an outlier at the end:
///
/// ```
/// use nalgebra::{Isometry2, Matrix3, Vector2};
/// use openbench_localization::graph::{FixCount, Window};
///
/// let pose = |x, y| Isometry2::new(Vector2::new(x, y), 0.0);
/// let decimetre = Matrix3::from_diagonal(&[100.0, 100.0, 1e4].into());
/// let mut window = Window::new(pose(0.0, 0.0), decimetre, 100);
/// for _ in 0..10 {
///     window.advance(pose(1.0, 0.0), decimetre);
/// }
/// window.fix(pose(10.3, 0.1), decimetre, 3.0);
/// window.fix(pose(40.0, -25.0), decimetre, 3.0);
/// window.settle()?;
///
/// assert_eq!(window.fix_count(), FixCount { accepted: 1, total: 2 });
/// assert!((window.newest().translation.x - 10.27).abs() < 0.01);
/// # Ok::<(), openbench_localization::graph::SolveError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Window<P, const D: usize> {
    capacity: usize,
    poses: VecDeque<P>,
    /// From each pose to the next.
    motions: VecDeque<Motion<P, D>>,
    /// In the order of their poses, which are counted from the oldest one.
    fixes: VecDeque<WeightedFix<P, D>>,
    /// What is known of the oldest pose.
    anchor: Prior<P, D>,
}

impl<P: Pose<D>, const D: usize> Window<P, D> {
    /// Begins at a pose with the inverse of its covariance. `capacity` poses are kept, at least
    /// two.
    pub fn new(start: P, information: SMatrix<f64, D, D>, capacity: usize) -> Self {
        Self {
            capacity: capacity.max(2),
            poses: VecDeque::from([start.clone()]),
            motions: VecDeque::new(),
            fixes: VecDeque::new(),
            anchor: Prior {
                at: 0,
                measured: start,
                information,
                max_deviations: f64::INFINITY,
            },
        }
    }

    /// The newest pose.
    pub fn newest(&self) -> &P {
        &self.poses[self.poses.len() - 1]
    }

    /// Adds a pose by a motion from odometry, with the inverse of the motion's covariance in the
    /// frame of its end.
    pub fn advance(&mut self, motion: P, information: SMatrix<f64, D, D>) {
        self.poses.push_back(self.newest().then(&motion));
        self.motions.push_back(Motion {
            measured: motion,
            information,
        });
        if self.poses.len() > self.capacity {
            self.drop_oldest();
        }
    }

    /// Attaches a fix to the newest pose, with the inverse of its covariance in its own frame. It
    /// is an outlier beyond `max_deviations` standard deviations. A pose keeps its eight newest
    /// fixes.
    pub fn fix(&mut self, measured: P, information: SMatrix<f64, D, D>, max_deviations: f64) {
        let at = self.poses.len() - 1;
        // Fixes are in the order of their poses: those of the newest pose stand last.
        let first = self.fixes.partition_point(|fix| fix.fix.at < at);
        if self.fixes.len() - first == MAX_FIXES_PER_POSE {
            self.fixes.remove(first);
        }
        let fix = Prior {
            at,
            measured,
            information,
            max_deviations,
        };
        self.fixes.push_back(WeightedFix { fix, weight: 1.0 });
    }

    /// How many fixes there are, and how many are accepted.
    pub fn fix_count(&self) -> FixCount {
        let accepted = self.fixes.iter().filter(|fix| fix.weight > 0.5).count();
        FixCount {
            accepted,
            total: self.fixes.len(),
        }
    }

    /// Finds the outliers and solves the graph.
    ///
    /// # Errors
    ///
    /// Where the graph cannot be solved; the poses stay as they were then.
    pub fn settle(&mut self) -> Result<(), SolveError> {
        let mut graph = self.graph();
        // All fixes are judged anew: later ones may show that an earlier verdict was wrong.
        self.fixes.iter_mut().for_each(|fix| fix.weight = 1.0);
        let mut control = None;
        for _ in 0..MAX_ROUNDS {
            self.set_priors(&mut graph);
            // Each solution begins at the one before, about a cost that is a little less convex.
            graph.solve_to(MIN_GAIN)?;
            let squares = self.squared_residuals(&graph.poses);
            let mu = control.unwrap_or_else(|| self.convex_control(&squares));
            self.weigh(&squares, mu);
            if self.is_decided() {
                break;
            }
            control = Some(mu * GRADUATION);
        }
        self.fixes
            .iter_mut()
            .for_each(|fix| fix.weight = fix.weight.round());
        self.set_priors(&mut graph);
        graph.solve_to(MIN_FINAL_GAIN)?;
        self.poses = graph.poses.into();
        Ok(())
    }

    /// Covariance of the newest pose, in its own frame, by the accepted fixes: along a chain it is
    /// what a filter would have at its end. `None` if the measurements do not determine the pose.
    pub fn covariance(&self) -> Option<SMatrix<f64, D, D>> {
        let mut information = self.anchor.information + self.fix_information(0);
        for (i, motion) in self.motions.iter().enumerate() {
            // A motion of the pose before, seen from this one.
            let carried = motion.measured.back().adjoint();
            let covariance = carried * information.try_inverse()? * carried.transpose();
            information = (covariance + motion.information.try_inverse()?).try_inverse()?;
            information += self.fix_information(i + 1);
        }
        information.try_inverse()
    }

    /// Information of the accepted fixes of a pose.
    fn fix_information(&self, at: usize) -> SMatrix<f64, D, D> {
        let fixes = self.fixes.iter().filter(|fix| fix.fix.at == at);
        fixes.map(|fix| fix.fix.information * fix.weight).sum()
    }

    /// Squares of the fixes' residuals in standard deviations.
    fn squared_residuals(&self, poses: &[P]) -> Vec<f64> {
        let fixes = self.fixes.iter().map(|weighted| &weighted.fix);
        fixes
            .map(|fix| normalized_square(&fix.residual(poses), &fix.information))
            .collect()
    }

    /// The control parameter μ from which on the cost is convex over all residuals.
    fn convex_control(&self, squares: &[f64]) -> f64 {
        let fixes = self.fixes.iter().zip(squares);
        let ratios =
            fixes.map(|(fix, square)| square / (fix.fix.max_deviations * fix.fix.max_deviations));
        let largest = ratios.fold(0.0, f64::max);
        if 2.0 * largest > 1.0 {
            1.0 / (2.0 * largest - 1.0)
        } else {
            // Every r² is at most half its bound: the cost is convex already, and all fixes are
            // inliers.
            f64::INFINITY
        }
    }

    /// Weighs the fixes by their squared residuals.
    fn weigh(&mut self, squares: &[f64], mu: f64) {
        for (fix, square) in self.fixes.iter_mut().zip(squares) {
            fix.weight = weight(mu, *square, fix.fix.max_deviations);
        }
    }

    /// Whether each fix is either an inlier or an outlier.
    fn is_decided(&self) -> bool {
        self.fixes
            .iter()
            .all(|fix| fix.weight == 0.0 || fix.weight == 1.0)
    }

    /// The chain of poses.
    fn graph(&self) -> Graph<P, D> {
        let motions = self.motions.iter().enumerate();
        Graph {
            poses: self.poses.iter().cloned().collect(),
            edges: motions.map(|(i, motion)| motion.edge(i)).collect(),
            priors: Vec::new(),
            held: Vec::new(),
        }
    }

    /// Gives a graph the anchor and the fixes as they are weighted now.
    fn set_priors(&self, graph: &mut Graph<P, D>) {
        let fixes = self.fixes.iter().filter(|fix| fix.weight > 0.0);
        graph.priors = std::iter::once(self.anchor.clone())
            .chain(fixes.map(WeightedFix::weighted))
            .collect();
    }

    /// What is known of the oldest pose goes over to the next one.
    fn drop_oldest(&mut self) {
        let Some(motion) = self.motions.pop_front() else {
            return;
        };
        let poses: Vec<P> = self.poses.iter().take(2).cloned().collect();
        let mut equations = TwoPoses::<D>::default();
        // With the weights of the last solution: an outlier does not enter the anchor.
        let fixes = self.fixes.iter().filter(|fix| fix.fix.at == 0);
        for weighted in fixes {
            equations.add_prior(&weighted.fix, weighted.weight, &poses);
        }
        equations.add_prior(&self.anchor, 1.0, &poses);
        equations.add_edge(&motion.edge(0), &poses);
        self.poses.pop_front();
        self.fixes.retain(|fix| fix.fix.at > 0);
        self.fixes.iter_mut().for_each(|fix| fix.fix.at -= 1);
        self.anchor = equations.marginal(&poses[1]);
    }
}

impl<P: Clone, const D: usize> Motion<P, D> {
    /// The motion from pose `from` to the next.
    fn edge(&self, from: usize) -> Edge<P, D> {
        Edge {
            from,
            to: from + 1,
            measured: self.measured.clone(),
            information: self.information,
        }
    }
}

impl<P: Clone, const D: usize> WeightedFix<P, D> {
    /// The fix as a prior that is always right, with as much information as it is weighted.
    fn weighted(&self) -> Prior<P, D> {
        Prior {
            information: self.fix.information * self.weight,
            max_deviations: f64::INFINITY,
            ..self.fix.clone()
        }
    }
}

/// Normal equations of two poses, about where they are estimated to be.
struct TwoPoses<const D: usize> {
    first: SMatrix<f64, D, D>,
    second: SMatrix<f64, D, D>,
    /// Rows of the second, columns of the first.
    mixed: SMatrix<f64, D, D>,
    first_right: SVector<f64, D>,
    second_right: SVector<f64, D>,
}

impl<const D: usize> Default for TwoPoses<D> {
    fn default() -> Self {
        Self {
            first: SMatrix::zeros(),
            second: SMatrix::zeros(),
            mixed: SMatrix::zeros(),
            first_right: SVector::zeros(),
            second_right: SVector::zeros(),
        }
    }
}

impl<const D: usize> TwoPoses<D> {
    /// Adds a prior of the first pose.
    fn add_prior<P: Pose<D>>(&mut self, prior: &Prior<P, D>, weight: f64, poses: &[P]) {
        let off = prior.disagreement(poses);
        let jacobian = off.distance_jacobian();
        let weighted = jacobian.transpose() * prior.information * weight;
        self.first += weighted * jacobian;
        self.first_right -= weighted * off.distance();
    }

    /// Adds the edge between both.
    fn add_edge<P: Pose<D>>(&mut self, edge: &Edge<P, D>, poses: &[P]) {
        let linear = edge.linearized(poses);
        let weighted_from = linear.from.transpose() * edge.information;
        let weighted_to = linear.to.transpose() * edge.information;
        self.first += weighted_from * linear.from;
        self.first_right -= weighted_from * linear.residual;
        self.second = weighted_to * linear.to;
        self.mixed = weighted_to * linear.from;
        self.second_right = -(weighted_to * linear.residual);
    }

    /// What is known of the second pose alone: Schur's complement.
    fn marginal<P: Pose<D>>(&self, second: &P) -> Prior<P, D> {
        self.solve(second).unwrap_or_else(|| {
            // Without a solution nothing is known of it, and the pose stays where it is.
            Prior {
                at: 0,
                measured: second.clone(),
                information: SMatrix::zeros(),
                max_deviations: f64::INFINITY,
            }
        })
    }

    fn solve<P: Pose<D>>(&self, second: &P) -> Option<Prior<P, D>> {
        // The first pose is eliminated: Λ₂₂ - Λ₂₁ Λ₁₁⁻¹ Λ₁₂, and the right side likewise.
        let solved = self.first.try_inverse()?;
        let information = self.second - self.mixed * solved * self.mixed.transpose();
        let information = (information + information.transpose()) * 0.5;
        let covariance = information.try_inverse()?;
        let right = self.second_right - self.mixed * solved * self.first_right;
        let measured = second.moved(&(covariance * right));
        Some(Prior {
            at: 0,
            measured,
            information,
            max_deviations: f64::INFINITY,
        })
    }
}

/// Weight of a squared residual under the control parameter μ: equation 14.
fn weight(mu: f64, square: f64, max_deviations: f64) -> f64 {
    let limit = max_deviations * max_deviations;
    if mu.is_infinite() {
        return f64::from(u8::from(square <= limit));
    }
    if square <= mu / (mu + 1.0) * limit {
        1.0
    } else if square >= (mu + 1.0) / mu * limit {
        0.0
    } else {
        (max_deviations / square.sqrt() * (mu * (mu + 1.0)).sqrt() - mu).clamp(0.0, 1.0)
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

    /// Inverse of the covariance with these standard deviations: metres, metres, radians.
    fn information(deviations: [f64; 3]) -> Matrix3<f64> {
        Matrix3::from_diagonal(&Vector3::from(deviations).map(|x| 1.0 / (x * x)))
    }

    /// Noise from a seed.
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

    /// A drive, and how it went.
    struct Drive {
        window: Window<Isometry2<f64>, 3>,
        /// Distance from the truth after each step, metres.
        errors_m: Vec<f64>,
        /// Normalized error squared after the last step.
        nees: f64,
    }

    impl Drive {
        /// Drives for so many steps. Fixes have noise of a metre, and three in ten are off by up to
        /// fifty metres. `start` are the standard deviations of the first pose.
        fn new(seed: u64, start: [f64; 3], steps: usize) -> Self {
            let mut noise = Noise(seed);
            let mut truth = pose(0.0, 0.0, 0.0);
            let off = Vector3::from(start).map(|x| x * noise.normal());
            let window = Window::new(truth.moved(&off), information(start), 100);
            let mut drive = Self {
                window,
                errors_m: Vec::new(),
                nees: 0.0,
            };
            for _ in 0..steps {
                truth = truth.then(&pose(1.0, 0.0, 0.02));
                drive.step(&truth, &mut noise);
            }
            drive
        }

        fn step(&mut self, truth: &Isometry2<f64>, noise: &mut Noise) {
            let deviations = [0.005, 0.005, 0.0005];
            let slip = Vector3::from(deviations).map(|x| x * noise.normal());
            let measured = pose(1.0, 0.0, 0.02).moved(&slip);
            self.window.advance(measured, information(deviations));
            let is_outlier = noise.uniform() < 0.3;
            let off = if is_outlier {
                Vector2::new(noise.uniform() - 0.5, noise.uniform() - 0.5) * 70.0
            } else {
                Vector2::new(noise.normal(), noise.normal())
            };
            let there = truth.translation.vector + off;
            let heading = self.window.newest().rotation.angle();
            let fix = pose(there.x, there.y, heading);
            self.window.fix(fix, information([1.0, 1.0, 1e6]), 3.0);
            self.window.settle().unwrap();
            let error = truth.back().then(self.window.newest()).distance();
            let inverse = self.window.covariance().unwrap().try_inverse().unwrap();
            self.errors_m.push(error.xy().norm());
            self.nees = error.dot(&(inverse * error));
        }
    }

    #[test]
    fn a_third_of_the_fixes_may_be_outliers() {
        let drive = Drive::new(3, [0.1, 0.1, 0.02], 400);
        let mut errors_m = drive.errors_m;
        errors_m.sort_by(f64::total_cmp);
        assert!(
            errors_m[380] < 0.5 && errors_m[399] < 0.8,
            "{:?}",
            &errors_m[380..]
        );
        let FixCount { accepted, total } = drive.window.fix_count();
        assert_eq!(total, 100);
        assert!((55..85).contains(&accepted), "{accepted} of {total}");
    }

    #[test]
    fn errors_are_as_large_as_the_covariance_says() {
        let sum: f64 = (0..40)
            .map(|seed| Drive::new(seed, [2.0, 2.0, 0.05], 60).nees)
            .sum();
        // χ² of 120 degrees of freedom: 95 in 100 lie between.
        assert!((91.6..152.2).contains(&sum), "{sum}");
    }

    #[test]
    fn one_pose_keeps_no_more_than_its_share_of_fixes() {
        let unit = information([1.0; 3]);
        let mut window = Window::new(pose(0.0, 0.0, 0.0), unit, 5);
        (0..100).for_each(|_| window.fix(pose(1.0, 0.0, 0.0), unit, 3.0));
        window.settle().unwrap();
        let all = MAX_FIXES_PER_POSE;
        assert_eq!(
            window.fix_count(),
            FixCount {
                accepted: all,
                total: all
            }
        );
    }

    #[test]
    fn an_outlier_on_another_continent_makes_no_other_fix_an_outlier() {
        let start = information([5.0, 5.0, 0.1]);
        let of_fix = information([0.01, 0.01, 1e3]);
        let mut window = Window::new(pose(0.0, 0.0, 0.0), start, 5);
        (0..4).for_each(|_| window.fix(pose(1.0, 0.0, 0.0), of_fix, 3.0));
        window.fix(pose(9e6, -4e6, 0.0), of_fix, 3.0);
        window.settle().unwrap();
        assert_eq!(
            window.fix_count(),
            FixCount {
                accepted: 4,
                total: 5
            }
        );
        assert!((window.newest().translation.vector - Vector2::new(1.0, 0.0)).norm() < 1e-3);
    }

    proptest! {
        /// What is dropped is kept as a prior: the newest pose is that of the whole graph, except
        /// for terms of second order.
        #[test]
        fn a_short_window_agrees_with_a_long_one(
            n in proptest::collection::vec(-0.01_f64..0.01, 60),
        ) {
            let start = information([0.1, 0.1, 0.05]);
            let of_motion = information([0.05, 0.05, 0.02]);
            let of_fix = information([0.5, 0.5, 0.3]);
            let origin = pose(0.0, 0.0, 0.0);
            let mut windows = [5, 100].map(|size| Window::new(origin, start, size));
            for (i, n) in n.chunks(3).enumerate() {
                let motion = pose(1.0, 0.1 * n[0], 0.1 * n[1]);
                let fix = pose(i as f64 + 1.0 + n[0], n[1], 0.1 * n[2]);
                for window in &mut windows {
                    window.advance(motion, of_motion);
                    window.fix(fix, of_fix, 5.0);
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
