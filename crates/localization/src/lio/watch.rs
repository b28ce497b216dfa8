//! Whether the way that the filter comes to is one that the robot can have gone.
//!
//! Wheels and gyroscope reckon a way of their own, beside the filter: they slip and drift, but
//! never by much in a few seconds. A filter that scans or a shaken accelerometer mislead runs away
//! by metres in that time. What it comes to is therefore laid on what is reckoned, over the last
//! seconds. Where both disagree and the scans do not support the filter, it begins anew from the
//! last state that agreed, moved on by what was reckoned since; where the scans do support it, the
//! sensors contradict each other, and nobody can say who is right.

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use openbench_core::{Pose3, SimTime};

use super::inertial::Known;

/// The way is looked at over so long a time.
const WINDOW: Duration = Duration::from_secs(2);
/// The filter and what is reckoned may be apart by so many metres, by that part of the way and so
/// many metres a radian: wheels slip.
const APART: [f64; 3] = [0.10, 0.15, 0.10];
/// The same for turns: radians, and that part of what was turned.
const TURNED: [f64; 2] = [0.04, 0.10];
/// Of the scans of a window that share supports the filter at least, if it is to be believed.
const SUPPORTED: f64 = 0.7;
/// Nothing is faster than so many times what the robot's wheels show and a little, m/s.
const FASTEST: [f64; 2] = [2.0, 0.5];
/// Straight on wheels slide neither sideways nor along by more than these parts of the way, over so
/// many metres.
const SIDEWAYS: f64 = 0.03;
const ALONG: f64 = 0.08;
const SLID_OVER: f64 = 6.0;
/// A filter that has turned by so many radians more than the gyroscope, over about so many seconds,
/// is turned by its scans.
const TURNING: f64 = 0.06;
const TURNING_OVER: f64 = 20.0;
/// Slower turns count as straight on, rad/s.
const STRAIGHT: f64 = 0.15;

/// The way between two scans by wheels and gyroscope, step by step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reckoned {
    /// Pose of the robot's frame at the end in that at the beginning.
    pub(super) step: Pose3,
    /// Length, metres.
    pub(super) metres: f64,
    /// How far it turned, radians.
    pub(super) turned: f64,
    /// Speed at the end, m/s in the robot's frame.
    pub(super) velocity: Vector3<f64>,
}

/// What the filter's way looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    /// As the robot can have gone it.
    Sound,
    /// Otherwise than wheels and gyroscope say, but as scans do.
    Contradicted,
    /// As nothing says but the filter itself.
    RunAway,
}

/// A scan's place on the way.
#[derive(Debug, Clone, Copy)]
struct Mark {
    stamp: SimTime,
    /// Of the robot's frame in `odom`, as the filter has it.
    filtered: Pose3,
    /// The same by wheels and gyroscope alone, from anywhere.
    reckoned: Pose3,
    /// Metres and radians so far.
    metres: f64,
    turned: f64,
    supported: bool,
}

/// The last state that agreed with everything.
#[derive(Debug, Clone)]
struct Anchor {
    known: Known,
    mark: Mark,
}

/// Watches the way.
#[derive(Debug, Clone, Default)]
pub(super) struct Watch {
    marks: VecDeque<Mark>,
    anchor: Option<Anchor>,
    /// Metres straight on, and how many more sideways and along the filter has than the wheels,
    /// older ones counting less.
    slid: [f64; 3],
    /// Radians that the filter has turned more than the gyroscope, the older ones counting less.
    turning: f64,
}

