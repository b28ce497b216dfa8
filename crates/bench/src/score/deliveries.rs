//! From the trace of an episode to the results of its deliveries.

use std::collections::BTreeMap;

use openbench_core::{FailureCause, MapPoint, Plan};
use openbench_osm::OsmMap;
use openbench_osm::disturb::MapState;
use openbench_scene::Door;

use crate::score::health::health_spans;
use crate::score::metrics::localization::localization;
use crate::score::metrics::{
    CollisionSum, DoorScore, EncounterSum, ExpectedPlan, Strict, Understood, collisions,
    paper_success, score_doors,
};
use crate::score::results::{ComputingSum, DeliveryResult, EpisodeResult};
use crate::score::stages::stage_spans;
use crate::score::statistics::Proportion;
use crate::suite::Condition;
use crate::trace::{EpisodeTrace, Failure, PlacedDoor, TaskOutcome};
use crate::worlds::{Prepared, PreparedEpisode};

/// The results of an episode's deliveries, in the order in which they ended.
pub fn score_episode(
    prepared: &Prepared,
    number: usize,
    episode: &PreparedEpisode,
    trace: &EpisodeTrace,
) -> Vec<DeliveryResult> {
    let mut results = Vec::new();
    for (task, outcome) in trace.tasks.iter().enumerate() {
        let target = &episode.targets[outcome.target];
        let plate = target
            .door
            .map(|door| prepared.world.scene.doors[door].point());
        // A door that the world lacks cannot be delivered to, so its length enters no metric.
        let straight = plate.map_or(0.0, |plate| outcome.began_at.distance(plate));
        let mut result = score_task(prepared, outcome, target.door);
        (result.episode, result.task, result.straight_line_m) = (number, task, straight);
        result.instruction = episode.instruction.clone();
        result.building = target.address.building.clone();
        result.unit = target.address.unit.clone();
        let building = target.door.and_then(|door| prepared.building(door));
        result.on_map = prepared.on_map().state(building);
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
    let collisions_by_class = collisions_by_class(outcome);
    DeliveryResult {
        episode: 0,
        task: 0,
        instruction: String::new(),
        building: String::new(),
        unit: None,
        on_map: MapState::Right,
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
        contact_s: collisions::contact_s(&collisions_by_class),
        collisions_by_class,
        encounters: outcome.encounters.map(EncounterSum::from),
        declared_at,
        pose_error_m: outcome.pose_error_m,
        plates_read: outcome.plates_read,
        model_calls: outcome.models.calls,
        model_calls_failed: outcome.models.failed,
        failure: failure.as_ref().map(|failure| failure.cause),
        failure_detail: failure.map(|failure| failure.detail),
    }
}

/// Collisions and contacts by the name of the class.
fn collisions_by_class(outcome: &TaskOutcome) -> BTreeMap<String, CollisionSum> {
    let bumps = outcome.collisions.iter();
    let mut sums = collisions::by_class(bumps.map(|c| (c.class.name(), c.into())));
    // A contact that began in the delivery before has no collision here.
    for (class, time) in &outcome.contacts {
        sums.entry(class.name().to_owned()).or_default().contact_s += time.as_secs_f64();
    }
    sums
}

/// The failure of a delivery by the strict criterion; `None` if it succeeded.
fn failure(outcome: &TaskOutcome, strict: &Strict) -> Option<Failure> {
    if outcome.failure.is_some() || strict.success {
        return outcome.failure.clone();
    }
    // For a declaration at a wrong place the agent reports no cause, so it is added here.
    let detail = if strict.correct_unit {
        "declared more than 2 m from the door's approach point"
    } else {
        "declared nearer to another door's approach point"
    };
    Some(Failure {
        cause: FailureCause::WrongPlace,
        detail: detail.to_owned(),
    })
}

/// Judges a declaration by geodesic distances. Doors whose straight-line distance already exceeds
/// the geodesic distance of the correct door need no search.
fn judge(prepared: &Prepared, at: MapPoint, door: usize) -> Strict {
    let Some(at) = prepared.nearest_reachable(at) else {
        return Strict::NOT_DECLARED;
    };
    let Some(correct) = geodesic_distance(prepared, at, door) else {
        return Strict::NOT_DECLARED;
    };
    let others: Vec<f64> = (0..prepared.approach.len())
        .filter(|&other| other != door)
        .filter(|&other| prepared.approach[other].is_some_and(|a| a.distance(at) < correct))
        .filter_map(|other| geodesic_distance(prepared, at, other))
        .collect();
    Strict::judge(correct, &others)
}

/// Distance from a reachable point to a door's approach point, metres; `None` without a path.
fn geodesic_distance(prepared: &Prepared, from: MapPoint, door: usize) -> Option<f64> {
    prepared.free_space.distance(from, prepared.approach[door]?)
}

/// The results of the episodes as a whole.
pub fn score_episodes(prepared: &Prepared, traces: &[EpisodeTrace]) -> Vec<EpisodeResult> {
    let (map, plans) = (prepared.true_map(), makes_plans(traces));
    let is_told_exactly = prepared.suite.conditions.start.is_off();
    let pairs = prepared.episodes.iter().zip(traces).enumerate();
    pairs
        .map(|(number, (episode, trace))| EpisodeResult {
            episode: number,
            sim_seconds: trace.sim_seconds,
            understood: plans.then(|| {
                let plan = trace.plan.as_ref();
                plan.is_some_and(|plan| is_understood(map, episode, plan))
            }),
            fallbacks: trace
                .plan
                .as_ref()
                .map_or(Vec::new(), |p| p.fallbacks.clone()),
            localization: localization([&trace.pose_errors[..]].into_iter()),
            start: trace.start.filter(|_| !is_told_exactly),
            health: health_spans(&trace.pose_errors),
            stages: stage_spans(&trace.stages, trace.sim_seconds),
            computing: trace.computing.as_ref().map(ComputingSum::from),
        })
        .collect()
}

/// Scores the doors that the agent wrote, over all episodes; `None` if it edits no map.
pub fn score_written_doors(prepared: &Prepared, traces: &[EpisodeTrace]) -> Option<DoorScore> {
    if traces.iter().all(|trace| trace.map.is_none()) {
        return None;
    }
    let written: Vec<PlacedDoor> = traces
        .iter()
        .flat_map(|trace| trace.doors.iter().cloned())
        .collect();
    let (map, on_map) = (prepared.true_map(), prepared.on_map());
    let doors = prepared.world.scene.doors.iter().enumerate();
    // Doors are written into the outlines of the public map, so they are expected there.
    let expected = |(number, door): (usize, &Door)| {
        let at = match door.doorway {
            Some(doorway) => doorway.point(),
            None => doorway_behind(map, door.point(), door.facing),
        };
        PlacedDoor {
            address: door.address.clone(),
            position: on_map.beside(prepared.building(number), at),
        }
    };
    let doors: Vec<PlacedDoor> = doors.map(expected).collect();
    Some(score_doors(&written, &doors))
}

/// The position of a door in OSM, on the outline of its building, from the position of its `plate`
/// and the direction in which that `facing` looks, radians: for imported worlds, which have plates
/// only.
///
/// The plate of a recessed doorway is inside the outline; its door is where a ray from the plate
/// leaves the building. For other plates it is the nearest point of the outline.
// OPEN has a rule of its own for the doors that it writes. The two share no code on purpose: with a
// common rule, an error in it would move the expected and the written door alike and not be seen.
fn doorway_behind(map: &OsmMap, plate: MapPoint, facing: f64) -> MapPoint {
    /// Maximum depth of a recess.
    const MAX_RECESS_CM: u32 = 400;
    /// Step along the ray.
    const STEP_CM: usize = 5;
    let Some(building) = map.nearest_building(plate) else {
        return plate;
    };
    let outline = &map.buildings[building].polygon;
    let mut outwards = (0..MAX_RECESS_CM)
        .step_by(STEP_CM)
        .map(|cm| plate.offset(facing, f64::from(cm) / 100.0));
    // A plate outside the outline would be its own first hit, at distance zero. For those the
    // nearest point is right.
    let in_front = outwards
        .find(|p| !outline.contains(*p))
        .filter(|_| outline.contains(plate));
    in_front.unwrap_or_else(|| outline.nearest_boundary_point(plate).point)
}

/// The instructions that were understood, see [`Understood`]; `None` if the agent plans none.
pub fn understood(prepared: &Prepared, traces: &[EpisodeTrace]) -> Option<Understood> {
    if !makes_plans(traces) {
        return None;
    }
    let map = prepared.true_map();
    let episodes: Vec<_> = prepared.episodes.iter().zip(traces).collect();
    let right: Vec<&Plan> = episodes
        .iter()
        .filter_map(|(episode, trace)| {
            let plan = trace.plan.as_ref()?;
            is_understood(map, episode, plan).then_some(plan)
        })
        .collect();
    let share = |successes| Proportion {
        successes,
        trials: episodes.len(),
    };
    Some(Understood {
        by_planner: share(right.iter().filter(|p| p.fallbacks.is_empty()).count()),
        with_fallbacks: share(right.len()),
    })
}

/// Whether the agent of a run plans its deliveries. One that fails in each episode because it could
/// not plan has tried. In a run with plans, an episode without one counts as not understood.
fn makes_plans(traces: &[EpisodeTrace]) -> bool {
    let causes = [
        FailureCause::NotUnderstood,
        FailureCause::PlannerUnavailable,
    ];
    let could_not = |trace: &EpisodeTrace| trace.failed_by(&causes);
    let has_plan = |trace: &EpisodeTrace| trace.plan.is_some();
    traces.iter().any(has_plan) || (!traces.is_empty() && traces.iter().all(could_not))
}

/// Whether the plan is right: the definition of SRTP, see [`ExpectedPlan::is_met_by`].
fn is_understood(map: &OsmMap, episode: &PreparedEpisode, plan: &Plan) -> bool {
    let expected = ExpectedPlan {
        doors: episode.targets.iter().map(|t| t.address.clone()).collect(),
        before: episode.before.clone(),
    };
    expected.is_met_by(plan, Some(map))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::worlds::{Target, builtin_suite};
    use openbench_core::{Address, PlannedDelivery};
    use openbench_core::{Georeference, LonLat};
    use openbench_osm::OsmData;
    use std::f64::consts::{FRAC_PI_2, PI};

    const METRES_PER_DEGREE: f64 = 111_320.0;

    /// A map with a building of 20 by 10 metres around the origin.
    fn map() -> OsmMap {
        let corners = [(-10.0, -5.0), (10.0, -5.0), (10.0, 5.0), (-10.0, 5.0)];
        let nodes: String = (1..)
            .zip(corners)
            .map(|(id, (x, y))| {
                let (lon, lat) = (x / METRES_PER_DEGREE, y / METRES_PER_DEGREE);
                format!("<node id=\"{id}\" lat=\"{lat:.9}\" lon=\"{lon:.9}\"/>")
            })
            .collect();
        let way = "<way id=\"9\"><nd ref=\"1\"/><nd ref=\"2\"/><nd ref=\"3\"/><nd ref=\"4\"/>\
                   <nd ref=\"1\"/><tag k=\"building\" v=\"yes\"/></way>";
        let xml = format!("<osm version=\"0.6\">{nodes}{way}</osm>");
        let data = OsmData::from_xml(xml.as_bytes()).unwrap();
        OsmMap::new(&data, Georeference::tangent_plane(LonLat::default()))
    }

    fn is_at(found: MapPoint, x: f64, y: f64) -> bool {
        found.distance(MapPoint::new(x, y)) < 0.1
    }

    #[test]
    fn a_door_is_on_the_outline_in_front_of_a_recessed_plate() {
        let map = map();
        // 2 m inside the southern wall, facing south, where the eastern wall is nearer.
        let recessed = MapPoint::new(9.0, -3.0);
        assert!(is_at(doorway_behind(&map, recessed, -FRAC_PI_2), 9.0, -5.0));
        // On a wall, and 1 m in front of it: the nearest point.
        let in_front = MapPoint::new(2.0, -6.0);
        assert!(is_at(doorway_behind(&map, in_front, -FRAC_PI_2), 2.0, -5.0));
        // Too deep for a recess.
        let deep = MapPoint::new(9.0, 0.0);
        assert!(is_at(doorway_behind(&map, deep, PI), 10.0, 0.0));
    }

    #[test]
    fn a_written_door_is_compared_with_the_door_that_was_made_and_not_with_its_plate() {
        let prepared = Prepared::new(builtin_suite("small").unwrap(), None).unwrap();
        let door = &prepared.world.scene.doors[0];
        let (plate, doorway) = (door.point(), door.doorway.unwrap());
        assert!(
            plate.distance(doorway.point()) > 0.3,
            "the plate hangs beside the door"
        );
        let error = |position| {
            let address = door.address.clone();
            let trace = EpisodeTrace {
                map: Some(Vec::new()),
                doors: vec![PlacedDoor { address, position }],
                ..EpisodeTrace::default()
            };
            let score = score_written_doors(&prepared, &[trace]).unwrap();
            score.mean_distance_m.unwrap()
        };
        assert!(error(doorway.point()) < 1e-9);
        assert!(error(plate) > 0.3);
        // Robots stop where one goes in, straight in front of the door.
        let approach = prepared.approach[0].unwrap();
        let ahead = doorway.point().distance(approach);
        assert!(ahead > 0.1);
        let in_front = doorway.point().offset(doorway.yaw, ahead);
        assert!(in_front.distance(approach) < 1e-6);
    }

    fn plan(doors: &[&Address]) -> Plan {
        let delivery = |door: &&Address| PlannedDelivery::to(0, (*door).clone());
        Plan {
            planner: "test".into(),
            deliveries: doors.iter().map(delivery).collect(),
            fallbacks: Vec::new(),
        }
    }

    fn episode(doors: &[&Address], before: &[(usize, usize)]) -> PreparedEpisode {
        PreparedEpisode {
            start: Default::default(),
            instruction: String::new(),
            targets: doors
                .iter()
                .map(|door| Target {
                    address: (*door).clone(),
                    door: None,
                })
                .collect(),
            before: before.to_vec(),
            time_limit: Default::default(),
        }
    }

    #[test]
    fn an_instruction_is_understood_if_the_plan_has_exactly_its_doors_in_their_order() {
        let (first, second) = (Address::new("b1", "u1"), Address::new("b1", "u2"));
        let any_order = episode(&[&first, &second], &[]);
        let understood = |doors: &[&Address]| is_understood(&map(), &any_order, &plan(doors));
        assert!(understood(&[&second, &first]));
        assert!(!understood(&[&first]));
        assert!(!understood(&[&first, &first]));
        assert!(!understood(&[&first, &second, &second]));
        let ordered = episode(&[&first, &second], &[(0, 1)]);
        assert!(is_understood(&map(), &ordered, &plan(&[&first, &second])));
        assert!(!is_understood(&map(), &ordered, &plan(&[&second, &first])));
    }

    #[test]
    fn an_agent_plans_if_it_has_a_plan_or_could_never_make_one() {
        let failed = |cause: FailureCause| EpisodeTrace {
            tasks: vec![outcome(Some(Failure {
                cause,
                detail: String::new(),
            }))],
            ..EpisodeTrace::default()
        };
        let planned = EpisodeTrace {
            plan: Some(plan(&[&Address::new("b1", "u1")])),
            ..EpisodeTrace::default()
        };
        let (misread, silent) = (
            FailureCause::NotUnderstood,
            FailureCause::PlannerUnavailable,
        );
        assert!(makes_plans(&[failed(misread), failed(silent)]));
        assert!(makes_plans(&[planned, failed(misread)]));
        assert!(!makes_plans(&[]));
        assert!(!makes_plans(&[EpisodeTrace::default()]));
        assert!(!makes_plans(&[failed(misread), EpisodeTrace::default()]));
        assert!(!makes_plans(&[
            failed(misread),
            failed(FailureCause::Stuck)
        ]));
    }

    fn outcome(failure: Option<Failure>) -> TaskOutcome {
        let none = Failure {
            cause: FailureCause::Timeout,
            detail: String::new(),
        };
        TaskOutcome {
            declared: true,
            failure,
            ..TaskOutcome::failed(0, none)
        }
    }

    #[test]
    fn a_declaration_at_the_wrong_place_is_a_failure_unless_the_agent_reports_another() {
        let right = Strict {
            success: true,
            correct_unit: true,
        };
        let too_far = Strict {
            success: false,
            correct_unit: true,
        };
        assert_eq!(failure(&outcome(None), &right), None);
        let detail = |strict: &Strict| failure(&outcome(None), strict).unwrap().detail;
        assert!(detail(&too_far).contains("more than 2 m"));
        assert!(detail(&Strict::NOT_DECLARED).contains("another door"));
        let lost = Failure {
            cause: FailureCause::Lost,
            detail: "lost".into(),
        };
        assert_eq!(failure(&outcome(Some(lost.clone())), &too_far), Some(lost));
    }
}
