//! Moving bodies: points where a moment ago the ground was seen to be free, gathered into bodies
//! and followed.
//!
//! A point belongs to the body that it is nearest to at that body's predicted place, so that two
//! people who pass each other stay two. The points of a cluster belong to a body as a whole if they
//! are near no other. Legs swing; where points of the trunk are seen above them, these say where
//! somebody is. Points in places that were never seen free may be anything; what appears where the
//! ground was free has come from somewhere.

use openbench_core::{MapPoint, SimTime};

use super::cluster::{TOGETHER_M, apart, clusters, mean, points_within, thinned, width};
use super::track::{Body, LEAN_M, PERSON_M, STRIDES_M, TRUNK, Track, WIDEST_M};
use crate::shape::Obstacle;
use crate::vector::Vector2;

/// Least points of a body that was not known before, one for each small cell.
const FEWEST: usize = 3;
/// Least points of a body that was known.
const FEWEST_KNOWN: usize = 2;
/// Bodies that are followed, at most.
const MOST_TRACKS: usize = 200;
/// A point belongs to a known person of usual width if it is so near to the middle, metres.
const GATE_M: f64 = 0.45;
/// A body that was not seen for so many seconds is forgotten.
const FORGOTTEN_S: f64 = 0.8;
/// Two tracks nearer to each other than this, metres,
const ONE_M: f64 = 0.3;
/// whose velocities differ by less than this, m/s, are one body.
const ONE_MPS: f64 = 0.7;

/// What a scan shows that was not there before.
#[derive(Debug, Clone, Copy)]
pub struct NewPoints<'a> {
    /// Where the sensor was, in `map`.
    pub sensor: MapPoint,
    /// Points as high as the robot, where the ground was free a moment ago, in `map`.
    pub low: &'a [MapPoint],
    /// Points above the robot; only those above somebody's legs count.
    pub above: &'a [MapPoint],
}

/// Follows bodies from scan to scan.
#[derive(Debug, Clone, Default)]
pub struct Tracker {
    tracks: Vec<Track>,
    now: SimTime,
}

impl Tracker {
    /// Takes in what a scan shows; `time` is the middle of the scan.
    pub fn update(&mut self, time: SimTime, seen: &NewPoints<'_>) {
        // Tracks cannot be moved back to the time of a late scan.
        if time <= self.now && !self.tracks.is_empty() {
            return;
        }
        self.predict(time);
        let walking = self.pedestrians(seen.low);
        let rest = self.follow(&walking, seen);
        self.begin(&rest, seen.sensor);
        self.forget();
        self.unite();
    }

    /// Moves all bodies on to where they are expected.
    fn predict(&mut self, time: SimTime) {
        let seconds = time.since(self.now).as_secs_f64();
        self.now = time;
        self.tracks
            .iter_mut()
            .for_each(|track| track.predict(seconds));
    }

    /// Clusters no wider than a person, or than as many people as are known to be there: the side
    /// of a car is neither.
    fn pedestrians(&self, low: &[MapPoint]) -> Vec<Vec<MapPoint>> {
        let mut clusters = clusters(&thinned(low));
        clusters.retain(|cluster| {
            let known = self
                .tracks
                .iter()
                .filter(|t| t.sightings > 1 && is_in(t, cluster))
                .count();
            width(cluster) <= WIDEST_M * known.max(1) as f64
        });
        clusters
    }

    /// Shows each body what is seen of it; points of no body are returned.
    fn follow(&mut self, walking: &[Vec<MapPoint>], seen: &NewPoints<'_>) -> Vec<MapPoint> {
        let mut low = vec![Vec::new(); self.tracks.len()];
        let mut trunks = vec![Vec::new(); self.tracks.len()];
        let mut rest = Vec::new();
        for cluster in walking {
            // As a whole if it is of one body, else point by point: two people side by side are one
            // cluster.
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
            // Otherwise the prediction stands, until the track is forgotten.
            if low.len() >= FEWEST_KNOWN {
                track.see(&Body::of(low, trunk, seen.sensor), self.now);
            }
        }
        rest
    }

    /// The one body that all of a cluster belongs to, if it is near no other and as wide as one.
    ///
    /// Somebody who stops or turns is not where they were expected, so points beyond the gate
    /// belong to them nevertheless, unless there is a trunk above these.
    fn only(&self, cluster: &[MapPoint], above: &[MapPoint]) -> Option<usize> {
        let mut bodies = cluster.iter().filter_map(|&point| self.nearest(point));
        let first = bodies.next()?;
        let is_one = bodies.all(|body| body == first) && width(cluster) <= 2.0 * STRIDES_M;
        (is_one && !self.is_somebody_else(cluster, above)).then_some(first)
    }

    /// Whether the points of a cluster that are near no body have a trunk above them.
    fn is_somebody_else(&self, cluster: &[MapPoint], above: &[MapPoint]) -> bool {
        let is_of_nobody = |p: &MapPoint| self.nearest(*p).is_none();
        let far: Vec<MapPoint> = cluster.iter().copied().filter(is_of_nobody).collect();
        let trunk = points_within(above, mean(&far), LEAN_M).filter(is_of_nobody);
        far.len() >= FEWEST && trunk.count() >= TRUNK
    }

