//! Whether the filter's trajectory is one that the robot can have driven.
//!
//! Wheels and gyroscope give a trajectory of their own, beside the filter. They slip and drift, but
//! never by much in a few seconds. A filter that scans or a shaken accelerometer mislead diverges
//! by metres in that time. Its trajectory over the last seconds is therefore compared with the
//! reckoned one. Where both disagree and the scans do not support the filter, it is restarted from
//! the last state that agreed, moved on by the reckoned motion since. Where the scans do support
//! it, the sensors contradict each other, and which one is right is unknown.

use std::collections::VecDeque;
use std::time::Duration;

use openbench_core::{Pose3, SimTime};

use super::belief::Belief;
use super::reckoning::Reckoned;

/// Trajectories are compared over this time.
const WINDOW: Duration = Duration::from_secs(2);
/// Both may be apart by this distance, metres,
const APART_M: f64 = 0.10;
/// and this share of the distance driven,
const APART_PER_METRE: f64 = 0.15;
/// and this many metres a radian turned: wheels slip.
const APART_PER_RADIAN: f64 = 0.10;
/// They may differ by this rotation, radians,
const TURNED_RAD: f64 = 0.04;
/// and this share of the angle turned.
const TURNED_PER_RADIAN: f64 = 0.10;
/// A filter is supported if at least this share of the scans of a window supports it.
const MIN_SUPPORT: f64 = 0.7;
/// Nothing is faster than this many times what the robot's wheels show
const MAX_SPEED_RATIO: f64 = 2.0;
/// and a little, m/s.
const MAX_SPEED_EXCESS_M_S: f64 = 0.5;

/// Straight on, wheels do not slide sideways by more than this share of the distance,
const MAX_SIDEWAYS: f64 = 0.03;
/// nor along by more than this share,
const MAX_ALONG: f64 = 0.08;
/// over about this distance, metres.
const SLIP_WINDOW_M: f64 = 6.0;
/// Slower turns count as straight on, rad/s.
const STRAIGHT_RAD_S: f64 = 0.15;
/// A filter that has turned by this much more than the gyroscope is turned by its scans, radians,
const MAX_EXTRA_TURN_RAD: f64 = 0.06;
/// over about this time, seconds.
const EXTRA_TURN_WINDOW_S: f64 = 20.0;

/// What the filter's trajectory looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    /// As the robot can have driven.
    Sound,
    /// As scans say, but not wheels and gyroscope.
    Contradicted,
    /// As nothing says but the filter itself.
    Diverged,
}

/// A state to restart from.
#[derive(Debug, Clone)]
pub(super) struct Restart {
    pub(super) belief: Belief,
    /// Distance reckoned since the last state that agreed, metres.
    pub(super) metres: f64,
    /// Angle turned since then, radians.
    pub(super) radians: f64,
}

/// Both trajectories after a scan.
#[derive(Debug, Clone, Copy)]
struct Mark {
    stamp: SimTime,
    /// Pose of the robot's frame in `odom`, as the filter has it.
    filtered: Pose3,
    /// The same by wheels and gyroscope alone, from an arbitrary start.
    reckoned: Pose3,
    /// Distance reckoned so far, metres.
    metres: f64,
    /// Angle turned so far, radians.
    radians: f64,
    /// Whether the scan lies on the map.
    is_supported: bool,
}

/// The last state that agreed with everything.
#[derive(Debug, Clone)]
struct Anchor {
    belief: Belief,
    mark: Mark,
}

/// How far the filter has slid against the wheels, metres. Older slips count less.
#[derive(Debug, Clone, Copy, Default)]
struct Slip {
    /// Distance driven straight on.
    driven: f64,
    sideways: f64,
    along: f64,
}

/// Compares the filter with wheels and gyroscope.
#[derive(Debug, Clone, Default)]
pub(super) struct Watchdog {
    marks: VecDeque<Mark>,
    anchor: Option<Anchor>,
    slip: Slip,
    /// Angle that the filter has turned more than the gyroscope, radians. Older turns count less.
    extra_turn: f64,
}

impl Watchdog {
    /// Judges the belief after a scan. `step` is the reckoned motion that led to it, `is_supported`
    /// whether the scan lies on the map, `imu` the IMU's pose on the robot.
    pub(super) fn judge(
        &mut self,
        belief: &Belief,
        step: &Reckoned,
        is_supported: bool,
        imu: &Pose3,
    ) -> Verdict {
        let mark = self.push(belief, step, is_supported, imu);
        // The oldest mark of the window: errors of a single step are too small to tell.
        let agrees = agree(&self.marks[0], &mark);
        let max_speed = MAX_SPEED_RATIO * step.velocity.norm() + MAX_SPEED_EXCESS_M_S;
        let is_too_fast = belief.state.velocity.norm() > max_speed;
        let support = self.support();
        if !agrees || is_too_fast {
            // No robot is that fast, however well the scans lie on the map.
            let scans_agree = support >= MIN_SUPPORT && !is_too_fast;
            return if scans_agree {
                Verdict::Contradicted
            } else {
                Verdict::Diverged
            };
        }
        if is_supported && support >= MIN_SUPPORT {
            self.anchor = Some(Anchor {
                belief: belief.clone(),
                mark,
            });
        }
        if self.slip.is_excessive() || self.extra_turn.abs() > MAX_EXTRA_TURN_RAD {
            Verdict::Contradicted
        } else {
            Verdict::Sound
        }
    }

