//! Who moves: points where a moment ago the ground was seen to be free, gathered into bodies and followed.
//!
//! Each body has a place and a velocity that changes little from scan to scan (a Kalman filter of constant velocity, the same along both axes). A point is of the body that it is nearest to, as it moved on from the last scan: two who
//! pass each other stay two. What hangs together with a body's points, and with nobody else's, is of it too. Legs swing; where the trunk above them is seen, it says where somebody is. What a scan shows in places that were never seen free may be anything; what appears where it was
//! free has come from somewhere.

use openbench_core::{MapPoint, SimTime};

use crate::shape::Obstacle;

/// Points nearer to each other than this are of one body, metres.
const TOGETHER: f64 = 0.25;
/// Bodies wider than this are none that walk, metres.
const WIDEST: f64 = 1.2;
/// Side of the cells of which one point each is looked at, metres.
const THIN: f64 = 0.04;
/// More points than this are not of people: the estimate of the robot's pose has jumped, and all walls with it.
const MOST_POINTS: usize = 2000;
/// Least points of a body that was not known before, and of one that was; one for each small cell.
const FEWEST: usize = 3;
const FEWEST_KNOWN: usize = 2;
/// Bodies that are followed, at most.
const MOST_TRACKS: usize = 200;
/// A point is of a known person if it is so near to the middle, or hangs together with such points, metres.
const GATE: f64 = 0.45;
/// Points above the robot of a body's trunk, at least.
const TRUNK: usize = 4;
/// Points of the trunk are no further from the middle of the legs' points, metres.
const LEAN: f64 = 0.3;
/// From the side that is seen to the middle of somebody, metres.
const HALF_DEPTH: f64 = 0.1;
/// Deviation of a measured place by the trunk, and by the legs, metres.
const MEASURED: [f64; 2] = [0.04, 0.12];
/// Deviation of the acceleration, m/s².
const RESTLESS: f64 = 2.0;
/// That of who stops or turns at once, m/s².
const SUDDEN: f64 = 8.0;
/// Somebody may have stopped or turned if the squared distance to where he was foreseen, by the variance of both places together, is above this; of those who did neither it is in one look of seven.
const UNLIKELY: f64 = 4.0;
/// Deviation of the velocity of a body that was seen once, m/s.
const UNKNOWN: f64 = 1.0;
/// A body that was not seen for so many seconds is forgotten.
const FORGOTTEN: f64 = 0.8;
/// Bodies nearer to each other than this, metres, that part slower than this, m/s, are one.
const ONE: (f64, f64) = (0.3, 0.7);
/// A body is believed in once it was seen so many times,
const SEEN: u32 = 4;
/// has got this far from where it was first seen, metres,
const MOVED: f64 = 0.25;
/// and is this fast, m/s.
const FAST: f64 = 0.15;
/// Half the width of a person, metres.
const PERSON: f64 = 0.3;
/// Points of somebody's legs are no further from the middle than this, metres.
const STRIDES: f64 = 0.45;
/// Share of the difference by which a body's radius follows what is seen.
const GROWS: f64 = 0.2;

