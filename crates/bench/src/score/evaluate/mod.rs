//! The paper's metrics for a log of the recorder of the paper.
//!
//! The log is CSV, `timestamp,status,address,robot_x,robot_y,robot_z`. A row with the status
//! `start` begins each task; rows with `running` and `end` continue it. The truth file has one `(x,
//! y)` per line, or several in one line for a sequence, in driving order. A file that does not fit
//! is reported with its line.
//!
//! As in the reference's scripts, a delivery succeeds within 10 m of its true position in a
//! straight line. The path is the sum of the straight lines between rows. It is compared with the
//! straight line from the origin, or in a sequence from the previous true position.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use openbench_core::{MapPoint, input};
use serde::Serialize;

use crate::line_problem::LineProblem;
use crate::plural::count;
use crate::score::metrics::{paper_success, path_ratio, sequence_mean, spl};
use crate::score::statistics::mean_interval;
use crate::suite::truth_file::parse_truth;

mod log;

use log::{LoggedTask, parse_log};

/// A log or truth file that cannot be evaluated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A line is not in the expected format.
    #[error("{}:{line}: {problem}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// What is wrong, and what is expected.
        problem: String,
    },
    /// Log and truth file do not belong together.
    #[error("{} does not fit the log", path.display())]
    Mismatch {
        /// The truth file.
        path: PathBuf,
        /// What is wrong, and what to do.
        source: MismatchError,
    },
}

/// Why a truth file does not belong to a log.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MismatchError {
    /// A line has several true positions, but no sequences were announced.
    #[error("a line has several true positions, which are a sequence; add --sequence")]
    IsSequence,
    /// The log and the truth file have different numbers of deliveries.
    #[error(
        "{} for {}; give one true position for each task of the log, in the same order",
        count(*truths, "true position", "true positions"),
        count(*tasks, "task", "tasks")
    )]
    Count {
        /// Number of true positions.
        truths: usize,
        /// Number of tasks in the log.
        tasks: usize,
    },
    /// Both files are empty.
    #[error("there are no true positions; write one `(x, y)` per line")]
    Empty,
}

/// The evaluation of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluation {
    /// The metrics over all tasks.
    pub metrics: PaperMetrics,
    /// The tasks, in the order of the log.
    pub deliveries: Vec<EvaluatedDelivery>,
}

/// The metrics of the paper.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PaperMetrics {
    /// Share of tasks that ended within 10 m of their true position.
    pub sr_10m: f64,
    /// SPL, where straight lines are the shortest paths.
    pub spl_straight: f64,
    /// Mean LSR of the sequences; null for single deliveries.
    pub lsr_10m: Option<f64>,
    /// Mean LSPL of the sequences; null for single deliveries.
    pub lspl_straight: Option<f64>,
    /// 95 % intervals of the metrics of these names; null below five episodes.
    pub intervals: BTreeMap<&'static str, Option<[f64; 2]>>,
}

/// One task of the log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EvaluatedDelivery {
    /// Line of the truth file, from 0.
    pub episode: usize,
    /// Index of the delivery in that line, from 0.
    pub task: usize,
    /// The address as logged.
    pub address: String,
    /// Whether it ended within 10 m of the true position.
    pub success_10m: bool,
    /// Distance between the end of the task and the true position, metres.
    pub distance_to_door_m: f64,
    /// Driven distance, metres.
    pub path_m: f64,
    /// Length of the straight line that the path is compared with, metres.
    pub straight_line_m: f64,
}

/// Evaluates a log file against a truth file. With `sequence`, the deliveries form a sequence, each
/// starting at the previous door.
///
/// # Errors
/// A file that cannot be read or parsed, or files that do not belong together.
pub fn evaluate(log: &Path, truth: &Path, sequence: bool) -> Result<Evaluation, EvaluateError> {
    let read = |path: &Path| {
        input::read_text(path).map_err(|source| EvaluateError::File {
            path: path.to_owned(),
            source,
        })
    };
    let tasks = at(log, parse_log(&read(log)?))?;
    let lines = at(truth, parse_truth(&read(truth)?))?.into_iter();
    let points = lines.map(|line| line.points).collect();
    let episodes = group_truths(points, sequence).map_err(|source| mismatch(truth, source))?;
    score(&tasks, &episodes).map_err(|source| mismatch(truth, source))
}

