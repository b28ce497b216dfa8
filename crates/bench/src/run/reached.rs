//! Whether the models of a run can be reached at all.

use std::sync::atomic::{AtomicBool, Ordering};

use openbench_core::FailureCause;

use crate::BenchError;
use crate::trace::EpisodeTrace;

/// Whether a model has answered so far in any episode of a run.
#[derive(Debug, Default)]
pub(super) struct Reached(AtomicBool);

impl Reached {
    /// Notes whether a model answered in an episode.
    pub(super) fn note(&self, trace: &EpisodeTrace) {
        if trace.models.calls > trace.models.failed {
            // Relaxed suffices: the flag alone is shared, and it only ever rises.
            self.0.store(true, Ordering::Relaxed);
        }
    }

    /// Ends a run whose planner or reader asks a model that has never answered: all its deliveries
    /// would fail for a reason that says nothing about the model.
    ///
    /// # Errors
    /// [`BenchError::Unreachable`].
    pub(super) fn check(&self, trace: &EpisodeTrace, episode: usize) -> Result<(), BenchError> {
        self.note(trace);
        if trace.models.failed == 0 || self.0.load(Ordering::Relaxed) {
            return Ok(());
        }
        let failures = trace.tasks.iter().filter_map(|task| task.failure.as_ref());
        let unavailable = failures.filter_map(|failure| match failure.cause {
            FailureCause::PlannerUnavailable => Some(("planner", failure)),
            FailureCause::ReaderUnavailable => Some(("reader", failure)),
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

#[cfg(test)]
mod tests {
    use openbench_core::ModelUse;

    use super::*;
    use crate::trace::{Failure, TaskOutcome};

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
}
