//! Steps of simulated time.

/// Simulated time between two observations, nanoseconds: 20 Hz.
pub const OBSERVATION_NS: u64 = 50_000_000;
/// Physics step, nanoseconds: 400 Hz.
pub(crate) const STEP_NS: u64 = 2_500_000;
