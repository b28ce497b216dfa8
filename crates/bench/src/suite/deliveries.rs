//! The published delivery files: one instruction per line, each an episode.

use std::path::Path;

use openbench_core::{Address, MapPoint, TravelTimes};
use openbench_language::{GrammarPlanner, PlanRequest, Planner};
use openbench_osm::OsmMap;

use crate::BenchError;
use crate::suite::Episode;

/// Equal travel times between all places, so that deliveries stay in the order of the instruction.
struct EqualTimes;

impl TravelTimes for EqualTimes {
    fn matrix(&self, places: &[MapPoint]) -> Vec<f64> {
        vec![1.0; places.len() * places.len()]
    }
}

/// Reads a delivery file.
///
/// The doors of a line are those that the grammar planner finds in it on `map`. A line that it does
/// not understand has none, and needs a file of true positions.
///
/// # Errors
/// A file that cannot be read or has no instructions.
pub fn read(path: &Path, map: &OsmMap) -> Result<Vec<Episode>, BenchError> {
    let text = std::fs::read_to_string(path).map_err(|e| BenchError::file(path, e))?;
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let episodes: Vec<Episode> = lines
        .map(|line| Episode {
            instruction: line.to_owned(),
            deliveries: doors_in(line, map),
        })
        .collect();
    if episodes.is_empty() {
        let problem = "there is no delivery in it; write one instruction per line".to_owned();
        return Err(BenchError::bad_file(path, problem));
    }
    Ok(episodes)
}

fn doors_in(instruction: &str, map: &OsmMap) -> Vec<Address> {
    let request = PlanRequest {
        instruction,
        map,
        // Any start will do, since all travel times are equal.
        start: MapPoint::default(),
        times: &EqualTimes,
    };
    let Ok(plan) = GrammarPlanner::new().plan(&request) else {
        return Vec::new();
    };
    // A plan may visit a door twice, but an episode has each door once.
    let mut doors: Vec<Address> = Vec::new();
    for delivery in &plan.deliveries {
        let address = delivery.address();
        if !doors.iter().any(|d| d.same_door(&address)) {
            doors.push(address);
        }
    }
    doors
}
