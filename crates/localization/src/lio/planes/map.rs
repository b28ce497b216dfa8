//! The map of all cubes.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::cube::{Cube, Rays, View};
use super::place::{ByCube, Place, SIDES_M, SIZES, is_near};
use super::plane::Plane;
use crate::lio::moments::Moments;
use crate::lio::noise::LidarNoise;

type Cubes = ByCube<Cube>;

/// The map.
///
/// A surface is seen from one side. Where the LiDAR is behind a cube's plane, the points that it
/// sees are not on that surface, however near they are to it. Beside the corner of a house, the
/// points of one wall near the edge would pass for points of the other, all on the same side of it,
/// and would pull the pose along. What is seen from behind therefore has cubes of its own.
#[derive(Debug, Clone)]
pub struct PlaneMap {
    /// By their size.
    cubes: [Cubes; SIZES],
    /// What is seen of cubes from behind their planes.
    backs: [Cubes; SIZES],
    noise: LidarNoise,
}

/// What is known of a cube.
#[derive(Debug, Clone, Copy)]
pub(in crate::lio) struct Content<'a> {
    /// The plane of its points, if they lie on one.
    pub(in crate::lio) plane: Option<&'a Plane>,
    /// Whether there is a plane and the cube takes no more points. A cube without a plane is never
    /// full: its points are not part of what is known.
    pub(in crate::lio) is_full: bool,
}

impl PlaneMap {
    /// An empty map for the points of a LiDAR.
    pub fn new(noise: LidarNoise) -> Self {
        Self {
            cubes: Default::default(),
            backs: Default::default(),
            noise,
        }
    }

    /// Takes in points of one cube; they and `lidar`, where the LiDAR was, are relative to its
    /// middle. Returns which share of the cube's points these are, if it has a plane.
    pub(in crate::lio) fn add(
        &mut self,
        place: &Place,
        points: &Moments,
        rays: Rays,
        lidar: Vector3<f64>,
    ) -> Option<f64> {
        let front = self.cubes[place.size].entry(place.number).or_default();
        let cube = if front.is_seen_from_behind(lidar + place.middle) {
            self.backs[place.size].entry(place.number).or_default()
        } else {
            front
        };
        let before = cube.count();
        cube.add(
            points,
            rays,
            View {
                middle: place.middle,
                lidar,
            },
            &self.noise,
        );
        cube.plane().map(|_| (cube.count() - before) / cube.count())
    }

    /// The plane of a cube as seen from where the LiDAR is, if its points lie on one.
    pub fn plane(&self, place: &Place, lidar: Vector3<f64>) -> Option<&Plane> {
        self.look_up(place, lidar)?.plane
    }

