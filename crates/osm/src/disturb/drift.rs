//! Shifts that change slowly from place to place.

use openbench_core::MapPoint;

use crate::draws::{between, stream};

use super::purpose::Purpose;

/// Number of waves along each axis.
const WAVES: usize = 8;
/// Shortest and longest wave, metres: neighbouring nodes of a road move alike, and the ends of a
/// street do not.
const LENGTHS_M: [f64; 2] = [60.0, 240.0];

/// A field of shifts: a sum of waves with random directions, lengths and phases. Along each axis it
/// has the given standard deviation over all places.
pub(super) struct Drift {
    axes: [[Wave; WAVES]; 2],
    amplitude_m: f64,
}

#[derive(Debug, Clone, Copy)]
struct Wave {
    /// Radians a metre, east and north.
    number: [f64; 2],
    phase: f64,
}

impl Drift {
    /// A field with a standard deviation along each axis, metres.
    pub(super) fn new(deviation_m: f64, seed: u64) -> Self {
        let mut draws = stream(seed, Purpose::Roads as u64, 0);
        let mut wave = || {
            let tau = std::f64::consts::TAU;
            let direction = between(&mut draws, 0.0, tau);
            let number = tau / between(&mut draws, LENGTHS_M[0], LENGTHS_M[1]);
            let (sin, cos) = libm::sincos(direction);
            Wave {
                number: [number * cos, number * sin],
                phase: between(&mut draws, 0.0, tau),
            }
        };
        Self {
            axes: std::array::from_fn(|_| std::array::from_fn(|_| wave())),
            // The square of a cosine is a half on average.
            amplitude_m: deviation_m * libm::sqrt(2.0 / WAVES as f64),
        }
    }

    /// Where a point comes to be.
    pub(super) fn apply(&self, point: MapPoint) -> MapPoint {
        let along = |waves: &[Wave; WAVES]| {
            let waves = waves.iter().map(|wave| {
                let [x, y] = wave.number;
                libm::cos(x * point.x + y * point.y + wave.phase)
            });
            self.amplitude_m * waves.sum::<f64>()
        };
        MapPoint::new(
            point.x + along(&self.axes[0]),
            point.y + along(&self.axes[1]),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_field_has_its_deviation_and_is_smooth() {
        let drift = Drift::new(2.0, 3);
        let (mut squares, mut count) = (0.0, 0.0);
        for i in 0..100 {
            for j in 0..100 {
                let at = MapPoint::new(f64::from(i) * 37.0, f64::from(j) * 37.0);
                let moved = drift.apply(at);
                squares += (moved.x - at.x) * (moved.x - at.x);
                count += 1.0;
                let next = drift.apply(MapPoint::new(at.x + 1.0, at.y));
                assert!((next.distance(moved) - 1.0).abs() < 0.5);
            }
        }
        let deviation = libm::sqrt(squares / count);
        assert!((deviation - 2.0).abs() < 0.3, "{deviation}");
    }
}
