//! Many scenes, several planners, and the table.

use std::collections::BTreeMap;

use openbench_core::RobotDescription;
use openbench_motion::follower::{self, Tolerance};
use openbench_motion::local::built_in::built_in;
use openbench_motion::local::{LocalPlanners, PlannerError, PlannerSettings};
use openbench_motion::navigator::{Cause, NavigatorError};
use serde::{Serialize, Serializer};

use crate::threads;

use super::best::{Possible, polished, possible};
use super::drive::{CYCLE, Drive, End, drive};
use super::scene::{Kind, Scene, scene};

/// Draws of a scene of which neither a motion nor a proof is found, before its number is left out.
const DRAWS: u64 = 20;
/// Time of a drive by which it may exceed the best motion's.
const SLOW: f64 = 1.3;

/// Changes of the turn's sign that are no oscillation: so many, and so many a second.
const SWERVES: (f64, f64) = (4.0, 0.25);

/// Distance and heading error with which the follower has arrived: less than what counts as reached.
const FOLLOWER: Tolerance = Tolerance { distance: 0.08, yaw: 0.07 };

/// The planners that are compared by default.
pub fn planners() -> LocalPlanners {
    built_in().with(follower::entry_with(FOLLOWER))
}

/// A planner that is compared: in the order in which planners are listed, and written as its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct PlannerKind {
    place: usize,
    name: &'static str,
}

impl PlannerKind {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        self.name
    }

    fn all(planners: &LocalPlanners) -> Vec<Self> {
        let entries = planners.entries().iter().enumerate();
        entries.map(|(place, entry)| Self { place, name: entry.name() }).collect()
    }
}

impl Serialize for PlannerKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name)
    }
}

/// A trial cannot be held.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// A local planner cannot be made.
    #[error(transparent)]
    Planner(#[from] PlannerError),
    /// The navigator cannot be made.
    #[error(transparent)]
    Navigator(#[from] NavigatorError),
    /// A scene cannot be drawn.
    #[error("scene {number}: {why}")]
    Scene {
        /// Its number.
        number: usize,
        /// What is wrong with it.
        why: openbench_motion::ShapeError,
    },
}

/// What a planner did in many scenes, or in those of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct Row {
    /// Scenes in which there is a motion to the goal.
    pub feasible: usize,
    /// Of these, those whose goal was reached without touching anything.
    pub reached: usize,
    /// Collisions, in all scenes.
    pub collisions: usize,
    /// Scenes in which it is proven that there is none.
    pub infeasible: usize,
    /// Of these, those that were given up because there is no way, or none for the footprint.
    pub refused: usize,
    /// CPU milliseconds of a decision of the planner, half of them: without maneuvers, which the navigator around it searches once it gives up.
    pub cycle_ms_p50: f64,
    /// CPU milliseconds of a decision, 99 of 100.
    pub cycle_ms_p99: f64,
    /// Mean of the time of drives that reached the goal, as a multiple of the best motion's; none if none did.
    pub time_ratio_mean: Option<f64>,
    /// The largest of these.
    pub time_ratio_max: Option<f64>,
    /// Drives that took more than 1.3 times the best motion's time.
    pub slow: usize,
    /// Mean number of changes of the turn's sign in a drive that reached the goal; none if none did.
    pub swerves_mean: Option<f64>,
    /// The most in one.
    pub swerves_max: usize,
}

/// Everything that came out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// Seed of the scenes.
    pub seed: u64,
    /// Scenes that were driven.
    pub scenes: usize,
    /// Draws of which neither a motion nor a proof was found.
    pub undecided: usize,
    /// A row for each planner.
    pub planners: BTreeMap<PlannerKind, Row>,
    /// A row for each planner and kind of scene.
    pub kinds: BTreeMap<PlannerKind, BTreeMap<Kind, Row>>,
    /// Scenes that were not driven as they should be: planner, number, kind, and what went wrong.
    pub failures: Vec<Failure>,
}

