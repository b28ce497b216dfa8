//! The way through several places, one after another.

use crate::leg::{Leg, Memory};
use crate::metric::Metric;
use crate::position::Position;
use crate::roads::Roads;

/// Edges through a place at most for its directions to be told apart; only maps that are made to be slow have more.
const MOST: usize = 32;

/// A way to one of the places.
#[derive(Debug, Clone)]
struct Arrival {
    /// The directed edge that it arrives along.
    directed: u32,
    weight: u64,
    /// Its last leg, and which way to the place before it goes on.
    leg: Option<(Leg, usize)>,
}

/// The lightest legs from place to place, each somewhere on one of its positions; `None` if there is no way. If one goes `straight` on at the places in
/// between, one does not turn round there, unless there is no other way.
pub fn through(
    roads: &Roads,
    metric: &Metric,
    places: &[Vec<Position>],
    straight: bool,
    memory: &mut Memory,
) -> Option<Vec<Leg>> {
    if !straight || places.len() < 3 || places.iter().any(|place| place.len() > MOST) {
        return places
            .windows(2)
            .map(|pair| Leg::find(roads, metric, &pair[0], &pair[1], memory))
            .collect();
    }
    // For each place the lightest way to it by each directed edge there.
    let mut arrivals: Vec<Vec<Arrival>> = Vec::new();
    for pair in places.windows(2) {
        let before = arrivals.last();
        let next = arrive(
            roads,
            metric,
            [&pair[0], &pair[1]],
            before.map_or(&[], Vec::as_slice),
            memory,
        );
        if next.is_empty() {
            return None;
        }
        arrivals.push(next);
    }
    let mut legs = Vec::with_capacity(arrivals.len());
    let last = arrivals.last()?;
    let mut at = (0..last.len()).min_by_key(|i| last[*i].weight)?;
    for mut there in arrivals.into_iter().rev() {
        let (leg, before) = there.swap_remove(at).leg?;
        legs.push(leg);
        at = before;
    }
    legs.reverse();
    Some(legs)
}

/// The lightest ways on to the next place, by each directed edge there. Without ways `before` the first place is where it begins.
fn arrive(
    roads: &Roads,
    metric: &Metric,
    [from, to]: [&[Position]; 2],
    before: &[Arrival],
    memory: &mut Memory,
) -> Vec<Arrival> {
    let begin = [Arrival {
        directed: u32::MAX,
        weight: 0,
        leg: None,
    }];
    let before = if before.is_empty() {
        &begin[..]
    } else {
        before
    };
    // One is at the beginning of an edge by another one, unless there is none.
    let travelled = arrivals(
        roads,
        metric,
        [from, to],
        before,
        |at, d| at.share_before(d) > 0.0,
        memory,
    );
    if travelled.is_empty() {
        arrivals(roads, metric, [from, to], before, |_, _| true, memory)
    } else {
        travelled
    }
}

/// The lightest ways on by each directed edge that is good to arrive by.
fn arrivals(
    roads: &Roads,
    metric: &Metric,
    [from, to]: [&[Position]; 2],
    before: &[Arrival],
    good: impl Fn(&Position, u32) -> bool,
    memory: &mut Memory,
) -> Vec<Arrival> {
    let mut found = Vec::new();
    for directed in to
        .iter()
        .flat_map(|position| [2 * position.edge, 2 * position.edge + 1])
    {
        let goal = only(to, |at, d| d == directed && good(at, d));
        if goal.is_empty() {
            continue;
        }
        let ways = before.iter().enumerate().filter_map(|(i, arrival)| {
            // Not back, nor to the end of a road where one is already, and then back.
            let onwards = only(from, |at, d| {
                d != arrival.directed ^ 1 && at.share_before(d) < 1.0
            });
            let onwards = if arrival.leg.is_some() {
                onwards
            } else {
                from.to_vec()
            };
            // In a dead end one turns round.
            let leg = Leg::find(roads, metric, &onwards, &goal, memory)
                .or_else(|| Leg::find(roads, metric, from, &goal, memory))?;
            let directed = leg.edges.last().copied().unwrap_or(directed);
            Some(Arrival {
                directed,
                weight: arrival.weight + u64::from(leg.weight),
                leg: Some((leg, i)),
            })
        });
        found.extend(ways.min_by_key(|arrival| arrival.weight));
    }
    found
}

/// Positions where one may go along some directed edges only.
fn only(positions: &[Position], good: impl Fn(&Position, u32) -> bool) -> Vec<Position> {
    let narrowed = positions.iter().map(|position| {
        let open = [0, 1]
            .map(|side| position.open[side as usize] && good(position, 2 * position.edge + side));
        Position { open, ..*position }
    });
    narrowed
        .filter(|position| position.open != [false; 2])
        .collect()
}
