//! Places on the network, and which of them a place off it stands for.

use crate::geo::{Place, distance};
use crate::metric::Metric;
use crate::roads::Roads;
use crate::tree::{Foot, Nearest};

/// Feet that are so near to the nearest one count as the same place, metres.
const SAME: f64 = 0.02;

/// A place on an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// The edge.
    pub edge: u32,
    /// The share of its length before the place, from 0 to 1.
    pub share: f64,
    /// Its segment that the place is on.
    pub segment: u32,
    /// Where it is.
    pub place: Place,
    /// Metres from the place that was asked about.
    pub away: f64,
}

/// Where a place off the network may be thought to be on it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Snap {
    /// The nearest place: on each edge that goes through it.
    pub nearest: Vec<Position>,
    /// The same in a large component, if the nearest place is in none.
    pub large: Vec<Position>,
}

impl Position {
    fn new(roads: &Roads, foot: Foot) -> Self {
        let points = roads.network.edge_points(foot.edge);
        let length = |points: &[Place]| points.windows(2).map(|pair| distance(pair[0], pair[1])).sum::<f64>();
        let segment = foot.segment as usize;
        let before =
            length(&points[..=segment]) + foot.share * distance(points[segment], points[segment + 1]);
        let all = length(points);
        let share = if all > 0.0 { (before / all).min(1.0) } else { 0.0 };
        // At its end a share is 1, whatever was lost in rounding.
        let at_end = segment + 2 == points.len() && foot.share >= 1.0;
        let share = if at_end { 1.0 } else { share };
        Self { edge: foot.edge, share, segment: foot.segment, place: foot.place, away: foot.away }
    }
}

impl Snap {
    /// Where `place` is on the roads of a metric, if something is within `limit` metres.
    pub fn new(roads: &Roads, metric: &Metric, place: Place, limit: f64, memory: &mut Nearest) -> Self {
        let nearest = nearest(roads, place, limit, memory, |edge| metric.is_open(edge));
        let in_large = |position: &Position| metric.components.is_large(position.edge);
        let large = if nearest.iter().any(in_large) {
            Vec::new()
        } else {
            nearest_large(roads, metric, place, limit, memory)
        };
        Self { nearest, large }
    }

    /// Whether all of a route's places can be where they are nearest, although none of these is in a large component: all are in the same
    /// small one.
    pub fn small_will_do(snaps: &[Self], metric: &Metric) -> bool {
        let component = |snap: &Self| {
            let first = snap.nearest.first().filter(|_| !snap.large.is_empty())?;
            metric.components.of(first.edge)
        };
        let first = snaps.first().and_then(component);
        first.is_some() && snaps.iter().all(|snap| component(snap) == first)
    }

    /// Where to begin or end: if `small` places will do, the nearest one, or else the nearest in a large component.
    pub fn positions(&self, small: bool) -> &[Position] {
        if small || self.large.is_empty() { &self.nearest } else { &self.large }
    }
}

fn nearest_large(
    roads: &Roads,
    metric: &Metric,
    place: Place,
    limit: f64,
    memory: &mut Nearest,
) -> Vec<Position> {
    let usable = |edge| metric.is_open(edge) && metric.components.is_large(edge);
    nearest(roads, place, limit, memory, usable)
}

/// The nearest place, on each usable edge that goes through it.
fn nearest(
    roads: &Roads,
    place: Place,
    limit: f64,
    memory: &mut Nearest,
    usable: impl Fn(u32) -> bool,
) -> Vec<Position> {
    let mut found: Vec<Position> = Vec::new();
    roads.segments.nearest(&roads.network, place, limit, memory, usable, |foot| {
        let first = found.first();
        if first.is_some_and(|first| foot.away > first.away + SAME) {
            return false;
        }
        if first.is_none_or(|first| distance(first.place, foot.place) < SAME) {
            let position = Position::new(roads, foot);
            let known = |p: &Position| p.edge == position.edge && p.share == position.share;
            if !found.iter().any(known) {
                found.push(position);
            }
        }
        true
    });
    found
}
