//! What travelling counts as for one profile: the weights of all edges and turns, and what follows from them for every cell.
//!
//! Weights and durations are hundredths of a second. (So the longest way that counts takes 248 days.)

use std::sync::OnceLock;

use openbench_osm::Tags;

use crate::components::Components;
use crate::network::{Edge, Network};
use crate::overlay::{Cliques, FAR, Overlay, Weights};
use crate::profile::{Going, Passing, Profile};
use crate::roads::Roads;
use crate::search::{Searched, Values};
use crate::turns::{TooManyTurns, TurnGraph};

/// Units of weights and durations in a second.
pub const UNITS: f64 = 100.0;

/// A weight and a duration with a mark on each: weights end at [`FAR`], so their highest bits are free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Marked {
    weight: u32,
    duration: u32,
}

const MARK: u32 = FAR + 1;

impl Marked {
    const fn new(weight: u32, duration: u32) -> Self {
        Self { weight, duration }
    }

    /// Not to be gone.
    const NEVER: Self = Self::new(FAR, FAR);
}

/// What travelling along an edge in one direction counts as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EdgeCost(Marked);

impl EdgeCost {
    const CLOSED: Self = Self(Marked::NEVER);

    /// [`FAR`] if one may not go.
    #[inline]
    pub fn weight(self) -> u32 {
        self.0.weight & FAR
    }

    /// What it takes.
    #[inline]
    pub fn duration(self) -> u32 {
        self.0.duration
    }

    /// Whether only those may go here who begin or end here.
    #[inline]
    pub fn ends_only(self) -> bool {
        self.0.weight & MARK != 0
    }

    /// Whether one may go.
    #[inline]
    pub fn is_open(self) -> bool {
        self.weight() < FAR
    }
}

/// What passing a vertex counts as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VertexCost(Marked);

impl VertexCost {
    /// [`FAR`] if one may not pass.
    #[inline]
    pub fn weight(self) -> u32 {
        self.0.weight & FAR
    }

    /// What it takes.
    #[inline]
    pub fn duration(self) -> u32 {
        self.0.duration & FAR
    }

    /// Whether an edge meets it that is not for those only who begin or end there.
    pub fn is_public(self) -> bool {
        self.0.weight & MARK != 0
    }

    /// Whether three edges or more meet there that are open.
    pub fn is_junction(self) -> bool {
        self.0.duration & MARK != 0
    }
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
    /// Worked out when a table is first asked for.
    values: OnceLock<Values>,
}

