//! Who watches an episode without driving it: a recorder, a report, a live view.

use openbench_core::{Event, SimTime, Velocity};
use openbench_sim::Simulator;

use crate::BenchError;

/// Watches an episode.
pub trait Observer: Send {
    /// Called before the first step.
    fn begin(&mut self, simulator: &Simulator) -> Result<(), BenchError> {
        let _ = simulator;
        Ok(())
    }

    /// Called after each step with the velocity that was asked for.
    fn step(&mut self, simulator: &Simulator, velocity: Velocity) -> Result<(), BenchError> {
        let _ = (simulator, velocity);
        Ok(())
    }

    /// Called for each event that an agent tells of.
    fn event(&mut self, time: SimTime, event: &Event) -> Result<(), BenchError> {
        let _ = (time, event);
        Ok(())
    }
}