/// A scene that was not driven as it should be.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Failure {
    /// Who drove.
    pub planner: PlannerKind,
    /// The scene's number.
    pub scene: usize,
    /// Its kind.
    pub kind: Kind,
    /// What went wrong.
    pub what: String,
}

/// One scene, what can be done in it, and what was done.
#[derive(Debug)]
pub struct Outcome {
    /// The scene's number.
    pub number: usize,
    /// What is hard about it.
    pub kind: Kind,
    /// The scene, unless of all that were drawn it is not known what can be done.
    pub scene: Option<Scene>,
    /// Seconds of the best motion; none if it is proven that there is none.
    pub best: Option<f64>,
    /// Draws before it of which that is not known.
    pub undecided: usize,
    /// What was done.
    pub drives: Vec<(PlannerKind, Drive)>,
}

impl Outcome {
    /// What sums are made of: a drive's track and its scene are by far larger than all else.
    fn without_pictures(self) -> Self {
        let bare = |(planner, drive): (PlannerKind, Drive)| (planner, Drive { track: Vec::new(), ..drive });
        Self { scene: None, drives: self.drives.into_iter().map(bare).collect(), ..self }
    }
}

/// Which scenes are driven, and by whom.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// Number of the first scene.
    pub first: usize,
    /// How many.
    pub count: usize,
    /// Their seed.
    pub seed: u64,
    /// Who drives.
    pub planners: &'a LocalPlanners,
    /// How many scenes at a time.
    pub threads: usize,
}

/// Drives planners through scenes; nothing but times depends on the number of threads. `seen` is shown each outcome as it comes, in no order.
pub fn hold<E>(
    request: &Request<'_>,
    robot: &RobotDescription,
    seen: &mut dyn FnMut(&Outcome) -> Result<(), E>,
) -> Result<Trial, E>
where
    E: From<TrialError>,
{
    let numbers = request.first..request.first.saturating_add(request.count);
    let outcomes = threads::each(
        numbers,
        request.threads,
        |number| outcome(number, request, robot),
        |outcome| seen(&outcome).map(|()| outcome.without_pictures()),
    )?;
    Ok(summary(request.seed, &PlannerKind::all(request.planners), &outcomes))
}

/// The first draw of a scene's number of which it is known what can be done.
pub fn decided(
    number: usize,
    seed: u64,
    robot: &RobotDescription,
) -> Result<(Option<(Scene, Possible)>, usize), TrialError> {
    for draw in 0..DRAWS {
        let scene = scene(number, seed.wrapping_add(draw << 32), robot)
            .map_err(|why| TrialError::Scene { number, why })?;
        match possible(&scene, robot) {
            Some(Possible::Unknown) | None => {}
            Some(known) => return Ok((Some((scene, known)), draw as usize)),
        }
    }
    Ok((None, DRAWS as usize))
}

fn outcome(number: usize, request: &Request<'_>, robot: &RobotDescription) -> Result<Outcome, TrialError> {
    let (found, undecided) = decided(number, request.seed, robot)?;
    let kind = Kind::ALL[number % Kind::ALL.len()];
    let Some((scene, known)) = found else {
        return Ok(Outcome { number, kind, scene: None, best: None, undecided, drives: vec![] });
    };
    let settings = PlannerSettings::new(robot.clone());
    let kinds = PlannerKind::all(request.planners).into_iter().zip(request.planners.entries());
    let drives = kinds.map(|(kind, entry)| Ok((kind, drive(&scene, robot, entry.make(&settings)?)?)));
    let drives = drives.collect::<Result<Vec<_>, TrialError>>()?;
    let best = match known {
        Possible::Motion(_, seconds) => {
            Some(fastest(seconds, &drives, |d| polished(&scene, robot, &d.track, CYCLE)))
        }
        Possible::Nothing | Possible::Unknown => None,
    };
    Ok(Outcome { number, kind, scene: Some(scene), best, undecided, drives })
}

