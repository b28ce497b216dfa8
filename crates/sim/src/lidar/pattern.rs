//! The rosette scan pattern of the Livox MID-360.
//!
//! Two rotors turn the four beams. The fast one, at 182.4 turns a second, gives the azimuth. The
//! slow one, at 10 turns a second, swings the beams up, down and sideways. Fourier series of the
//! slow rotor's angle φ describe the swing of the middle of the four beams. The four beams stand a
//! little apart in a fixed direction, which the fast rotor's angle θ turns:
//!
//! ```text
//! elevation = E(φ) + k (Gs(φ) sin θ + Gc(φ) cos θ)
//! azimuth   = θ + A(φ) + k (Hc(φ) cos θ + Hs(φ) sin θ),   k = 1, 1/3, -1/3, -1 for the four lines
//! ```
//!
//! The coefficients were fitted to 800,000 directions of a real sensor's pattern (the MID-360 file
//! of the PyPI package `mujoco-lidar`). The error is 0.05° rms and at most 0.25°; the sensor's own
//! angular precision is 0.15°. The fast rotor makes 729 2/3 turns in 4 seconds, so the pattern
//! repeats after 12 seconds.

use std::f64::consts::TAU;
use std::ops::{Add, Mul, Sub};

use crate::rounding::whole;

/// Laser lines, which fire at the same instant.
pub const LINES: usize = 4;
/// Time between two firings, nanoseconds.
pub(super) const FIRING_NS: u64 = 20_000;
/// Firings in a turn of the slow rotor.
const SLOW_TURN: u64 = 5_000;
/// Firings after which the pattern repeats.
const PERIOD: u64 = 600_000;
/// Turns of the fast rotor in a period.
const FAST_TURNS: u64 = 2_189;
/// Offset of each line, k in the equations.
const OFFSETS: [f32; LINES] = [1.0, 1.0 / 3.0, -1.0 / 3.0, -1.0];

/// Angle of the fast rotor at the first firing, radians.
const THETA: f64 = 4.701_06;
/// Angles of the slow rotor at the first firing, radians, for elevation, azimuth and offsets.
const PHI: [f64; 3] = [0.011_01, 0.008_19, 0.009_60];
/// Elevation: cosines of 0, 1, 2, … φ, radians.
const E: [f64; 9] = [
    0.35698, 0.41059, 0.01963, 0.04014, 0.0039, 0.00273, 0.00058, 0.00029, 0.00009,
];
/// Azimuth: sines of 1, 2, … φ, radians.
const A: [f64; 9] = [
    0.49618, 0.04098, 0.04698, 0.00934, 0.00531, 0.00164, 0.00079, 0.0003, 0.00014,
];
/// Offsets in elevation: cosines from 0, and sines from 1.
const GS: [f64; 7] = [
    -0.04825, -0.00717, -0.01148, -0.00215, -0.00229, -0.00053, -0.00036,
];
const GC: [f64; 6] = [0.00167, -0.00741, -0.00052, -0.00142, -0.0002, -0.00019];
/// Offsets in azimuth: cosines from 0, and sines from 1.
const HC: [f64; 9] = [
    -0.05493, -0.01, 0.00655, 0.0003, 0.00163, 0.00043, 0.00035, 0.00013, 0.00008,
];
const HS: [f64; 8] = [
    -0.01031, -0.01606, -0.0048, -0.0042, -0.00152, -0.00091, -0.00038, -0.0002,
];

/// Firings that are aimed together, as lanes of vector instructions.
pub(super) const VOLLEY: usize = 32;

/// Sine and cosine of an angle.
#[derive(Debug, Clone, Copy)]
struct SinCos<T> {
    sin: T,
    cos: T,
}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> SinCos<T> {
    /// Sine and cosine of the sum of two angles.
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self {
            sin: self.sin * other.cos + self.cos * other.sin,
            cos: self.cos * other.cos - self.sin * other.sin,
        }
    }
}

impl SinCos<f64> {
    fn of(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self { sin, cos }
    }

    #[inline(always)]
    fn single(self) -> SinCos<f32> {
        SinCos {
            sin: self.sin as f32,
            cos: self.cos as f32,
        }
    }
}

