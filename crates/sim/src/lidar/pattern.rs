//! The rosette of the Livox MID-360.
//!
//! Two rotors turn the four beams: one at 182.4 turns a second, which gives the azimuth, one at 10 turns a second, which swings the beams up and
//! down and to the side. Fourier series of the slow rotor's angle φ describe the swing of the middle of the four beams; the four stand a
//! little apart in a fixed direction, which the fast rotor's angle θ turns round:
//!
//! ```text
//! elevation = E(φ) + k (Gs(φ) sin θ + Gc(φ) cos θ)
//! azimuth   = θ + A(φ) + k (Hc(φ) cos θ + Hs(φ) sin θ),   k = 1, 1/3, -1/3, -1 for the four lines
//! ```
//!
//! The coefficients were fitted to 800,000 directions of a real sensor's pattern (the MID-360 file of the PyPI package `mujoco-lidar`): off by
//! 0.05° in the mean square and at most 0.25°; the sensor's own angular precision is 0.15°. The fast rotor makes 729 2/3 turns in
//! 4 seconds, so the pattern comes round after 12.

use std::f64::consts::TAU;
use std::ops::{Add, Mul, Sub};

use crate::rounding::whole;

/// Lines, which fire at the same instant.
pub const LINES: usize = 4;
/// Time between two firings, nanoseconds.
pub const FIRING_NS: u64 = 20_000;
/// Firings in a turn of the slow rotor.
const SLOW_TURN: u64 = 5_000;
/// Firings until the pattern comes round, and turns of the fast rotor in that time.
const PERIOD: u64 = 600_000;
const FAST_TURNS: u64 = 2_189;
/// Where each line stands.
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

/// Firings that are aimed together, lane by lane.
pub const VOLLEY: usize = 32;

/// What the series amount to at one angle of the slow rotor.
#[derive(Debug, Clone, Copy)]
struct Swing {
    elevation: f32,
    /// Turns.
    azimuth: f32,
    /// Sines and cosines of both.
    elevation_sin_cos: (f32, f32),
    azimuth_sin_cos: (f32, f32),
    gs: f32,
    gc: f32,
    hc: f32,
    hs: f32,
}

/// The pattern, its series tabulated.
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
    /// What the outermost line's offset is in elevation and azimuth, radians.
    up: [f32; VOLLEY],
    aside: [f32; VOLLEY],
}

/// Sines and cosines of the fast rotor's angle: that of whole thousands of steps, turned on by the rest of the steps.
#[derive(Debug, Clone)]
struct FastRotor {
    thousands: Vec<(f64, f64)>,
    rest: Vec<(f64, f64)>,
}

impl FastRotor {
    const REST: u64 = 1_000;

    fn new() -> Self {
        let turned = |steps: u64| -(steps as f64) / PERIOD as f64 * TAU;
        Self {
            thousands: (0..PERIOD / Self::REST)
                .map(|i| libm::sincos(THETA + turned(i * Self::REST)))
                .collect(),
            rest: (0..Self::REST).map(|i| libm::sincos(turned(i))).collect(),
        }
    }

    /// Sine and cosine after so many steps, of which [`PERIOD`] are a turn.
    #[inline(always)]
    fn sin_cos(&self, steps: u64) -> (f64, f64) {
        sum(
            self.thousands[(steps / Self::REST) as usize],
            self.rest[(steps % Self::REST) as usize],
        )
    }
}

/// Sine and cosine of the sum of two angles from those of each.
#[inline(always)]
fn sum<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>>(
    (sin_a, cos_a): (T, T),
    (sin_b, cos_b): (T, T),
) -> (T, T) {
    (sin_a * cos_b + cos_a * sin_b, cos_a * cos_b - sin_a * sin_b)
}

