//! Who moves: points where a moment ago the ground was seen to be free, gathered into bodies and followed.
//!
//! Each body has a place and a velocity that hardly changes (a Kalman filter of constant velocity, the same along both axes). What a scan shows in places that were never seen free may be anything; what appears where it was
//! free has come from somewhere.

use openbench_core::{MapPoint, SimTime};

use crate::shape::Obstacle;

/// Points nearer to each other than this are of one body, metres.
const TOGETHER: f64 = 0.25;
/// Bodies wider than this are none that walk, metres.
const WIDEST: f64 = 1.2;
/// Least points of a body.
const FEWEST: usize = 3;
/// A body is looked for this far from where it should be, metres.
const GATE: f64 = 0.6;
/// Deviation of a body's measured place, metres: of a body only the side that faces the robot is seen.
const MEASURED: f64 = 0.1;
/// Deviation of its acceleration, m/s².
const RESTLESS: f64 = 1.0;
/// Deviation of the velocity of a body that was seen once, m/s.
const UNKNOWN: f64 = 1.0;
/// A body that was not seen for so many seconds is forgotten.
const FORGOTTEN: f64 = 0.8;
/// A body is believed in once it was seen so many times,
const SEEN: u32 = 4;
/// has got this far from where it was first seen, metres,
const MOVED: f64 = 0.25;
/// and is this fast, m/s.
const FAST: f64 = 0.15;
/// Half a body's width at least, metres.
const SLIM: f64 = 0.25;

/// A body that may move.
#[derive(Debug, Clone, PartialEq)]
struct Track {
    place: [f64; 2],
    velocity: [f64; 2],
    /// Variances of place and velocity and their covariance.
    variance: [f64; 3],
    born: [f64; 2],
    radius: f64,
    sightings: u32,
    last: SimTime,
}

/// Follows bodies from scan to scan.
#[derive(Debug, Clone, Default)]
pub struct Tracker {
    tracks: Vec<Track>,
    now: SimTime,
}

impl Tracker {
    /// Takes in the points of a scan that are where the ground was free a moment ago, in `map`.
    pub fn update(&mut self, time: SimTime, points: &[MapPoint]) {
        if time <= self.now && !self.tracks.is_empty() {
            return;
        }
        let seconds = time.since(self.now).as_secs_f64();
        self.now = time;
        self.tracks.iter_mut().for_each(|track| track.predict(seconds));
        for body in bodies(points) {
            let off = |t: &Track| apart(t.place, body.0);
            let near =
                (0..self.tracks.len()).filter(|&i| off(&self.tracks[i]) < GATE && self.tracks[i].last < time);
            match near.min_by(|&a, &b| off(&self.tracks[a]).total_cmp(&off(&self.tracks[b]))) {
                Some(i) => self.tracks[i].see(body, time),
                None => self.tracks.push(Track::new(body, time)),
            }
        }
        self.tracks.retain(|t| time.since(t.last).as_secs_f64() < FORGOTTEN);
    }

    /// Those who are believed to move, as discs where they are by now.
    pub fn moving(&self, time: SimTime) -> Vec<Obstacle> {
        let seconds = time.since(self.now).as_secs_f64();
        let believed = self.tracks.iter().filter(|t| t.is_believed());
        believed.filter_map(|t| t.obstacle(seconds)).collect()
    }

    /// Whether a point is of somebody who is believed to move.
    pub fn covers(&self, point: MapPoint) -> bool {
        let at = [point.x, point.y];
        self.tracks.iter().any(|t| t.is_believed() && apart(t.place, at) < t.radius + TOGETHER)
    }
}

impl Track {
    fn new((place, radius): Body, time: SimTime) -> Self {
        Self {
            place,
            velocity: [0.0; 2],
            variance: [MEASURED * MEASURED, UNKNOWN * UNKNOWN, 0.0],
            born: place,
            radius: radius.max(SLIM),
            sightings: 1,
            last: time,
        }
    }

    fn predict(&mut self, dt: f64) {
        for k in 0..2 {
            self.place[k] += self.velocity[k] * dt;
        }
        let [p, v, pv] = self.variance;
        let q = RESTLESS * RESTLESS;
        self.variance = [
            p + 2.0 * dt * pv + dt * dt * v + q * dt * dt * dt * dt / 4.0,
            v + q * dt * dt,
            pv + dt * v + q * dt * dt * dt / 2.0,
        ];
    }

