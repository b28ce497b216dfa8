//! An IMU at the end of its range: it shows the same largest number again and again, whatever happens.

use openbench_core::ImuSample;

/// The same largest number so often in a row is a limit.
const REPEATS: u32 = 3;
/// Smaller numbers are no limit of any sensor: rad/s and m/s².
const LEAST: [f64; 2] = [0.4, 10.5];

/// Axes of a sample that are at their limits: x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct AtLimit {
    pub(super) gyro: [bool; 3],
    pub(super) accel: [bool; 3],
}

/// What is known of an IMU's limits.
#[derive(Debug, Clone, Default)]
pub(super) struct Limits {
    /// As its maker says, rad/s and m/s².
    stated: Option<[f64; 2]>,
    /// The largest number so far and how often in a row it has been shown, by axis of gyroscope and accelerometer.
    seen: [(f64, u32); 6],
}

impl Limits {
    pub(super) fn new(stated: Option<[f64; 2]>) -> Self {
        Self {
            stated,
            ..Self::default()
        }
    }

    /// Looks at a sample. As many samples before it as are told were at the limit, too, though it could not be known.
    pub(super) fn look(&mut self, sample: &ImuSample) -> (AtLimit, usize) {
        let mut at = [false; 6];
        let mut late = 0;
        for (axis, x) in sample.gyro.into_iter().chain(sample.accel).enumerate() {
            let (size, sensor) = (x.abs(), axis / 3);
            if self
                .stated
                .is_some_and(|stated| size >= stated[sensor] * (1.0 - 1e-6))
            {
                at[axis] = true;
                continue;
            }
            let (largest, count) = &mut self.seen[axis];
            *count = if size == *largest {
                *count + 1
            } else {
                u32::from(size > *largest)
            };
            *largest = largest.max(size);
            at[axis] = *count >= REPEATS && size >= LEAST[sensor];
            if at[axis] && *count == REPEATS {
                late = REPEATS as usize - 1;
            }
        }
        let [a, b, c, d, e, f] = at;
        (
            AtLimit {
                gyro: [a, b, c],
                accel: [d, e, f],
            },
            late,
        )
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
    fn the_same_largest_number_again_and_again_is_a_limit() {
        let mut limits = Limits::default();
        let at: Vec<_> = [0.1, 0.8, 0.9, 0.9, 0.9, 0.9, 0.7, 0.7, 0.7, 0.9]
            .map(|rate| limits.look(&turn(rate)))
            .iter()
            .map(|(at, late)| (at.gyro[2], *late))
            .collect();
        let none = (false, 0);
        assert_eq!(
            at,
            [
                none,
                none,
                none,
                none,
                (true, 2),
                (true, 0),
                none,
                none,
                none,
                none
            ]
        );
    }

    #[test]
    fn rest_is_no_limit_and_a_stated_one_counts_at_once() {
        let mut limits = Limits::default();
        assert!((0..10).all(|_| limits.look(&turn(0.0)).0 == AtLimit::default()));
        let mut limits = Limits::new(Some([0.5, 30.0]));
        assert!(
            limits.look(&turn(-0.5)).0.gyro[2] && limits.look(&turn(0.4)).0 == AtLimit::default()
        );
    }
}
