//! What travelling counts as for one profile: the weights of all edges and turns, and what follows from them for every cell.
//!
//! Weights and durations are hundredths of a second. (So the longest way that counts takes 248 days.)

use openbench_osm::Tags;

use crate::components::Components;
use crate::network::Network;
use crate::overlay::{Arcs, CellTooLarge, Cliques, FAR, Overlay, Weights};
use crate::profile::{Going, Passing, Profile};
use crate::roads::Roads;
use crate::search::Searched;
use crate::turns::TurnGraph;

/// Units of weights and durations in a second.
pub const UNITS: f64 = 100.0;

/// What travelling along an edge in one direction counts as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EdgeCost {
    /// [`FAR`] if one may not go.
    pub weight: u32,
    /// What it takes.
    pub duration: u32,
    /// Whether only those may go here who begin or end here.
    pub ends_only: bool,
}

const CLOSED: EdgeCost = EdgeCost { weight: FAR, duration: FAR, ends_only: false };

/// What passing a vertex counts as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VertexCost {
    /// [`FAR`] if one may not pass.
    pub weight: u32,
    /// What it takes.
    pub duration: u32,
    /// Whether an edge meets it that is not for those only who begin or end there.
    pub public: bool,
}

/// A profile's weights for a network.
#[derive(Debug, Clone)]
pub struct Metric {
    /// Whose they are.
    pub profile: Profile,
    /// For each directed edge (twice the edge's number, and one more against its direction) what it counts as.
    pub edges: Vec<EdgeCost>,
    /// For each vertex what passing it counts as.
    pub vertices: Vec<VertexCost>,
    /// What entering a place counts as that is not for passing through.
    pub entry: u32,
    /// What hangs together.
    pub components: Components,
    /// Layers over directed edges, if turns matter.
    pub turns: Option<TurnGraph>,
    weights: Weights,
    cliques: Vec<Cliques>,
    weight_is_duration: bool,
}

impl Metric {
    /// Applies a profile to a network and customizes all cells.
    pub fn new(roads: &Roads, profile: Profile) -> Result<Self, CellTooLarge> {
        let network = &roads.network;
        let edges = edge_costs(network, &profile);
        let vertices = vertex_costs(network, &profile, &edges);
        let entry = units(profile.entry());
        let weight_is_duration = edges.iter().all(|edge| edge.weight == edge.duration && !edge.ends_only)
            && vertices.iter().all(|vertex| vertex.weight == vertex.duration);
        let turns = profile.turns().map(|_| TurnGraph::new(roads));
        let mut metric = Self {
            profile,
            edges,
            vertices,
            entry,
            components: Components::default(),
            turns,
            weights: Weights::default(),
            cliques: Vec::new(),
            weight_is_duration,
        };
        metric.weights = match &metric.turns {
            Some(turns) => turns.weights(roads, &metric),
            None => Weights {
                out: metric.arc_weights(network, &roads.vertices.out),
                into: metric.arc_weights(network, &roads.vertices.into),
            },
        };
        metric.cliques = Cliques::all(metric.overlay(roads), &metric.weights)?;
        metric.components = Components::new(roads, &metric);
        Ok(metric)
    }

    /// The layers that are searched.
    fn overlay<'a>(&'a self, roads: &'a Roads) -> &'a Overlay {
        self.turns.as_ref().map_or(&roads.vertices, |turns| &turns.overlay)
    }

    /// What searches need.
    pub fn searched<'a>(&'a self, roads: &'a Roads) -> Searched<'a> {
        Searched { overlay: self.overlay(roads), weights: &self.weights, cliques: &self.cliques }
    }

    /// Whether an edge can be travelled in some direction.
    pub fn is_open(&self, edge: u32) -> bool {
        self.edges[2 * edge as usize].weight < FAR || self.edges[2 * edge as usize + 1].weight < FAR
    }

    /// Whether everything counts as long as it takes.
    pub fn weight_is_duration(&self) -> bool {
        self.weight_is_duration
    }

    /// What passing from one directed edge to the next takes: the vertex between them, and the turn.
    pub fn passing(&self, roads: &Roads, from: u32, to: u32) -> [u32; 2] {
        let vertex = self.vertices[roads.network.ends(from)[1] as usize];
        let turn = self.turns.as_ref().map_or(0, |turns| turns.penalty(roads, self, from, to));
        [vertex.duration + turn, vertex.weight + turn]
    }

    fn arc_weights(&self, network: &Network, arcs: &Arcs) -> Vec<u32> {
        arcs.via.iter().map(|via| self.arc_weight(network, *via)).collect()
    }

    /// What going along a directed edge and past the vertex at its end counts as.
    pub fn arc_weight(&self, network: &Network, directed: u32) -> u32 {
        let past = self.vertices[network.ends(directed)[1] as usize].weight;
        sum(self.edge_weight(network, directed, 0, self.edges[directed as usize].weight), past)
    }

    /// What a part of a directed edge counts as; its first vertex is at the part's beginning if `from` is 0, and entering may cost then.
    pub fn edge_weight(&self, network: &Network, directed: u32, from: u32, to: u32) -> u32 {
        let cost = self.edges[directed as usize];
        if cost.weight >= FAR {
            return FAR;
        }
        let first = self.vertices[network.ends(directed)[0] as usize];
        let entry = if from == 0 && cost.ends_only && first.public { self.entry } else { 0 };
        sum(to - from, entry)
    }
}

/// Two weights together.
pub(crate) fn sum(a: u32, b: u32) -> u32 {
    (a + b).min(FAR)
}

/// Seconds as a weight.
pub(crate) fn units(seconds: f64) -> u32 {
    (libm::round(seconds * UNITS) as u32).min(FAR)
}

fn edge_costs(network: &Network, profile: &Profile) -> Vec<EdgeCost> {
    let goings: Vec<_> = network.way_words.iter().map(|words| profile.way(words)).collect();
    let cost = |length: u32, going: Option<Going>| match going {
        Some(Going { speed, cost, ends_only }) => {
            let seconds = f64::from(length) / 1000.0 / speed;
            EdgeCost { weight: units(seconds * cost), duration: units(seconds), ends_only }
        }
        None => CLOSED,
    };
    let edges = network.edges().iter();
    edges.flat_map(|edge| goings[edge.class as usize].map(|going| cost(edge.length, going))).collect()
}

fn vertex_costs(network: &Network, profile: &Profile, edges: &[EdgeCost]) -> Vec<VertexCost> {
    let cost = |words: &Tags| match profile.node(words) {
        Some(Passing { delay, cost }) => {
            VertexCost { weight: units(delay + cost), duration: units(delay), public: false }
        }
        None => VertexCost { weight: FAR, duration: FAR, public: false },
    };
    let classes: Vec<_> = network.node_words.iter().map(cost).collect();
    let mut vertices: Vec<_> = network.vertex_classes.iter().map(|class| classes[*class as usize]).collect();
    for (directed, _) in edges.iter().enumerate().filter(|(_, e)| e.weight < FAR && !e.ends_only) {
        for vertex in network.ends(directed as u32) {
            vertices[vertex as usize].public = true;
        }
    }
    vertices
}
