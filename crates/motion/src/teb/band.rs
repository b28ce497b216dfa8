//! The band: where the robot is to be, and when.

use openbench_core::{MapPoint, Pose2, Velocity, frames::wrap_angle};

use crate::teb::settings::{Limits, Resolution};

/// A pose this far from where the band had it is a jump of the estimate, not a slip of the wheels: metres, radians.
const JUMP: (f64, f64) = (0.15, 0.2);

/// A pose at a time. The yaw is not wrapped: a full turn to the left is another way than one to the right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// Where, in `map`.
    pub pose: Pose2,
    /// When, seconds from now.
    pub time: f64,
}

/// Knots in the order of their times, the first one here and now.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    knots: Vec<Knot>,
}

impl Band {
    /// A band through knots; `None` unless there are two at least with rising times and finite numbers.
    pub fn new(knots: Vec<Knot>) -> Option<Self> {
        let finite = |k: &Knot| [k.pose.x, k.pose.y, k.pose.yaw, k.time].iter().all(|c| c.is_finite());
        let rising = knots.windows(2).all(|w| w[1].time > w[0].time);
        (knots.len() > 1 && rising && knots.iter().all(finite)).then_some(Self { knots })
    }

    /// Along a polyline with its corners rounded, as fast as the limits of speed and turn rate allow; turns on the spot before and after. Turns to the nearer side; where it
    /// turns by more than two radians at first, to the side of the sign of `side`, if it is not zero.
    pub fn along(
        start: Pose2,
        corners: &[MapPoint],
        goal_yaw: Option<f64>,
        limits: &Limits,
        side: f64,
    ) -> Option<Self> {
        let points = rounded(start.point(), corners);
        let mut knots = vec![Knot { pose: start, time: 0.0 }];
        for (i, pair) in points.windows(2).enumerate() {
            let after = points.get(i + 2).copied().unwrap_or(pair[1]);
            let chord = wrap_angle(pair[0].bearing_to(pair[1]) - knots[knots.len() - 1].pose.yaw);
            if i == 0 {
                let around = chord.abs() > U_TURN && chord * side < 0.0;
                let turn = if around { chord - std::f64::consts::TAU.copysign(chord) } else { chord };
                turn_by(&mut knots, turn, limits);
            }
            let last = knots[knots.len() - 1];
            let turn = wrap_angle(pair[0].bearing_to(after) - last.pose.yaw);
            let seconds = (pair[0].distance(pair[1]) / limits.forward).max(turn.abs() / limits.turn);
            let pose = Pose2::new(pair[1].x, pair[1].y, last.pose.yaw + turn);
            knots.push(Knot { pose, time: last.time + seconds });
        }
        if let Some(yaw) = goal_yaw {
            let turn = wrap_angle(yaw - knots[knots.len() - 1].pose.yaw);
            turn_by(&mut knots, turn, limits);
        }
        Self::new(knots)
    }

    /// Its knots.
    pub fn knots(&self) -> &[Knot] {
        &self.knots
    }

    /// Seconds until its end.
    pub fn duration(&self) -> f64 {
        self.knots[self.knots.len() - 1].time
    }

    /// The pose after `time` seconds, on the arc between its neighbours; the end after the end.
    pub fn pose_at(&self, time: f64) -> Pose2 {
        let after = self.knots.partition_point(|k| k.time <= time);
        if after == 0 {
            return self.knots[0].pose;
        }
        let Some(b) = self.knots.get(after) else { return self.knots[after - 1].pose };
        let a = self.knots[after - 1];
        let share = (time - a.time) / (b.time - a.time);
        on_arc(a.pose, b.pose, share)
    }

    /// The velocity on stretch `i`, from knot `i` to the next.
    pub fn velocity(&self, i: usize) -> Velocity {
        let (a, b) = (self.knots[i], self.knots[i + 1]);
        velocity(a.pose, b.pose, b.time - a.time)
    }

    /// The velocity that leads to where the band is after so many seconds, or at its end.
    pub fn velocity_until(&self, seconds: f64) -> Velocity {
        let until = seconds.min(self.duration());
        velocity(self.knots[0].pose, self.pose_at(until), until)
    }

    /// The same after a wait where it begins, seconds; `None` if that is not more than nothing.
    pub fn delayed(&self, wait: f64) -> Option<Self> {
        let later = self.knots.iter().map(|k| Knot { time: k.time + wait, ..*k });
        Self::new(std::iter::once(self.knots[0]).chain(later).collect())
    }