    /// Notes both trajectories after a scan, and drops what is older than the window.
    fn push(&mut self, belief: &Belief, step: &Reckoned, is_supported: bool, imu: &Pose3) -> Mark {
        let mut mark = Mark::at(belief, imu);
        mark.is_supported = is_supported;
        if let Some(last) = self.marks.back().copied() {
            mark.reckoned = last.reckoned * step.motion;
            mark.metres = last.metres + step.metres;
            mark.radians = last.radians + step.radians;
            self.note_slow_drift(&last, &mark, step);
        }
        self.marks.push_back(mark);
        // The second mark decides: the oldest one stays until another is a whole window old.
        while self.marks.len() > 2 && belief.stamp.since(self.marks[1].stamp) >= WINDOW {
            self.marks.pop_front();
        }
        mark
    }

    /// Share of the window's scans that lie on the map.
    fn support(&self) -> f64 {
        let supported = self.marks.iter().filter(|mark| mark.is_supported).count();
        supported as f64 / self.marks.len() as f64
    }

    /// Notes what is too slow to show within the window.
    fn note_slow_drift(&mut self, last: &Mark, mark: &Mark, step: &Reckoned) {
        let seconds = mark.stamp.since(last.stamp).as_secs_f64();
        let filtered = last.filtered.inverse() * mark.filtered;
        let extra = yaw(&filtered) - yaw(&step.motion);
        // Leaky sums: what lies a window back has faded to about a third.
        let kept = (1.0 - seconds / EXTRA_TURN_WINDOW_S).max(0.0);
        self.extra_turn = self.extra_turn * kept + extra;
        // In turns wheels slide sideways anyway.
        if step.radians <= STRAIGHT_RAD_S * seconds {
            self.slip.note(&filtered, step);
        }
    }

    /// The last state that agreed, moved on by the reckoned motion since then; `None` if there is
    /// none. `imu` is the IMU's pose on the robot.
    pub(super) fn recover(&self, imu: &Pose3) -> Option<Restart> {
        let anchor = self.anchor.as_ref()?;
        let now = self.marks.back()?;
        let moved = anchor.mark.reckoned.inverse() * now.reckoned;
        let pose = anchor.mark.filtered * moved * imu;
        let mut belief = anchor.belief.clone();
        belief.stamp = now.stamp;
        belief.state.position = pose.translation.vector;
        belief.state.rotation = pose.rotation;
        let metres = now.metres - anchor.mark.metres;
        let radians = now.radians - anchor.mark.radians;
        Some(Restart {
            belief,
            metres,
            radians,
        })
    }

    /// Begins anew without a state to restart from.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Begins anew from a belief that is taken for sound.
    pub(super) fn restart(&mut self, belief: &Belief, imu: &Pose3) {
        let mark = Mark::at(belief, imu);
        let anchor = Some(Anchor {
            belief: belief.clone(),
            mark,
        });
        *self = Self {
            marks: VecDeque::from([mark]),
            anchor,
            ..Self::default()
        };
    }
}

impl Mark {
    /// The first mark: both trajectories are at the belief, which is supported.
    fn at(belief: &Belief, imu: &Pose3) -> Self {
        let pose = belief.state.imu_pose() * imu.inverse();
        Self {
            stamp: belief.stamp,
            filtered: pose,
            reckoned: pose,
            metres: 0.0,
            radians: 0.0,
            is_supported: true,
        }
    }
}

impl Slip {
    /// Notes a step straight on, and what it was by the filter.
    fn note(&mut self, filtered: &Pose3, step: &Reckoned) {
        let slipped = filtered.translation.vector - step.motion.translation.vector;
        let kept = 1.0 - (step.metres / SLIP_WINDOW_M).min(1.0);
        self.driven = kept * self.driven + step.metres;
        self.sideways = kept * self.sideways + slipped.y;
        self.along = kept * self.along + slipped.x;
    }

    /// Whether wheels cannot have slid so far.
    fn is_excessive(&self) -> bool {
        self.driven > SLIP_WINDOW_M / 2.0
            && (self.sideways.abs() > MAX_SIDEWAYS * self.driven
                || self.along.abs() > MAX_ALONG * self.driven)
    }
}

