//! Global fixes: poses in `map`, from a source that does not drift.

use nalgebra::{Isometry2, Matrix3, UnitComplex, Vector2};
use openbench_core::{GnssFix, MapComparison, Observation, Pose2, SimTime};

use crate::deviation::PoseDeviation;
use crate::registration::BuildingOffset;
use crate::track::Track;

/// A measured pose in `map` at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Fix {
    /// When the robot was there.
    pub stamp: SimTime,
    /// Pose of `base_link`.
    pub pose: Isometry2<f64>,
    /// Inverse of the covariance, in the frame of `pose`: forward, left, yaw. Zero for what was
    /// not measured.
    pub information: Matrix3<f64>,
    /// A residual of more standard deviations than this makes the fix an outlier.
    pub max_deviations: f64,
}

impl Fix {
    /// Whether it contains neither NaN nor infinity, and could be true.
    pub(crate) fn is_sound(&self) -> bool {
        self.pose.translation.vector.iter().all(|x| x.is_finite())
            && self.pose.rotation.angle().is_finite()
            && self.information.iter().all(|x| x.is_finite())
            && self.max_deviations > 0.0
    }
}

/// Where a robot probably is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Presumption {
    /// Where it was by odometry,
    pub odom: Pose2,
    /// and where that probably is in `map`.
    pub map: Pose2,
}

/// A source of poses in `map`.
pub trait FixSource {
    /// Short name, as in results.
    fn name(&self) -> &str;

    /// Begins anew.
    fn reset(&mut self);

    /// How well the start is known in `map` as these fixes have it, if that is worse than it is
    /// given: a map may be displaced.
    fn start_deviation(&self) -> Option<PoseDeviation> {
        None
    }

    /// Whether it finds a robot by fixes that do not depend on where it is estimated to be.
    fn finds(&self) -> bool {
        false
    }

    /// Whether the robot turned out not to be where it was estimated, and was not found since.
    fn is_lost(&self) -> bool {
        false
    }

    /// Searches anew: the robot may have been carried away, or odometry lost its way.
    fn lose(&mut self) {}

    /// Odometry contradicted itself for a while: the robot may have been carried away, and what was
    /// seen before is not where odometry has it.
    fn distrust(&mut self) {}

    /// Where the robot probably is, by all that was seen. Other than a fix it may turn out wrong,
    /// and says nothing about how exact it is.
    fn presumption(&self) -> Option<Presumption> {
        None
    }

    /// How often it compared what was seen with a map.
    fn map_registrations(&self) -> u64 {
        0
    }

    /// What was found when it last compared what was seen with a map.
    fn comparison(&self) -> Option<MapComparison> {
        None
    }

    /// How far buildings are from where the map shows them, if the robot is where fixes say.
    fn building_offsets(&self) -> &[BuildingOffset] {
        &[]
    }

    /// The same if the robot is where the presumption says.
    fn presumed_offsets(&self) -> &[BuildingOffset] {
        &[]
    }

    /// Takes in sensor data. `near` is the estimated pose of the robot, and `track` where it was
    /// by odometry.
    fn update(
        &mut self,
        observation: &Observation<'_>,
        near: Pose2,
        track: &dyn Track,
    ) -> Option<Fix>;
}

/// A satellite fix of more standard deviations than this is an outlier.
const CREDIBLE: f64 = 3.0;
/// Receivers in streets underestimate their errors: the standard deviation is this many times what
/// they report,
const OPTIMISM: f64 = 2.0;
/// and no less than this, metres.
const MIN_DEVIATION_M: f64 = 2.0;
/// Errors from reflections last: one fix counts in this time, seconds.
const REFLECTION_S: f64 = 10.0;
/// Errors from the ionosphere and from satellites' orbits and clocks last half an hour (P. Misra,
/// P. Enge, *Global Positioning System*, chapter 5): all fixes of this time count as one at most,
/// seconds.
const SLOW_ERROR_S: f64 = 1800.0;

/// Satellite fixes with errors as in streets: larger than the receiver reports, and nearly the same
/// for a long time.
///
/// They bound the drift of odometry over hours. Where the start is known they say nothing new for a
/// long while.
#[derive(Debug, Clone, Default)]
pub struct Gnss {
    /// Position of the antenna in `base_link`, metres.
    antenna: Vector2<f64>,
    last: Option<SimTime>,
}

