//! What a locator finds on a drive.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Instant;

use nalgebra::Vector3;
use openbench_bench::Prepared;
use openbench_bench::run::threads;
use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2};
use openbench_geometry::Segment;
use openbench_localization::registration::estimate::Estimate;
use openbench_localization::registration::hypothesis::Acceptance;
use openbench_localization::registration::locator::{Judgement, Locator};
use openbench_localization::registration::refine::Assumptions;
use openbench_osm::OsmMap;
use openbench_osm::disturb::MapState;

use super::cases::Case;
use super::drives::{Seen, Shown};

/// Walls farther from the robot are not compared, metres.
const WALL_M: f64 = 25.0;
/// A building of the map is a true one if it is no farther from where that should be, metres.
const SAME_BUILDING_M: f64 = 2.0;

/// A part of registration that is left out (ablation).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Without {
    /// Free ground: facades are all that counts.
    FreeSpace,
    /// Offsets of buildings: each is where the map shows it.
    BuildingOffsets,
    /// The bank of hypotheses: one place has to be enough to accept a pose.
    HypothesisBank,
}

impl Without {
    fn judgement(without: Option<Self>) -> Judgement {
        let usual = Judgement::default();
        match without {
            Some(Self::BuildingOffsets) => Judgement {
                assumed: Assumptions::EXACT_MAP,
                ..usual
            },
            Some(Self::HypothesisBank) => Judgement {
                acceptance: Acceptance::AtOnePlace,
                ..usual
            },
            Some(Self::FreeSpace) | None => usual,
        }
    }
}

/// What was known at a moment of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Metres driven.
    pub metres: f64,
    /// The error of the pose that is accepted, carried on by odometry; `None` if none is.
    pub error: Option<PoseErrors>,
    /// The fix of this moment, if there was one.
    pub fix: Option<FixErrors>,
    /// Whether the robot was localized before.
    pub was_located: bool,
    /// Computing time, milliseconds.
    pub ms: f64,
}

/// Errors of a pose on a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseErrors {
    /// Of the position, metres; infinite if the map is of another place.
    pub metres: f64,
    /// Of the heading, radians.
    pub radians: f64,
}

/// Errors of an accepted fix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixErrors {
    /// Of its pose.
    pub pose: PoseErrors,
    /// Normalized estimation error squared: three degrees of freedom.
    pub nees: f64,
    /// Error of the distance to the nearest wall, metres; `None` if none is near, or it is not on
    /// the map.
    pub wall_m: Option<f64>,
}

