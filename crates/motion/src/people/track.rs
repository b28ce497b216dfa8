//! One body, followed from scan to scan by a Kalman filter of constant velocity.
//!
//! The filter is the same along both axes, so one covariance does for both.

use openbench_core::{MapPoint, SimTime};

use super::cluster::{apart, mean, points_within};
use crate::shape::Obstacle;
use crate::vector::Vector2;

/// Bodies wider than this are no pedestrians, metres.
pub(super) const WIDEST_M: f64 = 1.2;
/// Half the width of a person, metres.
pub(super) const PERSON_M: f64 = 0.3;
/// Points of somebody's legs are no further from the middle than this, metres.
pub(super) const STRIDES_M: f64 = 0.45;
/// Points above the robot of a body's trunk, at least.
pub(super) const TRUNK: usize = 4;
/// Points of the trunk are no further from the mean of the legs' points, metres.
pub(super) const LEAN_M: f64 = 0.3;

/// From the side that is seen to the middle of somebody, metres.
const HALF_DEPTH_M: f64 = 0.1;
/// Standard deviation of a place measured by the trunk, metres.
const TRUNK_DEVIATION_M: f64 = 0.04;
/// Standard deviation of a place measured by the legs, which swing, metres.
const LEGS_DEVIATION_M: f64 = 0.12;
/// Standard deviation of the acceleration, m/s².
const ACCELERATION_MPS2: f64 = 2.0;
/// Standard deviation of the acceleration of somebody who stops or turns at once, m/s².
const SUDDEN_MPS2: f64 = 8.0;
/// Normalized innovation squared above which somebody may have stopped or turned. Somebody who did
/// neither exceeds it in one scan of seven.
const UNLIKELY: f64 = 4.0;
/// Standard deviation of the velocity of a body that was seen once, m/s.
const FIRST_SPEED_MPS: f64 = 1.0;
/// Share of the difference by which a body's radius follows what is seen.
const GROWTH: f64 = 0.2;
/// A track is confirmed once it was seen so many times,
const CONFIRMED_SIGHTINGS: u32 = 4;
/// has got this far from where it was first seen, metres,
const CONFIRMED_M: f64 = 0.25;
/// and is this fast, m/s.
const CONFIRMED_MPS: f64 = 0.15;

/// Covariance of place (m) and velocity (m/s) along either axis.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Covariance {
    place: f64,
    velocity: f64,
    cross: f64,
}

/// A body that may move.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Track {
    /// In `map`, metres.
    pub(super) place: Vector2,
    /// In `map`, m/s.
    pub(super) velocity: Vector2,
    covariance: Covariance,
    /// Where it was first seen.
    born: Vector2,
    /// Metres.
    pub(super) radius: f64,
    pub(super) sightings: u32,
    /// When it was last seen.
    pub(super) last: SimTime,
}

impl Track {
    /// A body that is seen for the first time.
    pub(super) fn new(body: &Body, time: SimTime) -> Self {
        Self {
            place: body.middle,
            velocity: Vector2::ZERO,
            covariance: Covariance {
                place: body.deviation * body.deviation,
                velocity: FIRST_SPEED_MPS * FIRST_SPEED_MPS,
                cross: 0.0,
            },
            born: body.middle,
            radius: body.radius,
            sightings: 1,
            last: time,
        }
    }

    /// Where it will be `dt` seconds later.
    pub(super) fn predict(&mut self, dt: f64) {
        self.place = self.place + self.velocity * dt;
        let Covariance {
            place: p,
            velocity: v,
            cross: pv,
        } = self.covariance;
        // P becomes F P Fᵀ with F = [1, dt; 0, 1].
        self.covariance = Covariance {
            place: p + 2.0 * dt * pv + dt * dt * v,
            velocity: v,
            cross: pv + dt * v,
        };
        self.spread(ACCELERATION_MPS2, dt);
    }

