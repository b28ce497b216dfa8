//! Where the satellites are, and the slow part of their errors.

use nalgebra::{Rotation3, Unit, Vector3};

use crate::noise::Noise;

/// Satellites round the Earth, of which about ten stand above the mask at a time, as of GPS.
pub(super) const SATELLITES: usize = 24;
/// How fast a satellite runs across the sky, rad/s: once round in half a sidereal day.
const RATE: f64 = std::f64::consts::TAU / 43_082.0;
/// Deviation of the slow error at the zenith, metres: half of a zenith delay of 3 m that the broadcast model leaves of the
/// ionosphere, with orbit, clock and troposphere, less than a metre together.
const SLOW: f64 = 1.7;
/// Time in which the slow error forgets itself, seconds.
const MEMORY: f64 = 1800.0;

/// A constellation over a flat Earth: directions do not depend on the place in a world. It turns as one, so that its satellites
/// stay evenly spread; each stands still or runs half a degree a minute, as its distance from the axis wants it.
#[derive(Debug)]
pub(super) struct Sky {
    /// Directions at time zero: east, north, up.
    directions: [Vector3<f64>; SATELLITES],
    /// The slow errors in deviations.
    slow: [f64; SATELLITES],
    axis: Unit<Vector3<f64>>,
}

impl Sky {
    /// Satellites on a Fibonacci lattice that lies as `noise` will have it.
    pub(super) fn new(noise: &mut Noise) -> Self {
        let turned = random_rotation(noise);
        let golden = std::f64::consts::TAU * 0.618_033_988_749_895;
        let directions = std::array::from_fn(|i| {
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
        let kept = libm::exp(-seconds / MEMORY);
        for slow in &mut self.slow {
            *slow = kept * *slow + (1.0 - kept * kept).sqrt() * noise.normal();
        }
    }

    /// Directions and slow errors, in deviations, at `seconds` after the start.
    pub(super) fn at(&self, seconds: f64) -> impl Iterator<Item = (Vector3<f64>, f64)> {
        let turned = Rotation3::from_axis_angle(&self.axis, RATE * seconds);
        self.directions
            .iter()
            .zip(self.slow)
            .map(move |(direction, slow)| (turned * direction, slow))
    }
}

/// Deviation of the slow error of a satellite whose elevation has this sine, metres: what lies slantwise is longer (IS-GPS-200,
/// 20.3.3.5.2.5: `F = 1 + 16 (0.53 - E)³`, E in half circles).
pub(super) fn slow_deviation(sine: f64) -> f64 {
    let short = 0.53 - libm::asin(sine.clamp(0.0, 1.0)) / std::f64::consts::PI;
    SLOW * (1.0 + 16.0 * short * short * short)
}

fn random_rotation(noise: &mut Noise) -> Rotation3<f64> {
    // Four normal numbers are a quaternion without a preferred direction.
    let [w, x, y, z] = [0; 4].map(|_| noise.normal());
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
                    .filter(|(d, _)| d.z > super::super::MASK)
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
        for ((before, _), (after, _)) in sky.at(100.0).zip(sky.at(160.0)) {
            assert!((before.norm() - 1.0).abs() < 1e-9);
            let degrees = before.cross(&after).norm().to_degrees();
            fastest = fastest.max(degrees);
        }
        assert!((fastest - 0.5).abs() < 0.03, "{fastest}");
    }

    #[test]
    fn slow_errors_keep_their_size_and_forget() {
        let mut noise = Noise::new(2, 3);
        let mut sky = Sky::new(&mut noise);
        let (mut squares, mut products, mut count) = (0.0, 0.0, 0.0);
        for _ in 0..400 {
            let before: Vec<f64> = sky.at(0.0).map(|(_, slow)| slow).collect();
            sky.drift(MEMORY / 2.0, &mut noise);
            for ((_, after), before) in sky.at(0.0).zip(before) {
                (squares, products, count) = (
                    squares + after * after,
                    products + after * before,
                    count + 1.0,
                );
            }
        }
        assert!((squares / count - 1.0).abs() < 0.1, "{}", squares / count);
        assert!(
            (products / count - 0.607).abs() < 0.06,
            "e to the -1/2: {}",
            products / count
        );
    }

    #[test]
    fn low_satellites_err_more() {
        assert!((slow_deviation(1.0) / SLOW - 1.0).abs() < 0.01);
        assert!((slow_deviation(super::super::MASK) / SLOW - 2.71).abs() < 0.02);
    }
}