    /// What is known of a cube as seen from where the LiDAR is; `None` without points.
    pub(in crate::lio) fn look_up(
        &self,
        place: &Place,
        lidar: Vector3<f64>,
    ) -> Option<Content<'_>> {
        let mut cube = self.cubes[place.size].get(&place.number)?;
        if cube.is_seen_from_behind(lidar) {
            cube = self.backs[place.size].get(&place.number)?;
        }
        Some(Content {
            plane: cube.plane(),
            is_full: cube.is_full(),
        })
    }

    /// Drops all cubes that are farther than `distance` metres from a place along some axis.
    pub fn forget(&mut self, place: Vector3<f64>, distance: f64) {
        // Once for the cubes and once for the backs.
        let sides = SIDES_M.iter().chain(&SIDES_M);
        for (cubes, side) in self.cubes.iter_mut().chain(&mut self.backs).zip(sides) {
            cubes.retain(|number, _| is_near(*number, *side, place, distance));
        }
    }

    /// Number of cubes of all sizes.
    pub fn len(&self) -> usize {
        self.cubes.iter().chain(&self.backs).map(HashMap::len).sum()
    }

    /// Whether it is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lio::planes::plane::EVENNESS_M;

    /// Where the LiDAR is in most tests.
    const LIDAR: Vector3<f64> = Vector3::new(5.0, 4.0, 3.0);
    const NOISE: LidarNoise = LidarNoise {
        range: 0.01,
        angle: 0.001,
    };

    fn add(map: &mut PlaneMap, point: Vector3<f64>, lidar: Vector3<f64>) {
        for place in (0..SIZES).filter_map(|size| Place::of(point, size)) {
            let mut points = Moments::default();
            points.add(point - place.middle, 1.0);
            map.add(&place, &points, Rays::Corrected(0.0), lidar - place.middle);
        }
    }

    /// The plane at a point, of the largest cube that has one.
    fn plane(map: &PlaneMap, point: Vector3<f64>, lidar: Vector3<f64>) -> Option<&Plane> {
        (0..SIZES).find_map(|size| map.plane(&Place::of(point, size)?, lidar))
    }

    /// Points on a slope, some of them up to four millimetres off it.
    fn slope() -> PlaneMap {
        let mut map = PlaneMap::new(LidarNoise {
            range: 0.003,
            angle: 0.001,
        });
        for i in 0..4000 {
            let x = f64::from(i % 63) / 21.0 - 1.5;
            let y = f64::from(i / 63) / 21.0 - 1.5;
            let off = f64::from(i * 7 % 5 - 2) * 0.002;
            add(&mut map, Vector3::new(x, y, 0.1 * x + 0.3 + off), LIDAR);
        }
        map
    }

    #[test]
    fn points_on_a_slope_make_its_plane() {
        let map = slope();
        let found = plane(&map, Vector3::new(0.4, -0.3, 0.33), LIDAR).unwrap();
        let normal = Vector3::new(-0.1, 0.0, 1.0).normalize();
        assert!(
            (found.normal.dot(&normal).abs() - 1.0).abs() < 1e-5,
            "{found:?}"
        );
        assert!(found.distance(Vector3::new(0.4, -0.3, 0.34)).abs() < 1e-3);
        // 1.4 times two millimetres.
        let thickness = found.thickness.sqrt();
        assert!((thickness - 0.0028).abs() < 5e-4, "{thickness}");
        let in_middle = found.variance(found.middle);
        assert!((EVENNESS_M..EVENNESS_M + 1e-3).contains(&in_middle.sqrt()));
        assert!(found.variance(found.middle + found.along[0]) > in_middle);
        assert!(plane(&map, Vector3::new(5.0, 0.0, 0.5), LIDAR).is_none());
    }

    #[test]
    fn distant_cubes_are_forgotten_and_impossible_points_are_not_added() {
        let mut map = slope();
        let before = map.len();
        add(&mut map, Vector3::new(f64::NAN, 0.0, 0.0), LIDAR);
        add(&mut map, Vector3::new(1e9, 0.0, 0.0), LIDAR);
        assert_eq!(map.len(), before);
        map.forget(Vector3::new(0.0, 0.0, 0.0), 1.0);
        assert!(map.len() < before);
        assert!(plane(&map, Vector3::new(0.4, -0.3, 0.34), LIDAR).is_some());
        map.forget(Vector3::new(100.0, 0.0, 0.0), 50.0);
        assert!(map.is_empty());
    }

    #[test]
    fn a_corner_has_planes_in_small_cubes_only() {
        let mut map = PlaneMap::new(NOISE);
        for i in 0..10_000 {
            // All over the walls, as rays are.
            let i = i * 7919 % 10_000;
            let a = f64::from(i % 100) / 100.0;
            let b = f64::from(i / 100) / 100.0;
            add(&mut map, Vector3::new(a, b, 0.005), LIDAR);
            add(&mut map, Vector3::new(0.005, a, b), LIDAR);
        }
        // The largest cube has points of both.
        let middle = Vector3::new(0.5, 0.5, 0.5);
        assert!(map.plane(&Place::of(middle, 0).unwrap(), LIDAR).is_none());
        let wall = plane(&map, Vector3::new(0.005, 0.6, 0.6), LIDAR).unwrap();
        assert!(wall.normal.x.abs() > 0.99);
        let floor = plane(&map, Vector3::new(0.6, 0.6, 0.005), LIDAR).unwrap();
        assert!(floor.normal.z.abs() > 0.99);
    }

    /// Adds points of a wall along x, seen from a place.
    fn add_wall(map: &mut PlaneMap, y: f64, lidar: Vector3<f64>) {
        for i in 0..2500 {
            let x = f64::from(i % 50) / 25.0;
            let z = f64::from(i / 50) / 25.0;
            add(map, Vector3::new(x, y, z), lidar);
        }
    }

    #[test]
    fn a_wall_has_two_sides() {
        let mut map = PlaneMap::new(NOISE);
        let front = Vector3::new(0.0, 5.0, 0.7);
        let behind = Vector3::new(0.0, -5.0, 0.7);
        let middle = Vector3::new(0.9, 0.5, 0.9);
        add_wall(&mut map, 0.50, front);
        let before = *plane(&map, middle, front).unwrap();
        assert!(before.normal.y > 0.99, "{before:?}");
        assert!(plane(&map, middle, behind).is_none());
        // The other side of the wall is 4 cm farther back.
        add_wall(&mut map, 0.46, behind);
        assert_eq!(plane(&map, middle, front), Some(&before));
        let back = plane(&map, middle, behind).unwrap();
        assert!(back.normal.y < -0.99, "{back:?}");
        assert!((back.middle.y - 0.46).abs() < 1e-6, "{back:?}");
    }
}