    /// Adds what an acceleration of this standard deviation may have done within `dt` seconds.
    fn spread(&mut self, acceleration: f64, dt: f64) {
        // An acceleration that is constant over the step: G σ² Gᵀ with G = (dt² / 2, dt).
        let q = acceleration * acceleration * dt * dt;
        let Covariance {
            place: p,
            velocity: v,
            cross: pv,
        } = self.covariance;
        self.covariance = Covariance {
            place: p + q * dt * dt / 4.0,
            velocity: v + q,
            cross: pv + q * dt / 2.0,
        };
    }

    /// Takes in where the body is seen.
    pub(super) fn see(&mut self, body: &Body, time: SimTime) {
        let innovation = body.middle - self.place;
        let noise = body.deviation * body.deviation;
        if innovation.dot(innovation) > UNLIKELY * (self.covariance.place + noise) {
            // More uncertainty makes the gains below larger, so that the velocity follows at once.
            self.spread(SUDDEN_MPS2, time.since(self.last).as_secs_f64());
        }
        let Covariance {
            place: p,
            velocity: v,
            cross: pv,
        } = self.covariance;
        let total = p + noise;
        // Only the place is measured: the gain is the first column of P over the innovation's
        // variance.
        let (gain, gain_velocity) = (p / total, pv / total);
        self.place = self.place + innovation * gain;
        self.velocity = self.velocity + innovation * gain_velocity;
        self.covariance = Covariance {
            place: p * (1.0 - gain),
            velocity: v - gain_velocity * pv,
            cross: pv * (1.0 - gain),
        };
        self.radius += GROWTH * (body.radius - self.radius);
        self.sightings += 1;
        self.last = time;
    }

    /// Distance from a point to its side, metres; negative inside.
    pub(super) fn distance_to(&self, point: MapPoint) -> f64 {
        apart(self.place, Vector2::to(point)) - self.radius
    }

    /// Whether it surely moves.
    pub(super) fn is_confirmed(&self) -> bool {
        self.sightings >= CONFIRMED_SIGHTINGS
            && apart(self.place, self.born) > CONFIRMED_M
            && apart(self.velocity, Vector2::ZERO) > CONFIRMED_MPS
    }

    /// The disc that it covers `seconds` later.
    pub(super) fn obstacle(&self, seconds: f64) -> Option<Obstacle> {
        let place = self.place + self.velocity * seconds;
        Obstacle::new(&[place.point()], self.radius, self.velocity).ok()
    }
}

/// What one scan shows of a body.
pub(super) struct Body {
    middle: Vector2,
    /// Metres.
    radius: f64,
    /// Standard deviation of the middle, metres.
    deviation: f64,
}

impl Body {
    /// From points of it as high as the robot, one at least, and points above.
    pub(super) fn of(low: &[MapPoint], trunk: &[MapPoint], sensor: MapPoint) -> Self {
        let legs = mean(low);
        // A wall beside somebody is not of the trunk.
        let trunk: Vec<MapPoint> = points_within(trunk, legs, LEAN_M).collect();
        let (seen, deviation) = if trunk.len() < TRUNK {
            (legs, LEGS_DEVIATION_M)
        } else {
            (mean(&trunk), TRUNK_DEVIATION_M)
        };
        let away = apart(seen, Vector2::to(sensor)).max(1e-6);
        // The LiDAR sees the front of somebody; the middle is behind it.
        let middle = Vector2::new(
            seen.x + HALF_DEPTH_M * (seen.x - sensor.x) / away,
            seen.y + HALF_DEPTH_M * (seen.y - sensor.y) / away,
        );
        let widest = low
            .iter()
            .map(|p| apart(Vector2::to(*p), middle))
            .fold(0.0, f64::max);
        let radius = if widest < STRIDES_M {
            PERSON_M
        } else {
            widest.min(WIDEST_M / 2.0)
        };
        Self {
            middle,
            radius,
            deviation,
        }
    }
}
