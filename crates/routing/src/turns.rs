//! Where turns matter, searches settle directed edges instead of vertices, and arcs are turns from one into another.

use crate::geo::turn;
use crate::guidance::Guide;
use crate::metric::{EdgeCost, Metric, sum, units};
use crate::network::Network;
use crate::overlay::{Arcs, FAR, NONE, Overlay};
use crate::profile::{CROSSING, Profile, Turns};
use crate::restrictions::Restrictions;
use crate::roads::Roads;

/// Turns for each edge, on average over a map, beyond which its junctions are thought to be made to be slow: where four roads meet there are four.
const MOST_TURNS: usize = 32;

/// Roads of one junction, with all rows of restrictions that end on them.
const MOST_ROADS: usize = 512;

/// A map with junctions of so many roads that their turns cannot be looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "this map has {turns} turns from road to road, more than can be looked at; {roads} roads meet at node {node}: \
     is it a map of roads? (a profile without `[turns]` can do with it)"
)]
pub struct TooManyTurns {
    /// How many.
    pub turns: usize,
    /// The OSM node where most roads meet,
    pub node: i64,
    /// and how many these are.
    pub roads: usize,
}

/// Layers over directed edges. A directed edge is in the cell of the vertex at which it begins.
#[derive(Debug, Clone, Default)]
pub struct TurnGraph {
    /// The layers.
    pub overlay: Overlay,
    /// For each directed edge its state. Those on it behind a row of others, which a restriction begins with, follow.
    pub state_of: Vec<u32>,
    /// For each state its directed edge.
    pub edge_of: Vec<u32>,
    /// Restrictions that are not regarded: their ways do not meet, or make up too many edges.
    pub odd_restrictions: usize,
}

impl TurnGraph {
    /// All turns of a network that a profile, to which its directed edges cost so much, is not kept from.
    pub fn new(roads: &Roads, profile: &Profile, edges: &[EdgeCost]) -> Result<Self, TooManyTurns> {
        let network = &roads.network;
        let is_open = |directed: u32| edges[directed as usize].is_open();
        let restrictions = Restrictions::new(network, profile, &is_open);
        let mut order: Vec<u32> = (0..2 * network.edge_count() as u32).collect();
        order.sort_by_key(|directed| network.ends(*directed)[0]);
        let (mut state_of, mut edge_of, mut row_of) =
            (vec![NONE; order.len()], Vec::new(), Vec::new());
        for directed in order {
            state_of[directed as usize] = edge_of.len() as u32;
            let rows = restrictions.ending(directed);
            edge_of.extend(std::iter::repeat_n(directed, 1 + rows.len()));
            row_of.extend([NONE].iter().chain(rows));
        }
        let states = States {
            network,
            restrictions: &restrictions,
            state_of,
            edge_of,
            row_of,
        };
        let arcs = states.arcs()?;
        let overlay = Overlay::new(arcs, &states.levels(&roads.levels));
        let States {
            state_of, edge_of, ..
        } = states;
        Ok(Self {
            overlay,
            state_of,
            edge_of,
            odd_restrictions: restrictions.odd,
        })
    }

    /// The states on a directed edge.
    pub fn states_of(&self, directed: u32) -> impl Iterator<Item = u32> {
        let first = self.state_of[directed as usize];
        (first..).take_while(move |state| self.edge_of.get(*state as usize) == Some(&directed))
    }

    /// What going on from a state to another counts as: the turn, the vertex between, and the edge that one turns into.
    pub fn weight(&self, roads: &Roads, metric: &Metric, state: u32, next: u32) -> u32 {
        let [from, to] = [state, next].map(|state| self.edge_of[state as usize]);
        let (a, b) = (metric.edges[from as usize], metric.edges[to as usize]);
        if !a.is_open() || !b.is_open() {
            return FAR;
        }
        let turned = sum(b.weight(), self.penalty(roads, metric, from, to));
        if to == from ^ 1 {
            // One turns round where there is no other way only, be it for a barrier.
            return if self.is_dead_end(roads, metric, state) {
                turned
            } else {
                FAR
            };
        }
        let passed = metric.vertices[roads.network.ends(from)[1] as usize].weight();
        let entry = if b.ends_only() && !a.ends_only() {
            metric.entry
        } else {
            0
        };
        sum(sum(turned, passed), entry)
    }

    /// Hundredths of a second that turning from one directed edge into the next takes.
    pub fn penalty(&self, roads: &Roads, metric: &Metric, from: u32, to: u32) -> u32 {
        let Some(turns) = metric.profile.turns() else {
            return 0;
        };
        if to == from ^ 1 {
            return units(turns.u_turn);
        }
        if !metric.vertices[roads.network.ends(from)[1] as usize].is_junction() {
            return 0;
        }
        let guide = Guide { roads, metric };
        units(turns.seconds(turn(guide.reaching(from), guide.leaving(to))))
    }

    fn is_dead_end(&self, roads: &Roads, metric: &Metric, state: u32) -> bool {
        let directed = self.edge_of[state as usize];
        let mut others = self
            .overlay
            .out
            .of(state)
            .map(|slot| self.overlay.out.via[slot]);
        metric.vertices[roads.network.ends(directed)[1] as usize].weight() >= FAR
            || others.all(|to| to == directed ^ 1 || !metric.edges[to as usize].is_open())
    }
}

