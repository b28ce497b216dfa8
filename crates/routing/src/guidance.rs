//! What to do on the way: where to turn, and onto which road.
//!
//! The words are those of OSRM's API (`StepManeuver`); when which of them is said follows its documentation, not its code.

use crate::geo::{Place, bearing, distance, turn};
use crate::leg::{Leg, Line, Measures};
use crate::metric::Metric;
use crate::roads::Roads;

/// How far from a vertex the direction of an edge is taken, metres.
const LOOK: f64 = 10.0;
/// Turns by less than so many degrees go on along the road.
const STRAIGHT: f64 = 40.0;

/// What to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Set out.
    Depart,
    /// Be there.
    Arrive,
    /// Turn into another road.
    Turn,
    /// Stay on the road although it turns.
    Continue,
    /// Go on, the road changes its name.
    NewName,
    /// Keep to one side where the road parts.
    Fork,
    /// Turn where the road ends in another.
    EndOfRoad,
    /// Drive round, and leave by an exit.
    Roundabout,
    /// Leave the roundabout.
    ExitRoundabout,
}

impl Kind {
    /// OSRM's word.
    pub const fn word(self) -> &'static str {
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

/// OSRM's word for a turn by so many degrees, to the right above 0.
pub fn modifier(turn: f64) -> &'static str {
    let right = turn > 0.0;
    match turn.abs() {
        size if size < 20.0 => "straight",
        size if size < 40.0 => {
            if right {
                "slight right"
            } else {
                "slight left"
            }
        }
        size if size < 120.0 => {
            if right {
                "right"
            } else {
                "left"
            }
        }
        size if size < 170.0 => {
            if right {
                "sharp right"
            } else {
                "sharp left"
            }
        }
        _ => "uturn",
    }
}

/// A stretch of the way that needs one thing to be done at its beginning.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// What is done.
    pub kind: Kind,
    /// How; `None` on arrival and departure.
    pub modifier: Option<&'static str>,
    /// Which exit of a roundabout is taken, from 1 on.
    pub exit: Option<usize>,
    /// Directions before and after, degrees clockwise from north; 0 where there is none.
    pub bearings: [f64; 2],
    /// The leg's edges that belong to it; none on arrival.
    pub edges: std::ops::Range<usize>,
    /// What they take.
    pub measures: Measures,
}

/// Where a directed edge that leaves a vertex leads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exit {
    /// The edge.
    pub directed: u32,
    /// Degrees clockwise from north.
    pub bearing: f64,
    /// Whether one may go there.
    pub open: bool,
}

/// Directions of edges in a network.
#[derive(Debug, Clone, Copy)]
pub struct Guide<'a> {
    /// The network.
    pub roads: &'a Roads,
    /// Who travels.
    pub metric: &'a Metric,
}

