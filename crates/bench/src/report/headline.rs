//! The headline metrics by the paper's and by the strict criterion.

use crate::score::results::Metrics;

/// A metric with its names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Headline {
    /// Its abbreviation in the literature.
    pub label: &'static str,
    /// Its name in `results.json`.
    pub key: &'static str,
    /// Its value, 0 to 1.
    pub value: Option<f64>,
}

/// The metrics by the paper's criterion.
pub(super) fn paper(metrics: &Metrics) -> [Headline; 4] {
    [
        headline("SR", "sr_10m", metrics.sr_10m),
        headline("SPL", "spl_straight", metrics.spl_straight),
        headline("LSR", "lsr_10m", metrics.lsr_10m),
        headline("LSPL", "lspl_straight", metrics.lspl_straight),
    ]
}

/// The metrics by the strict criterion.
pub(super) fn strict(metrics: &Metrics) -> [Headline; 4] {
    [
        headline("SR", "sr_2m", metrics.sr_2m),
        headline("SPL", "spl", metrics.spl),
        headline("LSR", "lsr", metrics.lsr),
        headline("LSPL", "lspl", metrics.lspl),
    ]
}

fn headline(label: &'static str, key: &'static str, value: Option<f64>) -> Headline {
    Headline { label, key, value }
}