    /// The same way no faster than a robot's speeds allow: what a band promises beyond them it cannot keep.
    pub fn slowed(&self, limits: &Limits) -> Self {
        let mut knots = self.knots.clone();
        for i in 1..knots.len() {
            let (v, seconds) = (self.velocity(i - 1), self.knots[i].time - self.knots[i - 1].time);
            let backward = if v.linear < 0.0 { -v.linear / limits.backward.max(1e-3) } else { 0.0 };
            let over = (v.linear / limits.forward).max(backward).max(v.angular.abs() / limits.turn);
            knots[i].time = knots[i - 1].time + seconds * over.max(1.0);
        }
        Self { knots }
    }

    /// Moves every knot as `from` moves to `to`: what an estimate's jump does to all that was planned by it.
    pub fn carry(&mut self, from: Pose2, to: Pose2) {
        let turn = wrap_angle(to.yaw - from.yaw);
        let (sin, cos) = libm::sincos(turn);
        for knot in &mut self.knots {
            let (dx, dy) = (knot.pose.x - from.x, knot.pose.y - from.y);
            let yaw = knot.pose.yaw + turn;
            knot.pose = Pose2::new(to.x + cos * dx - sin * dy, to.y + sin * dx + cos * dy, yaw);
        }
    }

    /// Whether a pose is so far from where a band had the robot that the estimate has jumped.
    pub fn is_jump(expected: Pose2, pose: Pose2) -> bool {
        expected.point().distance(pose.point()) > JUMP.0 || wrap_angle(expected.yaw - pose.yaw).abs() > JUMP.1
    }

    /// What is left of the band for a robot at `pose`, `elapsed` seconds later, carried along if the estimate has jumped there.
    pub fn keep_up(&mut self, pose: Pose2, elapsed: f64) {
        // Who was held up has not jumped.
        if Self::is_jump(self.pose_at(self.progress(pose, elapsed)), pose) {
            self.carry(self.pose_at(elapsed), pose);
        }
        self.advance(pose, elapsed);
    }

    /// What is left of the band for a robot at `pose`, `elapsed` seconds later. Who was held up has as much left as before.
    pub fn advance(&mut self, pose: Pose2, elapsed: f64) {
        let elapsed = self.progress(pose, elapsed);
        let last = self.knots.len() - 1;
        // One stretch is left at least.
        let passed = self.knots.partition_point(|k| k.time <= elapsed).clamp(1, last);
        self.knots.drain(..passed - 1);
        let yaw = self.knots[0].pose.yaw + wrap_angle(pose.yaw - self.knots[0].pose.yaw);
        let start = elapsed.min(self.knots[1].time - 1e-2);
        self.knots[0] = Knot { pose: Pose2 { yaw, ..pose }, time: start };
        self.knots.iter_mut().for_each(|k| k.time -= start);
    }

    /// The time up to twice `elapsed` at which the band is nearest to `pose`; of those as near, the one nearest to `elapsed`.
    fn progress(&self, pose: Pose2, elapsed: f64) -> f64 {
        let off = |share: f64| {
            let at = self.pose_at(share * elapsed);
            let turn = TURN_WEIGHT * wrap_angle(at.yaw - pose.yaw);
            libm::hypot(at.point().distance(pose.point()), turn) + 1e-3 * (share - 1.0).abs()
        };
        let shares = (0..=8).map(|i| f64::from(i) / 4.0);
        shares.min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(1.0) * elapsed
    }

    /// Moves the end elsewhere; its yaw to the nearest turn of `yaw`.
    pub fn set_end(&mut self, point: MapPoint, yaw: Option<f64>) {
        let last = self.knots.len() - 1;
        let end = &mut self.knots[last].pose;
        let yaw = end.yaw + yaw.map_or(0.0, |yaw| wrap_angle(yaw - end.yaw));
        *end = Pose2::new(point.x, point.y, yaw);
    }

    /// Splits stretches that take too long and joins those that are too short (automatic resizing).
    pub fn resize(&mut self, resolution: &Resolution) {
        self.split(resolution);
        self.join(resolution);
    }

