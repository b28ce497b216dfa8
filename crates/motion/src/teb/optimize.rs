//! Optimization of a band: the Levenberg-Marquardt method on banded normal equations, with resizing
//! between passes.

use openbench_core::{MapPoint, Pose2};

use crate::teb::normal::{BLOCK, Normal, Total};
use crate::teb::terms::{Frozen, Problem, Via, collect};
use crate::trajectory::{TimedPose, Trajectory};

/// How much a band is optimized.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Passes; before each one the band is resized.
    pub passes: usize,
    /// Steps in a pass, at most.
    pub steps: usize,
    /// A pass ends when a step gains less than this share of the cost.
    pub enough: f64,
}

impl Effort {
    /// For a band that was optimized in the last cycle.
    pub const WARM: Self = Self {
        passes: 2,
        steps: 4,
        enough: 1e-3,
    };
    /// For a new band.
    pub const COLD: Self = Self {
        passes: 4,
        steps: 8,
        enough: 1e-3,
    };
    /// For a band without a limit of time.
    pub const PATIENT: Self = Self {
        passes: 12,
        steps: 60,
        enough: 1e-6,
    };
}

/// Firmness of obstacles in the first pass. It grows eightfold from pass to pass, up to 1, so that
/// a band first finds its side and then its shape.
const SOFT: f64 = 0.02;
/// Distance from which on a start counts as free of obstacles, metres.
const NEAR_M: f64 = 0.5;
/// How fast a band that begins near an obstacle has to leave it, m/s.
const LEAVING_MPS: f64 = 0.1;
/// Least damping.
const LEAST_DAMPING: f64 = 1e-4;
/// Most damping.
const MOST_DAMPING: f64 = 1e10;
/// Damping of the first step.
const FIRST_DAMPING: f64 = 30.0;
/// Least share of a stretch's duration that a step leaves.
const SHORTEST: f64 = 0.3;
/// The most that a knot turns in one step, radians.
const SHARPEST_RAD: f64 = 0.5;

/// An optimizer; its buffers are used again from band to band.
#[derive(Debug, Clone, Default)]
pub struct Optimizer {
    damping: f64,
    normal: Normal,
    frozen: Frozen,
    trial: Option<Trajectory>,
}

impl Optimizer {
    /// Optimizes a band and returns its cost. `vias` are points that it should pass, in `map`.
    pub fn improve(
        &mut self,
        band: &mut Trajectory,
        problem: &Problem<'_>,
        vias: &[MapPoint],
        effort: &Effort,
    ) -> f64 {
        let mut cost = f64::INFINITY;
        self.damping = FIRST_DAMPING;
        for pass in 0..effort.passes {
            band.resize(&problem.settings.resolution);
            // A band that was optimized in the last cycle has its side already.
            let rising = effort.passes > 2;
            let firmness = if rising {
                // Eight to the power of `pass`, bounded against overflow.
                SOFT * (1u32 << (3 * pass).min(20)) as f64
            } else {
                1.0
            };
            let last = pass + 1 == effort.passes;
            self.freeze(
                band,
                problem,
                vias,
                // The last pass has the real weights, however many passes there are.
                if last { 1.0 } else { firmness.min(1.0) },
            );
            cost = self.descend(band, problem, effort);
        }
        cost
    }

    /// Fixes what does not change during a pass.
    fn freeze(
        &mut self,
        band: &Trajectory,
        problem: &Problem<'_>,
        vias: &[MapPoint],
        firmness: f64,
    ) {
        let resolution = &problem.settings.resolution;
        self.frozen.firmness = firmness;
        self.frozen.steps.clear();
        self.frozen
            .steps
            .extend(band.poses().iter().map(|k| resolution.step_at(k.time)));
        let stretches = band.poses().windows(2);
        self.frozen.lengths.clear();
        self.frozen
            .lengths
            .extend(stretches.map(|w| w[0].pose.point().distance(w[1].pose.point())));
        let circle = problem.footprint.circumscribed();
        let placed = problem.footprint.at(band.poses()[0].pose);
        // A band that begins near an obstacle cannot keep the margin at once. It has to keep what
        // there is, and more with time.
        let near = problem
            .obstacles
            .iter()
            .filter_map(|o| o.contact(&placed, circle, 0.0, NEAR_M));
        let start = near.map(|contact| contact.distance).fold(NEAR_M, f64::min);
        self.frozen.allowed.clear();
        self.frozen
            .allowed
            .extend(band.poses().iter().map(|k| start + LEAVING_MPS * k.time));
        self.frozen.vias.clear();
        if problem.settings.weights.via == 0.0 {
            return;
        }
        let knots = band.poses();
        // For the whole pass a via point belongs to the knot that is nearest now.
        for via in vias {
            let away = |i: &usize| knots[*i].pose.point().distance(*via);
            // Both ends are fixed, and can pass no point.
            let nearest = (1..knots.len() - 1).min_by(|a, b| away(a).total_cmp(&away(b)));
            self.frozen
                .vias
                .extend(nearest.map(|knot| Via { knot, point: *via }));
        }
    }

