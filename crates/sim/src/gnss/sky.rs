//! Where the satellites are, and the slow part of their errors.

use nalgebra::{Rotation3, Unit, Vector3};

use crate::noise::Noise;

/// Satellites round the Earth. About ten stand above the mask at a time, as with GPS.
pub(super) const SATELLITES: usize = 24;
/// Angular velocity of a satellite across the sky, rad/s: one turn in half a sidereal day.
const RATE: f64 = std::f64::consts::TAU / 43_082.0;
/// Standard deviation of the slow error at the zenith, metres. The broadcast model leaves half of a
/// zenith delay of 3 m of the ionosphere; orbit, clock and troposphere add less than a metre.
const SLOW_M: f64 = 1.7;
/// Correlation time of the slow error, seconds.
const CORRELATION_S: f64 = 1800.0;

/// A constellation over a flat Earth: directions do not depend on the place in a world. It turns as
/// one, so its satellites stay evenly spread. Each stands still or moves by up to half a degree a
/// minute, depending on its distance from the axis.
#[derive(Debug)]
pub(super) struct Sky {
    /// Directions at time zero: east, north, up.
    directions: [Vector3<f64>; SATELLITES],
    /// The slow errors in standard deviations.
    slow: [f64; SATELLITES],
    axis: Unit<Vector3<f64>>,
}

/// A satellite at an instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Satellite {
    /// Unit vector towards it: east, north, up.
    pub(super) direction: Vector3<f64>,
    /// Slow error in standard deviations.
    pub(super) slow: f64,
}

impl Sky {
    /// Satellites on a Fibonacci lattice with an orientation drawn from `noise`.
    pub(super) fn new(noise: &mut Noise) -> Self {
        let turned = random_rotation(noise);
        // The golden ratio less one, in turns: no smaller set of directions repeats.
        let golden = std::f64::consts::TAU * 0.618_033_988_749_895;
        let directions = std::array::from_fn(|i| {
            // Equal steps of z bound zones of equal area on a sphere, so the satellites are spread
            // evenly.
            let z = 1.0 - (2.0 * i as f64 + 1.0) / SATELLITES as f64;
            let (sin, cos) = libm::sincos(golden * i as f64);
            let r = (1.0 - z * z).sqrt();
            turned * Vector3::new(r * cos, r * sin, z)
        });
        let axis = random_rotation(noise) * Vector3::x_axis();
        Self {
            directions,
            slow: std::array::from_fn(|_| noise.normal()),
            axis,
        }
    }

    /// Lets the slow errors drift for `seconds`: a Gauss-Markov process of first order each.
    pub(super) fn drift(&mut self, seconds: f64, noise: &mut Noise) {
        let kept = libm::exp(-seconds / CORRELATION_S);
        for slow in &mut self.slow {
            // The share of new noise keeps the variance at 1 whatever the interval.
            *slow = kept * *slow + (1.0 - kept * kept).sqrt() * noise.normal();
        }
    }

    /// All satellites at `seconds` after the start.
    pub(super) fn at(&self, seconds: f64) -> impl Iterator<Item = Satellite> {
        let turned = Rotation3::from_axis_angle(&self.axis, RATE * seconds);
        let satellites = self.directions.iter().zip(self.slow);
        satellites.map(move |(direction, slow)| Satellite {
            direction: turned * direction,
            slow,
        })
    }
}

/// Standard deviation of the slow error of a satellite, metres, by the sine of its elevation. A
/// slanting path through the ionosphere is longer (IS-GPS-200, 20.3.3.5.2.5:
/// `F = 1 + 16 (0.53 - E)³`, E in half circles).
pub(super) fn slow_deviation(sine: f64) -> f64 {
    let short = 0.53 - libm::asin(sine.clamp(0.0, 1.0)) / std::f64::consts::PI;
    SLOW_M * (1.0 + 16.0 * short * short * short)
}

/// A rotation drawn uniformly.
fn random_rotation(noise: &mut Noise) -> Rotation3<f64> {
    // Four normal numbers are a quaternion without a preferred direction.
    let [w, x, y, z] = [0; 4].map(|_| noise.normal());
    // Axis and angle do not depend on the quaternion's length, so it needs no normalization.
    let axis = Unit::try_new(Vector3::new(x, y, z), 1e-12).unwrap_or_else(Vector3::z_axis);
    let half = libm::atan2(libm::sqrt(x * x + y * y + z * z), w);
    Rotation3::from_axis_angle(&axis, 2.0 * half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn about_ten_satellites_stand_above_the_mask_at_any_time() {
        for seed in 0..20 {
            let sky = Sky::new(&mut Noise::new(seed, 3));
            for hour in 0..12 {
                let up = sky
                    .at(f64::from(hour) * 3600.0)
                    .filter(|s| s.direction.z > super::super::MASK)
                    .count();
                assert!(
                    (6..=14).contains(&up),
                    "{up} after {hour} h with seed {seed}"
                );
            }
        }
    }

    #[test]
    fn satellites_move_half_a_degree_a_minute() {
        let sky = Sky::new(&mut Noise::new(1, 3));
        let mut fastest: f64 = 0.0;
        for (before, after) in sky.at(100.0).zip(sky.at(160.0)) {
            assert!((before.direction.norm() - 1.0).abs() < 1e-9);
            let degrees = before.direction.cross(&after.direction).norm().to_degrees();
            fastest = fastest.max(degrees);
        }
        assert!((fastest - 0.5).abs() < 0.03, "{fastest}");
    }

    #[test]
    fn slow_errors_keep_their_size_and_decorrelate() {
        let mut noise = Noise::new(2, 3);
        let mut sky = Sky::new(&mut noise);
        let (mut squares, mut products, mut count) = (0.0, 0.0, 0.0);
        for _ in 0..400 {
            let before: Vec<f64> = sky.at(0.0).map(|s| s.slow).collect();
            sky.drift(CORRELATION_S / 2.0, &mut noise);
            for (after, before) in sky.at(0.0).zip(before) {
                (squares, products, count) = (
                    squares + after.slow * after.slow,
                    products + after.slow * before,
                    count + 1.0,
                );
            }
        }
        assert!((squares / count - 1.0).abs() < 0.1, "{}", squares / count);
        assert!(
            (products / count - 0.607).abs() < 0.06,
            "not e to the -1/2: {}",
            products / count
        );
    }

    #[test]
    fn low_satellites_have_larger_errors() {
        assert!((slow_deviation(1.0) / SLOW_M - 1.0).abs() < 0.01);
        assert!((slow_deviation(super::super::MASK) / SLOW_M - 2.71).abs() < 0.02);
    }
}
