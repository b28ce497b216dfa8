//! Samples of the IMU and velocities of the wheels, and the motion that follows from them.

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::Vector3;
use openbench_core::{ImuSample, Pose3, SimTime};

use super::belief::Belief;
use super::impacts::{ImpactFilter, WheelReport, is_shaken};
use super::noise::{UNMEASURED_ACCEL, UNMEASURED_GYRO};
use super::propagation::{Node, Reading, propagate, propagate_state};
use super::reckoning::Reckoned;
use super::saturation::{SaturatedAxes, SaturationDetector};
use super::settings::{ImuLimits, Settings};
use super::speed::Speed;
use super::state::State;
use super::velocity_update::apply_speed;
use super::wheel_speeds::{VALIDITY, WheelSpeeds};

/// Samples farther apart than this leave a gap.
const GAP: Duration = Duration::from_millis(50);
/// No step of a prediction is longer, so that the robot turns little during it.
const MAX_STEP: Duration = Duration::from_millis(20);
/// Error of a gyroscope's scale, √s: over the tenth of a second of a scan, three times this number
/// is the share of a turn that is wrong; over longer turns it is less.
const SCALE_ERROR: f64 = 1e-3;
/// No IMU shows more, rad/s,
const MAX_GYRO_RAD_S: f64 = 1e3;
/// nor more than this, m/s².
const MAX_ACCEL_M_S2: f64 = 1e5;
/// A velocity farther than this from an instant does not correct the state then.
const MAX_SPEED_AGE: Duration = Duration::from_millis(20);

/// A sample of the IMU, and which of its axes are at their limits.
#[derive(Debug, Clone, Copy)]
struct Sample {
    imu: ImuSample,
    saturated: SaturatedAxes,
}

/// For how long and about which axes the gyroscope was at its limit.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct GyroSaturation {
    pub(super) duration: Duration,
    pub(super) axes: [bool; 3],
}

/// A predicted motion.
#[derive(Debug, Default)]
pub(super) struct Prediction {
    pub(super) nodes: Vec<Node>,
    pub(super) saturation: GyroSaturation,
}

/// Samples and velocities that are still needed.
#[derive(Debug, Clone)]
pub(super) struct Inertial {
    samples: VecDeque<Sample>,
    speeds: WheelSpeeds,
    detector: SaturationDetector,
}

impl Inertial {
    pub(super) fn new(limits: Option<ImuLimits>) -> Self {
        Self {
            samples: VecDeque::new(),
            speeds: WheelSpeeds::default(),
            detector: SaturationDetector::new(limits),
        }
    }

    /// Time of the newest sample of the IMU.
    pub(super) fn newest(&self) -> Option<SimTime> {
        self.samples.back().map(|sample| sample.imu.stamp)
    }

    /// Takes in a sample, if it can be used.
    pub(super) fn push(&mut self, imu: ImuSample) -> bool {
        let is_late = self.newest().is_some_and(|newest| imu.stamp <= newest);
        if is_late || !is_sound(&imu) {
            return false;
        }
        let found = self.detector.examine(&imu);
        // This sample is not among them yet.
        for earlier in self.samples.iter_mut().rev().take(found.earlier) {
            earlier.saturated = found.axes;
        }
        self.samples.push_back(Sample {
            imu,
            saturated: found.axes,
        });
        true
    }

    /// Takes in a velocity, if it can be used.
    pub(super) fn push_speed(&mut self, speed: Speed) -> bool {
        self.speeds.push(speed)
    }

