//! The objectives of the Timed Elastic Band as residuals with their derivatives.
//!
//! Knot i is (xᵢ, yᵢ, θᵢ, tᵢ); the papers' ΔTᵢ is tᵢ₊₁ - tᵢ. Times instead of differences keep
//! every term local, that of a moving obstacle too: its place depends on tᵢ alone, not on the sum
//! of all differences before. Inequalities are penalties: the square of the excess over a bound.

use openbench_core::{MapPoint, Velocity};

use crate::limits::Limits;
use crate::shape::{Footprint, Obstacle};
use crate::teb::normal::{BLOCK, Sink};
use crate::teb::settings::Settings;
use crate::trajectory::{TimedPose, Trajectory};

/// Variables of two knots.
const PAIR: usize = 2 * BLOCK;
/// Variables of three knots.
const TRIPLE: usize = 3 * BLOCK;
/// Stretches at the beginning in which a side to turn to may be preferred.
const SIDED: usize = 8;
/// Stretches shorter than this count as turns on the spot, metres: their length weighs no more than
/// this.
const SHORT_M: f64 = 0.01;
/// Excess over a bound that does not count: new bands go as fast as the robot can, and rounding
/// must not decide whether they exceed a limit.
const TOLERANCE: f64 = 1e-9;
/// Shortest duration of a stretch, seconds.
const SHORTEST_S: f64 = 1e-3;

/// The problem that a band has to solve.
#[derive(Debug, Clone, Copy)]
pub struct Problem<'a> {
    /// The robot's outline.
    pub footprint: &'a Footprint,
    /// Standing and moving obstacles.
    pub obstacles: &'a [Obstacle],
    /// The robot's limits.
    pub limits: &'a Limits,
    /// Weights and margins.
    pub settings: &'a Settings,
    /// The robot's velocity now.
    pub start: Velocity,
    /// Whether the robot has to stand at the end.
    pub stops: bool,
    /// Whether the yaw at the end is fixed.
    pub end_yaw: bool,
    /// Side to turn to: 1 left, -1 right, 0 either.
    pub side: f64,
}

/// A via point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Via {
    /// The knot that is to pass it.
    pub(crate) knot: usize,
    /// Where, in `map`.
    pub(crate) point: MapPoint,
}

/// What does not change during a pass of optimization.
#[derive(Debug, Clone, Default)]
pub(crate) struct Frozen {
    /// Wanted duration of each stretch, seconds.
    pub(crate) steps: Vec<f64>,
    /// Via points.
    pub(crate) vias: Vec<Via>,
    /// Length of each stretch when the band was last resized, metres: squares weighed by their
    /// inverse are lengths.
    pub(crate) lengths: Vec<f64>,
    /// The most that each knot has to keep off obstacles, metres: a band that begins near one
    /// leaves it gradually.
    pub(crate) allowed: Vec<f64>,
    /// Factor of the obstacles' weight, raised from pass to pass.
    pub(crate) firmness: f64,
}

/// A stretch between two knots, and the derivatives of its velocities by their variables.
struct Stretch {
    seconds: f64,
    chord: [f64; 2],
    sideways: f64,
    by_sideways: [f64; PAIR],
    speed: f64,
    by_speed: [f64; PAIR],
    turn: f64,
    by_turn: [f64; PAIR],
}

impl Stretch {
    /// The speed is taken along the mean heading: a circle's chord leaves and meets it at the same
    /// angle, so that an arc has no sideways component (the non-holonomic constraint of Roesmann et
    /// al. 2012).
    fn between(a: &TimedPose, b: &TimedPose) -> Self {
        let seconds = (b.time - a.time).max(SHORTEST_S);
        let chord = [b.pose.x - a.pose.x, b.pose.y - a.pose.y];
        let (s, c) = libm::sincos((a.pose.yaw + b.pose.yaw) / 2.0);
        let along = chord[0] * c + chord[1] * s;
        let sideways = chord[1] * c - chord[0] * s;
        // By x, y, yaw and time of both knots. The mean heading takes half of each yaw.
        let by_sideways = [s, -c, -0.5 * along, 0.0, -s, c, -0.5 * along, 0.0];
        let per = 1.0 / seconds;
        let speed = along * per;
        // Turning the mean heading changes `along` by `sideways`.
        let half = 0.5 * sideways * per;
        let by_speed = [
            -c * per,
            -s * per,
            half,
            speed * per,
            c * per,
            s * per,
            half,
            -speed * per,
        ];
        let turn = (b.pose.yaw - a.pose.yaw) * per;
        let by_turn = [0.0, 0.0, -per, turn * per, 0.0, 0.0, per, -turn * per];
        Self {
            seconds,
            chord,
            sideways,
            by_sideways,
            speed,
            by_speed,
            turn,
            by_turn,
        }
    }

