//! How long the robot stands while models think.

use std::time::Duration;

use openbench_core::{Event, Events, ModelUse, SimTime};
use openbench_models::Meter;

/// What was asked of models, and until when the robot stands for it.
pub(super) struct Thinking {
    meter: Meter,
    is_charged: bool,
    /// What was reported so far.
    known: ModelUse,
    /// The robot stands before this.
    until: SimTime,
    /// How long it stands until then.
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

    /// Whether the robot stands.
    pub(super) fn lasts(&self, now: SimTime) -> bool {
        now < self.until
    }

    /// How long the robot stood since it last drove, told once.
    pub(super) fn ended(&mut self) -> Option<Duration> {
        Some(std::mem::take(&mut self.stands)).filter(|stood| !stood.is_zero())
    }

    /// Takes in what was asked at this instant.
    pub(super) fn account(&mut self, now: SimTime, events: &mut dyn Events) {
        let spent = self.meter.spent();
        if spent == self.known {
            return;
        }
        if self.is_charged {
            let took =
                Duration::from_millis(spent.latency_ms.saturating_sub(self.known.latency_ms));
            self.until = now.max(self.until) + took;
            self.stands += took;
        }
        self.known = spent;
        events.record(Event::Models(spent));
    }
}
