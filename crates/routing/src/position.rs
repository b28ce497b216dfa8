//! Places on the network, and snapping: which of them stands for a place off the network.

use crate::geo::{Place, bearing, distance, turn};
use crate::metric::Metric;
use crate::roads::Roads;
use crate::tree::{Foot, Nearest};

/// Feet this near to the nearest one count as the same place, metres.
const SAME_M: f64 = 0.02;

/// How many stretches of road are examined before a place counts as not found. Without a limit a
/// bearing that no road has would be looked for on the whole map.
const MOST_EXAMINED: usize = 20_000;

/// A place on an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// The edge.
    pub edge: u32,
    /// The share of its length before the place, from 0 to 1.
    pub share: f64,
    /// Its segment on which the place is.
    pub segment: u32,
    /// The place itself.
    pub place: Place,
    /// Metres from the place that was asked about.
    pub away: f64,
    /// Whether it may be left and reached along the edge, and against it.
    pub open: [bool; 2],
}

/// Which places on the network may stand for one off it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SnapOptions {
    /// How far away they may be, metres.
    pub radius: f64,
    /// In which directions one must be able to travel there; any, if there is none.
    pub bearing: Option<BearingRange>,
}

/// Directions around a bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingRange {
    /// Degrees clockwise from north.
    pub bearing: f64,
    /// The greatest difference to either side, degrees.
    pub tolerance: f64,
}

impl BearingRange {
    /// Whether a direction is in the range.
    pub fn contains(&self, direction: f64) -> bool {
        turn(self.bearing, direction).abs() <= self.tolerance
    }
}

impl Default for SnapOptions {
    fn default() -> Self {
        Self {
            radius: f64::INFINITY,
            bearing: None,
        }
    }
}

/// The positions that may stand for a place off the network.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Snap {
    /// The nearest place: a position on each edge through it.
    pub nearest: Vec<Position>,
    /// The nearest place in a large component, if the nearest one of all is in a small one.
    pub large: Vec<Position>,
}

impl Position {
    fn new(roads: &Roads, foot: Foot, open: [bool; 2]) -> Self {
        let Foot {
            edge,
            segment,
            place,
            away,
            ..
        } = foot;
        Self {
            edge,
            share: share_before(roads, foot),
            segment,
            place,
            away,
            open,
        }
    }

    /// The share of its edge before the place, in the direction in which the edge is travelled.
    pub(crate) fn share_before(&self, directed: u32) -> f64 {
        if directed.is_multiple_of(2) {
            self.share
        } else {
            1.0 - self.share
        }
    }
}

/// The share of its edge's length before a foot.
fn share_before(roads: &Roads, foot: Foot) -> f64 {
    let points = roads.network.edge_points(foot.edge);
    let segment = foot.segment as usize;
    // At the edge's end the share is exactly 1, whatever rounding does.
    if segment + 2 == points.len() && foot.share >= 1.0 {
        return 1.0;
    }
    let (mut before, mut all) = (0.0, 0.0);
    for (i, [a, b]) in points.pairs().enumerate() {
        if i == segment {
            before = all + foot.share * distance(a, b);
        }
        all += distance(a, b);
    }
    if all > 0.0 {
        (before / all).min(1.0)
    } else {
        0.0
    }
}

impl SnapOptions {
    /// In which directions a foot's segment may be travelled.
    fn open(&self, roads: &Roads, foot: &Foot) -> [bool; 2] {
        let Some(range) = self.bearing else {
            return [true; 2];
        };
        let points = roads.network.edge_points(foot.edge);
        let segment = foot.segment as usize;
        let forward = bearing(points.at(segment), points.at(segment + 1));
        // `contains` takes bearings modulo 360.
        [forward, forward + 180.0].map(|direction| range.contains(direction))
    }
}

impl Snap {
    /// The positions of `place` on the roads of a metric. None, if no position fits the options.
    pub fn new(
        roads: &Roads,
        metric: &Metric,
        place: Place,
        options: &SnapOptions,
        memory: &mut Nearest,
    ) -> Self {
        let is_large = |edge| metric.components.is_large(edge);
        let nearest = nearest(roads, metric, place, options, memory, |_| true);
        let suffices = nearest.is_empty() || nearest.iter().any(|position| is_large(position.edge));
        let large = match suffices {
            true => Vec::new(),
            false => self::nearest(roads, metric, place, options, memory, is_large),
        };
        Self { nearest, large }
    }

