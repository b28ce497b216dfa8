//! Where the robot is by all that it saw so far, and where the buildings around it are: a Kalman
//! filter of the pose and of an offset of each building.
//!
//! A building that a map displaces is seen on many stretches in turn, with the same error. A filter
//! of the pose alone would take these for independent, and soon be certain of a wrong pose. With
//! offsets it becomes no more certain than independent buildings allow, while the distance to the
//! wall in front of the robot is known ever better (R. Smith, M. Self and P. Cheeseman, *Estimating
//! uncertain spatial relationships in robotics*, 1990).
//!
//! The offset of the map as a whole is none of its variables: the pose is one on the map, and
//! nothing measures another.

use std::collections::BTreeMap;

use nalgebra::{Cholesky, DMatrix, DVector, Matrix3, SymmetricEigen, Vector2, Vector3};
use openbench_core::Pose2;
use openbench_core::frames::wrap_angle;

use super::chart::Chart;
use super::equations::Equations;
use super::matching::{BuildingEvidence, Matching};
use super::refine::{Assumptions, Refined};
use super::spread::Spread;
use super::submap::Submap;
use crate::reckoned::rotating;

/// Odometry errs by this share of the way, whatever it says itself,
const DRIFT: f64 = 0.01;
/// and turns by so many radians on each metre of it.
const DRIFT_RAD_PER_M: f64 = 1e-4;
/// A measured pose of more standard deviations contradicts the estimate.
const CREDIBLE: f64 = 4.0;
/// An offset of more standard deviations is not tried.
const GUESS: f64 = 3.0;
/// What is known of a direction that nothing measures: a kilometre, and any heading.
const NOTHING: [f64; 3] = [1e-6, 1e-6, 0.1];
/// Most steps of an update,
const MOST_STEPS: usize = 5;
/// of which one shorter than this is the last, metres and radians.
const SMALL: f64 = 1e-3;
/// Most buildings with an offset: the time of an update grows with their cube.
const MOST_BUILDINGS: usize = 48;
/// Information along a direction below this share of the most is rounding.
const ROUNDING: f64 = 1e-9;

/// A pose in `map`, and offsets of buildings, with their covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The pose of the robot.
    pub pose: Pose2,
    offsets: Vec<BuildingOffset>,
    /// How large offsets are.
    spread: Spread,
    assumed: Assumptions,
    /// Covariance of x, y of `map` and yaw, then of x and y of each offset.
    covariance: DMatrix<f64>,
    /// Pose of the robot in `odom` there.
    pub(super) here: Pose2,
}

/// How far a building is from where the map shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BuildingOffset {
    /// Index of the building in the map.
    pub building: usize,
    /// From the map's outline to that on the ground, metres.
    pub offset: Vector2<f64>,
}

/// A measured pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// The pose in `map`.
    pub pose: Pose2,
    /// Information about x, y of `map`, and yaw; zero along what was not measured.
    pub information: Matrix3<f64>,
}

impl Estimate {
    /// From a pose that was refined under the same assumptions; `here` is the robot's pose in
    /// `odom`. `None` if it is not finite.
    pub fn begin(
        chart: &Chart,
        refined: &Refined,
        here: Pose2,
        assumed: &Assumptions,
    ) -> Option<Self> {
        let buildings = most_seen(&refined.buildings);
        let offset = |one: &&BuildingEvidence| BuildingOffset {
            building: chart.buildings[one.building],
            offset: one.offset,
        };
        let mut equations =
            Equations::of(DMatrix::from_diagonal(&DVector::from_row_slice(&NOTHING)));
        for one in &buildings {
            let place = equations.extend(refined.building_m, one.offset);
            equations.add(one, place);
        }
        let covariance = equations.solver()?.inverse();
        if !covariance.iter().all(|x| x.is_finite()) {
            return None;
        }
        let mut estimate = Self {
            pose: chart.in_map(refined.pose),
            offsets: buildings.iter().map(offset).collect(),
            spread: Spread::new(assumed, refined.building_m),
            assumed: *assumed,
            covariance,
            here,
        };
        estimate.rescale()?;
        Some(estimate)
    }

    /// Covariance of x, y of `map`, and yaw.
    ///
    /// How large offsets are is estimated as well, from few buildings at first. What offsets
    /// contribute to the error of the pose then has Student's t distribution, whose covariance is
    /// larger than that of a normal one with the same scale.
    pub fn covariance(&self) -> Matrix3<f64> {
        self.pose_covariance() + self.share_of_offsets() * self.widening()
    }