    fn split(&mut self, resolution: &Resolution) {
        let mut knots = Vec::with_capacity(self.knots.len() + 8);
        for pair in self.knots.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            knots.push(a);
            while knots.len() < resolution.most {
                let at: Knot = knots[knots.len() - 1];
                let step = resolution.step_at(at.time);
                let left = b.time - at.time;
                if left <= (1.0 + HYSTERESIS) * step + ROUNDED {
                    break;
                }
                let time = at.time + left / (left / step + ROUNDED).round().max(2.0);
                let share = (time - a.time) / (b.time - a.time);
                knots.push(Knot { pose: on_arc(a.pose, b.pose, share), time });
            }
        }
        knots.push(self.knots[self.knots.len() - 1]);
        self.knots = knots;
    }

    fn join(&mut self, resolution: &Resolution) {
        let mut kept = 1;
        let last = self.knots.len() - 1;
        for i in 1..last {
            let (before, after) = (self.knots[kept - 1].time, self.knots[i + 1].time);
            let step = resolution.step_at(before);
            let short = self.knots[i].time - before < (1.0 - HYSTERESIS) * step - ROUNDED;
            let room = after - before < (1.0 + HYSTERESIS) * step + ROUNDED;
            // What is left must have three knots, for a velocity and its change.
            if !(short && room && kept + last - i >= 3) {
                self.knots[kept] = self.knots[i];
                kept += 1;
            }
        }
        self.knots[kept] = self.knots[last];
        self.knots.truncate(kept + 1);
    }

    pub(crate) fn knots_mut(&mut self) -> &mut [Knot] {
        &mut self.knots
    }
}

/// Share of the wanted step by which a stretch may be longer or shorter.
const HYSTERESIS: f64 = 0.4;
/// New bands have stretches that are just so long: rounding must not tell how they are divided.
const ROUNDED: f64 = 1e-9;
/// Metres that a radian counts for where poses are compared.
const TURN_WEIGHT: f64 = 0.3;
/// Distance between points of a new band, metres.
const SPACING: f64 = 0.1;
/// Points before and after one that its mean is taken over.
const ROUNDING: usize = 3;
/// Turns of more than this may go either way, radians.
const U_TURN: f64 = 2.0;

fn turn_by(knots: &mut Vec<Knot>, turn: f64, limits: &Limits) {
    let last = knots[knots.len() - 1];
    if turn.abs() > 1e-3 {
        let pose = Pose2 { yaw: last.pose.yaw + turn, ..last.pose };
        knots.push(Knot { pose, time: last.time + turn.abs() / limits.turn });
    }
}

/// Points every [`SPACING`] along a polyline, each the mean of those around it.
fn rounded(start: MapPoint, corners: &[MapPoint]) -> Vec<MapPoint> {
    let mut points = vec![start];
    let mut at = start;
    for &corner in corners {
        let length = at.distance(corner);
        // Corners are often a whole number of spacings apart, and rounding must not make one more of them.
        let count = (length / SPACING - 1e-6).ceil().clamp(0.0, 10_000.0) as usize;
        for k in 1..=count {
            let t = k as f64 / count as f64;
            points.push(MapPoint::new(at.x + t * (corner.x - at.x), at.y + t * (corner.y - at.y)));
        }
        at = corner;
    }
    let mean = |i: usize| {
        let reach = ROUNDING.min(i).min(points.len() - 1 - i);
        let around = &points[i - reach..=i + reach];
        let n = around.len() as f64;
        around.iter().fold(MapPoint::default(), |m, p| MapPoint::new(m.x + p.x / n, m.y + p.y / n))
    };
    (0..points.len()).map(mean).collect()
}

/// The velocity that leads along an arc from one pose to another.
pub fn velocity(from: Pose2, to: Pose2, seconds: f64) -> Velocity {
    let turn = to.yaw - from.yaw;
    let (sin, cos) = libm::sincos((from.yaw + to.yaw) / 2.0);
    let chord = (to.x - from.x) * cos + (to.y - from.y) * sin;
    Velocity::new(chord * bulge(turn) / seconds, turn / seconds)
}

/// Length of an arc that turns by `turn`, as a multiple of its chord.
fn bulge(turn: f64) -> f64 {
    let half = turn / 2.0;
    if half.abs() < 1e-4 { 1.0 } else { half / libm::sin(half) }
}

