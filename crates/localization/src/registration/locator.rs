//! Where the robot is on the map, from all that it saw since it was switched on.

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::Matrix3;
use openbench_core::{AcceptedPose, MapComparison, MapPoint, PlaceScores, Pose2, Start};
use openbench_geometry::Bounds;
use openbench_osm::OsmMap;

use super::candidates::{Candidate, SEEN_FROM_M, candidates, is_searchable};
use super::chart::Chart;
use super::estimate::{Estimate, Measured};
use super::field::{CELL_M, MARGIN_CELLS};
use super::hypothesis::{Acceptance, Hypothesis, Located, distinct};
use super::prior::Prior;
use super::refine::Assumptions;
use super::stretch::Stretch;
use super::submap::Submap;

/// So many of the last stretches are compared with the map: 40 m.
pub const STRETCHES: usize = 8;
/// A chart reaches farther than is needed at first by this, metres, so that it serves for a while.
const RESERVE_M: f64 = 50.0;
/// A pose that is more probable than all others together is presumed until one is accepted.
const PRESUMED: f64 = 0.5;
/// A pose explains what is seen if the closeness of facades that have a wall, less the share of
/// rays through walls, is at least this,
const EXPLAINED: f64 = 0.8;
/// and so many facades are on a wall for each that is near one and on none, as a logarithm. In a
/// street of parallel facades both hold along all of it: they say whether a known pose is still
/// right, and not which one is. Facades far from all walls count in neither: maps lack walls.
const ON_OVER_NEAR: f64 = 0.75;
/// Where the map shows walls in fewer directions, what is seen neither confirms a pose nor
/// contradicts it.
const IN_SIGHT: f64 = 0.1;
/// Once the robot is localized, so many poses in turn that explain too little, or are elsewhere,
/// say that it is not.
const DOUBTS: usize = 3;
/// After that the robot is this far from where it was estimated, metres;
const LOST_M: f64 = 75.0;
/// twice as far each time it drives this far and is not found, metres,
const WIDEN_M: f64 = 60.0;
/// and so often at most: the time of a search grows with the area.
const MOST_WIDENINGS: i32 = 2;

/// As many poses are shown of what was found,
const MOST_SHOWN_POSES: usize = 12;
/// and as many facades.
const MOST_SHOWN_FACADES: usize = 200;

/// How a locator judges.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Judgement {
    /// What is assumed of map and facades.
    pub assumed: Assumptions,
    /// When a pose is accepted.
    pub acceptance: Acceptance,
}

/// Finds out where the robot is.
#[derive(Debug, Clone)]
pub struct Locator {
    map: Arc<OsmMap>,
    bounds: Option<Bounds>,
    prior: Option<Prior>,
    /// Pose in `odom` that the prior is about,
    since: Option<Pose2>,
    /// and the newest one.
    here: Option<Pose2>,
    way: VecDeque<Stretch>,
    driven_m: f64,
    chart: Option<(Chart, Bounds)>,
    /// Poses that were compared last.
    candidates: Vec<Located>,
    /// Those of different places, and what confirmed them.
    bank: Vec<Hypothesis>,
    /// Facades that were compared last, in the frame of the robot at the end of the way.
    seen: Vec<MapPoint>,
    /// How well all places fitted, if it did not know where it was.
    places: Option<PlaceScores>,
    judgement: Judgement,
    /// The accepted pose by all fixes so far; `None` if the robot is not localized.
    estimate: Option<Estimate>,
    /// Whether what was seen last did not confirm it.
    is_refused: bool,
    /// What to go on with until a pose is accepted.
    presumed: Option<Estimate>,
    doubts: usize,
    /// Where the robot turned out not to be, if it was not found since.
    lost: Option<Lost>,
    /// How often it compared what was seen with the map.
    comparisons: u64,
}

/// A robot that turned out to be elsewhere.
#[derive(Debug, Clone, Copy)]
struct Lost {
    /// Where it was estimated,
    from: MapPoint,
    /// how far from there it can be at first, metres,
    radius_m: f64,
    /// and after how many metres that was.
    driven_m: f64,
    /// How often the area was doubled in which it is searched.
    widenings: i32,
}

