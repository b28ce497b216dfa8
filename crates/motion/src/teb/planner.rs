//! The planner: several bands at once, one for each class of ways, the best of them driven.

use openbench_core::{MapPoint, RobotDescription, SimTime, Velocity, frames::wrap_angle};

use crate::checks::{SettingsError, finite, positive};
use crate::feasible::{clearance, first_conflict};
use crate::limits::Limits;
use crate::local::{Blocked, Entry, LocalPlanner, PathPoint, PlannerSettings, Progress, Situation, ahead};
use crate::people::caution::Hesitation;
use crate::recovery::leave::{KEEP, leave};
use crate::recovery::maneuver::maneuver;
use crate::shape::{Footprint, Obstacle, ShapeError};
use crate::teb::classes::{Clusters, Explorer, Exploring, Passing, Signature};
use crate::teb::optimize::{Effort, Optimizer};
use crate::teb::settings::Settings;
use crate::teb::terms::Problem;
use crate::trajectory::Band;

mod command;

/// A goal that moves further than this at once is another one, metres.
const ELSEWHERE: f64 = 1.0;
/// Distance from obstacles that a motion has to keep to be driven, metres.
const SURE: f64 = 0.003;
/// Seconds until a conflict below which a band is not driven any further.
const TOO_LATE: f64 = 1.0;
/// Where anybody moves a band that comes nearer to anything than this is not taken for one that was driven and does not, metres: a robot does not drive quite
/// as foreseen, and they do not wait. Wary robots need it not: they are slow where somebody might come nearer.
const FIRM: f64 = 0.015;
/// A robot that is nearer to something than the first gets off it before it plans on, until it is as far as the second, metres.
const WEDGED: (f64, f64) = (0.004, 0.01);
/// Seconds of a motion off something that need not be driven to their end.
const DONE: f64 = 0.03;
/// Cost by which a band with a conflict is worse than any without.
const CONFLICT: f64 = 1e6;
/// A band that costs more than this share, and this, of what it did a cycle ago is begun anew beside itself.
const TANGLED: (f64, f64) = (1.3, 1.0);
/// A band with a stretch that takes this many times as long as it says, at the robot's speeds, is none that can be driven.
const LATER: f64 = 1.5;
/// Seconds that the robot may wait for somebody to pass.
const WAITS: [f64; 3] = [1.0, 2.5, 5.0];
/// Seconds until a maneuver is looked for again.
const SEARCH_AGAIN: f64 = 1.0;
/// Points to pass by, at most.
const MOST_VIAS: f64 = 40.0;
/// The robot begins its last turn once it is within this share of the tolerance, for it may slip.
const WELL_WITHIN: f64 = 0.7;

/// How the planner works.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TebSettings {
    /// What shapes a band.
    pub band: Settings,
    /// How classes are found; its `keep` and `comfort` are set from the footprint and the margins of bands.
    pub exploring: Exploring,
    /// Length of the way that is planned ahead, metres.
    pub horizon: f64,
    /// Another band is driven only if it costs less than this share of the one that is.
    pub hysteresis: f64,
    /// Distance from the end with which the robot has arrived, metres.
    pub tolerance: f64,
    /// Heading error at the end with which the robot has arrived, radians.
    pub yaw_tolerance: f64,
    /// Distance between points of the way that bands pass by, metres, as firmly as [`Weights::via`] says, which is not at all by default: ways are only hints where to go.
    ///
    /// [`Weights::via`]: crate::teb::settings::Weights::via
    pub via: Option<f64>,
    /// Side that is preferred where the robot turns by more than two radians: left if more than nothing, right if less. [`Weights::side`] says how much turning to the other side at the beginning of a band costs beside that.
    ///
    /// [`Weights::side`]: crate::teb::settings::Weights::side
    pub side: f64,
    /// How much faster than foreseen somebody may come at the robot, m/s: near those who move it is only as fast as lets it stand when they are there, and it does not run from them, since people walk round what stands; and when it stands near somebody it looks for half a second before it sets out. [`Margins::moving`] should be 0.3 m then, so that bands pass by people as far as that lets them. None by default: where all is foreseen exactly it may pass closely, and gets out of the way.
    ///
    /// [`Margins::moving`]: crate::teb::settings::Margins::moving
    pub surprise: Option<f64>,
    /// Seconds that somebody who walks needs to stop: the robot does not drive into ground that somebody will be on by then. None by default: where all is foreseen exactly it may pass before somebody closely.
    pub yields: Option<f64>,
}

