//! The satellite receiver: absent unless the robot's description has one.
//!
//! Each fix is what a receiver computes from the pseudoranges of the satellites in reception. Their
//! errors are those of GPS on one frequency: a slow part (ionosphere, troposphere, orbits and
//! clocks), white noise of the receiver, and multipath. Buildings block signals and reflect others,
//! which arrive late. With fewer than four satellites, or with too bad a geometry, there is no fix.
//!
//! Sources: P. Misra, P. Enge, *Global Positioning System*, 2nd edition, chapters 5, 6 and 10
//! (error budget, least squares and dilution of precision, multipath); IS-GPS-200, 20.3.3.5.2.5
//! (obliquity of the ionosphere; its broadcast model removes half of the error or more); P. D.
//! Groves, *Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems*, 2nd
//! edition, chapter 9 (non-line-of-sight reception). Not modelled: diffraction round edges, a
//! receiver's filter over time, exclusion of outliers.
//!
//! | module | job |
//! |---|---|
//! | `sky` | where the satellites are, and their slow errors |
//! | `signals` | how a signal arrives: direct, reflected or both |
//! | `solution` | from pseudoranges to a position |

mod signals;
mod sky;
mod solution;

use openbench_core::{GnssFix, Pose3, SimTime};
use openbench_scene::RayCaster;

use crate::noise::Noise;
use signals::{Arrival, Surroundings};
use sky::{SATELLITES, Satellite, Sky, slow_deviation};
use solution::{Range, solve};

/// Time between two fixes, nanoseconds: 5 Hz.
pub(crate) const FIX_NS: u64 = 200_000_000;
/// Lowest satellite that is used: sine of 10° of elevation.
const MASK: f64 = 0.173_648_177_666_930_33;
/// White noise of a direct pseudorange, metres.
const WHITE_M: f64 = 0.5;
/// Amplitude of a signal after a reflection: 10 dB less power, the order of brick and glass.
const REFLECTED: f64 = 0.3;
/// Wavelength of GPS L1, metres.
const WAVELENGTH_M: f64 = 0.190_29;
/// Length of a chip of the C/A code, metres.
const CHIP_M: f64 = 293.05;

/// A receiver.
#[derive(Debug)]
pub(crate) struct Gnss {
    noise: Noise,
    antenna: Pose3,
    sky: Sky,
}

impl Gnss {
    /// A receiver with its antenna at `antenna` in `base_link`, under a sky drawn from `noise`.
    pub(crate) fn new(mut noise: Noise, antenna: Pose3) -> Self {
        let sky = Sky::new(&mut noise);
        Self {
            noise,
            antenna,
            sky,
        }
    }

    /// The fix at `stamp`, or `None` without enough satellites. Call it every [`FIX_NS`].
    pub(crate) fn fix(
        &mut self,
        caster: &RayCaster,
        stamp: SimTime,
        base_link: &Pose3,
    ) -> Option<GnssFix> {
        let truth = (base_link * self.antenna).translation.vector;
        // Slow errors drift also while there is no fix, so reception does not change their course.
        self.sky.drift(FIX_NS as f64 * 1e-9, &mut self.noise);
        // Walls are searched once for a fix, not for each satellite.
        let around = Surroundings::new(caster, truth);
        let mut ranges = Vec::with_capacity(SATELLITES);
        for satellite in self.sky.at(stamp.seconds()) {
            // Drawn for every satellite, so that a wall does not change the noise of the others.
            let white = self.noise.normal();
            if satellite.direction.z < MASK {
                continue;
            }
            if let Some(arrival) = around.arrival(satellite.direction) {
                ranges.push(range(satellite, white, arrival));
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

/// The error of a satellite's pseudorange, and the receiver's weight for it by elevation and signal
/// strength. `white` is the receiver's noise in standard deviations.
fn range(satellite: Satellite, white: f64, arrival: Arrival) -> Range {
    let (late, strength) = match arrival {
        Arrival::Direct => (0.0, 1.0),
        // The direct signal is the stronger one, and the receiver tracks it.
        Arrival::Both { extra } => (interference(extra), 1.0),
        // The receiver takes the reflection for the satellite: the whole detour is an error.
        Arrival::Reflected { extra } => (extra, REFLECTED),
    };
    let slow_deviation = slow_deviation(satellite.direction.z);
    let white_deviation = WHITE_M / strength;
    Range {
        direction: satellite.direction,
        error: satellite.slow * slow_deviation + white * white_deviation + late,
        // `late` is left out: a receiver sees that a signal is weak, not that it was reflected.
        deviation: libm::hypot(slow_deviation, white_deviation) / strength,
    }
}

/// Error of the measured range, metres, by a weaker signal that arrives `extra` metres late. It
/// oscillates with the phase between the two, and the correlator, spaced a tenth of a chip, bounds
/// it.
fn interference(extra: f64) -> f64 {
    // Let α be the relative amplitude and φ the phase. A short delay gives an error of `α cos φ /
    // (1 + α cos φ)` times the delay. From half the correlator's spacing on, the envelope is flat.
    // It ends beyond one chip, which walls within 60 m do not reach.
    let longest = 0.1 * CHIP_M / 2.0;
    let swing = REFLECTED * libm::cos(std::f64::consts::TAU * extra / WAVELENGTH_M);
    swing / (1.0 + swing) * extra.min(longest)
}

#[cfg(test)]
mod tests;