    fn see(&mut self, (place, radius): Body, time: SimTime) {
        let [p, v, pv] = self.variance;
        let total = p + MEASURED * MEASURED;
        let (gain, gain_velocity) = (p / total, pv / total);
        let surprise = [place[0] - self.place[0], place[1] - self.place[1]];
        for (k, surprise) in surprise.into_iter().enumerate() {
            self.place[k] += gain * surprise;
            self.velocity[k] += gain_velocity * surprise;
        }
        self.variance = [p * (1.0 - gain), v - gain_velocity * pv, pv * (1.0 - gain)];
        self.radius = self.radius.max(radius.min(WIDEST / 2.0));
        self.sightings += 1;
        self.last = time;
    }

    fn is_believed(&self) -> bool {
        let [x, y] = self.velocity;
        self.sightings >= SEEN && apart(self.place, self.born) > MOVED && libm::hypot(x, y) > FAST
    }

    fn obstacle(&self, seconds: f64) -> Option<Obstacle> {
        let [x, y] = [0, 1].map(|k| self.place[k] + self.velocity[k] * seconds);
        Obstacle::new(&[MapPoint::new(x, y)], self.radius, self.velocity).ok()
    }
}

/// Middle and radius.
type Body = ([f64; 2], f64);

/// Points that hang together, as bodies; what is too wide or has too few points is none.
fn bodies(points: &[MapPoint]) -> Vec<Body> {
    let mut rest: Vec<MapPoint> = points.to_vec();
    let mut found = Vec::new();
    while let Some(first) = rest.pop() {
        let mut body = vec![first];
        let mut looked = 0;
        while looked < body.len() {
            let at = body[looked];
            looked += 1;
            let mut k = 0;
            while k < rest.len() {
                if rest[k].distance(at) < TOGETHER {
                    body.push(rest.swap_remove(k));
                } else {
                    k += 1;
                }
            }
        }
        let n = body.len() as f64;
        let middle = body.iter().fold([0.0; 2], |m, p| [m[0] + p.x / n, m[1] + p.y / n]);
        let radius = body.iter().map(|p| apart([p.x, p.y], middle)).fold(0.0, f64::max);
        if body.len() >= FEWEST && 2.0 * radius <= WIDEST {
            found.push((middle, radius));
        }
    }
    found
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn time(scan: u32) -> SimTime {
        SimTime::ZERO + Duration::from_millis(100) * scan
    }

    /// The side of a round body that faces the origin.
    fn seen(middle: MapPoint) -> Vec<MapPoint> {
        let towards = middle.bearing_to(MapPoint::default());
        (-5..=5).map(|i| middle.offset(towards + 0.25 * f64::from(i), 0.2)).collect()
    }

    #[test]
    fn somebody_who_walks_is_followed_and_who_stands_is_not() {
        let mut tracker = Tracker::default();
        let place = |scan: u32| MapPoint::new(3.0, -1.5 + 0.12 * f64::from(scan));
        for scan in 0..20 {
            let mut points = seen(place(scan));
            points.extend(seen(MapPoint::new(-2.0, 1.0)));
            tracker.update(time(scan), &points);
        }
        let moving = tracker.moving(time(19));
        assert_eq!(moving.len(), 1);
        let [vx, vy] = moving[0].velocity();
        assert!(vx.abs() < 0.15 && (vy - 1.2).abs() < 0.15, "{vx} {vy}");
        assert!(moving[0].middle().distance(place(19)) < 0.3 && tracker.covers(place(19)));
        assert!(!tracker.covers(MapPoint::new(-2.0, 1.0)));
        // Half a second later he is further on; after a second unseen he is forgotten.
        assert!((tracker.moving(time(24))[0].middle().y - moving[0].middle().y - 0.6).abs() < 0.1);
        tracker.update(time(30), &[]);
        assert!(tracker.moving(time(30)).is_empty());
    }

    #[test]
    fn two_who_pass_each_other_keep_their_velocities() {
        let mut tracker = Tracker::default();
        for scan in 0..30 {
            let along = 0.1 * f64::from(scan) - 1.5;
            let mut points = seen(MapPoint::new(3.0, along));
            points.extend(seen(MapPoint::new(4.2, -along)));
            tracker.update(time(scan), &points);
        }
        let mut speeds: Vec<f64> = tracker.moving(time(29)).iter().map(|o| o.velocity()[1]).collect();
        speeds.sort_by(f64::total_cmp);
        assert!(
            speeds.len() == 2 && (speeds[0] + 1.0).abs() < 0.2 && (speeds[1] - 1.0).abs() < 0.2,
            "{speeds:?}"
        );
    }

    #[test]
    fn walls_and_single_points_are_no_bodies() {
        let wall: Vec<MapPoint> = (0..40).map(|i| MapPoint::new(2.0, 0.1 * f64::from(i))).collect();
        assert!(bodies(&wall).is_empty() && bodies(&wall[..2]).is_empty());
    }
}