/// The pose at a share of the way from `a` to `b`: straight on or around, the yaw in proportion.
pub fn on_arc(a: Pose2, b: Pose2, share: f64) -> Pose2 {
    let turn = b.yaw - a.yaw;
    let yaw = a.yaw + share * turn;
    if turn.abs() < 1e-4 {
        return Pose2::new(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), yaw);
    }
    // Chords of one circle: their lengths are as the sines of half their turns, and each is turned by half its turn.
    let ratio = libm::sin(share * turn / 2.0) / libm::sin(turn / 2.0);
    let (sin, cos) = libm::sincos((share - 1.0) * turn / 2.0);
    let (dx, dy) = (ratio * (b.x - a.x), ratio * (b.y - a.y));
    Pose2::new(a.x + cos * dx - sin * dy, a.y + sin * dx + cos * dy, yaw)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn limits() -> Limits {
        Limits { forward: 0.5, backward: 0.2, turn: 1.0, acceleration: 1.0, half_track: 0.2 }
    }

    fn band() -> Band {
        let corners = [(2.0, 0.0), (2.0, 1.0)].map(|(x, y)| MapPoint::new(x, y));
        Band::along(Pose2::default(), &corners, Some(0.0), &limits(), 1.0).unwrap()
    }

    #[test]
    fn a_band_along_corners_rounds_them_and_turns_on_the_spot_at_the_end() {
        let band = band();
        let quarter = std::f64::consts::FRAC_PI_2;
        let (around, spot) = (band.duration() - quarter, band.duration() - 0.1);
        assert!(around < 3.0 / 0.5 + quarter && around > 2.7 / 0.5, "{around}");
        assert!(band.pose_at(spot).point().distance(MapPoint::new(2.0, 1.0)) < 1e-9);
        let nearest =
            (0..100).map(|i| band.pose_at(f64::from(i) * 0.1).point().distance(MapPoint::new(2.0, 0.0)));
        assert!((0.05..0.2).contains(&nearest.reduce(f64::min).unwrap()));
        assert!((band.pose_at(1.0).x - 0.5).abs() < 1e-9);
        assert!((band.velocity(0).linear - 0.5).abs() < 1e-9 && band.velocity(0).angular == 0.0);
    }

    #[test]
    fn a_turn_about_goes_to_the_side_that_is_preferred() {
        let back = [MapPoint::new(-2.0, 0.05)];
        for side in [-1.0, 1.0] {
            let band = Band::along(Pose2::default(), &back, None, &limits(), side).unwrap();
            assert!(band.velocity(0).angular * side > 0.9, "{band:?}");
        }
    }

    #[test]
    fn resizing_keeps_ends_and_time_and_makes_steps_even() {
        let (mut band, resolution) = (band(), Resolution::default());
        let (end, duration) = (band.pose_at(99.0), band.duration());
        for _ in 0..3 {
            band.resize(&resolution);
        }
        assert_eq!((band.pose_at(99.0), band.duration()), (end, duration));
        for pair in band.knots().windows(2) {
            let (step, wanted) = (pair[1].time - pair[0].time, resolution.step_at(pair[0].time));
            assert!(step < 1.41 * wanted && step > 0.3 * wanted, "{step} for {wanted}");
        }
    }

    #[test]
    fn a_jump_carries_the_band_along() {
        let mut band = band();
        let (from, to) = (Pose2::new(0.0, 0.0, 0.0), Pose2::new(1.0, 2.0, 0.5));
        let before = from.inverse_transform(band.pose_at(3.0).point());
        band.carry(from, to);
        let after = to.inverse_transform(band.pose_at(3.0).point());
        assert!((before.0 - after.0).abs() < 1e-9 && (before.1 - after.1).abs() < 1e-9);
    }

    #[test]
    fn who_drives_on_gets_on_and_who_is_held_up_does_not() {
        for (at, left) in [(1.0, -1.0), (0.0, 0.0), (0.5, -0.5)] {
            let (mut band, whole) = (band(), band().duration());
            band.advance(band.pose_at(at), 1.0);
            assert!((band.duration() - whole - left).abs() < 0.011, "{at}");
        }
    }

    proptest! {
        #[test]
        fn points_of_an_arc_are_on_one_circle(x in -2.0..2.0_f64, turn in -3.0..3.0_f64, share in 0.0..1.0_f64) {
            // From the origin along the x axis with a constant ratio of speed and turn.
            let radius = x / turn;
            let (sin, cos) = libm::sincos(turn);
            let end = Pose2::new(radius * sin, radius * (1.0 - cos), turn);
            let found = on_arc(Pose2::default(), end, share);
            let (sin, cos) = libm::sincos(share * turn);
            prop_assert!(found.point().distance(MapPoint::new(radius * sin, radius * (1.0 - cos))) < 1e-3 * x.abs() + 1e-9);
        }

        #[test]
        fn an_advanced_band_starts_here_and_ends_there(elapsed in 0.0..20.0_f64, yaw in -9.0..9.0_f64) {
            let mut band = band();
            band.resize(&Resolution::default());
            let (end, duration) = (band.pose_at(99.0), band.duration());
            let on_it = band.pose_at(elapsed);
            let here = Pose2::new(on_it.x, on_it.y + 0.01, yaw);
            band.advance(here, elapsed);
            prop_assert!(band.knots()[0].time == 0.0 && band.knots()[0].pose.point() == here.point());
            prop_assert!(wrap_angle(band.knots()[0].pose.yaw - yaw).abs() < 1e-9);
            prop_assert!(band.knots().len() > 1 && band.knots().windows(2).all(|w| w[1].time > w[0].time));
            prop_assert!(band.pose_at(99.0) == end);
            prop_assert!(band.duration() <= duration && band.duration() > 0.0);
        }
    }
}
