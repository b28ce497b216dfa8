//! A pose made exact: facades of a submap on walls of the map.
//!
//! Gauss-Newton on distances from points to walls, with a robust kernel. A building of a map is
//! displaced as a whole, and by more than its walls are rough. Each matched building therefore has
//! an offset with a prior, which is estimated with the pose. Several buildings decide together
//! where the robot is, and the distance to the wall in front of it is known better than either.

use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector2, Vector3};
use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2};

use super::chart::{Chart, Wall};
use super::columns::Facade;
use super::submap::Submap;

/// Most steps.
const MAX_STEPS: usize = 20;
/// The gate narrows over so many.
const NARROWING_STEPS: f64 = 6.0;
/// A step shorter than this is the last, metres and radians.
const SMALL: f64 = 1e-3;
/// Facades match walls that face the same way up to this, radians,
const FACING_RAD: f64 = 0.45;
/// and reach beyond their ends by no more than this, metres, or by half the gate at first.
const BEYOND_END_M: f64 = 0.7;
/// Walls within this distance of the robot are matched, metres.
const REACH_M: f64 = 60.0;
/// Most views that a piece of a facade counts for.
const MOST_VIEWS: u8 = 4;

/// What is assumed of map and facades.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assumptions {
    /// Standard deviation of a building's offset along each axis, metres: what is expected before
    /// any building is seen.
    pub building_m: f64,
    /// How many buildings that expectation is worth.
    pub expected_buildings: f64,
    /// Standard deviation of a facade about its wall, metres.
    pub facade_m: f64,
    /// Information of a facade relative to an independent one: neighbours have the same errors.
    pub independence: f64,
    /// Facades farther than this from each wall match none at the first step, metres,
    pub first_gate_m: f64,
    /// and at the last.
    pub last_gate_m: f64,
}

impl Default for Assumptions {
    fn default() -> Self {
        Self {
            building_m: 1.0,
            expected_buildings: 1.0,
            facade_m: 0.3,
            independence: 0.2,
            first_gate_m: 4.0,
            last_gate_m: 1.5,
        }
    }
}

/// What the facades of one building say, linear about the refined pose: information about pose and
/// offset, and the gradient of half the squared error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BuildingEvidence {
    /// Index of the building in the chart.
    pub building: usize,
    /// Estimated offset of its outline on the ground from that in the map, metres.
    pub offset: Vector2<f64>,
    /// Information about the pose.
    pub pose: Matrix3<f64>,
    /// Between pose and offset.
    pub mixed: Matrix3x2<f64>,
    /// Information about the offset, without its prior.
    pub own: Matrix2<f64>,
    /// Gradient along the pose.
    pub pose_gradient: Vector3<f64>,
    /// Gradient along the offset.
    pub own_gradient: Vector2<f64>,
    /// Facades that match its walls.
    pub facades: usize,
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
    /// Facades that match a wall,
    pub matched: usize,
    /// of so many.
    pub facades: usize,
}

impl BuildingEvidence {
    fn of(building: usize) -> Self {
        Self {
            building,
            offset: Vector2::zeros(),
            pose: Matrix3::zeros(),
            mixed: Matrix3x2::zeros(),
            own: Matrix2::zeros(),
            pose_gradient: Vector3::zeros(),
            own_gradient: Vector2::zeros(),
            facades: 0,
        }
    }