/// The best that is known: a long search may be beaten by a drive, and a drive by what can be made of it. So whoever else drives may make the others' ratios a little larger.
fn fastest(found: f64, drives: &[(PlannerKind, Drive)], polished: impl Fn(&Drive) -> Option<f64>) -> f64 {
    let good = drives.iter().map(|(_, d)| d).filter(|d| d.end == End::Reached && d.collisions == 0);
    good.flat_map(|d| [Some(d.seconds), polished(d)]).flatten().fold(found, f64::min)
}

fn summary(seed: u64, planners: &[PlannerKind], outcomes: &[Outcome]) -> Trial {
    let rows = |kind: Option<Kind>, planner: PlannerKind| {
        let of_kind = outcomes.iter().filter(|o| kind.is_none_or(|k| k == o.kind));
        row(of_kind.flat_map(|o| o.drives.iter().filter(|d| d.0 == planner).map(|d| (o.best, &d.1))))
    };
    let kinds = |planner| Kind::ALL.into_iter().map(|kind| (kind, rows(Some(kind), planner))).collect();
    Trial {
        seed,
        scenes: outcomes.iter().filter(|o| !o.drives.is_empty()).count(),
        undecided: outcomes.iter().map(|o| o.undecided).sum(),
        planners: planners.iter().map(|&p| (p, rows(None, p))).collect(),
        kinds: planners.iter().map(|&p| (p, kinds(p))).collect(),
        failures: outcomes.iter().flat_map(failures).collect(),
    }
}

fn row<'a>(drives: impl Iterator<Item = (Option<f64>, &'a Drive)>) -> Row {
    let mut row = Row::default();
    let (mut cycles, mut ratios, mut swerves) = (Vec::new(), Vec::new(), 0);
    for (best, drive) in drives {
        cycles.extend(&drive.cycles);
        row.collisions += drive.collisions;
        match best {
            Some(best) => {
                row.feasible += 1;
                if drive.end == End::Reached && drive.collisions == 0 {
                    row.reached += 1;
                    ratios.push(drive.seconds / best);
                    swerves += drive.swerves;
                    row.swerves_max = row.swerves_max.max(drive.swerves);
                    row.slow += usize::from(drive.seconds > SLOW * best);
                }
            }
            None => {
                row.infeasible += 1;
                row.refused += usize::from(is_right_refusal(&drive.end));
            }
        }
    }
    cycles.sort_by(f64::total_cmp);
    let at = |share: f64| cycles.get((cycles.len() as f64 * share) as usize).copied().unwrap_or(0.0);
    (row.cycle_ms_p50, row.cycle_ms_p99) = (at(0.5), at(0.99));
    let mean = |sum: f64| (!ratios.is_empty()).then(|| sum / ratios.len() as f64);
    row.time_ratio_mean = mean(ratios.iter().sum::<f64>());
    row.time_ratio_max = ratios.iter().copied().reduce(f64::max);
    row.swerves_mean = mean(swerves as f64);
    row
}

fn is_right_refusal(end: &End) -> bool {
    matches!(end, End::GaveUp(Cause::NoWay(_) | Cause::TooNarrow(_)))
}

fn failures(outcome: &Outcome) -> Vec<Failure> {
    let wrong = outcome.drives.iter().filter_map(|(planner, drive)| {
        let what = what_is_wrong(outcome.best, drive)?;
        Some(Failure { planner: *planner, scene: outcome.number, kind: outcome.kind, what })
    });
    wrong.collect()
}

