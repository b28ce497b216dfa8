//! The graph that is searched where turns matter: its states are directed edges, its arcs are turns
//! from one edge into another.

use crate::bearings::{leaving, reaching};
use crate::costs::{Costs, EdgeCost, sum, units};
use crate::geo::turn;
use crate::network::Network;
use crate::overlay::{Arc, Arcs, FAR, NONE, Overlay};
use crate::profile::{CROSSING, Profile, Turns};
use crate::restrictions::Restrictions;
use crate::roads::Roads;

/// The most turns for each edge, on average over a map. A map with more is made to be slow: where
/// four roads meet there are four.
const MOST_TURNS_PER_EDGE: usize = 32;

/// The most roads at one junction, together with all prefixes of restrictions that end on them.
const MOST_ROADS: usize = 512;

/// A map with junctions of so many roads that their turns cannot be enumerated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "this map has {turns} turns from road to road, more than can be enumerated; {roads} roads meet \
     at node {node}: is it a map of roads? (a profile without `[turns]` can use it)"
)]
pub struct TooManyTurns {
    /// How many.
    pub turns: usize,
    /// The OSM node where most roads meet.
    pub node: i64,
    /// How many roads meet there.
    pub roads: usize,
}

/// Layers over directed edges. A directed edge is in the cell of the vertex at which it begins.
#[derive(Debug, Clone, Default)]
pub struct TurnGraph {
    /// The layers.
    pub(crate) overlay: Overlay,
    /// For each directed edge its state. The states that follow are on the same edge, behind the
    /// prefixes of restrictions that end with it.
    pub(crate) state_of: Vec<u32>,
    /// For each state its directed edge.
    pub edge_of: Vec<u32>,
    /// Restrictions that are ignored: their ways do not meet, or consist of too many edges.
    pub odd_restrictions: usize,
}

impl TurnGraph {
    /// All turns of a network that no restriction forbids to a profile. `edges` are the profile's
    /// costs.
    ///
    /// # Errors
    /// If the junctions of the map have too many roads.
    pub(crate) fn new(
        roads: &Roads,
        profile: &Profile,
        edges: &[EdgeCost],
    ) -> Result<Self, TooManyTurns> {
        let network = &roads.network;
        let is_open = |directed: u32| edges[directed as usize].is_open();
        let restrictions = Restrictions::new(network, profile, &is_open);
        let states = States::new(network, &restrictions);
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
    pub(crate) fn states_of(&self, directed: u32) -> impl Iterator<Item = u32> {
        let first = self.state_of[directed as usize];
        (first..).take_while(move |state| self.edge_of.get(*state as usize) == Some(&directed))
    }

    /// The weight of continuing from a state to another: the turn, the vertex between them, and the
    /// edge after the turn.
    pub(crate) fn weight(&self, roads: &Roads, costs: &Costs<'_>, state: u32, next: u32) -> u32 {
        let [from, to] = [state, next].map(|state| self.edge_of[state as usize]);
        let (a, b) = (costs.edges[from as usize], costs.edges[to as usize]);
        if !a.is_open() || !b.is_open() {
            return FAR;
        }
        let turned = sum(b.weight(), self.penalty(roads, costs, from, to));
        if to == from ^ 1 {
            // U-turns are made only where there is no other way, for example at a barrier.
            return if self.is_dead_end(roads, costs, state) {
                turned
            } else {
                FAR
            };
        }
        let passed = costs.vertices[roads.network.ends(from)[1] as usize].weight();
        let entry = if b.ends_only() && !a.ends_only() {
            costs.entry
        } else {
            0
        };
        sum(sum(turned, passed), entry)
    }

    /// The time that turning from one directed edge into the next takes, hundredths of a second.
    pub(crate) fn penalty(&self, roads: &Roads, costs: &Costs<'_>, from: u32, to: u32) -> u32 {
        let Some(turns) = costs.profile.turns() else {
            return 0;
        };
        if to == from ^ 1 {
            return units(turns.u_turn);
        }
        let network = &roads.network;
        // Where only two roads meet a bend is no turn. OSRM charges turns where more than two meet.
        if !costs.vertices[network.ends(from)[1] as usize].is_junction() {
            return 0;
        }
        units(turns.seconds(turn(reaching(network, from), leaving(network, to))))
    }

    /// Whether a state cannot continue but by a U-turn.
    fn is_dead_end(&self, roads: &Roads, costs: &Costs<'_>, state: u32) -> bool {
        let directed = self.edge_of[state as usize];
        let out = &self.overlay.out;
        let mut others = out.of(state).map(|slot| out.via[slot]);
        costs.vertices[roads.network.ends(directed)[1] as usize].weight() >= FAR
            || others.all(|to| to == directed ^ 1 || !costs.edges[to as usize].is_open())
    }
}

/// States while their arcs are made.
struct States<'a> {
    network: &'a Network,
    restrictions: &'a Restrictions,
    state_of: Vec<u32>,
    edge_of: Vec<u32>,
    /// For each state the number of its prefix, [`NONE`] if it is its edge alone.
    prefix_of: Vec<u32>,
}

