//! Where turns matter, searches settle directed edges instead of vertices, and arcs are turns from one into another.

use std::collections::HashSet;

use crate::geo::turn;
use crate::guidance::Guide;
use crate::metric::{Metric, sum, units};
use crate::overlay::{Arcs, FAR, NONE, Overlay};
use crate::profile::{CROSSING, Profile, Turns};
use crate::roads::Roads;

/// Layers over directed edges. A directed edge is in the cell of the vertex at which it begins.
#[derive(Debug, Clone, Default)]
pub struct TurnGraph {
    /// The layers.
    pub overlay: Overlay,
    /// For each directed edge its state.
    pub state_of: Vec<u32>,
    /// For each state its directed edge.
    pub edge_of: Vec<u32>,
    restricted: Restricted,
}

impl TurnGraph {
    /// All turns of a network, and those that a profile keeps from.
    pub fn new(roads: &Roads, profile: &Profile) -> Self {
        let network = &roads.network;
        let mut edge_of: Vec<u32> = (0..2 * network.edge_count() as u32).collect();
        edge_of.sort_by_key(|directed| network.ends(*directed)[0]);
        let mut state_of = vec![NONE; edge_of.len()];
        for (state, directed) in edge_of.iter().enumerate() {
            state_of[*directed as usize] = state as u32;
        }
        let first =
            |vertex: u32| edge_of.partition_point(|directed| network.ends(*directed)[0] < vertex) as u32;
        // Cells without edges have no states.
        let in_states = |starts: &Vec<u32>| {
            let mut starts: Vec<u32> = starts.iter().map(|vertex| first(*vertex)).collect();
            starts.dedup();
            starts
        };
        let levels: Vec<Vec<u32>> =
            roads.levels.iter().map(in_states).take_while(|starts| starts.len() > 1).collect();
        let firsts: Vec<u32> = (0..=network.vertices.len() as u32).map(first).collect();
        let crossing: Vec<bool> = network.way_words.iter().map(|words| words.has(CROSSING)).collect();
        let is_crossing = |directed: u32| crossing[network.edges[directed as usize / 2].class as usize];
        let is_crossing = &is_crossing;
        let arcs = (0..edge_of.len() as u32).flat_map(|state| {
            let [_, end] = network.ends(edge_of[state as usize]);
            let out = firsts[end as usize]..firsts[end as usize + 1];
            let edge_of = &edge_of;
            let turns = out.map(move |to| (state, to, edge_of[to as usize]));
            // No vehicle crosses squares.
            turns.filter(move |(from, _, to)| !is_crossing(edge_of[*from as usize]) && !is_crossing(*to))
        });
        let overlay = Overlay::new(Arcs::new(edge_of.len(), arcs), &levels);
        Self { overlay, state_of, edge_of, restricted: Restricted::new(roads, profile) }
    }

    /// What turning from a directed edge into the next counts as, with the vertex between them and the edge that one turns into.
    pub fn weight(&self, roads: &Roads, metric: &Metric, from: u32, to: u32) -> u32 {
        let (a, b) = (metric.edges[from as usize], metric.edges[to as usize]);
        if !a.is_open() || !b.is_open() || self.restricted.forbids(from, to) {
            return FAR;
        }
        let turned = sum(b.weight(), self.penalty(roads, metric, from, to));
        if to == from ^ 1 {
            // One turns round where there is no other way only, be it for a barrier.
            return if self.is_dead_end(roads, metric, from) { turned } else { FAR };
        }
        let passed = metric.vertices[roads.network.ends(from)[1] as usize].weight();
        let entry = if b.ends_only() && !a.ends_only() { metric.entry } else { 0 };
        sum(sum(turned, passed), entry)
    }

    /// Hundredths of a second that turning from one directed edge into the next takes.
    pub fn penalty(&self, roads: &Roads, metric: &Metric, from: u32, to: u32) -> u32 {
        let Some(turns) = metric.profile.turns() else { return 0 };
        if to == from ^ 1 {
            return units(turns.u_turn);
        }
        if !metric.vertices[roads.network.ends(from)[1] as usize].is_junction() {
            return 0;
        }
        let guide = Guide { roads, metric };
        units(turns.seconds(turn(guide.reaching(from), guide.leaving(to))))
    }

    fn is_dead_end(&self, roads: &Roads, metric: &Metric, directed: u32) -> bool {
        let state = self.state_of[directed as usize];
        let others = self.overlay.out.of(state).map(|slot| self.overlay.out.via[slot]);

        metric.vertices[roads.network.ends(directed)[1] as usize].weight() >= FAR
            || others.filter(|to| *to != directed ^ 1).all(|to| metric.edges[to as usize].weight() >= FAR)
    }
}

impl Turns {
    /// Seconds that a turn by so many degrees takes, to the right above 0.
    pub fn seconds(&self, degrees: f64) -> f64 {
        let to_near_side = (degrees >= 0.0) == self.right_hand;
        let bias = if to_near_side { self.bias } else { 1.0 / self.bias };
        let steepness = 13.0 / bias * degrees.abs() / 180.0 - 6.5 * bias;
        self.sharpest / (1.0 + libm::exp(-steepness))
    }
}

/// Turns that are not allowed.
#[derive(Debug, Clone, Default)]
struct Restricted {
    forbidden: HashSet<(u32, u32)>,
    /// Where only one turn is allowed: the edge that one comes along, and the turns.
    only: HashSet<(u32, u32)>,
    bound: HashSet<u32>,
}

impl Restricted {
    fn new(roads: &Roads, profile: &Profile) -> Self {
        let network = &roads.network;
        let mut of_way: Vec<(i64, u32)> = network.ways.iter().copied().zip(0..).collect();
        of_way.sort_unstable();
        let edges = |way: i64| {
            let first = of_way.partition_point(|(w, _)| *w < way);
            of_way[first..].iter().take_while(move |(w, _)| *w == way).map(|(_, edge)| *edge)
        };
        // Directed edges of a way that end at a node.
        let reaching = |way: i64, node: i64| {
            let directed = edges(way).flat_map(|edge| [2 * edge, 2 * edge + 1]);
            directed.filter(move |directed| {
                network.vertex_nodes[network.ends(*directed)[1] as usize] == node
            })
        };
        let mut all = Self { forbidden: HashSet::new(), only: HashSet::new(), bound: HashSet::new() };
        for restriction in network.restrictions.iter() {
            let Some(only) = profile.restricts(&network.restriction_words.get(restriction.words)) else {
                continue;
            };
            for from in reaching(restriction.from, restriction.via) {
                for to in reaching(restriction.to, restriction.via).map(|directed| directed ^ 1) {
                    if only {
                        all.only.insert((from, to));
                        all.bound.insert(from);
                    } else {
                        all.forbidden.insert((from, to));
                    }
                }
            }
        }
        all
    }

    fn forbids(&self, from: u32, to: u32) -> bool {
        let others = self.bound.contains(&from) && !self.only.contains(&(from, to));
        self.forbidden.contains(&(from, to)) || (others && to != from ^ 1)
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
        assert!(seconds(90.0) < seconds(-90.0), "{} {}", seconds(90.0), seconds(-90.0));
        let right = 7.5 / (1.0 + libm::exp(-(13.0 / 1.075 * 90.0 / 180.0 - 6.5 * 1.075)));
        assert!((seconds(90.0) - right).abs() < 1e-9);
        let left = 7.5 / (1.0 + libm::exp(-(13.0 * 1.075 * 90.0 / 180.0 - 6.5 / 1.075)));
        assert!((seconds(-90.0) - left).abs() < 1e-9);
    }
}