impl Lost {
    /// Where it can be.
    fn prior(&self) -> Option<Prior> {
        Prior::new(&Start::Area {
            centre: self.from,
            radius_m: self.radius_m * f64::powi(2.0, self.widenings),
        })
    }
}

impl Locator {
    /// On a map, from what is known about the start.
    pub fn new(map: Arc<OsmMap>, start: &Start) -> Self {
        let boxes = map
            .buildings
            .iter()
            .map(|building| building.polygon.bounds());
        Self {
            bounds: boxes.reduce(Bounds::union),
            map,
            prior: Prior::new(start),
            since: None,
            here: None,
            way: VecDeque::new(),
            driven_m: 0.0,
            chart: None,
            candidates: Vec::new(),
            bank: Vec::new(),
            seen: Vec::new(),
            places: None,
            judgement: Judgement::default(),
            estimate: None,
            is_refused: false,
            presumed: None,
            doubts: 0,
            lost: None,
            comparisons: 0,
        }
    }

    /// The same with another judgement.
    #[must_use]
    pub fn judging(self, judgement: Judgement) -> Self {
        Self { judgement, ..self }
    }

    /// The buildings in whose coordinates candidates are.
    pub fn chart(&self) -> Option<&Chart> {
        self.chart.as_ref().map(|(chart, _)| chart)
    }

    /// All poses that were compared last, several of them at one place; their probabilities sum up
    /// to less than one.
    pub fn candidates(&self) -> &[Located] {
        &self.candidates
    }

    /// What may be true, one pose for each place, the most probable one first.
    pub fn hypotheses(&self) -> &[Hypothesis] {
        &self.bank
    }

    /// What was found when it last compared what was seen with the map.
    pub fn comparison(&self) -> MapComparison {
        let bank = self.bank.iter().take(MOST_SHOWN_POSES);
        let hypotheses = bank.map(|one| openbench_core::Hypothesis {
            pose: one.located.pose,
            probability: one.located.candidate.probability,
        });
        let hypotheses: Vec<_> = hypotheses.collect();
        let accepted = self.estimate.as_ref().map(|estimate| AcceptedPose {
            pose: estimate.pose,
            covariance: estimate.covariance().into(),
        });
        let known = accepted.map(|accepted| accepted.pose);
        let pose = known.or(hypotheses.first().map(|best| best.pose));
        let every = self.seen.len().div_ceil(MOST_SHOWN_FACADES).max(1);
        let seen = pose.into_iter().flat_map(|pose| {
            let some = self.seen.iter().step_by(every);
            some.map(move |at| pose.transform(at.x, at.y))
        });
        MapComparison {
            hypotheses,
            accepted,
            is_refused: self.is_refused,
            facades: seen.collect(),
            places: self.places.clone(),
        }
    }

    /// Whether a pose is accepted.
    pub fn is_located(&self) -> bool {
        self.estimate.is_some()
    }

    /// Whether the robot turned out not to be where it was estimated, and was not found since.
    pub fn is_lost(&self) -> bool {
        self.lost.is_some()
    }

    /// How often it compared what was seen with the map.
    pub fn comparisons(&self) -> u64 {
        self.comparisons
    }

    /// Searches anew, after the robot may have been carried away.
    pub fn lose(&mut self) {
        match self.estimate.take().or(self.presumed.take()) {
            Some(known) => self.give_up(&known),
            None => self.give_up_start(),
        }
    }

    /// Takes in that odometry contradicted itself. A known pose is given up as soon as what is seen
    /// next does not confirm it.
    pub fn distrust(&mut self) {
        if self.is_located() {
            self.forget_way();
            self.doubts = DOUBTS - 1;
        } else {
            self.lose();
        }
    }

    /// The accepted pose by all fixes so far, where the robot was last.
    pub fn estimate(&self) -> Option<&Estimate> {
        self.estimate.as_ref()
    }

    /// The newest pose that was more probable than all others together, while none is accepted.
    pub fn presumed(&self) -> Option<&Estimate> {
        self.presumed.as_ref()
    }

    /// Takes in a first look around, before a stretch has ended.
    pub fn look(&mut self, first: &Stretch) -> Option<Measured> {
        let submap = Submap::of(std::slice::from_ref(first));
        self.consider(&submap, &submap, first.end, &Matrix3::from(first.drift))
    }

