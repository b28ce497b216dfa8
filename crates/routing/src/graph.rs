//! The road network as vertices and arcs.

use std::collections::BTreeMap;

use openbench_core::MapPoint;
use openbench_osm::OsmMap;

use crate::profile::Profile;

/// A piece of road between two nodes, in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// Vertex that it leads to.
    pub to: u32,
    /// Length, metres.
    pub length: f64,
    /// Time, seconds.
    pub time: f64,
    /// Index into [`RoadGraph::name`].
    pub road: u32,
}

/// A place on the network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Snap {
    /// The place.
    pub point: MapPoint,
    /// Distance from what was asked for, metres.
    pub away: f64,
    /// The segment's vertices, in the order of its way.
    pub ends: (u32, u32),
    /// Share of the segment between its first vertex and the place.
    pub share: f64,
}

/// The part of the network that a profile may use.
#[derive(Debug, Clone, Default)]
pub struct RoadGraph {
    vertices: Vec<MapPoint>,
    first_arc: Vec<u32>,
    arcs: Vec<Arc>,
    segments: Vec<(u32, u32)>,
    names: Vec<String>,
    /// For each vertex: whether it is in the largest part of the network that hangs together.
    in_largest: Vec<bool>,
}

impl RoadGraph {
    /// Builds the network of `map` for a profile. Ways that share a node hang together there.
    pub fn new(map: &OsmMap, profile: Profile) -> Self {
        let mut builder = Builder::default();
        for road in &map.roads {
            let speeds = profile.speeds(&road.tags);
            if speeds.forward.is_none() && speeds.backward.is_none() {
                continue;
            }
            let name = builder.name(road.tags.get("name").unwrap_or_default());
            for i in 1..road.nodes.len().min(road.points.len()) {
                let a = builder.vertex(road.nodes[i - 1], road.points[i - 1]);
                let b = builder.vertex(road.nodes[i], road.points[i]);
                builder.segment(a, b, name, speeds);
            }
        }
        builder.finish()
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Whether there is no road at all.
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty()
    }

    /// Where a vertex is.
    pub fn point(&self, vertex: u32) -> MapPoint {
        self.vertices[vertex as usize]
    }

    /// Arcs that leave a vertex.
    pub fn arcs(&self, vertex: u32) -> &[Arc] {
        &self.arcs[self.first_arc[vertex as usize] as usize..self.first_arc[vertex as usize + 1] as usize]
    }

    /// The arc from `a` straight to `b`, the fastest if there are several.
    pub fn arc_between(&self, a: u32, b: u32) -> Option<&Arc> {
        self.arcs(a).iter().filter(|arc| arc.to == b).min_by(|x, y| x.time.total_cmp(&y.time))
    }

    /// Name of a road, empty if it has none.
    pub fn name(&self, road: u32) -> &str {
        &self.names[road as usize]
    }

    /// The place on the network nearest to `point`, if one is within `limit` metres.
    pub fn snap(&self, point: MapPoint, limit: f64) -> Option<Snap> {
        self.nearest(point, limit, |_| true)
    }

    /// The same on the largest part of the network that hangs together.
    pub fn snap_to_largest(&self, point: MapPoint, limit: f64) -> Option<Snap> {
        self.nearest(point, limit, |vertex| self.in_largest[vertex as usize])
    }

    fn nearest(&self, point: MapPoint, limit: f64, usable: impl Fn(u32) -> bool) -> Option<Snap> {
        let segments = self.segments.iter().filter(|ends| usable(ends.0));
        let candidates = segments.map(|&ends| self.snap_to(point, ends));
        candidates.filter(|s| s.away <= limit).min_by(|a, b| a.away.total_cmp(&b.away))
    }

    fn snap_to(&self, point: MapPoint, ends: (u32, u32)) -> Snap {
        let (a, b) = (self.point(ends.0), self.point(ends.1));
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let square = dx * dx + dy * dy;
        let along = (point.x - a.x) * dx + (point.y - a.y) * dy;
        let share = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
        let foot = MapPoint::new(a.x + share * dx, a.y + share * dy);
        Snap { point: foot, away: foot.distance(point), ends, share }
    }
}

#[derive(Default)]
struct Builder {
    graph: RoadGraph,
    index: BTreeMap<i64, u32>,
    name_index: BTreeMap<String, u32>,
    arcs: Vec<(u32, Arc)>,
}

impl Builder {
    fn vertex(&mut self, node: i64, point: MapPoint) -> u32 {
        *self.index.entry(node).or_insert_with(|| {
            self.graph.vertices.push(point);
            self.graph.vertices.len() as u32 - 1
        })
    }

    fn name(&mut self, name: &str) -> u32 {
        if let Some(&known) = self.name_index.get(name) {
            return known;
        }
        let number = self.graph.names.len() as u32;
        self.graph.names.push(name.to_owned());
        self.name_index.insert(name.to_owned(), number);
        number
    }

    fn segment(&mut self, a: u32, b: u32, road: u32, speeds: crate::profile::Speeds) {
        let length = self.graph.point(a).distance(self.graph.point(b));
        self.graph.segments.push((a, b));
        for (from, to, speed) in [(a, b, speeds.forward), (b, a, speeds.backward)] {
            if let Some(speed) = speed {
                self.arcs.push((from, Arc { to, length, time: length / speed, road }));
            }
        }
    }

    fn finish(mut self) -> RoadGraph {
        self.arcs.sort_by_key(|(from, arc)| (*from, arc.to));
        let mut first_arc = vec![0_u32; self.graph.vertices.len() + 1];
        for (from, _) in &self.arcs {
            first_arc[*from as usize + 1] += 1;
        }
        for i in 1..first_arc.len() {
            first_arc[i] += first_arc[i - 1];
        }
        self.graph.first_arc = first_arc;
        self.graph.in_largest = largest_part(self.graph.vertices.len(), &self.graph.segments);
        self.graph.arcs = self.arcs.into_iter().map(|(_, arc)| arc).collect();
        self.graph
    }
}

/// Which of `count` vertices are in the largest part that `segments` hold together; of equally large ones the first.
fn largest_part(count: usize, segments: &[(u32, u32)]) -> Vec<bool> {
    let mut parent: Vec<u32> = (0..count as u32).collect();
    for &(a, b) in segments {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        parent[a.max(b) as usize] = a.min(b);
    }
    let roots: Vec<u32> = (0..count as u32).map(|v| root(&mut parent, v)).collect();
    let mut sizes = vec![0_u32; count];
    roots.iter().for_each(|&r| sizes[r as usize] += 1);
    let largest = (0..count).max_by(|&a, &b| sizes[a].cmp(&sizes[b]).then(b.cmp(&a)));
    roots.iter().map(|&r| Some(r as usize) == largest).collect()
}

/// The representative of a vertex's part (union-find with path halving).
fn root(parent: &mut [u32], mut vertex: u32) -> u32 {
    while parent[vertex as usize] != vertex {
        parent[vertex as usize] = parent[parent[vertex as usize] as usize];
        vertex = parent[vertex as usize];
    }
    vertex
}
