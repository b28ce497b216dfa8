//! Whether the models of a run can be reached at all.

use std::sync::atomic::{AtomicBool, Ordering};

use openbench_core::{FailureCause, ModelUse};

use crate::BenchError;
use crate::trace::{Deed, EpisodeTrace};

/// Whether a model has answered so far in any episode of a run: that of the planner, and any other.
#[derive(Debug, Default)]
pub(super) struct Reached {
    planner: AtomicBool,
    reader: AtomicBool,
}

impl Reached {
    /// Notes whether a model answered in an episode.
    pub(super) fn note(&self, trace: &EpisodeTrace) {
        let used = Uses::of(trace);
        for (reached, used) in [(&self.planner, used.planner), (&self.reader, used.reader)] {
            if used.calls > used.failed {
                // Relaxed suffices: the flag alone is shared, and it only ever rises.
                reached.store(true, Ordering::Relaxed);
            }
        }
    }

    /// Ends a run whose planner or reader asks a model that has never answered: all its deliveries
    /// would fail for a reason that says nothing about the model.
    ///
    /// # Errors
    /// [`BenchError::Unreachable`].
    pub(super) fn check(&self, trace: &EpisodeTrace, episode: usize) -> Result<(), BenchError> {
        self.note(trace);
        let used = Uses::of(trace);
        let never = |reached: &AtomicBool, used: ModelUse| {
            used.failed > 0 && !reached.load(Ordering::Relaxed)
        };
        let failures = trace.tasks.iter().filter_map(|task| task.failure.as_ref());
        let unavailable = failures.filter_map(|failure| match failure.cause {
            FailureCause::PlannerUnavailable if never(&self.planner, used.planner) => {
                Some(("planner", failure))
            }
            FailureCause::ReaderUnavailable if never(&self.reader, used.reader) => {
                Some(("reader", failure))
            }
            _ => None,
        });
        match unavailable.into_iter().next() {
            Some((part, failure)) => Err(BenchError::Unreachable {
                episode,
                detail: failure.detail.clone(),
                part,
            }),
            None => Ok(()),
        }
    }
}

/// What an episode asked of models.
struct Uses {
    /// For its plan.
    planner: ModelUse,
    /// Afterwards.
    reader: ModelUse,
}

impl Uses {
    fn of(trace: &EpisodeTrace) -> Self {
        let planned = trace.deeds.iter().find(|deed| is_plan(&deed.deed));
        let first = trace.deeds.iter().find_map(|deed| match &deed.deed {
            Deed::Asked(used) => Some((deed.step, *used)),
            _ => None,
        });
        let without_plan = [
            FailureCause::PlannerUnavailable,
            FailureCause::NotUnderstood,
        ];
        let planner = match (planned, first) {
            // An agent plans before it drives, and then reports what it asked.
            (Some(planned), Some((step, used))) if step == planned.step => used,
            // What has no plan reads no plates.
            (None, _) if trace.failed_by(&without_plan) => trace.models,
            _ => ModelUse::default(),
        };
        Self {
            planner,
            reader: trace.models.since(planner),
        }
    }
}

fn is_plan(deed: &Deed) -> bool {
    matches!(deed, Deed::Planned(_))
}

#[cfg(test)]
mod tests {
    use openbench_core::Plan;

    use super::*;
    use crate::trace::{Failure, TaskOutcome, TimedDeed};

    /// An episode that failed for a cause after some questions without an answer.
    fn unanswered(cause: FailureCause, calls: u32, failed: u32) -> EpisodeTrace {
        let failure = Failure {
            cause,
            detail: "connection refused".into(),
        };
        EpisodeTrace {
            tasks: vec![TaskOutcome::failed(0, failure)],
            models: ModelUse {
                calls,
                failed,
                ..ModelUse::default()
            },
            ..EpisodeTrace::default()
        }
    }

    #[test]
    fn a_run_ends_if_its_model_has_never_answered() {
        for (cause, fallback) in [
            (FailureCause::PlannerUnavailable, "planner=MODEL,OTHER"),
            (FailureCause::ReaderUnavailable, "reader=MODEL,OTHER"),
        ] {
            let reached = Reached::default();
            let error = reached.check(&unanswered(cause, 1, 1), 3).unwrap_err();
            let said = error.to_string();
            assert!(
                said.contains("connection refused") && said.contains(fallback),
                "{said}"
            );
            // A part that asks no model, and one whose model answered nonsense, fail deliveries.
            assert!(reached.check(&unanswered(cause, 0, 0), 3).is_ok());
            assert!(reached.check(&unanswered(cause, 2, 0), 3).is_ok());
            // Once it has answered, a silence fails a delivery only.
            assert!(reached.check(&unanswered(cause, 1, 1), 4).is_ok());
        }
        // What fails for another reason says nothing about the model.
        let stuck = unanswered(FailureCause::Stuck, 1, 1);
        assert!(Reached::default().check(&stuck, 0).is_ok());
    }

    #[test]
    fn a_planner_that_answers_does_not_stand_for_a_reader_that_never_does() {
        let plan = Plan {
            planner: "test".into(),
            deliveries: Vec::new(),
            fallbacks: Vec::new(),
        };
        let asked = ModelUse {
            calls: 2,
            ..ModelUse::default()
        };
        let mut episode = unanswered(FailureCause::ReaderUnavailable, 3, 1);
        let deeds = [Deed::Planned(plan), Deed::Asked(asked)];
        episode.deeds = deeds.map(|deed| TimedDeed { step: 0, deed }).into();
        let reached = Reached::default();
        let error = reached.check(&episode, 0).unwrap_err().to_string();
        assert!(error.contains("--set reader="), "{error}");
        // Nor does a reader stand for a planner.
        let mut read = unanswered(FailureCause::Stuck, 1, 0);
        read.deeds = episode.deeds[..1].into();
        let reached = Reached::default();
        reached.note(&read);
        let silent = unanswered(FailureCause::PlannerUnavailable, 1, 1);
        assert!(reached.check(&silent, 1).is_err());
        let silent = unanswered(FailureCause::ReaderUnavailable, 1, 1);
        assert!(reached.check(&silent, 2).is_ok());
        // A planner that answers without a plan has answered.
        let reached = Reached::default();
        reached.note(&unanswered(FailureCause::NotUnderstood, 1, 0));
        assert!(reached.check(&silent, 1).is_err());
        let silent = unanswered(FailureCause::PlannerUnavailable, 1, 1);
        assert!(reached.check(&silent, 2).is_ok());
    }
}