    /// Takes in a stretch. If a pose is accepted, gives what the stretch says about the pose at its
    /// end; at first what all of them say.
    pub fn take(&mut self, stretch: Stretch) -> Option<Measured> {
        let (here, drift) = (stretch.end, Matrix3::from(stretch.drift));
        let newest = Submap::of(std::slice::from_ref(&stretch));
        self.driven_m += stretch.metres;
        self.way.push_back(stretch);
        if self.way.len() > STRETCHES {
            self.way.pop_front();
        }
        let submap = Submap::of(self.way.make_contiguous());
        self.consider(&submap, &newest, here, &drift)
    }

    /// Compares the last stretches, and the newest of them alone, with the map. `drift` is the
    /// covariance of the way since the stretch before.
    fn consider(
        &mut self,
        submap: &Submap,
        newest: &Submap,
        here: Pose2,
        drift: &Matrix3<f64>,
    ) -> Option<Measured> {
        self.here = Some(here);
        self.widen();
        let since = *self.since.get_or_insert(here);
        let prior = self.prior?.after(here.seen_from(since));
        self.reach(&prior)?;
        self.seen = submap.facades.iter().map(|facade| facade.at).collect();
        let (chart, _) = self.chart.as_ref()?;
        self.comparisons += 1;
        let found = candidates(chart, submap, &prior, &self.judgement.assumed);
        let landscape = found.landscape.filter(|_| self.estimate.is_none());
        self.places = landscape.and_then(|landscape| landscape.scores(chart, &prior));
        let located = found.candidates.into_iter().map(|candidate| Located {
            pose: chart.in_map(candidate.refined.pose),
            candidate,
        });
        self.candidates = located.collect();
        let (driven_m, earlier) = (self.driven_m, &self.bank);
        let places = distinct(&self.candidates).into_iter();
        let bank = places.map(|located| Hypothesis::found(located, here, driven_m, earlier));
        self.bank = bank.collect();
        let known = self.estimate.take();
        let was_located = known.is_some();
        let measured = match known {
            None => self.find(here),
            Some(known) => self.follow(known.carried(here, drift), newest),
        };
        self.is_refused = was_located && measured.is_none();
        self.presume(here);
        measured
    }

    /// Searches a robot that was not found for a while in a larger area.
    fn widen(&mut self) {
        let Some(lost) = &mut self.lost else { return };
        let due = ((self.driven_m - lost.driven_m) / WIDEN_M) as i32;
        let due = due.min(MOST_WIDENINGS);
        if due > lost.widenings {
            lost.widenings = due;
            self.prior = lost.prior();
        }
    }

    /// Makes the chart reach as far as the robot may see; `None` if it may be in too large an area.
    fn reach(&mut self, prior: &Prior) -> Option<()> {
        let bounds = self.bounds?;
        let area = prior.area(bounds);
        if !is_searchable(area.intersection(bounds.grown(SEEN_FROM_M))) {
            return None;
        }
        let is_inside = |reached: &Bounds| area.corners().iter().all(|at| reached.holds(*at, 0.0));
        if self
            .chart
            .as_ref()
            .is_none_or(|(_, reached)| !is_inside(reached))
        {
            let reached = area.grown(RESERVE_M);
            let seen = reached.grown(MARGIN_CELLS as f64 * CELL_M);
            let radius = seen.middle().distance(seen.high);
            let chart = Chart::around(&self.map, seen.middle(), radius);
            self.chart = Some((chart, reached));
        }
        Some(())
    }

    /// Believes the best hypothesis if it is certain.
    fn find(&mut self, here: Pose2) -> Option<Measured> {
        let best = self.bank.first();
        let best = best.filter(|best| best.is_accepted(self.judgement.acceptance))?;
        let estimate = self.estimate_of(&best.located.candidate, here)?;
        // Of the estimate, not of the candidate: what the next stretches add is measured from here.
        let measured = Measured {
            pose: estimate.pose,
            information: estimate.covariance().try_inverse()?,
        };
        self.lost = None;
        self.keep(estimate);
        Some(measured)
    }

    fn estimate_of(&self, candidate: &Candidate, here: Pose2) -> Option<Estimate> {
        let (chart, _) = self.chart.as_ref()?;
        Estimate::begin(chart, &candidate.refined, here, &self.judgement.assumed)
    }

