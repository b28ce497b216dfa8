//! One episode driven by an agent.

use openbench_core::{Agent, Event};

use crate::BenchError;
use crate::run::rollout::{Rollout, Status};
use crate::trace::EpisodeTrace;

/// Lets an agent drive an episode to its end.
///
/// # Errors
/// The first error of the rollout's observers.
pub fn run_episode(
    mut rollout: Rollout<'_>,
    agent: &mut dyn Agent,
) -> Result<EpisodeTrace, BenchError> {
    let mut events = Vec::new();
    let begun = agent.begin(rollout.briefing(), &mut events);
    record(&mut rollout, &mut events);
    // A refusal is a result, not an error: all deliveries fail with its cause, and the run
    // continues.
    if let Err(give_up) = begun {
        rollout.refuse(&give_up);
    }
    while rollout.status() == Status::Running {
        let action = agent.act(&rollout.observation(), &mut events);
        // Before the step, so that an event has the time of the observation that caused it.
        record(&mut rollout, &mut events);
        rollout.step(action);
    }
    let map = agent.finish(&mut events);
    record(&mut rollout, &mut events);
    rollout.finish(map)
}

fn record(rollout: &mut Rollout<'_>, events: &mut Vec<Event>) {
    for event in events.drain(..) {
        rollout.record(event);
    }
}
