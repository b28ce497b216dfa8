//! Cubes of the map searched for planes, from the largest to the smallest.

use nalgebra::{Point3, SMatrix, Vector3};

use super::cluster::{Cluster, PlaneObservation};
use super::cube_order::{CubeOrder, cubes, point_number};
use super::gate::{Gate, Viewpoint};
use crate::lio::moments::Moments;
use crate::lio::planes::{Place, Plane, PlaneMap, SIZES};

/// Buffers for the points that are left over at each size.
pub(super) type LeftOver = [Vec<u64>; SIZES];

/// A search, and what it has found.
pub(super) struct Search<'a> {
    pub(super) view: Viewpoint<'a>,
    pub(super) scan: &'a CubeOrder,
    pub(super) map: &'a PlaneMap,
    pub(super) clusters: &'a mut Vec<Cluster>,
    /// Points in cubes with planes that lie on none of them.
    pub(super) contradicting: usize,
}

impl Search<'_> {
    /// Searches for the planes of all points.
    pub(super) fn run(&mut self, left_over: &mut LeftOver) {
        let scan = self.scan;
        self.cubes(&scan.keys, 0, false, left_over);
    }

    /// Searches the cubes of a size; `has_met_plane` if there is a plane in the larger cube round
    /// them.
    fn cubes(
        &mut self,
        keys: &[u64],
        size: usize,
        has_met_plane: bool,
        left_over: &mut [Vec<u64>],
    ) {
        for cube in cubes(keys, size) {
            self.cube(cube, size, has_met_plane, left_over);
        }
    }

    /// Points on the cube's plane make a cluster. The others, all if it has none, are searched for
    /// in smaller cubes.
    fn cube(&mut self, keys: &[u64], size: usize, has_met_plane: bool, left_over: &mut [Vec<u64>]) {
        let first = self.scan.places[point_number(keys[0])];
        let Some(place) = Place::of(first, size) else {
            return;
        };
        // One buffer for each size: smaller cubes fill theirs while this one is still read.
        let (mine, below) = left_over.split_at_mut(1);
        let rest = &mut mine[0];
        rest.clear();
        let mut points = Moments::default();
        let content = self.map.look_up(&place, self.view.lidar.translation.vector);
        let is_full = content.is_some_and(|content| content.is_full);
        let plane = content.and_then(|content| content.plane);
        let observed = plane.map(|plane| self.observe(plane, keys, &mut points, rest));
        // A cube without a plane collects all points, and so do the smaller ones in it: which of
        // them will have a plane is not known yet.
        if observed.is_none() {
            for key in keys {
                points.add(self.scan.points[point_number(*key)], 1.0);
            }
        }
        let has_met_plane = has_met_plane || observed.is_some();
        let next = if observed.is_some() { &rest[..] } else { keys };
        if points.weight > 0.0 {
            self.clusters.push(Cluster {
                place,
                points,
                plane: observed,
                is_full,
            });
        }
        if size + 1 < SIZES {
            self.cubes(next, size + 1, has_met_plane, below);
        } else if has_met_plane {
            self.contradicting += next.len();
        }
    }

    /// The cube's plane as the scan sees it. Points that lie on it go into `points`, the others
    /// into `rest`.
    fn observe(
        &self,
        plane: &Plane,
        keys: &[u64],
        points: &mut Moments,
        rest: &mut Vec<u64>,
    ) -> PlaneObservation {
        let first = self.scan.places[point_number(keys[0])];
        let gate = Gate::new(&self.view, plane, first);
        let mut weighted = Moments::default();
        for key in keys {
            match gate.pass(&self.scan.points[point_number(*key)]) {
                Some(inlier) => {
                    weighted.add(inlier.point, inlier.weight);
                    points.add(inlier.point, 1.0);
                }
                None => rest.push(*key),
            }
        }
        let middle = self.view.lidar * Point3::from(points.mean());
        let errors = plane.errors();
        PlaneObservation {
            normal: plane.normal,
            offset: plane.normal.dot(&plane.middle),
            weighted,
            shared: plane.variance(middle.coords),
            errors: self.errors_on_lidar(plane),
            known: errors.map(|error| 1.0 / error.variance).into(),
            normal_covariance: plane.normal_covariance(),
        }
    }

    /// The plane's errors as rows that (p, 1) is multiplied by, p being in the LiDAR's frame.
    fn errors_on_lidar(&self, plane: &Plane) -> SMatrix<f64, 3, 4> {
        let from_middle: Vector3<f64> = self.view.lidar.translation.vector - plane.middle;
        let rows = plane.errors().map(|error| {
            let along = self.view.lidar.rotation.inverse() * error.along;
            along
                .push(error.shift + error.along.dot(&from_middle))
                .transpose()
        });
        SMatrix::from_rows(&rows)
    }
}