    /// Presumes the best hypothesis if it is probable, as long as none is certain.
    fn presume(&mut self, here: Pose2) {
        if self.is_located() {
            self.presumed = None;
            return;
        }
        let best = self.bank.first().map(|best| &best.located.candidate);
        let best = best.filter(|best| best.probability >= PRESUMED);
        let presumed = best.and_then(|best| self.estimate_of(best, here));
        // What was presumed before is still the best that is known.
        self.presumed = presumed.or(self.presumed.take());
    }

    /// Improves what is known by the newest stretch, if the best hypothesis agrees.
    fn follow(&mut self, known: Estimate, newest: &Submap) -> Option<Measured> {
        let agreeing = self
            .bank
            .first()
            .map(|best| &best.located)
            .filter(|best| explains(&best.candidate) && known.agrees_with(&best.measured()));
        let improved = agreeing.zip(self.chart.as_ref());
        let improved = improved.and_then(|(best, (chart, _))| {
            let improved = known.with(chart, newest, &best.candidate.refined)?;
            let news = improved.news_since(&known)?;
            Some((improved, news))
        });
        let Some((improved, news)) = improved else {
            self.doubt(known);
            return None;
        };
        self.doubts = 0;
        self.keep(improved);
        Some(news)
    }

    /// A pose that was not confirmed is kept a few times.
    fn doubt(&mut self, known: Estimate) {
        let best = self.bank.first().map(|best| &best.located.candidate);
        let is_in_sight = best.is_some_and(|best| best.explained.towards >= IN_SIGHT);
        self.doubts += usize::from(is_in_sight);
        if self.doubts < DOUBTS {
            self.keep(known);
        } else {
            self.give_up(&known);
        }
    }

    /// The robot is searched near an estimate from now on.
    fn keep(&mut self, estimate: Estimate) {
        let covariance = estimate.covariance();
        let start = Start::Pose {
            pose: estimate.pose,
            covariance: std::array::from_fn(|i| std::array::from_fn(|j| covariance[(i, j)])),
        };
        self.prior = Prior::new(&start);
        self.since = Some(estimate.here);
        self.estimate = Some(estimate);
    }

    /// Begins anew near where the robot was estimated.
    fn give_up(&mut self, known: &Estimate) {
        self.search_around(known.pose.point(), LOST_M, known.here);
    }

    /// The same where nothing but the start is known. One that may be anywhere still may.
    fn give_up_start(&mut self) {
        let (Some(prior), Some(since), Some(here)) = (self.prior, self.since, self.here) else {
            return self.forget_way();
        };
        let area = prior
            .after(here.seen_from(since))
            .area(Bounds::of_point(MapPoint::default()));
        if prior.is_bounded() {
            let radius = area.middle().distance(area.high) + LOST_M;
            self.search_around(area.middle(), radius, here);
        } else {
            self.forget_way();
        }
    }

    fn search_around(&mut self, from: MapPoint, radius_m: f64, here: Pose2) {
        self.forget_way();
        let lost = Lost {
            from,
            radius_m,
            driven_m: self.driven_m,
            widenings: 0,
        };
        self.prior = lost.prior();
        self.lost = Some(lost);
        self.since = Some(here);
    }

    /// If the robot was carried, odometry does not know where the stretches before are.
    fn forget_way(&mut self) {
        self.doubts = 0;
        self.presumed = None;
        self.candidates.clear();
        self.bank.clear();
        self.way.clear();
    }
}

/// Whether what is seen agrees with a pose, wherever that is along parallel facades.
fn explains(candidate: &Candidate) -> bool {
    let closeness = candidate.refined.closeness_of_matched();
    closeness - candidate.explained.through >= EXPLAINED
        && candidate.nearness.on_over_near() >= ON_OVER_NEAR
}

#[cfg(test)]
mod tests {
    use openbench_geometry::Polygon;

    use super::super::town::{block, map, village, way};
    use super::*;

    /// Poses along a road, five metres apart.
    fn road(from: f64, y: f64, count: usize) -> Vec<Pose2> {
        let at = |i: usize| Pose2::new(from + 5.0 * i as f64, y, 0.05 * libm::sin(i as f64));
        (0..count).map(at).collect()
    }

