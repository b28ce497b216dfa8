//! The planner: several bands at once, one for each homotopy class, the best of them driven.

use openbench_core::{MapPoint, RobotDescription, SimTime, Velocity, frames::wrap_angle};

use crate::checks::SettingsError;
use crate::feasible::ConflictCheck;
use crate::limits::Limits;
use crate::local::{
    Blocked, LocalPlanner, PathPoint, PlannerEntry, Progress, Situation, ahead, planner_entry,
};
use crate::people::caution::Hesitation;
use crate::recovery::maneuver;
use crate::shape::{Footprint, Obstacle, ShapeError};
use crate::teb::candidate::{Candidate, best_of_each_class, signature};
use crate::teb::classes::{Clusters, Explorer};
use crate::teb::optimize::{Effort, Optimizer};
use crate::teb::settings::TebSettings;
use crate::teb::terms::Problem;
use crate::trajectory::Trajectory;

mod command;
mod contact;

/// A goal that moves further than this at once is another one, metres.
const ELSEWHERE_M: f64 = 1.0;
/// Distance from obstacles that a motion has to keep to be driven, metres.
const SURE_M: f64 = 0.003;
/// Seconds until a conflict below which a band is not driven any further.
const TOO_LATE_S: f64 = 1.0;
/// Near moving obstacles a band that comes nearer to anything than this does not replace one that
/// was driven and does not, metres: a robot does not drive exactly as predicted, and people do not
/// wait. A cautious robot does not need it: it is slow where somebody might come nearer.
const FIRM_M: f64 = 0.015;
/// A band that costs this many times what it did a cycle ago,
const TANGLED: f64 = 1.3;
/// and this more, is begun anew beside itself.
const TANGLED_MORE: f64 = 1.0;
/// A band cannot be driven if one of its stretches takes this many times its duration at the
/// robot's speeds.
const LATER: f64 = 1.5;
/// Seconds that the robot may wait for somebody to pass.
const WAITS_S: [f64; 3] = [1.0, 2.5, 5.0];
/// Seconds until a maneuver is searched again.
const SEARCH_AGAIN_S: f64 = 1.0;
/// Most via points.
const MOST_VIAS: f64 = 40.0;
/// The robot begins its last turn within this share of the tolerance, since it may slip.
const WELL_WITHIN: f64 = 0.7;

/// Its entry among the local planners.
pub fn entry() -> PlannerEntry {
    entry_with(TebSettings::default())
}

/// Its entry with other settings.
pub fn entry_with(own: TebSettings) -> PlannerEntry {
    let about = "Timed Elastic Bands in several homotopy classes";
    planner_entry("teb", about, move |settings| {
        Ok(Box::new(Teb::new(&settings.robot, own)?))
    })
}

/// A planner cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TebError {
    /// A limit or a setting makes no sense.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The footprint is none.
    #[error(transparent)]
    Footprint(#[from] ShapeError),
}

/// The planner.
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
    /// When bands were last planned, and to where.
    last: Option<Planned>,
    /// Whether the robot is at the end and turns to its heading there.
    is_turning: bool,
    /// Whether the robot is in near contact with an obstacle.
    is_touching: bool,
    /// The motion that leaves near contact.
    way_out: Option<Trajectory>,
    /// When a maneuver was last searched.
    searched: Option<SimTime>,
    hesitation: Hesitation,
}

/// When and to where bands were planned.
#[derive(Debug, Clone, Copy)]
struct Planned {
    time: SimTime,
    end: MapPoint,
}