fn at<T>(path: &Path, parsed: Result<T, LineProblem>) -> Result<T, EvaluateError> {
    parsed.map_err(|LineProblem { line, problem }| EvaluateError::Line {
        path: path.to_owned(),
        line,
        problem,
    })
}

fn mismatch(path: &Path, source: MismatchError) -> EvaluateError {
    EvaluateError::Mismatch {
        path: path.to_owned(),
        source,
    }
}

/// True positions by episode. One sequence may be written as one line, or with one position per
/// line; several lines with several positions each are several sequences.
fn group_truths(
    lines: Vec<Vec<MapPoint>>,
    sequence: bool,
) -> Result<Vec<Vec<MapPoint>>, MismatchError> {
    let singles = lines.iter().all(|line| line.len() == 1);
    match (sequence, singles) {
        (true, true) => Ok(vec![lines.concat()]),
        (false, false) => Err(MismatchError::IsSequence),
        _ => Ok(lines),
    }
}

fn score(tasks: &[LoggedTask], episodes: &[Vec<MapPoint>]) -> Result<Evaluation, MismatchError> {
    let truths: usize = episodes.iter().map(Vec::len).sum();
    if truths != tasks.len() {
        return Err(MismatchError::Count {
            truths,
            tasks: tasks.len(),
        });
    }
    if truths == 0 {
        return Err(MismatchError::Empty);
    }
    let deliveries: Vec<_> = legs(episodes)
        .zip(tasks)
        .map(|(leg, task)| score_task(&leg, task))
        .collect();
    Ok(Evaluation {
        metrics: metrics(&deliveries),
        deliveries,
    })
}

/// The straight line that the path of a delivery is compared with.
struct Leg {
    episode: usize,
    task: usize,
    from: MapPoint,
    door: MapPoint,
}

/// The legs of all episodes, each from the origin to the first door and on to the next.
fn legs(episodes: &[Vec<MapPoint>]) -> impl Iterator<Item = Leg> {
    episodes.iter().enumerate().flat_map(|(episode, doors)| {
        // One start more than there are doors: `zip` pairs each door with its predecessor and drops
        // the last start.
        let starts = std::iter::once(&MapPoint { x: 0.0, y: 0.0 }).chain(doors);
        let ends = starts.zip(doors).enumerate();
        ends.map(move |(task, (&from, &door))| Leg {
            episode,
            task,
            from,
            door,
        })
    })
}

fn score_task(leg: &Leg, log: &LoggedTask) -> EvaluatedDelivery {
    let &Leg {
        episode,
        task,
        from,
        door,
    } = leg;
    EvaluatedDelivery {
        episode,
        task,
        address: log.address.clone(),
        success_10m: paper_success(Some(log.end), door),
        distance_to_door_m: log.end.distance(door),
        path_m: log.path_m,
        straight_line_m: from.distance(door),
    }
}

fn metrics(deliveries: &[EvaluatedDelivery]) -> PaperMetrics {
    let success = |d: &EvaluatedDelivery| f64::from(d.success_10m);
    let ratio = |d: &EvaluatedDelivery| path_ratio(d.success_10m, d.straight_line_m, d.path_m);
    let successes = by_episode(deliveries, success);
    let ratios = by_episode(deliveries, ratio);
    let lsr = sequence_values(deliveries, success);
    let lspl = sequence_values(deliveries, ratio);
    // With a fixed seed, the same log always gives the same intervals.
    let interval = |episodes: &[Vec<f64>]| mean_interval(episodes, 0);
    // A plain mean, also of what is no path ratio.
    let mean = |episodes: &[Vec<f64>]| spl(&episodes.concat());
    PaperMetrics {
        sr_10m: mean(&successes).unwrap_or(0.0),
        spl_straight: mean(&ratios).unwrap_or(0.0),
        lsr_10m: mean(&lsr),
        lspl_straight: mean(&lspl),
        intervals: BTreeMap::from([
            ("sr_10m", interval(&successes)),
            ("spl_straight", interval(&ratios)),
            ("lsr_10m", interval(&lsr)),
            ("lspl_straight", interval(&lspl)),
        ]),
    }
}

