//! The encoders of the wheels.

use openbench_core::{SimTime, WheelSample};

use crate::defects::Defects;
use crate::wheels::WheelSpeeds;

/// Encoders of the left and right wheels, on the axes of their motors.
#[derive(Debug)]
pub(crate) struct Encoders {
    left: Disc,
    right: Disc,
    /// Angle between two marks, radians.
    mark: f64,
    /// Angle by which a motor turns before its wheel follows, when it is reversed, radians.
    backlash: f64,
}

/// A disc with marks.
#[derive(Debug, Default)]
struct Disc {
    /// Angle of the wheel since the start, radians.
    wheel: f64,
    /// Angle by which the motor is ahead of its wheel, at most half the backlash, radians.
    lead: f64,
}

impl Disc {
    fn turn(&mut self, angle: f64, backlash: f64) {
        self.wheel += angle;
        self.lead = (self.lead + angle).clamp(-backlash / 2.0, backlash / 2.0);
    }

    /// Angle of the disc since the start, radians.
    fn angle(&self) -> f64 {
        self.wheel + self.lead
    }
}

impl Encoders {
    pub(crate) fn new(defects: &Defects) -> Self {
        Self {
            left: Disc::default(),
            right: Disc::default(),
            // At least one, or the angle would not be finite.
            mark: std::f64::consts::TAU / f64::from(defects.encoder_marks.max(1)),
            backlash: defects.backlash_rad,
        }
    }

    /// Turns the discs with the wheels for `dt` seconds.
    pub(crate) fn turn(&mut self, speeds: WheelSpeeds, dt: f64) {
        self.left.turn(speeds.left * dt, self.backlash);
        self.right.turn(speeds.right * dt, self.backlash);
    }

    /// The sample at `stamp`: angles in whole marks. They count from the start, so that a lost
    /// sample loses no angle.
    pub(crate) fn sample(&self, stamp: SimTime) -> WheelSample {
        WheelSample {
            stamp,
            left: whole_marks(self.left.angle(), self.mark),
            right: whole_marks(self.right.angle(), self.mark),
        }
    }
}

/// `angle` rounded down to a whole number of marks, radians.
fn whole_marks(angle: f64, mark: f64) -> f64 {
    libm::floor(angle / mark) * mark
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_whole_marks() {
        let mark = std::f64::consts::TAU / 2048.0;
        assert_eq!(whole_marks(2.7 * mark, mark), 2.0 * mark);
        assert_eq!(whole_marks(-0.2 * mark, mark), -mark);
    }

    #[test]
    fn a_reversed_motor_turns_through_the_backlash() {
        let backlash_rad = 0.02;
        let mut encoders = Encoders::new(&Defects {
            backlash_rad,
            encoder_marks: 1_000_000,
            ..Defects::default()
        });
        let mut turn = |speed: f64| {
            let before = encoders.sample(SimTime::ZERO).left;
            let speeds = WheelSpeeds {
                left: speed,
                right: 0.0,
            };
            (0..100).for_each(|_| encoders.turn(speeds, 0.01));
            encoders.sample(SimTime::ZERO).left - before
        };
        // A radian forward and as far back; the first time half the backlash is taken up.
        assert!((turn(1.0) - (1.0 + backlash_rad / 2.0)).abs() < 1e-4);
        assert!((turn(1.0) - 1.0).abs() < 1e-4);
        assert!((turn(-1.0) + 1.0 + backlash_rad).abs() < 1e-4);
    }
}
