//! The encoders of the wheels.

use openbench_core::{SimTime, WheelSample};

use crate::wheels::WheelSpeeds;

/// Marks on an encoder's disc.
const MARKS: f64 = 2048.0;

/// Encoders of the left and right wheels.
#[derive(Debug, Default)]
pub(crate) struct Encoders {
    /// Angle since the start, radians.
    left: f64,
    right: f64,
}

impl Encoders {
    /// Turns the discs with the wheels for `dt` seconds.
    pub(crate) fn turn(&mut self, speeds: WheelSpeeds, dt: f64) {
        self.left += speeds.left * dt;
        self.right += speeds.right * dt;
    }

    /// The sample at `stamp`: angles in whole marks. They count from the start, so that a lost
    /// sample loses no angle.
    pub(crate) fn sample(&self, stamp: SimTime) -> WheelSample {
        WheelSample {
            stamp,
            left: whole_marks(self.left),
            right: whole_marks(self.right),
        }
    }
}

/// `angle` rounded down to a whole number of marks, radians.
fn whole_marks(angle: f64) -> f64 {
    let mark = std::f64::consts::TAU / MARKS;
    libm::floor(angle / mark) * mark
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_whole_marks() {
        let mark = std::f64::consts::TAU / MARKS;
        assert_eq!(whole_marks(2.7 * mark), 2.0 * mark);
        assert_eq!(whole_marks(-0.2 * mark), -mark);
    }
}
