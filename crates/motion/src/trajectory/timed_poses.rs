//! The band: poses at times, read and carried along from cycle to cycle.

use openbench_core::{MapPoint, Pose2, Velocity, frames::wrap_angle};

use crate::kinematics::{on_arc, velocity};
use crate::limits::Limits;

/// A pose this far from the expected one is a jump of the estimate, not a slip of the wheels,
/// metres.
const JUMP_M: f64 = 0.15;
/// The same of the heading, radians.
const JUMP_RAD: f64 = 0.2;

/// Seconds ahead from which a command is taken: the time until the next command, and a little for
/// latency.
pub(crate) const COMMAND_S: f64 = 0.1;
/// Metres that count as much as a radian where poses are compared.
const TURN_WEIGHT_M: f64 = 0.3;

/// A pose at a time. The yaw is not wrapped: a full turn to the left is another trajectory than one
/// to the right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedPose {
    /// The pose in `map`.
    pub pose: Pose2,
    /// Seconds from now.
    pub time: f64,
}

impl TimedPose {
    fn is_finite(&self) -> bool {
        [self.pose.x, self.pose.y, self.pose.yaw, self.time]
            .iter()
            .all(|c| c.is_finite())
    }
}

/// Poses in the order of their times; the first one is here and now.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    pub(super) poses: Vec<TimedPose>,
}

impl Trajectory {
    /// A trajectory through poses; `None` unless there are at least two, with rising times and
    /// finite numbers.
    pub fn new(poses: Vec<TimedPose>) -> Option<Self> {
        let finite = poses.iter().all(TimedPose::is_finite);
        let rising = poses.windows(2).all(|w| w[1].time > w[0].time);
        (poses.len() > 1 && rising && finite).then_some(Self { poses })
    }

    /// Its poses and their times.
    pub fn poses(&self) -> &[TimedPose] {
        &self.poses
    }

    /// Seconds until its end.
    pub fn duration(&self) -> f64 {
        self.poses[self.poses.len() - 1].time
    }

    /// The pose after `time` seconds, on the arc between its neighbours; after the end, the end.
    pub fn pose_at(&self, time: f64) -> Pose2 {
        let after = self.poses.partition_point(|k| k.time <= time);
        if after == 0 {
            return self.poses[0].pose;
        }
        let Some(b) = self.poses.get(after) else {
            return self.poses[after - 1].pose;
        };
        let a = self.poses[after - 1];
        let share = (time - a.time) / (b.time - a.time);
        on_arc(a.pose, b.pose, share)
    }

    /// The velocity on stretch `i`, from knot `i` to the next.
    pub fn velocity(&self, i: usize) -> Velocity {
        let (a, b) = (self.poses[i], self.poses[i + 1]);
        velocity(a.pose, b.pose, b.time - a.time)
    }

    /// The constant velocity that leads to where the band is after so many seconds, or to its end.
    pub(crate) fn velocity_until(&self, seconds: f64) -> Velocity {
        let until = seconds.min(self.duration());
        velocity(self.poses[0].pose, self.pose_at(until), until)
    }

    /// The velocity to drive with now, within the robot's limits.
    pub(crate) fn command(&self, limits: &Limits) -> Velocity {
        let v = self.velocity_until(COMMAND_S);
        Velocity::new(
            v.linear.clamp(-limits.backward, limits.forward),
            v.angular.clamp(-limits.turn, limits.turn),
        )
    }

    /// The same band after waiting at its start for `wait` seconds; `None` if that is not positive.
    pub fn delayed(&self, wait: f64) -> Option<Self> {
        let later = self.poses.iter().map(|k| TimedPose {
            time: k.time + wait,
            ..*k
        });
        Self::new(std::iter::once(self.poses[0]).chain(later).collect())
    }

    /// The same poses, no faster than the robot's speeds allow: beyond them a band cannot be kept.
    pub(crate) fn slowed(&self, limits: &Limits) -> Self {
        let mut poses = self.poses.clone();
        for i in 1..poses.len() {
            let (v, seconds) = (
                self.velocity(i - 1),
                self.poses[i].time - self.poses[i - 1].time,
            );
            // A robot may be unable to drive backward: its band is very slow there, not infinitely.
            let backward = if v.linear < 0.0 {
                -v.linear / limits.backward.max(1e-3)
            } else {
                0.0
            };
            let over = (v.linear / limits.forward)
                .max(backward)
                .max(v.angular.abs() / limits.turn);
            poses[i].time = poses[i - 1].time + seconds * over.max(1.0);
        }
        Self { poses }
    }

    /// Moves every knot as `from` moves to `to`, for an estimated pose that has jumped.
    pub(crate) fn carry(&mut self, from: Pose2, to: Pose2) {
        let turn = wrap_angle(to.yaw - from.yaw);
        let (sin, cos) = libm::sincos(turn);
        for knot in &mut self.poses {
            let (dx, dy) = (knot.pose.x - from.x, knot.pose.y - from.y);
            let yaw = knot.pose.yaw + turn;
            knot.pose = Pose2::new(to.x + cos * dx - sin * dy, to.y + sin * dx + cos * dy, yaw);
        }
    }

    /// Whether a pose is so far from the expected one that the estimate has jumped.
    pub(crate) fn is_jump(expected: Pose2, pose: Pose2) -> bool {
        expected.point().distance(pose.point()) > JUMP_M
            || wrap_angle(expected.yaw - pose.yaw).abs() > JUMP_RAD
    }