impl Gnss {
    /// A receiver whose antenna is there in `base_link`: metres forward and left.
    pub fn new(antenna: Vector2<f64>) -> Self {
        Self {
            antenna,
            last: None,
        }
    }

    fn fix(&mut self, fix: &GnssFix, now: SimTime, near: Pose2) -> Option<Fix> {
        // A stamp from the future would make all later ones come too late.
        if !is_finite(fix) || self.is_soon(fix.stamp) || fix.stamp > now {
            return None;
        }
        self.last = Some(fix.stamp);
        let deviation = deviation(fix);
        // One fix in ten seconds counts, and all fixes of half an hour count as one together.
        let information = 1.0 / (deviation * deviation) * REFLECTION_S / SLOW_ERROR_S;
        // The heading is not measured; it only says where the antenna is.
        let rotation = UnitComplex::new(near.yaw);
        let antenna = Vector2::new(fix.position[0], fix.position[1]);
        let position = antenna - rotation * self.antenna;
        Some(Fix {
            stamp: fix.stamp,
            pose: Isometry2::from_parts(position.into(), rotation),
            information: Matrix3::from_diagonal(&[information, information, 0.0].into()),
            // In the fix's own deviations, not in those that it counts with.
            max_deviations: CREDIBLE * libm::sqrt(REFLECTION_S / SLOW_ERROR_S),
        })
    }

    /// Whether the errors of a fix are those of the last one.
    fn is_soon(&self, stamp: SimTime) -> bool {
        self.last
            .is_some_and(|last| stamp <= last || stamp.since(last).as_secs_f64() < REFLECTION_S)
    }
}

fn is_finite(fix: &GnssFix) -> bool {
    fix.position
        .iter()
        .chain(fix.covariance.iter().flatten())
        .all(|x| x.is_finite())
}

/// Standard deviation of a fix along the ground, metres.
fn deviation(fix: &GnssFix) -> f64 {
    let variance = fix.covariance[0][0].max(fix.covariance[1][1]).max(0.0);
    (variance.sqrt() * OPTIMISM).max(MIN_DEVIATION_M)
}

impl FixSource for Gnss {
    fn name(&self) -> &str {
        "gnss"
    }

    fn reset(&mut self) {
        self.last = None;
    }

    fn update(
        &mut self,
        observation: &Observation<'_>,
        near: Pose2,
        _track: &dyn Track,
    ) -> Option<Fix> {
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
    fn a_receiver_counts_now_and_then_and_less_than_it_reports() {
        let mut gnss = Gnss::new(Vector2::new(0.5, 0.0));
        let near = Pose2::new(9.0, 2.0, std::f64::consts::FRAC_PI_2);
        let now = SimTime::from_millis(30_000);
        let first = gnss.fix(&fix(100, 10.0, 0.5), now, near).unwrap();
        assert!((first.pose.translation.vector - Vector2::new(10.0, 1.5)).norm() < 1e-12);
        // A fix of 2 m counts for a 180th of that. It is an outlier beyond three times as far.
        let information = first.information[(0, 0)];
        assert!((information - 0.25 / 180.0).abs() < 1e-12);
        assert_eq!(first.information[(2, 2)], 0.0);
        assert!((first.max_deviations / information.sqrt() - 6.0).abs() < 1e-9);
        assert!(
            gnss.fix(&fix(5_000, 11.0, 5.0), now, near).is_none(),
            "too soon"
        );
        assert!(
            gnss.fix(&fix(40_000, 11.0, 5.0), now, near).is_none(),
            "from the future"
        );
        assert!(gnss.fix(&fix(20_000, f64::NAN, 5.0), now, near).is_none());
        let later = gnss.fix(&fix(20_000, 11.0, 5.0), now, near).unwrap();
        assert!((later.information[(0, 0)] - 0.01 / 180.0).abs() < 1e-12);
        assert!(
            gnss.fix(&fix(10_000, 11.0, 5.0), now, near).is_none(),
            "backwards"
        );
    }
}