/// What a scan shows that was not there before.
#[derive(Debug, Clone, Copy)]
pub struct Newcomers<'a> {
    /// Where the sensor was.
    pub sensor: MapPoint,
    /// Points as high as the robot, where the ground was free a moment ago.
    pub low: &'a [MapPoint],
    /// Points above the robot; only those above somebody's legs count.
    pub above: &'a [MapPoint],
}

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
    /// Takes in what a scan shows, in `map`; `time` is the middle of the scan.
    pub fn update(&mut self, time: SimTime, seen: &Newcomers<'_>) {
        if time <= self.now && !self.tracks.is_empty() {
            return;
        }
        let seconds = time.since(self.now).as_secs_f64();
        self.now = time;
        self.tracks.iter_mut().for_each(|track| track.predict(seconds));
        let walking = self.walking(seen.low);
        let rest = self.follow(&walking, seen);
        for low in clusters(&rest) {
            if low.len() >= FEWEST && width(&low) <= WIDEST && self.tracks.len() < MOST_TRACKS {
                self.tracks.push(Track::new(&Body::of(&low, &[], seen.sensor), time));
            }
        }
        self.tracks.retain(|t| time.since(t.last).as_secs_f64() < FORGOTTEN);
        self.unite();
    }

    /// What hangs together and is no wider than somebody, or than as many as are known to be there: the side of a car is neither.
    fn walking(&self, low: &[MapPoint]) -> Vec<Vec<MapPoint>> {
        let fits = |cluster: &Vec<MapPoint>| {
            let is_in = |t: &&Track| cluster.iter().any(|p| apart(t.place, [p.x, p.y]) < PERSON);
            let known = self.tracks.iter().filter(|t| t.sightings > 1).filter(is_in).count();
            width(cluster) <= WIDEST * known.max(1) as f64
        };
        clusters(&thinned(low)).into_iter().filter(fits).collect()
    }

    /// Shows each body what is seen of it; what is of none is returned.
    fn follow(&mut self, walking: &[Vec<MapPoint>], seen: &Newcomers<'_>) -> Vec<MapPoint> {
        let time = self.now;
        let mut low = vec![Vec::new(); self.tracks.len()];
        let mut trunks = vec![Vec::new(); self.tracks.len()];
        let mut rest = Vec::new();
        for cluster in walking {
            let only = self.only(cluster, seen.above);
            for &point in cluster {
                match only.or_else(|| self.nearest(point)) {
                    Some(i) => low[i].push(point),
                    None => rest.push(point),
                }
            }
        }
        if !self.tracks.is_empty() {
            for &point in seen.above {
                if let Some(i) = self.nearest(point) {
                    trunks[i].push(point);
                }
            }
        }
        for (track, (low, trunk)) in self.tracks.iter_mut().zip(low.iter().zip(&trunks)) {
            if low.len() >= FEWEST_KNOWN {
                track.see(&Body::of(low, trunk, seen.sensor), time);
            }
        }
        rest
    }

    /// The body that all of a cluster is of, if there is no other and it is as wide as one. Who stops or turns is not where he was foreseen; what of him is further off than the gate is him nevertheless, unless there is a trunk above it.
    fn only(&self, cluster: &[MapPoint], above: &[MapPoint]) -> Option<usize> {
        let mut bodies = cluster.iter().filter_map(|&point| self.nearest(point));
        let first = bodies.next()?;
        let is_one = bodies.all(|body| body == first) && width(cluster) <= 2.0 * STRIDES;
        let is_far = |p: &&MapPoint| self.nearest(**p).is_none();
        let far: Vec<MapPoint> = cluster.iter().filter(is_far).copied().collect();
        let is_somebody = || {
            let middle = mean(&far);
            let is_above = |p: &&MapPoint| apart([p.x, p.y], middle) < LEAN;
            far.len() >= FEWEST && above.iter().filter(is_above).filter(is_far).count() >= TRUNK
        };
        (is_one && !is_somebody()).then_some(first)
    }

    /// The body that a point may be of.
    fn nearest(&self, point: MapPoint) -> Option<usize> {
        let off = |i: usize| apart(self.tracks[i].place, [point.x, point.y]) - self.tracks[i].radius;
        let near = (0..self.tracks.len()).filter(|&i| off(i) < GATE - PERSON);
        near.min_by(|&a, &b| off(a).total_cmp(&off(b)))
    }

    /// Two that go the same way in the same place are one, the older.
    fn unite(&mut self) {
        let mut i = 0;
        while i < self.tracks.len() {
            let track = &self.tracks[i];
            let same = |other: &Track| {
                apart(other.place, track.place) < ONE.0 && apart(other.velocity, track.velocity) < ONE.1
            };
            if self.tracks[..i].iter().any(same) {
                self.tracks.remove(i);
            } else {
                i += 1;
            }
        }
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
        self.tracks.iter().any(|t| apart(t.place, at) < t.radius + TOGETHER && t.is_believed())
    }
}

impl Track {
    fn new(body: &Body, time: SimTime) -> Self {
        Self {
            place: body.middle,
            velocity: [0.0; 2],
            variance: [body.deviation * body.deviation, UNKNOWN * UNKNOWN, 0.0],
            born: body.middle,
            radius: body.radius,
            sightings: 1,
            last: time,
        }
    }

    fn predict(&mut self, dt: f64) {
        for k in 0..2 {
            self.place[k] += self.velocity[k] * dt;
        }
        let [p, v, pv] = self.variance;
        self.variance = [p + 2.0 * dt * pv + dt * dt * v, v, pv + dt * v];
        self.spread(RESTLESS, dt);
    }

