//! Turn-by-turn instructions: where to turn, and into which road.
//!
//! The terms are those of OSRM's API (`StepManeuver`). When each of them is used follows its
//! documentation, not its code.

use std::ops::Range;

use crate::bearings::{along, leaving, reaching};
use crate::geo::turn;
use crate::leg::{Leg, Line, Measures};
use crate::metric::Metric;
use crate::network::Network;
use crate::roads::Roads;

/// Turns by less than this continue along the road, degrees.
const STRAIGHT_DEG: f64 = 40.0;
/// A road that is met at an angle in this range is met crosswise, degrees.
const ACROSS_DEG: std::ops::RangeInclusive<f64> = 50.0..=130.0;
/// Whoever keeps to a side at a fork turns by at least this much, degrees: [`modifier`] then says
/// to which side.
const LEAST_FORK_DEG: f64 = 20.0;

/// What to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub(crate) enum Kind {
    /// Begin the route.
    Depart,
    /// The route has ended.
    Arrive,
    /// Turn into another road.
    Turn,
    /// Stay on the road although it turns.
    Continue,
    /// Go straight on; the road changes its name.
    NewName,
    /// Keep to one side where the road forks.
    Fork,
    /// Turn where the road ends in another.
    EndOfRoad,
    /// Enter a roundabout and leave it by an exit.
    Roundabout,
    /// Leave the roundabout.
    ExitRoundabout,
}

impl Kind {
    /// OSRM's term.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Depart => "depart",
            Self::Arrive => "arrive",
            Self::Turn => "turn",
            Self::Continue => "continue",
            Self::NewName => "new name",
            Self::Fork => "fork",
            Self::EndOfRoad => "end of road",
            Self::Roundabout => "roundabout",
            Self::ExitRoundabout => "exit roundabout",
        }
    }
}

/// OSRM's term for a turn by an angle in degrees, positive to the right.
pub(crate) fn modifier(turn: f64) -> &'static str {
    let [right, left] = match turn.abs() {
        size if size < 20.0 => ["straight"; 2],
        size if size < 40.0 => ["slight right", "slight left"],
        size if size < 120.0 => ["right", "left"],
        size if size < 170.0 => ["sharp right", "sharp left"],
        _ => ["uturn"; 2],
    };
    if turn > 0.0 { right } else { left }
}

/// A stretch of the route with one maneuver at its beginning.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Step {
    /// The maneuver.
    pub kind: Kind,
    /// Its direction, see [`modifier`]; `None` on departure and arrival.
    pub modifier: Option<&'static str>,
    /// The exit by which a roundabout is left, from 1.
    pub exit: Option<usize>,
    /// Directions before and after the maneuver, degrees clockwise from north; 0 where there is
    /// none.
    pub bearings: [f64; 2],
    /// The leg's edges that belong to the step; none on arrival.
    pub edges: Range<usize>,
    /// Their length, duration and weight.
    pub measures: Measures,
}

/// An edge that leaves a junction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Exit {
    /// The directed edge.
    pub directed: u32,
    /// Its direction at the junction, degrees clockwise from north.
    pub bearing: f64,
    /// Whether it may be used.
    pub open: bool,
}

/// A maneuver where one edge follows another.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Maneuver {
    kind: Kind,
    /// Degrees, positive to the right.
    turn: f64,
}

/// Gives instructions for routes of a profile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Guide<'a> {
    /// The network.
    pub roads: &'a Roads,
    /// The profile's costs.
    pub metric: &'a Metric,
}

