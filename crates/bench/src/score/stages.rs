//! What an agent did about its deliveries over time.

use openbench_core::Stage;
use serde::{Deserialize, Serialize};

use crate::trace::TimedStage;

/// A time in which an agent did one thing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StageSpan {
    /// Its begin, simulated seconds.
    pub from_s: f64,
    /// Its end, simulated seconds.
    pub to_s: f64,
    /// What it did.
    pub stage: Stage,
}

/// The stages of an episode that ended after so many seconds, in the order of time.
pub fn stage_spans(stages: &[TimedStage], end_s: f64) -> Vec<StageSpan> {
    let ends = stages.iter().skip(1).map(|next| next.time.seconds());
    let spans = stages.iter().zip(ends.chain([end_s]));
    spans
        .map(|(began, to_s)| StageSpan {
            from_s: began.time.seconds(),
            to_s,
            stage: began.stage,
        })
        .collect()
}

/// Seconds of each stage that there was, over all spans.
pub fn stage_sums<'a>(spans: impl Iterator<Item = &'a StageSpan> + Clone) -> Vec<(Stage, f64)> {
    let sum = |stage: Stage| {
        let own = spans.clone().filter(move |span| span.stage == stage);
        // Folded from +0, since the `sum()` of nothing is -0.
        own.fold(0.0, |all, span| all + (span.to_s - span.from_s))
    };
    let sums = Stage::ALL.map(|stage| (stage, sum(stage)));
    sums.into_iter()
        .filter(|(_, seconds)| *seconds > 0.0)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::SimTime;

    #[test]
    fn a_stage_lasts_until_the_next_and_the_last_one_until_the_end() {
        let at = |seconds: u64, stage: Stage| TimedStage {
            time: SimTime::from_millis(1000 * seconds),
            stage,
        };
        let stages = [
            at(2, Stage::Locating),
            at(5, Stage::Travelling),
            at(9, Stage::Locating),
        ];
        let spans = stage_spans(&stages, 10.0);
        let times: Vec<_> = spans.iter().map(|span| (span.from_s, span.to_s)).collect();
        assert_eq!(times, [(2.0, 5.0), (5.0, 9.0), (9.0, 10.0)]);
        let sums = stage_sums(spans.iter());
        assert_eq!(sums, [(Stage::Locating, 4.0), (Stage::Travelling, 4.0)]);
        assert!(stage_spans(&[], 10.0).is_empty());
    }
}