    /// Drops what has been driven by a robot that is at `pose` `elapsed` seconds later, and carries
    /// the rest along if the estimate has jumped there.
    pub(crate) fn keep_up(&mut self, pose: Pose2, elapsed: f64) {
        // A robot that was held up has not jumped.
        if Self::is_jump(self.pose_at(self.progress(pose, elapsed)), pose) {
            self.carry(self.pose_at(elapsed), pose);
        }
        self.advance(pose, elapsed);
    }

    /// Drops what has been driven by a robot that is at `pose` `elapsed` seconds later. For a robot
    /// that was held up as much is left as before.
    pub(crate) fn advance(&mut self, pose: Pose2, elapsed: f64) {
        let elapsed = self.progress(pose, elapsed);
        let last = self.poses.len() - 1;
        // At least one stretch is left.
        let passed = self
            .poses
            .partition_point(|k| k.time <= elapsed)
            .clamp(1, last);
        self.poses.drain(..passed - 1);
        // Yaws of the band are not wrapped: the pose's is taken in the nearest turn.
        let yaw = self.poses[0].pose.yaw + wrap_angle(pose.yaw - self.poses[0].pose.yaw);
        // At least 10 ms of the first stretch are left, so that times rise.
        let start = elapsed.min(self.poses[1].time - 1e-2);
        self.poses[0] = TimedPose {
            pose: Pose2 { yaw, ..pose },
            time: start,
        };
        self.poses.iter_mut().for_each(|k| k.time -= start);
    }

    /// The time, from 0 to twice `elapsed`, at which the band is nearest to `pose`; of times as
    /// near, the one nearest to `elapsed`.
    fn progress(&self, pose: Pose2, elapsed: f64) -> f64 {
        let shares = (0..=8).map(|i| f64::from(i) / 4.0);
        let nearest = shares.min_by(|a, b| {
            let [a, b] = [a, b].map(|share| self.mismatch(pose, elapsed, *share));
            a.total_cmp(&b)
        });
        nearest.unwrap_or(1.0) * elapsed
    }

    /// How far the pose after a share of `elapsed` is from `pose`, metres. Shares far from 1 count
    /// as a millimetre more, so that a robot that stands does not seem to have been fast or slow.
    fn mismatch(&self, pose: Pose2, elapsed: f64, share: f64) -> f64 {
        let at = self.pose_at(share * elapsed);
        let turn = TURN_WEIGHT_M * wrap_angle(at.yaw - pose.yaw);
        libm::hypot(at.point().distance(pose.point()), turn) + 1e-3 * (share - 1.0).abs()
    }

    /// Moves the end; its yaw goes to the nearest turn of `yaw`.
    pub(crate) fn set_end(&mut self, point: MapPoint, yaw: Option<f64>) {
        let last = self.poses.len() - 1;
        let end = &mut self.poses[last].pose;
        let yaw = end.yaw + yaw.map_or(0.0, |yaw| wrap_angle(yaw - end.yaw));
        *end = Pose2::new(point.x, point.y, yaw);
    }

    pub(crate) fn poses_mut(&mut self) -> &mut [TimedPose] {
        &mut self.poses
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::trajectory::Resolution;
    use proptest::prelude::*;

    pub(in crate::trajectory) fn limits() -> Limits {
        Limits {
            forward: 0.5,
            backward: 0.2,
            turn: 1.0,
            acceleration: 1.0,
            half_track: 0.2,
        }
    }

    pub(in crate::trajectory) fn band() -> Trajectory {
        let corners = [(2.0, 0.0), (2.0, 1.0)].map(|(x, y)| MapPoint::new(x, y));
        Trajectory::along(Pose2::default(), &corners, Some(0.0), &limits(), 1.0).unwrap()
    }

    #[test]
    fn a_jump_of_the_estimate_moves_the_whole_band() {
        let mut band = band();
        let (from, to) = (Pose2::new(0.0, 0.0, 0.0), Pose2::new(1.0, 2.0, 0.5));
        let before = from.inverse_transform(band.pose_at(3.0).point());
        band.carry(from, to);
        let after = to.inverse_transform(band.pose_at(3.0).point());
        assert!((before.0 - after.0).abs() < 1e-9 && (before.1 - after.1).abs() < 1e-9);
    }

    #[test]
    fn a_band_is_shortened_by_what_was_driven_and_not_by_time() {
        for (at, left) in [(1.0, -1.0), (0.0, 0.0), (0.5, -0.5)] {
            let (mut band, whole) = (band(), band().duration());
            band.advance(band.pose_at(at), 1.0);
            assert!((band.duration() - whole - left).abs() < 0.011, "{at}");
        }
    }

    proptest! {
        #[test]
        fn an_advanced_band_starts_here_and_ends_there(
            elapsed in 0.0..20.0_f64,
            yaw in -9.0..9.0_f64,
        ) {
            let mut band = band();
            band.resize(&Resolution::default());
            let (end, duration) = (band.pose_at(99.0), band.duration());
            let on_it = band.pose_at(elapsed);
            let here = Pose2::new(on_it.x, on_it.y + 0.01, yaw);
            band.advance(here, elapsed);
            let (poses, first) = (band.poses(), band.poses()[0]);
            prop_assert!(first.time == 0.0 && first.pose.point() == here.point());
            prop_assert!(wrap_angle(first.pose.yaw - yaw).abs() < 1e-9);
            prop_assert!(poses.len() > 1 && poses.windows(2).all(|w| w[1].time > w[0].time));
            prop_assert!(band.pose_at(99.0) == end);
            prop_assert!(band.duration() <= duration && band.duration() > 0.0);
        }
    }
}