    /// Whether all of a route's places can stay where they are nearest although none of these is
    /// in a large component: all are in the same small one.
    pub(crate) fn small_suffices(snaps: &[Self], metric: &Metric) -> bool {
        let component = |snap: &Self| {
            // `large` is only filled if the nearest place is in a small component.
            let first = snap.nearest.first().filter(|_| !snap.large.is_empty())?;
            metric.components.of(first.edge)
        };
        let first = snaps.first().and_then(component);
        first.is_some() && snaps.iter().all(|snap| component(snap) == first)
    }

    /// As [`Snap::positions`].
    pub(crate) fn into_positions(self, small: bool) -> Vec<Position> {
        if small || self.large.is_empty() {
            self.nearest
        } else {
            self.large
        }
    }

    /// Where to begin or end: if small components will do, at the nearest place, else at the
    /// nearest place in a large component.
    pub fn positions(&self, small: bool) -> &[Position] {
        if small || self.large.is_empty() {
            &self.nearest
        } else {
            &self.large
        }
    }
}

/// The nearest place, on each usable edge through it.
fn nearest(
    roads: &Roads,
    metric: &Metric,
    place: Place,
    options: &SnapOptions,
    memory: &mut Nearest,
    is_usable: impl Fn(u32) -> bool,
) -> Vec<Position> {
    let (mut found, mut examined): (Vec<Position>, usize) = (Vec::new(), 0);
    let is_usable = |edge| metric.is_open(edge) && is_usable(edge);
    roads.segments.nearest(
        &roads.network,
        place,
        options.radius,
        memory,
        is_usable,
        |foot| {
            let first = found.first();
            // Feet come nearest first, so none of those that follow is at the same place.
            if first.is_some_and(|first| foot.away > first.away + SAME_M) {
                return false;
            }
            examined += 1;
            // Equally far is not enough: two roads may lie on opposite sides of the place.
            let is_same = first.is_none_or(|first| distance(first.place, foot.place) < SAME_M);
            let open = open_directions(roads, metric, options, &foot);
            if is_same && open != [false; 2] {
                let position = Position::new(roads, foot, open);
                // A point between two runs of segments is the foot of both.
                let is_known = found
                    .iter()
                    .any(|known| known.edge == position.edge && known.share == position.share);
                if !is_known {
                    found.push(position);
                }
            }
            examined < MOST_EXAMINED
        },
    );
    keep_public(metric, &mut found);
    found
}

/// Where a public road and private ground meet, the place is on the road.
fn keep_public(metric: &Metric, positions: &mut Vec<Position>) {
    let is_public = |position: &Position| {
        (0..2).any(|side| {
            let cost = metric.edges[2 * position.edge as usize + side];
            position.open[side] && !cost.ends_only()
        })
    };
    if positions.iter().any(is_public) {
        positions.retain(is_public);
    }
}

/// In which directions a foot's edge may be travelled, by the options and the profile.
fn open_directions(
    roads: &Roads,
    metric: &Metric,
    options: &SnapOptions,
    foot: &Foot,
) -> [bool; 2] {
    let bearings = options.open(roads, foot);
    [0, 1].map(|side| bearings[side] && metric.edges[2 * foot.edge as usize + side].is_open())
}

/// The nearest places on different stretches of road, nearest first, `count` at most.
pub(crate) fn several(
    roads: &Roads,
    metric: &Metric,
    place: Place,
    count: usize,
    options: &SnapOptions,
    memory: &mut Nearest,
) -> Vec<Position> {
    let (mut found, mut examined): (Vec<Position>, usize) = (Vec::new(), 0);
    let is_usable = |edge| metric.is_open(edge);
    roads.segments.nearest(
        &roads.network,
        place,
        options.radius,
        memory,
        is_usable,
        |foot| {
            let open = open_directions(roads, metric, options, &foot);
            // Feet on other runs of an edge follow later, since they are farther away.
            if open != [false; 2] && found.iter().all(|known| known.edge != foot.edge) {
                found.push(Position::new(roads, foot, open));
            }
            examined += 1;
            found.len() < count && examined < MOST_EXAMINED
        },
    );
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bearings_are_compared_across_north() {
        let range = BearingRange {
            bearing: 350.0,
            tolerance: 20.0,
        };
        assert!(range.contains(5.0) && range.contains(330.0) && range.contains(365.0));
        assert!(!range.contains(15.0) && !range.contains(170.0));
    }
}
