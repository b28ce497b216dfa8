//! A pose made exact: facades of a submap on walls of the map.
//!
//! Gauss-Newton on distances from points to walls, with a robust kernel. A building of a map is
//! displaced as a whole, and by more than its walls are rough. Each matched building therefore has
//! an offset with a prior, which is estimated with the pose. Several buildings decide together
//! where the robot is, and the distance to the wall in front of it is known better than either.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use openbench_core::Pose2;
use openbench_core::frames::wrap_angle;

use super::chart::Chart;
use super::matching::{BuildingEvidence, FacadeNoise, Matching};
use super::submap::Submap;

/// Most steps.
const MAX_STEPS: usize = 20;
/// The gate narrows over so many.
const NARROWING_STEPS: f64 = 6.0;
/// A step shorter than this is the last, metres and radians.
const SMALL: f64 = 1e-3;

/// What is assumed of map and facades.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assumptions {
    /// Standard deviation of a building's offset along each axis, metres: what is expected before
    /// any building is seen.
    pub building_m: f64,
    /// How many buildings that expectation is worth.
    pub expected_buildings: f64,
    /// How exactly facades are on their walls.
    pub facade: FacadeNoise,
    /// Facades farther than this from each wall match none at the first step, metres.
    pub first_gate_m: f64,
    /// Facades farther than this from each wall match none at the last step, metres.
    pub last_gate_m: f64,
}

impl Assumptions {
    /// Every building is where the map shows it.
    pub const EXACT_MAP: Self = Self {
        building_m: 0.02,
        // However many are seen, the estimate stays there.
        expected_buildings: 1e9,
        ..Self::DEFAULT
    };

    const DEFAULT: Self = Self {
        building_m: 1.0,
        expected_buildings: 0.5,
        facade: FacadeNoise {
            metres: 0.3,
            independence: 0.2,
        },
        first_gate_m: 4.0,
        last_gate_m: 1.5,
    };
}

impl Default for Assumptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A refined pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    /// The pose, in the chart's coordinates.
    pub pose: Pose2,
    /// Information about x and y of the chart and about yaw; offsets have their prior only.
    pub information: Matrix3<f64>,
    /// Standard deviation of the buildings' offsets as estimated, metres.
    pub building_m: f64,
    /// What each building says.
    pub buildings: Vec<BuildingEvidence>,
    /// How close facades are to their walls, from 0, where none is within the gate, to 1.
    pub closeness: f64,
    /// What the distances of all facades from walls cost, nats: a robust half of squared errors, in
    /// which one facade that is on no wall costs no more than one at the gate.
    pub misfit: f64,
    /// Number of facades that match a wall.
    pub matched: usize,
    /// Number of all facades.
    pub facades: usize,
}

impl Refined {
    /// The offset of each building of a chart of so many; zero where none of its walls is seen.
    pub fn offsets(&self, buildings: usize) -> Vec<Vector2<f64>> {
        let mut offsets = vec![Vector2::zeros(); buildings];
        for building in &self.buildings {
            offsets[building.building] = building.offset;
        }
        offsets
    }

    /// How close the facades that match a wall are to it, from 0 to 1.
    pub fn closeness_of_matched(&self) -> f64 {
        self.closeness * self.facades as f64 / self.matched.max(1) as f64
    }

    /// Information about the position along the direction in which it is known least, 1/m².
    pub fn weakest(&self) -> f64 {
        let position = self.information.fixed_view::<2, 2>(0, 0).into_owned();
        position.symmetric_eigenvalues().min().max(0.0)
    }
}

