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
        let known = self.prior.filter(Prior::is_bounded).zip(self.since);
        let (Some((prior, since)), Some(here), Some(map)) = (known, self.here, self.bounds) else {
            return self.forget_way();
        };
        let area = prior.after(here.seen_from(since)).area(map);
        let radius = area.middle().distance(area.high) + LOST_M;
        self.search_around(area.middle(), radius, here);
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
mod tests;