    fn locator(houses: &[Polygon], start: Start) -> Locator {
        Locator::new(Arc::new(map(houses)), &start)
    }

    /// Drives along poses; gives what is accepted at each.
    fn driven(locator: &mut Locator, houses: &[Polygon], poses: &[Pose2]) -> Vec<Option<Measured>> {
        let stretches = way(houses, poses);
        stretches
            .into_iter()
            .map(|stretch| locator.take(stretch))
            .collect()
    }

    #[test]
    fn a_robot_that_knows_nothing_finds_itself_on_its_way() {
        let town = village(7);
        let poses = road(-40.0, 50.0, 12);
        let mut locator = locator(&town, Start::Anywhere);
        let found = driven(&mut locator, &town, &poses);
        let last = found.last().unwrap().as_ref().expect("it is localized");
        let truth = poses[poses.len() - 1];
        assert!(
            last.pose.point().distance(truth.point()) < 0.3,
            "{:?}",
            last.pose
        );
        for (located, truth) in found.iter().zip(&poses) {
            let error = located
                .as_ref()
                .map_or(0.0, |one| one.pose.point().distance(truth.point()));
            assert!(error < 0.5, "{error}");
        }
    }

    #[test]
    fn in_another_town_nothing_is_accepted() {
        // The same rows of houses, but other houses; with more than one town, since in few of them
        // a good part of the houses is alike.
        let towns = (0..12).map(|i| (100 + i, 200 + i)).chain([(7, 8)]);
        for (driven_in, mapped) in towns {
            let mut locator = locator(&village(mapped), Start::Anywhere);
            let town = village(driven_in);
            let found = driven(&mut locator, &town, &road(-40.0, 50.0, 12));
            assert!(found.iter().all(Option::is_none), "{driven_in}: {found:#?}");
        }
    }

    #[test]
    fn among_equal_houses_nothing_is_accepted() {
        // Two endless rows: each place is as all others.
        let row = |y: f64| (-20..20).map(move |i| block(f64::from(i) * 14.0, y, 8.0, 8.0));
        let houses: Vec<_> = row(-10.0).chain(row(10.0)).collect();
        let mut locator = locator(&houses, Start::Anywhere);
        let found = driven(&mut locator, &houses, &road(-30.0, 0.0, 12));
        assert!(found.iter().all(Option::is_none));
        assert_eq!(locator.presumed(), None);
    }

    #[test]
    fn beside_a_single_house_nothing_is_accepted() {
        // From its opposite sides a rectangle looks the same.
        let house = [block(0.0, -12.0, 16.0, 9.0)];
        let mut locator = locator(&house, Start::Anywhere);
        let found = driven(&mut locator, &house, &road(-30.0, 0.0, 12));
        assert!(found.iter().all(Option::is_none), "{found:#?}");
    }

    #[test]
    fn in_a_symmetric_courtyard_nothing_is_accepted() {
        let wide = [-20.0, 20.0].map(|y| block(0.0, y, 30.0, 8.0));
        let deep = [-20.0, 20.0].map(|x| block(x, 0.0, 8.0, 30.0));
        let court = [wide, deep].concat();
        let mut locator = locator(&court, Start::Anywhere);
        let found = driven(&mut locator, &court, &road(-9.0, 3.0, 4));
        assert!(found.iter().all(Option::is_none), "{found:#?}");
        // Each of the four sides is as good as the others.
        assert!(locator.hypotheses().len() >= 4);
        assert_eq!(locator.presumed(), None);
    }