impl SinCos<f32> {
    /// Of an angle below 0.1, to 1e-7.
    #[inline(always)]
    fn of_small(angle: f32) -> Self {
        let square = angle * angle;
        Self {
            sin: angle * (1.0 - square * (1.0 / 6.0)),
            cos: 1.0 - square * 0.5 * (1.0 - square * (1.0 / 12.0)),
        }
    }
}

/// Values of the series at one angle of the slow rotor.
#[derive(Debug, Clone, Copy)]
struct Swing {
    /// Radians.
    elevation: f32,
    /// Turns.
    azimuth: f32,
    elevation_sin_cos: SinCos<f32>,
    azimuth_sin_cos: SinCos<f32>,
    gs: f32,
    gc: f32,
    hc: f32,
    hs: f32,
}

/// The scan pattern, its series tabulated.
#[derive(Debug, Clone)]
pub struct Pattern {
    swings: Vec<Swing>,
    fast: FastRotor,
}

/// The two rotors at the firings of a volley.
#[derive(Debug, Clone, Copy, Default)]
struct Rotors {
    elevation: [f32; VOLLEY],
    elevation_sin: [f32; VOLLEY],
    elevation_cos: [f32; VOLLEY],
    /// Azimuth of the middle of the beams, turns.
    turns: [f32; VOLLEY],
    azimuth_sin: [f32; VOLLEY],
    azimuth_cos: [f32; VOLLEY],
    /// Offset of the outermost line in elevation, radians.
    up: [f32; VOLLEY],
    /// Offset of the outermost line in azimuth, radians.
    aside: [f32; VOLLEY],
}

/// Sines and cosines of the fast rotor's angle. An angle is the sum of whole thousands of steps
/// and of the rest, each of which has a table.
#[derive(Debug, Clone)]
struct FastRotor {
    thousands: Vec<SinCos<f64>>,
    rest: Vec<SinCos<f64>>,
}

impl FastRotor {
    const REST: u64 = 1_000;

    fn new() -> Self {
        // The fast rotor turns clockwise.
        let turned = |steps: u64| -(steps as f64) / PERIOD as f64 * TAU;
        let thousands = 0..PERIOD / Self::REST;
        Self {
            thousands: thousands
                .map(|i| SinCos::of(THETA + turned(i * Self::REST)))
                .collect(),
            rest: (0..Self::REST).map(|i| SinCos::of(turned(i))).collect(),
        }
    }

    /// Sine and cosine of the angle after `steps`, of which [`PERIOD`] make a turn.
    #[inline(always)]
    fn sin_cos(&self, steps: u64) -> SinCos<f64> {
        let thousand = self.thousands[(steps / Self::REST) as usize];
        thousand.plus(self.rest[(steps % Self::REST) as usize])
    }
}

/// Direction of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Aim {
    /// Unit vector: x forward, y left, z up.
    pub direction: [f32; 3],
    /// Azimuth, turns in [0, 1).
    pub turn: f32,
    /// Elevation, radians.
    pub elevation: f32,
}

impl Pattern {
    /// The pattern from its first firing.
    pub fn new() -> Self {
        let swings = (0..SLOW_TURN)
            .map(|i| swing(i as f64 / SLOW_TURN as f64 * TAU))
            .collect();
        Self {
            swings,
            fast: FastRotor::new(),
        }
    }

    /// Directions of the four lines at a firing, counted from 0.
    pub fn firing(&self, number: u64) -> [Aim; LINES] {
        self.volley(number)[0]
    }

