//! The comparison of several planners over many scenes.

use std::collections::BTreeMap;

use openbench_core::RobotDescription;
use openbench_motion::follower::{self, Tolerance};
use openbench_motion::local::built_in::built_in;
use openbench_motion::local::{LocalPlanners, PlannerError, PlannerSettings, make_planner};
use openbench_motion::{FailureReason, NavigatorError};
use serde::{Serialize, Serializer};

use openbench_bench::run::threads;

use super::drive::{CYCLE_S, Drive, End, drive};
use super::reference::{Reference, ReferenceMotion, improved_duration, reference_motion};
use super::scene::{Kind, Scene, scene};

/// Draws of a scene before its number is left out, if for none a motion or a proof is found.
const MAX_DRAWS: u64 = 20;
/// Ratio to the duration of the reference motion above which a drive is slow.
const SLOW_RATIO: f64 = 1.3;
/// Swerves that are not regarded as an oscillation: constant part.
const BASE_SWERVES: f64 = 4.0;
/// Swerves that are not regarded as an oscillation: part per second.
const SWERVES_PER_S: f64 = 0.25;

/// Tolerance of the follower: it moves on while it turns, and has to end well within the goal's
/// tolerance.
const FOLLOWER: Tolerance = Tolerance {
    distance: 0.08,
    yaw: 0.07,
};

/// The planners that are compared by default.
pub fn planners() -> LocalPlanners {
    built_in().with_entry(follower::entry_with(FOLLOWER))
}

/// A planner that is compared, ordered as listed and serialized as its name.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct PlannerKind {
    // The first field, so that the derived order is that of the list.
    place: usize,
    name: String,
}

impl PlannerKind {
    /// Its name in tables.
    pub fn name(&self) -> &str {
        &self.name
    }

    fn all(planners: &LocalPlanners) -> Vec<Self> {
        let entries = planners.entries().enumerate();
        entries
            .map(|(place, entry)| Self {
                place,
                name: entry.name.clone(),
            })
            .collect()
    }
}

impl Serialize for PlannerKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name)
    }
}

/// A comparison that cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ComparisonError {
    /// A local planner cannot be created.
    #[error(transparent)]
    Planner(#[from] PlannerError),
    /// The navigator cannot be created.
    #[error(transparent)]
    Navigator(#[from] NavigatorError),
    /// A scene cannot be drawn.
    #[error("scene {number} cannot be drawn for this robot")]
    Scene {
        /// Number of the scene.
        number: usize,
        /// The invalid shape.
        source: openbench_motion::ShapeError,
    },
}

/// The results of a planner over many scenes, or over those of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct Row {
    /// Scenes with a motion to the goal.
    pub feasible: usize,
    /// Feasible scenes whose goal was reached without a collision.
    pub reached: usize,
    /// Collisions in all scenes.
    pub collisions: usize,
    /// Scenes for which it is proven that there is no motion.
    pub infeasible: usize,
    /// Infeasible scenes that were given up because there is no path, or none for the footprint.
    pub refused: usize,
    /// Median CPU time of a decision, milliseconds. Maneuvers are not included: the navigator
    /// searches them after the planner has given up.
    pub cycle_ms_p50: f64,
    /// 99th percentile of the CPU time of a decision, milliseconds.
    pub cycle_ms_p99: f64,
    /// Mean duration of the drives that reached the goal, relative to the reference motion; null if
    /// none did.
    pub time_ratio_mean: Option<f64>,
    /// Maximum of these ratios.
    pub time_ratio_max: Option<f64>,
    /// Drives that took more than 1.3 times the duration of the reference motion.
    pub slow: usize,
    /// Mean number of swerves of the drives that reached the goal; null if none did.
    pub swerves_mean: Option<f64>,
    /// Maximum number of swerves of such a drive.
    pub swerves_max: usize,
}

/// The result of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Seed of the scenes.
    pub seed: u64,
    /// Number of scenes that were driven.
    pub scenes: usize,
    /// Number of draws for which neither a motion nor a proof was found.
    pub undecided: usize,
    /// Results of each planner.
    pub planners: BTreeMap<PlannerKind, Row>,
    /// Results of each planner for each kind of scene.
    pub kinds: BTreeMap<PlannerKind, BTreeMap<Kind, Row>>,
    /// The failed drives.
    pub failures: Vec<Failure>,
}

/// A failed drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Failure {
    /// The planner.
    pub planner: PlannerKind,
    /// Number of the scene.
    pub scene: usize,
    /// Kind of the scene.
    pub kind: Kind,
    /// Description of the failure.
    pub what: String,
}

