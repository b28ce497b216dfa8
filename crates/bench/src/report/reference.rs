//! What others achieve in the same suite, beside this run.

use std::fmt::Write;

use serde::Deserialize;

use super::html::{escape, percent};
use crate::score::metrics::PAPER_SRTP;
use crate::score::results::Results;

/// Measured by `benchmarks/reference/reference.py`.
const MEASURED: &str = include_str!("../../data/reference.json");

/// Results of an agent in a built-in suite.
#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Reference {
    suite_hash: String,
    world_hash: String,
    agent: String,
    commit: String,
    collisions: usize,
    #[serde(flatten)]
    shares: Shares,
}

/// The headline metrics, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
struct Shares {
    sr_10m: Option<f64>,
    spl_straight: Option<f64>,
    lsr_10m: Option<f64>,
    lspl_straight: Option<f64>,
    sr_2m: Option<f64>,
    spl: Option<f64>,
    lsr: Option<f64>,
    lspl: Option<f64>,
}

impl Shares {
    fn of(results: &Results) -> Self {
        let m = &results.metrics;
        Self {
            sr_10m: m.sr_10m,
            spl_straight: m.spl_straight,
            lsr_10m: m.lsr_10m,
            lspl_straight: m.lspl_straight,
            sr_2m: m.sr_2m,
            spl: m.spl,
            lsr: m.lsr,
            lspl: m.lspl,
        }
    }

    /// In the order of the table.
    fn all(self) -> [Option<f64>; 8] {
        [
            self.sr_10m,
            self.spl_straight,
            self.lsr_10m,
            self.lspl_straight,
            self.sr_2m,
            self.spl,
            self.lsr,
            self.lspl,
        ]
    }
}

/// Writes a table of this run and of the references in its suite, and the paper's SRTP if the run
/// has one.
pub fn render(out: &mut String, results: &Results) {
    table(out, results);
    if let Some(srtp) = results.metrics.srtp {
        let models = PAPER_SRTP.map(|(model, srtp)| format!("{model} {}", percent(srtp)));
        let _ = writeln!(
            out,
            "<p class=\"note\">SRTP of this run: {} %. The paper reports, over 60 runs of other \
             instructions: {}.</p>",
            percent(srtp),
            models.join(", ")
        );
    }
}

/// Nothing in suites without references.
fn table(out: &mut String, results: &Results) {
    let references = in_suite(results);
    if references.is_empty() {
        return;
    }
    out.push_str(HEAD);
    row(
        out,
        "<b>this run</b>",
        Shares::of(results),
        results.metrics.collisions,
    );
    for reference in references {
        let name = format!(
            "{} <small>{}</small>",
            escape(&reference.agent),
            escape(&reference.commit)
        );
        row(out, &name, reference.shares, reference.collisions);
    }
    out.push_str(TAIL);
}

/// The references whose world and suite are those of a run.
fn in_suite(results: &Results) -> Vec<Reference> {
    let hashes = &results.provenance.hashes;
    let all: Vec<Reference> = serde_json::from_str(MEASURED).unwrap_or_default();
    let is_same = |r: &Reference| r.suite_hash == hashes.suite && r.world_hash == hashes.world;
    all.into_iter().filter(is_same).collect()
}

const HEAD: &str = "<h2>To compare with</h2>\n<div class=\"scroll\">\n<table>\n<thead>\n\
    <tr><th>Agent</th><th class=\"n\">SR<small>paper, %</small></th>\
    <th class=\"n\">SPL<small>paper</small></th><th class=\"n\">LSR<small>paper</small></th>\
    <th class=\"n\">LSPL<small>paper</small></th><th class=\"n\">SR<small>strict, %</small></th>\
    <th class=\"n\">SPL<small>strict</small></th><th class=\"n\">LSR<small>strict</small></th>\
    <th class=\"n\">LSPL<small>strict</small></th><th class=\"n\">Collisions</th></tr>\n\
    </thead>\n<tbody>\n";
const TAIL: &str = "</tbody>\n</table>\n</div>\n<p class=\"note\"><b>open</b> is the baseline with \
    its defaults. Yardsticks know the truth: <b>omniscient</b> follows the shortest path to the \
    right door, <b>straight-line</b> drives straight at it, <b>random</b> drives anywhere. All \
    with seed 0; the number beside the name is the commit.</p>\n";

fn row(out: &mut String, name: &str, shares: Shares, collisions: usize) {
    let _ = write!(out, "<tr><td>{name}</td>");
    for share in shares.all() {
        let share = share.map_or("–".to_owned(), percent);
        let _ = write!(out, "<td class=\"n\">{share}</td>");
    }
    let _ = writeln!(out, "<td class=\"n\">{collisions}</td></tr>");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::results::tests::results;

    fn measured() -> Vec<Reference> {
        serde_json::from_str(MEASURED).unwrap()
    }

    #[test]
    fn every_built_in_suite_has_its_references() {
        let agents = |suite: &str| -> Vec<String> {
            let prepared = crate::worlds::builtin_suite(suite).unwrap();
            let prepared = crate::Prepared::new(prepared, None).unwrap();
            let mut run = results(vec![]);
            run.provenance.hashes = crate::worlds::Hashes::of(&prepared).unwrap();
            in_suite(&run).into_iter().map(|r| r.agent).collect()
        };
        for suite in ["small", "medium", "large"] {
            let expected = ["omniscient", "open", "straight-line", "random"];
            assert_eq!(
                agents(suite),
                expected,
                "run benchmarks/reference for {suite}"
            );
        }
    }

    #[test]
    fn the_table_is_for_runs_of_the_same_suite_only() {
        let mut out = String::new();
        let mut run = results(vec![]);
        render(&mut out, &run);
        assert_eq!(out, "");
        let known = &measured()[0];
        run.provenance.hashes.suite = known.suite_hash.clone();
        run.provenance.hashes.world = known.world_hash.clone();
        render(&mut out, &run);
        assert!(out.contains("this run") && out.contains(&known.agent));
        assert!(!out.contains("SRTP"));
        run.metrics.srtp = Some(0.5);
        render(&mut out, &run);
        assert!(out.contains("SRTP of this run: 50.0 %") && out.contains("Qwen-turbo 50.0"));
    }
}