    /// One pass. The damping follows H. B. Nielsen, *Damping Parameter in Marquardt's Method*,
    /// 1999: it depends on how well the last step was predicted.
    fn descend(&mut self, band: &mut Trajectory, problem: &Problem<'_>, effort: &Effort) -> f64 {
        let mut cost = self.linearize(band, problem);
        let mut raise = 2.0;
        for _ in 0..effort.steps {
            let trial = self.trial.get_or_insert_with(|| band.clone());
            trial.clone_from(band);
            let foreseen = self.normal.step(self.damping).map(|step| {
                take(trial.poses_mut(), step.by);
                step.fall
            });
            let mut total = Total::default();
            collect(trial, problem, &self.frozen, &mut total);
            let gain = cost - total.0;
            // Written so that NaN is no gain.
            let Some(foreseen) = foreseen.filter(|_| gain > 0.0) else {
                // The bound is high: stiff bands need much damping before a step gains anything.
                self.damping = (self.damping * raise).min(MOST_DAMPING);
                raise *= 2.0;
                continue;
            };
            // Nielsen's 2 ρ - 1, ρ being the gain over the predicted one. A gain beyond the
            // prediction counts as predicted.
            let quality = 2.0 * gain / foreseen.max(gain) - 1.0;
            self.damping = (self.damping * (1.0 - quality * quality * quality).max(1.0 / 3.0))
                .max(LEAST_DAMPING);
            raise = 2.0;
            std::mem::swap(trial, band);
            cost = total.0;
            if gain < effort.enough * cost {
                break;
            }
            self.linearize(band, problem);
        }
        cost
    }

    /// Sets up the normal equations at a band, with its ends held; returns its cost.
    fn linearize(&mut self, band: &Trajectory, problem: &Problem<'_>) -> f64 {
        let knots = band.poses().len();
        self.normal.clear(knots);
        collect(band, problem, &self.frozen, &mut self.normal);
        let end = (knots - 1) * BLOCK;
        // The start with its time, and the place of the end. The time of the end is free: it is
        // minimized.
        let held = [0, 1, 2, 3, end, end + 1]
            .into_iter()
            .chain(problem.end_yaw.then_some(end + 2));
        held.for_each(|variable| self.normal.hold(variable));
        self.normal.total()
    }
}

/// Moves the knots by a step of all variables.
///
/// Headings and times move by the step. Positions are laid anew from chord to chord, each as long
/// and as far aside of its heading as the step says: a straight step would violate the
/// non-holonomic constraint, and be refused or have to be tiny. The error at the end is small (of
/// second order) and distributed over all knots.
fn take(knots: &mut [TimedPose], step: &[f64]) {
    let last = knots.len() - 1;
    let (goal, mut at) = (knots[last].pose.point(), knots[0].pose.point());
    let (mut old, mut before) = (knots[0], [0.0; BLOCK]);
    for (knot, step) in knots.iter_mut().zip(step.chunks_exact(BLOCK)).skip(1) {
        let new = *knot;
        let (mean, turned) = (
            (old.pose.yaw + new.pose.yaw) / 2.0,
            (before[2] + bounded_turn(step[2])) / 2.0,
        );
        let (s, c) = libm::sincos(mean);
        let chord = [new.pose.x - old.pose.x, new.pose.y - old.pose.y];
        // The chord in the frame of its mean heading.
        let (along, aside) = (chord[0] * c + chord[1] * s, chord[1] * c - chord[0] * s);
        let moved = [step[0] - before[0], step[1] - before[1]];
        // To first order: the step of the chord in that frame, and the turn of the frame itself.
        let along_new = along + moved[0] * c + moved[1] * s + turned * aside;
        let aside_new = aside + moved[1] * c - moved[0] * s - turned * along;
        let (s, c) = libm::sincos(mean + turned);
        at = MapPoint::new(
            at.x + along_new * c - aside_new * s,
            at.y + along_new * s + aside_new * c,
        );
        let seconds = new.time - old.time;
        // Times have to rise.
        let seconds = (seconds + step[3] - before[3]).max(SHORTEST * seconds);
        before = [step[0], step[1], bounded_turn(step[2]), step[3]];
        knot.pose = Pose2::new(at.x, at.y, new.pose.yaw + before[2]);
        // A duration for now; the loop below adds them up.
        knot.time = seconds;
        old = new;
    }
    let mut time = knots[0].time;
    for knot in &mut knots[1..] {
        time += knot.time;
        knot.time = time;
    }
    let missing = [goal.x - at.x, goal.y - at.y];
    let (from, whole) = (knots[0].time, time - knots[0].time);
    for knot in &mut knots[1..] {
        let share = (knot.time - from) / whole;
        knot.pose.x += share * missing[0];
        knot.pose.y += share * missing[1];
    }
}

/// The turn of a step, radians: large ones come from a poor linearization.
fn bounded_turn(turn: f64) -> f64 {
    turn.clamp(-SHARPEST_RAD, SHARPEST_RAD)
}