/// A scene with its reference motion and the drives of all planners.
#[derive(Debug)]
pub struct SceneOutcome {
    /// Number of the scene.
    pub number: usize,
    /// Kind of the scene.
    pub kind: Kind,
    /// The scene; `None` if for no draw a motion or a proof was found.
    pub scene: Option<Scene>,
    /// Duration of the reference motion, seconds; `None` if it is proven that there is no motion.
    pub best: Option<f64>,
    /// Number of earlier draws for which neither was found.
    pub undecided: usize,
    /// The drives.
    pub drives: Vec<PlannerDrive>,
}

/// The drive of a planner.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannerDrive {
    /// The planner.
    pub planner: PlannerKind,
    /// Its drive.
    pub drive: Drive,
}

impl SceneOutcome {
    /// Without the scene and the tracks, which need most of the memory and are not summed.
    fn without_pictures(self) -> Self {
        let mut bare = self;
        bare.scene = None;
        for driven in &mut bare.drives {
            driven.drive.track = Vec::new();
        }
        bare
    }
}

/// The scenes and planners to compare.
#[derive(Debug, Clone, Copy)]
pub struct ComparisonRequest<'a> {
    /// Number of the first scene.
    pub first: usize,
    /// Number of scenes.
    pub count: usize,
    /// Seed of the scenes.
    pub seed: u64,
    /// The planners.
    pub planners: &'a LocalPlanners,
    /// Number of threads.
    pub threads: usize,
}

/// Compares planners. Only CPU times depend on the number of threads. `seen` receives each outcome,
/// in the order of completion.
///
/// # Errors
/// A planner or scene that cannot be created, or an error of `seen`.
pub fn compare<E>(
    request: &ComparisonRequest<'_>,
    robot: &RobotDescription,
    seen: &mut dyn FnMut(&SceneOutcome) -> Result<(), E>,
) -> Result<Comparison, E>
where
    E: From<ComparisonError>,
{
    let numbers = request.first..request.first.saturating_add(request.count);
    let outcomes = threads::each(
        numbers,
        request.threads,
        |number| outcome(number, request, robot),
        |outcome| seen(&outcome).map(|()| outcome.without_pictures()),
    )?;
    Ok(summary(
        request.seed,
        &PlannerKind::all(request.planners),
        &outcomes,
    ))
}

/// The draws of a scene until one has a reference motion or a proof.
struct Decided {
    /// The scene and its reference; `None` if no draw has any.
    scene: Option<(Scene, Reference)>,
    /// Number of earlier draws.
    undecided: usize,
}

fn decided(number: usize, seed: u64, robot: &RobotDescription) -> Result<Decided, ComparisonError> {
    for draw in 0..MAX_DRAWS {
        // In the upper half, so that the redrawn scenes of neighbouring seeds differ.
        let scene = scene(number, seed.wrapping_add(draw << 32), robot)
            .map_err(|source| ComparisonError::Scene { number, source })?;
        // A new draw if nothing is known about this one: no drive through it could be judged.
        match reference_motion(&scene, robot) {
            Some(Reference::Unknown) | None => {}
            Some(known) => {
                return Ok(Decided {
                    scene: Some((scene, known)),
                    undecided: draw as usize,
                });
            }
        }
    }
    Ok(Decided {
        scene: None,
        undecided: MAX_DRAWS as usize,
    })
}

fn outcome(
    number: usize,
    request: &ComparisonRequest<'_>,
    robot: &RobotDescription,
) -> Result<SceneOutcome, ComparisonError> {
    let Decided { scene, undecided } = decided(number, request.seed, robot)?;
    let kind = Kind::ALL[number % Kind::ALL.len()];
    let Some((scene, known)) = scene else {
        return Ok(SceneOutcome {
            number,
            kind,
            scene: None,
            best: None,
            undecided,
            drives: vec![],
        });
    };
    let settings = PlannerSettings::new(robot.clone());
    let planners = PlannerKind::all(request.planners).into_iter();
    let drives = planners
        .zip(request.planners.entries())
        .map(|(planner, entry)| {
            let drive = drive(&scene, robot, make_planner(entry, &settings)?)?;
            Ok(PlannerDrive { planner, drive })
        })
        .collect::<Result<Vec<_>, ComparisonError>>()?;
    // A drive can be faster than the search, so drives and their improvements count as well.
    let best = match known {
        Reference::Motion(ReferenceMotion { arrival_s, .. }) => {
            Some(fastest(arrival_s, &drives, |drive| {
                improved_duration(&scene, robot, &drive.track, CYCLE_S)
            }))
        }
        Reference::Infeasible | Reference::Unknown => None,
    };
    Ok(SceneOutcome {
        number,
        kind,
        scene: Some(scene),
        best,
        undecided,
        drives,
    })
}

