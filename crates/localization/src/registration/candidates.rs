//! Poses that could be the robot's, and how probable each of them is.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::Bounds;

use super::chart::Chart;
use super::explain::{Explained, explain};
use super::field::Field;
use super::landscape::Landscape;
use super::modes::{Mode, distinct, modes};
use super::nearness::Nearness;
use super::prior::Prior;
use super::probability::{FEATURES, Features, Merits, probabilities};
use super::refine::{Assumptions, Refined, refine};
use super::submap::Submap;
use super::vote::Evidence;

/// Large areas are searched in squares of this side, metres,
const SQUARE_M: f64 = 400.0;
/// and so many of them at most: two by two kilometres.
const MOST_SQUARES: usize = 25;
/// So many modes of a vote are refined.
const MOST_MODES: usize = 8;
/// Refined poses nearer than this are one, metres,
const SAME_M: f64 = 1.0;
/// if their headings differ less than this, radians.
const SAME_RAD: f64 = 0.1;
/// Around all buildings of a chart, a robot sees some of them from so far, metres.
pub(super) const SEEN_FROM_M: f64 = 40.0;

/// A pose that could be the robot's.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The pose and what it was refined from.
    pub refined: Refined,
    /// Where facades are relative to walls.
    pub nearness: Nearness,
    /// What it explains of the free ground.
    pub explained: Explained,
    /// What the vote and the prior said about it, nats.
    pub cost: f64,
    /// What the prior says about it once it is refined, nats.
    pub prior: f64,
    /// What its probability is computed from.
    pub features: Features,
    /// Probability that it is the robot's pose. Those of all candidates sum up to less than one:
    /// the robot may be at none of them.
    pub probability: f64,
}

/// What a search found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Found {
    /// The most probable poses, the best one first.
    pub candidates: Vec<Candidate>,
    /// What all places cost; `None` where there are none.
    pub landscape: Option<Landscape>,
}

/// Searches a robot that sees a submap. Finds nothing where nothing is seen of a building, or where
/// the area in which it can be is larger than two by two kilometres.
pub fn candidates(chart: &Chart, submap: &Submap, prior: &Prior, assumed: &Assumptions) -> Found {
    let Some(area) = searched(chart, prior) else {
        return Found::default();
    };
    let evidence = Evidence::of(submap);
    let (modes, landscape) = voted(chart, area, &evidence, prior);
    let mut candidates: Vec<Candidate> = Vec::new();
    for mode in modes {
        let Some(refined) = refine(chart, submap, mode.pose, assumed) else {
            continue;
        };
        let is_known = candidates
            .iter()
            .any(|one| is_same(one.refined.pose, refined.pose));
        let beforehand = prior.cost(chart.in_map(refined.pose));
        if is_known || beforehand.is_infinite() {
            continue;
        }
        let nearness = Nearness::of(chart, submap, &refined);
        let explained = explain(chart, submap, &refined);
        candidates.push(Candidate {
            refined,
            nearness,
            explained,
            cost: mode.cost,
            prior: beforehand,
            features: [0.0; FEATURES],
            probability: 0.0,
        });
    }
    judge(&mut candidates, &evidence, prior, area);
    Found {
        candidates,
        landscape: Some(landscape),
    }
}

/// Gives candidates their probabilities, and puts the best one first.
fn judge(candidates: &mut [Candidate], evidence: &Evidence, prior: &Prior, area: Bounds) {
    let volume = prior.volume(area);
    let costs = candidates.iter().map(|one| one.cost);
    let least = costs.fold(f64::INFINITY, f64::min);
    let misfits = candidates.iter().map(|one| one.refined.misfit);
    let least_misfit = misfits.fold(f64::INFINITY, f64::min);
    for one in candidates.iter_mut() {
        let merits = Merits {
            refined: &one.refined,
            nearness: one.nearness,
            explained: &one.explained,
            more: one.cost - least,
            more_misfit: one.refined.misfit - least_misfit,
            pieces: evidence.facades(),
            surprise: one.prior + libm::log(1.0 + volume),
        };
        one.features = merits.features();
    }
    let features: Vec<Features> = candidates.iter().map(|one| one.features).collect();
    let found = probabilities(&features, prior.is_bounded());
    for (one, probability) in candidates.iter_mut().zip(found) {
        one.probability = probability;
    }
    candidates.sort_by(|a, b| b.probability.total_cmp(&a.probability));
}

