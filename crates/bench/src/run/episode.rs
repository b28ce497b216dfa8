//! One episode driven by an agent.

use openbench_core::{Agent, Event};

use super::computing;
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
    if let Err(give_up) = begun {
        record(&mut rollout, &mut events);
        // A refusal is a result, not an error: all deliveries fail with its cause, and the run
        // continues.
        rollout.refuse(&give_up);
    } else if rollout.is_computing_charged() {
        computing::drive(&mut rollout, agent, std::mem::take(&mut events));
    } else {
        record(&mut rollout, &mut events);
        drive(&mut rollout, agent);
    }
    let map = agent.finish(&mut events);
    record(&mut rollout, &mut events);
    rollout.finish(map)
}

/// Computing takes no time: each decision takes effect at once.
fn drive(rollout: &mut Rollout<'_>, agent: &mut dyn Agent) {
    let mut events = Vec::new();
    while rollout.status() == Status::Running {
        let action = agent.act(&rollout.observation(), &mut events);
        // Before the step, so that an event has the time of the observation that caused it.
        record(rollout, &mut events);
        rollout.step(action);
    }
}

fn record(rollout: &mut Rollout<'_>, events: &mut Vec<Event>) {
    for event in events.drain(..) {
        rollout.record(event);
    }
}
