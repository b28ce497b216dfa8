//! Where a leg runs.

use std::ops::Range;

use super::travel::Leg;
use crate::geo::Place;
use crate::roads::Roads;

/// The line of a leg.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Line {
    /// Its points; no two neighbours are the same place.
    pub points: Vec<Place>,
    /// For each of the leg's edges the index of its last point.
    pub ends: Vec<usize>,
}

impl Line {
    fn push(&mut self, point: Place) {
        if self.points.last() != Some(&point) {
            self.points.push(point);
        }
    }

    /// The points of some of the leg's edges. At least one point, at the leg's end.
    pub fn part(&self, edges: Range<usize>) -> &[Place] {
        let first = edges
            .start
            .checked_sub(1)
            .map_or(0, |before| self.ends[before]);
        let last = edges.end.checked_sub(1).map_or(0, |last| self.ends[last]);
        &self.points[first..=last.max(first)]
    }
}

/// The part of an edge that a leg travels, in the edge's own direction: the points between its
/// first and its last place.
pub(crate) struct TravelledPart {
    /// Indices of the edge's points that are passed.
    pub(crate) points: Range<usize>,
    /// Whether the part begins within the edge, not at its first vertex.
    pub(crate) begins_within: bool,
    /// Whether the part ends within the edge, not at its last vertex.
    pub(crate) ends_within: bool,
}

impl Leg {
    /// The line from its first place to its last.
    pub fn line(&self, roads: &Roads) -> Line {
        let mut line = Line {
            points: vec![self.from.place],
            ends: Vec::with_capacity(self.edges.len()),
        };
        for (i, &directed) in self.edges.iter().enumerate() {
            let points = roads.network.edge_points(directed / 2);
            let passed = self.travelled_part(i, points.len()).points;
            let between = points.part(passed.start, passed.end);
            if directed.is_multiple_of(2) {
                between.for_each(|point| line.push(point));
            } else {
                between.rev().for_each(|point| line.push(point));
            }
            // The goal lies within the last edge, behind all of its points that are passed.
            if i + 1 == self.edges.len() {
                line.push(self.to.place);
            }
            line.ends.push(line.points.len() - 1);
        }
        line
    }

    /// The part of the edge of that index, which has so many points, that is travelled.
    pub(crate) fn travelled_part(&self, index: usize, points: usize) -> TravelledPart {
        let is_forward = self.edges[index].is_multiple_of(2);
        let (begins, ends) = (index == 0, index + 1 == self.edges.len());
        let [a, b] = if is_forward {
            [&self.from, &self.to]
        } else {
            [&self.to, &self.from]
        };
        let [begins_within, ends_within] = if is_forward {
            [begins, ends]
        } else {
            [ends, begins]
        };
        // Segment `i` leads from point `i` to point `i + 1`: the first point passed is behind the
        // place, the last one before it. Within one segment the range is empty.
        let first = if begins_within {
            a.segment as usize + 1
        } else {
            0
        };
        let last = if ends_within {
            b.segment as usize + 1
        } else {
            points
        };
        TravelledPart {
            points: first..last,
            begins_within,
            ends_within,
        }
    }
}