    /// Directions of the four lines at firing number `first` and those after it.
    #[inline(always)]
    pub(super) fn volley(&self, first: u64) -> [[Aim; LINES]; VOLLEY] {
        let rotors = self.rotors(first);
        let mut aims = [[Aim::default(); LINES]; VOLLEY];
        for (line, k) in OFFSETS.into_iter().enumerate() {
            let (mut x, mut y, mut z) = ([0.0; VOLLEY], [0.0; VOLLEY], [0.0; VOLLEY]);
            let (mut turns, mut elevation) = ([0.0; VOLLEY], [0.0; VOLLEY]);
            for i in 0..VOLLEY {
                let (up, aside) = (k * rotors.up[i], k * rotors.aside[i]);
                let el = SinCos {
                    sin: rotors.elevation_sin[i],
                    cos: rotors.elevation_cos[i],
                };
                let el = el.plus(SinCos::of_small(up));
                let az = SinCos {
                    sin: rotors.azimuth_sin[i],
                    cos: rotors.azimuth_cos[i],
                };
                let az = az.plus(SinCos::of_small(aside));
                let turn = rotors.turns[i] + aside * (1.0 / TAU) as f32;
                // The line's own direction by the sum formulas, without a sine or cosine of its
                // angles.
                (x[i], y[i], z[i]) = (az.cos * el.cos, az.sin * el.cos, el.sin);
                // Through a signed integer, for which every machine has a vector conversion.
                turns[i] = turn - whole(turn) as i32 as f32;
                elevation[i] = rotors.elevation[i] + up;
            }
            // Stored apart from the arithmetic above, whose loop becomes vector instructions.
            for (i, aims) in aims.iter_mut().enumerate() {
                let direction = [x[i], y[i], z[i]];
                aims[line] = Aim {
                    direction,
                    turn: turns[i],
                    elevation: elevation[i],
                };
            }
        }
        aims
    }

    #[inline(always)]
    fn rotors(&self, first: u64) -> Rotors {
        let mut rotors = Rotors::default();
        for i in 0..VOLLEY {
            let number = (first + i as u64) % PERIOD;
            let swing = &self.swings[(number % SLOW_TURN) as usize];
            // In whole numbers, so that the angle is as exact after hours as at the start. The
            // product stays below 2^31, as `number` is below PERIOD.
            let steps = number * FAST_TURNS % PERIOD;
            let fast = self.fast.sin_cos(steps).single();
            let azimuth = fast.plus(swing.azimuth_sin_cos);
            (rotors.azimuth_sin[i], rotors.azimuth_cos[i]) = (azimuth.sin, azimuth.cos);
            rotors.elevation_sin[i] = swing.elevation_sin_cos.sin;
            rotors.elevation_cos[i] = swing.elevation_sin_cos.cos;
            rotors.elevation[i] = swing.elevation;
            // From one turn up, since only numbers above zero are rounded down.
            rotors.turns[i] = swing.azimuth + (THETA / TAU + 2.0) as f32
                - steps as i32 as f32 * (1.0 / PERIOD as f32);
            rotors.up[i] = swing.gs * fast.sin + swing.gc * fast.cos;
            rotors.aside[i] = swing.hc * fast.cos + swing.hs * fast.sin;
        }
        rotors
    }
}

impl Default for Pattern {
    fn default() -> Self {
        Self::new()
    }
}

/// Values of the series at the slow rotor's angle `phi`, radians.
fn swing(phi: f64) -> Swing {
    let elevation = cosines(&E, phi - PHI[0]);
    let azimuth = sines(&A, phi - PHI[1]);
    let offsets = phi - PHI[2];
    Swing {
        elevation: elevation as f32,
        azimuth: (azimuth / TAU) as f32,
        elevation_sin_cos: SinCos::of(elevation).single(),
        azimuth_sin_cos: SinCos::of(azimuth).single(),
        gs: cosines(&GS, offsets) as f32,
        gc: sines(&GC, offsets) as f32,
        hc: cosines(&HC, offsets) as f32,
        hs: sines(&HS, offsets) as f32,
    }
}

/// Sum of coefficients times cosines of 0, 1, 2, … φ.
fn cosines(coefficients: &[f64], phi: f64) -> f64 {
    let terms = coefficients.iter().zip(0_u32..);
    terms.map(|(c, m)| c * libm::cos(f64::from(m) * phi)).sum()
}

/// Sum of coefficients times sines of 1, 2, … φ.
fn sines(coefficients: &[f64], phi: f64) -> f64 {
    let terms = coefficients.iter().zip(1_u32..);
    terms.map(|(c, m)| c * libm::sin(f64::from(m) * phi)).sum()
}

#[cfg(test)]
#[path = "../../../skips.rs"]
mod skips;

#[cfg(test)]
mod tests {
    use super::skips::shared_data;
    use super::*;

