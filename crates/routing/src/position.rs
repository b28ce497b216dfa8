//! Places on the network, and which of them a place off it stands for.

use crate::geo::{Place, distance};
use crate::metric::Metric;
use crate::roads::Roads;
use crate::tree::{Foot, Nearest};

/// Feet that are so near to the nearest one count as the same place, metres.
const SAME: f64 = 0.02;

/// So many stretches of road are looked at before a place is nowhere: a bearing that no road has would be looked for on the whole map.
const MOST: usize = 20_000;

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
    /// Whether it may be left and reached along the edge, and against it.
    pub open: [bool; 2],
}

/// What a place on the network must be like to stand for one off it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SnapOptions {
    /// How far it may be, metres.
    pub radius: f64,
    /// In which direction one travels there, degrees clockwise from north, and how many degrees that may be off.
    pub bearing: Option<(f64, f64)>,
}

impl Default for SnapOptions {
    fn default() -> Self {
        Self {
            radius: f64::INFINITY,
            bearing: None,
        }
    }
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
        let segment = foot.segment as usize;
        let (mut before, mut all) = (0.0, 0.0);
        for (i, (a, b)) in points.pairs().enumerate() {
            if i == segment {
                before = all + foot.share * distance(a, b);
            }
            all += distance(a, b);
        }
        let share = if all > 0.0 {
            (before / all).min(1.0)
        } else {
            0.0
        };
        // At its end a share is 1, whatever was lost in rounding.
        let at_end = segment + 2 == points.len() && foot.share >= 1.0;
        let share = if at_end { 1.0 } else { share };
        let (edge, segment, place, away) = (foot.edge, foot.segment, foot.place, foot.away);
        Self {
            edge,
            share,
            segment,
            place,
            away,
            open: [true; 2],
        }
    }
}

impl Position {
    /// The share of its edge before the place, in the direction in which the edge is travelled.
    pub fn share_before(&self, directed: u32) -> f64 {
        if directed.is_multiple_of(2) {
            self.share
        } else {
            1.0 - self.share
        }
    }
}

impl SnapOptions {
    /// In which directions a foot's segment may be travelled.
    fn open(&self, roads: &Roads, foot: &Foot) -> [bool; 2] {
        let Some((bearing, range)) = self.bearing else {
            return [true; 2];
        };
        let points = roads.network.edge_points(foot.edge);
        let forward = crate::geo::bearing(
            points.at(foot.segment as usize),
            points.at(foot.segment as usize + 1),
        );
        [forward, forward + 180.0]
            .map(|direction| crate::geo::turn(bearing, direction).abs() <= range)
    }
}

impl Snap {
    /// Where `place` is on the roads of a metric; nowhere if nothing is as the options say.
    pub fn new(
        roads: &Roads,
        metric: &Metric,
        place: Place,
        options: &SnapOptions,
        memory: &mut Nearest,
    ) -> Self {
        let nearest = nearest(roads, metric, place, options, memory, |_| true);
        let in_large = |position: &Position| metric.components.is_large(position.edge);
        let large = if nearest.is_empty() || nearest.iter().any(in_large) {
            Vec::new()
        } else {
            nearest_large(roads, metric, place, options, memory)
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

    /// As [`Snap::positions`].
    pub fn into_positions(self, small: bool) -> Vec<Position> {
        if small || self.large.is_empty() {
            self.nearest
        } else {
            self.large
        }
    }

    /// Where to begin or end: if `small` places will do, the nearest one, or else the nearest in a large component.
    pub fn positions(&self, small: bool) -> &[Position] {
        if small || self.large.is_empty() {
            &self.nearest
        } else {
            &self.large
        }
    }
}

fn nearest_large(
    roads: &Roads,
    metric: &Metric,
    place: Place,
    options: &SnapOptions,
    memory: &mut Nearest,
) -> Vec<Position> {
    nearest(roads, metric, place, options, memory, |edge| {
        metric.components.is_large(edge)
    })
}

/// The nearest place, on each usable edge that goes through it.
fn nearest(
    roads: &Roads,
    metric: &Metric,
    place: Place,
    options: &SnapOptions,
    memory: &mut Nearest,
    usable: impl Fn(u32) -> bool,
) -> Vec<Position> {
    let (mut found, mut looked_at): (Vec<Position>, usize) = (Vec::new(), 0);
    let usable = |edge| metric.is_open(edge) && usable(edge);
    roads.segments.nearest(
        &roads.network,
        place,
        options.radius,
        memory,
        usable,
        |foot| {
            let first = found.first();
            if first.is_some_and(|first| foot.away > first.away + SAME) {
                return false;
            }
            looked_at += 1;
            let same = first.is_none_or(|first| distance(first.place, foot.place) < SAME);
            let bearings = options.open(roads, &foot);
            let open =
                [0, 1].map(|i| bearings[i] && metric.edges[2 * foot.edge as usize + i].is_open());
            if same && open != [false; 2] {
                let position = Position {
                    open,
                    ..Position::new(roads, foot)
                };
                let known = |p: &Position| p.edge == position.edge && p.share == position.share;
                if !found.iter().any(known) {
                    found.push(position);
                }
            }
            looked_at < MOST
        },
    );
    // Where a public road and private ground meet, one is on the road.
    let public = |p: &Position| {
        (0..2).any(|i| p.open[i] && !metric.edges[2 * p.edge as usize + i].ends_only())
    };
    if found.iter().any(public) {
        found.retain(public);
    }
    found
}

/// The nearest places on different stretches of road, nearest first, `count` at most.
pub fn several(
    roads: &Roads,
    metric: &Metric,
    place: Place,
    count: usize,
    options: &SnapOptions,
    memory: &mut Nearest,
) -> Vec<Position> {
    let (mut found, mut looked_at) = (Vec::new(), 0);
    let usable = |edge| metric.is_open(edge);
    roads.segments.nearest(
        &roads.network,
        place,
        options.radius,
        memory,
        usable,
        |foot| {
            let bearings = options.open(roads, &foot);
            let open =
                [0, 1].map(|i| bearings[i] && metric.edges[2 * foot.edge as usize + i].is_open());
            if open != [false; 2] && found.iter().all(|p: &Position| p.edge != foot.edge) {
                found.push(Position {
                    open,
                    ..Position::new(roads, foot)
                });
            }
            looked_at += 1;
            found.len() < count && looked_at < MOST
        },
    );
    found
}