    #[test]
    fn among_ten_thousand_houses_it_finds_itself_within_a_block() {
        // Villages side by side.
        let village_at = |tile: u64| {
            let (x, y) = (160.0 * (tile % 16) as f64, 160.0 * (tile / 16) as f64);
            village(tile).into_iter().map(move |house| {
                let moved = |at: &MapPoint| MapPoint::new(at.x + x, at.y + y);
                Polygon::new(house.outer.iter().map(moved).collect(), Vec::new()).unwrap()
            })
        };
        let houses: Vec<_> = (0..256).flat_map(village_at).collect();
        assert!(houses.len() >= 10_000, "{}", houses.len());
        let poses = road(1240.0, 1330.0, 12);
        let start = Start::Area {
            centre: MapPoint::new(1280.0, 1300.0),
            radius_m: 75.0,
        };
        let mut locator = locator(&houses, start);
        // What it sees is near.
        let is_near = |house: &&Polygon| house.outer[0].distance(poses[6].point()) < 120.0;
        let near: Vec<Polygon> = houses.iter().filter(is_near).cloned().collect();
        driven(&mut locator, &near, &poses);
        let found = locator.estimate().expect("it is localized").pose;
        let error = found.point().distance(poses[11].point());
        assert!(error < 0.3, "{error}");
    }

    #[test]
    fn what_is_only_probable_is_presumed_until_a_pose_is_accepted() {
        // The start says which of the equal houses it is, though not for sure.
        let row = |y: f64| (-20..20).map(move |i| block(f64::from(i) * 14.0, y, 8.0, 8.0));
        let houses: Vec<_> = row(-10.0).chain(row(10.0)).collect();
        let variance = |deviation: f64| deviation * deviation;
        let start = Start::Pose {
            pose: Pose2::new(-28.0, 1.0, 0.1),
            covariance: [
                [variance(5.0), 0.0, 0.0],
                [0.0, variance(5.0), 0.0],
                [0.0, 0.0, variance(0.2)],
            ],
        };
        let mut locator = locator(&houses, start);
        let poses = road(-30.0, 0.0, 4);
        let found = driven(&mut locator, &houses, &poses);
        assert!(found.iter().all(Option::is_none), "{found:#?}");
        let presumed = locator.presumed().expect("one house is the most probable");
        let away = presumed.pose.point().distance(poses[3].point());
        assert!(away < 0.5, "{away}");
        locator.lose();
        assert_eq!(locator.presumed(), None);
    }

    /// A robot that was carried to another road, while odometry went on, and what it sees there.
    fn carried_away() -> (Locator, Vec<Stretch>) {
        let town = village(7);
        let start = Start::exact(Pose2::new(-40.0, 50.0, 0.0));
        let mut locator = locator(&town, start);
        driven(&mut locator, &town, &road(-40.0, 50.0, 8));
        assert!(locator.is_located());
        let carried = Pose2::new(35.0, 0.0, 0.0);
        let there = way(&town, &road(-30.0, 100.0, 16));
        let there = there.iter().map(|stretch| stretch.moved(carried)).collect();
        (locator, there)
    }

    /// The same way, on which nothing is seen that tells where it is.
    fn blind(stretch: &Stretch) -> Stretch {
        Stretch {
            facades: Vec::new(),
            panoramas: Vec::new(),
            ..stretch.clone()
        }
    }

    /// After how many stretches it notices.
    fn notices(locator: &mut Locator, there: Vec<Stretch>) -> Option<usize> {
        let mut noticed = None;
        for (number, stretch) in there.into_iter().enumerate() {
            locator.take(stretch);
            assert_eq!(locator.is_lost(), !locator.is_located());
            if locator.is_lost() {
                noticed = noticed.or(Some(number + 1));
            }
        }
        noticed
    }

    #[test]
    fn a_robot_that_was_carried_away_notices() {
        let (mut locator, there) = carried_away();
        assert!(!locator.comparison().is_refused);
        let mut doubts = 0;
        for stretch in &there {
            locator.take(stretch.clone());
            if locator.is_lost() {
                break;
            }
            doubts += usize::from(locator.comparison().is_refused);
        }
        assert!(doubts >= DOUBTS - 1, "{doubts}");
        let (mut locator, there) = carried_away();
        let stretches = notices(&mut locator, there);
        assert!(
            stretches.is_some_and(|count| count >= DOUBTS),
            "{stretches:?}"
        );
    }

    #[test]
    fn after_odometry_contradicted_itself_it_notices_at_once() {
        let (mut locator, there) = carried_away();
        locator.distrust();
        assert!(locator.is_located());
        assert_eq!(notices(&mut locator, there), Some(1));
    }

