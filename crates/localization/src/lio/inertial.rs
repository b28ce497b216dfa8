//! What IMU and wheels said, and the way that follows from it.

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::Vector3;
use openbench_core::{ImuSample, Pose3, SimTime};

use super::Settings;
use super::limits::{AtLimit, Limits};
use super::propagation::{ImuNoise, Node, advance, propagate};
use super::speed::{Speed, correct, temper};
use super::state::{Covariance, State};
use super::watch::Reckoned;

/// Samples farther apart than that leave a gap.
const GAP: Duration = Duration::from_millis(50);
/// No step of the way is longer, so that turns in it are small: seconds.
const STEP: Duration = Duration::from_millis(20);
/// Densities of what happens unseen, in a gap or beyond the IMU's limits: rad/s/√Hz and m/s²/√Hz.
const UNSEEN: [f64; 2] = [0.3, 1.0];
/// Part of a turn that a gyroscope's scale may be off by, √s: over the tenth of a second of a scan three times this number, over longer turns less, is the part.
const MISSCALED: f64 = 1e-3;
/// No IMU shows more, rad/s and m/s².
const MOST: [f64; 2] = [1e3, 1e5];
/// Velocities farther than that from an instant say nothing about it, and so many of them wait at most.
const NEAR: Duration = Duration::from_millis(20);
const SPEEDS: usize = 1000;
/// What wheels say holds for so long.
const HOLDS: Duration = Duration::from_millis(300);
/// Wheels, which are told a twentieth of a second late, and gyroscope are no further apart, whatever the motors do, and no robot
/// on wheels tumbles faster, rad/s; and the same while the wheels go on evenly.
const SHAKEN: [f64; 2] = [2.0, 0.6];
/// No robot on wheels speeds up or brakes harder, kerbs included, m/s².
const HIT: f64 = 4.0;
/// A hit lasts about so long, seconds.
const HIT_LASTS: f64 = 0.03;
/// Wheels that change by less than that go on evenly, m/s and rad/s.
const EVENLY: [f64; 2] = [0.1, 0.3];
/// The wheels' velocity is a mean over some time, and comes after it.
const TOLD_LATE: Duration = Duration::from_millis(100);

/// A state at an instant.
#[derive(Debug, Clone)]
pub(super) struct Known {
    pub(super) stamp: SimTime,
    pub(super) state: State,
    pub(super) covariance: Covariance,
}

impl Known {
    /// Holds velocities back along directions of which nothing was said for so long.
    pub(super) fn temper(&mut self, unseen: &[Vector3<f64>], settings: &Settings, since: Duration) {
        for direction in unseen {
            let (typical, seconds) = (settings.typical_speed, since.as_secs_f64());
            temper(
                &mut self.state,
                &mut self.covariance,
                direction,
                typical,
                seconds,
            );
        }
    }
}

/// How it went on from there.
#[derive(Debug, Default)]
pub(super) struct Way {
    pub(super) nodes: Vec<Node>,
    /// For how long the gyroscope was at its limit, and about which axes.
    pub(super) blind: Duration,
    pub(super) axes: [bool; 3],
}

/// Samples that are not used up yet.
#[derive(Debug, Clone, Default)]
pub(super) struct Inertial {
    samples: VecDeque<(ImuSample, AtLimit)>,
    speeds: VecDeque<Speed>,
    limits: Limits,
}

impl Inertial {
    pub(super) fn new(limits: Limits) -> Self {
        Self {
            limits,
            ..Self::default()
        }
    }

    /// When the newest sample of the IMU was taken.
    pub(super) fn newest(&self) -> Option<SimTime> {
        self.samples.back().map(|(sample, _)| sample.stamp)
    }

    /// Takes in a sample, if it can be used.
    pub(super) fn push(&mut self, sample: ImuSample) -> bool {
        let within = |values: [f64; 3], most: f64| values.iter().all(|x| x.abs() <= most);
        let sound = within(sample.gyro, MOST[0]) && within(sample.accel, MOST[1]);
        if !sound || self.newest().is_some_and(|newest| sample.stamp <= newest) {
            return false;
        }
        let (at, late) = self.limits.look(&sample);
        for (_, before) in self.samples.iter_mut().rev().take(late) {
            *before = at;
        }
        self.samples.push_back((sample, at));
        true
    }