/// Where a band is to end.
#[derive(Debug, Clone, Copy)]
struct End {
    point: MapPoint,
    /// Heading there, radians; any if `None`.
    yaw: Option<f64>,
    /// Whether the robot is to stand there.
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
            is_turning: false,
            is_touching: false,
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
        let PathPoint { point, is_end } = ahead(situation.path, from, self.settings.horizon)
            .unwrap_or(PathPoint {
                point: from,
                is_end: true,
            });
        End {
            point,
            yaw: situation.final_yaw.filter(|_| is_end),
            stops: is_end,
        }
    }

    /// A check of motions that keep `margin` metres off obstacles.
    fn check<'a>(&'a self, obstacles: &'a [Obstacle], margin: f64) -> ConflictCheck<'a> {
        ConflictCheck {
            footprint: &self.footprint,
            limits: &self.limits,
            obstacles,
            margin,
        }
    }

    /// Seconds since bands were last planned.
    fn elapsed(&self, now: SimTime) -> f64 {
        self.last
            .map_or(0.0, |last| now.since(last.time).as_secs_f64())
    }

    /// Turns on the spot at the end of the path, or has arrived; `None` before the end.
    fn finish(
        &mut self,
        situation: &Situation<'_>,
        end: &End,
    ) -> Option<Result<Progress, Blocked>> {
        let distance = situation.pose.point().distance(end.point);
        // Once it turns, a slip within the tolerance does not make the robot drive again.
        let within = if self.is_turning { 1.0 } else { WELL_WITHIN } * self.settings.tolerance;
        self.is_turning = end.stops && distance <= within;
        if !self.is_turning {
            return None;
        }
        self.candidates.clear();
        self.hesitation.forget();
        let error = end
            .yaw
            .map_or(0.0, |yaw| wrap_angle(yaw - situation.pose.yaw));
        let is_there = error.abs() <= self.settings.yaw_tolerance;
        Some(if is_there {
            Ok(Progress::Arrived)
        } else {
            self.turn(situation, error)
        })
    }

    /// Moves the bands on to now: from where they expected the robot to its estimated pose.
    fn carry_on(&mut self, situation: &Situation<'_>, end: &End) {
        let elapsed = self.elapsed(situation.time);
        if self
            .last
            .is_none_or(|last| last.end.distance(end.point) > ELSEWHERE_M)
        {
            self.candidates.clear();
        }
        // Only the band that was driven tells where the robot should be.
        let expected = self.candidates.first().map(|c| c.band.pose_at(elapsed));
        let jumped = expected.filter(|expected| Trajectory::is_jump(*expected, situation.pose));
        for candidate in &mut self.candidates {
            if let Some(expected) = jumped {
                candidate.band.carry(expected, situation.pose);
            }
            candidate.band.advance(situation.pose, elapsed);
            candidate.band.set_end(end.point, end.yaw);
        }
        self.last = Some(Planned {
            time: situation.time,
            end: end.point,
        });
    }

    /// Searches classes and begins a band for each that has none.
    fn explore(&mut self, situation: &Situation<'_>, end: &End) -> Vec<Candidate> {
        let start = situation.pose.point();
        let how = self.settings.exploring;
        let (moving, standing): (Vec<Obstacle>, Vec<Obstacle>) = situation
            .obstacles
            .iter()
            .cloned()
            .partition(Obstacle::is_moving);
        let mut paths = self.explorer.explore(start, end.point, &standing, &how);
        // Classes count by what stands: the search with moving obstacles below has other clusters.
        self.clusters = self.explorer.take_clusters();
        self.clusters.set_moving(&moving, start);
        for candidate in &mut self.candidates {
            candidate.signature = signature(&self.clusters, &candidate.band);
        }
        // Once more, with moving obstacles where the driven band would meet them: paths around them
        // there pass before or behind.
        if !moving.is_empty() {
            let met: Vec<Obstacle> = moving
                .iter()
                .map(|o| self.when_met(o))
                .chain(standing)
                .collect();
            paths.extend(self.explorer.explore(start, end.point, &met, &how));
        }
        let (pose, side) = (situation.pose, self.settings.side);
        let drafts = paths.iter().filter_map(|path| {
            Trajectory::along(pose, &path.corners[1..], end.yaw, &self.limits, side)
        });
        let mut drafts: Vec<Trajectory> = drafts.collect();
        if !moving.is_empty() {
            drafts.extend(self.waiting());
        }
        self.of_new_classes(drafts)
    }

    /// The first band after waits, if it has a conflict.
    fn waiting(&self) -> Vec<Trajectory> {
        let Some(driven) = self.candidates.first().filter(|c| c.conflict.is_some()) else {
            return Vec::new();
        };
        WAITS_S
            .iter()
            .filter_map(|wait| driven.band.delayed(*wait))
            .collect()
    }

    /// Candidates from drafts of classes that have none. While a band leads to the end, one new
    /// band in a cycle is soon enough: cycles should all take about as long.
    fn of_new_classes(&self, drafts: Vec<Trajectory>) -> Vec<Candidate> {
        let most = self.settings.exploring.most;
        let at_once = if self.leads() { 1 } else { most };
        let mut new: Vec<Candidate> = Vec::new();
        for band in drafts {
            let candidate = Candidate::new(band, &self.clusters);
            let mut known = self.candidates.iter().chain(&new);
            // A tangled band gets a rival of its own class.
            let is_known = known.any(|c| c.signature == candidate.signature && !c.tangled);
            let has_room = new.len() < at_once && self.candidates.len() + new.len() < most;
            if !is_known && has_room {
                new.push(candidate);
            }
        }
        new
    }

    /// A moving obstacle where the band that is driven meets it.
    fn when_met(&self, obstacle: &Obstacle) -> Obstacle {
        let Some(driven) = self.candidates.first().filter(|_| obstacle.is_moving()) else {
            return obstacle.clone();
        };
        let times = driven.band.poses().iter().map(|k| k.time);
        let met = times.min_by(|a, b| {
            let [a, b] = [a, b].map(|time| apart_at(*time, obstacle, &driven.band));
            a.total_cmp(&b)
        });
        obstacle.after(met.unwrap_or(0.0))
    }

    /// Via points: points of the path within the horizon that bands pass.
    fn vias(&self, situation: &Situation<'_>) -> Vec<MapPoint> {
        let Some(every) = self.settings.via else {
            return Vec::new();
        };
        let count = (self.settings.horizon / every).min(MOST_VIAS) as usize;
        let from = situation.pose.point();
        let points = (1..=count).filter_map(|i| ahead(situation.path, from, i as f64 * every));
        points
            .take_while(|ahead| !ahead.is_end)
            .map(|ahead| ahead.point)
            .collect()
    }

    /// Optimizes all bands.
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
        let has_moving = situation.obstacles.iter().any(Obstacle::is_moving);
        let check = Check {
            problem: &problem,
            // Without this rule one of a thousand scenes is missed (`benchmarks/motion`): a band
            // passes one person by millimetres, and none is left before the next one comes.
            is_firm: self.settings.approach_margin_mps.is_none() && has_moving,
        };
        let warm = self.candidates.len();
        self.candidates.extend(new);
        for (i, candidate) in self.candidates.iter_mut().enumerate() {
            let is_warm = i < warm;
            // Only a band that led to the end is worth going back to.
            let before = (is_warm && candidate.conflict.is_none()).then(|| candidate.clone());
            let effort = if is_warm { Effort::WARM } else { Effort::COLD };
            let cost = self
                .optimizer
                .improve(&mut candidate.band, &problem, &vias, &effort);
            candidate.tangled = is_warm && cost > TANGLED * candidate.cost + TANGLED_MORE;
            candidate.cost = cost;
            candidate.conflict = check.conflict(&candidate.band);
            // A band that leads to the end is not given up for a lower cost.
            if let Some(before) = before.filter(|before| check.prefers(before, candidate)) {
                *candidate = Candidate {
                    tangled: true,
                    ..before
                };
            }
            candidate.signature = signature(&self.clusters, &candidate.band);
        }
    }

    /// Whether the first band leads to the end.
    fn leads(&self) -> bool {
        self.candidates
            .first()
            .is_some_and(|c| c.conflict.is_none())
    }

    /// Where no band leads to the end, searches a maneuver with the whole footprint.
    fn maneuver(&mut self, situation: &Situation<'_>, end: &End) {
        if self.leads() {
            return;
        }
        if let Some(band) = self.search(situation, end) {
            let mut candidate = Candidate::new(band, &self.clusters);
            candidate.conflict = self
                .check(situation.obstacles, SURE_M)
                .first_conflict(&candidate.band);
            // First, since no other band leads to the end.
            self.candidates.insert(0, candidate);
        }
    }

    /// Searches a maneuver to the end, once a second at most.
    fn search(&mut self, situation: &Situation<'_>, end: &End) -> Option<Trajectory> {
        let age = self.searched.map(|at| situation.time.since(at));
        // A search takes several times as long as a cycle.
        if age.is_some_and(|age| age.as_secs_f64() < SEARCH_AGAIN_S) {
            return None;
        }
        self.searched = Some(situation.time);
        let (footprint, limits, start) = (&self.footprint, &self.limits, situation.pose);
        maneuver(
            footprint,
            limits,
            situation.obstacles,
            start,
            end.point,
            end.yaw,
        )
        .ok()
    }
}

