//! What IMU and wheels said, and the way that follows from it.

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::Vector3;
use openbench_core::{ImuSample, SimTime};

use super::Settings;
use super::limits::{AtLimit, Limits};
use super::propagation::{Node, advance, propagate};
use super::speed::{Speed, correct, temper};
use super::state::{Covariance, State};

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
            temper(&mut self.state, &mut self.covariance, direction, typical, seconds);
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
        Self { limits, ..Self::default() }
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
        let late = self.speeds.back().is_some_and(|last| speed.stamp <= last.stamp);
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
        let (mut way, mut at) = (Way::default(), 0);
        let from = known.stamp;
        let mut speeds = self.speeds.iter().skip_while(|speed| speed.stamp <= from).peekable();
        while known.stamp < until && !self.samples.is_empty() {
            // The samples round this instant; before the first and behind the last one they hold on.
            while at + 2 < self.samples.len() && self.samples[at + 1].0.stamp <= known.stamp {
                at += 1;
            }
            let [before, behind] = [&self.samples[at], &self.samples[(at + 1).min(self.samples.len() - 1)]];
            let ahead = behind.0.stamp > known.stamp;
            let next = if ahead { behind.0.stamp.min(until) } else { until };
            let next = speeds.peek().map_or(next, |speed| next.min(speed.stamp)).min(known.stamp + STEP);
            let (mut gyro, accel) =
                (mean(before.0.gyro, behind.0.gyro), mean(before.0.accel, behind.0.accel));
            let mut noise = settings.imu_noise;
            if behind.0.stamp.since(before.0.stamp) > GAP {
                [noise.gyro, noise.accel] = UNSEEN;
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
            let Known { stamp, state, covariance } = known;
            way.nodes.push(propagate(state, covariance, &noise, *stamp, next, gyro, accel));
            *stamp = next;
            while let Some(speed) = speeds.next_if(|speed| speed.stamp <= next) {
                if next.since(speed.stamp) < NEAR {
                    correct(state, covariance, &settings.imu, gyro, speed);
                }
            }
        }
        way
    }

    /// Where a state has come to with the newest sample.
    pub(super) fn extrapolate(&self, known: &Known) -> (SimTime, State) {
        let (mut stamp, mut state) = (known.stamp, known.state.clone());
        for ((before, _), (behind, _)) in self.samples.iter().zip(self.samples.iter().skip(1)) {
            if behind.stamp > stamp {
                let (gyro, accel) = (mean(before.gyro, behind.gyro), mean(before.accel, behind.accel));
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
        while self.speeds.front().is_some_and(|speed| speed.stamp <= until) {
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

fn mean(a: [f64; 3], b: [f64; 3]) -> Vector3<f64> {
    (Vector3::from(a) + Vector3::from(b)) * 0.5
}
