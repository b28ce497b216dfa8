//! The clusters of a scan: found in the map, and put into it.

use nalgebra::{Isometry3, Vector3};

use super::cluster::Cluster;
use super::cube_order::CubeOrder;
use super::gate::Viewpoint;
use super::search::{LeftOver, Search};
use crate::lio::noise::LidarNoise;
use crate::lio::noise_scale::NoiseScale;
use crate::lio::planes::{PlaneMap, Rays};
use crate::lio::state::{Covariance, State};

/// The clusters of a scan, in buffers that are used again for each scan.
#[derive(Debug, Clone, Default)]
pub struct Matching {
    /// What the last search found.
    pub clusters: Vec<Cluster>,
    /// Points in cubes with planes that lie on none of them.
    contradicting: usize,
    /// How noisy the LiDAR turns out to be. It changes weights, but not which points lie on a
    /// plane: a wider gate lets in what lies beside the plane.
    pub(in crate::lio) noise_scale: NoiseScale,
    scan: CubeOrder,
    left_over: LeftOver,
}

impl Matching {
    /// Searches for the planes of a scan's points, which are in the LiDAR's frame at the state's
    /// instant. Of the covariance only the pose's part counts. No point farther than `gate` metres
    /// from a plane lies on it.
    pub fn find(
        &mut self,
        state: &State,
        covariance: &Covariance,
        points: &[Vector3<f64>],
        map: &PlaneMap,
        noise: &LidarNoise,
        gate: f64,
    ) {
        let lidar = state.lidar_pose();
        let factor = self.noise_scale.factor();
        // Weights are inverse variances, and the factor is one of deviations.
        let certainty = 1.0 / (factor * factor);
        self.scan.sort(points, &lidar, &state.position);
        self.clusters.clear();
        let mut search = Search {
            view: Viewpoint {
                state,
                lidar,
                covariance,
                noise,
                gate,
                certainty,
            },
            scan: &self.scan,
            map,
            clusters: &mut self.clusters,
            contradicting: 0,
        };
        search.run(&mut self.left_over);
        self.contradicting = search.contradicting;
    }

    /// Share of points on planes among the points where planes are known; 1 where there are none.
    pub(in crate::lio) fn agreeing(&self) -> f64 {
        let on_planes = self
            .clusters
            .iter()
            .filter(|cluster| cluster.plane.is_some());
        let agreeing: f64 = on_planes.map(|cluster| cluster.points.weight).sum();
        let all = agreeing + self.contradicting as f64;
        if all > 0.0 { agreeing / all } else { 1.0 }
    }

    /// Adds the clusters to the map, with the scan at `state`. Returns which share of all points on
    /// the planes that were seen came with this scan.
    pub fn insert(&self, state: &State, map: &mut PlaneMap) -> f64 {
        let lidar = state.lidar_pose();
        let mut new = 0.0;
        let mut all = 0.0;
        for cluster in &self.clusters {
            let points = cluster.points.weight;
            // A full cube takes nothing: what is seen of it is known, and not new.
            if cluster.is_full {
                all += points;
            } else if let Some(share) = insert_cluster(cluster, &lidar, map) {
                new += share * points;
                all += points;
            }
        }
        if all > 0.0 { new / all } else { 0.0 }
    }
}

/// Adds a cluster to its cube. Returns which share of the cube's points it has, if that has a
/// plane. `lidar` is the LiDAR's pose in `odom`.
fn insert_cluster(cluster: &Cluster, lidar: &Isometry3<f64>, map: &mut PlaneMap) -> Option<f64> {
    let from_middle = lidar.translation.vector - cluster.place.middle;
    let motion = Isometry3::from_parts(from_middle.into(), lidar.rotation);
    let rays = match &cluster.plane {
        // The harmonic mean of the variances that the points are weighted by.
        Some(plane) => Rays::Corrected(cluster.points.weight / plane.weighted.weight),
        None => Rays::Uncorrected(lidar.rotation * cluster.points.mean()),
    };
    map.add(
        &cluster.place,
        &cluster.points.moved(&motion),
        rays,
        from_middle,
    )
}