/// The shortest known duration: of the search, of a drive, or of an improved drive. The ratios of a
/// planner may therefore depend slightly on the other planners.
fn fastest(found: f64, drives: &[PlannerDrive], improved: impl Fn(&Drive) -> Option<f64>) -> f64 {
    let good = drives
        .iter()
        .map(|driven| &driven.drive)
        .filter(|drive| drive.end == End::Reached && drive.collisions == 0);
    good.flat_map(|drive| [Some(drive.seconds), improved(drive)])
        .flatten()
        .fold(found, f64::min)
}

fn summary(seed: u64, planners: &[PlannerKind], outcomes: &[SceneOutcome]) -> Comparison {
    let all: Vec<&SceneOutcome> = outcomes.iter().collect();
    Comparison {
        seed,
        scenes: outcomes.iter().filter(|o| !o.drives.is_empty()).count(),
        undecided: outcomes.iter().map(|o| o.undecided).sum(),
        planners: planners
            .iter()
            .map(|planner| (planner.clone(), row(judged(&all, planner))))
            .collect(),
        kinds: planners
            .iter()
            .map(|planner| (planner.clone(), rows_by_kind(&all, planner)))
            .collect(),
        failures: outcomes.iter().flat_map(failures).collect(),
    }
}

fn rows_by_kind(outcomes: &[&SceneOutcome], planner: &PlannerKind) -> BTreeMap<Kind, Row> {
    let mut rows = BTreeMap::new();
    for kind in Kind::ALL {
        let of_kind: Vec<&SceneOutcome> = outcomes
            .iter()
            .copied()
            .filter(|outcome| outcome.kind == kind)
            .collect();
        rows.insert(kind, row(judged(&of_kind, planner)));
    }
    rows
}

/// A drive and what it is compared with.
#[derive(Clone, Copy)]
struct Judged<'a> {
    /// Duration of the reference motion, seconds; `None` if there is no motion.
    best: Option<f64>,
    drive: &'a Drive,
}

/// The drives of a planner.
fn judged<'a>(
    outcomes: &[&'a SceneOutcome],
    planner: &'a PlannerKind,
) -> impl Iterator<Item = Judged<'a>> {
    outcomes.iter().flat_map(move |outcome| {
        let drives = outcome.drives.iter();
        drives
            .filter(move |driven| driven.planner == *planner)
            .map(|driven| Judged {
                best: outcome.best,
                drive: &driven.drive,
            })
    })
}

fn row<'a>(drives: impl Iterator<Item = Judged<'a>>) -> Row {
    let mut row = Row::default();
    // CPU times count in all drives, times and swerves in those that reached the goal.
    let (mut cycles, mut ratios, mut swerves) = (Vec::new(), Vec::new(), 0);
    for Judged { best, drive } in drives {
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
                    row.slow += usize::from(drive.seconds > SLOW_RATIO * best);
                }
            }
            None => {
                row.infeasible += 1;
                row.refused += usize::from(is_right_refusal(&drive.end));
            }
        }
    }
    cycles.sort_by(f64::total_cmp);
    row.cycle_ms_p50 = quantile(&cycles, 0.5);
    row.cycle_ms_p99 = quantile(&cycles, 0.99);
    let mean = |sum: f64| (!ratios.is_empty()).then(|| sum / ratios.len() as f64);
    row.time_ratio_mean = mean(ratios.iter().sum::<f64>());
    row.time_ratio_max = ratios.iter().copied().reduce(f64::max);
    row.swerves_mean = mean(swerves as f64);
    row
}

/// The value that `share` of the values are below; 0 without values.
fn quantile(ascending: &[f64], share: f64) -> f64 {
    let place = (ascending.len() as f64 * share) as usize;
    ascending.get(place).copied().unwrap_or(0.0)
}

/// Whether a scene without a motion was given up for that reason.
fn is_right_refusal(end: &End) -> bool {
    matches!(
        end,
        End::GaveUp(FailureReason::NoPath(_) | FailureReason::TooNarrow(_))
    )
}

fn failures(outcome: &SceneOutcome) -> Vec<Failure> {
    outcome
        .drives
        .iter()
        .filter_map(|PlannerDrive { planner, drive }| {
            Some(Failure {
                planner: planner.clone(),
                scene: outcome.number,
                kind: outcome.kind,
                what: failure(outcome.best, drive)?,
            })
        })
        .collect()
}