impl Default for TebSettings {
    fn default() -> Self {
        Self {
            band: Settings::default(),
            exploring: Exploring::default(),
            horizon: 4.0,
            hysteresis: 0.9,
            tolerance: 0.1,
            yaw_tolerance: 0.08,
            via: None,
            side: 0.0,
            surprise: None,
            yields: None,
        }
    }
}

impl TebSettings {
    /// Whether a planner can work like that.
    pub fn check(&self) -> Result<(), SettingsError> {
        self.band.check()?;
        positive("the horizon", self.horizon)?;
        positive("the tolerance", self.tolerance)?;
        positive("the tolerance of heading", self.yaw_tolerance)?;
        if !(self.hysteresis > 0.0 && self.hysteresis <= 1.0) {
            let wanted = "give more than nothing, and 1 at most";
            return Err(SettingsError { name: "the hysteresis", value: self.hysteresis, wanted });
        }
        positive("the distance between points to pass by", self.via.unwrap_or(1.0))?;
        finite("the preferred side", self.side)?;
        positive("the speed of a surprise", self.surprise.unwrap_or(1.0))?;
        positive("the time that somebody needs to stop", self.yields.unwrap_or(1.0))?;
        self.exploring.check()
    }
}

/// A planner cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TebError {
    /// A limit or a setting makes no sense.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The footprint is none.
    #[error(transparent)]
    Footprint(#[from] ShapeError),
}

/// Its entry among the local planners.
pub fn entry() -> Entry {
    entry_with(TebSettings::default())
}

/// Its entry with settings of one's own.
pub fn entry_with(own: TebSettings) -> Entry {
    Entry::new("teb", "Timed Elastic Bands in several classes of ways", move |settings: &PlannerSettings| {
        Teb::new(&settings.robot, own)
    })
}

/// A band that is kept from cycle to cycle.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The band.
    pub band: Band,
    /// Its class.
    pub signature: Signature,
    /// What is left of its cost.
    pub cost: f64,
    /// Seconds until it meets something, if it does.
    pub conflict: Option<f64>,
    /// Whether it suddenly costs much more than before: it may have got into a knot that small steps do not undo.
    pub tangled: bool,
}

impl Candidate {
    fn worth(&self) -> f64 {
        self.cost + self.conflict.map_or(0.0, |at| CONFLICT / (1.0 + at))
    }
}

/// Timed Elastic Bands in distinctive topologies.
#[derive(Debug)]
pub struct Teb {
    footprint: Footprint,
    limits: Limits,
    settings: TebSettings,
    optimizer: Optimizer,
    explorer: Explorer,
    clusters: Clusters,
    /// The one that is driven comes first.
    candidates: Vec<Candidate>,
    last: Option<(SimTime, MapPoint)>,
    turning: bool,
    /// Whether the robot is getting off something that is all but touched.
    wedged: bool,
    /// The motion by which it does.
    way_out: Option<Band>,
    /// When a maneuver was last looked for.
    searched: Option<SimTime>,
    hesitation: Hesitation,
}

/// Where a band is to end.
#[derive(Debug, Clone, Copy)]
struct End {
    point: MapPoint,
    yaw: Option<f64>,
    stops: bool,
}

impl Teb {
    /// A planner for a robot.
    pub fn new(robot: &RobotDescription, settings: TebSettings) -> Result<Self, TebError> {
        settings.check()?;
        let footprint = Footprint::of(robot)?;
        let limits = Limits::of(robot)?;
        let mut settings = settings;
        settings.exploring.keep = footprint.inscribed();
        settings.exploring.comfort = footprint.inscribed() + settings.band.margins.comfort;
        Ok(Self {
            footprint,
            limits,
            settings,
            optimizer: Optimizer::default(),
            explorer: Explorer::default(),
            clusters: Clusters::default(),
            candidates: Vec::new(),
            last: None,
            turning: false,
            wedged: false,
            way_out: None,
            searched: None,
            hesitation: Hesitation::default(),
        })
    }

