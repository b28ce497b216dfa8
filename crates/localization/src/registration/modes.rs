//! The best poses of a vote.

use openbench_core::Pose2;
use openbench_core::frames::wrap_angle;

use super::field::{Field, UNITS_PER_NAT};
use super::vote::{Evidence, Headings, vote};

/// Modes nearer than this are one, metres,
const SAME_M: f64 = 4.0;
/// if their headings differ less than this, radians: a peak's flanks are wide.
const SAME_RAD: f64 = 0.7;
/// Modes that cost more than the best by so many units are of no interest.
const MARGIN: u16 = 2000;
/// Most candidates that are kept while voting.
const MOST_CANDIDATES: usize = 4000;
/// A robot stands at most so deep in a building of the map, metres.
const MAX_DEPTH_M: f32 = 2.0;

/// A pose that is better than those around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode {
    /// The pose, in the chart's coordinates.
    pub pose: Pose2,
    /// What it costs, nats: evidence and prior together.
    pub cost: f64,
}

/// What a vote said.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Voted {
    /// The best modes, the one that costs the least first.
    pub modes: Vec<Mode>,
    /// What each place of the area costs with its best heading, without the prior: row by row, in
    /// [units](UNITS_PER_NAT); `u16::MAX` where no robot stands.
    pub least: Vec<u16>,
}

/// The best `most` modes of the places of a field's area and of headings; nothing without evidence
/// of facades, which all poses explain equally well. `prior` is what a pose costs beforehand, nats;
/// infinite where the robot cannot be.
pub fn modes(
    field: &Field,
    evidence: &Evidence,
    headings: &Headings,
    prior: &dyn Fn(Pose2) -> f64,
    most: usize,
) -> Voted {
    if evidence.facades() == 0 {
        return Voted::default();
    }
    let allowed = allowed_places(field);
    let mut best = u16::MAX;
    let mut candidates: Vec<Mode> = Vec::new();
    // Places that are not allowed cost the most, so that they hide none beside them.
    let mut costs = vec![u16::MAX; allowed.len()];
    let mut least = costs.clone();
    vote(field, evidence, headings, &mut |slice| {
        let yaw = wrap_angle(slice.yaw);
        let pose_at = |place: usize| {
            let at = field.place(place % field.columns, place / field.columns);
            Pose2::new(at.x, at.y, yaw)
        };
        for (place, (cost, voted)) in costs.iter_mut().zip(slice.costs).enumerate() {
            if allowed[place] {
                *cost = *voted;
                if *voted < best && prior(pose_at(place)).is_finite() {
                    best = *voted;
                }
            }
        }
        for (least, cost) in least.iter_mut().zip(&costs) {
            *least = (*least).min(*cost);
        }
        let limit = best.saturating_add(MARGIN).min(u16::MAX - 1);
        for row in 0..field.rows {
            for column in 0..field.columns {
                let place = row * field.columns + column;
                let cost = costs[place];
                if cost > limit || !is_least_around(&costs, field.columns, column, row) {
                    continue;
                }
                let pose = pose_at(place);
                let cost = f64::from(cost) / UNITS_PER_NAT + prior(pose);
                if cost.is_finite() {
                    candidates.push(Mode { pose, cost });
                }
                if candidates.len() == MOST_CANDIDATES {
                    candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost));
                    candidates.truncate(MOST_CANDIDATES / 2);
                }
            }
        }
    });
    Voted {
        modes: distinct(candidates, most),
        least,
    }
}

/// Whether a robot can be at each place.
fn allowed_places(field: &Field) -> Vec<bool> {
    let rows = 0..field.rows;
    rows.flat_map(|row| {
        (0..field.columns).map(move |column| field.depth_at(column, row) <= MAX_DEPTH_M)
    })
    .collect()
}