impl Metric {
    /// Applies a profile to a network and customizes all cells.
    pub fn new(roads: &Roads, profile: Profile) -> Result<Self, TooManyTurns> {
        let network = &roads.network;
        let edges = edge_costs(network, &profile);
        let vertices = vertex_costs(network, &profile, &edges);
        let entry = units(profile.entry());
        let weight_is_duration = edges
            .iter()
            .all(|edge| edge.weight() == edge.duration() && !edge.ends_only())
            && vertices
                .iter()
                .all(|vertex| vertex.weight() == vertex.duration());
        let turns = profile
            .turns()
            .map(|_| TurnGraph::new(roads, &profile, &edges))
            .transpose()?;
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
            values: OnceLock::new(),
        };
        let overlay = metric.overlay(roads);
        metric.weights = Weights {
            out: overlay
                .out
                .iter()
                .map(|(from, slot)| metric.weight_of_arc_out(roads, from, slot))
                .collect(),
            into: overlay
                .incoming()
                .iter()
                .map(|(to, slot)| metric.weight_of_arc_into(roads, to, slot))
                .collect(),
        };
        // First, so that what it needs for a moment is used again.
        metric.components = Components::new(roads, &metric);
        metric.cliques = Cliques::all(metric.overlay(roads), &metric.weights);
        Ok(metric)
    }

    /// The layers that are searched.
    fn overlay<'a>(&'a self, roads: &'a Roads) -> &'a Overlay {
        self.turns
            .as_ref()
            .map_or(&roads.vertices, |turns| &turns.overlay)
    }

    /// What searches need.
    pub fn searched<'a>(&'a self, roads: &'a Roads) -> Searched<'a> {
        Searched {
            overlay: self.overlay(roads),
            weights: &self.weights,
            cliques: &self.cliques,
        }
    }

    /// Whether an edge can be travelled in some direction.
    pub fn is_open(&self, edge: u32) -> bool {
        (0..2).any(|side| self.edges[2 * edge as usize + side].is_open())
    }

    /// Whether everything counts as long as it takes.
    pub fn weight_is_duration(&self) -> bool {
        self.weight_is_duration
    }

    /// What arcs and ways through cells take, hundredths of a second and centimetres.
    pub fn values(&self, roads: &Roads) -> &Values {
        self.values.get_or_init(|| {
            let graph = self.searched(roads);
            let out = &graph.overlay.out;
            let arcs = out.iter().map(|(from, slot)| {
                let via = out.via[slot];
                let passed = match &self.turns {
                    Some(turns) => self.passing(roads, turns.edge_of[from as usize], via)[0],
                    None => self.vertices[out.head[slot] as usize].duration(),
                };
                [
                    self.edges[via as usize].duration().saturating_add(passed),
                    centimetres(roads, via),
                ]
            });
            Values::new(graph, arcs.collect())
        })
    }

    /// What passing from one directed edge to the next takes: the vertex between them, and the turn.
    pub fn passing(&self, roads: &Roads, from: u32, to: u32) -> [u32; 2] {
        let turn = self
            .turns
            .as_ref()
            .map_or(0, |turns| turns.penalty(roads, self, from, to));
        if to == from ^ 1 && self.turns.is_some() {
            // One turns round in front of the vertex, which may be a barrier.
            return [turn, turn];
        }
        let vertex = self.vertices[roads.network.ends(from)[1] as usize];
        [vertex.duration() + turn, vertex.weight() + turn]
    }

    /// What going from one directed edge into the next counts as because the next is not for passing through.
    pub fn entry_weight(&self, roads: &Roads, from: u32, to: u32) -> u32 {
        let into = self.edges[to as usize].ends_only();
        let from_public = match &self.turns {
            Some(_) => !self.edges[from as usize].ends_only() && to != from ^ 1,
            None => self.vertices[roads.network.ends(to)[0] as usize].is_public(),
        };
        if into && from_public { self.entry } else { 0 }
    }

    /// What an arc counts as that leaves a state.
    fn weight_of_arc_out(&self, roads: &Roads, from: u32, slot: usize) -> u32 {
        match &self.turns {
            Some(turns) => turns.weight(roads, self, from, turns.overlay.out.head[slot]),
            None => self.arc_weight(&roads.network, roads.vertices.out.via[slot]),
        }
    }

    /// What an arc counts as that leads to a state.
    fn weight_of_arc_into(&self, roads: &Roads, to: u32, slot: usize) -> u32 {
        match &self.turns {
            Some(turns) => turns.weight(roads, self, turns.overlay.incoming().head[slot], to),
            None => self.arc_weight(&roads.network, roads.vertices.via_incoming(slot)),
        }
    }

    /// Closes edges to all traffic, or opens them again as far as the profile has them open. Only the cells that this changes are worked out again, and what hangs together.
    pub fn set_closed(&mut self, roads: &Roads, edges: &[u32], closed: bool) {
        let network = &roads.network;
        for &edge in edges {
            let Edge { class, length, .. } = network.edges[edge as usize];
            let goings = self.profile.way(&network.way_words.get(class));
            for (direction, going) in goings.into_iter().enumerate() {
                let cost = if closed {
                    EdgeCost::CLOSED
                } else {
                    edge_cost(length, going)
                };
                self.edges[2 * edge as usize + direction] = cost;
            }
        }
        let mut vertices: Vec<u32> = edges
            .iter()
            .flat_map(|edge| network.ends(2 * edge))
            .collect();
        vertices.sort_unstable();
        vertices.dedup();
        let states = self.states_at(roads, &vertices);
        for &state in &states {
            for slot in self.overlay(roads).out.of(state) {
                self.weights.out[slot] = self.weight_of_arc_out(roads, state, slot);
            }
            for slot in self.overlay(roads).incoming().of(state) {
                self.weights.into[slot] = self.weight_of_arc_into(roads, state, slot);
            }
        }
        // A way to a state, or from one, is an arc of the state at its other end too.
        for &state in &states {
            for other in self.neighbours(roads, state) {
                for slot in self.overlay(roads).out.of(other) {
                    self.weights.out[slot] = self.weight_of_arc_out(roads, other, slot);
                }
                for slot in self.overlay(roads).incoming().of(other) {
                    self.weights.into[slot] = self.weight_of_arc_into(roads, other, slot);
                }
            }
        }
        let overlay = self
            .turns
            .as_ref()
            .map_or(&roads.vertices, |turns| &turns.overlay);
        Cliques::update(&mut self.cliques, overlay, &self.weights, &states);
        self.components = Components::new(roads, self);
        self.values = OnceLock::new();
    }

    /// The states that arcs at these vertices lead between.
    fn states_at(&self, roads: &Roads, vertices: &[u32]) -> Vec<u32> {
        let Some(turns) = &self.turns else {
            return vertices.to_vec();
        };
        let around = vertices
            .iter()
            .flat_map(|vertex| roads.vertices.out.of(*vertex));
        let leaving = around.map(|slot| roads.vertices.out.via[slot]);
        leaving
            .flat_map(|directed| [directed, directed ^ 1])
            .flat_map(|d| turns.states_of(d))
            .collect()
    }

    fn neighbours(&self, roads: &Roads, state: u32) -> Vec<u32> {
        let overlay = self.overlay(roads);
        let out = overlay.out.of(state).map(|slot| overlay.out.head[slot]);
        out.chain(
            overlay
                .incoming()
                .of(state)
                .map(|slot| overlay.incoming().head[slot]),
        )
        .collect()
    }

    /// What going along a directed edge and past the vertex at its end counts as.
    pub fn arc_weight(&self, network: &Network, directed: u32) -> u32 {
        let past = self.vertices[network.ends(directed)[1] as usize].weight();
        sum(
            self.edge_weight(network, directed, self.edges[directed as usize].weight()),
            past,
        )
    }

    /// What the first part of a directed edge, which itself counts as `part`, counts as with entering it.
    pub fn edge_weight(&self, network: &Network, directed: u32, part: u32) -> u32 {
        let cost = self.edges[directed as usize];
        if !cost.is_open() {
            return FAR;
        }
        let first = self.vertices[network.ends(directed)[0] as usize];
        let entry = if cost.ends_only() && first.is_public() {
            self.entry
        } else {
            0
        };
        sum(part, entry)
    }
}

