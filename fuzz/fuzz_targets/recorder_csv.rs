#![no_main]
//! The reference recorder's CSV and its truth files: one input is read as both.
//!
//! The readers' two files are compiled by themselves: `openbench-bench`, which they belong to, brings the runtime of the networks, and that compiles for half an hour once it is instrumented.

use libfuzzer_sys::fuzz_target;
use log::parse_log;
use truth_file::parse_truth;

#[path = "../../crates/bench/src/line_problem.rs"]
mod line_problem;
#[path = "../../crates/bench/src/score/evaluate/log.rs"]
mod log;
#[path = "../../crates/bench/src/suite/truth_file.rs"]
mod truth_file;

fuzz_target!(|text: &str| {
    if let Ok(tasks) = parse_log(text) {
        assert!(
            tasks
                .iter()
                .all(|t| t.path_m >= 0.0 && t.end.x.is_finite() && t.end.y.is_finite())
        );
    }
    if let Ok(lines) = parse_truth(text) {
        assert!(
            lines
                .iter()
                .flat_map(|line| &line.points)
                .all(|p| p.x.is_finite() && p.y.is_finite())
        );
    }
});