impl<'a> States<'a> {
    /// For each directed edge one state, and one for each prefix that ends with it.
    fn new(network: &'a Network, restrictions: &'a Restrictions) -> Self {
        let mut order: Vec<u32> = (0..2 * network.edge_count() as u32).collect();
        // Vertices are in the order of their cells. States in the order of the vertices where they
        // begin make each cell a range of states.
        order.sort_by_key(|directed| network.ends(*directed)[0]);
        let mut state_of = vec![NONE; order.len()];
        let (mut edge_of, mut prefix_of) = (Vec::new(), Vec::new());
        for directed in order {
            state_of[directed as usize] = edge_of.len() as u32;
            let prefixes = restrictions.ending(directed);
            edge_of.extend(std::iter::repeat_n(directed, 1 + prefixes.len()));
            prefix_of.push(NONE);
            prefix_of.extend(prefixes);
        }
        Self {
            network,
            restrictions,
            state_of,
            edge_of,
            prefix_of,
        }
    }

    /// The first state that begins at a vertex, or behind it.
    fn first(&self, vertex: u32) -> u32 {
        let begins_before = |directed: &u32| self.network.ends(*directed)[0] < vertex;
        self.edge_of.partition_point(begins_before) as u32
    }

    /// Where cells begin, as states.
    fn levels(&self, levels: &[Vec<u32>]) -> Vec<Vec<u32>> {
        let in_states = levels.iter().map(|starts| {
            let mut starts: Vec<u32> = starts.iter().map(|vertex| self.first(*vertex)).collect();
            // Cells without edges have no states.
            starts.dedup();
            starts
        });
        in_states.take_while(|starts| starts.len() > 1).collect()
    }

    /// The vertex at the end of a state's edge.
    fn end(&self, state: u32) -> usize {
        self.network.ends(self.edge_of[state as usize])[1] as usize
    }

    /// From each state to all states in which a traveller may continue.
    fn arcs(&self) -> Result<Arcs, TooManyTurns> {
        let vertices = self.network.vertices.len() as u32;
        let firsts: Vec<u32> = (0..=vertices).map(|vertex| self.first(vertex)).collect();
        // Before any turn is listed: their number may be the square of the roads at a junction.
        self.check_turns(&firsts)?;
        let is_road = self.roads();
        let is_road = |directed: u32| is_road[directed as usize / 2];
        let states = self.edge_of.len();
        let open = (0..states as u32).filter(|state| is_road(self.edge_of[*state as usize]));
        let arcs = open.flat_map(|state| {
            // Restrictions look at the edges of the state's prefix, or at its one edge.
            let travelled = self.travelled(state);
            let vertex = self.end(state);
            let leaving = firsts[vertex]..firsts[vertex + 1];
            // Each edge once. Which of its states follows depends on what was travelled, see
            // `next`.
            let alone = leaving.filter(|next| self.prefix_of[*next as usize] == NONE);
            let edges = alone
                .map(|next| self.edge_of[next as usize])
                .filter(|to| is_road(*to));
            let allowed = edges.filter(move |to| !self.restrictions.forbid(travelled, *to));
            allowed.map(move |to| Arc {
                from: state,
                to: self.next(travelled, to),
                via: to,
            })
        });
        Ok(Arcs::new(states, arcs))
    }

    /// Refuses maps with too many turns. `firsts` are the first states of all vertices.
    fn check_turns(&self, firsts: &[u32]) -> Result<(), TooManyTurns> {
        let roads = |vertex: usize| (firsts[vertex + 1] - firsts[vertex]) as usize;
        let states = self.edge_of.len();
        let turns: usize = (0..states as u32).map(|state| roads(self.end(state))).sum();
        let vertices = 0..self.network.vertices.len();
        let worst = vertices
            .max_by_key(|vertex| roads(*vertex))
            .unwrap_or_default();
        if turns > MOST_TURNS_PER_EDGE * states || (states > 0 && roads(worst) > MOST_ROADS) {
            let node = self.network.vertex_nodes[worst];
            return Err(TooManyTurns {
                turns,
                node,
                roads: roads(worst),
            });
        }
        Ok(())
    }

    /// For each edge whether it is a road. No vehicle crosses squares.
    fn roads(&self) -> Vec<bool> {
        let sets = &self.network.way_tags;
        let is_crossing: Vec<bool> = sets.iter().map(|tags| tags.has(CROSSING)).collect();
        let edges = self.network.edges().iter();
        edges
            .map(|edge| !is_crossing[edge.class as usize])
            .collect()
    }

    /// The directed edges that a traveller in a state has travelled last.
    fn travelled(&self, state: u32) -> &[u32] {
        match self.prefix_of[state as usize] {
            NONE => std::slice::from_ref(&self.edge_of[state as usize]),
            prefix => self.restrictions.prefix(prefix),
        }
    }

    /// The state of a traveller who continues along a directed edge.
    fn next(&self, travelled: &[u32], to: u32) -> u32 {
        let alone = self.state_of[to as usize];
        let prefix = self.restrictions.next(travelled, to);
        let prefixes = self.restrictions.ending(to);
        match prefixes.iter().position(|number| *number == prefix) {
            None => alone,
            // States with a prefix follow that of the edge alone, in the order of `ending`.
            Some(place) => alone + 1 + place as u32,
        }
    }
}

impl Turns {
    /// Seconds that a turn by an angle in degrees takes, positive to the right.
    pub(crate) fn seconds(&self, degrees: f64) -> f64 {
        let to_near_side = (degrees >= 0.0) == self.right_hand;
        let bias = if to_near_side {
            self.bias
        } else {
            1.0 / self.bias
        };
        // The formula is in the documentation of `Turns`.
        let steepness = 13.0 / bias * degrees.abs() / 180.0 - 6.5 * bias;
        self.sharpest / (1.0 + libm::exp(-steepness))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seconds of OSRM's car profile: straight on is nearly free, left turns cost more than right
    /// turns.
    #[test]
    fn turns_across_the_road_cost_more() {
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