/// Where a ray points.
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

    /// Where the four lines point at a firing, counted from 0.
    pub fn firing(&self, number: u64) -> [Aim; LINES] {
        self.volley(number)[0]
    }

    /// Where they point at that firing and those after it.
    #[inline(always)]
    pub fn volley(&self, first: u64) -> [[Aim; LINES]; VOLLEY] {
        let rotors = self.rotors(first);
        let mut aims = [[Aim::default(); LINES]; VOLLEY];
        for (line, k) in OFFSETS.into_iter().enumerate() {
            let (mut x, mut y, mut z) = ([0.0; VOLLEY], [0.0; VOLLEY], [0.0; VOLLEY]);
            let (mut turns, mut elevation) = ([0.0; VOLLEY], [0.0; VOLLEY]);
            for i in 0..VOLLEY {
                let (up, aside) = (k * rotors.up[i], k * rotors.aside[i]);
                let (sin_el, cos_el) = sum(
                    (rotors.elevation_sin[i], rotors.elevation_cos[i]),
                    small(up),
                );
                let (sin_az, cos_az) =
                    sum((rotors.azimuth_sin[i], rotors.azimuth_cos[i]), small(aside));
                let turn = rotors.turns[i] + aside * (1.0 / TAU) as f32;
                (x[i], y[i], z[i]) = (cos_az * cos_el, sin_az * cos_el, sin_el);
                (turns[i], elevation[i]) =
                    (turn - whole(turn) as i32 as f32, rotors.elevation[i] + up);
            }
            for (i, aims) in aims.iter_mut().enumerate() {
                aims[line] = Aim {
                    direction: [x[i], y[i], z[i]],
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
            // The fast rotor turns clockwise.
            let steps = number * FAST_TURNS % PERIOD;
            let (sin, cos) = self.fast.sin_cos(steps);
            let (sin, cos) = (sin as f32, cos as f32);
            (rotors.azimuth_sin[i], rotors.azimuth_cos[i]) = sum((sin, cos), swing.azimuth_sin_cos);
            (rotors.elevation_sin[i], rotors.elevation_cos[i]) = swing.elevation_sin_cos;
            rotors.elevation[i] = swing.elevation;
            // From one turn up, since only what is above zero is rounded down.
            rotors.turns[i] = swing.azimuth + (THETA / TAU + 2.0) as f32
                - steps as i32 as f32 * (1.0 / PERIOD as f32);
            rotors.up[i] = swing.gs * sin + swing.gc * cos;
            rotors.aside[i] = swing.hc * cos + swing.hs * sin;
        }
        rotors
    }
}

impl Default for Pattern {
    fn default() -> Self {
        Self::new()
    }
}

fn swing(phi: f64) -> Swing {
    let cosines = |c: &[f64], phi: f64| series(c, 0, |m| libm::cos(m * phi));
    let sines = |c: &[f64], phi: f64| series(c, 1, |m| libm::sin(m * phi));
    let (elevation, azimuth) = (cosines(&E, phi - PHI[0]), sines(&A, phi - PHI[1]));
    let offsets = phi - PHI[2];
    let sin_cos = |angle: f64| {
        let (sin, cos) = libm::sincos(angle);
        (sin as f32, cos as f32)
    };
    Swing {
        elevation: elevation as f32,
        azimuth: (azimuth / TAU) as f32,
        elevation_sin_cos: sin_cos(elevation),
        azimuth_sin_cos: sin_cos(azimuth),
        gs: cosines(&GS, offsets) as f32,
        gc: sines(&GC, offsets) as f32,
        hc: cosines(&HC, offsets) as f32,
        hs: sines(&HS, offsets) as f32,
    }
}

fn series(coefficients: &[f64], first: u32, wave: impl Fn(f64) -> f64) -> f64 {
    coefficients
        .iter()
        .zip(first..)
        .map(|(c, m)| c * wave(f64::from(m)))
        .sum()
}

/// Sine and cosine of an angle below 0.1, to 1e-7.
#[inline(always)]
fn small(angle: f32) -> (f32, f32) {
    let square = angle * angle;
    (
        angle * (1.0 - square * (1.0 / 6.0)),
        1.0 - square * 0.5 * (1.0 - square * (1.0 / 12.0)),
    )
}

#[cfg(test)]
#[allow(clippy::print_stderr)]
mod tests {
    use super::*;

    /// Azimuth and elevation, radians, of the rays of a real sensor's pattern, if the file is there: a NumPy array of 800,000 x 2 floats.
    fn recorded() -> Option<Vec<[f32; 2]>> {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../../shared/data/lidar/mid360.npy"
        );
        let Ok(bytes) = std::fs::read(path) else {
            eprintln!("SKIPPED: {path} is not there");
            return None;
        };
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

    /// Largest difference between two histograms, as a share of the even share of a bin.
    fn difference(a: &[f64], b: &[f64]) -> f64 {
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
            * a.len() as f64
    }

    #[test]
    fn directions_are_those_of_a_real_sensor() {
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
    fn histograms_of_azimuth_and_elevation_are_those_of_a_real_sensor() {
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
    fn it_covers_the_field_of_view_and_nothing_else() {
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
        // Without repeating, longer looks see more: cells of a degree, after one scan and after ten.
        assert!(
            cells(200_000) as f64 > 1.3 * cells(20_000) as f64,
            "{} {}",
            cells(20_000),
            cells(200_000)
        );
    }
}
