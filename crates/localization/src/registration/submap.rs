//! The last metres of the way as evidence about where the robot is.

use openbench_core::{MapPoint, Pose2};

use super::columns::{CELL_M, Facade};
use super::stretch::{Panorama, Stretch};

/// Facades farther from the robot are left out, and so are walls, metres.
pub(super) const REACH_M: f64 = 60.0;

/// Stretches, in the frame of the robot at the end of the newest.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Submap {
    /// Pieces of facades, one for each half metre.
    pub facades: Vec<Facade>,
    /// What was free.
    pub panoramas: Vec<Panorama>,
}

impl Submap {
    /// Joins stretches; the last one is the newest.
    pub fn of(stretches: &[Stretch]) -> Self {
        let Some(newest) = stretches.last() else {
            return Self::default();
        };
        let mut submap = Self::default();
        // From the frame of the stretches to that of the robot.
        let by = Pose2::default().seen_from(newest.end);
        for stretch in stretches.iter().map(|stretch| stretch.moved(by)) {
            let facades = stretch.facades.into_iter();
            let is_near = |facade: &Facade| facade.at.distance(MapPoint::default()) < REACH_M;
            submap.facades.extend(facades.filter(is_near));
            submap.panoramas.extend(stretch.panoramas);
        }
        submap.facades = joined(submap.facades);
        submap
    }
}

/// Facades of the same half metre as one, which has their views together.
fn joined(mut facades: Vec<Facade>) -> Vec<Facade> {
    let cell = |facade: &Facade| {
        let index = |value: f64| (value / CELL_M).floor() as i64;
        (index(facade.at.y), index(facade.at.x))
    };
    facades.sort_by_key(cell);
    facades
        .chunk_by(|a, b| cell(a) == cell(b))
        .map(|same| {
            let n = same.len() as f64;
            let x = same.iter().map(|one| one.at.x).sum::<f64>() / n;
            let y = same.iter().map(|one| one.at.y).sum::<f64>() / n;
            let best = same.iter().max_by_key(|one| one.views).unwrap_or(&same[0]);
            Facade {
                at: MapPoint::new(x, y),
                facing: best.facing,
                views: same
                    .iter()
                    .fold(0, |sum: u8, one| sum.saturating_add(one.views)),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::town::{stretch_at, town};
    use super::*;

    #[test]
    fn stretches_from_two_places_show_the_same_walls() {
        let here = Pose2::new(2.0, 1.0, 0.5);
        let first = stretch_at(&town(), Pose2::default());
        // The second stretch begins its own `odom`; here both have one.
        let mut second = stretch_at(&town(), here);
        for facade in &mut second.facades {
            facade.at = here.transform(facade.at.x, facade.at.y);
            facade.facing += here.yaw;
        }
        second.end = here;
        let alone = Submap::of(std::slice::from_ref(&second));
        let both = Submap::of(&[first, second]);
        assert!(both.facades.len() > alone.facades.len());
        assert_eq!(both.panoramas.len(), 2);
        let again = both
            .facades
            .iter()
            .filter(|facade| facade.views == 2)
            .count();
        assert!(again > 20, "{again} pieces were seen twice");
        // The robot is the origin, at the end of the newest.
        let (x, y) = here.inverse_transform(MapPoint::default());
        assert!(both.panoramas[0].from.distance(MapPoint::new(x, y)) < 1e-9);
    }

    #[test]
    fn facades_far_from_the_robot_are_left_out() {
        let mut seen = stretch_at(&town(), Pose2::default());
        seen.end = Pose2::new(-35.0, 0.0, 0.0);
        let submap = Submap::of(std::slice::from_ref(&seen));
        assert!(submap.facades.len() < seen.facades.len() && !submap.facades.is_empty());
        let mut away = submap
            .facades
            .iter()
            .map(|facade| facade.at.distance(MapPoint::default()));
        assert!(away.all(|metres| metres < REACH_M));
    }

    #[test]
    fn no_stretches_make_an_empty_submap() {
        assert_eq!(Submap::of(&[]), Submap::default());
    }
}