    /// Speed of the left (`side` -1) or right (1) rim, and its derivatives.
    fn rim(&self, side: f64, half_track: f64) -> Rim {
        let arm = side * half_track;
        Rim {
            speed: self.speed + arm * self.turn,
            by_speed: std::array::from_fn(|k| self.by_speed[k] + arm * self.by_turn[k]),
        }
    }
}

/// Speed of a rim on a stretch, m/s, and its derivatives by the variables of both knots.
struct Rim {
    speed: f64,
    by_speed: [f64; PAIR],
}

/// Gives every residual of `band` to `sink`.
pub(crate) fn collect(
    band: &Trajectory,
    problem: &Problem<'_>,
    frozen: &Frozen,
    sink: &mut impl Sink,
) {
    let knots = band.poses();
    // The first knot is where the robot is, and cannot be moved.
    for (i, knot) in knots.iter().enumerate().skip(1) {
        obstacles(i, knot, problem, frozen, sink);
    }
    // An acceleration lies between two stretches. At the ends it lies between a stretch and the
    // robot's velocity there.
    let mut before: Option<Stretch> = None;
    for i in 0..knots.len() - 1 {
        let stretch = Stretch::between(&knots[i], &knots[i + 1]);
        let step = frozen.steps[i];
        drive(i, &stretch, step, frozen, problem, sink);
        match &before {
            Some(before) => {
                accelerate(i - 1, before, &stretch, step, problem, sink);
                steady(i - 1, before, &stretch, step, problem, sink);
            }
            None => {
                set_out(&stretch, step, problem, sink);
                steady_from_now(&stretch, step, problem, sink);
            }
        }
        before = Some(stretch);
    }
    if let Some(last) = before.filter(|_| problem.stops) {
        stop(
            knots.len() - 2,
            &last,
            frozen.steps[knots.len() - 2],
            problem,
            sink,
        );
    }
    let weight = problem.settings.weights.via;
    for &Via { knot, point } in &frozen.vias {
        let at = &knots[knot].pose;
        sink.add(knot, weight, at.x - point.x, &[1.0, 0.0, 0.0, 0.0]);
        sink.add(knot, weight, at.y - point.y, &[0.0, 1.0, 0.0, 0.0]);
    }
}

/// Distances to obstacles, of the whole footprint from the whole outline.
fn obstacles(
    i: usize,
    knot: &TimedPose,
    problem: &Problem<'_>,
    frozen: &Frozen,
    sink: &mut impl Sink,
) {
    let (margins, weights) = (&problem.settings.margins, &problem.settings.weights);
    let foot = problem.footprint.at(knot.pose);
    let step = frozen.steps[i.min(frozen.steps.len() - 1)];
    // Weights are for a second of nearness, and a knot stands for one step.
    let (firm, soft) = (
        weights.obstacle * frozen.firmness * step,
        weights.comfort * step,
    );
    for obstacle in problem.obstacles {
        let least = if obstacle.is_moving() {
            margins.moving
        } else {
            margins.least
        };
        let comfort = margins.comfort.max(least);
        let circle = problem.footprint.circumscribed();
        let Some(near) = obstacle.contact(&foot, circle, knot.time, comfort) else {
            continue;
        };
        if near.distance >= comfort {
            continue;
        }
        let n = near.normal;
        let velocity = obstacle.velocity();
        // The normal points to the obstacle: motion along it widens the gap.
        let away = n.dot(velocity);
        let gradient = [
            -near.gradient[0],
            -near.gradient[1],
            -near.gradient[2],
            -away,
        ];
        let depth = comfort - near.distance;
        // As if the whole depth were one unit, so that the cost of comfort does not depend on its
        // width.
        sink.add(i, soft / (comfort * comfort), depth, &gradient);
        let least = least.min(frozen.allowed[i]);
        if near.distance < least {
            sink.add(i, firm, least - near.distance, &gradient);
        }
    }
}

