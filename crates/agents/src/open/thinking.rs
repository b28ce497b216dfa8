//! How long the robot stands while models compute their answers.

use std::time::Duration;

use openbench_core::{Event, Events, ModelUse, SimTime};
use openbench_models::Meter;

/// What was asked of models, and until when the robot stands for it.
pub(super) struct Thinking {
    meter: Meter,
    is_charged: bool,
    /// What was reported so far.
    known: ModelUse,
    /// The robot stands until then.
    until: SimTime,
    /// How long it stands altogether since it last drove.
    stands: Duration,
}

impl Thinking {
    pub(super) fn new(meter: Meter, is_charged: bool) -> Self {
        Self {
            meter,
            is_charged,
            known: ModelUse::default(),
            until: SimTime::ZERO,
            stands: Duration::ZERO,
        }
    }

    /// Whether the robot stands at this instant.
    pub(super) fn lasts(&self, now: SimTime) -> bool {
        now < self.until
    }

    /// How long the robot stood since it last drove; `None` if it did not, or was asked before.
    pub(super) fn ended(&mut self) -> Option<Duration> {
        Some(std::mem::take(&mut self.stands)).filter(|stood| !stood.is_zero())
    }

    /// Accounts for what was asked of models since the last call.
    pub(super) fn account(&mut self, now: SimTime, events: &mut dyn Events) {
        let spent = self.meter.spent();
        if spent == self.known {
            return;
        }
        if self.is_charged {
            let took =
                Duration::from_millis(spent.latency_ms.saturating_sub(self.known.latency_ms));
            // From the end of a time that still lasts, so that questions asked in one instant add
            // up.
            self.until = now.max(self.until) + took;
            self.stands += took;
        }
        self.known = spent;
        events.record(Event::Models(spent));
    }
}
