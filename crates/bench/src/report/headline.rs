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

/// Further shares of single deliveries, and SRTP.
pub(super) fn beside(metrics: &Metrics) -> Vec<Headline> {
    let all = [
        headline("clean SR", "sr_clean", metrics.sr_clean),
        headline("right door", "correct_unit", metrics.correct_unit),
        headline("SRTP", "srtp", metrics.srtp),
        // Shown only where it says more than SRTP.
        headline(
            "with fallbacks",
            "srtp_with_fallback",
            metrics
                .srtp_with_fallback
                .filter(|_| metrics.srtp_with_fallback != metrics.srtp),
        ),
    ];
    present(all)
}

/// The metrics of the deliveries in sequences, by both criteria.
pub(super) fn members(metrics: &Metrics) -> Vec<Headline> {
    present([
        headline("paper SR", "member_sr_10m", metrics.member_sr_10m),
        headline(
            "paper SPL",
            "member_spl_straight",
            metrics.member_spl_straight,
        ),
        headline("clean SR", "member_sr_clean", metrics.member_sr_clean),
        headline("strict SR", "member_sr_2m", metrics.member_sr_2m),
        headline("strict SPL", "member_spl", metrics.member_spl),
    ])
}

/// Those that have a value.
fn present<const N: usize>(all: [Headline; N]) -> Vec<Headline> {
    let has_value = |metric: &Headline| metric.value.is_some();
    all.into_iter().filter(has_value).collect()
}

fn headline(label: &'static str, key: &'static str, value: Option<f64>) -> Headline {
    Headline { label, key, value }
}