/// The area in which a robot can be and sees a building, in the chart's coordinates.
fn searched(chart: &Chart, prior: &Prior) -> Option<Bounds> {
    let bounds = chart.bounds()?;
    let shifted = |bounds: Bounds, x: f64, y: f64| Bounds {
        low: MapPoint::new(bounds.low.x + x, bounds.low.y + y),
        high: MapPoint::new(bounds.high.x + x, bounds.high.y + y),
    };
    let origin = chart.origin;
    let allowed = prior.area(shifted(bounds, origin.x, origin.y));
    Some(shifted(allowed, -origin.x, -origin.y).intersection(bounds.grown(SEEN_FROM_M)))
}

/// The modes of a vote over all places of an area where the robot can be, and a picture of it.
fn voted(
    chart: &Chart,
    area: Bounds,
    evidence: &Evidence,
    prior: &Prior,
) -> (Vec<Mode>, Landscape) {
    let cost = |pose: Pose2| prior.cost(chart.in_map(pose));
    let mut landscape = Landscape::over(area);
    let squares = squares(area);
    let found = squares.into_iter().flat_map(|square| {
        let field = Field::over(chart, square);
        let voted = modes(&field, evidence, &prior.headings(), &cost, MOST_MODES);
        landscape.take(&field, &voted.least);
        voted.modes
    });
    let modes = distinct(found.collect(), MOST_MODES);
    (modes, landscape)
}

/// Whether an area is small enough to search it: two by two kilometres at most.
pub(super) fn is_searchable(area: Bounds) -> bool {
    !squares(area).is_empty()
}

/// An area in squares; none if it would be too many.
fn squares(area: Bounds) -> Vec<Bounds> {
    let (width, height) = (area.high.x - area.low.x, area.high.y - area.low.y);
    let count = |length: f64| (length / SQUARE_M).ceil();
    let (columns, rows) = (count(width), count(height));
    // Of a box that is empty or not finite as well.
    let is_some = columns >= 1.0 && rows >= 1.0 && columns * rows <= MOST_SQUARES as f64;
    if !is_some {
        return Vec::new();
    }
    let (columns, rows) = (columns as usize, rows as usize);
    let corner = |column: usize, row: usize| {
        let (x, y) = (column as f64 / columns as f64, row as f64 / rows as f64);
        MapPoint::new(area.low.x + x * width, area.low.y + y * height)
    };
    let square = |i: usize| Bounds {
        low: corner(i % columns, i / columns),
        high: corner(i % columns + 1, i / columns + 1),
    };
    (0..columns * rows).map(square).collect()
}

fn is_same(a: Pose2, b: Pose2) -> bool {
    a.is_near(b, SAME_M, SAME_RAD)
}

#[cfg(test)]
mod tests {
    use openbench_core::Start;

    use super::super::town::{chart, stretch_at, town};
    use super::*;

    fn seen_from(pose: Pose2) -> Submap {
        Submap::of(&[stretch_at(&town(), pose)])
    }

    #[test]
    fn the_best_candidate_is_where_the_robot_is() {
        let truth = Pose2::new(5.0, 2.0, 2.5);
        let mut chart = chart(&town());
        // The town is far from the map's origin.
        chart.origin = MapPoint::new(3e5, 5e6);
        let prior = Prior::new(&Start::Anywhere).unwrap();
        let found = candidates(&chart, &seen_from(truth), &prior, &Assumptions::default());
        let found = found.candidates;
        let error = found[0].refined.pose.point().distance(truth.point());
        assert!(error < 0.05, "{error}");
        assert!(found[0].explained.met > 0.9);
    }

    #[test]
    fn a_prior_that_excludes_the_town_leaves_no_candidate() {
        let start = Start::exact(Pose2::new(1000.0, 0.0, 0.0));
        let prior = Prior::new(&start).unwrap();
        let seen = seen_from(Pose2::default());
        let found = candidates(&chart(&town()), &seen, &prior, &Assumptions::default());
        assert!(found.candidates.is_empty());
    }

    #[test]
    fn areas_are_covered_by_squares_and_too_large_ones_are_not_searched() {
        let area = |x: f64, y: f64| Bounds {
            low: MapPoint::new(-x, -y),
            high: MapPoint::new(x, y),
        };
        assert_eq!(squares(area(100.0, 50.0)), [area(100.0, 50.0)]);
        let six = squares(area(500.0, 300.0));
        assert_eq!(six.len(), 6);
        let joined = six.into_iter().reduce(Bounds::union).unwrap();
        assert_eq!(joined, area(500.0, 300.0));
        assert!(squares(area(1e9, 1e9)).is_empty());
        assert!(squares(area(-1.0, 50.0)).is_empty());
        assert!(squares(area(f64::NAN, 50.0)).is_empty());
    }
}
