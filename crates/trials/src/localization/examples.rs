//! Candidates with the truth about them, to fit their probabilities.

use std::convert::Infallible;
use std::sync::Arc;

use openbench_bench::run::threads;
use openbench_core::Pose2;
use openbench_localization::registration::hypothesis::{Acceptance, Located};
use openbench_localization::registration::locator::{Judgement, Locator};
use serde::Serialize;

use super::cases::Case;
use super::drives::Shown;
use super::trial::pose_errors;

/// A candidate, and how far it is from the truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Example {
    /// Number of the case.
    pub case: usize,
    /// Metres driven before.
    pub metres: f64,
    /// The pose in the map's frame: x, y, yaw.
    pub pose: [f64; 3],
    /// Pose of the robot by odometry then.
    pub odom: [f64; 3],
    /// Distance from the true position, metres; null if the robot is not on the map.
    pub error_m: Option<f64>,
    /// Difference from the true heading, radians.
    pub error_rad: Option<f64>,
    /// Number of buildings on whose walls facades are.
    pub buildings: usize,
    /// Information about the position along the direction in which it is known least, 1/m².
    pub weakest: f64,
    /// What its probability is computed from.
    pub features: Vec<f64>,
    /// The probability.
    pub probability: f64,
}

/// The candidates of all cases, in their order.
pub fn examples(cases: &[Case<'_>], threads: usize) -> Vec<Example> {
    let one = |i: usize| Ok::<_, Infallible>(of_case(i, &cases[i]));
    let found = threads::each(0..cases.len(), threads, one, Ok::<_, Infallible>);
    let found = found.unwrap_or_else(|never| match never {});
    found.into_iter().flatten().collect()
}

/// The candidates of a case after each leg of its drive, if none is ever accepted.
fn of_case(number: usize, case: &Case<'_>) -> Vec<Example> {
    let judgement = Judgement {
        acceptance: Acceptance::Never,
        ..Judgement::default()
    };
    let map = Arc::clone(&case.map.map);
    let mut locator = Locator::new(map, &case.start).judging(judgement);
    let mut examples = Vec::new();
    for shown in case.drive.shown() {
        shown.to(&mut locator);
        let example = |one| example(number, case, &shown, one);
        examples.extend(locator.candidates().iter().map(example));
    }
    examples
}

fn example(number: usize, case: &Case<'_>, shown: &Shown<'_>, one: &Located) -> Example {
    let numbers = |pose: Pose2| [pose.x, pose.y, pose.yaw];
    let errors = case
        .on_map(shown.seen.truth)
        .map(|truth| pose_errors(one.pose, truth));
    Example {
        case: number,
        metres: shown.metres,
        pose: numbers(one.pose),
        odom: numbers(shown.seen.stretch.end),
        error_m: errors.map(|errors| errors.metres),
        error_rad: errors.map(|errors| errors.radians),
        buildings: one.candidate.refined.buildings.len(),
        weakest: one.candidate.refined.weakest(),
        features: one.candidate.features.to_vec(),
        probability: one.candidate.probability,
    }
}
