//! A lane or a turn: its course and its speed limits.

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2};
use openbench_geometry::line::length;

use super::polyline::resampled;

/// Distance between the points of a piece, about, metres.
pub(super) const SPACING_M: f64 = 1.0;
/// Lateral acceleration in bends, m/s²: comfortable for drivers.
const LATERAL: f64 = 2.0;
/// Deceleration before bends, m/s².
const BEFORE_BENDS: f64 = 1.5;
/// Lowest limit in bends, m/s.
const SLOWEST: f64 = 1.5;

/// A lane or a turn.
#[derive(Debug, Clone, Default)]
pub(super) struct Piece {
    pub points: Vec<MapPoint>,
    /// Speed limit at each point, m/s, with the bends there and ahead.
    speeds: Vec<f64>,
    spacing: f64,
    /// Metres.
    pub length: f64,
    /// From a lane: turns; from a turn: the one lane.
    pub next: Vec<u32>,
    /// Turns that must not be driven at the same time.
    pub conflicts: Vec<u32>,
    /// Whether no turn leads here: cars come from outside.
    pub is_entry: bool,
}

impl Piece {
    /// A piece along a line with a speed limit in m/s.
    pub fn new(line: &[MapPoint], limit: f64) -> Self {
        let points = resampled(line, SPACING_M);
        let length = length(&points);
        let spacing = length / (points.len() - 1) as f64;
        // First what each bend allows, then what braking before it requires.
        let mut speeds = vec![limit; points.len()];
        for i in 2..points.len().saturating_sub(2) {
            // Over two segments on either side, since single bearings of resampled points are
            // noisy. The middles of the two stretches are two spacings apart.
            let turn = points[i].bearing_to(points[i + 2]) - points[i - 2].bearing_to(points[i]);
            let curvature = wrap_angle(turn).abs() / (2.0 * spacing);
            speeds[i] = limit
                // The lateral acceleration is v² times the curvature.
                .min((LATERAL / curvature.max(1e-3)).sqrt())
                .max(SLOWEST);
        }
        // From the end on: each point limits the speed at the one before it.
        for i in (1..speeds.len()).rev() {
            speeds[i - 1] = speeds[i - 1].min(slowing(speeds[i], spacing));
        }
        Self {
            points,
            speeds,
            spacing,
            length,
            ..Self::default()
        }
    }

    /// Pose of a car that has driven `s` metres on this piece.
    pub fn pose(&self, s: f64) -> Pose2 {
        // Below the last point, so that a segment begins at `i`.
        let at = (s / self.spacing).clamp(0.0, (self.points.len() - 1) as f64 - 1e-9);
        let (i, share) = (at as usize, at.fract());
        let (a, b) = (self.points[i], self.points[i + 1]);
        // Headings of segments jump at points; a car's heading must not.
        let here = a.bearing_to(b);
        // Headings change gradually from the middle of one segment to the middle of the next.
        let (j, part) = if share < 0.5 {
            (i.max(1) - 1, 0.5 - share)
        } else {
            (i + 1, share - 0.5)
        };
        let beside = match self.points.get(j..j + 2) {
            Some(w) if j != i => w[0].bearing_to(w[1]),
            _ => here,
        };
        let yaw = wrap_angle(here + part * wrap_angle(beside - here));
        Pose2::new(a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share, yaw)
    }

    /// Speed limit after `s` metres, m/s.
    pub fn speed(&self, s: f64) -> f64 {
        let i = (s / self.spacing).max(0.0) as usize;
        self.speeds[i.min(self.speeds.len() - 1)]
    }

    /// Whether cars on both pieces would touch: some of their points are nearer than `apart`
    /// metres.
    pub fn meets(&self, other: &Self, apart: f64) -> bool {
        self.points
            .iter()
            .any(|p| other.points.iter().any(|q| p.distance(*q) < apart))
    }
}

/// The speed from which a car slows down to `speed` within `distance` metres, m/s.
pub(super) fn slowing(speed: f64, distance: f64) -> f64 {
    (speed * speed + 2.0 * BEFORE_BENDS * distance.max(0.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cars_slow_down_before_a_bend() {
        let bend = [
            MapPoint::new(0.0, 0.0),
            MapPoint::new(30.0, 0.0),
            MapPoint::new(30.0, 30.0),
        ];
        let piece = Piece::new(&bend, 8.0);
        assert!(piece.speed(30.0) < 3.0 && piece.speed(0.0) == 8.0);
        assert!(
            piece.speed(25.0) > piece.speed(28.0),
            "slower and slower towards the bend"
        );
        let turning = piece.pose(30.0).yaw;
        assert!((0.1..1.5).contains(&turning), "{turning}");
    }
}