/// Refines a pose; `None` if no facade matches a wall, or the pose is not finite.
pub fn refine(
    chart: &Chart,
    submap: &Submap,
    start: Pose2,
    assumed: &Assumptions,
) -> Option<Refined> {
    let is_finite = start.x.is_finite() && start.y.is_finite() && start.yaw.is_finite();
    if !is_finite {
        return None;
    }
    let mut problem = Problem {
        matching: Matching::about(chart, start),
        building_m: assumed.building_m,
    };
    let mut pose = start;
    for step in 0..MAX_STEPS {
        let share = (step as f64 / NARROWING_STEPS).min(1.0);
        let gate = assumed.first_gate_m + share * (assumed.last_gate_m - assumed.first_gate_m);
        let matching = &mut problem.matching;
        matching.linearise(&submap.facades, pose, gate, assumed.facade);
        let change = problem.solve()?;
        pose = Pose2::new(
            pose.x + change.x,
            pose.y + change.y,
            wrap_angle(pose.yaw + change.z),
        );
        if share < 1.0 {
            continue;
        }
        let before = problem.building_m;
        problem.estimate_building_m(assumed);
        let is_settled = (problem.building_m - before).abs() < 0.02 * before;
        if is_settled && change.norm() < SMALL {
            break;
        }
    }
    // Evidence is about the pose that is returned, not about the one before the last step.
    let gate = assumed.last_gate_m;
    let matching = &mut problem.matching;
    let matches = matching.linearise(&submap.facades, pose, gate, assumed.facade);
    let facades = submap.facades.len();
    (matches.count > 0).then(|| Refined {
        pose,
        information: problem.information(),
        building_m: problem.building_m,
        buildings: problem.matching.matched(),
        closeness: matches.closeness / facades as f64,
        misfit: matches.misfit,
        matched: matches.count,
        facades,
    })
}

/// The equations, and what is assumed of offsets.
struct Problem {
    matching: Matching,
    /// Standard deviation of offsets, metres.
    building_m: f64,
}

impl Problem {
    /// The step of the pose; offsets take theirs.
    fn solve(&mut self) -> Option<Vector3<f64>> {
        let prior = self.prior();
        let mut reduced = Matrix3::zeros();
        let mut gradient = Vector3::zeros();
        for building in &self.matching.buildings {
            let inverse = (building.own + Matrix2::identity() * prior).try_inverse()?;
            let own_gradient = building.own_gradient + building.offset * prior;
            reduced += building.pose - building.mixed * inverse * building.mixed.transpose();
            gradient += building.pose_gradient - building.mixed * inverse * own_gradient;
        }
        // Directions that nothing measures stay.
        let damped = reduced + Matrix3::from_diagonal(&Vector3::new(1e-3, 1e-3, 1e-1));
        let change = -damped.try_inverse()? * gradient;
        for building in &mut self.matching.buildings {
            let inverse = (building.own + Matrix2::identity() * prior).try_inverse()?;
            let own_gradient = building.own_gradient + building.offset * prior;
            building.offset -= inverse * (own_gradient + building.mixed.transpose() * change);
        }
        change
            .iter()
            .all(|value| value.is_finite())
            .then_some(change)
    }

    /// Inverse of the offsets' variance.
    fn prior(&self) -> f64 {
        1.0 / (self.building_m * self.building_m)
    }

    /// How large offsets are, from those that were found and from what was expected: a step of
    /// expectation maximization.
    fn estimate_building_m(&mut self, assumed: &Assumptions) {
        let prior = self.prior();
        let pose = self.information().try_inverse();
        let mut count = assumed.expected_buildings;
        let mut sum = count * assumed.building_m * assumed.building_m;
        let seen = self.matching.buildings.iter();
        for building in seen.filter(|building| building.facades > 0) {
            // Offsets are pulled towards zero, and the pose follows those of buildings near it:
            // what is not known of both counts as well. At most as much as the prior leaves, and
            // none where rounding makes a covariance of a pose that nothing constrains negative.
            let own = (building.own + Matrix2::identity() * prior).try_inverse();
            let unknown = own.zip(pose).map_or(2.0 / prior, |(own, pose)| {
                let by_pose = own * building.mixed.transpose();
                (own + by_pose * pose * by_pose.transpose()).trace()
            });
            sum += 0.5 * (building.offset.norm_squared() + unknown.clamp(0.0, 2.0 / prior));
            count += 1.0;
        }
        if count > 0.0 {
            self.building_m = (sum / count).sqrt();
        }
    }