fn what_is_wrong(best: Option<f64>, drive: &Drive) -> Option<String> {
    if drive.collisions > 0 {
        return Some(format!("{} collisions, the deepest {:.3} m", drive.collisions, drive.deepest));
    }
    match (best, &drive.end) {
        (Some(best), End::Reached) if drive.seconds > SLOW * best => {
            Some(format!("{:.1} s, the best is {best:.1} s", drive.seconds))
        }
        (Some(_), End::Reached) if drive.swerves as f64 > SWERVES.0 + SWERVES.1 * drive.seconds => {
            Some(format!("{} swerves in {:.1} s", drive.swerves, drive.seconds))
        }
        (Some(_), End::Reached) => None,
        (None, end) if is_right_refusal(end) => None,
        (_, End::GaveUp(cause)) => Some(format!("gave up: {cause}")),
        (_, end) => Some(format!("{end:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::MapPoint;
    use openbench_motion::PlanError;

    fn driven(end: End, seconds: f64) -> Drive {
        Drive {
            end,
            collisions: 0,
            deepest: 0.0,
            seconds,
            swerves: 2,
            cycles: vec![1.0, 3.0],
            recoveries: 0,
            track: vec![],
        }
    }

    fn no_way() -> End {
        End::GaveUp(Cause::NoWay(PlanError::NoWay(MapPoint::default(), MapPoint::new(1.0, 0.0))))
    }

    #[test]
    fn what_is_wrong_is_told() {
        let wrong = |best, drive: Drive| what_is_wrong(best, &drive).unwrap_or_default();
        assert_eq!(wrong(Some(10.0), driven(End::Reached, 13.0)), "");
        assert_eq!(wrong(None, driven(no_way(), 1.0)), "");
        assert_eq!(wrong(Some(10.0), driven(End::Reached, 13.1)), "13.1 s, the best is 10.0 s");
        let collision = Drive { collisions: 1, deepest: 0.02, ..driven(End::Reached, 9.0) };
        assert_eq!(wrong(Some(10.0), collision), "1 collisions, the deepest 0.020 m");
        let swerving = Drive { swerves: 15, ..driven(End::Reached, 10.0) };
        assert_eq!(wrong(Some(10.0), swerving), "15 swerves in 10.0 s");
        assert!(wrong(Some(10.0), driven(no_way(), 1.0)).starts_with("gave up: "));
        for end in [End::Timeout, End::Mistaken, End::Reached] {
            assert_eq!(wrong(None, driven(end, 1.0)), format!("{end:?}"));
        }
    }

    #[test]
    fn a_row_sums_up_what_was_reached_and_what_was_refused() {
        let touched = Drive { collisions: 2, ..driven(End::Reached, 5.0) };
        let drives = [
            (Some(10.0), driven(End::Reached, 11.0)),
            (Some(10.0), driven(End::Reached, 14.0)),
            (Some(10.0), touched),
            (Some(10.0), driven(End::Timeout, 90.0)),
            (None, driven(no_way(), 1.0)),
            (None, driven(End::Timeout, 90.0)),
        ];
        let row = row(drives.iter().map(|(best, drive)| (*best, drive)));
        assert_eq!((row.feasible, row.reached, row.collisions), (4, 2, 2));
        assert_eq!((row.infeasible, row.refused, row.slow), (2, 1, 1));
        assert!((row.time_ratio_mean.unwrap_or_default() - 1.25).abs() < 1e-12);
        assert_eq!((row.time_ratio_max, row.swerves_mean, row.swerves_max), (Some(1.4), Some(2.0), 2));
        assert_eq!((row.cycle_ms_p50, row.cycle_ms_p99), (3.0, 3.0));
        assert_eq!(super::row(std::iter::empty()), Row::default());
    }

    #[test]
    fn the_best_is_the_fastest_that_is_known() {
        let touched = Drive { collisions: 1, ..driven(End::Reached, 5.0) };
        let drives = [driven(End::Reached, 9.0), driven(End::Timeout, 1.0), touched];
        let drives = drives.map(|drive| (PlannerKind::all(&planners())[0], drive));
        let best = |found, saved| fastest(found, &drives, |d| Some(d.seconds - saved));
        assert_eq!((best(10.0, 0.0), best(8.0, 0.0), best(8.0, 1.5)), (9.0, 8.0, 7.5));
        assert_eq!(fastest(10.0, &drives, |_| None), 9.0);
    }
}
