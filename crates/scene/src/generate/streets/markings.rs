//! Lines on the ground: dashed middle lines, zebra crossings.

use std::collections::BTreeMap;

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Segment, segments};
use openbench_osm::Road;

use super::profile::profile;
use super::stripes;
use crate::generate::inputs::Inputs;
use crate::generate::layout::features::Feature;
use crate::generate::output::Output;
use crate::material::SemanticClass;

/// Length of a dash, metres.
const DASH_M: f64 = 2.0;
/// Length of a dash with its gap, metres.
const DASH_SPACING_M: f64 = 5.0;
/// Width of a dash, metres.
const DASH_WIDTH_M: f64 = 0.12;
/// Dashes in one segment at most.
const MAX_DASHES: usize = 2_000;
/// No dashes within this distance of a junction or crossing, metres.
const JUNCTION_M: f64 = 6.0;
/// Length of a zebra along the road, metres.
const ZEBRA_LENGTH_M: f64 = 2.8;
/// Width of a zebra's stripe, metres.
const ZEBRA_STRIPE_M: f64 = 0.5;
/// Width of a zebra's stripe with its gap, metres.
const ZEBRA_SPACING_M: f64 = 1.0;
/// Narrowest carriageway with a zebra, metres.
const NARROWEST_ZEBRA_M: f64 = 4.5;

/// Builds the markings of all streets.
pub(crate) fn build(inputs: &Inputs, out: &mut Output) {
    let roads = &inputs.map.roads;
    let breaks = Breaks::new(roads, &inputs.features);
    out.scene.begin_object("road markings", SemanticClass::Road);
    for road in roads
        .iter()
        .filter(|r| profile(&r.tags).is_some_and(|p| p.marked))
    {
        for segment in segments(&road.points) {
            dashes(inputs, out, segment, &breaks);
        }
    }
    zebras(inputs, out);
}

fn dashes(inputs: &Inputs, out: &mut Output, segment: Segment, breaks: &Breaks) {
    let length = segment.length();
    let count = ((length / DASH_SPACING_M) as usize).min(MAX_DASHES);
    for i in 0..count {
        // What is left of the length is divided between both ends.
        let start = (length - count as f64 * DASH_SPACING_M) / 2.0
            + i as f64 * DASH_SPACING_M
            + (DASH_SPACING_M - DASH_M) / 2.0;
        let dash = segment.part(start / length, (start + DASH_M) / length);
        let middle = dash.middle();
        if !breaks.is_near(middle) && inputs.is_on_ground(middle) {
            let pose = Pose2::new(middle.x, middle.y, dash.bearing());
            stripes::paint(inputs, out, pose, DASH_M, DASH_WIDTH_M);
        }
    }
}

/// Carriageway at a node.
struct Carriageway {
    /// Direction along it, radians.
    yaw: f64,
    /// Metres.
    width: f64,
}

fn zebras(inputs: &Inputs, out: &mut Output) {
    let carriageways = carriageways(&inputs.map.roads);
    let is_zebra = |f: &&Feature| is_crossing(f) && !f.tags.is("crossing:markings", "no");
    for crossing in inputs.features.iter().filter(is_zebra) {
        // Crossings of paths, and those on no way at all, have no stripes.
        let Some(Carriageway { yaw, width }) = carriageways.get(&crossing.node) else {
            continue;
        };
        let pose = Pose2::new(crossing.position.x, crossing.position.y, *yaw);
        let count = ((width - 0.3) / ZEBRA_SPACING_M) as usize;
        for i in 0..count {
            let left = (i as f64 - (count as f64 - 1.0) / 2.0) * ZEBRA_SPACING_M;
            let p = pose.transform(0.0, left);
            let stripe = Pose2::new(p.x, p.y, *yaw);
            stripes::paint(inputs, out, stripe, ZEBRA_LENGTH_M, ZEBRA_STRIPE_M);
        }
    }
}

fn is_crossing(feature: &Feature) -> bool {
    feature.tags.is("highway", "crossing")
}

/// The carriageway at each node of a road for cars; of several the last.
fn carriageways(roads: &[Road]) -> BTreeMap<i64, Carriageway> {
    let mut found = BTreeMap::new();
    for road in roads {
        let profile = profile(&road.tags);
        let Some(profile) = profile.filter(|p| p.for_cars && p.width >= NARROWEST_ZEBRA_M) else {
            continue;
        };
        for (i, node) in road.nodes.iter().enumerate() {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(road.points.len() - 1));
            let yaw = road.points[before].bearing_to(road.points[after]);
            found.insert(
                *node,
                Carriageway {
                    yaw,
                    width: profile.width,
                },
            );
        }
    }
    found
}

/// Where middle lines are interrupted: junctions of carriageways and crossings.
struct Breaks {
    /// By cell of the size of [`JUNCTION_M`].
    cells: BTreeMap<Cell, Vec<MapPoint>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Cell {
    x: i64,
    y: i64,
}

impl Cell {
    fn of(p: MapPoint) -> Self {
        Self {
            x: (p.x / JUNCTION_M).floor() as i64,
            y: (p.y / JUNCTION_M).floor() as i64,
        }
    }
}

impl Breaks {
    fn new(roads: &[Road], features: &[Feature]) -> Self {
        let crossings = features
            .iter()
            .filter(|f| is_crossing(f))
            .map(|f| f.position);
        let mut cells: BTreeMap<Cell, Vec<MapPoint>> = BTreeMap::new();
        for p in junctions(roads).into_iter().chain(crossings) {
            cells.entry(Cell::of(p)).or_default().push(p);
        }
        Self { cells }
    }

    fn is_near(&self, point: MapPoint) -> bool {
        let Cell { x, y } = Cell::of(point);
        // A cell is as wide as the distance that is searched, so its neighbours hold all that is
        // near.
        let columns = x - 1..=x + 1;
        let around = columns.flat_map(|x| (y - 1..=y + 1).map(move |y| Cell { x, y }));
        let mut points = around.filter_map(|cell| self.cells.get(&cell)).flatten();
        points.any(|p| p.distance(point) < JUNCTION_M)
    }
}

/// A node of a road, and the number of arms that roads have there.
struct Node {
    arms: u32,
    position: MapPoint,
}

/// The nodes at which carriageways have more than two arms.
fn junctions(roads: &[Road]) -> Vec<MapPoint> {
    let mut nodes: BTreeMap<i64, Node> = BTreeMap::new();
    for road in roads
        .iter()
        .filter(|r| profile(&r.tags).is_some_and(|p| p.for_cars))
    {
        for (i, (node, point)) in road.nodes.iter().zip(&road.points).enumerate() {
            // A way that runs through a node has two arms there.
            let is_inner = i > 0 && i + 1 < road.points.len();
            let node = nodes.entry(*node).or_insert(Node {
                arms: 0,
                position: *point,
            });
            node.arms += if is_inner { 2 } else { 1 };
        }
    }
    nodes
        .values()
        .filter(|node| node.arms > 2)
        .map(|node| node.position)
        .collect()
}
