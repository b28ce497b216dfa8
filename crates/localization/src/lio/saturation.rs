//! An IMU at the end of its range: it shows the same largest reading again and again, whatever
//! happens.

use openbench_core::ImuSample;

use super::settings::ImuLimits;

/// The same largest reading this often in a row is a limit.
const REPEATS: u32 = 3;
/// No sensor's limit is lower than these.
const LOWEST: ImuLimits = ImuLimits {
    gyro: 0.4,
    accel: 10.5,
};
/// A reading within this share of a stated limit is at it.
const ROUNDING: f64 = 1e-6;

/// Axes (x, y, z) of a sample that are at their limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct SaturatedAxes {
    pub(super) gyro: [bool; 3],
    pub(super) accel: [bool; 3],
}

/// What a sample shows of an IMU's limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Detection {
    pub(super) axes: SaturatedAxes,
    /// How many samples directly before this one were saturated likewise. A limit is recognized by
    /// repetition, so only now is that known.
    pub(super) earlier: usize,
}

/// The largest magnitude that an axis has shown so far.
#[derive(Debug, Clone, Copy, Default)]
struct Peak {
    magnitude: f64,
    /// How often in a row the axis has just shown it.
    repeats: u32,
}

/// Finds samples that are at an IMU's limits.
#[derive(Debug, Clone, Default)]
pub(super) struct SaturationDetector {
    /// Limits from a data sheet.
    stated: Option<ImuLimits>,
    gyro: [Peak; 3],
    accel: [Peak; 3],
}

impl SaturationDetector {
    pub(super) fn new(stated: Option<ImuLimits>) -> Self {
        Self {
            stated,
            ..Self::default()
        }
    }

    /// Examines the next sample.
    pub(super) fn examine(&mut self, sample: &ImuSample) -> Detection {
        let mut found = Detection::default();
        let stated = self.stated.map(|limits| limits.gyro);
        for axis in 0..3 {
            let seen = self.gyro[axis].examine(sample.gyro[axis].abs(), stated, LOWEST.gyro);
            found.axes.gyro[axis] = seen.is_saturated;
            found.earlier = found.earlier.max(seen.earlier);
        }
        let stated = self.stated.map(|limits| limits.accel);
        for axis in 0..3 {
            let seen = self.accel[axis].examine(sample.accel[axis].abs(), stated, LOWEST.accel);
            found.axes.accel[axis] = seen.is_saturated;
            found.earlier = found.earlier.max(seen.earlier);
        }
        found
    }
}

/// What one axis shows.
#[derive(Debug, Clone, Copy, Default)]
struct AxisDetection {
    is_saturated: bool,
    earlier: usize,
}

impl Peak {
    /// Takes in the next magnitude of the axis; `lowest` is what a limit is not below.
    fn examine(&mut self, magnitude: f64, stated: Option<f64>, lowest: f64) -> AxisDetection {
        // A stated limit shows in the sample itself: no earlier ones have to be marked.
        if stated.is_some_and(|limit| magnitude >= limit * (1.0 - ROUNDING)) {
            return AxisDetection {
                is_saturated: true,
                earlier: 0,
            };
        }
        // A new peak has been seen once. Anything below it ends the row.
        self.repeats = if magnitude == self.magnitude {
            self.repeats + 1
        } else {
            u32::from(magnitude > self.magnitude)
        };
        self.magnitude = self.magnitude.max(magnitude);
        let is_saturated = self.repeats >= REPEATS && magnitude >= lowest;
        let is_found_now = is_saturated && self.repeats == REPEATS;
        let earlier = if is_found_now {
            REPEATS as usize - 1
        } else {
            0
        };
        AxisDetection {
            is_saturated,
            earlier,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::SimTime;

    fn turn(rate: f64) -> ImuSample {
        ImuSample {
            stamp: SimTime::ZERO,
            gyro: [0.0, 0.0, rate],
            accel: [0.0, 0.0, 9.8],
        }
    }

    #[test]
    fn the_same_largest_reading_several_times_in_a_row_is_a_limit() {
        let mut detector = SaturationDetector::default();
        let readings = [0.1, 0.8, 0.9, 0.9, 0.9, 0.9, 0.7, 0.7, 0.7, 0.9];
        let found = readings.map(|rate| detector.examine(&turn(rate)));
        let saturated = found.map(|detection| detection.axes.gyro[2]);
        let earlier = found.map(|detection| detection.earlier);
        let expected = [
            false, false, false, false, true, true, false, false, false, false,
        ];
        assert_eq!(saturated, expected);
        assert_eq!(earlier, [0, 0, 0, 0, 2, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn rest_is_no_limit_and_a_stated_limit_needs_no_repetition() {
        let mut detector = SaturationDetector::default();
        assert!((0..10).all(|_| detector.examine(&turn(0.0)) == Detection::default()));
        let limits = ImuLimits {
            gyro: 0.5,
            accel: 30.0,
        };
        let mut detector = SaturationDetector::new(Some(limits));
        assert!(detector.examine(&turn(-0.5)).axes.gyro[2]);
        assert_eq!(detector.examine(&turn(0.4)), Detection::default());
    }
}
