//! Fixes from LiDAR scans and the public map.

use std::sync::Arc;
use std::time::Duration;

use nalgebra::Isometry2;
use openbench_core::{LidarScan, MapComparison, Observation, Pose2, Pose3, Start};
use openbench_osm::OsmMap;

use super::estimate::{BuildingOffset, Estimate, Measured};
use super::locator::Locator;
use super::prior::Prior;
use super::stretch::{FIRST_SCANS, Gatherer};
use crate::deviation::PoseDeviation;
use crate::fixes::{Fix, FixSource, Presumption};
use crate::reckoned::rotating;
use crate::track::Track;

/// A fix of more standard deviations than this is an outlier.
const CREDIBLE: f64 = 4.0;

/// Finds the robot on the public map by the buildings around it.
///
/// A fix comes with each five metres of the way, once a pose is certain. It says what these five
/// metres add to what all before have said, so that fixes are independent of each other, although
/// they show the same displaced buildings.
pub struct Registrar {
    map: Arc<OsmMap>,
    start: Start,
    lidar: Pose3,
    locator: Locator,
    gatherer: Gatherer,
    /// Scans before the first look.
    scans: u16,
}

impl Registrar {
    /// For a robot with a LiDAR at this pose in `base_link`, and what is known about its start.
    pub fn new(map: Arc<OsmMap>, start: Start, lidar: Pose3) -> Self {
        Self {
            locator: Locator::new(Arc::clone(&map), &start),
            gatherer: Gatherer::new(lidar),
            scans: 0,
            map,
            start,
            lidar,
        }
    }

    /// The accepted pose, or else what is presumed.
    fn best(&self) -> Option<&Estimate> {
        self.locator.estimate().or(self.locator.presumed())
    }

    /// Begins with a look around.
    fn look_anew(&mut self) {
        self.gatherer.restart();
        self.scans = 0;
    }

    fn locate(&mut self, scan: &LidarScan, track: &dyn Track) -> Option<Measured> {
        let ended = self.gatherer.take(scan, track);
        self.scans = self.scans.saturating_add(1);
        match ended {
            Some(stretch) => self.locator.take(stretch),
            None if self.scans == FIRST_SCANS => self.locator.look(&self.gatherer.end()?),
            None => None,
        }
    }
}

impl FixSource for Registrar {
    fn name(&self) -> &str {
        "osm"
    }

    fn reset(&mut self) {
        *self = Self::new(Arc::clone(&self.map), self.start, self.lidar);
    }

    fn start_deviation(&self) -> Option<PoseDeviation> {
        Prior::new(&self.start).map(|prior| prior.deviation())
    }

    fn finds(&self) -> bool {
        true
    }

    fn is_lost(&self) -> bool {
        self.locator.is_lost()
    }

    fn lose(&mut self) {
        self.locator.lose();
        self.look_anew();
    }

    fn distrust(&mut self) {
        self.locator.distrust();
        self.look_anew();
    }

    fn map_registrations(&self) -> u64 {
        self.locator.comparisons()
    }

    fn comparison(&self) -> Option<MapComparison> {
        Some(self.locator.comparison())
    }

    fn presumption(&self) -> Option<Presumption> {
        self.best().map(|best| Presumption {
            odom: best.here,
            map: best.pose,
        })
    }

    fn building_offsets(&self) -> &[BuildingOffset] {
        offsets(self.locator.estimate())
    }

    fn presumed_offsets(&self) -> &[BuildingOffset] {
        offsets(self.best())
    }

    fn update(
        &mut self,
        observation: &Observation<'_>,
        _near: Pose2,
        track: &dyn Track,
    ) -> Option<Fix> {
        let scan = observation.scan?;
        let last = scan.points.iter().map(|point| point.offset_ns).max()?;
        let Measured { pose, information } = self.locate(scan, track)?;
        // From x, y of the map to forward, left.
        let turn = rotating(pose.yaw);
        Some(Fix {
            stamp: scan.stamp + Duration::from_nanos(u64::from(last)),
            pose: Isometry2::new(nalgebra::Vector2::new(pose.x, pose.y), pose.yaw),
            information: turn.transpose() * information * turn,
            max_deviations: CREDIBLE,
        })
    }
}

fn offsets(estimate: Option<&Estimate>) -> &[BuildingOffset] {
    estimate.map_or(&[], |estimate| estimate.offsets())
}

#[cfg(test)]
mod tests {
    use openbench_core::{Camera, Image, SimTime};

    use super::super::town::{SENSOR_M, Still, map, scan, village};
    use super::*;

    struct Blind;

    impl Camera for Blind {
        fn image(&self) -> Option<Arc<Image>> {
            None
        }
    }

    /// The fixes of a drive along the middle road, from a start that is known to three metres.
    fn fixes(registrar: &mut Registrar) -> Vec<(Pose2, Fix)> {
        let houses = village(7);
        let mut fixes = Vec::new();
        for i in 0..120 {
            let truth = Pose2::new(-40.0 + 0.4 * f64::from(i), 50.0, 0.0);
            let stamp = SimTime::from_millis(100 * i as u64);
            let scan = scan(&houses, truth, stamp);
            let observation = Observation {
                time: stamp,
                imu: &[],
                wheels: &[],
                scan: Some(&scan),
                gnss: None,
                camera: &Blind,
            };
            // Odometry begins at its own origin, a quarter turn away.
            let odom = Pose2::new(0.0, -0.4 * f64::from(i), -std::f64::consts::FRAC_PI_2);
            let fix = registrar.update(&observation, Pose2::default(), &Still(odom));
            fixes.extend(fix.map(|fix| (truth, fix)));
        }
        fixes
    }

    #[test]
    fn a_start_is_known_to_the_graph_as_it_is_to_the_search() {
        let map = Arc::new(map(&village(7)));
        let lidar = Pose3::translation(0.0, 0.0, SENSOR_M);
        let registrar = Registrar::new(map, Start::exact(Pose2::default()), lidar);
        let known = registrar.start_deviation().expect("it is known");
        assert!((known.metres - 3.0).abs() < 1e-9, "{known:?}");
    }

    #[test]
    fn fixes_are_where_the_robot_is_and_the_same_after_a_reset() {
        let start = Start::exact(Pose2::new(-41.0, 51.0, 0.03));
        let lidar = Pose3::translation(0.0, 0.0, SENSOR_M);
        let mut registrar = Registrar::new(Arc::new(map(&village(7))), start, lidar);
        let found = fixes(&mut registrar);
        assert!(found.len() >= 5, "{}", found.len());
        for (truth, fix) in &found {
            let at = fix.pose.translation.vector;
            let error = (at - nalgebra::Vector2::new(truth.x, truth.y)).norm();
            assert!(error < 0.3, "{error}");
            assert!(fix.pose.rotation.angle().abs() < 0.02);
            assert!(fix.information.symmetric_eigenvalues().min() >= 0.0);
        }
        registrar.reset();
        assert_eq!(fixes(&mut registrar), found);
    }
}