    /// Predicts a belief at `until`, corrected by the wheels' velocities until then. `unmeasured`
    /// is the turn rate that a gyroscope at its limit does not show, rad/s.
    pub(super) fn predict(
        &self,
        belief: &mut Belief,
        until: SimTime,
        settings: &Settings,
        unmeasured: &Vector3<f64>,
    ) -> Prediction {
        let mut prediction = Prediction::default();
        let mut impacts = ImpactFilter::default();
        let mut speeds = self.speeds.after(belief.stamp).peekable();
        let mut index = 0;
        while belief.stamp < until && !self.samples.is_empty() {
            index = self.index_at(belief.stamp, index);
            let before = &self.samples[index];
            let after = &self.samples[(index + 1).min(self.samples.len() - 1)];
            let next_speed = speeds.peek().map(|speed| speed.stamp);
            let next = step_end(belief.stamp, until, after.imu.stamp, next_speed);

            // What the samples on both sides show, less what they cannot have measured.
            let mut reading = mean_reading(before, after, settings);
            if let Some(wheels) = self.wheels_at(belief.stamp) {
                let (stamp, state) = (belief.stamp, &belief.state);
                impacts.apply(&mut reading, stamp, state, wheels, &settings.imu);
            }
            add_scale_error(&mut reading);
            let duration = next.since(belief.stamp);
            prediction.saturation.note(after.saturated.gyro, duration);
            correct_saturated(&mut reading, after.saturated, unmeasured);

            prediction.nodes.push(propagate(belief, &reading, next));
            // A step ends where a velocity does, so that it corrects the state of its own instant.
            while let Some(speed) = speeds.next_if(|speed| speed.stamp <= next) {
                if next.since(speed.stamp) < MAX_SPEED_AGE {
                    apply_speed(belief, &settings.imu, reading.gyro, speed);
                }
            }
        }
        prediction
    }

    /// Number of the last sample at or before an instant, from `index` on; there is one after it,
    /// as far as there is one at all.
    fn index_at(&self, stamp: SimTime, mut index: usize) -> usize {
        while index + 2 < self.samples.len() && self.samples[index + 1].imu.stamp <= stamp {
            index += 1;
        }
        index
    }

    /// What the wheels report at an instant.
    fn wheels_at(&self, stamp: SimTime) -> Option<WheelReport<'_>> {
        self.speeds.at(stamp).map(|speed| self.report(speed))
    }

    fn report<'a>(&self, speed: &'a Speed) -> WheelReport<'a> {
        WheelReport {
            speed,
            is_steady: self.speeds.is_steady_after(speed),
        }
    }

    /// The motion from one instant to another by wheels and gyroscope; `None` where the wheels
    /// report nothing. `bias` is the gyroscope's, rad/s, and `imu` the IMU's pose on the robot.
    pub(super) fn reckon(
        &self,
        from: SimTime,
        until: SimTime,
        bias: Vector3<f64>,
        imu: &Pose3,
    ) -> Option<Reckoned> {
        let mut reckoned = Reckoned::default();
        let mut speeds = self.speeds.iter().peekable();
        let mut speed = *speeds
            .peek()
            .filter(|first| first.stamp < from + VALIDITY)?;
        for (before, after) in self.pairs() {
            let begin = before.stamp.max(from);
            let end = after.stamp.min(until);
            if end <= begin {
                continue;
            }
            while let Some(next) = speeds.next_if(|next| next.stamp <= end) {
                speed = next;
            }
            if begin.since(speed.stamp) > VALIDITY {
                return None;
            }
            let mut rate = imu.rotation * (mean(before.gyro, after.gyro) - bias);
            // As in a prediction: during an impact only the wheels count.
            if is_shaken(&rate, self.report(speed)) {
                rate = Vector3::z() * speed.turn;
            }
            reckoned.advance(speed.velocity, rate, end.since(begin).as_secs_f64());
        }
        Some(reckoned)
    }

    /// The state of a belief at the newest sample, and when that was.
    pub(super) fn extrapolate(&self, belief: &Belief) -> (SimTime, State) {
        let mut stamp = belief.stamp;
        let mut state = belief.state.clone();
        for (before, after) in self.pairs() {
            if after.stamp > stamp {
                let gyro = mean(before.gyro, after.gyro);
                let accel = mean(before.accel, after.accel);
                let dt = after.stamp.since(stamp).as_secs_f64();
                propagate_state(&mut state, stamp, dt, gyro, accel);
                stamp = after.stamp;
            }
        }
        (stamp, state)
    }

    /// Each sample with the next one.
    fn pairs(&self) -> impl Iterator<Item = (&ImuSample, &ImuSample)> {
        let samples = self.samples.iter().map(|sample| &sample.imu);
        samples.clone().zip(samples.skip(1))
    }

    /// Drops what is older than an instant; returns how many gaps were in it.
    pub(super) fn forget(&mut self, until: SimTime) -> usize {
        let mut gaps = 0;
        // One sample at or before `until` stays: the mean reading of the next step begins at it.
        while self.samples.len() > 2 && self.samples[1].imu.stamp <= until {
            let interval = self.samples[1].imu.stamp.since(self.samples[0].imu.stamp);
            gaps += usize::from(interval > GAP);
            self.samples.pop_front();
        }
        self.speeds.forget(until);
        gaps
    }

    /// Drops all but the newest sample.
    pub(super) fn clear(&mut self) {
        self.samples.drain(..self.samples.len().saturating_sub(1));
        self.speeds.clear();
    }
}