    /// The body that a point may belong to.
    fn nearest(&self, point: MapPoint) -> Option<usize> {
        let distances = self.tracks.iter().map(|track| track.distance_to(point));
        // The gate is measured from the middle of a person; wide bodies have a wide gate.
        let near = distances
            .enumerate()
            .filter(|(_, distance)| *distance < GATE_M - PERSON_M);
        let nearest = near.min_by(|(_, a), (_, b)| a.total_cmp(b));
        nearest.map(|(number, _)| number)
    }

    /// Begins a track for each body that was not known.
    fn begin(&mut self, rest: &[MapPoint], sensor: MapPoint) {
        for low in clusters(rest) {
            let fits = low.len() >= FEWEST && width(&low) <= WIDEST_M;
            if fits && self.tracks.len() < MOST_TRACKS {
                self.tracks
                    .push(Track::new(&Body::of(&low, &[], sensor), self.now));
            }
        }
    }

    fn forget(&mut self) {
        let now = self.now;
        self.tracks
            .retain(|track| now.since(track.last).as_secs_f64() < FORGOTTEN_S);
    }

    /// Leaves one of two tracks of the same body, the older.
    fn unite(&mut self) {
        let mut i = 0;
        while i < self.tracks.len() {
            let track = &self.tracks[i];
            // Tracks are in the order in which they began.
            if self.tracks[..i].iter().any(|older| is_same(older, track)) {
                self.tracks.remove(i);
            } else {
                i += 1;
            }
        }
    }

    /// Confirmed moving bodies as discs, where they are expected at `time`.
    pub fn moving(&self, time: SimTime) -> Vec<Obstacle> {
        let seconds = time.since(self.now).as_secs_f64();
        let confirmed = self.tracks.iter().filter(|track| track.is_confirmed());
        confirmed
            .filter_map(|track| track.obstacle(seconds))
            .collect()
    }

    /// Whether a point belongs to a confirmed moving body.
    pub fn covers(&self, point: MapPoint) -> bool {
        let at = Vector2::to(point);
        self.tracks
            .iter()
            .any(|t| apart(t.place, at) < t.radius + TOGETHER_M && t.is_confirmed())
    }
}

/// Whether a cluster has a point where a person of this track is expected.
fn is_in(track: &Track, cluster: &[MapPoint]) -> bool {
    cluster
        .iter()
        .any(|p| apart(track.place, Vector2::to(*p)) < PERSON_M)
}