/// Checks optimized bands for conflicts.
struct Check<'a> {
    problem: &'a Problem<'a>,
    /// Whether bands that come very near to obstacles are avoided.
    is_firm: bool,
}

impl Check<'_> {
    /// Seconds until a band meets an obstacle.
    fn conflict(&self, band: &Trajectory) -> Option<f64> {
        self.first_conflict(band, SURE_M)
    }

    fn first_conflict(&self, band: &Trajectory, margin: f64) -> Option<f64> {
        let Problem {
            footprint,
            limits,
            obstacles,
            ..
        } = *self.problem;
        let check = ConflictCheck {
            footprint,
            limits,
            obstacles,
            margin,
        };
        check.first_conflict(band)
    }

    fn is_near(&self, band: &Trajectory) -> bool {
        self.first_conflict(band, FIRM_M).is_some()
    }

    /// Whether a band from before its optimization is to be kept.
    fn prefers(&self, before: &Candidate, after: &Candidate) -> bool {
        let is_worse = after.conflict.is_some()
            || self.is_firm && self.is_near(&after.band) && !self.is_near(&before.band);
        is_worse && self.leads(&before.band)
    }

    /// Whether a band can be driven to its end.
    fn leads(&self, band: &Trajectory) -> bool {
        self.conflict(band).is_none() && is_drivable(band, self.problem.limits)
    }
}

