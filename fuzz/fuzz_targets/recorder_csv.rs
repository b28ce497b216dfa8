#![no_main]
//! The reference recorder's CSV and its truth files: one input is read as both.

use libfuzzer_sys::fuzz_target;
use openbench_bench::evaluate::{parse_log, parse_truth};

fuzz_target!(|text: &str| {
    if let Ok(tasks) = parse_log(text) {
        assert!(tasks.iter().all(|t| t.path_m >= 0.0 && t.end.x.is_finite() && t.end.y.is_finite()));
    }
    if let Ok(lines) = parse_truth(text) {
        assert!(lines.iter().flatten().all(|p| p.x.is_finite() && p.y.is_finite()));
    }
});
