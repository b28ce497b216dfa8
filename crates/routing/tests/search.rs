//! Searches over layers give the weights of plain Dijkstra, and the paths that they claim.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use openbench_routing::geo::Place;
use openbench_routing::overlay::{Arc, Arcs, Cliques, FAR, Overlay, Weights};
use openbench_routing::partition::{CellSizes, Partition};
use openbench_routing::search::{
    End, Path, Searched, TableMemory, Value, ValuedEnd, Values, Workspace,
};
use proptest::prelude::*;

/// Arcs with weights, between states that have places.
#[derive(Debug, Clone)]
struct Graph {
    places: Vec<Place>,
    /// From, to, weight. The index of an arc is the edge that it passes along.
    arcs: Vec<(u32, u32, u32)>,
}

fn graph() -> impl Strategy<Value = Graph> {
    let weight = prop_oneof![4 => 0_u32..50, 1 => Just(0), 1 => Just(FAR), 1 => Just(FAR / 3)];
    (2_u32..80).prop_flat_map(move |count| {
        let places = proptest::collection::vec((-9_i32..9, -9_i32..9), count as usize);
        let arcs = proptest::collection::vec(
            (0..count, 0..count, [weight.clone(), weight.clone()]),
            0..220,
        );
        (places, arcs, any::<bool>()).prop_map(|(places, arcs, streets)| Graph {
            places: places
                .into_iter()
                .map(|(lon, lat)| Place { lon, lat })
                .collect(),
            arcs: if streets {
                // Each arc has one in the opposite direction, like those of streets.
                let arcs = arcs.into_iter().filter(|(a, b, _)| a != b).take(110);
                arcs.flat_map(|(a, b, [there, back])| [(a, b, there), (b, a, back)])
                    .collect()
            } else {
                arcs.into_iter()
                    .map(|(a, b, [weight, _])| (a, b, weight))
                    .collect()
            },
        })
    })
}

impl Graph {
    /// The same graph, with states in the order of their cells.
    fn in_cells(&self, sizes: &[usize]) -> (Self, Vec<Vec<u32>>) {
        let edges: Vec<_> = self.arcs.iter().map(|(a, b, _)| [*a, *b]).collect();
        let partition = Partition::new(&self.places, &edges, &CellSizes::new(sizes).unwrap());
        let mut position = vec![0; self.places.len()];
        for (i, state) in partition.order.iter().enumerate() {
            position[*state as usize] = i as u32;
        }
        let arcs = self
            .arcs
            .iter()
            .map(|(a, b, w)| (position[*a as usize], position[*b as usize], *w));
        let places = partition
            .order
            .iter()
            .map(|state| self.places[*state as usize])
            .collect();
        (
            Self {
                places,
                arcs: arcs.collect(),
            },
            partition.levels,
        )
    }

    fn overlay(&self, levels: &[Vec<u32>]) -> Overlay {
        let arcs = self.arcs.iter().zip(0..).map(|((a, b, _), via)| Arc {
            from: *a,
            to: *b,
            via,
        });
        Overlay::new(Arcs::new(self.places.len(), arcs), levels)
    }

    fn weights(&self, overlay: &Overlay) -> Weights {
        let weight = |via: u32| self.arcs[via as usize].2;
        let slots = 0..overlay.out.via.len();
        Weights {
            out: slots
                .clone()
                .map(|slot| weight(overlay.out.via[slot]))
                .collect(),
            into: slots
                .map(|slot| weight(overlay.via_incoming(slot)))
                .collect(),
        }
    }

    fn dijkstra(&self, sources: &[End], targets: &[End]) -> Option<u32> {
        let mut distance = vec![FAR; self.places.len()];
        let mut heap = BinaryHeap::new();
        for end in sources {
            heap.push(Reverse((end.weight, end.state)));
        }
        while let Some(Reverse((reached, state))) = heap.pop() {
            if reached >= distance[state as usize] {
                continue;
            }
            distance[state as usize] = reached;
            for (_, to, weight) in self
                .arcs
                .iter()
                .filter(|(from, _, w)| *from == state && *w < FAR)
            {
                heap.push(Reverse((reached + weight, *to)));
            }
        }
        let total = targets
            .iter()
            .map(|end| distance[end.state as usize] + end.weight)
            .min();
        total.filter(|total| *total < FAR)
    }

    /// The weight of a path of states, by the lightest arcs between them.
    fn along(&self, path: &[u32], sources: &[End], targets: &[End]) -> u32 {
        let end = |ends: &[End], state: u32| {
            ends.iter()
                .filter(|e| e.state == state)
                .map(|e| e.weight)
                .min()
                .unwrap()
        };
        let arc = |pair: &[u32]| {
            let between = self
                .arcs
                .iter()
                .filter(|(a, b, _)| [*a, *b] == [pair[0], pair[1]]);
            between.map(|arc| arc.2).min().unwrap()
        };
        let arcs: u32 = path.windows(2).map(arc).sum();
        end(sources, path[0]) + arcs + end(targets, path[path.len() - 1])
    }
}

fn ends(count: u32, drawn: &[(u32, u32)]) -> Vec<End> {
    drawn
        .iter()
        .map(|(state, weight)| End {
            state: state % count,
            weight: *weight,
        })
        .collect()
}

fn drawn() -> impl Strategy<Value = Vec<(u32, u32)>> {
    proptest::collection::vec((0_u32..1000, 0_u32..60), 1..4)
}

/// The overlay of a graph, its weights and its cliques.
struct Customized {
    overlay: Overlay,
    weights: Weights,
    cliques: Vec<Cliques>,
}