/// Whether two tracks are at the same place and have the same velocity.
fn is_same(a: &Track, b: &Track) -> bool {
    apart(a.place, b.place) < ONE_M && apart(a.velocity, b.velocity) < ONE_MPS
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn time(scan: u32) -> SimTime {
        SimTime::ZERO + Duration::from_millis(100) * scan
    }

    fn update(tracker: &mut Tracker, scan: u32, low: &[MapPoint], above: &[MapPoint]) {
        tracker.update(
            time(scan),
            &NewPoints {
                sensor: MapPoint::default(),
                low,
                above,
            },
        );
    }

    /// The side of a round body that faces the origin.
    fn seen(middle: MapPoint, radius: f64) -> Vec<MapPoint> {
        let towards = middle.bearing_to(MapPoint::default());
        (-5..=5)
            .map(|i| middle.offset(towards + 0.25 * f64::from(i), radius))
            .collect()
    }

    /// Two legs, one before the other by turns, 0.25 m to either side.
    fn legs(middle: MapPoint, scan: u32) -> Vec<MapPoint> {
        let swing = 0.25 * libm::sin(6.0 * 0.1 * f64::from(scan));
        let leg = |x: f64, y: f64| seen(MapPoint::new(middle.x + x, middle.y + y), 0.06);
        [leg(0.1, swing), leg(-0.1, -swing)].concat()
    }

    #[test]
    fn somebody_who_walks_is_followed_and_a_standing_thing_is_not() {
        let mut tracker = Tracker::default();
        let place = |scan: u32| MapPoint::new(3.0, -1.5 + 0.12 * f64::from(scan));
        for scan in 0..20 {
            let low = [legs(place(scan), scan), seen(MapPoint::new(-2.0, 1.0), 0.2)].concat();
            update(&mut tracker, scan, &low, &seen(place(scan), 0.15));
        }
        let moving = tracker.moving(time(19));
        assert_eq!(moving.len(), 1);
        let velocity = moving[0].velocity();
        assert!(
            velocity.x.abs() < 0.15 && (velocity.y - 1.2).abs() < 0.15,
            "{velocity:?}"
        );
        assert!(moving[0].middle().distance(place(19)) < 0.1 && tracker.covers(place(19)));
        assert!(!tracker.covers(MapPoint::new(-2.0, 1.0)));
        // Half a second later they are further on; after a second unseen they are forgotten.
        assert!((tracker.moving(time(24))[0].middle().y - moving[0].middle().y - 0.6).abs() < 0.1);
        update(&mut tracker, 30, &[], &[]);
        assert!(tracker.moving(time(30)).is_empty());
    }

    #[test]
    fn a_runner_who_turns_back_is_not_predicted_further_on() {
        let mut tracker = Tracker::default();
        let (mut along, mut speed) = (-2.7_f64, 1.8_f64);
        for scan in 0..24 {
            let place = MapPoint::new(0.7, along);
            // Arms and legs reach out before and behind.
            let low = [seen(place, 0.3), legs(place, scan)].concat();
            update(&mut tracker, scan, &low, &seen(place, 0.15));
            let moving = tracker.moving(time(scan));
            let knows = |o: &Obstacle| {
                o.middle().distance(place) < 0.1 && (o.velocity().y - speed).abs() < 1.0
            };
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
    fn somebody_who_steps_out_from_behind_another_is_a_second_body() {
        let mut tracker = Tracker::default();
        let place =
            |scan: u32, aside: f64| MapPoint::new(2.0 + aside, -1.5 + 0.1 * f64::from(scan));
        let mut out = 0.0;
        for scan in 0..30 {
            out = if scan < 12 {
                0.0
            } else {
                f64::min(out + 0.1, 0.6)
            };
            // They are seen as far as they have stepped out.
            let aside: Vec<MapPoint> = seen(place(scan, out), 0.2);
            let is_out = |p: &MapPoint| p.x > 2.2;
            let low: Vec<MapPoint> = aside.iter().copied().filter(is_out).collect();
            let low = [seen(place(scan, 0.0), 0.2), low].concat();
            let above = aside.into_iter().filter(is_out).collect();
            let above: Vec<MapPoint> = [seen(place(scan, 0.0), 0.15), above].concat();
            update(&mut tracker, scan, &low, &above);
        }
        let moving = tracker.moving(time(29));
        let off = |p: MapPoint| {
            moving
                .iter()
                .map(|o| o.middle().distance(p))
                .fold(9.0, f64::min)
        };
        assert!(
            off(place(29, 0.0)) < 0.15 && off(place(29, out)) < 0.15,
            "{moving:?}"
        );
    }

    #[test]
    fn two_people_who_brush_past_each_other_stay_two() {
        let mut tracker = Tracker::default();
        for scan in 0..30 {
            let along = 0.1 * f64::from(scan) - 1.5;
            let (one, other) = (MapPoint::new(3.0, along), MapPoint::new(3.45, -along));
            let low = [legs(one, scan), legs(other, scan + 3)].concat();
            let above = [seen(one, 0.15), seen(other, 0.15)].concat();
            update(&mut tracker, scan, &low, &above);
            let moving = tracker.moving(time(scan));
            let off = |p: MapPoint| {
                moving
                    .iter()
                    .map(|o| o.middle().distance(p))
                    .fold(9.0, f64::min)
            };
            assert!(
                scan < 8 || (moving.len() == 2 && off(one) < 0.2 && off(other) < 0.2),
                "{scan}: {moving:?}"
            );
        }
        let mut speeds: Vec<f64> = tracker
            .moving(time(29))
            .iter()
            .map(|o| o.velocity().y)
            .collect();
        speeds.sort_by(f64::total_cmp);
        assert!(
            (speeds[0] + 1.0).abs() < 0.2 && (speeds[1] - 1.0).abs() < 0.2,
            "{speeds:?}"
        );
    }

    #[test]
    fn walls_and_single_points_are_no_bodies() {
        let wall: Vec<MapPoint> = (0..40)
            .map(|i| MapPoint::new(2.0, 0.1 * f64::from(i)))
            .collect();
        let mut tracker = Tracker::default();
        for scan in 0..3 {
            update(&mut tracker, scan, &wall, &[]);
            update(&mut tracker, scan, &wall[..2], &[]);
        }
        assert!(tracker.tracks.is_empty());
    }

    #[test]
    fn the_side_of_a_car_that_appears_is_no_pedestrian() {
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
    fn a_wall_beside_somebody_who_stops_does_not_move_their_track() {
        let mut tracker = Tracker::default();
        let wall: Vec<MapPoint> = (0..400)
            .map(|i| MapPoint::new(3.5, 0.02 * f64::from(i) - 3.0))
            .collect();
        let place = |scan: u32| MapPoint::new(3.0, -1.5 + 0.12 * f64::from(scan.min(15)));
        for scan in 0..30 {
            let above = [seen(place(scan), 0.15), wall.clone()].concat();
            update(&mut tracker, scan, &legs(place(scan), scan.min(15)), &above);
            let off = |o: &Obstacle| o.middle().distance(place(scan));
            assert!(
                scan < 8 || tracker.moving(time(scan)).iter().all(|o| off(o) < 0.25),
                "{scan}"
            );
        }
        assert!(tracker.moving(time(29)).is_empty());
    }
}