    /// The same, if it were known how large offsets are.
    fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into_owned()
    }

    /// What of the pose's covariance would vanish if all offsets were known.
    fn share_of_offsets(&self) -> Matrix3<f64> {
        let count = 2 * self.offsets.len();
        let mixed = self.covariance.view((3, 0), (count, 3)).into_owned();
        let own = self.covariance.view((3, 3), (count, count)).into_owned();
        let solver = Cholesky::new(own);
        solver.map_or_else(Matrix3::zeros, |solver| {
            let share = mixed.tr_mul(&solver.solve(&mixed));
            share.fixed_view::<3, 3>(0, 0).into_owned()
        })
    }

    /// By which share the covariance of what offsets contribute exceeds its squared scale.
    fn widening(&self) -> f64 {
        self.spread.widening(self.offsets.len())
    }

    /// The offsets of the buildings that were seen around the robot.
    pub fn offsets(&self) -> &[BuildingOffset] {
        &self.offsets
    }

    /// The same after the robot has moved; `drift` is the covariance of that motion by odometry,
    /// in the frame of its end.
    #[must_use]
    pub fn carried(mut self, here: Pose2, drift: &Matrix3<f64>) -> Self {
        let pose = self.pose.compose(here.seen_from(self.here));
        let (dx, dy) = (pose.x - self.pose.x, pose.y - self.pose.y);
        // An error of the heading displaces what lies ahead.
        for column in 0..self.covariance.ncols() {
            let turn = self.covariance[(2, column)];
            self.covariance[(0, column)] -= dy * turn;
            self.covariance[(1, column)] += dx * turn;
        }
        for row in 0..self.covariance.nrows() {
            let turn = self.covariance[(row, 2)];
            self.covariance[(row, 0)] -= dy * turn;
            self.covariance[(row, 1)] += dx * turn;
        }
        let way = libm::hypot(dx, dy);
        let (metres, radians) = (DRIFT * way, DRIFT_RAD_PER_M * way);
        let least = Vector3::new(metres, metres, radians);
        let least = Matrix3::from_diagonal(&least.component_mul(&least));
        let turn = rotating(pose.yaw);
        let mut own = self.covariance.fixed_view_mut::<3, 3>(0, 0);
        own += turn * drift * turn.transpose() + least;
        Self { pose, here, ..self }
    }

    /// Whether a pose that was measured here may be the same.
    pub fn agrees_with(&self, measured: &Measured) -> bool {
        let own = measured.information + Matrix3::from_diagonal(&NOTHING.into());
        let own = own.try_inverse();
        let error = difference(measured.pose, self.pose);
        own.is_some_and(|own| is_credible(&(self.covariance() + own), &error))
    }

    /// The same with what was seen from here, which nothing before has shown: facades of the last
    /// stretch. `about` is a refined pose that agrees; it says nearly where buildings are that are
    /// new. `None` if what is seen contradicts the estimate.
    pub fn with(&self, chart: &Chart, seen: &Submap, about: &Refined) -> Option<Self> {
        let mut after = self.clone();
        let guesses = self.guesses(chart, about);
        for own in &mut after.offsets {
            own.offset = *guesses.get(&own.building).unwrap_or(&own.offset);
        }
        let mut equations = Equations::of(self.covariance.clone().cholesky()?.inverse());
        let mut matching = Matching::about(chart, chart.from_map(self.pose));
        for _ in 0..MOST_STEPS {
            matching.displace(|building| {
                let building = chart.buildings[building];
                let guess = || guesses.get(&building).copied();
                after.offset(building).or_else(guess).unwrap_or_default()
            });
            let pose = chart.from_map(after.pose);
            let Assumptions {
                last_gate_m,
                facade,
                ..
            } = self.assumed;
            matching.linearise(&seen.facades, pose, last_gate_m, facade);
            equations.reset_to_prior(&after.departure(self));
            for one in most_seen(&matching.buildings) {
                let building = chart.buildings[one.building];
                let place = after.place(building).unwrap_or_else(|| {
                    let offset = one.offset;
                    after.spread.see(building);
                    after.offsets.push(BuildingOffset { building, offset });
                    equations.extend(self.spread.deviation_m(), offset)
                });
                equations.add(one, place);
            }
            let solver = equations.solver()?;
            let step = -solver.solve(&equations.gradient);
            after.covariance = solver.inverse();
            after.step(&step)?;
            if step.norm() < SMALL {
                break;
            }
        }
        let moved = difference(after.pose, self.pose);
        if !is_credible(&self.covariance(), &moved) {
            return None;
        }
        after.forget_far(chart, &matching);
        after.rescale()?;
        Some(after)
    }

    /// The pose that would have had to be measured, by something independent, to change an earlier
    /// estimate at the same place into this one: an equivalent measurement (O. Drummond, *Tracklets
    /// and a hybrid fusion with process noise*, 1997).
    pub fn news_since(&self, before: &Self) -> Option<Measured> {
        let own = self.covariance().try_inverse()?;
        let gained = SymmetricEigen::new(own - before.covariance().try_inverse()?);
        let least = ROUNDING * own.symmetric_eigenvalues().max();
        let along = |f: &dyn Fn(f64) -> f64| {
            let vectors = gained.eigenvectors;
            let values = gained
                .eigenvalues
                .map(|x| if x > least { f(x) } else { 0.0 });
            vectors * Matrix3::from_diagonal(&values) * vectors.transpose()
        };
        let change = along(&|x| 1.0 / x) * own * difference(self.pose, before.pose);
        let moved = moved(before.pose, change);
        moved.x.is_finite().then(|| Measured {
            pose: moved,
            information: along(&|x| x),
        })
    }

    /// The offset of a building of the map, metres; `None` before it is seen.
    pub fn offset(&self, building: usize) -> Option<Vector2<f64>> {
        self.place(building).map(|place| self.offsets[place].offset)
    }

    /// Where buildings could be by a refined pose, if that does not contradict what is known about
    /// them. A wall that was not seen before may be far from where its building was expected.
    fn guesses(&self, chart: &Chart, about: &Refined) -> BTreeMap<usize, Vector2<f64>> {
        let apart = difference(self.pose, chart.in_map(about.pose)).xy();
        let mut guesses = BTreeMap::new();
        for one in &about.buildings {
            let building = chart.buildings[one.building];
            let guess = one.offset + apart;
            let is_possible = |place: usize| {
                let at = 3 + 2 * place;
                let covariance = self.covariance.fixed_view::<2, 2>(at, at).into_owned();
                let error = guess - self.offsets[place].offset;
                let known = covariance.try_inverse();
                known.is_some_and(|known| error.dot(&(known * error)) <= GUESS * GUESS)
            };
            if self.place(building).is_none_or(is_possible) {
                guesses.insert(building, guess);
            }
        }
        guesses
    }

    /// The place of a building among the offsets.
    fn place(&self, building: usize) -> Option<usize> {
        let mut buildings = self.offsets.iter();
        buildings.position(|own| own.building == building)
    }

    /// From an earlier estimate to this one, in the order of the covariance.
    fn departure(&self, before: &Self) -> DVector<f64> {
        let pose = difference(self.pose, before.pose);
        let earlier = before.offsets.iter().map(|own| own.offset);
        let none = std::iter::repeat(Vector2::zeros());
        let offsets = self.offsets.iter().zip(earlier.chain(none));
        let offsets = offsets.flat_map(|(own, earlier)| {
            let moved = own.offset - earlier;
            [moved.x, moved.y]
        });
        let all: Vec<f64> = pose.iter().copied().chain(offsets).collect();
        DVector::from_vec(all)
    }

    /// Moves pose and offsets; `None` if the step is not finite.
    fn step(&mut self, step: &DVector<f64>) -> Option<()> {
        if !step.iter().all(|x| x.is_finite()) {
            return None;
        }
        self.pose = moved(self.pose, Vector3::new(step[0], step[1], step[2]));
        for (i, own) in self.offsets.iter_mut().enumerate() {
            own.offset += Vector2::new(step[3 + 2 * i], step[4 + 2 * i]);
        }
        Some(())
    }

    /// Estimates how large offsets are, by a step of expectation maximization, and expects all of
    /// them to be so.
    fn rescale(&mut self) -> Option<()> {
        let before = self.spread.information();
        let in_sight = (0..self.offsets.len()).map(|place| self.squared_offset(place));
        self.spread.estimate(&in_sight.collect::<Vec<_>>());
        let change = self.spread.information() - before;
        let mut information = self.covariance.clone().cholesky()?.inverse();
        let mut gradient = DVector::zeros(information.nrows());
        for (i, own) in self.offsets.iter().enumerate() {
            for (at, offset) in [(3 + 2 * i, own.offset.x), (4 + 2 * i, own.offset.y)] {
                information[(at, at)] += change;
                gradient[at] = change * offset;
            }
        }
        let solver = information.cholesky()?;
        let step = -solver.solve(&gradient);
        self.covariance = solver.inverse();
        self.step(&step)
    }

    /// Expected square of the offset at a place, mean over both axes, m².
    fn squared_offset(&self, place: usize) -> f64 {
        let at = 3 + 2 * place;
        let unknown = self.covariance[(at, at)] + self.covariance[(at + 1, at + 1)];
        0.5 * (self.offsets[place].offset.norm_squared() + unknown)
    }

    /// Leaves out buildings that cannot be seen from here, and the farthest ones of too many.
    fn forget_far(&mut self, chart: &Chart, near: &Matching) {
        let here = chart.from_map(self.pose).point();
        let away = |own: &BuildingOffset| {
            let seen = near.buildings.iter();
            let mut indices = seen.map(|one| one.building);
            let index = indices.find(|i| chart.buildings[*i] == own.building)?;
            Some(chart.outlines[index].distance_to_boundary(here))
        };
        let mut kept: Vec<(usize, f64)> = self
            .offsets
            .iter()
            .enumerate()
            .filter_map(|(i, own)| Some((i, away(own)?)))
            .collect();
        kept.sort_by(|(_, a), (_, b)| a.total_cmp(b));
        kept.truncate(MOST_BUILDINGS);
        if kept.len() == self.offsets.len() {
            return;
        }
        let (share, widening) = (self.share_of_offsets(), self.widening());
        for place in 0..self.offsets.len() {
            if !kept.iter().any(|(i, _)| *i == place) {
                let building = self.offsets[place].building;
                let square = self.squared_offset(place);
                self.spread.pass(building, square);
            }
        }
        let offsets = kept.iter().map(|(i, _)| self.offsets[*i]).collect();
        let rows: Vec<usize> = (0..3)
            .chain(kept.iter().flat_map(|(i, _)| [3 + 2 * i, 4 + 2 * i]))
            .collect();
        let own = &self.covariance;
        let covariance = DMatrix::from_fn(rows.len(), rows.len(), |i, j| own[(rows[i], rows[j])]);
        self.offsets = offsets;
        self.covariance = covariance;
        // What the forgotten ones contribute to the pose's covariance stays as wide.
        let lost = (share - self.share_of_offsets()) * widening;
        let mut own = self.covariance.fixed_view_mut::<3, 3>(0, 0);
        own += lost;
    }
}

