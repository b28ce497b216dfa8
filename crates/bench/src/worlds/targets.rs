//! The doors that an episode requests, by address or by true position.

use std::path::Path;

use openbench_core::{Address, MapPoint};
use openbench_scene::World;

use crate::BenchError;
use crate::line_problem::LineProblem;
use crate::plural::count;
use crate::suite::truth_file::parse_truth;
use crate::suite::{Episode, Suite};

/// Maximum distance between a true position and the plate of its door.
const TRUTH_TOLERANCE_M: f64 = 0.5;

/// The door of a delivery.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Address as in the instruction.
    pub address: Address,
    /// Index into the world's doors; `None` if the world has no such door, so that the delivery
    /// cannot succeed.
    pub door: Option<usize>,
}

/// The doors with the addresses of an episode.
pub(super) fn find_doors(episode: &Episode, world: &World) -> Vec<Target> {
    let find = |address: &Address| {
        let door = world
            .scene
            .doors
            .iter()
            .position(|d| d.address.same_door(address));
        Target {
            address: address.clone(),
            door,
        }
    };
    episode.deliveries.iter().map(find).collect()
}

/// The doors at the true positions, each with its address in the instruction.
pub(super) fn match_doors(episode: &Episode, truths: &[usize], world: &World) -> Vec<Target> {
    let mut left: Vec<&Address> = episode.deliveries.iter().collect();
    let named: Vec<Option<&Address>> = truths
        .iter()
        .map(|&door| {
            let at = left
                .iter()
                .position(|a| a.same_door(&world.scene.doors[door].address))?;
            Some(left.remove(at))
        })
        .collect();
    let mut left = left.into_iter();
    let targets = truths.iter().zip(named).map(|(&door, address)| {
        let address = address
            .or_else(|| left.next())
            .unwrap_or(&world.scene.doors[door].address);
        Target {
            address: address.clone(),
            door: Some(door),
        }
    });
    targets.collect()
}

/// Reads a truth file: for each episode the doors at its true positions.
pub(super) fn read_truths(
    path: &Path,
    suite: &Suite,
    world: &World,
) -> Result<Vec<Vec<usize>>, BenchError> {
    let bad = |problem: String| BenchError::bad_file(path, problem);
    let text = std::fs::read_to_string(path).map_err(|e| BenchError::file(path, e))?;
    let lines = parse_truth(&text)
        .map_err(|LineProblem { line, problem }| bad(format!("line {line}: {problem}")))?;
    if lines.len() != suite.episodes.len() {
        return Err(bad(format!(
            "there are {} of true positions for {} of deliveries; write one for each",
            count(lines.len(), "line", "lines"),
            count(suite.episodes.len(), "line", "lines")
        )));
    }
    let mut doors = Vec::new();
    for (i, (points, episode)) in lines.iter().zip(&suite.episodes).enumerate() {
        let found: Result<Vec<usize>, BenchError> = points
            .iter()
            .map(|p| door_at(path, i + 1, *p, world))
            .collect();
        let found = found?;
        // The doors of an instruction that was not understood are unknown.
        if !episode.deliveries.is_empty() && found.len() != episode.deliveries.len() {
            return Err(bad(format!(
                "line {}: {} true positions, but the instruction names {} doors ({})",
                i + 1,
                found.len(),
                episode.deliveries.len(),
                episode
                    .deliveries
                    .iter()
                    .map(Address::to_string)
                    .collect::<Vec<_>>()
                    .join("; ")
            )));
        }
        doors.push(found);
    }
    Ok(doors)
}

fn door_at(path: &Path, line: usize, at: MapPoint, world: &World) -> Result<usize, BenchError> {
    let doors = &world.scene.doors;
    let distance = |i: &usize| doors[*i].point().distance(at);
    let nearest = (0..doors.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    match nearest {
        Some(door) if distance(&door) <= TRUTH_TOLERANCE_M => Ok(door),
        _ => Err(BenchError::NoSuchTruth {
            path: path.to_owned(),
            line,
            at,
            nearest: nearest.map_or("none".into(), |d| doors[d].address.to_string()),
            away: nearest.map_or(f64::INFINITY, |d| distance(&d)),
        }),
    }
}