impl Watch {
    /// Takes in the state after a scan and the step that led to it; `supported` if the scan lies on
    /// the map. `imu` is the IMU's place on the robot.
    pub(super) fn look(
        &mut self,
        known: &Known,
        step: &Reckoned,
        supported: bool,
        imu: &Pose3,
    ) -> Verdict {
        let filtered = super::pose(&known.state) * imu.inverse();
        let last = self.marks.back().copied();
        let (reckoned, metres, turned) = last.map_or((filtered, 0.0, 0.0), |last| {
            (
                last.reckoned * step.step,
                last.metres + step.metres,
                last.turned + step.turned,
            )
        });
        let mark = Mark {
            stamp: known.stamp,
            filtered,
            reckoned,
            metres,
            turned,
            supported,
        };
        if let Some(last) = last {
            self.note_slow_drift(&last, &mark, step, known);
        }
        self.marks.push_back(mark);
        while self.marks.len() > 2 && known.stamp.since(self.marks[1].stamp) >= WINDOW {
            self.marks.pop_front();
        }
        let agrees = agree(&self.marks[0], &mark);
        let fastest = FASTEST[0] * step.velocity.norm() + FASTEST[1];
        let too_fast = known.state.velocity.norm() > fastest;
        let share = self.marks.iter().filter(|mark| mark.supported).count() as f64
            / self.marks.len() as f64;
        if agrees && !too_fast {
            if supported && share >= SUPPORTED {
                self.anchor = Some(Anchor {
                    known: known.clone(),
                    mark,
                });
            }
            let [metres, sideways, along] = self.slid;
            let slides = metres > SLID_OVER / 2.0
                && (sideways.abs() > SIDEWAYS * metres || along.abs() > ALONG * metres);
            let slides = slides || self.turning.abs() > TURNING;
            return if slides {
                Verdict::Contradicted
            } else {
                Verdict::Sound
            };
        }
        if share >= SUPPORTED && !too_fast {
            Verdict::Contradicted
        } else {
            Verdict::RunAway
        }
    }

    /// The last state that agreed, moved on by what was reckoned since then; how far that was,
    /// metres and radians.
    pub(super) fn recover(&self, imu: &Pose3) -> Option<(Known, f64, f64)> {
        let (anchor, now) = (self.anchor.as_ref()?, self.marks.back()?);
        let moved = anchor.mark.reckoned.inverse() * now.reckoned;
        let there = anchor.mark.filtered * moved * imu;
        let mut known = anchor.known.clone();
        known.stamp = now.stamp;
        (known.state.position, known.state.rotation) = (there.translation.vector, there.rotation);
        Some((
            known,
            now.metres - anchor.mark.metres,
            now.turned - anchor.mark.turned,
        ))
    }

    /// Begins anew with nothing to go back to.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Begins anew from a state that is taken for sound.
    pub(super) fn restart(&mut self, known: &Known, imu: &Pose3) {
        let filtered = super::pose(&known.state) * imu.inverse();
        let (stamp, reckoned) = (known.stamp, filtered);
        let mark = Mark {
            stamp,
            filtered,
            reckoned,
            metres: 0.0,
            turned: 0.0,
            supported: true,
        };
        let anchor = Some(Anchor {
            known: known.clone(),
            mark,
        });
        *self = Self {
            marks: VecDeque::from([mark]),
            anchor,
            slid: [0.0; 3],
            turning: 0.0,
        };
    }

    fn note_slow_drift(&mut self, last: &Mark, mark: &Mark, step: &Reckoned, known: &Known) {
        let seconds = known.stamp.since(last.stamp).as_secs_f64();
        let yaw = |pose: &Pose3| pose.rotation.euler_angles().2;
        let more = yaw(&(last.filtered.inverse() * mark.filtered)) - yaw(&step.step);
        self.turning = self.turning * (1.0 - seconds / TURNING_OVER).max(0.0) + more;
        if step.turned > STRAIGHT * seconds {
            return;
        }
        let filtered = (last.filtered.inverse() * mark.filtered).translation.vector;
        let more = filtered - step.step.translation.vector;
        let kept = 1.0 - (step.metres / SLID_OVER).min(1.0);
        let [metres, sideways, along] = self.slid;
        self.slid = [
            kept * metres + step.metres,
            kept * sideways + more.y,
            kept * along + more.x,
        ];
    }
}

/// Whether filter and wheels have come about as far from one mark to another.
fn agree(from: &Mark, to: &Mark) -> bool {
    let (metres, turned) = (to.metres - from.metres, to.turned - from.turned);
    let filtered = from.filtered.inverse() * to.filtered;
    let reckoned = from.reckoned.inverse() * to.reckoned;
    let apart = (filtered.translation.vector - reckoned.translation.vector).norm();
    let off = filtered.rotation.angle_to(&reckoned.rotation);
    apart <= APART[0] + APART[1] * metres + APART[2] * turned
        && off <= TURNED[0] + TURNED[1] * turned
}

impl Reckoned {
    /// No way yet.
    pub(super) fn nothing() -> Self {
        Self {
            step: Isometry3::identity(),
            metres: 0.0,
            turned: 0.0,
            velocity: Vector3::zeros(),
        }
    }