/// Localizes the robot on the drives of all cases through a world.
pub fn trials(
    prepared: &Prepared,
    cases: &[Case<'_>],
    without: Option<Without>,
    threads: usize,
) -> Vec<Vec<Moment>> {
    let truth_map = OsmMap::new(&prepared.world.map, prepared.world.georeference);
    let one = |i: usize| Ok::<_, Infallible>(trial(&truth_map, &cases[i], without));
    let moments = threads::each(0..cases.len(), threads, one, Ok::<_, Infallible>);
    moments.unwrap_or_else(|never| match never {})
}

/// Localizes the robot along a drive. `truth_map` is the map without errors.
fn trial(truth_map: &OsmMap, case: &Case<'_>, without: Option<Without>) -> Vec<Moment> {
    let locator = Locator::new(Arc::clone(&case.map.map), &case.start);
    let mut locator = locator.judging(Without::judgement(without));
    let mut moments = Vec::new();
    for shown in case.drive.shown() {
        let blind = (without == Some(Without::FreeSpace)).then(|| without_free_space(shown.seen));
        let seen = blind.as_ref().unwrap_or(shown.seen);
        let shown = Shown { seen, ..shown };
        let was_located = locator.is_located();
        let began = Instant::now();
        let is_fixed = shown.to(&mut locator).is_some();
        let ms = began.elapsed().as_secs_f64() * 1e3;
        let truth = case.on_map(seen.truth);
        let errors = |pose| truth.map_or(PoseErrors::ELSEWHERE, |truth| pose_errors(pose, truth));
        let estimate = locator.estimate();
        let error = estimate.map(|estimate| errors(estimate.pose));
        let fix = estimate.filter(|_| is_fixed).map(|estimate| FixErrors {
            pose: errors(estimate.pose),
            nees: truth.map_or(f64::INFINITY, |truth| nees(estimate, truth)),
            wall_m: wall_error(truth_map, case, seen.truth, &locator, estimate),
        });
        let moment = Moment {
            metres: shown.metres,
            error,
            fix,
            was_located,
            ms,
        };
        moments.push(moment);
    }
    moments
}

fn without_free_space(seen: &Seen) -> Seen {
    let mut seen = seen.clone();
    seen.stretch.panoramas.clear();
    seen
}

impl PoseErrors {
    /// Of a pose on a map of another place.
    pub(super) const ELSEWHERE: Self = Self {
        metres: f64::INFINITY,
        radians: f64::INFINITY,
    };
}

/// How far a pose is from the truth.
pub(super) fn pose_errors(pose: Pose2, truth: Pose2) -> PoseErrors {
    PoseErrors {
        metres: pose.point().distance(truth.point()),
        radians: wrap_angle(pose.yaw - truth.yaw).abs(),
    }
}

fn nees(estimate: &Estimate, truth: Pose2) -> f64 {
    let pose = estimate.pose;
    let turn = wrap_angle(pose.yaw - truth.yaw);
    let error = Vector3::new(pose.x - truth.x, pose.y - truth.y, turn);
    let information = estimate.covariance().try_inverse();
    information.map_or(f64::INFINITY, |information| {
        error.dot(&(information * error))
    })
}

/// Error of the distance between the robot and the nearest wall that is on the map, as the locator
/// estimates both.
fn wall_error(
    truth_map: &OsmMap,
    case: &Case<'_>,
    truth: Pose2,
    locator: &Locator,
    estimate: &Estimate,
) -> Option<f64> {
    let wrong = case.map.errors.as_ref()?;
    let chart = locator.chart()?;
    let here = truth.point();
    let near = truth_map.buildings_within(here, WALL_M);
    let is_mapped = |i: &usize| {
        let error = wrong.buildings.get(&truth_map.buildings[*i].element);
        error.is_some_and(|error| error.state != MapState::Missing)
    };
    let (building, wall) = near
        .into_iter()
        .filter(is_mapped)
        .filter_map(|i| Some((i, nearest_wall(truth_map, i, here)?)))
        .min_by(|(_, a), (_, b)| {
            a.distance_to_point(here)
                .total_cmp(&b.distance_to_point(here))
        })?;
    let id = truth_map.buildings[building].element;
    let middle = truth_map.buildings[building].polygon.bounds().middle();
    // Where the building and the robot beside it are on the map.
    let middle = wrong.beside(Some(id), middle);
    let beside = wrong.beside(Some(id), here);
    let in_chart = MapPoint::new(middle.x - chart.origin.x, middle.y - chart.origin.y);
    let distance = |i: &usize| {
        let middle = chart.outlines[*i].bounds().middle();
        middle.distance(in_chart)
    };
    let mapped = (0..chart.outlines.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    if distance(&mapped) > SAME_BUILDING_M {
        return None;
    }
    let offset = estimate.offset(chart.buildings[mapped]);
    let offset = offset.unwrap_or_default();
    let normal = wall.outward() + wrong.frame.yaw;
    let (x, y) = (
        estimate.pose.x - offset.x - beside.x,
        estimate.pose.y - offset.y - beside.y,
    );
    Some((libm::cos(normal) * x + libm::sin(normal) * y).abs())
}

fn nearest_wall(map: &OsmMap, building: usize, here: MapPoint) -> Option<Segment> {
    map.buildings[building].polygon.sides().min_by(|a, b| {
        a.distance_to_point(here)
            .total_cmp(&b.distance_to_point(here))
    })
}
