//! What a profile's edges and vertices cost, before turns and cells.
//!
//! Weights and durations are hundredths of a second. The heaviest route that counts therefore
//! takes 248 days.

use openbench_osm::Tags;

use crate::network::{Edge, Network};
use crate::overlay::FAR;
use crate::profile::{Passing, Profile, Travel};

/// Units of weights and durations in a second.
pub(crate) const UNITS_PER_SECOND: f64 = 100.0;

/// A weight and a duration, each with a flag. Weights end at [`FAR`], so the highest bits are free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Flagged {
    weight: u32,
    duration: u32,
}

// The highest bit, since `FAR` is 2^31 - 1.
const FLAG: u32 = FAR + 1;

impl Flagged {
    const fn new(weight: u32, duration: u32) -> Self {
        Self { weight, duration }
    }

    /// Impassable.
    const NEVER: Self = Self::new(FAR, FAR);
}

/// The cost of travelling along an edge in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EdgeCost(Flagged);

impl EdgeCost {
    /// An edge that is closed in this direction.
    pub(crate) const CLOSED: Self = Self(Flagged::NEVER);

    /// The cost of an edge of that length, which is travelled as `travel` says, if at all.
    pub(crate) fn new(edge: &Edge, travel: Option<Travel>) -> Self {
        let Some(Travel {
            speed,
            cost,
            ends_only,
        }) = travel
        else {
            return Self::CLOSED;
        };
        // `edge.length` is in millimetres.
        let seconds = f64::from(edge.length) / 1000.0 / speed;
        let flag = if ends_only { FLAG } else { 0 };
        Self(Flagged::new(units(seconds * cost) | flag, units(seconds)))
    }

    /// The weight; [`FAR`] if the edge is closed.
    #[inline]
    pub fn weight(self) -> u32 {
        self.0.weight & FAR
    }

    /// The time it takes.
    #[inline]
    pub fn duration(self) -> u32 {
        self.0.duration
    }

    /// Whether the edge may be used only by routes that begin or end there.
    #[inline]
    pub(crate) fn ends_only(self) -> bool {
        self.0.weight & FLAG != 0
    }

    /// Whether the edge may be used.
    #[inline]
    pub fn is_open(self) -> bool {
        self.weight() < FAR
    }
}

/// The cost of passing a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct VertexCost(Flagged);

impl VertexCost {
    /// The weight; [`FAR`] if the vertex cannot be passed.
    #[inline]
    pub(crate) fn weight(self) -> u32 {
        self.0.weight & FAR
    }

    /// The time it takes.
    #[inline]
    pub(crate) fn duration(self) -> u32 {
        self.0.duration & FAR
    }

    /// Whether an edge that is open to through traffic meets the vertex.
    pub(crate) fn is_public(self) -> bool {
        self.0.weight & FLAG != 0
    }

    /// Whether three open edges or more meet at the vertex.
    pub(crate) fn is_junction(self) -> bool {
        self.0.duration & FLAG != 0
    }
}

/// A profile with the costs of a network's edges and vertices.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Costs<'a> {
    /// The profile.
    pub profile: &'a Profile,
    /// The cost of each directed edge: twice the edge's number, plus one against its direction.
    pub edges: &'a [EdgeCost],
    /// The cost of each vertex.
    pub vertices: &'a [VertexCost],
    /// The weight of entering an edge that is closed to through traffic.
    pub entry: u32,
}

impl Costs<'_> {
    /// Whether an edge can be travelled in one direction at least.
    pub(crate) fn is_open(&self, edge: u32) -> bool {
        (0..2).any(|side| self.edges[2 * edge as usize + side].is_open())
    }

    /// Whether all weights are durations.
    pub(crate) fn weights_are_durations(&self) -> bool {
        let edges = self.edges.iter();
        let vertices = self.vertices.iter();
        edges
            .clone()
            .all(|edge| edge.weight() == edge.duration() && !edge.ends_only())
            && vertices
                .clone()
                .all(|vertex| vertex.weight() == vertex.duration())
    }

    /// The weight of a directed edge together with the vertex at its end.
    #[inline]
    pub(crate) fn arc_weight(&self, network: &Network, directed: u32) -> u32 {
        let passed = self.vertices[network.ends(directed)[1] as usize].weight();
        let edge = self.edge_weight(network, directed, self.edges[directed as usize].weight());
        sum(edge, passed)
    }

    /// The weight of the first part of a directed edge, which itself weighs `part`, together with
    /// entering the edge. [`FAR`] if the edge is closed.
    #[inline]
    pub(crate) fn edge_weight(&self, network: &Network, directed: u32, part: u32) -> u32 {
        let cost = self.edges[directed as usize];
        if !cost.is_open() {
            return FAR;
        }
        // The penalty is paid once, on the way in from a public vertex. Further edges of the same
        // private ground begin at vertices that are not public, and cost no more.
        let first = self.vertices[network.ends(directed)[0] as usize];
        let entry = if cost.ends_only() && first.is_public() {
            self.entry
        } else {
            0
        };
        sum(part, entry)
    }
}