    /// The bands of the last cycle, the one that is driven first.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    fn end(&self, situation: &Situation<'_>) -> End {
        let from = situation.pose.point();
        let PathPoint { point, is_end: last } = ahead(situation.path, from, self.settings.horizon)
            .unwrap_or(PathPoint { point: from, is_end: true });
        End { point, yaw: situation.final_yaw.filter(|_| last), stops: last }
    }

    /// Moves the bands on to now: from where they had the robot by now to where it believes to be.
    fn carry_on(&mut self, situation: &Situation<'_>, end: &End) {
        let elapsed = self.last.map_or(0.0, |(time, _)| situation.time.since(time).as_secs_f64());
        let elsewhere = self.last.is_none_or(|(_, point)| point.distance(end.point) > ELSEWHERE);
        if elsewhere {
            self.candidates.clear();
        }
        let expected = self.candidates.first().map(|c| c.band.pose_at(elapsed));
        let jumped = expected.filter(|expected| Band::is_jump(*expected, situation.pose));
        for candidate in &mut self.candidates {
            if let Some(expected) = jumped {
                candidate.band.carry(expected, situation.pose);
            }
            candidate.band.advance(situation.pose, elapsed);
            candidate.band.set_end(end.point, end.yaw);
        }
        self.last = Some((situation.time, end.point));
    }

    /// Finds classes and begins a band for each that has none.
    fn explore(&mut self, situation: &Situation<'_>, end: &End) -> Vec<Candidate> {
        let start = situation.pose.point();
        let how = self.settings.exploring;
        let (moving, standing): (Vec<Obstacle>, Vec<Obstacle>) =
            situation.obstacles.iter().cloned().partition(Obstacle::is_moving);
        let mut ways = self.explorer.explore(start, end.point, &standing, &how);
        self.clusters = self.explorer.take_clusters();
        self.clusters.set_moving(&moving, start);
        for candidate in &mut self.candidates {
            candidate.signature = signature(&self.clusters, &candidate.band);
        }
        if !moving.is_empty() {
            let met = moving.iter().map(|o| self.when_met(o)).chain(standing).collect::<Vec<_>>();
            ways.extend(self.explorer.explore(start, end.point, &met, &how));
        }
        let side = self.settings.side;
        let along = |corners: &[MapPoint]| Band::along(situation.pose, corners, end.yaw, &self.limits, side);
        let mut drafts: Vec<Band> = ways.iter().filter_map(|way| along(&way.corners[1..])).collect();
        if let Some(driven) = self.candidates.first().filter(|c| c.conflict.is_some() && !moving.is_empty()) {
            drafts.extend(WAITS.iter().filter_map(|wait| driven.band.delayed(*wait)));
        }
        self.of_new_classes(drafts)
    }

    /// With a way to drive, one new band a cycle is soon enough: cycles should all take about as long.
    fn of_new_classes(&self, drafts: Vec<Band>) -> Vec<Candidate> {
        let most = self.settings.exploring.most;
        let at_once = if self.leads() { 1 } else { most };
        let mut new: Vec<Candidate> = Vec::new();
        for band in drafts {
            let signature = signature(&self.clusters, &band);
            let known = self.candidates.iter().chain(&new).any(|c| c.signature == signature && !c.tangled);
            let room = new.len() < at_once && self.candidates.len() + new.len() < most;
            if !known && room {
                new.push(Candidate { band, signature, cost: 0.0, conflict: None, tangled: false });
            }
        }
        new
    }

    /// A moving obstacle where the band that is driven meets it.
    fn when_met(&self, obstacle: &Obstacle) -> Obstacle {
        let Some(band) = self.candidates.first().filter(|_| obstacle.is_moving()).map(|c| &c.band) else {
            return obstacle.clone();
        };
        let v = obstacle.velocity();
        let middle = obstacle.middle();
        let apart = |time: f64| {
            MapPoint::new(middle.x + v.x * time, middle.y + v.y * time).distance(band.pose_at(time).point())
        };
        let times = band.knots().iter().map(|k| k.time);
        obstacle.after(times.min_by(|a, b| apart(*a).total_cmp(&apart(*b))).unwrap_or(0.0))
    }

    /// Points of the way within the horizon that bands pass by.
    fn vias(&self, situation: &Situation<'_>) -> Vec<MapPoint> {
        let Some(every) = self.settings.via else { return Vec::new() };
        let count = (self.settings.horizon / every).min(MOST_VIAS) as usize;
        let at = |i: usize| ahead(situation.path, situation.pose.point(), i as f64 * every);
        (1..=count).filter_map(at).take_while(|ahead| !ahead.is_end).map(|ahead| ahead.point).collect()
    }

    fn improve(&mut self, new: Vec<Candidate>, situation: &Situation<'_>, end: &End) {
        let problem = Problem {
            footprint: &self.footprint,
            obstacles: situation.obstacles,
            limits: &self.limits,
            settings: &self.settings.band,
            start: situation.velocity,
            stops: end.stops,
            end_yaw: end.yaw.is_some(),
            side: sign(self.settings.side),
        };
        let vias = self.vias(situation);
        let warm = self.candidates.len();
        let is_firm = self.settings.surprise.is_none() && situation.obstacles.iter().any(Obstacle::is_moving);
        self.candidates.extend(new);
        for (i, candidate) in self.candidates.iter_mut().enumerate() {
            let effort = if i < warm { Effort::WARM } else { Effort::COLD };
            let conflict =
                |band: &Band| first_conflict(&self.footprint, &self.limits, situation.obstacles, band, SURE);
            let before = (i < warm && candidate.conflict.is_none()).then(|| candidate.clone());
            let cost = self.optimizer.improve(&mut candidate.band, &problem, &vias, &effort);
            candidate.tangled = i < warm && cost > TANGLED.0 * candidate.cost + TANGLED.1;
            candidate.cost = cost;
            candidate.conflict = conflict(&candidate.band);
            // Not for a better cost is a way given up that leads there.
            let leads = |b: &Band| conflict(b).is_none() && is_drivable(b, &self.limits);
            let is_near = |b: &Band| {
                first_conflict(&self.footprint, &self.limits, situation.obstacles, b, FIRM).is_some()
            };
            let is_worse =
                |b: &Band| candidate.conflict.is_some() || is_firm && is_near(&candidate.band) && !is_near(b);
            let kept = before.filter(|b| is_worse(&b.band) && leads(&b.band));
            if let Some(before) = kept {
                *candidate = Candidate { tangled: true, ..before };
            }
            candidate.signature = signature(&self.clusters, &candidate.band);
        }
    }

    /// Puts the best band first, the one that was there if it is hardly worse, and drops all but the best of each class.
    fn choose(&mut self) {
        if self.candidates.is_empty() {
            return;
        }
        let worth =
            |i: usize, c: &Candidate| if i == 0 { self.settings.hysteresis * c.worth() } else { c.worth() };
        let best = (0..self.candidates.len())
            .min_by(|&a, &b| worth(a, &self.candidates[a]).total_cmp(&worth(b, &self.candidates[b])));
        self.candidates.swap(0, best.unwrap_or(0));
        let mut kept: Vec<Candidate> = Vec::with_capacity(self.candidates.len());
        for candidate in self.candidates.drain(..) {
            match kept.iter_mut().position(|k| k.signature == candidate.signature) {
                Some(0) => {}
                Some(i) if candidate.worth() < kept[i].worth() => kept[i] = candidate,
                Some(_) => {}
                None => kept.push(candidate),
            }
        }
        let dearest = 2.0 * kept[0].cost + 5.0;
        let mut first = true;
        kept.retain(|c| std::mem::take(&mut first) || c.conflict.is_none() && c.cost < dearest);
        self.candidates = kept;
    }

    /// Whether the first band leads to the end.
    fn leads(&self) -> bool {
        self.candidates.first().is_some_and(|c| c.conflict.is_none())
    }

    /// Where no band leads to the end, a search with the whole footprint may.
    fn maneuver(&mut self, situation: &Situation<'_>, end: &End) {
        if self.leads() {
            return;
        }
        if let Some(band) = self.search(situation, end) {
            let conflict = first_conflict(&self.footprint, &self.limits, situation.obstacles, &band, SURE);
            let signature = signature(&self.clusters, &band);
            self.candidates.insert(0, Candidate { band, signature, cost: 0.0, conflict, tangled: false });
        }
    }

    fn search(&mut self, situation: &Situation<'_>, end: &End) -> Option<Band> {
        if self.searched.is_some_and(|at| situation.time.since(at).as_secs_f64() < SEARCH_AGAIN) {
            return None;
        }
        self.searched = Some(situation.time);
        let (footprint, obstacles) = (&self.footprint, situation.obstacles);
        maneuver(footprint, &self.limits, obstacles, situation.pose, end.point, end.yaw).ok()
    }

    /// Whether the robot is so near to something that soft penalties are no help.
    fn is_wedged(&self, situation: &Situation<'_>) -> bool {
        let standing = situation.obstacles.iter().filter(|o| !o.is_moving());
        let near = clearance(&self.footprint, standing, situation.pose, 0.0, WEDGED.1);
        near < if self.wedged { WEDGED.1 } else { WEDGED.0 }
    }

    /// Gets off what is all but touched: by a maneuver to the end that is driven as it was found or, where there is none, by a small motion.
    fn drive_out(&mut self, situation: &Situation<'_>, end: &End) -> Option<Progress> {
        let elapsed = self.last.map_or(0.0, |(time, _)| situation.time.since(time).as_secs_f64());
        if let Some(band) = &mut self.way_out {
            band.keep_up(situation.pose, elapsed);
        }
        let known = self.way_out.take().filter(|band| self.keeps(situation, band));
        self.way_out = known.or_else(|| self.search(situation, end));
        self.driven_out(situation).or_else(|| {
            self.way_out = leave(&self.footprint, &self.limits, situation);
            self.driven_out(situation)
        })
    }

    /// Whether a way out is still to be driven, and meets nobody soon.
    fn keeps(&self, situation: &Situation<'_>, band: &Band) -> bool {
        let conflict = first_conflict(&self.footprint, &self.limits, situation.obstacles, band, KEEP);
        band.duration() > DONE && conflict.is_none_or(|at| at > TOO_LATE)
    }

    fn driven_out(&self, situation: &Situation<'_>) -> Option<Progress> {
        let band = self.way_out.as_ref().filter(|band| self.keeps(situation, band))?;
        let velocity = self.secured(situation, band.command(&self.limits), Some(band)).ok()?.velocity()?;
        Some(Progress::Slowed(velocity, Blocked::Touching))
    }
}

