//! A profile customized for a network: the weights of all edges and turns, and what follows from
//! them for every cell.

use std::sync::OnceLock;

use crate::components::Components;
use crate::costs::{Costs, EdgeCost, VertexCost, centimetres, edge_costs, units, vertex_costs};
use crate::overlay::{Arcs, Cliques, Overlay, Weights};
use crate::profile::Profile;
use crate::roads::Roads;
use crate::search::{Searched, Value, Values};
use crate::turns::{TooManyTurns, TurnGraph};

/// What passing from one edge to the next takes, hundredths of a second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct PassingCost {
    /// The time.
    pub duration: u32,
    /// The weight.
    pub weight: u32,
}

/// A profile customized for a network.
///
/// ```
/// use openbench_core::LonLat;
/// use openbench_osm::OsmData;
/// use openbench_routing::geo::Place;
/// use openbench_routing::leg::{Leg, Memory};
/// use openbench_routing::position::{Snap, SnapOptions};
/// use openbench_routing::tree::Nearest;
/// use openbench_routing::{Metric, Profile, Roads};
///
/// // 222 m of a residential street along the equator, one-way to the east.
/// let map = OsmData::from_xml(
///     br#"<osm version="0.6"><node id="1" lat="0" lon="0"/><node id="2" lat="0" lon="0.002"/>
///         <way id="7"><nd ref="1"/><nd ref="2"/><tag k="highway" v="residential"/>
///         <tag k="oneway" v="yes"/></way></osm>"#,
/// )?;
/// let roads = Roads::read(&map, &Default::default())?;
/// let [west, east] = [0.0005, 0.0015].map(|lon| Place::new(LonLat::new(lon, 0.0)).unwrap());
/// for (profile, back) in [("car", false), ("foot", true)] {
///     let metric = Metric::new(&roads, Profile::open(profile)?)?;
///     let snap = |place| {
///         Snap::new(&roads, &metric, place, &SnapOptions::default(), &mut Nearest::default())
///     };
///     let (from, to) = (snap(east), snap(west));
///     let memory = &mut Memory::default();
///     let leg = Leg::find(&roads, &metric, &from.nearest, &to.nearest, memory);
///     assert_eq!(leg.is_some(), back, "only pedestrians may go back along the street");
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Metric {
    /// The profile.
    pub(crate) profile: Profile,
    /// The cost of each directed edge: twice the edge's number, plus one against its direction.
    pub edges: Vec<EdgeCost>,
    /// The cost of passing each vertex.
    pub(crate) vertices: Vec<VertexCost>,
    /// The weight of entering an edge that is closed to through traffic.
    pub(crate) entry: u32,
    /// Strongly connected components.
    pub components: Components,
    /// Layers over directed edges, if turns matter.
    pub turns: Option<TurnGraph>,
    weights: Weights,
    cliques: Vec<Cliques>,
    weight_is_duration: bool,
    /// Computed when a table is requested for the first time.
    values: OnceLock<Values>,
}