impl Guide<'_> {
    /// All edges that leave a vertex.
    pub(crate) fn exits(&self, vertex: u32) -> impl Iterator<Item = Exit> + '_ {
        let out = &self.roads.vertices.out;
        out.of(vertex).map(move |slot| self.exit(out.via[slot]))
    }

    /// A directed edge as an exit of the vertex that it leaves.
    pub(crate) fn exit(&self, directed: u32) -> Exit {
        let open = self.metric.edges[directed as usize].is_open();
        Exit {
            directed,
            bearing: leaving(self.network(), directed),
            open,
        }
    }

    /// The steps of a leg, the last of which is the arrival.
    pub(crate) fn steps(&self, leg: &Leg, line: &Line) -> Vec<Step> {
        let mut begin = 0;
        let mut maneuver = None;
        let mut steps = Vec::new();
        for i in 1..leg.edges.len() {
            if let Some(next) = self.maneuver(leg.edges[i - 1], leg.edges[i]) {
                steps.push(self.step(leg, line, maneuver, begin..i));
                (begin, maneuver) = (i, Some(next));
            }
        }
        steps.push(self.step(leg, line, maneuver, begin..leg.edges.len()));
        steps.push(arrival(leg, line));
        steps
    }

    fn network(&self) -> &Network {
        &self.roads.network
    }

    /// The number of a directed edge's name.
    fn name(&self, directed: u32) -> u32 {
        self.network().edges[directed as usize / 2].name
    }

    /// Whether a directed edge is part of a roundabout, if the profile drives.
    fn is_roundabout(&self, directed: u32) -> bool {
        let class = self.network().edges[directed as usize / 2].class;
        let has_junction = |kind| self.network().way_tags.is(class, "junction", kind);
        self.metric.profile.turns().is_some()
            && (has_junction("roundabout") || has_junction("circular"))
    }

    /// The step of some of a leg's edges, which begins with a maneuver or is the departure.
    fn step(
        &self,
        leg: &Leg,
        line: &Line,
        maneuver: Option<Maneuver>,
        edges: Range<usize>,
    ) -> Step {
        let kind = maneuver.map_or(Kind::Depart, |maneuver| maneuver.kind);
        let exits = match kind {
            Kind::Roundabout => self.exits_passed(leg, edges.clone()),
            _ => 0,
        };
        let before = match edges.start.checked_sub(1) {
            None => 0.0,
            Some(before) => reaching(self.network(), leg.edges[before]),
        };
        // The directions by which the turn was chosen, which are also those of the junction's
        // roads. The route begins within an edge, whose line alone is known there.
        let after = match edges.start {
            0 => along(line.part(edges.clone()).iter().copied()),
            first => leaving(self.network(), leg.edges[first]),
        };
        Step {
            kind,
            modifier: maneuver.map(|maneuver| modifier(maneuver.turn)),
            exit: Some(exits).filter(|exits| *exits > 0),
            bearings: [before, after],
            measures: self.measures(leg, edges.clone()),
            edges,
        }
    }

    fn measures(&self, leg: &Leg, edges: Range<usize>) -> Measures {
        let all = edges.map(|i| leg.measures(self.roads, self.metric, i));
        all.fold(Measures::default(), |sum, edge| Measures {
            length: sum.length + edge.length,
            duration: sum.duration + edge.duration,
            weight: sum.weight + edge.weight,
        })
    }

    /// The number of a roundabout's exits up to the one that is taken.
    fn exits_passed(&self, leg: &Leg, edges: Range<usize>) -> usize {
        // The end of the leg is no exit.
        let passed = edges.filter(|i| i + 1 < leg.edges.len());
        let ends = passed.map(|i| self.network().ends(leg.edges[i])[1]);
        ends.filter(|vertex| self.has_exit_of_roundabout(*vertex))
            .count()
    }

    fn has_exit_of_roundabout(&self, vertex: u32) -> bool {
        self.exits(vertex)
            .any(|exit| exit.open && !self.is_roundabout(exit.directed))
    }

    /// The maneuver where one directed edge follows another; `None` if there is nothing to say.
    fn maneuver(&self, from: u32, to: u32) -> Option<Maneuver> {
        // The road stays the same, so a U-turn is a `continue` with the modifier `uturn`.
        if to == from ^ 1 {
            return Some(Maneuver {
                kind: Kind::Continue,
                turn: 180.0,
            });
        }
        let before = reaching(self.network(), from);
        let taken = turn(before, leaving(self.network(), to));
        match (self.is_roundabout(from), self.is_roundabout(to)) {
            (false, true) => {
                return Some(Maneuver {
                    kind: Kind::Roundabout,
                    turn: taken,
                });
            }
            (true, false) => {
                return Some(Maneuver {
                    kind: Kind::ExitRoundabout,
                    turn: taken,
                });
            }
            // The exits that are passed are counted by `exits_passed` instead.
            (true, true) => return None,
            (false, false) => {}
        }
        // Roads that the traveller could take instead: not closed ones, and not the way back.
        let exits = self.exits(self.network().ends(from)[1]);
        let others: Vec<Exit> = exits
            .filter(|exit| exit.open && exit.directed != to && exit.directed != from ^ 1)
            .collect();
        // Without a choice there is no turn to announce, however sharp the bend.
        if others.is_empty() {
            return self.new_name(from, to, taken);
        }
        if taken.abs() < STRAIGHT_DEG {
            return self.straight_on(from, to, taken, &others);
        }
        let angles: Vec<f64> = others
            .iter()
            .map(|exit| turn(before, exit.bearing))
            .collect();
        let kind = if is_end_of_road(taken, &angles) {
            Kind::EndOfRoad
        } else if self.keeps_name(from, to) {
            Kind::Continue
        } else {
            Kind::Turn
        };
        Some(Maneuver { kind, turn: taken })
    }

    /// The maneuver at a junction with other exits that is passed nearly straight on.
    fn straight_on(&self, from: u32, to: u32, taken: f64, others: &[Exit]) -> Option<Maneuver> {
        let before = reaching(self.network(), from);
        // An exit with another name is no rival of a road that keeps its name.
        let is_obvious =
            |exit: &Exit| self.keeps_name(from, to) && self.name(exit.directed) != self.name(to);
        let angle = |exit: &Exit| turn(before, exit.bearing);
        let rival = others
            .iter()
            .find(|exit| angle(exit).abs() < STRAIGHT_DEG && !is_obvious(exit));
        let Some(rival) = rival else {
            return self.new_name(from, to, taken);
        };
        // Both are nearly straight: keep to the side of the one that is taken.
        let side = if taken > angle(rival) { 1.0 } else { -1.0 };
        // `modifier` calls turns below `LEAST_FORK_DEG` straight, which would not tell the two
        // apart.
        let is_clear = taken * side >= LEAST_FORK_DEG;
        let turn = if is_clear {
            taken
        } else {
            LEAST_FORK_DEG * side
        };
        Some(Maneuver {
            kind: Kind::Fork,
            turn,
        })
    }

    /// Says that the road changes its name, if it has a new one.
    fn new_name(&self, from: u32, to: u32, taken: f64) -> Option<Maneuver> {
        let name = self.name(to);
        let is_new = name != self.name(from) && name != 0;
        is_new.then_some(Maneuver {
            kind: Kind::NewName,
            turn: taken,
        })
    }

    /// Whether both edges have the same name, and not none.
    fn keeps_name(&self, from: u32, to: u32) -> bool {
        self.name(to) == self.name(from) && self.name(to) != 0
    }
}

