//! Passive observers of an episode: a recorder, a report, a live view.

use openbench_core::{Event, SimTime, Velocity};
use openbench_sim::Simulator;

use crate::BenchError;

/// A passive observer of an episode. An error of an observer ends the episode.
pub trait Observer: Send {
    /// Called before the first step.
    fn begin(&mut self, simulator: &Simulator) -> Result<(), BenchError> {
        let _ = simulator;
        Ok(())
    }

    /// Called after each step of 50 ms with the commanded velocity.
    fn step(&mut self, simulator: &Simulator, velocity: Velocity) -> Result<(), BenchError> {
        let _ = (simulator, velocity);
        Ok(())
    }

    /// Called for each event that the agent reports, with the simulated time.
    fn event(&mut self, time: SimTime, event: &Event) -> Result<(), BenchError> {
        let _ = (time, event);
        Ok(())
    }
}