    /// Azimuth and elevation, radians, of the rays of a real sensor's pattern, if the file exists:
    /// a NumPy array of 800,000 x 2 floats.
    fn recorded() -> Option<Vec<[f32; 2]>> {
        let bytes = std::fs::read(shared_data("lidar/mid360.npy")?).unwrap();
        let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let float = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        Some(
            bytes[header..]
                .chunks_exact(8)
                .map(|c| [float(&c[..4]), float(&c[4..])])
                .collect(),
        )
    }

    fn histogram(values: impl Iterator<Item = f64>, low: f64, high: f64, bins: usize) -> Vec<f64> {
        let (mut counts, mut total) = (vec![0.0; bins], 0.0);
        for value in values {
            let bin = ((value - low) / (high - low) * bins as f64) as usize;
            counts[bin.min(bins - 1)] += 1.0;
            total += 1.0;
        }
        counts.iter().map(|c| c / total).collect()
    }

    /// Largest difference between two histograms, relative to the share of a bin if all were equal.
    fn difference(a: &[f64], b: &[f64]) -> f64 {
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
            * a.len() as f64
    }

    #[test]
    fn directions_match_a_real_sensor() {
        let Some(recorded) = recorded() else { return };
        let pattern = Pattern::new();
        let (mut worst, mut squares) = (0.0_f64, 0.0);
        for (ray, [azimuth, elevation]) in recorded.iter().enumerate() {
            let aim = pattern.firing((ray / LINES) as u64)[ray % LINES];
            let (sa, ca) = libm::sincos(f64::from(*azimuth));
            let (se, ce) = libm::sincos(f64::from(*elevation));
            let there = [ca * ce, sa * ce, se];
            let square: f64 = (0..3)
                .map(|i| (there[i] - f64::from(aim.direction[i])).powi(2))
                .sum();
            let angle = square.sqrt().to_degrees();
            worst = worst.max(angle);
            squares += angle * angle;
        }
        let rms = (squares / recorded.len() as f64).sqrt();
        assert!(rms < 0.08 && worst < 0.3, "{rms}° rms, {worst}° at worst");
    }

    #[test]
    fn histograms_of_azimuth_and_elevation_match_a_real_sensor() {
        let Some(recorded) = recorded() else { return };
        let pattern = Pattern::new();
        let ours: Vec<Aim> = (0..200_000).flat_map(|n| pattern.firing(n)).collect();
        let azimuths = histogram(recorded.iter().map(|r| f64::from(r[0])), 0.0, TAU, 72);
        let ours_azimuths = histogram(ours.iter().map(|a| f64::from(a.turn) * TAU), 0.0, TAU, 72);
        assert!(difference(&azimuths, &ours_azimuths) < 0.02);
        let (low, high) = (-0.13, 0.92);
        let elevations = histogram(recorded.iter().map(|r| f64::from(r[1])), low, high, 60);
        let ours_elevations = histogram(ours.iter().map(|a| f64::from(a.elevation)), low, high, 60);
        assert!(
            difference(&elevations, &ours_elevations) < 0.1,
            "{elevations:?} {ours_elevations:?}"
        );
    }

    #[test]
    fn the_pattern_covers_the_field_of_view_and_nothing_else() {
        let pattern = Pattern::new();
        let aims: Vec<Aim> = (0..50_000).flat_map(|n| pattern.firing(n)).collect();
        let elevations = aims.iter().map(|a| f64::from(a.elevation).to_degrees());
        let (low, high) = elevations.fold((90.0_f64, -90.0_f64), |(l, h), e| (l.min(e), h.max(e)));
        assert!(
            (-7.5..-6.8).contains(&low) && (51.8..52.5).contains(&high),
            "{low} {high}"
        );
        let length = |a: &Aim| a.direction.iter().map(|c| c * c).sum::<f32>();
        assert!(aims.iter().all(|a| (length(a) - 1.0).abs() < 1e-5));
        let cells = |count: usize| {
            let cell = |a: &Aim| {
                ((a.turn * 360.0) as usize).min(359) * 60
                    + (a.elevation.to_degrees() + 8.0) as usize
            };
            aims[..count]
                .iter()
                .map(cell)
                .collect::<std::collections::BTreeSet<_>>()
                .len()
        };
        // The pattern does not repeat, so ten scans see more cells of a degree than one.
        assert!(
            cells(200_000) as f64 > 1.3 * cells(20_000) as f64,
            "{} {}",
            cells(20_000),
            cells(200_000)
        );
    }
}
