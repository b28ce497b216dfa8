//! Closing a road while routes are requested: only what it changes is computed again, and the
//! result is as if everything had been.

use openbench_osm::OsmData;
use openbench_routing::partition::CellSizes;
use openbench_routing::{Metric, Profile, Roads};
use proptest::prelude::*;

/// Streets along a grid, every third of them one-way.
fn grid(width: i32, height: i32) -> Roads {
    let mut xml = "<osm version=\"0.6\">".to_owned();
    for i in 0..width * height {
        let (lon, lat) = (f64::from(i % width) / 1e3, f64::from(i / width) / 1e3);
        xml += &format!("<node id=\"{}\" lat=\"{lat}\" lon=\"{lon}\"/>", i + 1);
    }
    let mut way = |id: i32, nodes: Vec<i32>| {
        let nodes: String = nodes
            .iter()
            .map(|n| format!("<nd ref=\"{}\"/>", n + 1))
            .collect();
        let oneway = if id % 3 == 0 {
            "<tag k=\"oneway\" v=\"yes\"/>"
        } else {
            ""
        };
        xml += &format!(
            "<way id=\"{id}\">{nodes}<tag k=\"highway\" v=\"residential\"/>{oneway}</way>"
        );
    };
    for row in 0..height {
        way(row + 1, (0..width).map(|i| row * width + i).collect());
    }
    for column in 0..width {
        way(
            100 + column,
            (0..height).map(|i| i * width + column).collect(),
        );
    }
    let data = OsmData::from_xml((xml + "</osm>").as_bytes()).unwrap();
    Roads::read(&data, &CellSizes::new(&[6, 20]).unwrap()).unwrap()
}

/// Everything that searches read.
fn state(metric: &Metric, roads: &Roads) -> impl PartialEq + std::fmt::Debug {
    let graph = metric.searched(roads);
    (
        graph.weights.clone(),
        graph.cliques.to_vec(),
        metric.components.clone(),
        metric.edges.clone(),
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn closing_and_opening_equals_a_new_customization(
        first in proptest::collection::vec(0_u32..110, 1..6),
        second in proptest::collection::vec(0_u32..110, 1..6),
        profile in 0_usize..3,
    ) {
        let roads = grid(8, 8);
        let profile = Profile::named(Profile::NAMES[profile]).unwrap();
        let untouched = Metric::new(&roads, profile.clone()).unwrap();
        let mut one = untouched.clone();
        one.set_closed(&roads, &first, true);
        one.set_closed(&roads, &second, true);
        let mut other = untouched.clone();
        other.set_closed(&roads, &[first.clone(), second.clone()].concat(), true);
        prop_assert_eq!(state(&one, &roads), state(&other, &roads));
        prop_assert!(first.iter().all(|edge| !one.is_open(*edge)));
        one.set_closed(&roads, &first, false);
        one.set_closed(&roads, &second, false);
        prop_assert_eq!(state(&one, &roads), state(&untouched, &roads));
    }
}
