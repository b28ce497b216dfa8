//! From the trace of an episode to the results of its deliveries.

use openbench_core::{Address, FailureCause, MapPoint};
use openbench_osm::OsmMap;
use openbench_scene::Door;

use crate::score::metrics::{
    DoorScore, EncounterSum, Strict, collisions, paper_success, score_doors,
};
use crate::score::results::DeliveryResult;
use crate::trace::{EpisodeTrace, TaskOutcome};
use crate::worlds::{Prepared, PreparedEpisode};

/// The results of an episode's deliveries, in the order in which they ended.
pub fn score_episode(
    prepared: &Prepared,
    number: usize,
    episode: &PreparedEpisode,
    trace: &EpisodeTrace,
) -> Vec<DeliveryResult> {
    let mut from = None;
    let mut results = Vec::new();
    for (task, outcome) in trace.tasks.iter().enumerate() {
        let target = &episode.targets[outcome.target];
        // As in the reference's scripts: from the origin, and in a sequence from the previous door.
        let plate = target
            .door
            .map(|door| prepared.world.scene.doors[door].point());
        let straight = plate.map_or(0.0, |plate| {
            from.unwrap_or(MapPoint::default()).distance(plate)
        });
        from = plate.or(from);
        let mut result = score_task(prepared, outcome, target.door);
        (result.episode, result.task, result.straight_line_m) = (number, task, straight);
        result.instruction = episode.instruction.clone();
        result.building = target.address.building.clone();
        result.unit = target.address.unit.clone();
        results.push(result);
    }
    results
}

/// The result without the fields of the episode. A door that the world does not have is never
/// reached.
fn score_task(prepared: &Prepared, outcome: &TaskOutcome, door: Option<usize>) -> DeliveryResult {
    let declared_at = outcome.declared.then_some(outcome.ended_at);
    let plate = door.map(|door| prepared.world.scene.doors[door].point());
    let strict = declared_at
        .zip(door)
        .map_or(Strict::NOT_DECLARED, |(at, door)| judge(prepared, at, door));
    let failure = failure(outcome, &strict);
    DeliveryResult {
        episode: 0,
        task: 0,
        instruction: String::new(),
        building: String::new(),
        unit: None,
        success_10m: plate.is_some_and(|plate| paper_success(declared_at, plate)),
        success_2m: strict.success,
        correct_unit: strict.correct_unit,
        distance_to_door_m: plate.map(|plate| outcome.ended_at.distance(plate)),
        path_m: outcome.path_m,
        shortest_path_m: door.and_then(|door| prepared.shortest(outcome.began_at, door)),
        straight_line_m: 0.0,
        sim_seconds: outcome.ended.since(outcome.began).as_secs_f64(),
        smoothness: outcome.smoothness,
        collisions: outcome.collisions.len(),
        collisions_by_class: collisions::by_class(
            outcome
                .collisions
                .iter()
                .map(|c| (c.class.name(), c.into())),
        ),
        encounters: outcome.encounters.map(EncounterSum::from),
        declared_at,
        pose_error_m: outcome.pose_error_m,
        plates_read: outcome.plates_read,
        failure: failure.as_ref().map(|f| f.0),
        failure_detail: failure.map(|f| f.1),
    }
}

fn failure(outcome: &TaskOutcome, strict: &Strict) -> Option<(FailureCause, String)> {
    let misplaced = || {
        let detail = if strict.correct_unit {
            "declared more than 2 m from the door's approach point"
        } else {
            "declared nearer to another door's approach point"
        };
        (FailureCause::WrongPlace, detail.to_owned())
    };
    outcome
        .failure
        .clone()
        .or_else(|| (!strict.success).then(misplaced))
}

/// Judges a declaration by geodesic distances. Doors whose straight-line distance already exceeds
/// the geodesic distance of the correct door need no search.
fn judge(prepared: &Prepared, at: MapPoint, door: usize) -> Strict {
    let Some(at) = prepared.free_space.nearest_reachable(at, 1.0) else {
        return Strict::NOT_DECLARED;
    };
    let distance_to = |door: usize| {
        let approach = prepared.approach[door]?;
        prepared.free_space.distance(at, approach)
    };
    let Some(correct) = distance_to(door) else {
        return Strict::NOT_DECLARED;
    };
    let others = (0..prepared.approach.len()).filter(|&d| d != door);
    let near = others.filter(|&d| prepared.approach[d].is_some_and(|a| a.distance(at) < correct));
    let others: Vec<f64> = near.filter_map(distance_to).collect();
    Strict::judge(correct, &others)
}

/// Scores the doors that the agent wrote, over all episodes; `None` if it edits no map.
pub fn score_written_doors(prepared: &Prepared, traces: &[EpisodeTrace]) -> Option<DoorScore> {
    traces.iter().any(|t| t.map.is_some()).then(|| {
        let written: Vec<(Address, MapPoint)> = traces
            .iter()
            .flat_map(|t| t.doors.iter().cloned())
            .collect();
        let map = prepared.osm_map();
        let doors = prepared
            .world
            .scene
            .doors
            .iter()
            .map(|d| (d.address.clone(), doorway(&map, d)));
        score_doors(&written, &doors.collect::<Vec<_>>())
    })
}

/// The position of a door in OSM: on the outline of its building.
///
/// The plate of a recessed doorway is inside the outline; its door is where a ray from the plate
/// leaves the building. For other plates it is the nearest point of the outline.
fn doorway(map: &OsmMap, door: &Door) -> MapPoint {
    /// Maximum depth of a recess.
    const MAX_RECESS_CM: u32 = 400;
    /// Step along the ray.
    const STEP_CM: usize = 5;
    let plate = door.point();
    let Some(building) = map.nearest_building(plate) else {
        return plate;
    };
    let outline = &map.buildings[building].polygon;
    let mut outwards = (0..MAX_RECESS_CM)
        .step_by(STEP_CM)
        .map(|cm| plate.offset(door.facing, f64::from(cm) / 100.0));
    let in_front = outwards
        .find(|p| !outline.contains(*p))
        .filter(|_| outline.contains(plate));
    in_front.unwrap_or_else(|| outline.nearest_boundary_point(plate).point)
}

/// Number of instructions whose plan has exactly the requested doors, and number of all
/// instructions; `None` if the agent made no plans.
pub fn understood(prepared: &Prepared, traces: &[EpisodeTrace]) -> Option<(usize, usize)> {
    if traces.iter().all(|trace| trace.plan.is_none()) {
        return None;
    }
    let pairs = prepared.episodes.iter().zip(traces);
    let understood = pairs.filter(|(episode, trace)| is_understood(episode, trace));
    Some((understood.count(), traces.len()))
}

/// Whether the plan has exactly the requested doors, in any order.
fn is_understood(episode: &PreparedEpisode, trace: &EpisodeTrace) -> bool {
    let Some(plan) = &trace.plan else {
        return false;
    };
    let mut missing: Vec<&Address> = episode.targets.iter().map(|t| &t.address).collect();
    for delivery in &plan.deliveries {
        let address = delivery.address();
        match missing.iter().position(|m| m.same_door(&address)) {
            Some(i) => drop(missing.remove(i)),
            None => return false,
        }
    }
    missing.is_empty()
}