impl Metric {
    /// Applies a profile to a network and customizes all cells.
    ///
    /// # Errors
    /// If turns matter to the profile and the junctions of the map have too many roads.
    pub fn new(roads: &Roads, profile: Profile) -> Result<Self, TooManyTurns> {
        let network = &roads.network;
        let edges = edge_costs(network, &profile);
        let vertices = vertex_costs(network, &profile, &edges);
        let entry = units(profile.entry());
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
            weight_is_duration: false,
            values: OnceLock::new(),
        };
        metric.weight_is_duration = metric.costs().weights_are_durations();
        metric.weights = metric.weights_of_arcs(roads);
        // Before the cliques, so that its temporary memory is used again by them.
        metric.components = metric.find_components(roads);
        metric.cliques = Cliques::all(metric.overlay(roads), &metric.weights);
        Ok(metric)
    }

    /// The costs of edges and vertices alone.
    pub(crate) fn costs(&self) -> Costs<'_> {
        Costs {
            profile: &self.profile,
            edges: &self.edges,
            vertices: &self.vertices,
            entry: self.entry,
        }
    }

    fn weights_of_arcs(&self, roads: &Roads) -> Weights {
        let overlay = self.overlay(roads);
        let out = overlay
            .out
            .iter()
            .map(|(from, slot)| self.weight_of_arc_out(roads, from, slot));
        let into = overlay.incoming().iter();
        let into = into.map(|(to, slot)| self.weight_of_arc_into(roads, to, slot));
        Weights {
            out: out.collect(),
            into: into.collect(),
        }
    }

    fn find_components(&self, roads: &Roads) -> Components {
        Components::new(
            roads,
            &self.costs(),
            self.turns.as_ref(),
            self.searched(roads),
        )
    }

    /// The layers that are searched.
    fn overlay<'a>(&'a self, roads: &'a Roads) -> &'a Overlay {
        overlay_of(&self.turns, roads)
    }

    /// The graph that is searched.
    pub fn searched<'a>(&'a self, roads: &'a Roads) -> Searched<'a> {
        Searched {
            overlay: self.overlay(roads),
            weights: &self.weights,
            cliques: &self.cliques,
        }
    }

    /// Whether an edge can be travelled in one direction at least.
    pub fn is_open(&self, edge: u32) -> bool {
        self.costs().is_open(edge)
    }

    /// Whether all weights are durations.
    pub(crate) fn weight_is_duration(&self) -> bool {
        self.weight_is_duration
    }

    /// What arcs and paths through cells take.
    pub(crate) fn values(&self, roads: &Roads) -> &Values {
        self.values.get_or_init(|| {
            let graph = self.searched(roads);
            let out = &graph.overlay.out;
            let arcs = out
                .iter()
                .map(|(from, slot)| self.value_of_arc(roads, out, from, slot));
            Values::new(graph, arcs.collect())
        })
    }

    /// What an arc takes that leaves a state.
    fn value_of_arc(&self, roads: &Roads, out: &Arcs, from: u32, slot: usize) -> Value {
        let via = out.via[slot];
        let passed = match &self.turns {
            Some(turns) => {
                self.passing(roads, turns.edge_of[from as usize], via)
                    .duration
            }
            None => self.vertices[out.head[slot] as usize].duration(),
        };
        Value {
            duration: self.edges[via as usize].duration().saturating_add(passed),
            length: centimetres(&roads.network, via),
        }
    }

    /// What passing from one directed edge to the next takes: the vertex between them, and the
    /// turn.
    pub(crate) fn passing(&self, roads: &Roads, from: u32, to: u32) -> PassingCost {
        let costs = self.costs();
        let turn = match &self.turns {
            Some(turns) => turns.penalty(roads, &costs, from, to),
            None => 0,
        };
        if to == from ^ 1 && self.turns.is_some() {
            // A U-turn is made in front of the vertex, which may be a barrier.
            return PassingCost {
                duration: turn,
                weight: turn,
            };
        }
        let vertex = self.vertices[roads.network.ends(from)[1] as usize];
        PassingCost {
            duration: vertex.duration() + turn,
            weight: vertex.weight() + turn,
        }
    }

    /// The weight of going from one directed edge into the next if the next is closed to through
    /// traffic.
    pub(crate) fn entry_weight(&self, roads: &Roads, from: u32, to: u32) -> u32 {
        let into = self.edges[to as usize].ends_only();
        let from_public = match &self.turns {
            // As in `TurnGraph::weight`: the edge before decides, and a U-turn enters nothing.
            Some(_) => !self.edges[from as usize].ends_only() && to != from ^ 1,
            // As in `Costs::edge_weight`: the search does not know the edge before, only the
            // vertex.
            None => self.vertices[roads.network.ends(to)[0] as usize].is_public(),
        };
        if into && from_public { self.entry } else { 0 }
    }

    /// The weight of an arc that leaves a state.
    fn weight_of_arc_out(&self, roads: &Roads, from: u32, slot: usize) -> u32 {
        match &self.turns {
            Some(turns) => turns.weight(roads, &self.costs(), from, turns.overlay.out.head[slot]),
            None => self
                .costs()
                .arc_weight(&roads.network, roads.vertices.out.via[slot]),
        }
    }

    /// The weight of an arc that leads to a state.
    fn weight_of_arc_into(&self, roads: &Roads, to: u32, slot: usize) -> u32 {
        match &self.turns {
            Some(turns) => turns.weight(
                roads,
                &self.costs(),
                turns.overlay.incoming().head[slot],
                to,
            ),
            None => self
                .costs()
                .arc_weight(&roads.network, roads.vertices.via_incoming(slot)),
        }
    }

    /// Closes edges to all traffic, or opens them again as far as the profile has them open. Only
    /// the cells that this changes are customized again, and the components.
    pub fn set_closed(&mut self, roads: &Roads, edges: &[u32], closed: bool) {
        let network = &roads.network;
        for &number in edges {
            let edge = &network.edges[number as usize];
            // Opening is no undo: the profile is asked again, so that it may keep a direction
            // closed.
            let travels = self.profile.way(&network.way_tags.get(edge.class));
            for (side, travel) in travels.into_iter().enumerate() {
                let travel = travel.filter(|_| !closed);
                self.edges[2 * number as usize + side] = EdgeCost::new(edge, travel);
            }
        }
        // Vertices keep their flags: a blocked road still makes a junction.
        let mut vertices: Vec<u32> = edges
            .iter()
            .flat_map(|edge| network.ends(2 * edge))
            .collect();
        vertices.sort_unstable();
        vertices.dedup();
        let states = self.states_at(roads, &vertices);
        for &state in &states {
            self.update_weights_at(roads, state);
        }
        // An arc to or from a state is an arc of the state at its other end, too.
        for &state in &states {
            for other in self.neighbours(roads, state) {
                self.update_weights_at(roads, other);
            }
        }
        let overlay = overlay_of(&self.turns, roads);
        // Each changed arc joins two of these states, or one of them and a neighbour. The cells
        // around these states are all cells that contain such an arc.
        Cliques::update(&mut self.cliques, overlay, &self.weights, &states);
        self.components = self.find_components(roads);
        // Sums along trees that may have changed.
        self.values = OnceLock::new();
    }

    /// Computes the weights of a state's arcs again.
    fn update_weights_at(&mut self, roads: &Roads, state: u32) {
        for slot in self.overlay(roads).out.of(state) {
            self.weights.out[slot] = self.weight_of_arc_out(roads, state, slot);
        }
        for slot in self.overlay(roads).incoming().of(state) {
            self.weights.into[slot] = self.weight_of_arc_into(roads, state, slot);
        }
    }

    /// The states between which the arcs at these vertices lead.
    fn states_at(&self, roads: &Roads, vertices: &[u32]) -> Vec<u32> {
        let Some(turns) = &self.turns else {
            return vertices.to_vec();
        };
        let out = &roads.vertices.out;
        let leaving = vertices
            .iter()
            .flat_map(|vertex| out.of(*vertex))
            .map(|slot| out.via[slot]);
        // Turns at a vertex lead from the edges that reach it to those that leave it.
        let both = leaving.flat_map(|directed| [directed, directed ^ 1]);
        both.flat_map(|directed| turns.states_of(directed))
            .collect()
    }

    /// The states at the other ends of a state's arcs.
    fn neighbours(&self, roads: &Roads, state: u32) -> Vec<u32> {
        let overlay = self.overlay(roads);
        let (out, incoming) = (&overlay.out, overlay.incoming());
        let after = out.of(state).map(|slot| out.head[slot]);
        let before = incoming.of(state).map(|slot| incoming.head[slot]);
        after.chain(before).collect()
    }
}

/// The layers that are searched: over directed edges if turns matter, else over vertices.
fn overlay_of<'a>(turns: &'a Option<TurnGraph>, roads: &'a Roads) -> &'a Overlay {
    turns
        .as_ref()
        .map_or(&roads.vertices, |turns| &turns.overlay)
}