impl Guide<'_> {
    /// The direction in which a directed edge leaves its first vertex.
    pub fn leaving(&self, directed: u32) -> f64 {
        let points = self.roads.network.edge_points(directed / 2);
        if directed.is_multiple_of(2) {
            look(points.iter())
        } else {
            look(points.iter().rev())
        }
    }

    /// The direction in which a directed edge reaches its last vertex.
    pub fn reaching(&self, directed: u32) -> f64 {
        (self.leaving(directed ^ 1) + 180.0) % 360.0
    }

    /// All ways out of a vertex.
    pub fn exits(&self, vertex: u32) -> impl Iterator<Item = Exit> + '_ {
        let out = &self.roads.vertices.out;
        out.of(vertex).map(move |slot| self.exit(out.via[slot]))
    }

    /// A directed edge as a way out of the vertex that it leaves.
    pub fn exit(&self, directed: u32) -> Exit {
        let open = self.metric.edges[directed as usize].is_open();
        Exit {
            directed,
            bearing: self.leaving(directed),
            open,
        }
    }

    fn name(&self, directed: u32) -> u32 {
        self.roads.network.edges[directed as usize / 2].name
    }

    fn is_roundabout(&self, directed: u32) -> bool {
        let network = &self.roads.network;
        let is = |kind| {
            network
                .way_words
                .is(network.edges[directed as usize / 2].class, "junction", kind)
        };
        self.metric.profile.turns().is_some() && (is("roundabout") || is("circular"))
    }

    /// The steps of a leg.
    pub fn steps(&self, leg: &Leg, line: &Line) -> Vec<Step> {
        let mut begun: Vec<(usize, Kind, Option<f64>)> = vec![(0, Kind::Depart, None)];
        for i in 1..leg.edges.len() {
            if let Some((kind, turn)) = self.decision(leg.edges[i - 1], leg.edges[i]) {
                begun.push((i, kind, Some(turn)));
            }
        }
        let ends = begun
            .iter()
            .skip(1)
            .map(|(i, ..)| *i)
            .chain([leg.edges.len()]);
        let mut steps: Vec<Step> = begun
            .iter()
            .zip(ends)
            .map(|((first, kind, turn), end)| {
                let edges = *first..end;
                let before = first
                    .checked_sub(1)
                    .map_or(0.0, |i| self.reaching(leg.edges[i]));
                // The directions by which turns were told, which are also those of the junction's roads.
                let after = match first {
                    0 => look(line.part(edges.clone()).iter().copied()),
                    _ => self.leaving(leg.edges[*first]),
                };
                Step {
                    kind: *kind,
                    modifier: turn.map(modifier),
                    exit: (*kind == Kind::Roundabout)
                        .then(|| self.exits_passed(leg, edges.clone()))
                        .filter(|exits| *exits > 0),
                    bearings: [before, after],
                    measures: self.measures(leg, edges.clone()),
                    edges,
                }
            })
            .collect();
        let last = line.part(leg.edges.len().saturating_sub(1)..leg.edges.len());
        let before = (look(last.iter().rev().copied()) + 180.0) % 360.0;
        let edges = leg.edges.len()..leg.edges.len();
        let bearings = [if last.len() > 1 { before } else { 0.0 }, 0.0];
        let measures = Measures::default();
        steps.push(Step {
            kind: Kind::Arrive,
            modifier: None,
            exit: None,
            bearings,
            edges,
            measures,
        });
        steps
    }

    fn measures(&self, leg: &Leg, edges: std::ops::Range<usize>) -> Measures {
        let all = edges.map(|i| leg.measures(self.roads, self.metric, i));
        all.fold(Measures::default(), |sum, edge| Measures {
            length: sum.length + edge.length,
            duration: sum.duration + edge.duration,
            weight: sum.weight + edge.weight,
        })
    }

    /// How many ways out of a roundabout are passed, with the one that is taken.
    fn exits_passed(&self, leg: &Leg, edges: std::ops::Range<usize>) -> usize {
        // The leg's own end is passed by nobody.
        let passed = edges.filter(|i| i + 1 < leg.edges.len());
        let ends = passed.map(|i| self.roads.network.ends(leg.edges[i])[1]);
        ends.filter(|vertex| {
            self.exits(*vertex)
                .any(|exit| exit.open && !self.is_roundabout(exit.directed))
        })
        .count()
    }

    /// What is to be said where one directed edge follows another, and by how much one turns.
    fn decision(&self, from: u32, to: u32) -> Option<(Kind, f64)> {
        let reaching = self.reaching(from);
        let angle = |exit: &Exit| turn(reaching, exit.bearing);
        if to == from ^ 1 {
            return Some((Kind::Continue, 180.0));
        }
        let vertex = self.roads.network.ends(from)[1];
        let mut taken = turn(reaching, self.leaving(to));
        match (self.is_roundabout(from), self.is_roundabout(to)) {
            (false, true) => return Some((Kind::Roundabout, taken)),
            (true, false) => return Some((Kind::ExitRoundabout, taken)),
            (true, true) => return None,
            (false, false) => {}
        }
        let others: Vec<Exit> = self
            .exits(vertex)
            .filter(|exit| exit.open && exit.directed != to && exit.directed != from ^ 1)
            .collect();
        let (name, before) = (self.name(to), self.name(from));
        let renamed = (name != before).then_some((Kind::NewName, taken));
        if others.is_empty() {
            return renamed.filter(|_| name != 0);
        }
        let straight = |exit: &&Exit| angle(exit).abs() < STRAIGHT;
        if taken.abs() < STRAIGHT {
            let obvious =
                |exit: &Exit| name == before && name != 0 && self.name(exit.directed) != name;
            let Some(other) = others.iter().find(|exit| straight(exit) && !obvious(exit)) else {
                return renamed.filter(|_| name != 0);
            };
            // Both go on: one keeps to a side, however little it is.
            let side = if taken > angle(other) { 1.0 } else { -1.0 };
            if taken * side < 20.0 {
                taken = 20.0 * side;
            }
            return Some((Kind::Fork, taken));
        }
        let across = |angle: f64| (50.0..=130.0).contains(&angle.abs());
        let ends = |exit: &Exit| across(angle(exit)) && angle(exit) * taken < 0.0;
        let kind = if across(taken) && others.len() == 1 && others.iter().all(ends) {
            Kind::EndOfRoad
        } else if name == before && name != 0 {
            Kind::Continue
        } else {
            Kind::Turn
        };
        Some((kind, taken))
    }
}

/// The direction from the first point to one some metres on.
fn look(points: impl Iterator<Item = Place>) -> f64 {
    let (mut first, mut last, mut length) = (None, None, 0.0);
    for point in points {
        let before = *last.get_or_insert(point);
        first.get_or_insert(point);
        length += distance(before, point);
        last = Some(point);
        if length >= LOOK {
            break;
        }
    }
    first
        .zip(last)
        .map_or(0.0, |(first, last)| bearing(first, last))
}