/// Length of a directed edge, centimetres.
#[inline]
pub(crate) fn centimetres(network: &Network, directed: u32) -> u32 {
    network.edges[directed as usize / 2]
        .length
        .saturating_add(5)
        / 10
}

/// The sum of two weights, [`FAR`] at most.
#[inline]
pub(crate) fn sum(a: u32, b: u32) -> u32 {
    // No overflow: both are at most `FAR`, and twice that fits into `u32`.
    (a + b).min(FAR)
}

/// Seconds as a weight, [`FAR`] at most.
#[inline]
pub(crate) fn units(seconds: f64) -> u32 {
    // The cast saturates, so an endless time is `FAR` as well.
    (libm::round(seconds * UNITS_PER_SECOND) as u32).min(FAR)
}

/// The costs of all directed edges.
pub(crate) fn edge_costs(network: &Network, profile: &Profile) -> Vec<EdgeCost> {
    // The rules are applied once for each set of tags. Edges share few sets.
    let travels: Vec<_> = network
        .way_tags
        .iter()
        .map(|tags| profile.way(&tags))
        .collect();
    let both = |edge: &Edge| travels[edge.class as usize].map(|travel| EdgeCost::new(edge, travel));
    network.edges().iter().flat_map(both).collect()
}

/// The costs of all vertices. `edges` are the costs of all directed edges.
pub(crate) fn vertex_costs(
    network: &Network,
    profile: &Profile,
    edges: &[EdgeCost],
) -> Vec<VertexCost> {
    // As for edges: once for each set of tags.
    let classes: Vec<_> = network
        .node_tags
        .iter()
        .map(|tags| passing_cost(profile, &tags))
        .collect();
    let mut vertices: Vec<_> = network
        .vertex_classes
        .iter()
        .map(|class| classes[*class as usize])
        .collect();
    flag_public(&mut vertices, network, edges);
    flag_junctions(&mut vertices, network, edges);
    vertices.into_iter().map(VertexCost).collect()
}

fn passing_cost(profile: &Profile, tags: &Tags) -> Flagged {
    match profile.node(tags) {
        Some(Passing { delay, cost }) => Flagged::new(units(delay + cost), units(delay)),
        None => Flagged::NEVER,
    }
}

/// Flags the weights of vertices that an edge open to through traffic meets.
fn flag_public(vertices: &mut [Flagged], network: &Network, edges: &[EdgeCost]) {
    for (directed, cost) in (0..).zip(edges) {
        if cost.is_open() && !cost.ends_only() {
            for vertex in network.ends(directed) {
                vertices[vertex as usize].weight |= FLAG;
            }
        }
    }
}

/// Flags the durations of vertices at which three open edges or more meet.
fn flag_junctions(vertices: &mut [Flagged], network: &Network, edges: &[EdgeCost]) {
    let mut degrees = vec![0_u8; vertices.len()];
    for edge in 0..network.edge_count() as u32 {
        let is_open = (0..2).any(|side| edges[(2 * edge + side) as usize].is_open());
        if is_open {
            for vertex in network.ends(2 * edge) {
                // Only three or more matters, so a count that saturates at 255 is exact enough. A
                // loop counts twice: a traveller sees two roads.
                degrees[vertex as usize] = degrees[vertex as usize].saturating_add(1);
            }
        }
    }
    for (vertex, degree) in vertices.iter_mut().zip(degrees) {
        if degree >= 3 {
            vertex.duration |= FLAG;
        }
    }
}