    /// Takes in a velocity, if it can be used.
    pub(super) fn push_speed(&mut self, speed: Speed) -> bool {
        let late = self
            .speeds
            .back()
            .is_some_and(|last| speed.stamp <= last.stamp);
        let usable = speed.is_sound() && !late && self.speeds.len() < SPEEDS;
        if usable {
            self.speeds.push_back(speed);
        }
        usable
    }

    /// Moves on to `until`; `missing` is the turn rate that the gyroscope does not show at its limit.
    pub(super) fn travel(
        &self,
        known: &mut Known,
        until: SimTime,
        settings: &Settings,
        missing: Vector3<f64>,
    ) -> Way {
        let (mut way, mut at, mut hit) = (Way::default(), 0, None);
        let from = known.stamp;
        let mut speeds = self
            .speeds
            .iter()
            .skip_while(|speed| speed.stamp <= from)
            .peekable();
        while known.stamp < until && !self.samples.is_empty() {
            // The samples round this instant; before the first and behind the last one they hold on.
            while at + 2 < self.samples.len() && self.samples[at + 1].0.stamp <= known.stamp {
                at += 1;
            }
            let [before, behind] = [
                &self.samples[at],
                &self.samples[(at + 1).min(self.samples.len() - 1)],
            ];
            let ahead = behind.0.stamp > known.stamp;
            let next = if ahead {
                behind.0.stamp.min(until)
            } else {
                until
            };
            let next = speeds
                .peek()
                .map_or(next, |speed| next.min(speed.stamp))
                .min(known.stamp + STEP);
            let (mut gyro, mut accel) = (
                mean(before.0.gyro, behind.0.gyro),
                mean(before.0.accel, behind.0.accel),
            );
            let mut noise = settings.imu_noise;
            if behind.0.stamp.since(before.0.stamp) > GAP {
                [noise.gyro, noise.accel] = UNSEEN;
            }
            if let Some(said) = self.said_at(known.stamp) {
                self.steady(
                    &known.state,
                    settings,
                    said,
                    &mut gyro,
                    &mut accel,
                    &mut noise,
                );
                // Wheels that were stopped by a hit say so a little later.
                if noise.accel > UNSEEN[1] {
                    hit = Some((known.stamp, noise.accel));
                } else if let Some((_, unseen)) =
                    hit.filter(|(at, _)| known.stamp.since(*at) < TOLD_LATE)
                {
                    noise.accel = unseen;
                }
            }
            noise.gyro = libm::hypot(noise.gyro, MISSCALED * gyro.norm());
            let limit = behind.1;
            if limit.gyro.contains(&true) {
                noise.gyro = UNSEEN[0];
                way.blind += next.since(known.stamp);
                for axis in (0..3).filter(|axis| limit.gyro[*axis]) {
                    way.axes[axis] = true;
                    gyro[axis] += missing[axis];
                }
            }
            if limit.accel.contains(&true) {
                noise.accel = UNSEEN[1];
            }
            let Known {
                stamp,
                state,
                covariance,
            } = known;
            way.nodes.push(propagate(
                state, covariance, &noise, *stamp, next, gyro, accel,
            ));
            *stamp = next;
            while let Some(speed) = speeds.next_if(|speed| speed.stamp <= next) {
                if next.since(speed.stamp) < NEAR {
                    correct(state, covariance, &settings.imu, gyro, speed);
                }
            }
        }
        way
    }

    /// What wheels said last before an instant, if not long ago.
    fn said_at(&self, stamp: SimTime) -> Option<&Speed> {
        let before = self.speeds.partition_point(|speed| speed.stamp <= stamp);
        let said = self.speeds.get(before.saturating_sub(1))?;
        (stamp.since(said.stamp) <= HOLDS && said.stamp.since(stamp) <= HOLDS).then_some(said)
    }

    /// Whether the wheels said after this that nothing had changed: then a hit moved nothing.
    fn go_on_evenly(&self, said: &Speed) -> bool {
        let after = self
            .speeds
            .partition_point(|speed| speed.stamp <= said.stamp);
        self.speeds.get(after).is_some_and(|next| {
            (next.velocity - said.velocity).norm() < EVENLY[0]
                && (next.turn - said.turn).abs() < EVENLY[1]
        })
    }