    fn forget(&mut self) {
        *self = Self {
            offset: self.offset,
            ..Self::of(self.building)
        };
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
    let mut problem = Problem::about(chart, start, assumed.building_m);
    let mut pose = start;
    for step in 0..MAX_STEPS {
        let share = (step as f64 / NARROWING_STEPS).min(1.0);
        let gate = assumed.first_gate_m + share * (assumed.last_gate_m - assumed.first_gate_m);
        problem.linearise(&submap.facades, pose, gate, assumed);
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
    let matches = problem.linearise(&submap.facades, pose, assumed.last_gate_m, assumed);
    let facades = submap.facades.len();
    (matches.count > 0).then(|| Refined {
        pose,
        information: problem.information(),
        building_m: problem.building_m,
        buildings: problem.matched_buildings(),
        closeness: matches.closeness / facades as f64,
        matched: matches.count,
        facades,
    })
}

/// Walls near a pose, and the normal equations.
struct Problem {
    walls: Vec<Line>,
    buildings: Vec<BuildingEvidence>,
    /// Standard deviation of offsets, metres.
    building_m: f64,
}

/// A wall as the equations need it.
struct Line {
    start: Vector2<f64>,
    along: Vector2<f64>,
    /// Away from the building.
    normal: Vector2<f64>,
    /// The direction of the normal, radians.
    facing: f64,
    length: f64,
    /// Of its building in the problem.
    place: usize,
}

impl Line {
    fn of(wall: &Wall, place: usize) -> Self {
        let (a, b) = (wall.segment.start, wall.segment.end);
        let length = wall.segment.length();
        let along = Vector2::new(b.x - a.x, b.y - a.y) / length;
        // The building lies to the left.
        let normal = Vector2::new(along.y, -along.x);
        Self {
            start: Vector2::new(a.x, a.y),
            along,
            normal,
            facing: libm::atan2(normal.y, normal.x),
            length,
            place,
        }
    }
}

impl Problem {
    fn about(chart: &Chart, pose: Pose2, building_m: f64) -> Self {
        let mut places = vec![None; chart.outlines.len()];
        let mut problem = Self {
            walls: Vec::new(),
            buildings: Vec::new(),
            building_m,
        };
        for wall in &chart.walls {
            if wall.segment.distance_to_point(pose.point()) > REACH_M {
                continue;
            }
            let buildings = &mut problem.buildings;
            let place = *places[wall.building].get_or_insert_with(|| {
                buildings.push(BuildingEvidence::of(wall.building));
                buildings.len() - 1
            });
            problem.walls.push(Line::of(wall, place));
        }
        problem
    }

    /// Sums up the equations at a pose.
    fn linearise(
        &mut self,
        facades: &[Facade],
        pose: Pose2,
        gate: f64,
        assumed: &Assumptions,
    ) -> Matches {
        self.buildings.iter_mut().for_each(BuildingEvidence::forget);
        let mut matches = Matches::default();
        for facade in facades {
            let at = pose.transform(facade.at.x, facade.at.y);
            let Some(fit) = self.fit(at, facade.facing + pose.yaw, gate) else {
                continue;
            };
            let views = f64::from(facade.views.min(MOST_VIEWS)) / f64::from(MOST_VIEWS);
            let scaled = fit.away / gate;
            // Tukey's biweight: nothing jumps when a facade leaves the gate.
            let robust = (1.0 - scaled * scaled).powi(2);
            matches.count += 1;
            matches.closeness += robust;
            let weight =
                robust * views * assumed.independence / (assumed.facade_m * assumed.facade_m);
            let normal = fit.normal;
            // The facade moves with the heading about the robot.
            let lever = Vector2::new(-(at.y - pose.y), at.x - pose.x);
            let by_pose = Vector3::new(normal.x, normal.y, normal.dot(&lever));
            let building = &mut self.buildings[fit.place];
            building.pose += by_pose * by_pose.transpose() * weight;
            building.mixed -= by_pose * normal.transpose() * weight;
            building.own += normal * normal.transpose() * weight;
            building.pose_gradient += by_pose * (fit.away * weight);
            building.own_gradient -= normal * (fit.away * weight);
            building.facades += 1;
        }
        matches
    }

    /// The nearest wall that a facade can be on.
    fn fit(&self, at: MapPoint, facing: f64, gate: f64) -> Option<Fit> {
        let beyond = BEYOND_END_M.max(0.5 * gate);
        let mut nearest = gate;
        let mut best = None;
        for line in &self.walls {
            let offset = self.buildings[line.place].offset;
            let from = Vector2::new(at.x, at.y) - line.start - offset;
            let away = line.normal.dot(&from);
            if away.abs() >= nearest {
                continue;
            }
            let on = line.along.dot(&from);
            let is_on = on > -beyond && on < line.length + beyond;
            if is_on && wrap_angle(line.facing - facing).abs() < FACING_RAD {
                nearest = away.abs();
                best = Some(Fit {
                    place: line.place,
                    normal: line.normal,
                    away,
                });
            }
        }
        best
    }

    /// The step of the pose; offsets take theirs.
    fn solve(&mut self) -> Option<Vector3<f64>> {
        let prior = self.prior();
        let mut reduced = Matrix3::zeros();
        let mut gradient = Vector3::zeros();
        for building in &self.buildings {
            let inverse = (building.own + Matrix2::identity() * prior).try_inverse()?;
            let own_gradient = building.own_gradient + building.offset * prior;
            reduced += building.pose - building.mixed * inverse * building.mixed.transpose();
            gradient += building.pose_gradient - building.mixed * inverse * own_gradient;
        }
        // Directions that nothing measures stay.
        let damped = reduced + Matrix3::from_diagonal(&Vector3::new(1e-3, 1e-3, 1e-1));
        let change = -damped.try_inverse()? * gradient;
        for building in &mut self.buildings {
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
        for building in self
            .buildings
            .iter()
            .filter(|building| building.facades > 0)
        {
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
        let reduced = self.buildings.iter().filter_map(|building| {
            let inverse = (building.own + Matrix2::identity() * prior).try_inverse()?;
            Some(building.pose - building.mixed * inverse * building.mixed.transpose())
        });
        reduced.sum()
    }

    fn matched_buildings(self) -> Vec<BuildingEvidence> {
        let mut matched = self.buildings;
        matched.retain(|building| building.facades > 0);
        matched
    }
}

/// Facades that match walls.
#[derive(Debug, Clone, Copy, Default)]
struct Matches {
    count: usize,
    /// Sum of their closeness, 0 at the gate and 1 on the wall.
    closeness: f64,
}

/// A facade on a wall.
#[derive(Debug, Clone, Copy)]
struct Fit {
    /// Of the building in the problem.
    place: usize,
    normal: Vector2<f64>,
    /// In front of the wall, metres.
    away: f64,
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

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