/// States while their arcs are made.
struct States<'a> {
    network: &'a Network,
    restrictions: &'a Restrictions,
    state_of: Vec<u32>,
    edge_of: Vec<u32>,
    /// For each state the number of its row, [`NONE`] if it is its edge alone.
    row_of: Vec<u32>,
}

impl States<'_> {
    /// The first state that begins at a vertex, or behind it.
    fn first(&self, vertex: u32) -> u32 {
        self.edge_of
            .partition_point(|directed| self.network.ends(*directed)[0] < vertex) as u32
    }

    /// Where cells begin, as states.
    fn levels(&self, levels: &[Vec<u32>]) -> Vec<Vec<u32>> {
        // Cells without edges have no states.
        let in_states = |starts: &Vec<u32>| {
            let mut starts: Vec<u32> = starts.iter().map(|vertex| self.first(*vertex)).collect();
            starts.dedup();
            starts
        };
        levels
            .iter()
            .map(in_states)
            .take_while(|starts| starts.len() > 1)
            .collect()
    }

    /// From each state to all that one may go on to.
    fn arcs(&self) -> Result<Arcs, TooManyTurns> {
        let network = self.network;
        let firsts: Vec<u32> = (0..=network.vertices.len() as u32)
            .map(|vertex| self.first(vertex))
            .collect();
        let end = |state: u32| network.ends(self.edge_of[state as usize])[1] as usize;
        let leaving = |vertex: usize| firsts[vertex]..firsts[vertex + 1];
        let states = self.edge_of.len();
        let turns: usize = (0..states as u32)
            .map(|state| leaving(end(state)).len())
            .sum();
        let roads = |vertex: &usize| leaving(*vertex).len();
        let worst = (0..network.vertices.len())
            .max_by_key(roads)
            .unwrap_or_default();
        if turns > MOST_TURNS * states || (states > 0 && roads(&worst) > MOST_ROADS) {
            return Err(TooManyTurns {
                turns,
                node: network.vertex_nodes[worst],
                roads: roads(&worst),
            });
        }
        let crossing: Vec<bool> = network
            .way_words
            .iter()
            .map(|words| words.has(CROSSING))
            .collect();
        // No vehicle crosses squares.
        let is_road =
            |directed: u32| !crossing[network.edges[directed as usize / 2].class as usize];
        let (is_road, leaving) = (&is_road, &leaving);
        let arcs = (0..states as u32)
            .filter(|state| is_road(self.edge_of[*state as usize]))
            .flat_map(|state| {
                let travelled = match self.row_of[state as usize] {
                    NONE => std::slice::from_ref(&self.edge_of[state as usize]),
                    row => self.restrictions.row(row),
                };
                let edges = leaving(end(state)).filter(|to| self.row_of[*to as usize] == NONE);
                let edges = edges
                    .map(|to| self.edge_of[to as usize])
                    .filter(|to| is_road(*to));
                let allowed = edges.filter(move |to| !self.restrictions.forbid(travelled, *to));
                allowed.map(move |to| (state, self.next(travelled, to), to))
            });
        Ok(Arcs::new(states, arcs))
    }

    /// The state that one is in who goes on along a directed edge.
    fn next(&self, travelled: &[u32], to: u32) -> u32 {
        let alone = self.state_of[to as usize];
        match self.restrictions.next(travelled, to) {
            NONE => alone,
            row => {
                let place = self
                    .restrictions
                    .ending(to)
                    .iter()
                    .position(|number| *number == row);
                place.map_or(alone, |place| alone + 1 + place as u32)
            }
        }
    }
}

impl Turns {
    /// Seconds that a turn by so many degrees takes, to the right above 0.
    pub fn seconds(&self, degrees: f64) -> f64 {
        let to_near_side = (degrees >= 0.0) == self.right_hand;
        let bias = if to_near_side {
            self.bias
        } else {
            1.0 / self.bias
        };
        let steepness = 13.0 / bias * degrees.abs() / 180.0 - 6.5 * bias;
        self.sharpest / (1.0 + libm::exp(-steepness))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seconds of OSRM's car profile: going straight is next to free, turning left is dearer than turning right.
    #[test]
    fn turns_across_the_road_are_dearer() {
        let car = Profile::named("car").unwrap();
        let seconds = |degrees| car.turns().unwrap().seconds(degrees);
        assert!(seconds(0.0) < 0.02 && seconds(180.0) > 7.3);
        assert!(
            seconds(90.0) < seconds(-90.0),
            "{} {}",
            seconds(90.0),
            seconds(-90.0)
        );
        let right = 7.5 / (1.0 + libm::exp(-(13.0 / 1.075 * 90.0 / 180.0 - 6.5 * 1.075)));
        assert!((seconds(90.0) - right).abs() < 1e-9);
        let left = 7.5 / (1.0 + libm::exp(-(13.0 * 1.075 * 90.0 / 180.0 - 6.5 / 1.075)));
        assert!((seconds(-90.0) - left).abs() < 1e-9);
    }
}
