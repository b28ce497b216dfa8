//! Time-optimal path parametrization by reachability analysis (TOPP-RA; H. Pham and Q.-C. Pham,
//! 2018) for the wheel rims of a differential drive.
//!
//! The path is divided into segments of equal length, and s counts them. z = (ds/dt)² changes by 2
//! s̈ from one segment to the next. A rim that covers L metres in a segment has the acceleration L′
//! z + L s̈, where L′ is the change of L from segment to segment.
//!
//! The backward pass finds K, the largest z at each knot from which the rest can be driven. The
//! forward pass chooses the largest admissible z from the start.

use openbench_core::Pose2;
use openbench_motion::Limits;
use openbench_motion::kinematics::{on_arc, velocity};
use openbench_motion::{TimedPose, Trajectory};

/// Upper bound of z, for segments without motion.
const MAX_Z: f64 = 1e6;
/// Length of a segment.
const SEGMENT_M: f64 = 0.02;
/// Iterations of the bisection for K.
const BISECTIONS: usize = 60;
/// Minimum number of segments of a piece.
const MIN_SEGMENTS: f64 = 30.0;
/// Maximum number of rounds in which knots with an excessive acceleration are slowed.
const MAX_ROUNDS: usize = 20;
/// Relative excess over the limit of the acceleration that is tolerated.
const ACCELERATION_TOLERANCE: f64 = 1e-3;
/// Lower bound of z between the ends: at z = 0 the robot would not continue.
const MIN_Z: f64 = 0.05;
/// Tolerance for rounding: a length in metres, or a share.
const ROUNDING: f64 = 1e-6;

/// The path of a trajectory with the shortest times, from rest to rest. The robot stops only where
/// both rims reverse. `None` if the path has no length. Lateral parts of the path take no time.
pub fn retimed(trajectory: &Trajectory, limits: &Limits) -> Option<Trajectory> {
    let mut knots = vec![TimedPose {
        pose: trajectory.poses()[0].pose,
        time: 0.0,
    }];
    for piece in pieces(trajectory.poses(), limits.half_track) {
        let poses = divided(piece, limits.half_track);
        let began = knots[knots.len() - 1].time;
        // From rest to rest: between two pieces both rims stand for an instant.
        let times = times(&poses, limits)?;
        knots.extend(
            poses
                .iter()
                .zip(times)
                // The first pose of a piece is the last one of the piece before.
                .skip(1)
                .map(|(&pose, time)| TimedPose {
                    pose,
                    time: began + time,
                }),
        );
    }
    Trajectory::new(knots)
}

/// The pieces between points at which both rims reverse, ends included.
fn pieces(knots: &[TimedPose], half_track: f64) -> Vec<&[TimedPose]> {
    let mut pieces = Vec::new();
    let (mut first, mut before) = (0, [0.0; 2]);
    for (i, pair) in knots.windows(2).enumerate() {
        let rims = Arc::between(pair[0].pose, pair[1].pose).rims(half_track);
        // Without motion there is no direction to compare.
        if rims.iter().all(|rim| rim.abs() < ROUNDING) {
            continue;
        }
        // If both rims reverse, ds/dt is zero here. If one does, the robot moves on, and only L
        // changes its sign.
        if (0..2).all(|side| rims[side] * before[side] < 0.0) {
            pieces.push(&knots[first..=i]);
            first = i;
        }
        before = rims;
    }
    pieces.push(&knots[first..]);
    // A piece without motion has no length to divide.
    pieces.retain(|piece| piece.windows(2).any(|pair| pair[0].pose != pair[1].pose));
    pieces
}

/// Poses along a piece at equal distances, measured along the rims.
fn divided(piece: &[TimedPose], half_track: f64) -> Vec<Pose2> {
    let length = |pair: &[TimedPose]| {
        let arc = Arc::between(pair[0].pose, pair[1].pose);
        // The distance of the faster rim.
        arc.length.abs() + half_track * arc.turn.abs()
    };
    let whole: f64 = piece.windows(2).map(length).sum();
    let count = (whole / SEGMENT_M).ceil().max(MIN_SEGMENTS);
    let mut poses = vec![piece[0].pose];
    let mut passed = 0.0;
    // Pose n lies at the share n / count of the whole length.
    for pair in piece.windows(2) {
        let length = length(pair);
        while (poses.len() as f64) < count && poses.len() as f64 * whole / count <= passed + length
        {
            let at = poses.len() as f64 * whole / count - passed;
            poses.push(on_arc(
                pair[0].pose,
                pair[1].pose,
                if length > 0.0 { at / length } else { 1.0 },
            ));
        }
        passed += length;
    }
    poses.push(piece[piece.len() - 1].pose);
    poses
}