/// The values of the deliveries of each episode.
fn by_episode(
    deliveries: &[EvaluatedDelivery],
    value: impl Fn(&EvaluatedDelivery) -> f64,
) -> Vec<Vec<f64>> {
    // Deliveries are in the order of their episodes, so those of one episode are adjacent.
    deliveries
        .chunk_by(|a, b| a.episode == b.episode)
        .map(|episode| episode.iter().map(&value).collect())
        .collect()
}

/// LSR or LSPL of each sequence.
fn sequence_values(
    deliveries: &[EvaluatedDelivery],
    value: impl Fn(&EvaluatedDelivery) -> f64,
) -> Vec<Vec<f64>> {
    by_episode(deliveries, value)
        .into_iter()
        .filter(|episode| episode.len() > 1)
        .filter_map(|episode| Some(vec![sequence_mean(&episode)?]))
        .collect()
}

#[cfg(test)]
mod tests {
    use openbench_core::with_causes;

    use super::*;

    const LOG: &str = "timestamp,status,address,robot_x,robot_y,robot_z\r\n\
        1.0,start,\"unit1, building3\",0,0,0.1\r\n\
        2.0,running,\"unit1, building3\",3,4,0.1\r\n\
        3.0,end,\"unit1, building3\",6,8,0.1\r\n\
        4.0,start,unit2,6,8,0.1\r\n\
        5.0,running,unit2,6,28,0.1\r\n";

    /// The evaluation, or the error in words.
    fn run(truth: &str, sequence: bool) -> Result<Evaluation, String> {
        let dir = tempfile::tempdir().unwrap();
        let (log, gt) = (dir.path().join("log.csv"), dir.path().join("gt.txt"));
        std::fs::write(&log, LOG).unwrap();
        std::fs::write(&gt, truth).unwrap();
        evaluate(&log, &gt, sequence).map_err(|error| with_causes(&error))
    }

    #[test]
    fn singles_are_measured_from_the_origin() {
        let result = run("(6.0, 8.0)\n(6, 48)\n", false).unwrap();
        assert_eq!(result.deliveries[0].address, "unit1, building3");
        assert_eq!(
            (
                result.deliveries[0].path_m,
                result.deliveries[0].straight_line_m
            ),
            (10.0, 10.0)
        );
        assert_eq!(
            (result.metrics.sr_10m, result.metrics.spl_straight),
            (0.5, 0.5)
        );
        assert_eq!(result.deliveries[1].distance_to_door_m, 20.0);
        assert_eq!(result.metrics.lsr_10m, None);
    }

    #[test]
    fn a_sequence_is_measured_from_door_to_door() {
        for truth in ["(6, 8) (6, 18)\n", "(6, 8)\n(6, 18)\n"] {
            let result = run(truth, true).unwrap();
            assert_eq!(result.deliveries[1].straight_line_m, 10.0);
            assert_eq!(result.metrics.lsr_10m, Some(1.0));
            // Weights 1 / 1.9 and 0.9 / 1.9, ratios 1 and 0.5.
            assert!((result.metrics.lspl_straight.unwrap() - 1.45 / 1.9).abs() < 1e-12);
        }
    }

    #[test]
    fn true_positions_that_do_not_fit_are_rejected() {
        assert!(
            run("(6, 8)\n", false)
                .unwrap_err()
                .contains("1 true position for 2 tasks")
        );
        assert!(
            run("(6, 8) (1, 1)\n", false)
                .unwrap_err()
                .contains("--sequence")
        );
        assert!(
            run("(6, 8)\n(1; 2)\n", false)
                .unwrap_err()
                .contains("gt.txt:2: ")
        );
        assert!(run("", false).unwrap_err().contains("0 true positions"));
    }

    #[test]
    fn a_missing_file_is_named_and_its_error_kept() {
        let error = evaluate(Path::new("/nonexistent.csv"), Path::new("/x"), false).unwrap_err();
        assert_eq!(error.to_string(), "cannot read /nonexistent.csv");
        assert!(std::error::Error::source(&error).is_some());
    }
}
