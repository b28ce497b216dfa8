//! Minimum cuts: maximum flow through edges of capacity one, in either direction.
//!
//! E. A. Dinic, *Algorithm for solution of a problem of maximum flow in networks with power
//! estimation*, 1970: shortest augmenting paths, all of one length at a time.

/// An undirected graph: each edge is stored at both of its ends.
#[derive(Debug, Clone, Default)]
pub(super) struct Graph {
    /// For each vertex its first slot, and the end of the last one's.
    pub(super) first: Vec<u32>,
    /// The vertex to which the edge in this slot leads.
    pub(super) head: Vec<u32>,
    /// The slot of the same edge at its other end.
    pub(super) twin: Vec<u32>,
}

impl Graph {
    /// Edges between `count` vertices. Loops are left out.
    pub(super) fn new(count: usize, edges: impl Iterator<Item = [u32; 2]> + Clone) -> Self {
        let edges = edges.filter(|[a, b]| a != b);
        // Sorts by counting, as `Arcs` does, with each edge at both of its ends.
        let mut first = vec![0_u32; count + 1];
        for [a, b] in edges.clone() {
            first[a as usize + 1] += 1;
            first[b as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let slots = first[count] as usize;
        let mut graph = Self {
            first,
            head: vec![0; slots],
            twin: vec![0; slots],
        };
        let mut next = graph.first.clone();
        let mut take = |vertex: u32| {
            next[vertex as usize] += 1;
            next[vertex as usize] - 1
        };
        for [a, b] in edges {
            let (s, t) = (take(a), take(b));
            (graph.head[s as usize], graph.head[t as usize]) = (b, a);
            (graph.twin[s as usize], graph.twin[t as usize]) = (t, s);
        }
        graph
    }

    pub(super) fn len(&self) -> usize {
        self.first.len() - 1
    }

    pub(super) fn slots(&self, vertex: u32) -> std::ops::Range<usize> {
        self.first[vertex as usize] as usize..self.first[vertex as usize + 1] as usize
    }
}

/// Which end of the flow a vertex belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Free,
    Source,
    Sink,
}

const FAR: u32 = u32::MAX;

/// Finds minimum cuts. Its memory is used again for the next one.
#[derive(Debug, Default)]
pub(super) struct Flow {
    /// The residual capacity of each slot: 1 if unused, 0 if used this way, 2 if used the other
    /// way.
    residual: Vec<u8>,
    level: Vec<u32>,
    /// Sources with a neighbour that is none: the flow leaves the sources there.
    begin: Vec<u32>,
    /// For each vertex the slot with which to continue.
    next: Vec<u32>,
    queue: Vec<u32>,
    path: Vec<u32>,
}

impl Flow {
    /// The maximum flow from all sources to all sinks; `None` as soon as it exceeds `limit`.
    pub(super) fn largest(&mut self, graph: &Graph, roles: &[Role], limit: usize) -> Option<usize> {
        self.residual.clear();
        // An edge of capacity one in both directions: using it one way frees a second unit the
        // other way.
        self.residual.resize(graph.head.len(), 1);
        let is_source = |vertex: u32| roles[vertex as usize] == Role::Source;
        let leaves = |vertex: &u32| {
            is_source(*vertex)
                && graph
                    .slots(*vertex)
                    .any(|slot| !is_source(graph.head[slot]))
        };
        self.begin.clear();
        self.begin.extend((0..graph.len() as u32).filter(leaves));
        let mut flow = 0;
        while self.find_levels(graph, roles) {
            // No underflow: a flow above the limit has returned.
            flow += self.block(graph, roles, limit - flow);
            if flow > limit {
                return None;
            }
        }
        Some(flow)
    }

    /// Numbers vertices by their distance from the sources. Returns whether a sink was reached.
    fn find_levels(&mut self, graph: &Graph, roles: &[Role]) -> bool {
        self.level.clear();
        self.level.resize(graph.len(), FAR);
        self.queue.clear();
        self.queue.extend_from_slice(&self.begin);
        self.begin
            .iter()
            .for_each(|vertex| self.level[*vertex as usize] = 0);
        let (mut done, mut last) = (0, FAR);
        while let Some(&vertex) = self.queue.get(done) {
            done += 1;
            let next = self.level[vertex as usize] + 1;
            // All vertices at the distance of the nearest sink have their level. Farther ones are
            // on no shortest path.
            if next > last {
                break;
            }
            for slot in graph.slots(vertex) {
                let head = graph.head[slot] as usize;
                if self.residual[slot] == 0
                    || self.level[head] != FAR
                    || roles[head] == Role::Source
                {
                    continue;
                }
                self.level[head] = next;
                if roles[head] == Role::Sink {
                    last = next;
                }
                self.queue.push(head as u32);
            }
        }
        last != FAR
    }

