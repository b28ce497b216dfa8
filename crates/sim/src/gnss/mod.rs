//! The satellite receiver: off unless the robot's description has one.
//!
//! Each fix is what a receiver computes from the pseudoranges of the satellites that it hears. Their errors are those of GPS on one
//! frequency: a slow part (ionosphere, troposphere, orbits and clocks), the receiver's white noise, and what the walls around
//! do. Buildings block signals, and reflect others, which come late. With fewer than four satellites, or with a geometry that is
//! too bad, there is no fix.
//!
//! Sources: P. Misra, P. Enge, *Global Positioning System*, 2nd edition, chapters 5, 6 and 10 (error budget, least squares and
//! dilution of precision, multipath); IS-GPS-200, 20.3.3.5.2.5 (slant of the ionosphere, and that its broadcast model takes away
//! half of it or more); P. D. Groves, *Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems*, 2nd edition,
//! chapter 9 (reception by reflection alone). What is not modelled: diffraction round edges, a receiver's filter over time, exclusion of
//! outliers.
//!
//! | module | its one job |
//! |---|---|
//! | `sky` | where the satellites are, and their slow errors |
//! | `signals` | which way a signal comes in: straight, reflected, both |
//! | `solution` | from pseudoranges to a position |

mod signals;
mod sky;
mod solution;

use nalgebra::Vector3;
use openbench_core::{GnssFix, Pose3, SimTime};
use openbench_scene::RayCaster;

use crate::noise::Noise;
use signals::{Arrival, Surroundings};
use sky::Sky;
use solution::{Range, solve};

/// Time between two fixes, nanoseconds: 5 Hz.
pub const FIX_NS: u64 = 200_000_000;
/// Lowest satellite that is used: sine of 10° of elevation.
const MASK: f64 = 0.173_648_177_666_930_33;
/// White noise of a pseudorange that comes in straight, metres.
const WHITE: f64 = 0.5;
/// Amplitude of a signal after a reflection: 10 dB less power, the order of brick and glass.
const REFLECTED: f64 = 0.3;

/// A receiver.
#[derive(Debug)]
pub struct Gnss {
    noise: Noise,
    antenna: Pose3,
    sky: Sky,
}

impl Gnss {
    /// A receiver whose antenna stands at `antenna` in `base_link`, under a sky drawn from `noise`.
    pub fn new(mut noise: Noise, antenna: Pose3) -> Self {
        let sky = Sky::new(&mut noise);
        Self {
            noise,
            antenna,
            sky,
        }
    }

    /// The fix at `stamp`, or `None` without enough satellites. Call it every [`FIX_NS`].
    pub fn fix(
        &mut self,
        caster: &RayCaster,
        stamp: SimTime,
        base_link: &Pose3,
    ) -> Option<GnssFix> {
        let truth = (base_link * self.antenna).translation.vector;
        self.sky.drift(FIX_NS as f64 * 1e-9, &mut self.noise);
        let around = Surroundings::new(caster, truth);
        let (noise, mut ranges) = (&mut self.noise, Vec::with_capacity(sky::SATELLITES));
        for (direction, slow) in self.sky.at(stamp.seconds()) {
            // Drawn for all, so that a wall does not change the noise of the others.
            let white = noise.normal();
            if direction.z >= MASK {
                ranges.extend(
                    around
                        .arrival(direction)
                        .map(|arrival| range(direction, slow, white, arrival)),
                );
            }
        }
        let solution = solve(&ranges)?;
        Some(GnssFix {
            stamp,
            position: (truth + solution.error).into(),
            covariance: solution.covariance.into(),
            satellites: ranges.len() as u8,
        })
    }
}

/// The pseudorange's error, metres, and how much the receiver trusts it: by elevation and strength.
fn range(direction: Vector3<f64>, slow: f64, white: f64, arrival: Arrival) -> Range {
    let (late, strength) = match arrival {
        Arrival::Straight => (0.0, 1.0),
        Arrival::Both { extra } => (interference(extra), 1.0),
        Arrival::Reflected { extra } => (extra, REFLECTED),
    };
    let (slow_deviation, white_deviation) = (sky::slow_deviation(direction.z), WHITE / strength);
    Range {
        direction,
        error: slow * slow_deviation + white * white_deviation + late,
        deviation: libm::hypot(slow_deviation, white_deviation) / strength,
    }
}

/// What a weaker signal that comes `extra` metres late does to the measured range, metres: it swings with
/// the phase between the two, and the correlator, spaced a tenth of a chip, bounds it.
fn interference(extra: f64) -> f64 {
    const WAVELENGTH: f64 = 0.190_29;
    const CHIP: f64 = 293.05;
    let longest = 0.1 * CHIP / 2.0;
    let swing = REFLECTED * libm::cos(std::f64::consts::TAU * extra / WAVELENGTH);
    swing / (1.0 + swing) * extra.min(longest)
}

#[cfg(test)]
mod tests;