    /// What a robot on wheels cannot have done, an IMU shows because it was hit: nothing is known of that instant but what
    /// the wheels say.
    fn steady(
        &self,
        state: &State,
        settings: &Settings,
        said: &Speed,
        gyro: &mut Vector3<f64>,
        accel: &mut Vector3<f64>,
        noise: &mut ImuNoise,
    ) {
        let rate = settings.imu.rotation * (*gyro - state.gyro_bias);
        let evenly = self.go_on_evenly(said);
        if is_shaken(&rate, said, evenly) {
            let turn = settings.imu.rotation.inverse() * (Vector3::z() * said.turn);
            (*gyro, noise.gyro) = (turn + state.gyro_bias, UNSEEN[0]);
        }
        let beyond = (accel.norm() - state.gravity.norm()).abs();
        if beyond > HIT {
            if evenly {
                let rest = -(state.rotation.inverse() * state.gravity);
                (*accel, noise.accel) = (rest + state.accel_bias, UNSEEN[1]);
            } else {
                // The velocity may have changed by as much as that, or not at all.
                noise.accel = UNSEEN[1].max(beyond * HIT_LASTS.sqrt());
            }
        }
    }

    /// The way from one instant to another by wheels and gyroscope; `None` where wheels said nothing.
    pub(super) fn reckon(
        &self,
        from: SimTime,
        until: SimTime,
        bias: Vector3<f64>,
        imu: &Pose3,
    ) -> Option<Reckoned> {
        let mut way = Reckoned::nothing();
        let mut speeds = self.speeds.iter().peekable();
        let mut speed = *speeds.peek().filter(|first| first.stamp < from + HOLDS)?;
        for ((before, _), (behind, _)) in self.samples.iter().zip(self.samples.iter().skip(1)) {
            let (start, end) = (before.stamp.max(from), behind.stamp.min(until));
            if end <= start {
                continue;
            }
            while let Some(next) = speeds.next_if(|next| next.stamp <= end) {
                speed = next;
            }
            if start.since(speed.stamp) > HOLDS {
                return None;
            }
            let mut rate = imu.rotation * (mean(before.gyro, behind.gyro) - bias);
            if is_shaken(&rate, speed, self.go_on_evenly(speed)) {
                rate = Vector3::z() * speed.turn;
            }
            way.go_on(speed.velocity, rate, end.since(start).as_secs_f64());
        }
        Some(way)
    }

    /// Where a state has come to with the newest sample.
    pub(super) fn extrapolate(&self, known: &Known) -> (SimTime, State) {
        let (mut stamp, mut state) = (known.stamp, known.state.clone());
        for ((before, _), (behind, _)) in self.samples.iter().zip(self.samples.iter().skip(1)) {
            if behind.stamp > stamp {
                let (gyro, accel) = (
                    mean(before.gyro, behind.gyro),
                    mean(before.accel, behind.accel),
                );
                advance(&mut state, stamp, behind.stamp, gyro, accel);
                stamp = behind.stamp;
            }
        }
        (stamp, state)
    }

    /// Drops what is used up; how many gaps there were in it.
    pub(super) fn forget(&mut self, until: SimTime) -> usize {
        let mut gaps = 0;
        while self.samples.len() > 2 && self.samples[1].0.stamp <= until {
            gaps += usize::from(self.samples[1].0.stamp.since(self.samples[0].0.stamp) > GAP);
            self.samples.pop_front();
        }
        // The last one holds on.
        while self.speeds.get(1).is_some_and(|speed| speed.stamp <= until) {
            self.speeds.pop_front();
        }
        gaps
    }

    /// Drops all but the newest sample.
    pub(super) fn clear(&mut self) {
        self.samples.drain(..self.samples.len().saturating_sub(1));
        self.speeds.clear();
    }
}

/// Whether a gyroscope shows what the wheels did not do, by a turn rate of the robot's frame.
fn is_shaken(rate: &Vector3<f64>, said: &Speed, evenly: bool) -> bool {
    let most = SHAKEN[usize::from(evenly)];
    (rate.z - said.turn).abs() > most || rate.xy().norm() > most
}

fn mean(a: [f64; 3], b: [f64; 3]) -> Vector3<f64> {
    (Vector3::from(a) + Vector3::from(b)) * 0.5
}