impl LocalPlanner for Teb {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Progress, Blocked> {
        situation.check()?;
        let end = self.end(situation);
        let off = situation.pose.point().distance(end.point);
        let near = if self.turning { 1.0 } else { WELL_WITHIN } * self.settings.tolerance;
        self.turning = end.stops && off <= near;
        if self.turning {
            self.candidates.clear();
            self.hesitation.forget();
            let error = end.yaw.map_or(0.0, |yaw| wrap_angle(yaw - situation.pose.yaw));
            let there = error.abs() <= self.settings.yaw_tolerance;
            return if there { Ok(Progress::Arrived) } else { self.turn(situation, error) };
        }
        self.wedged = self.is_wedged(situation);
        if self.wedged {
            if let Some(progress) = self.drive_out(situation, &end) {
                self.candidates.clear();
                self.hesitation.forget();
                self.last = Some((situation.time, end.point));
                return Ok(progress);
            }
        } else {
            self.way_out = None;
        }
        self.carry_on(situation, &end);
        let new = self.explore(situation, &end);
        self.improve(new, situation, &end);
        self.choose();
        self.maneuver(situation, &end);
        let decided = self.command(situation);
        self.hesitate(situation, decided)
    }

    fn among_people(&self, situation: &Situation<'_>, velocity: Velocity) -> Velocity {
        let caution = self.caution();
        let slowed = caution.slowed(situation, velocity, None);
        if caution.cuts_off(situation, slowed, None) { Velocity::ZERO } else { slowed }
    }

    fn reset(&mut self) {
        self.candidates.clear();
        (self.last, self.searched, self.way_out) = (None, None, None);
        self.hesitation.forget();
        (self.turning, self.wedged) = (false, false);
    }
}

fn signature(clusters: &Clusters, band: &Band) -> Signature {
    clusters.signature(band.knots().iter().map(|k| Passing { point: k.pose.point(), time: k.time }))
}

/// -1, 0 or 1.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// Whether a robot can drive a band about as fast as it says, everywhere.
fn is_drivable(band: &Band, limits: &Limits) -> bool {
    let slowed = band.slowed(limits);
    let mut pairs = band.knots().windows(2).zip(slowed.knots().windows(2));
    pairs.all(|(a, b)| b[1].time - b[0].time < LATER * (a[1].time - a[0].time))
}
