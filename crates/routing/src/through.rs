//! The route through several places, one after another.

use crate::leg::{Leg, Memory};
use crate::metric::Metric;
use crate::position::Position;
use crate::roads::Roads;

/// The most edges through a place for its directions to be distinguished. Only maps that are made
/// to be slow have more.
const MOST_POSITIONS: usize = 32;

/// A route to one of the places.
#[derive(Debug, Clone)]
struct Arrival {
    /// The directed edge on which it arrives.
    directed: u32,
    weight: u64,
    last_leg: LastLeg,
}

/// The end of a route.
#[derive(Debug, Clone)]
enum LastLeg {
    /// The route begins here.
    None,
    /// Its last leg, and the index of the arrival at the place before that it continues.
    Some(Leg, usize),
}

/// The lightest legs from place to place, each at one of the place's positions; `None` if there is
/// no route. If the route goes `straight` on at the places in between, it makes no U-turns there
/// unless there is no other way.
pub fn through(
    roads: &Roads,
    metric: &Metric,
    places: &[Vec<Position>],
    straight: bool,
    memory: &mut Memory,
) -> Option<Vec<Leg>> {
    if !straight || places.len() < 3 || places.iter().any(|place| place.len() > MOST_POSITIONS) {
        // Without the rule about U-turns the legs do not depend on each other.
        let pairs = places.windows(2);
        return pairs
            .map(|pair| Leg::find(roads, metric, &pair[0], &pair[1], memory))
            .collect();
    }
    let mut search = Search {
        roads,
        metric,
        memory,
    };
    // For each place the lightest route to it by each directed edge there.
    let mut arrivals = vec![vec![Arrival::begin()]];
    for pair in places.windows(2) {
        let next = search.arrive(&pair[0], &pair[1], arrivals.last()?);
        if next.is_empty() {
            return None;
        }
        arrivals.push(next);
    }
    legs_of_lightest(arrivals)
}

/// The legs of the lightest route to the last place.
fn legs_of_lightest(arrivals: Vec<Vec<Arrival>>) -> Option<Vec<Leg>> {
    let last = arrivals.last()?;
    // Backwards from the lightest arrival at the last place, along what each continued.
    let mut at = (0..last.len()).min_by_key(|i| last[*i].weight)?;
    let mut legs = Vec::with_capacity(arrivals.len());
    for mut there in arrivals.into_iter().rev() {
        let LastLeg::Some(leg, before) = there.swap_remove(at).last_leg else {
            break;
        };
        legs.push(leg);
        at = before;
    }
    legs.reverse();
    Some(legs)
}

impl Arrival {
    /// Where a route begins, by no edge.
    fn begin() -> Self {
        Self {
            directed: u32::MAX,
            weight: 0,
            last_leg: LastLeg::None,
        }
    }

    fn is_begin(&self) -> bool {
        matches!(self.last_leg, LastLeg::None)
    }
}

/// What finding legs needs.
struct Search<'a> {
    roads: &'a Roads,
    metric: &'a Metric,
    memory: &'a mut Memory,
}

impl Search<'_> {
    /// The lightest routes on to the next place, by each directed edge there.
    fn arrive(&mut self, from: &[Position], to: &[Position], before: &[Arrival]) -> Vec<Arrival> {
        // A place at the beginning of an edge is reached by another edge, unless there is none.
        let travelled = self.arrivals(from, to, before, |at, directed| {
            at.share_before(directed) > 0.0
        });
        if travelled.is_empty() {
            self.arrivals(from, to, before, |_, _| true)
        } else {
            travelled
        }
    }

    /// The lightest routes on by each directed edge on which it is good to arrive.
    fn arrivals(
        &mut self,
        from: &[Position],
        to: &[Position],
        before: &[Arrival],
        is_good: impl Fn(&Position, u32) -> bool,
    ) -> Vec<Arrival> {
        let mut found = Vec::new();
        for directed in to.iter().flat_map(|at| [2 * at.edge, 2 * at.edge + 1]) {
            let goal = restricted(to, |at, side| side == directed && is_good(at, side));
            if goal.is_empty() {
                continue;
            }
            let routes = before
                .iter()
                .enumerate()
                .filter_map(|(i, arrival)| self.extended(from, &goal, i, arrival));
            // How a route goes on depends on the edge of its arrival alone, so the lightest for
            // each edge suffices.
            found.extend(routes.min_by_key(|arrival| arrival.weight));
        }
        found
    }

    /// A route continued to the next place, without a U-turn if possible.
    fn extended(
        &mut self,
        from: &[Position],
        goal: &[Position],
        index: usize,
        before: &Arrival,
    ) -> Option<Arrival> {
        let leg = if before.is_begin() {
            self.leg(from, goal)?
        } else {
            // Not back, and not to the end of a road where the route already is, and then back.
            let onwards = restricted(from, |at, directed| {
                directed != before.directed ^ 1 && at.share_before(directed) < 1.0
            });
            // In a dead end there is only the U-turn.
            self.leg(&onwards, goal).or_else(|| self.leg(from, goal))?
        };
        let directed = *leg.edges.last()?;
        let weight = before.weight + u64::from(leg.weight);
        Some(Arrival {
            directed,
            weight,
            last_leg: LastLeg::Some(leg, index),
        })
    }

    fn leg(&mut self, from: &[Position], to: &[Position]) -> Option<Leg> {
        Leg::find(self.roads, self.metric, from, to, self.memory)
    }
}

/// The positions, open in those directions only that are good, without positions that are not.
fn restricted(positions: &[Position], is_good: impl Fn(&Position, u32) -> bool) -> Vec<Position> {
    let narrowed = positions.iter().map(|at| {
        let open = [0, 1].map(|side| at.open[side as usize] && is_good(at, 2 * at.edge + side));
        Position { open, ..*at }
    });
    narrowed.filter(|at| at.open != [false; 2]).collect()
}