    /// Goes on for some seconds with a velocity, m/s, and a turn rate, rad/s, of the robot's frame
    /// in itself.
    pub(super) fn go_on(&mut self, velocity: Vector3<f64>, rate: Vector3<f64>, seconds: f64) {
        let turn = UnitQuaternion::from_scaled_axis(rate * seconds);
        // Along the chord of the arc.
        let half = UnitQuaternion::from_scaled_axis(rate * (0.5 * seconds));
        self.step *= Isometry3::from_parts((half * velocity * seconds).into(), turn);
        self.metres += velocity.norm() * seconds;
        self.turned += rate.norm() * seconds;
        self.velocity = velocity;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lio::state::{Covariance, State};
    use nalgebra::Vector2;

    fn known(millis: u64, x: f64, y: f64, speed: f64) -> Known {
        let state = State {
            rotation: UnitQuaternion::identity(),
            position: Vector3::new(x, y, 0.0),
            velocity: Vector3::x() * speed,
            gyro_bias: Vector3::zeros(),
            accel_bias: Vector3::zeros(),
            gravity: Vector3::z() * -9.8,
            mount_rotation: UnitQuaternion::identity(),
            mount_position: Vector3::zeros(),
            map_tilt: Vector2::zeros(),
        };
        Known {
            stamp: SimTime::from_millis(millis),
            state,
            covariance: Covariance::identity() * 1e-6,
        }
    }

    /// Half a metre a second straight on, as wheels have it.
    fn step() -> Reckoned {
        let mut way = Reckoned::nothing();
        way.go_on(Vector3::x() * 0.5, Vector3::zeros(), 0.1);
        way
    }

    /// The verdicts on ten seconds in which the filter goes as told: its place after so many
    /// seconds, and its speed.
    fn verdicts(way: impl Fn(f64) -> (f64, f64, f64), supported: bool) -> (Watch, Vec<Verdict>) {
        let mut watch = Watch::default();
        let look = |i: u64| {
            let (x, y, speed) = way(i as f64 * 0.1);
            // The first second is sound, so that there is something to come back to.
            let supported = supported || i < 10;
            watch.look(
                &known(100 * i, x, y, speed),
                &step(),
                supported,
                &Pose3::identity(),
            )
        };
        let verdicts = (0..100).map(look).collect();
        (watch, verdicts)
    }

    #[test]
    fn a_way_that_wheels_confirm_is_sound() {
        let (_, verdicts) = verdicts(|t| (0.51 * t, 0.0, 0.5), false);
        assert!(
            verdicts.iter().all(|verdict| *verdict == Verdict::Sound),
            "{verdicts:?}"
        );
    }

    #[test]
    fn a_way_that_nothing_confirms_has_run_away_and_is_gone_back_on() {
        let runs = |t: f64| {
            (
                if t < 3.0 {
                    0.5 * t
                } else {
                    1.5 + 2.0 * (t - 3.0)
                },
                0.0,
                0.5,
            )
        };
        let (watch, told) = verdicts(runs, false);
        let first = told
            .iter()
            .position(|verdict| *verdict == Verdict::RunAway)
            .unwrap();
        assert!(
            (30..45).contains(&first),
            "noticed within one and a half seconds: {first}"
        );
        let (back, metres, _) = watch.recover(&Pose3::identity()).unwrap();
        assert!(
            (back.state.position.x - 0.5 * 9.9).abs() < 0.1,
            "{}",
            back.state.position
        );
        assert!(
            (4.4..4.6).contains(&metres),
            "since the sound second: {metres}"
        );
        // Scans that confirm it contradict the wheels; nobody knows who is right.
        let slow = |t: f64| {
            (
                if t < 3.0 {
                    0.5 * t
                } else {
                    1.5 + 0.8 * (t - 3.0)
                },
                0.0,
                0.5,
            )
        };
        let (_, told) = verdicts(slow, true);
        assert!(told.contains(&Verdict::Contradicted) && !told.contains(&Verdict::RunAway));
        // Nothing is ten times as fast as its wheels.
        let (_, told) = verdicts(|t| (0.5 * t, 0.0, 5.0), true);
        assert_eq!(told[0], Verdict::RunAway);
    }

    #[test]
    fn who_slides_sideways_all_the_time_has_a_sensor_that_is_turned() {
        let (_, told) = verdicts(|t| (0.5 * t, 0.5 * t * 0.06, 0.5), true);
        assert_eq!(told[10], Verdict::Sound, "too soon to say");
        assert_eq!(told[99], Verdict::Contradicted);
    }
}