impl LocalPlanner for Teb {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Progress, Blocked> {
        situation.check()?;
        let end = self.end(situation);
        if let Some(decided) = self.finish(situation, &end) {
            return decided;
        }
        if let Some(progress) = self.leave_contact(situation, &end) {
            return Ok(progress);
        }
        self.carry_on(situation, &end);
        // In every cycle: with pauses between, mirrored scenes were not always driven alike.
        let new = self.explore(situation, &end);
        self.improve(new, situation, &end);
        let candidates = std::mem::take(&mut self.candidates);
        self.candidates = best_of_each_class(candidates, self.settings.hysteresis);
        self.maneuver(situation, &end);
        let decided = self.command(situation);
        self.hesitate(situation, decided)
    }

    fn limit_near_people(&self, situation: &Situation<'_>, velocity: Velocity) -> Velocity {
        let caution = self.caution();
        let slowed = caution.slowed(situation, velocity, None);
        if caution.cuts_off(situation, slowed, None) {
            Velocity::ZERO
        } else {
            slowed
        }
    }

    fn reset(&mut self) {
        self.candidates.clear();
        (self.last, self.searched, self.way_out) = (None, None, None);
        (self.is_turning, self.is_touching) = (false, false);
        self.hesitation.forget();
    }
}

/// How far a moving obstacle and a robot on a band are apart after `time` seconds, metres.
fn apart_at(time: f64, obstacle: &Obstacle, band: &Trajectory) -> f64 {
    let (middle, v) = (obstacle.middle(), obstacle.velocity());
    let there = MapPoint::new(middle.x + v.x * time, middle.y + v.y * time);
    there.distance(band.pose_at(time).point())
}

/// -1, 0 or 1.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// Whether a robot can drive a band about as fast as it says, everywhere.
fn is_drivable(band: &Trajectory, limits: &Limits) -> bool {
    let slowed = band.slowed(limits);
    let mut pairs = band.poses().windows(2).zip(slowed.poses().windows(2));
    pairs.all(|(a, b)| b[1].time - b[0].time < LATER * (a[1].time - a[0].time))
}
