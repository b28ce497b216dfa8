//! Targets that a planner reads from instructions, for `run --targets planner`.
//!
//! They stand here and not in `openbench-bench`: the judge knows no planner. Results name them.

use anyhow::bail;
use openbench_bench::Episode;
use openbench_core::{Address, MapPoint, TravelTimes};
use openbench_language::{GrammarPlanner, PlanRequest, Planner};
use openbench_osm::OsmMap;

/// Equal travel times between all places, so that deliveries stay in the order of the instruction.
struct EqualTimes;

impl TravelTimes for EqualTimes {
    fn matrix(&self, places: &[MapPoint]) -> Vec<f64> {
        vec![1.0; places.len() * places.len()]
    }
}

/// The episodes with the doors that the grammar finds in their instructions.
///
/// # Errors
/// The first instruction in which it finds none.
pub fn read_doors(episodes: Vec<Episode>, map: &OsmMap) -> anyhow::Result<Vec<Episode>> {
    let read = |episode: Episode| {
        let deliveries = doors_in(&episode.instruction, map);
        if deliveries.is_empty() {
            bail!(
                "the planner finds no delivery in `{}`; name building and unit, or give true \
                 positions with --truth",
                episode.instruction
            );
        }
        Ok(Episode {
            deliveries,
            ..episode
        })
    };
    episodes.into_iter().map(read).collect()
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