    /// What an acceleration of this deviation may have done within `dt` seconds.
    fn spread(&mut self, acceleration: f64, dt: f64) {
        let (q, [p, v, pv]) = (acceleration * acceleration * dt * dt, self.variance);
        self.variance = [p + q * dt * dt / 4.0, v + q, pv + q * dt / 2.0];
    }

    fn see(&mut self, body: &Body, time: SimTime) {
        let surprise = [0, 1].map(|k| body.middle[k] - self.place[k]);
        let noise = body.deviation * body.deviation;
        if surprise[0] * surprise[0] + surprise[1] * surprise[1] > UNLIKELY * (self.variance[0] + noise) {
            self.spread(SUDDEN, time.since(self.last).as_secs_f64());
        }
        let [p, v, pv] = self.variance;
        let total = p + noise;
        let (gain, gain_velocity) = (p / total, pv / total);
        for (k, surprise) in surprise.into_iter().enumerate() {
            self.place[k] += gain * surprise;
            self.velocity[k] += gain_velocity * surprise;
        }
        self.variance = [p * (1.0 - gain), v - gain_velocity * pv, pv * (1.0 - gain)];
        self.radius += GROWS * (body.radius - self.radius);
        self.sightings += 1;
        self.last = time;
    }

    fn is_believed(&self) -> bool {
        self.sightings >= SEEN
            && apart(self.place, self.born) > MOVED
            && apart(self.velocity, [0.0; 2]) > FAST
    }

    fn obstacle(&self, seconds: f64) -> Option<Obstacle> {
        let [x, y] = [0, 1].map(|k| self.place[k] + self.velocity[k] * seconds);
        Obstacle::new(&[MapPoint::new(x, y)], self.radius, self.velocity).ok()
    }
}

/// What one scan shows of a body.
struct Body {
    middle: [f64; 2],
    radius: f64,
    /// Of the middle, metres.
    deviation: f64,
}

impl Body {
    /// From points of it, one at least, as high as the robot, and above.
    fn of(low: &[MapPoint], trunk: &[MapPoint], sensor: MapPoint) -> Self {
        let legs = mean(low);
        // A wall beside somebody is not of the trunk.
        let is_above = |p: &&MapPoint| apart([p.x, p.y], legs) < LEAN;
        let trunk: Vec<MapPoint> = trunk.iter().filter(is_above).copied().collect();
        let (seen, deviation) =
            if trunk.len() < TRUNK { (legs, MEASURED[1]) } else { (mean(&trunk), MEASURED[0]) };
        let away = apart(seen, [sensor.x, sensor.y]).max(1e-6);
        let behind = |seen: f64, sensor: f64| seen + HALF_DEPTH * (seen - sensor) / away;
        let middle = [behind(seen[0], sensor.x), behind(seen[1], sensor.y)];
        let widest = low.iter().map(|p| apart([p.x, p.y], middle)).fold(0.0, f64::max);
        let radius = if widest < STRIDES { PERSON } else { widest.min(WIDEST / 2.0) };
        Self { middle, radius, deviation }
    }
}

/// One point of each small cell: what hangs together still does, and many points of one body cost no more than few.
fn thinned(points: &[MapPoint]) -> Vec<MapPoint> {
    let cell = |p: &MapPoint| ((p.y / THIN).floor() as i64, (p.x / THIN).floor() as i64);
    let mut kept = points.to_vec();
    kept.sort_by_key(cell);
    kept.dedup_by_key(|p| cell(p));
    kept
}

/// Points that hang together; none if there are too many points.
fn clusters(points: &[MapPoint]) -> Vec<Vec<MapPoint>> {
    if points.len() > MOST_POINTS {
        return Vec::new();
    }
    let mut rest = points.to_vec();
    let mut found = Vec::new();
    while let Some(first) = rest.pop() {
        let mut cluster = vec![first];
        let mut looked = 0;
        while looked < cluster.len() {
            let at = cluster[looked];
            looked += 1;
            let mut k = 0;
            while k < rest.len() {
                if rest[k].distance(at) < TOGETHER {
                    cluster.push(rest.swap_remove(k));
                } else {
                    k += 1;
                }
            }
        }
        found.push(cluster);
    }
    found
}

/// Twice the distance from the mean to the furthest point, metres.
fn width(points: &[MapPoint]) -> f64 {
    let middle = mean(points);
    2.0 * points.iter().map(|p| apart([p.x, p.y], middle)).fold(0.0, f64::max)
}