    /// Augments the flow along all paths of the present length, by no more than one unit above
    /// `limit`.
    fn block(&mut self, graph: &Graph, roles: &[Role], limit: usize) -> usize {
        self.next.clear();
        // A slot that failed once fails for the rest of the phase, so each is passed over once
        // only.
        self.next.extend_from_slice(&graph.first[..graph.len()]);
        let mut flow = 0;
        for i in 0..self.begin.len() {
            while flow <= limit && self.augment(graph, roles, self.begin[i]) {
                flow += 1;
            }
        }
        flow
    }

    /// Augments the flow by one unit from a source to a sink.
    fn augment(&mut self, graph: &Graph, roles: &[Role], source: u32) -> bool {
        self.path.clear();
        let mut vertex = source;
        while roles[vertex as usize] != Role::Sink {
            let slot = self.next[vertex as usize];
            if slot < graph.first[vertex as usize + 1] {
                let head = graph.head[slot as usize];
                let onwards = self.level[vertex as usize] + 1;
                if self.residual[slot as usize] > 0 && self.level[head as usize] == onwards {
                    self.path.push(slot);
                    vertex = head;
                } else {
                    self.next[vertex as usize] += 1;
                }
            } else {
                // A dead end: back, and not this way again.
                let Some(slot) = self.path.pop() else {
                    return false;
                };
                vertex = graph.head[graph.twin[slot as usize] as usize];
                self.next[vertex as usize] += 1;
            }
        }
        // All capacities are one, so each path carries one unit.
        for &slot in &self.path {
            self.residual[slot as usize] -= 1;
            self.residual[graph.twin[slot as usize] as usize] += 1;
        }
        true
    }

    /// After [`Flow::largest`]: the vertices that can still be reached from the sources, or, with
    /// `from_sinks`, that can still reach the sinks.
    pub(super) fn side(
        &mut self,
        graph: &Graph,
        roles: &[Role],
        from_sinks: bool,
        inside: &mut Vec<bool>,
    ) {
        inside.clear();
        inside.resize(graph.len(), false);
        self.queue.clear();
        let role = if from_sinks { Role::Sink } else { Role::Source };
        for vertex in 0..graph.len() as u32 {
            if roles[vertex as usize] == role {
                inside[vertex as usize] = true;
                self.queue.push(vertex);
            }
        }
        while let Some(vertex) = self.queue.pop() {
            for slot in graph.slots(vertex) {
                let head = graph.head[slot] as usize;
                let way = if from_sinks {
                    // Towards the sinks: what is left in the direction from `head` to here.
                    graph.twin[slot] as usize
                } else {
                    slot
                };
                if self.residual[way] > 0 && !inside[head] {
                    inside[head] = true;
                    self.queue.push(head as u32);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The minimum number of edges between a set that contains the sources and the rest that
    /// contains the sinks, by trying all sets.
    fn smallest_cut(count: usize, edges: &[[u32; 2]], roles: &[Role]) -> usize {
        let fits = |set: usize| {
            (0..count).all(|v| match roles[v] {
                Role::Free => true,
                Role::Source => set >> v & 1 == 1,
                Role::Sink => set >> v & 1 == 0,
            })
        };
        let cut = |set: usize| {
            edges
                .iter()
                .filter(|[a, b]| (set >> a ^ set >> b) & 1 == 1)
                .count()
        };
        (0..1 << count)
            .filter(|set| fits(*set))
            .map(cut)
            .min()
            .unwrap()
    }

    proptest! {
        #[test]
        fn the_largest_flow_is_the_smallest_cut(
            edges in proptest::collection::vec((0_u32..9, 0_u32..9), 0..24),
            roles in proptest::collection::vec(0_u8..4, 9),
        ) {
            let edges: Vec<[u32; 2]> = edges.into_iter().map(|(a, b)| [a, b]).collect();
            let all = [Role::Free, Role::Free, Role::Source, Role::Sink];
            let roles: Vec<Role> = roles.into_iter().map(|role| all[usize::from(role)]).collect();
            let graph = Graph::new(9, edges.iter().copied());
            let (mut flow, mut inside) = (Flow::default(), Vec::new());
            let largest = flow.largest(&graph, &roles, 100).unwrap();
            prop_assert_eq!(largest, smallest_cut(9, &edges, &roles));
            for from_sinks in [false, true] {
                flow.side(&graph, &roles, from_sinks, &mut inside);
                let apart = |edge: &&[u32; 2]| inside[edge[0] as usize] != inside[edge[1] as usize];
                prop_assert_eq!(edges.iter().filter(apart).count(), largest);
            }
            let below = largest.checked_sub(1);
            let stopped = below.and_then(|limit| flow.largest(&graph, &roles, limit));
            prop_assert_eq!(stopped, None);
        }
    }
}