/// Time, length, non-holonomic kinematics, and the limits of speed and turn rate.
fn drive(
    i: usize,
    stretch: &Stretch,
    step: f64,
    frozen: &Frozen,
    problem: &Problem<'_>,
    sink: &mut impl Sink,
) {
    let (weights, limits) = (&problem.settings.weights, problem.limits);
    sink.add(
        i,
        weights.time / step,
        stretch.seconds,
        &[0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0],
    );
    // dᵢ² over the length is about the length again: the sum does not depend on how finely the band
    // is divided.
    let per_length = weights.length / frozen.lengths[i].max(SHORT_M);
    sink.add(i, per_length, stretch.chord[0], &[-1.0, 0.0, 0.0, 0.0, 1.0]);
    sink.add(
        i,
        per_length,
        stretch.chord[1],
        &[0.0, -1.0, 0.0, 0.0, 0.0, 1.0],
    );
    sink.add(i, weights.sideways, stretch.sideways, &stretch.by_sideways);
    // Equation 6 (2012), of the second order: nothing up to the bound, then the square of the
    // excess.
    let mut at_most = |weight: f64, over: f64, sign: f64, by: &[f64; PAIR]| {
        if over > TOLERANCE {
            sink.add(i, weight * step, over, &by.map(|d| sign * d));
        }
    };
    at_most(
        weights.speed,
        stretch.speed - limits.forward,
        1.0,
        &stretch.by_speed,
    );
    at_most(
        weights.speed,
        -stretch.speed - limits.backward,
        -1.0,
        &stretch.by_speed,
    );
    at_most(weights.backward, -stretch.speed, -1.0, &stretch.by_speed);
    at_most(
        weights.turn,
        stretch.turn - limits.turn,
        1.0,
        &stretch.by_turn,
    );
    at_most(
        weights.turn,
        -stretch.turn - limits.turn,
        -1.0,
        &stretch.by_turn,
    );
    if problem.side != 0.0 && i < SIDED {
        at_most(
            weights.side,
            -problem.side * stretch.turn,
            -problem.side,
            &stretch.by_turn,
        );
    }
}

/// Accelerations of both rims between two stretches, the first of which begins at knot `i`.
fn accelerate(
    i: usize,
    a: &Stretch,
    b: &Stretch,
    step: f64,
    problem: &Problem<'_>,
    sink: &mut impl Sink,
) {
    let both = a.seconds + b.seconds;
    for side in [-1.0, 1.0] {
        let u = a.rim(side, problem.limits.half_track);
        let v = b.rim(side, problem.limits.half_track);
        let rate = 2.0 / both;
        let acceleration = rate * (v.speed - u.speed);
        let over = acceleration.abs() - problem.limits.acceleration;
        if over <= TOLERANCE {
            continue;
        }
        let sign = acceleration.signum();
        let mut by = [0.0; TRIPLE];
        for k in 0..PAIR {
            by[k] -= sign * rate * u.by_speed[k];
            by[k + BLOCK] += sign * rate * v.by_speed[k];
        }
        // Both durations together depend on the first and the last time only.
        by[BLOCK - 1] += sign * acceleration / both;
        by[TRIPLE - 1] -= sign * acceleration / both;
        sink.add(i, problem.settings.weights.acceleration * step, over, &by);
    }
}

