//! On every extract at hand and for every profile, searches over layers agree with plain Dijkstra.

#[path = "../../skips.rs"]
mod skips;

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::path::PathBuf;

use openbench_osm::stream::Source;
use openbench_routing::overlay::FAR;
use openbench_routing::search::{End, Path, Searched, TableMemory, Value, ValuedEnd, Workspace};
use openbench_routing::{Metric, Profile, Roads};
use skips::shared_data;

fn extracts() -> Vec<PathBuf> {
    let Some(folder) = shared_data("osm") else {
        return Vec::new();
    };
    let files = std::fs::read_dir(folder).unwrap();
    let mut files: Vec<PathBuf> = files.map(|file| file.unwrap().path()).collect();
    files.sort();
    files
}

/// The distance of every state.
fn dijkstra(graph: Searched<'_>, source: u32) -> Vec<u32> {
    let (out, weights) = (&graph.overlay.out, &graph.weights.out);
    let mut distance = vec![FAR; out.states()];
    let mut heap = BinaryHeap::from([Reverse((0, source))]);
    while let Some(Reverse((reached, state))) = heap.pop() {
        if reached >= distance[state as usize] {
            continue;
        }
        distance[state as usize] = reached;
        for slot in out.of(state).filter(|slot| weights[*slot] < FAR) {
            heap.push(Reverse((reached + weights[slot], out.head[slot])));
        }
    }
    distance
}

#[test]
fn routes_and_tables_on_real_maps_are_exact() {
    for file in extracts() {
        let roads = Roads::read(&Source::open(&file).unwrap(), &Default::default()).unwrap();
        for name in Profile::NAMES {
            let metric = Metric::new(&roads, Profile::named(name).unwrap()).unwrap();
            let graph = metric.searched(&roads);
            let states = graph.overlay.out.states() as u64;
            let state = |i: u64| (i.wrapping_mul(0x9E37_79B9_7F4A_7C15) % states) as u32;
            let sources: Vec<u32> = (1..=6).map(state).collect();
            let targets: Vec<u32> = (100..150).map(state).collect();
            let (mut workspace, mut path) = (Workspace::default(), Path::default());
            let end = |state: u32| vec![End { state, weight: 0 }];
            let [from, to] = [&sources, &targets]
                .map(|states| states.iter().map(|s| end(*s)).collect::<Vec<_>>());
            let valued = |all: &[Vec<End>]| {
                let one = |end: &End| ValuedEnd {
                    end: *end,
                    value: Value::default(),
                };
                all.iter()
                    .map(|ends| ends.iter().map(one).collect())
                    .collect::<Vec<Vec<_>>>()
            };
            let table = TableMemory::default().table(
                &mut Workspace::default(),
                graph,
                None,
                &valued(&from),
                &valued(&to),
            );
            for (row, source) in table.chunks(targets.len()).zip(&sources) {
                let plain = dijkstra(graph, *source);
                for (cell, target) in row.iter().zip(&targets) {
                    let expected = plain[*target as usize];
                    assert_eq!(
                        cell.weight,
                        expected,
                        "{} {name}: table {source} to {target}",
                        file.display()
                    );
                    let found = workspace.route(graph, &end(*source), &end(*target), &mut path);
                    assert_eq!(
                        found.unwrap_or(FAR),
                        expected,
                        "{} {name}: {source} to {target}",
                        file.display()
                    );
                    let weight = |pair: &[u32]| {
                        let out = &graph.overlay.out;
                        let slots = out.of(pair[0]).filter(|slot| out.head[*slot] == pair[1]);
                        slots.map(|slot| graph.weights.out[slot]).min().unwrap()
                    };
                    if found.is_some() {
                        assert_eq!(path.states.windows(2).map(weight).sum::<u32>(), expected);
                    }
                }
            }
        }
    }
}