/// The buildings with the most facades, not more than are remembered.
fn most_seen(buildings: &[BuildingEvidence]) -> Vec<&BuildingEvidence> {
    let mut seen: Vec<_> = buildings.iter().filter(|one| one.facades > 0).collect();
    seen.sort_by_key(|one| std::cmp::Reverse(one.facades));
    seen.truncate(MOST_BUILDINGS);
    seen
}

/// From a pose to another: x, y, yaw.
fn difference(to: Pose2, from: Pose2) -> Vector3<f64> {
    Vector3::new(to.x - from.x, to.y - from.y, wrap_angle(to.yaw - from.yaw))
}

fn moved(pose: Pose2, by: Vector3<f64>) -> Pose2 {
    Pose2::new(pose.x + by.x, pose.y + by.y, wrap_angle(pose.yaw + by.z))
}

fn is_credible(covariance: &Matrix3<f64>, error: &Vector3<f64>) -> bool {
    let information = covariance.try_inverse();
    // Of NaN no.
    information.is_some_and(|known| error.dot(&(known * error)) <= CREDIBLE * CREDIBLE)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use openbench_core::MapPoint;
    use openbench_geometry::Polygon;

    use super::super::refine::refine;
    use super::super::town::{block, chart, stretch_at, town, village, way};
    use super::*;

    /// What a robot sees that stands at a pose and looks around, after it was told where it is.
    fn begun(houses: &[Polygon], mapped: &[Polygon], pose: Pose2) -> Estimate {
        let seen = Submap::of(&[stretch_at(houses, pose)]);
        let chart = chart(mapped);
        let refined = refine(&chart, &seen, pose, &Assumptions::default()).unwrap();
        Estimate::begin(&chart, &refined, Pose2::default(), &Assumptions::default()).unwrap()
    }

    /// The estimate after it has seen the same from the same place so many times.
    fn looked(houses: &[Polygon], mapped: &[Polygon], pose: Pose2, times: usize) -> Estimate {
        let seen = Submap::of(&[stretch_at(houses, pose)]);
        let chart = chart(mapped);
        let mut estimate = begun(houses, mapped, pose);
        for _ in 0..times {
            let about = refine(&chart, &seen, estimate.pose, &Assumptions::default()).unwrap();
            estimate = estimate.with(&chart, &seen, &about).unwrap();
        }
        estimate
    }

    fn shifted(house: &Polygon, x: f64, y: f64) -> Polygon {
        let outline = house.outer.iter();
        let outline = outline.map(|at| MapPoint::new(at.x + x, at.y + y));
        Polygon::new(outline.collect(), Vec::new()).unwrap()
    }

    fn level_deviation(covariance: &Matrix3<f64>) -> f64 {
        libm::sqrt(covariance[(0, 0)].max(covariance[(1, 1)]))
    }

    #[test]
    fn a_pose_is_as_uncertain_as_odometry_says() {
        let known = begun(&town(), &town(), Pose2::new(0.0, 0.0, FRAC_PI_2));
        let ahead = Pose2::new(5.0, 0.0, 0.0);
        let drift = Matrix3::from_diagonal(&[0.25, 0.0, 4e-4].into());
        let sound = known.clone().carried(ahead, &Matrix3::zeros()).covariance();
        let poor = known.carried(ahead, &drift).covariance();
        // The robot drives along y.
        let more = poor - sound;
        assert!((more[(1, 1)] - 0.25).abs() < 1e-9 && more[(0, 0)].abs() < 1e-3);
        assert!((more[(2, 2)] - 4e-4).abs() < 1e-9);
    }

    #[test]
    fn a_house_seen_again_and_again_makes_no_pose_certain() {
        let house = [block(0.0, 14.0, 12.0, 8.0), block(16.0, 0.0, 6.0, 12.0)];
        let mapped = [shifted(&house[0], 0.7, 0.5), shifted(&house[1], 0.7, 0.5)];
        let estimate = looked(&house, &mapped, Pose2::default(), 30);
        // Both houses are displaced alike, so that the pose follows. No number of looks tells.
        let deviation = level_deviation(&estimate.covariance());
        assert!(deviation > 0.4, "{deviation}");
        // The robot knows how far the wall is in front of it: ten metres.
        let wall = 10.5 + estimate.offset(0).unwrap().y - estimate.pose.y;
        assert!((wall - 10.0).abs() < 0.05, "{wall}");
    }

    #[test]
    fn many_houses_tell_more_than_one() {
        let few = looked(&town()[..2], &town()[..2], Pose2::default(), 1);
        let many = looked(&town(), &town(), Pose2::default(), 1);
        let [few, many] = [few, many].map(|one| level_deviation(&one.covariance()));
        assert!(many < 0.6 * few, "{many} {few}");
    }

    #[test]
    fn a_pose_stays_as_uncertain_where_the_houses_that_told_it_are_out_of_sight() {
        let known = begun(&town(), &town(), Pose2::default());
        let mut later = known.clone();
        later.forget_far(&chart(&[]), &Matching::about(&chart(&[]), known.pose));
        assert!(later.offsets().is_empty());
        let change = (later.covariance() - known.covariance()).norm();
        assert!(change < 1e-9 * known.covariance().norm(), "{change}");
        // What they said about the map as a whole is not forgotten.
        later.rescale().unwrap();
        let deviation = known.spread.deviation_m();
        assert!((later.spread.deviation_m() - deviation).abs() < 0.05 * deviation);
    }

    #[test]
    fn offsets_are_found_of_houses_that_are_new_on_the_way() {
        let town = village(7);
        let shift = |i: usize| {
            let turn = 2.4 * i as f64;
            Vector2::new(0.8 * libm::cos(turn), 0.8 * libm::sin(turn))
        };
        let mapped: Vec<Polygon> = town
            .iter()
            .enumerate()
            .map(|(i, house)| shifted(house, shift(i).x, shift(i).y))
            .collect();
        let chart = chart(&mapped);
        let poses: Vec<Pose2> = (0..12)
            .map(|i| Pose2::new(-40.0 + 5.0 * f64::from(i), 50.0, 0.0))
            .collect();
        let stretches = way(&town, &poses);
        let first = Submap::of(&stretches[..1]);
        let refined = refine(&chart, &first, poses[0], &Assumptions::default()).unwrap();
        let mut estimate =
            Estimate::begin(&chart, &refined, stretches[0].end, &Assumptions::default()).unwrap();
        for i in 1..stretches.len() {
            let known = estimate.carried(stretches[i].end, &Matrix3::zeros());
            let all = Submap::of(&stretches[..=i]);
            let newest = Submap::of(&stretches[i..=i]);
            let about = refine(&chart, &all, known.pose, &Assumptions::default()).unwrap();
            estimate = known.with(&chart, &newest, &about).unwrap();
        }
        let error = estimate.pose.point().distance(poses[11].point());
        assert!(error < 0.5, "{error}");
        assert!(estimate.offsets().len() >= 8);
        let walls = estimate.offsets().iter().map(|own| {
            // Houses along the road show the walls that face it.
            let off = own.offset + shift(own.building);
            (off.y - (estimate.pose.y - 50.0)).abs()
        });
        let right = walls.filter(|error| *error < 0.2).count();
        assert!(right >= 8, "{right} of {}", estimate.offsets().len());
    }

    #[test]
    fn news_tell_another_filter_the_same() {
        let known = begun(&town(), &town(), Pose2::default());
        let known = known.carried(Pose2::new(4.0, 0.0, 0.02), &Matrix3::zeros());
        let here = Pose2::new(4.1, 0.1, 0.0);
        let seen = Submap::of(&[stretch_at(&town(), here)]);
        let chart = chart(&town());
        let about = refine(&chart, &seen, here, &Assumptions::default()).unwrap();
        let after = known.with(&chart, &seen, &about).unwrap();
        let news = after.news_since(&known).unwrap();
        // A filter of the pose alone.
        let prior = known.covariance().try_inverse().unwrap();
        let covariance = (prior + news.information).try_inverse().unwrap();
        let change = covariance * news.information * difference(news.pose, known.pose);
        assert!((change - difference(after.pose, known.pose)).norm() < 1e-6);
        assert!((covariance - after.covariance()).norm() < 1e-6);
    }

    #[test]
    fn what_a_street_does_not_measure_stays_as_it_was() {
        let street = [block(0.0, 10.0, 300.0, 8.0), block(0.0, -10.0, 300.0, 8.0)];
        let before = begun(&town(), &town(), Pose2::default());
        let seen = Submap::of(&[stretch_at(&street, Pose2::default())]);
        let mut chart = chart(&street);
        // Not the houses that the robot knows.
        chart.buildings = vec![100, 101];
        let about = refine(&chart, &seen, before.pose, &Assumptions::default()).unwrap();
        let after = before.with(&chart, &seen, &about).unwrap();
        let news = after.news_since(&before).unwrap().information;
        // Along the street nothing is new but how large offsets are, which two more houses tell.
        let known = before.covariance().try_inverse().unwrap();
        assert!(news[(0, 0)] < 0.1 * known[(0, 0)], "{news} {known}");
        assert!(
            news[(1, 1)] > 0.3 * known[(1, 1)] && news[(2, 2)] > 100.0,
            "{news} {known}"
        );
        assert!((after.pose.x - before.pose.x).abs() < 0.01);
    }

    #[test]
    fn a_pose_elsewhere_contradicts() {
        let known = begun(&town(), &town(), Pose2::default());
        let measured = |x: f64| Measured {
            pose: Pose2::new(x, 0.0, 0.0),
            information: Matrix3::from_diagonal(&[10.0, 10.0, 1e4].into()),
        };
        assert!(known.agrees_with(&measured(0.5)));
        assert!(!known.agrees_with(&measured(9.0)));
        assert!(!known.agrees_with(&measured(f64::NAN)));
        let nowhere = Pose2::new(f64::NAN, 0.0, 0.0);
        let lost = known.clone().carried(nowhere, &Matrix3::zeros());
        let seen = Submap::of(&[stretch_at(&town(), Pose2::default())]);
        let chart = chart(&town());
        let about = refine(&chart, &seen, Pose2::default(), &Assumptions::default()).unwrap();
        assert_eq!(lost.with(&chart, &seen, &about), None);
    }

    #[test]
    fn of_very_many_houses_the_nearest_ones_are_remembered() {
        let houses: Vec<Polygon> = (0..60)
            .map(|i| {
                let turn = f64::from(i) * std::f64::consts::TAU / 60.0;
                block(30.0 * libm::cos(turn), 30.0 * libm::sin(turn), 2.5, 2.5)
            })
            .collect();
        let estimate = looked(&houses, &houses, Pose2::default(), 1);
        assert_eq!(estimate.offsets().len(), MOST_BUILDINGS);
    }
}