/// Changes of the turn rate between two stretches, as accelerations of the rims: the same change
/// costs a tenth if it takes ten times as long.
fn steady(
    i: usize,
    a: &Stretch,
    b: &Stretch,
    step: f64,
    problem: &Problem<'_>,
    sink: &mut impl Sink,
) {
    let weight = problem.settings.weights.steady;
    if weight == 0.0 {
        return;
    }
    let both = a.seconds + b.seconds;
    let rate = 2.0 * problem.limits.half_track / both;
    let change = rate * (b.turn - a.turn);
    let mut by = [0.0; TRIPLE];
    for k in 0..PAIR {
        by[k] -= rate * a.by_turn[k];
        by[k + BLOCK] += rate * b.by_turn[k];
    }
    by[BLOCK - 1] += change / both;
    by[TRIPLE - 1] -= change / both;
    sink.add(i, weight * step, change, &by);
}

/// The same from the robot's turn rate now to the middle of the first stretch.
fn steady_from_now(first: &Stretch, step: f64, problem: &Problem<'_>, sink: &mut impl Sink) {
    let weight = problem.settings.weights.steady;
    if weight == 0.0 {
        return;
    }
    let rate = 2.0 * problem.limits.half_track / first.seconds;
    let change = rate * (first.turn - problem.start.angular);
    let mut by = first.by_turn.map(|d| rate * d);
    by[BLOCK - 1] += change / first.seconds;
    by[PAIR - 1] -= change / first.seconds;
    sink.add(0, weight * step, change, &by);
}

/// Accelerations from the robot's velocity now to the middle of the first stretch.
fn set_out(first: &Stretch, step: f64, problem: &Problem<'_>, sink: &mut impl Sink) {
    for side in [-1.0, 1.0] {
        let now = problem.start.linear + side * problem.limits.half_track * problem.start.angular;
        let end = RimAtEnd {
            side,
            speed: now,
            direction: 1.0,
        };
        change(0, first, end, step, problem, sink);
    }
}

/// Accelerations from the middle of the last stretch to standing.
fn stop(i: usize, last: &Stretch, step: f64, problem: &Problem<'_>, sink: &mut impl Sink) {
    for side in [-1.0, 1.0] {
        let end = RimAtEnd {
            side,
            speed: 0.0,
            direction: -1.0,
        };
        change(i, last, end, step, problem, sink);
    }
}

/// A rim at an end of a stretch.
#[derive(Clone, Copy)]
struct RimAtEnd {
    /// Left (-1) or right (1).
    side: f64,
    /// Its speed there, m/s.
    speed: f64,
    /// Whether the end is the beginning of the stretch (1) or its end (-1).
    direction: f64,
}