impl GyroSaturation {
    /// Notes a step that took so long, and the axes at their limits during it.
    fn note(&mut self, axes: [bool; 3], duration: Duration) {
        if axes.contains(&true) {
            self.duration += duration;
            for (axis, is_saturated) in axes.into_iter().enumerate() {
                self.axes[axis] |= is_saturated;
            }
        }
    }
}

/// Whether an IMU can show that.
fn is_sound(sample: &ImuSample) -> bool {
    // NaN compares as false, and is refused too.
    sample.gyro.iter().all(|x| x.abs() <= MAX_GYRO_RAD_S)
        && sample.accel.iter().all(|x| x.abs() <= MAX_ACCEL_M_S2)
}

/// End of the step that begins at `from`: the next sample or velocity, or a full step.
fn step_end(from: SimTime, until: SimTime, sample: SimTime, speed: Option<SimTime>) -> SimTime {
    // After the last sample its readings stay valid.
    let next = if sample > from {
        sample.min(until)
    } else {
        until
    };
    let next = speed.map_or(next, |speed| next.min(speed));
    next.min(from + MAX_STEP)
}

/// Mean readings between two samples; noisier if there is a gap between them.
fn mean_reading(before: &Sample, after: &Sample, settings: &Settings) -> Reading {
    let mut noise = settings.imu_noise;
    if after.imu.stamp.since(before.imu.stamp) > GAP {
        noise.gyro = UNMEASURED_GYRO;
        noise.accel = UNMEASURED_ACCEL;
    }
    Reading {
        gyro: mean(before.imu.gyro, after.imu.gyro),
        accel: mean(before.imu.accel, after.imu.accel),
        noise,
    }
}

/// The faster the robot turns, the more the gyroscope's scale matters.
fn add_scale_error(reading: &mut Reading) {
    let error = SCALE_ERROR * reading.gyro.norm();
    reading.noise.gyro = libm::hypot(reading.noise.gyro, error);
}

/// Adds what a gyroscope at its limit does not show, and says that the motion is unmeasured.
fn correct_saturated(reading: &mut Reading, saturated: SaturatedAxes, unmeasured: &Vector3<f64>) {
    if saturated.gyro.contains(&true) {
        reading.noise.gyro = UNMEASURED_GYRO;
        for axis in (0..3).filter(|axis| saturated.gyro[*axis]) {
            reading.gyro[axis] += unmeasured[axis];
        }
    }
    if saturated.accel.contains(&true) {
        reading.noise.accel = UNMEASURED_ACCEL;
    }
}

fn mean(a: [f64; 3], b: [f64; 3]) -> Vector3<f64> {
    (Vector3::from(a) + Vector3::from(b)) * 0.5
}