/// The shortest times along poses, from rest to rest.
fn times(poses: &[Pose2], limits: &Limits) -> Option<Vec<f64>> {
    let mut path = RimPath::of(poses, limits);
    for _ in 0..MAX_ROUNDS {
        let times = path.times()?;
        if !path.slow_down(&times) {
            return Some(times);
        }
    }
    // What still exceeds the limit after all rounds is slowed down by the caller.
    path.times()
}

/// The arc from one pose to another.
#[derive(Debug, Clone, Copy)]
struct Arc {
    /// Metres, negative backwards.
    length: f64,
    /// Radians, counter-clockwise.
    turn: f64,
}

impl Arc {
    fn between(from: Pose2, to: Pose2) -> Self {
        // In one second, velocities are distances.
        let velocity = velocity(from, to, 1.0);
        Self {
            length: velocity.linear,
            turn: velocity.angular,
        }
    }

    /// Distance covered by the left and the right rim, metres.
    fn rims(self, half_track: f64) -> [f64; 2] {
        let Self { length, turn } = self;
        [length - half_track * turn, length + half_track * turn]
    }

    /// The largest z on a segment with this arc by the limits of speed and turn rate.
    fn cap(self, limits: &Limits) -> f64 {
        let speed = if self.length < 0.0 {
            limits.backward
        } else {
            limits.forward
        };
        // The rate ds/dt in segments per second. Without a length or a turn, the quotient is
        // infinite.
        let rate = (speed / self.length.abs()).min(limits.turn / self.turn.abs());
        (rate * rate).min(MAX_Z)
    }
}

/// The motion of both rims along a path.
struct RimPath {
    /// Distance covered by both rims in each segment, metres.
    rims: Vec<[f64; 2]>,
    /// The largest z at each knot by the limits of speed and turn rate.
    caps: Vec<f64>,
    acceleration: f64,
}

impl RimPath {
    fn of(poses: &[Pose2], limits: &Limits) -> Self {
        let arcs: Vec<Arc> = poses
            .windows(2)
            .map(|pair| Arc::between(pair[0], pair[1]))
            .collect();
        // A knot is in two segments, so the lower of their bounds holds.
        let inner = arcs
            .windows(2)
            .map(|pair| pair[0].cap(limits).min(pair[1].cap(limits)));
        Self {
            rims: arcs.iter().map(|arc| arc.rims(limits.half_track)).collect(),
            // From rest to rest.
            caps: std::iter::once(0.0).chain(inner).chain([0.0]).collect(),
            acceleration: limits.acceleration,
        }
    }

    /// The forward pass: the time at each knot, or `None` if a segment cannot be driven.
    fn times(&self) -> Option<Vec<f64>> {
        let reach = self.controllable();
        let (mut z, mut times) = (0.0_f64, vec![0.0]);
        for k in 0..self.rims.len() {
            let most = self.largest_acceleration(k, z, reach[k + 1])?;
            // Over one segment z changes by 2 s̈. With constant s̈, the mean rate is that of both
            // ends.
            let next = (z + 2.0 * most).clamp(0.0, reach[k + 1]);
            let rate = (z.sqrt() + next.sqrt()) / 2.0;
            times.push(times[k] + 1.0 / rate);
            z = next;
        }
        Some(times)
    }

    /// Lowers z at knots where the times require more acceleration than the limit; returns whether
    /// there were any. Between segments that differ much, the discretization underestimates the
    /// acceleration.
    fn slow_down(&mut self, times: &[f64]) -> bool {
        let mut slower = false;
        for k in 1..self.rims.len() {
            let (before, after) = (times[k] - times[k - 1], times[k + 1] - times[k]);
            // The change of a rim's mean speed from one segment to the next.
            let change =
                |side: usize| (self.rims[k][side] / after - self.rims[k - 1][side] / before).abs();
            let ratio = change(0).max(change(1)) * 2.0 / (before + after) / self.acceleration;
            if ratio > 1.0 + ACCELERATION_TOLERANCE {
                // The z that the times stand for: two segments in `before + after` seconds.
                self.caps[k] = (self.caps[k].min((2.0 / (before + after)).powi(2))
                    / (ratio * ratio))
                    .max(MIN_Z);
                slower = true;
            }
        }
        slower
    }