impl Customized {
    fn new(graph: &Graph, levels: &[Vec<u32>]) -> Self {
        let overlay = graph.overlay(levels);
        let weights = graph.weights(&overlay);
        let cliques = Cliques::all(&overlay, &weights);
        Self {
            overlay,
            weights,
            cliques,
        }
    }

    fn searched(&self) -> Searched<'_> {
        let Self {
            overlay,
            weights,
            cliques,
        } = self;
        Searched {
            overlay,
            weights,
            cliques,
        }
    }
}

/// Each end takes its weight and no length.
fn valued(all: &[Vec<End>]) -> Vec<Vec<ValuedEnd>> {
    let one = |end: &End| {
        let value = Value {
            duration: end.weight,
            length: 0,
        };
        ValuedEnd { end: *end, value }
    };
    all.iter()
        .map(|ends| ends.iter().map(one).collect())
        .collect()
}

const SIZES: [&[usize]; 4] = [&[2, 5, 12, 30], &[4, 16], &[8], &[100]];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn routes_are_as_light_as_those_of_dijkstra(
        graph in graph(),
        pairs in proptest::collection::vec((drawn(), drawn()), 6),
    ) {
        for sizes in SIZES {
            let (graph, levels) = graph.in_cells(sizes);
            let customized = Customized::new(&graph, &levels);
            let searched = customized.searched();
            let (mut workspace, mut path) = (Workspace::default(), Path::default());
            for (sources, targets) in &pairs {
                let count = graph.places.len() as u32;
                let (sources, targets) = (ends(count, sources), ends(count, targets));
                let found = workspace.route(searched, &sources, &targets, &mut path);
                prop_assert_eq!(found, graph.dijkstra(&sources, &targets), "{:?}", sizes);
                if let Some(weight) = found {
                    prop_assert_eq!(graph.along(&path.states, &sources, &targets), weight);
                }
            }
        }
    }

    #[test]
    fn incoming_and_outgoing_arcs_are_the_same(graph in graph()) {
        let (graph, levels) = graph.in_cells(&[4, 16]);
        let overlay = graph.overlay(&levels);
        let (incoming, outgoing) = (overlay.incoming(), &overlay.out);
        let mut into: Vec<Arc> = incoming
            .iter()
            .map(|(to, slot)| Arc {
                from: incoming.head[slot],
                to,
                via: overlay.via_incoming(slot),
            })
            .collect();
        let mut out: Vec<Arc> = outgoing
            .iter()
            .map(|(from, slot)| Arc { from, to: outgoing.head[slot], via: outgoing.via[slot] })
            .collect();
        let key = |arc: &Arc| (arc.from, arc.to, arc.via);
        into.sort_unstable_by_key(key);
        out.sort_unstable_by_key(key);
        prop_assert_eq!(into, out);
    }

    #[test]
    fn tables_are_as_light_as_those_of_dijkstra(
        graph in graph(),
        sources in proptest::collection::vec(drawn(), 0..5),
        targets in proptest::collection::vec(drawn(), 0..5),
    ) {
        for sizes in SIZES {
            let (graph, levels) = graph.in_cells(sizes);
            let customized = Customized::new(&graph, &levels);
            let searched = customized.searched();
            let count = graph.places.len() as u32;
            let sources: Vec<_> = sources.iter().map(|drawn| ends(count, drawn)).collect();
            let targets: Vec<_> = targets.iter().map(|drawn| ends(count, drawn)).collect();
            // Each arc takes its weight and a length of 1, so a path takes its weight and its
            // number of arcs.
            let arcs = customized.overlay.out.via.iter();
            let value = |via: &u32| Value { duration: graph.arcs[*via as usize].2, length: 1 };
            let values = Values::new(searched, arcs.map(value).collect());
            let (from, to) = (valued(&sources), valued(&targets));
            let mut memory = TableMemory::default();
            let mut table =
                || memory.table(&mut Workspace::default(), searched, Some(&values), &from, &to);
            let first = table();
            for cell in &first {
                prop_assert!(cell.weight == FAR || cell.weight == cell.value.duration);
            }
            let weights: Vec<u32> = first.iter().map(|cell| cell.weight).collect();
            let pairs = sources.iter().flat_map(|s| targets.iter().map(move |t| (s, t)));
            let plain = pairs.map(|(s, t)| graph.dijkstra(s, t).unwrap_or(FAR));
            prop_assert_eq!(weights, plain.collect::<Vec<_>>(), "{:?}", sizes);
            prop_assert_eq!(table(), first, "the second time");
        }
    }

    #[test]
    fn changed_weights_affect_only_their_cells(
        graph in graph(),
        changes in proptest::collection::vec((0_usize..1000, 0_u32..60), 1..6),
    ) {
        let (mut graph, levels) = graph.in_cells(&[3, 9, 27]);
        let overlay = graph.overlay(&levels);
        let before = graph.weights(&overlay);
        let mut cliques = Cliques::all(&overlay, &before);
        let mut states = Vec::new();
        let count = graph.arcs.len();
        for (arc, weight) in changes.into_iter().filter(|_| count > 0) {
            let arc = arc % count;
            graph.arcs[arc].2 = if weight == 0 { FAR } else { weight };
            states.extend([graph.arcs[arc].0, graph.arcs[arc].1]);
        }
        let after = graph.weights(&overlay);
        Cliques::update(&mut cliques, &overlay, &after, &states);
        prop_assert_eq!(cliques, Cliques::all(&overlay, &after));
    }
}