/// Description of the failure of a drive; `None` if it is as it should be.
fn failure(best: Option<f64>, drive: &Drive) -> Option<String> {
    // A collision is a failure however the drive ended.
    if drive.collisions > 0 {
        return Some(format!(
            "collisions: {}, maximum penetration {:.3} m",
            drive.collisions, drive.deepest
        ));
    }
    match (best, &drive.end) {
        (Some(best), End::Reached) if drive.seconds > SLOW_RATIO * best => Some(format!(
            "took {:.1} s, the reference motion {best:.1} s",
            drive.seconds
        )),
        (Some(_), End::Reached)
            if drive.swerves as f64 > BASE_SWERVES + SWERVES_PER_S * drive.seconds =>
        {
            Some(format!(
                "oscillates: {} swerves in {:.1} s",
                drive.swerves, drive.seconds
            ))
        }
        (Some(_), End::Reached) => None,
        (None, end) if is_right_refusal(end) => None,
        (_, End::GaveUp(cause)) => Some(format!("gave up: {cause}")),
        (_, End::Timeout) => Some("ran out of time".to_owned()),
        (_, End::Mistaken) => Some("reported arrival beside the goal".to_owned()),
        (None, End::Reached) => Some("reached a goal that no motion leads to".to_owned()),
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
        End::GaveUp(FailureReason::NoPath(PlanError::NoPath(
            MapPoint::default(),
            MapPoint::new(1.0, 0.0),
        )))
    }

    #[test]
    fn failures_are_described() {
        let wrong = |best, drive: Drive| failure(best, &drive).unwrap_or_default();
        assert_eq!(wrong(Some(10.0), driven(End::Reached, 13.0)), "");
        assert_eq!(wrong(None, driven(no_way(), 1.0)), "");
        assert_eq!(
            wrong(Some(10.0), driven(End::Reached, 13.1)),
            "took 13.1 s, the reference motion 10.0 s"
        );
        let collision = Drive {
            collisions: 1,
            deepest: 0.02,
            ..driven(End::Reached, 9.0)
        };
        assert_eq!(
            wrong(Some(10.0), collision),
            "collisions: 1, maximum penetration 0.020 m"
        );
        let swerving = Drive {
            swerves: 15,
            ..driven(End::Reached, 10.0)
        };
        assert_eq!(
            wrong(Some(10.0), swerving),
            "oscillates: 15 swerves in 10.0 s"
        );
        assert!(wrong(Some(10.0), driven(no_way(), 1.0)).starts_with("gave up: "));
        for (end, words) in [
            (End::Timeout, "ran out of time"),
            (End::Mistaken, "reported arrival beside the goal"),
            (End::Reached, "reached a goal that no motion leads to"),
        ] {
            assert_eq!(wrong(None, driven(end, 1.0)), words);
        }
    }

    #[test]
    fn a_row_counts_reached_and_refused_scenes() {
        let touched = Drive {
            collisions: 2,
            ..driven(End::Reached, 5.0)
        };
        let drives = [
            (Some(10.0), driven(End::Reached, 11.0)),
            (Some(10.0), driven(End::Reached, 14.0)),
            (Some(10.0), touched),
            (Some(10.0), driven(End::Timeout, 90.0)),
            (None, driven(no_way(), 1.0)),
            (None, driven(End::Timeout, 90.0)),
        ];
        let row = row(drives
            .iter()
            .map(|(best, drive)| Judged { best: *best, drive }));
        assert_eq!((row.feasible, row.reached, row.collisions), (4, 2, 2));
        assert_eq!((row.infeasible, row.refused, row.slow), (2, 1, 1));
        assert!((row.time_ratio_mean.unwrap_or_default() - 1.25).abs() < 1e-12);
        assert_eq!(
            (row.time_ratio_max, row.swerves_mean, row.swerves_max),
            (Some(1.4), Some(2.0), 2)
        );
        assert_eq!((row.cycle_ms_p50, row.cycle_ms_p99), (3.0, 3.0));
        assert_eq!(super::row(std::iter::empty()), Row::default());
    }

    #[test]
    fn the_reference_is_the_shortest_known_duration() {
        let touched = Drive {
            collisions: 1,
            ..driven(End::Reached, 5.0)
        };
        let drives = [
            driven(End::Reached, 9.0),
            driven(End::Timeout, 1.0),
            touched,
        ];
        let planners = PlannerKind::all(&planners());
        let drives = drives.map(|drive| PlannerDrive {
            planner: planners[0].clone(),
            drive,
        });
        let best = |found, saved| fastest(found, &drives, |d| Some(d.seconds - saved));
        assert_eq!(
            (best(10.0, 0.0), best(8.0, 0.0), best(8.0, 1.5)),
            (9.0, 8.0, 7.5)
        );
        assert_eq!(fastest(10.0, &drives, |_| None), 9.0);
    }
}