/// Whether both trajectories agree about the motion from one mark to another.
fn agree(from: &Mark, to: &Mark) -> bool {
    let metres = to.metres - from.metres;
    let radians = to.radians - from.radians;
    let filtered = from.filtered.inverse() * to.filtered;
    let reckoned = from.reckoned.inverse() * to.reckoned;
    let apart = (filtered.translation.vector - reckoned.translation.vector).norm();
    let turned = filtered.rotation.angle_to(&reckoned.rotation);
    apart <= APART_M + APART_PER_METRE * metres + APART_PER_RADIAN * radians
        && turned <= TURNED_RAD + TURNED_PER_RADIAN * radians
}

fn yaw(pose: &Pose3) -> f64 {
    pose.rotation.euler_angles().2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lio::state::{Covariance, State};
    use nalgebra::Vector3;

    /// Where the filter is, in the plane, and how fast it thinks it goes.
    struct Filtered {
        x: f64,
        y: f64,
        speed: f64,
    }

    fn belief(millis: u64, filtered: &Filtered) -> Belief {
        let pose = Pose3::translation(filtered.x, filtered.y, 0.0);
        let velocity = Vector3::x() * filtered.speed;
        let state = State {
            velocity,
            ..State::at_rest(&pose, 9.8)
        };
        let covariance = Covariance::identity() * 1e-6;
        Belief {
            stamp: SimTime::from_millis(millis),
            state,
            covariance,
        }
    }

    /// Half a metre a second straight on, by wheels.
    fn step() -> Reckoned {
        let mut step = Reckoned::default();
        step.advance(Vector3::x() * 0.5, Vector3::zeros(), 0.1);
        step
    }

    /// Verdicts on ten seconds of a filter that is somewhere after so many seconds. The first
    /// second is supported, so that there is a state to restart from.
    fn judge(filter: impl Fn(f64) -> Filtered, is_supported: bool) -> (Watchdog, Vec<Verdict>) {
        let mut watchdog = Watchdog::default();
        let mut verdicts = Vec::new();
        for i in 0..100 {
            let belief = belief(100 * i, &filter(i as f64 * 0.1));
            let is_supported = is_supported || i < 10;
            let imu = Pose3::identity();
            verdicts.push(watchdog.judge(&belief, &step(), is_supported, &imu));
        }
        (watchdog, verdicts)
    }

    /// Straight on at half a metre a second, from the third second on at another speed.
    fn changing(t: f64, speed: f64) -> Filtered {
        let x = if t < 3.0 {
            0.5 * t
        } else {
            1.5 + speed * (t - 3.0)
        };
        Filtered {
            x,
            y: 0.0,
            speed: 0.5,
        }
    }

    #[test]
    fn a_trajectory_that_wheels_confirm_is_sound() {
        let confirmed = |t| Filtered {
            x: 0.51 * t,
            y: 0.0,
            speed: 0.5,
        };
        let (_, verdicts) = judge(confirmed, false);
        assert!(
            verdicts.iter().all(|verdict| *verdict == Verdict::Sound),
            "{verdicts:?}"
        );
    }

    #[test]
    fn a_trajectory_that_nothing_confirms_has_diverged_and_is_recovered() {
        let (watchdog, verdicts) = judge(|t| changing(t, 2.0), false);
        let first = verdicts
            .iter()
            .position(|verdict| *verdict == Verdict::Diverged)
            .unwrap();
        assert!(
            (30..45).contains(&first),
            "noticed within one and a half seconds: {first}"
        );
        let restart = watchdog.recover(&Pose3::identity()).unwrap();
        let position = restart.belief.state.position;
        assert!((position.x - 0.5 * 9.9).abs() < 0.1, "{position}");
        let metres = restart.metres;
        assert!(
            (4.4..4.6).contains(&metres),
            "since the sound second: {metres}"
        );
    }

    #[test]
    fn a_trajectory_that_scans_confirm_contradicts_the_wheels() {
        let (_, verdicts) = judge(|t| changing(t, 0.8), true);
        assert!(verdicts.contains(&Verdict::Contradicted));
        assert!(!verdicts.contains(&Verdict::Diverged));
    }

    #[test]
    fn nothing_is_ten_times_as_fast_as_its_wheels() {
        let (_, verdicts) = judge(
            |t| Filtered {
                x: 0.5 * t,
                y: 0.0,
                speed: 5.0,
            },
            true,
        );
        assert_eq!(verdicts[0], Verdict::Diverged);
    }

    #[test]
    fn a_robot_that_always_slides_sideways_has_a_rotated_sensor() {
        let sliding = |t| Filtered {
            x: 0.5 * t,
            y: 0.5 * t * 0.06,
            speed: 0.5,
        };
        let (_, verdicts) = judge(sliding, true);
        assert_eq!(verdicts[10], Verdict::Sound, "too soon to say");
        assert_eq!(verdicts[99], Verdict::Contradicted);
    }
}
