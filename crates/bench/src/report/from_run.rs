//! From results and traces to the input of a report.

use openbench_core::MapPoint;
use openbench_geometry::Polygon;

use super::{Declaration, DoorMark, EpisodeReport, MapArea, PlateFrame, ReportInput, WorldMap};
use crate::score::results::Results;
use crate::trace::{EpisodeTrace, Frame};
use crate::worlds::{Prepared, PreparedEpisode};

/// The input of a run's report.
pub fn report_input<'a>(
    prepared: &Prepared,
    results: &'a Results,
    traces: &[EpisodeTrace],
    command: &str,
) -> ReportInput<'a> {
    let pairs = prepared.episodes.iter().zip(traces).enumerate();
    ReportInput {
        results,
        command: command.to_owned(),
        worlds: vec![world_map(prepared)],
        episodes: pairs
            .map(|(i, (episode, trace))| episode_report(prepared, results, i, episode, trace))
            .collect(),
    }
}

fn world_map(prepared: &Prepared) -> WorldMap {
    let map = prepared.public_map();
    let area = |name: Option<&String>, polygon: &Polygon| MapArea {
        name: name.cloned(),
        outline: polygon.outer.clone(),
        holes: polygon.holes.clone(),
    };
    WorldMap {
        name: prepared.world.name.clone(),
        buildings: map
            .buildings
            .iter()
            .map(|b| area(b.name.as_ref(), &b.polygon))
            .collect(),
        roads: map.roads.iter().map(|r| r.points.clone()).collect(),
        barriers: map.barriers.iter().map(|b| b.points.clone()).collect(),
        areas: map
            .areas
            .iter()
            // The parts of a building stand on its outline, which is drawn already.
            .filter(|a| !a.tags.says("building:part"))
            .map(|a| area(None, &a.polygon))
            .collect(),
    }
}

fn episode_report(
    prepared: &Prepared,
    results: &Results,
    number: usize,
    episode: &PreparedEpisode,
    trace: &EpisodeTrace,
) -> EpisodeReport {
    let wanted = |door: usize| episode.targets.iter().any(|t| t.door == Some(door));
    let doors = prepared.world.scene.doors.iter().enumerate();
    // All in the frame of the public map, which the report draws.
    let on_map = prepared.on_map();
    let points = |points: &[MapPoint]| points.iter().map(|at| on_map.point(*at)).collect();
    let declared = results
        .deliveries
        .iter()
        .filter(|d| d.episode == number)
        .filter_map(|d| {
            Some(Declaration {
                task: d.task,
                address: d.address(),
                position: on_map.point(d.declared_at?),
                success: d.success_2m,
            })
        });
    let found = trace.doors.iter();
    EpisodeReport {
        episode: number,
        world: 0,
        start: on_map.pose(prepared.world.start),
        driven: points(&trace.driven),
        estimated: trace.estimated.clone(),
        pose_errors: trace.pose_errors.clone(),
        comparisons: trace.comparisons.clone(),
        routes: trace.routes.clone(),
        true_doors: doors
            .map(|(i, d)| DoorMark {
                address: d.address.clone(),
                position: on_map.beside(prepared.building(i), d.entrance().point()),
                wanted: wanted(i),
            })
            .collect(),
        found_doors: found
            .map(|door| DoorMark {
                address: door.address.clone(),
                position: door.position,
                // Whether a door was requested is shown by its true mark.
                wanted: false,
            })
            .collect(),
        declared: declared.collect(),
        collisions: trace
            .collisions
            .iter()
            .map(|c| on_map.point(MapPoint::new(c.pose.x, c.pose.y)))
            .collect(),
        plates: frames(trace),
        plan: trace
            .plan
            .as_ref()
            .map(|p| p.deliveries.clone())
            .unwrap_or_default(),
    }
}

/// The last images, each with the plate of highest confidence that was read in it.
fn frames(trace: &EpisodeTrace) -> Vec<PlateFrame> {
    let frame = |f: &Frame| {
        // Exactly equal: the rollout stamps a plate and its image with the time of the same event.
        let read = trace.plates.iter().filter(|p| p.time == f.time);
        let best = read.max_by(|a, b| a.confidence.total_cmp(&b.confidence))?;
        Some(PlateFrame {
            // Without the image, the text that was read is still of use.
            jpeg: f.jpeg.clone(),
            width: f.width,
            height: f.height,
            time: f.time,
            text: best.text.clone(),
            confidence: best.confidence,
            corners: best.corners,
        })
    };
    trace.frames.iter().filter_map(frame).collect()
}
