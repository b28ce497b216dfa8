//! A first band along a polyline, before it is optimized.

use openbench_core::{MapPoint, Pose2, frames::wrap_angle};

use super::timed_poses::{TimedPose, Trajectory};
use crate::limits::Limits;

/// Distance between points of a new band, metres.
const SPACING_M: f64 = 0.1;
/// Points before and after each one that are averaged to round corners.
const ROUNDING: usize = 3;
/// Turns of more than this may go to either side, radians.
const U_TURN_RAD: f64 = 2.0;

impl Trajectory {
    /// A band along a polyline with its corners rounded, as fast as the limits of speed and turn
    /// rate allow. The robot turns on the spot before it and, with `goal_yaw` (radians), after it.
    ///
    /// It turns to the nearer side, except where it first turns by more than two radians: then to
    /// the side of the sign of `side` (left if positive), if that is not zero.
    pub fn along(
        start: Pose2,
        corners: &[MapPoint],
        goal_yaw: Option<f64>,
        limits: &Limits,
        side: f64,
    ) -> Option<Self> {
        let points = rounded(start.point(), corners);
        let mut poses = vec![TimedPose {
            pose: start,
            time: 0.0,
        }];
        for (i, pair) in points.windows(2).enumerate() {
            // The heading at a point is that from the point before it to the one after it.
            let after = points.get(i + 2).copied().unwrap_or(pair[1]);
            let chord = wrap_angle(pair[0].bearing_to(pair[1]) - poses[poses.len() - 1].pose.yaw);
            if i == 0 {
                // The long way round, to the preferred side.
                let around = chord.abs() > U_TURN_RAD && chord * side < 0.0;
                let turn = if around {
                    chord - std::f64::consts::TAU.copysign(chord)
                } else {
                    chord
                };
                turn_by(&mut poses, turn, limits);
            }
            let last = poses[poses.len() - 1];
            let turn = wrap_angle(pair[0].bearing_to(after) - last.pose.yaw);
            // Driving and turning take place at once: the slower one decides.
            let seconds =
                (pair[0].distance(pair[1]) / limits.forward).max(turn.abs() / limits.turn);
            let pose = Pose2::new(pair[1].x, pair[1].y, last.pose.yaw + turn);
            poses.push(TimedPose {
                pose,
                time: last.time + seconds,
            });
        }
        if let Some(yaw) = goal_yaw {
            let turn = wrap_angle(yaw - poses[poses.len() - 1].pose.yaw);
            turn_by(&mut poses, turn, limits);
        }
        Self::new(poses)
    }
}

/// Adds a turn on the spot, radians.
fn turn_by(poses: &mut Vec<TimedPose>, turn: f64, limits: &Limits) {
    let last = poses[poses.len() - 1];
    if turn.abs() > 1e-3 {
        let pose = Pose2 {
            yaw: last.pose.yaw + turn,
            ..last.pose
        };
        poses.push(TimedPose {
            pose,
            time: last.time + turn.abs() / limits.turn,
        });
    }
}

/// Points every [`SPACING_M`] along a polyline, each the mean of those around it.
fn rounded(start: MapPoint, corners: &[MapPoint]) -> Vec<MapPoint> {
    let mut points = vec![start];
    let mut at = start;
    for &corner in corners {
        let length = at.distance(corner);
        // Corners are often a whole number of spacings apart; rounding must not add another point.
        let count = (length / SPACING_M - 1e-6).ceil().clamp(0.0, 10_000.0) as usize;
        for k in 1..=count {
            let t = k as f64 / count as f64;
            points.push(MapPoint::new(
                at.x + t * (corner.x - at.x),
                at.y + t * (corner.y - at.y),
            ));
        }
        at = corner;
    }
    (0..points.len()).map(|i| mean_around(&points, i)).collect()
}

/// The mean of a point and those around it, as many before it as after it: the ends stay.
fn mean_around(points: &[MapPoint], i: usize) -> MapPoint {
    let reach = ROUNDING.min(i).min(points.len() - 1 - i);
    let around = &points[i - reach..=i + reach];
    let n = around.len() as f64;
    around.iter().fold(MapPoint::default(), |m, p| {
        MapPoint::new(m.x + p.x / n, m.y + p.y / n)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::timed_poses::tests::{band, limits};

    #[test]
    fn a_band_along_corners_rounds_them_and_turns_on_the_spot_at_the_end() {
        let band = band();
        let quarter = std::f64::consts::FRAC_PI_2;
        let (around, spot) = (band.duration() - quarter, band.duration() - 0.1);
        assert!(
            around < 3.0 / 0.5 + quarter && around > 2.7 / 0.5,
            "{around}"
        );
        assert!(band.pose_at(spot).point().distance(MapPoint::new(2.0, 1.0)) < 1e-9);
        let nearest = (0..100).map(|i| {
            band.pose_at(f64::from(i) * 0.1)
                .point()
                .distance(MapPoint::new(2.0, 0.0))
        });
        assert!((0.05..0.2).contains(&nearest.reduce(f64::min).unwrap()));
        assert!((band.pose_at(1.0).x - 0.5).abs() < 1e-9);
        assert!((band.velocity(0).linear - 0.5).abs() < 1e-9 && band.velocity(0).angular == 0.0);
    }

    #[test]
    fn a_u_turn_goes_to_the_preferred_side() {
        let back = [MapPoint::new(-2.0, 0.05)];
        for side in [-1.0, 1.0] {
            let band = Trajectory::along(Pose2::default(), &back, None, &limits(), side).unwrap();
            assert!(band.velocity(0).angular * side > 0.9, "{band:?}");
        }
    }
}