/// The best candidates that are not near a better one.
pub(super) fn distinct(mut candidates: Vec<Mode>, most: usize) -> Vec<Mode> {
    candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut modes: Vec<Mode> = Vec::new();
    for candidate in candidates {
        if modes.len() == most {
            break;
        }
        if !modes.iter().any(|mode| is_same(mode.pose, candidate.pose)) {
            modes.push(candidate);
        }
    }
    modes
}

fn is_same(a: Pose2, b: Pose2) -> bool {
    a.is_near(b, SAME_M, SAME_RAD)
}

/// Whether a place costs less than those beside it with the same heading. Of equal ones, the first.
fn is_least_around(costs: &[u16], columns: usize, column: usize, row: usize) -> bool {
    let here = row * columns + column;
    let near = column.saturating_sub(1)..(column + 2).min(columns);
    let rows = row.saturating_sub(1)..(row + 2).min(costs.len() / columns);
    for other_row in rows {
        for other in near.clone().map(|column| other_row * columns + column) {
            let is_better = costs[other] < costs[here];
            if is_better || (other < here && costs[other] == costs[here]) {
                return false;
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use openbench_core::MapPoint;
    use openbench_geometry::Bounds;
    use proptest::prelude::*;

    use super::super::submap::Submap;
    use super::super::town::{block, chart, stretch_at, town};
    use super::*;

    /// The modes of what is seen from a pose, all headings, 30 m about the middle of the town.
    fn voted(houses: &[openbench_geometry::Polygon], pose: Pose2) -> Vec<Mode> {
        let submap = Submap::of(&[stretch_at(houses, pose)]);
        let field = Field::over(&chart(houses), square(30.0));
        modes(&field, &Evidence::of(&submap), &Headings::ALL, &anywhere, 3).modes
    }

    fn anywhere(_: Pose2) -> f64 {
        0.0
    }

    fn square(half: f64) -> Bounds {
        Bounds {
            low: MapPoint::new(-half, -half),
            high: MapPoint::new(half, half),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]

        #[test]
        fn the_best_pose_is_where_the_robot_is(
            x in -20.0..20.0_f64, y in -6.0..6.0_f64, yaw in -3.1..3.1_f64,
        ) {
            let modes = voted(&town(), Pose2::new(x, y, yaw));
            let best = modes[0].pose;
            prop_assert!(best.point().distance(MapPoint::new(x, y)) < 1.5, "{modes:?}");
            prop_assert!(wrap_angle(best.yaw - yaw).abs() < 0.1, "{modes:?}");
        }
    }

    #[test]
    fn equal_houses_give_modes_that_cost_the_same() {
        // Two rows of four, each as the other.
        let row = |y: f64| (0..4).map(move |i| block(f64::from(i) * 14.0 - 21.0, y, 8.0, 8.0));
        let houses: Vec<_> = row(-10.0).chain(row(10.0)).collect();
        let modes = voted(&houses, Pose2::new(0.0, 0.0, 0.0));
        let gap = modes[1].cost - modes[0].cost;
        assert!(gap < 2.0, "{modes:?}");
    }

    #[test]
    fn poses_that_the_prior_excludes_are_no_modes() {
        let seen = Submap::of(&[stretch_at(&town(), Pose2::new(4.0, 2.0, 0.0))]);
        let field = Field::over(&chart(&town()), square(12.0));
        let west = |pose: Pose2| if pose.x < 0.0 { 0.0 } else { f64::INFINITY };
        let modes = modes(&field, &Evidence::of(&seen), &Headings::ALL, &west, 5).modes;
        assert!(modes.len() > 1 && modes.iter().all(|mode| mode.pose.x < 0.0));
    }

    #[test]
    fn a_submap_of_nothing_prefers_no_pose() {
        let field = Field::over(&chart(&town()), square(5.0));
        let nothing = Evidence::of(&Submap::default());
        let voted = modes(&field, &nothing, &Headings::ALL, &anywhere, 9);
        assert_eq!(voted, Voted::default());
    }
}
