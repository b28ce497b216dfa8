//! Global fixes: where the robot is in `map`, from something that does not drift.

use nalgebra::{Isometry2, Matrix3, UnitComplex, Vector2};
use openbench_core::{GnssFix, Observation, Pose2, SimTime};

/// A pose in `map` at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Fix {
    /// When the robot was there.
    pub stamp: SimTime,
    /// Of `base_link`.
    pub pose: Isometry2<f64>,
    /// One over covariance, in the frame of `pose`: forward, left, turn. Zero for what was not measured.
    pub information: Matrix3<f64>,
    /// Deviations beyond which it is thought to be false.
    pub credible: f64,
}

/// Something that tells where the robot is in `map`.
pub trait FixSource {
    /// Short name, as in results.
    fn name(&self) -> &str;

    /// Begins anew.
    fn reset(&mut self);

    /// Takes in what the sensors delivered; `near` is where the robot is thought to be.
    fn update(&mut self, observation: &Observation<'_>, near: Pose2) -> Option<Fix>;
}

/// Deviations beyond which a satellite fix is thought to be false.
const CREDIBLE: f64 = 3.0;
/// Receivers in streets think too well of themselves: their deviation is so many times what they say, and no less than that, metres.
const OPTIMISM: f64 = 2.0;
const BEST: f64 = 2.0;
/// Errors from reflections last: a fix counts once in that time, seconds.
const REFLECTED: f64 = 10.0;
/// Those from the ionosphere and from satellites' orbits and clocks last half an hour (P. Misra, P. Enge, *Global Positioning System*, chapter 5): all fixes of that time together count as one at most.
const SLOW: f64 = 1800.0;

/// Satellite fixes with errors as in streets: larger than the receiver says, and much the same for a long time. They bound how far odometry drifts in hours; where the start is known they say
/// nothing new for a long while.
#[derive(Debug, Clone, Default)]
pub struct Gnss {
    /// Of the antenna in `base_link`, metres.
    antenna: Vector2<f64>,
    last: Option<SimTime>,
}

impl Gnss {
    /// With the antenna there in `base_link`, metres forward and left.
    pub fn new(antenna: Vector2<f64>) -> Self {
        Self {
            antenna,
            last: None,
        }
    }

    fn fix(&mut self, fix: &GnssFix, now: SimTime, near: Pose2) -> Option<Fix> {
        let sound = fix
            .position
            .iter()
            .chain(fix.covariance.iter().flatten())
            .all(|x| x.is_finite());
        let soon = self.last.is_some_and(|last| {
            fix.stamp <= last || fix.stamp.since(last).as_secs_f64() < REFLECTED
        });
        // A stamp from the future would make all that follow come too late.
        if !sound || soon || fix.stamp > now {
            return None;
        }
        self.last = Some(fix.stamp);
        let said = fix.covariance[0][0]
            .max(fix.covariance[1][1])
            .max(0.0)
            .sqrt();
        let deviation = (said * OPTIMISM).max(BEST);
        let level = 1.0 / (deviation * deviation) * REFLECTED / SLOW;
        // The heading is not measured; it only says where the antenna is.
        let turned = UnitComplex::new(near.yaw);
        let at = Vector2::new(fix.position[0], fix.position[1]) - turned * self.antenna;
        Some(Fix {
            stamp: fix.stamp,
            pose: Isometry2::from_parts(at.into(), turned),
            information: Matrix3::from_diagonal(&[level, level, 0.0].into()),
            // Of the fix's own deviations, not of those that it counts with.
            credible: CREDIBLE * libm::sqrt(REFLECTED / SLOW),
        })
    }
}

impl FixSource for Gnss {
    fn name(&self) -> &str {
        "gnss"
    }

    fn reset(&mut self) {
        self.last = None;
    }

    fn update(&mut self, observation: &Observation<'_>, near: Pose2) -> Option<Fix> {
        self.fix(observation.gnss?, observation.time, near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fix(millis: u64, x: f64, deviation: f64) -> GnssFix {
        let square = deviation * deviation;
        GnssFix {
            stamp: SimTime::from_millis(millis),
            position: [x, 2.0, 50.0],
            covariance: [[square, 0.0, 0.0], [0.0, square, 0.0], [0.0, 0.0, square]],
            satellites: 8,
        }
    }

    #[test]
    fn a_receiver_is_believed_now_and_then_and_less_than_it_says() {
        let mut gnss = Gnss::new(Vector2::new(0.5, 0.0));
        let near = Pose2::new(9.0, 2.0, std::f64::consts::FRAC_PI_2);
        let first = gnss
            .fix(&fix(100, 10.0, 0.5), SimTime::from_millis(30_000), near)
            .unwrap();
        assert!((first.pose.translation.vector - Vector2::new(10.0, 1.5)).norm() < 1e-12);
        // A fix of 2 m counts for a 180th of that; it is false beyond three times as far.
        assert!(
            (first.information[(0, 0)] - 0.25 / 180.0).abs() < 1e-12
                && first.information[(2, 2)] == 0.0
        );
        assert!((first.credible / first.information[(0, 0)].sqrt() - 6.0).abs() < 1e-9);
        assert!(
            gnss.fix(&fix(5_000, 11.0, 5.0), SimTime::from_millis(30_000), near)
                .is_none(),
            "too soon"
        );
        assert!(
            gnss.fix(&fix(40_000, 11.0, 5.0), SimTime::from_millis(30_000), near)
                .is_none(),
            "from the future"
        );
        assert!(
            gnss.fix(
                &fix(20_000, f64::NAN, 5.0),
                SimTime::from_millis(30_000),
                near
            )
            .is_none()
        );
        let later = gnss
            .fix(&fix(20_000, 11.0, 5.0), SimTime::from_millis(30_000), near)
            .unwrap();
        assert!((later.information[(0, 0)] - 0.01 / 180.0).abs() < 1e-12);
        assert!(
            gnss.fix(&fix(10_000, 11.0, 5.0), SimTime::from_millis(30_000), near)
                .is_none(),
            "backwards"
        );
    }
}