/// How long a directed edge is.
pub(crate) fn centimetres(roads: &Roads, directed: u32) -> u32 {
    roads.network.edges[directed as usize / 2]
        .length
        .saturating_add(5)
        / 10
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
    let goings: Vec<_> = network
        .way_words
        .iter()
        .map(|words| profile.way(&words))
        .collect();
    let edges = network.edges().iter();
    edges
        .flat_map(|edge| goings[edge.class as usize].map(|going| edge_cost(edge.length, going)))
        .collect()
}

fn edge_cost(millimetres: u32, going: Option<Going>) -> EdgeCost {
    let Some(Going {
        speed,
        cost,
        ends_only,
    }) = going
    else {
        return EdgeCost::CLOSED;
    };
    let seconds = f64::from(millimetres) / 1000.0 / speed;
    let mark = if ends_only { MARK } else { 0 };
    EdgeCost(Marked::new(units(seconds * cost) | mark, units(seconds)))
}

fn vertex_costs(network: &Network, profile: &Profile, edges: &[EdgeCost]) -> Vec<VertexCost> {
    let cost = |words: Tags| match profile.node(&words) {
        Some(Passing { delay, cost }) => Marked::new(units(delay + cost), units(delay)),
        None => Marked::NEVER,
    };
    let classes: Vec<_> = network.node_words.iter().map(cost).collect();
    let mut vertices: Vec<_> = network
        .vertex_classes
        .iter()
        .map(|class| classes[*class as usize])
        .collect();
    for (directed, _) in edges
        .iter()
        .enumerate()
        .filter(|(_, e)| e.is_open() && !e.ends_only())
    {
        for vertex in network.ends(directed as u32) {
            vertices[vertex as usize].weight |= MARK;
        }
    }
    let mut met = vec![0_u8; vertices.len()];
    let open = |edge: &u32| (0..2).any(|side| edges[(2 * edge + side) as usize].is_open());
    for edge in (0..network.edge_count() as u32).filter(open) {
        for vertex in network.ends(2 * edge) {
            met[vertex as usize] = met[vertex as usize].saturating_add(1);
        }
    }
    for (vertex, _) in vertices.iter_mut().zip(met).filter(|(_, met)| *met >= 3) {
        vertex.duration |= MARK;
    }
    vertices.into_iter().map(VertexCost).collect()
}
