//! How time passes in the simulator.

/// Simulated time between two observations, nanoseconds.
pub const OBSERVATION_NS: u64 = 50_000_000;
/// Physics step, nanoseconds: 400 Hz.
pub const STEP_NS: u64 = 2_500_000;
