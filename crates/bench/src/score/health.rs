//! What an agent reported about its own pose over time, beside the errors that it really had.

use openbench_core::Health;
use serde::{Deserialize, Serialize};

use crate::trace::PoseError;

/// A time in which an agent reported the same health at every pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HealthSpan {
    /// The first pose, simulated seconds.
    pub from_s: f64,
    /// The last pose, simulated seconds.
    pub to_s: f64,
    /// The reported health.
    pub health: Health,
    /// Maximum position error meanwhile, metres; null if an estimate was not finite.
    pub max_error_m: Option<f64>,
}

impl HealthSpan {
    fn of(error: &PoseError) -> Self {
        Self {
            from_s: error.time.seconds(),
            to_s: error.time.seconds(),
            health: error.health,
            max_error_m: Some(error.distance()).filter(|metres| metres.is_finite()),
        }
    }

    fn extend(&mut self, error: &PoseError) {
        let next = Self::of(error);
        self.to_s = next.to_s;
        self.max_error_m = self
            .max_error_m
            .zip(next.max_error_m)
            .map(|(a, b)| a.max(b));
    }
}

/// The spans of equal health of an episode, in the order of time.
pub fn health_spans(errors: &[PoseError]) -> Vec<HealthSpan> {
    let mut spans: Vec<HealthSpan> = Vec::new();
    for error in errors {
        match spans.last_mut() {
            Some(last) if last.health == error.health => last.extend(error),
            _ => spans.push(HealthSpan::of(error)),
        }
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::{Pose2, PoseEstimate, SimTime};

    fn error(seconds: u64, x: f64, health: Health) -> PoseError {
        let pose = Pose2::new(x, 0.0, 0.0);
        let time = SimTime::from_millis(1000 * seconds);
        PoseError::new(time, Pose2::default(), PoseEstimate { pose, health })
    }

    #[test]
    fn spans_end_where_the_health_changes() {
        let spans = health_spans(&[
            error(1, 0.1, Health::Good),
            error(2, -0.3, Health::Good),
            error(3, 4.0, Health::Lost),
            error(4, f64::NAN, Health::Lost),
            error(5, 0.2, Health::Good),
        ]);
        let found: Vec<_> = spans.iter().map(|s| (s.from_s, s.to_s, s.health)).collect();
        let expected = [
            (1.0, 2.0, Health::Good),
            (3.0, 4.0, Health::Lost),
            (5.0, 5.0, Health::Good),
        ];
        assert_eq!(found, expected);
        let errors: Vec<_> = spans.iter().map(|s| s.max_error_m).collect();
        assert_eq!(errors, [Some(0.3), None, Some(0.2)]);
        assert!(health_spans(&[]).is_empty());
    }
}