/// Acceleration of a rim between the middle of a stretch and one of its ends.
fn change(
    i: usize,
    stretch: &Stretch,
    end: RimAtEnd,
    step: f64,
    problem: &Problem<'_>,
    sink: &mut impl Sink,
) {
    let rim = stretch.rim(end.side, problem.limits.half_track);
    // The mean speed of a stretch is that at its middle, half a duration from its ends.
    let rate = 2.0 * end.direction / stretch.seconds;
    let acceleration = rate * (rim.speed - end.speed);
    let over = acceleration.abs() - problem.limits.acceleration;
    if over <= TOLERANCE {
        return;
    }
    let sign = acceleration.signum();
    let mut by = rim.by_speed.map(|d| sign * rate * d);
    by[BLOCK - 1] += sign * acceleration / stretch.seconds;
    by[PAIR - 1] -= sign * acceleration / stretch.seconds;
    sink.add(i, problem.settings.weights.acceleration * step, over, &by);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::Vector2;
    use openbench_core::{Pose2, RobotDescription};
    use proptest::prelude::*;

    /// Every residual with its derivatives by all variables.
    #[derive(Default)]
    struct List(Vec<(f64, Vec<(usize, f64)>)>);

    impl Sink for List {
        fn add<const K: usize>(
            &mut self,
            knot: usize,
            weight: f64,
            residual: f64,
            gradient: &[f64; K],
        ) {
            let root = weight.sqrt();
            let entries = gradient
                .iter()
                .enumerate()
                .map(|(k, d)| (knot * BLOCK + k, root * d))
                .collect();
            self.0.push((root * residual, entries));
        }
    }

    fn obstacles() -> Vec<Obstacle> {
        let at = MapPoint::new;
        let square = [at(1.2, 0.2), at(1.6, 0.2), at(1.6, 0.7), at(1.2, 0.7)];
        vec![
            Obstacle::new(&square, 0.0, Vector2::ZERO).unwrap(),
            Obstacle::disc(at(0.8, -0.5), 0.2).unwrap(),
            Obstacle::wall(at(0.5, -1.0), at(2.0, -0.6)).unwrap(),
            Obstacle::new(&[at(1.5, 1.0)], 0.25, Vector2::new(0.2, -0.9)).unwrap(),
        ]
    }

    prop_compose! {
        /// Five knots along the x axis.
        fn chain()(
            steps in prop::collection::vec(
                (-0.15..0.15_f64, -0.3..0.3_f64, -0.8..0.8_f64, 0.05..0.5_f64),
                5,
            ),
        ) -> Vec<TimedPose> {
            let mut time = -0.1;
            let knot = |(i, (x, y, yaw, dt)): (usize, &(f64, f64, f64, f64))| {
                time += dt + 0.05;
                TimedPose { pose: Pose2::new(0.4 * i as f64 + x, *y, *yaw), time }
            };
            steps.iter().enumerate().map(knot).collect()
        }
    }

    /// Knots with one variable moved.
    fn moved(knots: &[TimedPose], variable: usize, by: f64) -> Vec<TimedPose> {
        let mut knots = knots.to_vec();
        let knot = &mut knots[variable / BLOCK];
        match variable % BLOCK {
            0 => knot.pose.x += by,
            1 => knot.pose.y += by,
            2 => knot.pose.yaw += by,
            _ => knot.time += by,
        }
        knots
    }

    proptest! {
        /// Every residual and derivative enters the sum of squares and its gradient.
        #[test]
        fn derivatives_are_those_of_finite_differences(
            knots in chain(),
            speed in -0.3..0.6_f64,
            rate in -1.5..1.5_f64,
            side in -1..2_i32,
        ) {
            const STEP: f64 = 1e-7;
            let robot = RobotDescription::sentry();
            let (footprint, limits) = (Footprint::of(&robot).unwrap(), Limits::of(&robot).unwrap());
            let obstacles = obstacles();
            let mut settings = Settings::default();
            (settings.weights.via, settings.weights.side) = (0.7, 0.3);
            let problem = Problem {
                footprint: &footprint,
                obstacles: &obstacles,
                limits: &limits,
                settings: &settings,
                start: Velocity::new(speed, rate),
                stops: true,
                end_yaw: true,
                side: f64::from(side),
            };
            let frozen = Frozen {
                steps: vec![0.2; 4],
                lengths: vec![0.3, 0.4, 0.0, 0.5],
                allowed: vec![f64::INFINITY, 0.01, 0.02, 1.0, 1.0],
                vias: vec![Via { knot: 2, point: MapPoint::new(0.9, 0.2) }],
                firmness: 1.0,
            };
            let residuals = |knots: Vec<TimedPose>| {
                let mut list = List::default();
                collect(&Trajectory::new(knots).unwrap(), &problem, &frozen, &mut list);
                list.0
            };
            let here = residuals(knots.clone());
            for variable in 0..knots.len() * BLOCK {
                let up = residuals(moved(&knots, variable, STEP));
                let down = residuals(moved(&knots, variable, -STEP));
                if up.len() != here.len() || down.len() != here.len() {
                    continue; // A bound is just being reached.
                }
                for (r, (up, down)) in here.iter().zip(up.iter().zip(&down)) {
                    let (forward, back) = ((up.0 - r.0) / STEP, (r.0 - down.0) / STEP);
                    let by_variable = r.1.iter().filter(|(v, _)| *v == variable);
                    let stated: f64 = by_variable.map(|(_, d)| d).sum();
                    let scale = 1.0 + stated.abs();
                    // Where the nearest edge changes there is no derivative.
                    let smooth = (forward - back).abs() < 1e-3 * scale;
                    let agrees = (forward - stated).abs() < 2e-3 * scale;
                    prop_assert!(!smooth || agrees, "{variable}: {stated} {forward} {:?}", r);
                }
            }
        }
    }
}