    fn information(&self) -> Matrix3<f64> {
        let prior = self.prior();
        let reduced = self.matching.buildings.iter().filter_map(|building| {
            let inverse = (building.own + Matrix2::identity() * prior).try_inverse()?;
            Some(building.pose - building.mixed * inverse * building.mixed.transpose())
        });
        reduced.sum()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use openbench_core::MapPoint;

    use super::super::town::{block, chart, stretch_at, town};
    use super::*;

    fn submap(houses: &[openbench_geometry::Polygon], pose: Pose2) -> Submap {
        Submap::of(&[stretch_at(houses, pose)])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn a_pose_two_metres_off_is_found_again(
            dx in -2.0..2.0_f64, dy in -2.0..2.0_f64, turn in -0.1..0.1_f64,
        ) {
            let truth = Pose2::new(1.0, 0.0, 0.4);
            let start = Pose2::new(truth.x + dx, truth.y + dy, truth.yaw + turn);
            let seen = submap(&town(), truth);
            let refined =
                refine(&chart(&town()), &seen, start, &Assumptions::default()).unwrap();
            let error = refined.pose.point().distance(truth.point());
            prop_assert!(error < 0.05, "{error} m, {:?}", refined.pose);
            prop_assert!(wrap_angle(refined.pose.yaw - truth.yaw).abs() < 0.003);
        }
    }

    #[test]
    fn buildings_that_the_map_displaces_have_their_offsets() {
        // The map shows each house elsewhere; on average they are where they should be.
        let shifts = [
            (0.8, 0.1),
            (-0.5, 0.6),
            (0.3, -0.7),
            (-0.6, 0.4),
            (0.1, 0.5),
            (0.5, -0.3),
            (-0.6, -0.6),
        ];
        let mapped: Vec<_> = town()
            .iter()
            .zip(shifts)
            .map(|(house, (dx, dy))| {
                let outline = house
                    .outer
                    .iter()
                    .map(|p| MapPoint::new(p.x + dx, p.y + dy));
                openbench_geometry::Polygon::new(outline.collect(), Vec::new()).unwrap()
            })
            .collect();
        let truth = Pose2::new(1.0, 0.0, 0.4);
        let seen = submap(&town(), truth);
        let refined = refine(&chart(&mapped), &seen, truth, &Assumptions::default()).unwrap();
        assert!(
            refined.pose.point().distance(truth.point()) < 0.4,
            "{:?}",
            refined.pose
        );
        assert!(refined.buildings.len() >= 5);
        assert!(
            (0.4..0.9).contains(&refined.building_m),
            "{}",
            refined.building_m
        );
        // What matters at a door: how far the wall in front of the robot is. House 1 shows its
        // south wall.
        let house = refined
            .buildings
            .iter()
            .find(|house| house.building == 1)
            .unwrap();
        let wall_relative = refined.pose.y - (shifts[1].1 + house.offset.y) - truth.y;
        assert!(wall_relative.abs() < 0.2, "{wall_relative}");
    }

    #[test]
    fn what_the_map_lacks_leaves_facades_on_no_wall_and_the_others_as_close_as_before() {
        let seen = submap(&town(), Pose2::default());
        let refined = |mapped: &[openbench_geometry::Polygon]| {
            let assumed = Assumptions::default();
            refine(&chart(mapped), &seen, Pose2::default(), &assumed).unwrap()
        };
        let (all, some) = (refined(&town()), refined(&town()[1..]));
        let share = |of: &Refined| of.matched as f64 / of.facades as f64;
        assert!(share(&all) > 0.95 && share(&some) < 0.9);
        let change = all.closeness_of_matched() - some.closeness_of_matched();
        assert!(change.abs() < 0.02, "{change}");
        // 0.2 / 0.3² times 1.5² / 6 nats at most.
        let each = (some.misfit - all.misfit) / (all.matched - some.matched) as f64;
        assert!((0.1..0.84).contains(&each), "{each}");
    }

    #[test]
    fn a_single_wall_says_nothing_about_the_way_along_it() {
        let house = [block(0.0, 10.0, 200.0, 8.0)];
        let seen = submap(&house, Pose2::default());
        let refined = refine(
            &chart(&house),
            &seen,
            Pose2::new(3.0, 0.5, 0.02),
            &Assumptions::default(),
        )
        .unwrap();
        assert!((refined.pose.x - 3.0).abs() < 1e-3, "{:?}", refined.pose);
        assert!(refined.pose.y.abs() < 0.2);
        assert!(refined.information[(0, 0)] < 1e-6 * refined.information[(2, 2)]);
    }

    #[test]
    fn nothing_to_match_is_no_pose() {
        let assumed = Assumptions::default();
        let seen = submap(&town(), Pose2::default());
        assert_eq!(
            refine(&Chart::default(), &seen, Pose2::default(), &assumed),
            None
        );
        let nowhere = Submap::default();
        assert_eq!(
            refine(&chart(&town()), &nowhere, Pose2::default(), &assumed),
            None
        );
        let nan = Pose2::new(f64::NAN, 0.0, 0.0);
        assert_eq!(refine(&chart(&town()), &seen, nan, &assumed), None);
    }
}