fn mean(points: &[MapPoint]) -> [f64; 2] {
    let n = points.len() as f64;
    points.iter().fold([0.0; 2], |m, p| [m[0] + p.x / n, m[1] + p.y / n])
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (x, y) = (a[0] - b[0], a[1] - b[1]);
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn time(scan: u32) -> SimTime {
        SimTime::ZERO + Duration::from_millis(100) * scan
    }

    fn update(tracker: &mut Tracker, scan: u32, low: &[MapPoint], above: &[MapPoint]) {
        tracker.update(time(scan), &Newcomers { sensor: MapPoint::default(), low, above });
    }

    /// The side of a round body that faces the origin.
    fn seen(middle: MapPoint, radius: f64) -> Vec<MapPoint> {
        let towards = middle.bearing_to(MapPoint::default());
        (-5..=5).map(|i| middle.offset(towards + 0.25 * f64::from(i), radius)).collect()
    }

    /// Two legs, one before the other by turns, 0.25 m to either side.
    fn legs(middle: MapPoint, scan: u32) -> Vec<MapPoint> {
        let swing = 0.25 * libm::sin(6.0 * 0.1 * f64::from(scan));
        let leg = |x: f64, y: f64| seen(MapPoint::new(middle.x + x, middle.y + y), 0.06);
        [leg(0.1, swing), leg(-0.1, -swing)].concat()
    }

    #[test]
    fn somebody_who_walks_is_followed_and_who_stands_is_not() {
        let mut tracker = Tracker::default();
        let place = |scan: u32| MapPoint::new(3.0, -1.5 + 0.12 * f64::from(scan));
        for scan in 0..20 {
            let low = [legs(place(scan), scan), seen(MapPoint::new(-2.0, 1.0), 0.2)].concat();
            update(&mut tracker, scan, &low, &seen(place(scan), 0.15));
        }
        let moving = tracker.moving(time(19));
        assert_eq!(moving.len(), 1);
        let [vx, vy] = moving[0].velocity();
        assert!(vx.abs() < 0.15 && (vy - 1.2).abs() < 0.15, "{vx} {vy}");
        assert!(moving[0].middle().distance(place(19)) < 0.1 && tracker.covers(place(19)));
        assert!(!tracker.covers(MapPoint::new(-2.0, 1.0)));
        // Half a second later he is further on; after a second unseen he is forgotten.
        assert!((tracker.moving(time(24))[0].middle().y - moving[0].middle().y - 0.6).abs() < 0.1);
        update(&mut tracker, 30, &[], &[]);
        assert!(tracker.moving(time(30)).is_empty());
    }

    #[test]
    fn who_stops_running_and_turns_back_is_not_thought_further_on() {
        let mut tracker = Tracker::default();
        let (mut along, mut speed) = (-2.7_f64, 1.8_f64);
        for scan in 0..24 {
            let place = MapPoint::new(0.7, along);
            // Arms and legs reach out before and behind.
            let low = [seen(place, 0.3), legs(place, scan)].concat();
            update(&mut tracker, scan, &low, &seen(place, 0.15));
            let moving = tracker.moving(time(scan));
            let knows =
                |o: &Obstacle| o.middle().distance(place) < 0.1 && (o.velocity()[1] - speed).abs() < 1.0;
            assert!(
                scan < 8 || speed.abs() < 0.6 || moving.len() == 1 && moving.iter().all(knows),
                "{scan}: {moving:?}"
            );
            if scan >= 15 {
                speed = (speed - 0.4).max(-1.0);
            }
            along += 0.1 * speed;
        }
    }

    #[test]
    fn who_steps_out_from_behind_somebody_is_another() {
        let mut tracker = Tracker::default();
        let place = |scan: u32, aside: f64| MapPoint::new(2.0 + aside, -1.5 + 0.1 * f64::from(scan));
        let mut out = 0.0;
        for scan in 0..30 {
            out = if scan < 12 { 0.0 } else { f64::min(out + 0.1, 0.6) };
            // He is seen as far as he is out.
            let aside: Vec<MapPoint> = seen(place(scan, out), 0.2);
            let is_out = |p: &MapPoint| p.x > 2.2;
            let low: Vec<MapPoint> = aside.iter().copied().filter(is_out).collect();
            let low = [seen(place(scan, 0.0), 0.2), low].concat();
            let above = aside.into_iter().filter(is_out).collect();
            let above: Vec<MapPoint> = [seen(place(scan, 0.0), 0.15), above].concat();
            update(&mut tracker, scan, &low, &above);
        }
        let moving = tracker.moving(time(29));
        let off = |p: MapPoint| moving.iter().map(|o| o.middle().distance(p)).fold(9.0, f64::min);
        assert!(off(place(29, 0.0)) < 0.15 && off(place(29, out)) < 0.15, "{moving:?}");
    }

    #[test]
    fn two_who_brush_past_each_other_stay_two() {
        let mut tracker = Tracker::default();
        for scan in 0..30 {
            let along = 0.1 * f64::from(scan) - 1.5;
            let (one, other) = (MapPoint::new(3.0, along), MapPoint::new(3.45, -along));
            let low = [legs(one, scan), legs(other, scan + 3)].concat();
            let above = [seen(one, 0.15), seen(other, 0.15)].concat();
            update(&mut tracker, scan, &low, &above);
            let moving = tracker.moving(time(scan));
            let off = |p: MapPoint| moving.iter().map(|o| o.middle().distance(p)).fold(9.0, f64::min);
            assert!(
                scan < 8 || (moving.len() == 2 && off(one) < 0.2 && off(other) < 0.2),
                "{scan}: {moving:?}"
            );
        }
        let mut speeds: Vec<f64> = tracker.moving(time(29)).iter().map(|o| o.velocity()[1]).collect();
        speeds.sort_by(f64::total_cmp);
        assert!((speeds[0] + 1.0).abs() < 0.2 && (speeds[1] - 1.0).abs() < 0.2, "{speeds:?}");
    }

    #[test]
    fn walls_and_single_points_are_no_bodies() {
        let wall: Vec<MapPoint> = (0..40).map(|i| MapPoint::new(2.0, 0.1 * f64::from(i))).collect();
        let mut tracker = Tracker::default();
        for scan in 0..3 {
            update(&mut tracker, scan, &wall, &[]);
            update(&mut tracker, scan, &wall[..2], &[]);
        }
        assert!(tracker.tracks.is_empty());
    }

    #[test]
    fn the_side_of_a_car_that_comes_out_from_behind_something_is_nobody() {
        let mut tracker = Tracker::default();
        for scan in 0..25 {
            let front = 0.2 * f64::from(scan);
            let side: Vec<MapPoint> = (0..60)
                .map(|i| front - 0.05 * f64::from(i))
                .filter(|x| *x > 0.0)
                .map(|x| MapPoint::new(x, 3.0))
                .collect();
            update(&mut tracker, scan, &side, &side);
            assert!(
                scan < 16 || tracker.moving(time(scan)).is_empty(),
                "{scan}: {:?}",
                tracker.moving(time(scan))
            );
        }
    }

    #[test]
    fn a_wall_beside_somebody_who_stops_does_not_lead_him_on() {
        let mut tracker = Tracker::default();
        let wall: Vec<MapPoint> = (0..400).map(|i| MapPoint::new(3.5, 0.02 * f64::from(i) - 3.0)).collect();
        let place = |scan: u32| MapPoint::new(3.0, -1.5 + 0.12 * f64::from(scan.min(15)));
        for scan in 0..30 {
            let above = [seen(place(scan), 0.15), wall.clone()].concat();
            update(&mut tracker, scan, &legs(place(scan), scan.min(15)), &above);
            let off = |o: &Obstacle| o.middle().distance(place(scan));
            assert!(scan < 8 || tracker.moving(time(scan)).iter().all(|o| off(o) < 0.25), "{scan}");
        }
        assert!(tracker.moving(time(29)).is_empty());
    }

    #[test]
    fn many_points_of_somebody_are_one_body_and_a_flood_of_points_is_nobody() {
        let dense = |n: u32, side: f64| -> Vec<MapPoint> {
            let at = |i: u32| side * f64::from(i) / f64::from(n);
            (0..n).flat_map(|i| (0..n).map(move |k| MapPoint::new(at(i), at(k)))).collect()
        };
        let found = clusters(&thinned(&dense(100, 0.3)));
        assert!(found.len() == 1 && found[0].len() < 100, "{}", found.len());
        // Islands 0.6 m apart, as when all walls have jumped.
        let flood: Vec<MapPoint> = dense(30, 18.0).iter().flat_map(|p| seen(*p, 0.1)).collect();
        let found = |points: &[MapPoint]| clusters(&thinned(points)).len();
        assert!(found(&flood[..100]) > 5 && found(&flood) == 0);
    }
}