/// Whether a road ends crosswise in another: the turn that is taken is one of its two directions,
/// and the only other exit is the opposite one.
fn is_end_of_road(taken: f64, others: &[f64]) -> bool {
    let is_across = |angle: f64| ACROSS_DEG.contains(&angle.abs());
    let is_opposite = |angle: &f64| is_across(*angle) && angle * taken < 0.0;
    is_across(taken) && others.len() == 1 && others.iter().all(is_opposite)
}

fn arrival(leg: &Leg, line: &Line) -> Step {
    let count = leg.edges.len();
    // The direction into the goal, seen backwards from it.
    let last = line.part(count.saturating_sub(1)..count);
    let before = (along(last.iter().rev().copied()) + 180.0) % 360.0;
    Step {
        kind: Kind::Arrive,
        modifier: None,
        exit: None,
        bearings: [if last.len() > 1 { before } else { 0.0 }, 0.0],
        edges: count..count,
        measures: Measures::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_a_turn_has_a_term() {
        for (turn, expected) in [
            (0.0, "straight"),
            (-19.0, "straight"),
            (20.0, "slight right"),
            (-60.0, "left"),
            (130.0, "sharp right"),
            (180.0, "uturn"),
        ] {
            assert_eq!(modifier(turn), expected, "{turn}");
        }
    }

    #[test]
    fn a_road_ends_where_only_the_opposite_turn_is_left() {
        assert!(is_end_of_road(90.0, &[-90.0]));
        assert!(!is_end_of_road(90.0, &[0.0]));
        assert!(!is_end_of_road(90.0, &[-90.0, 10.0]));
        assert!(!is_end_of_road(150.0, &[-90.0]));
    }
}
