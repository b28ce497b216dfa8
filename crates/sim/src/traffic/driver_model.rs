//! How drivers accelerate: the intelligent driver model.
//!
//! M. Treiber, A. Hennecke and D. Helbing, *Congested traffic states in empirical observations and
//! microscopic simulations*, Phys. Rev. E 62, 2000, arXiv cond-mat/0002177; with exponent 4 and, as
//! usual, without its term of the square root of speed. The numbers are ours, for streets rather
//! than motorways.

/// Largest acceleration, m/s².
pub(super) const ACCELERATION: f64 = 1.5;
/// Comfortable deceleration, m/s².
pub(super) const COMFORTABLE: f64 = 2.0;
/// Hardest braking, m/s²: on dry asphalt.
pub(super) const HARDEST: f64 = 8.0;
/// Time behind the car ahead, seconds.
const HEADWAY_S: f64 = 1.2;
/// Distance to the car ahead at rest, metres.
pub(super) const AT_REST_M: f64 = 1.5;

/// An obstacle or a road user ahead.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leader {
    /// Free distance to it, metres.
    pub gap: f64,
    /// Its speed along the lane, m/s.
    pub speed: f64,
}

/// Acceleration without a leader, m/s²: `a (1 - (v / v0)^4)`. Above the limit, speed returns to it
/// briskly; this part is ours.
pub(super) fn free(speed: f64, limit: f64) -> f64 {
    if speed > limit {
        // The model's fourth power would brake without bound far above a limit that falls ahead.
        return ((limit - speed) / 0.5).max(-COMFORTABLE * 1.5);
    }
    let share = speed / limit.max(0.1);
    ACCELERATION * (1.0 - share * share * share * share)
}

/// Acceleration behind a leader, m/s²: `a (1 - (v / v0)^4 - (s* / s)²)` with
/// `s* = s0 + v T + v dv / (2 sqrt(a b))`. The sum of the last two terms is kept from falling below
/// zero (M. Treiber and A. Kesting, *Traffic Flow Dynamics*, 2013), so nobody brakes for a leader
/// that drives away.
pub(super) fn behind(speed: f64, limit: f64, leader: Leader) -> f64 {
    let approach = speed * (speed - leader.speed) / (2.0 * (ACCELERATION * COMFORTABLE).sqrt());
    let desired = AT_REST_M + (speed * HEADWAY_S + approach).max(0.0);
    // Hulls that touch have no gap to divide by. Callers bound the braking that results.
    let share = desired / leader.gap.max(0.05);
    free(speed, limit) - ACCELERATION * share * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn behind_a_steady_leader_the_gap_is_that_of_the_equilibrium() {
        // (s0 + v T) / sqrt(1 - (v / v0)^4) at half the limit.
        let gap = (AT_REST_M + 5.0 * HEADWAY_S) / (1.0_f64 - 0.0625).sqrt();
        let at = |gap: f64| behind(5.0, 10.0, Leader { gap, speed: 5.0 });
        assert!(at(gap).abs() < 1e-12 && at(gap - 1.0) < -0.1 && at(gap + 1.0) > 0.1);
    }

    #[test]
    fn before_a_wall_a_car_brakes_gently_and_stops_short_of_it() {
        let (mut speed, mut gap, mut hardest) = (8.0_f64, 100.0, 0.0_f64);
        for _ in 0..1200 {
            let acceleration = behind(speed, 8.0, Leader { gap, speed: 0.0 });
            hardest = hardest.min(acceleration);
            speed = (speed + 0.05 * acceleration).max(0.0);
            gap -= 0.05 * speed;
        }
        assert!(hardest > -1.5 * COMFORTABLE, "{hardest}");
        let near = (0.9 * AT_REST_M..1.5 * AT_REST_M).contains(&gap);
        assert!(speed < 0.05 && near, "{speed} {gap}");
    }

    #[test]
    fn nobody_brakes_for_a_leader_that_drives_away() {
        assert!(
            behind(
                5.0,
                10.0,
                Leader {
                    gap: 20.0,
                    speed: 15.0
                }
            ) > 1.3
        );
    }
}