    /// The backward pass: K, the largest z at each knot from which the rest can be driven.
    fn controllable(&self) -> Vec<f64> {
        let mut reach = self.caps.clone();
        for k in (0..self.rims.len()).rev() {
            // All conditions are linear in z and s̈, so the admissible z are an interval. Bisection
            // finds its upper end, beginning with a `low` that is close to standstill.
            let (mut low, mut high) = (if k == 0 { 0.0 } else { MIN_Z }, reach[k]);
            if self.largest_acceleration(k, high, reach[k + 1]).is_some() {
                continue;
            }
            for _ in 0..BISECTIONS {
                let middle = (low + high) / 2.0;
                let is_possible = self.largest_acceleration(k, middle, reach[k + 1]).is_some();
                *(if is_possible { &mut low } else { &mut high }) = middle;
            }
            // Slightly below the bound, so that rounding cannot exceed it.
            reach[k] = low * (1.0 - ROUNDING);
        }
        reach
    }

    /// The largest s̈ on segment `k` with which both rims respect their limit at both ends, and the
    /// next z is between [`MIN_Z`] and `most`; `None` if there is none.
    fn largest_acceleration(&self, k: usize, z: f64, most: f64) -> Option<f64> {
        let least = if k + 1 == self.rims.len() { 0.0 } else { MIN_Z };
        // From the bounds of the next z, which is z + 2 s̈.
        let (mut low, mut high) = ((least - z) / 2.0, (most - z) / 2.0);
        let here = self.rims[k];
        // At the ends of the path there is no neighbour, and L does not change.
        let before = if k == 0 { here } else { self.rims[k - 1] };
        let after = self.rims.get(k + 1).copied().unwrap_or(here);
        for side in 0..2 {
            let (change, mean) = (here[side] - before[side], (here[side] + before[side]) / 2.0);
            let (change_after, mean_after) =
                (after[side] - here[side], (after[side] + here[side]) / 2.0);
            // At its beginning, and at its end, where z has grown by 2 s̈.
            for (of_z, of_w) in [
                (change, mean),
                (change_after, mean_after + 2.0 * change_after),
            ] {
                // -acceleration <= of_z z + of_w s̈ <= acceleration, solved for s̈.
                let (least, most) = (-self.acceleration - of_z * z, self.acceleration - of_z * z);
                if of_w.abs() > f64::EPSILON {
                    let (a, b) = (least / of_w, most / of_w);
                    (low, high) = (low.max(a.min(b)), high.min(a.max(b)));
                } else if least > 0.0 || most < 0.0 {
                    return None;
                }
            }
        }
        // The bounds may cross by rounding.
        (low <= high + ROUNDING * (1.0 + low.abs())).then_some(high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::MapPoint;
    use proptest::prelude::*;

    const LIMITS: Limits = Limits {
        forward: 0.5,
        backward: 0.2,
        turn: 1.0,
        acceleration: 1.0,
        half_track: 0.2,
    };

    fn through(poses: &[(f64, f64, f64)]) -> Trajectory {
        let knot = |(i, &(x, y, yaw))| TimedPose {
            pose: Pose2::new(x, y, yaw),
            time: i as f64,
        };
        Trajectory::new(poses.iter().enumerate().map(knot).collect()).unwrap()
    }

    fn seconds(poses: &[(f64, f64, f64)]) -> f64 {
        retimed(&through(poses), &LIMITS).unwrap().duration()
    }

    /// Duration of a trapezoidal speed profile over a distance.
    fn ramps(distance: f64, most: f64, acceleration: f64) -> f64 {
        let far = most * most / acceleration;
        if distance > far {
            distance / most + most / acceleration
        } else {
            2.0 * (distance / acceleration).sqrt()
        }
    }

    #[test]
    fn straight_paths_and_turns_have_the_analytic_duration() {
        let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 5e-3;
        for length in [0.1, 0.2, 1.0, 3.0] {
            assert!(
                near(
                    seconds(&[(0.0, 0.0, 0.0), (length, 0.0, 0.0)]),
                    ramps(length, 0.5, 1.0)
                ),
                "{length}"
            );
            assert!(
                near(
                    seconds(&[(0.0, 0.0, 0.0), (-length, 0.0, 0.0)]),
                    ramps(length, 0.2, 1.0)
                ),
                "{length}"
            );
        }
        // On the spot: the rims, 0.2 m from the middle, accelerate by 1 m/s², the robot by 5
        // rad/s².
        for turn in [0.1, -0.3, 2.0, -6.0] {
            let found = seconds(&[(0.0, 0.0, 0.0), (0.0, 0.0, turn)]);
            assert!(
                near(found, ramps(f64::abs(turn), 1.0, 5.0)),
                "{turn} {found}"
            );
        }
        // Forth and back.
        let found = seconds(&[
            (0.0, 0.0, 0.0),
            (1.0, 0.0, 0.0),
            (1.0, 0.0, 0.0),
            (0.5, 0.0, 0.0),
        ]);
        assert!(
            near(found, ramps(1.0, 0.5, 1.0) + ramps(0.5, 0.2, 1.0)),
            "{found}"
        );
    }

    #[test]
    fn the_robot_stops_only_where_both_rims_reverse() {
        let turn = |noise: f64| -> Vec<(f64, f64, f64)> {
            let at = |i: i32| (noise * f64::from(i % 2), 0.0, 0.05 * f64::from(i));
            (0..=40).map(at).collect()
        };
        assert!((seconds(&turn(1e-5)) / seconds(&turn(0.0)) - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_trajectory_without_length_has_no_times() {
        assert_eq!(
            retimed(&through(&[(1.0, 2.0, 0.5), (1.0, 2.0, 0.5)]), &LIMITS),
            None
        );
    }

    proptest! {
        /// Along rounded corners the limits are exceeded by no more than the discretization error,
        /// and the path does not change.
        #[test]
        fn limits_are_respected_along_any_path(
            corners in prop::collection::vec((-3.0..3.0_f64, -3.0..3.0_f64), 1..5),
            yaw in -3.0..3.0_f64,
        ) {
            check(&corners, yaw)?;
        }
    }

    fn check(corners: &[(f64, f64)], yaw: f64) -> Result<(), TestCaseError> {
        let corners: Vec<MapPoint> = corners.iter().map(|&(x, y)| MapPoint::new(x, y)).collect();
        let start = Pose2::default();
        let Some(trajectory) = Trajectory::along(start, &corners, Some(yaw), &LIMITS, 1.0) else {
            return Ok(());
        };
        let retimed = retimed(&trajectory, &LIMITS).unwrap();
        let mut before = (0.0, 0.0, 0.0);
        for (i, pair) in retimed.poses().windows(2).enumerate() {
            let (v, seconds) = (retimed.velocity(i), pair[1].time - pair[0].time);
            prop_assert!(v.linear < 0.5 * 1.001 && v.linear > -0.2 * 1.001);
            prop_assert!(v.angular.abs() < 1.001);
            let rims = [v.linear - 0.2 * v.angular, v.linear + 0.2 * v.angular];
            let between = (seconds + before.2) / 2.0;
            for (now, then) in rims.into_iter().zip([before.0, before.1]) {
                let acceleration = (now - then).abs() / between;
                prop_assert!(
                    acceleration < 1.1,
                    "{} {now} {then} {between}",
                    pair[0].time
                );
            }
            before = (rims[0], rims[1], seconds);
        }
        prop_assert_eq!(
            trajectory.poses().last().unwrap().pose,
            retimed.poses().last().unwrap().pose
        );
        prop_assert!(retimed.duration() > 0.99 * trajectory.duration());
        let distance_to_trajectory = |pose: Pose2| {
            let times =
                (0..=400).map(|i| trajectory.pose_at(f64::from(i) / 400.0 * trajectory.duration()));
            times
                .map(|at| at.point().distance(pose.point()))
                .fold(9.0, f64::min)
        };
        let is_near = |knot: &TimedPose| distance_to_trajectory(knot.pose) < 0.05;
        prop_assert!(retimed.poses().iter().all(is_near));
        Ok(())
    }
}