    #[test]
    fn a_robot_that_is_not_found_is_searched_in_a_larger_area() {
        let (mut locator, there) = carried_away();
        locator.lose();
        let radius = |locator: &Locator| match locator.prior.unwrap().start() {
            Start::Area { radius_m, .. } => *radius_m,
            other => panic!("{other:?}"),
        };
        assert_eq!(radius(&locator), LOST_M);
        let way = there.iter().cycle().take(60).map(blind);
        let radii: Vec<f64> = way
            .map(|stretch| {
                locator.take(stretch);
                radius(&locator)
            })
            .collect();
        assert!(radii.contains(&(2.0 * LOST_M)));
        assert_eq!(radii.last(), Some(&(4.0 * LOST_M)));
    }

    #[test]
    fn a_robot_that_was_carried_away_before_it_was_found_is_searched_farther_off() {
        let town = village(7);
        let mut locator = locator(&town, Start::exact(Pose2::new(-40.0, 50.0, 0.0)));
        let nothing = blind(&way(&town, &road(-40.0, 50.0, 1))[0]);
        assert_eq!(locator.look(&nothing), None);
        locator.lose();
        assert!(locator.is_lost());
        let there = road(-30.0, 100.0, 12);
        driven(&mut locator, &town, &there);
        let found = locator.estimate().expect("it is found").pose;
        let error = found.point().distance(there[11].point());
        assert!(error < 0.3, "{error}");
    }

    #[test]
    fn a_robot_that_may_be_anywhere_still_may_when_it_is_lost() {
        let town = village(7);
        let mut locator = locator(&town, Start::Anywhere);
        locator.look(&blind(&way(&town, &road(-40.0, 50.0, 1))[0]));
        locator.lose();
        assert_eq!(locator.prior.unwrap().start(), &Start::Anywhere);
    }

    #[test]
    fn walls_that_no_map_shows_do_not_end_what_is_known() {
        let town = village(7);
        let mut locator = locator(&town, Start::exact(Pose2::new(-40.0, 50.0, 0.0)));
        driven(&mut locator, &town, &road(-40.0, 50.0, 6));
        assert!(locator.is_located());
        // Further along the road, walls hide many of the houses.
        let wall = |i: usize, y: f64| block(-5.0 + 12.0 * i as f64, 50.0 + y, 9.0, 0.4);
        let walls = (0..8).flat_map(|i| [wall(i, -3.0), wall(i, 3.0)]);
        let walled: Vec<Polygon> = town.iter().cloned().chain(walls).collect();
        let (before, after) = (road(-40.0, 50.0, 6), road(-10.0, 50.0, 10));
        let odom = after[0].seen_from(before[0]);
        for stretch in way(&walled, &after) {
            locator.take(stretch.moved(odom));
            assert!(locator.is_located());
        }
    }

    #[test]
    fn too_large_an_area_is_not_searched() {
        let far = [
            block(0.0, 0.0, 10.0, 10.0),
            block(9000.0, 9000.0, 10.0, 10.0),
        ];
        let mut anywhere = locator(&far, Start::Anywhere);
        driven(&mut anywhere, &far, &road(-20.0, 10.0, 2));
        assert!(anywhere.chart().is_none() && anywhere.comparisons() == 0);
        let mut here = locator(&far, Start::exact(Pose2::new(-20.0, 10.0, 0.0)));
        driven(&mut here, &far, &road(-20.0, 10.0, 2));
        assert_eq!(here.comparisons(), 2);
    }

    #[test]
    fn without_buildings_or_a_start_nothing_is_accepted() {
        let town = village(7);
        let poses = road(-40.0, 50.0, 3);
        let nan = Start::exact(Pose2::new(f64::NAN, 0.0, 0.0));
        let mut none = locator(&town, nan);
        assert!(driven(&mut none, &town, &poses).iter().all(Option::is_none));
        let mut empty = locator(&[], Start::Anywhere);
        assert!(
            driven(&mut empty, &town, &poses)
                .iter()
                .all(Option::is_none)
        );
        let mut blind = locator(&town, Start::Anywhere);
        let mut nothing = way(&town, &poses[..1]).remove(0);
        nothing.facades.clear();
        nothing.panoramas.clear();
        assert_eq!(blind.look(&nothing), None);
        nothing.end = Pose2::new(f64::NAN, f64::NAN, f64::NAN);
        assert_eq!(blind.take(nothing), None);
    }
}
