#![no_main]
//! A graph of poses in g2o's format; a small one is solved, too.

use libfuzzer_sys::fuzz_target;
use openbench_localization::graph::PoseGraph;

fuzz_target!(|text: &str| {
    let Ok(mut graph) = PoseGraph::parse(text) else {
        return;
    };
    let size = graph.size();
    if size.poses > 50 || size.edges > 200 {
        return;
    }
    if let Ok(solved) = graph.solve() {
        assert!(solved.chi2.is_finite() && solved.chi2 >= 0.0);
    }
    let again = PoseGraph::parse(&graph.to_text()).expect("what was written");
    assert_eq!(again.size(), size);
});
