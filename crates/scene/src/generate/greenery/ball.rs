//! Dented balls: crowns of trees, and shrubs.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Vector3};
use rand_pcg::Pcg64Mcg;

use crate::generate::seeds::between;
use crate::generate::shapes::Surface;
use crate::scene::{Corner, Layer, SceneBuilder};

/// A ball that is stretched upwards, metres.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ball {
    pub center: Point3<f64>,
    pub radius: f64,
    pub half_height: f64,
}

/// Directions of corners, and triangles as indices into them.
struct Sphere {
    points: Vec<Vector3<f64>>,
    faces: Vec<[u32; 3]>,
}

/// Builds a dented ball, visible only: an icosahedron, its faces divided in four `divisions` times.
pub(crate) fn ball(
    scene: &mut SceneBuilder,
    surface: Surface,
    Ball {
        center,
        radius,
        half_height,
    }: Ball,
    divisions: usize,
    rng: &mut Pcg64Mcg,
) {
    let mut sphere = Sphere::icosahedron();
    for _ in 0..divisions {
        sphere = sphere.divided();
    }
    let (sin, cos) = libm::sincos(between(rng, 0.0, TAU));
    let mut corner = |d: &Vector3<f64>| -> Corner {
        // Drawn once for each corner: neighbouring faces share it, so the ball stays closed however
        // deep the dents are.
        let dent = between(rng, 0.82, 1.12);
        let (x, y) = (cos * d.x - sin * d.y, sin * d.x + cos * d.y);
        let away = Vector3::new(
            x * radius * dent,
            y * radius * dent,
            d.z * half_height * dent,
        );
        let p = center + away;
        // Texture from the side that the surface faces; it may be stretched, since leaves have no
        // direction.
        let around = libm::atan2(y, x) * radius;
        let up = p.z + 0.3 * x;
        Corner::new(
            p,
            [(around / surface.tile) as f32, (up / surface.tile) as f32],
        )
    };
    let corners: Vec<Corner> = sphere.points.iter().map(&mut corner).collect();
    scene.mesh(Layer::Visible, surface.material, &corners, &sphere.faces);
}

impl Sphere {
    /// Two poles and two rings of five.
    fn icosahedron() -> Self {
        let mut points = vec![Vector3::z(), -Vector3::z()];
        let (z, r) = (1.0 / 5.0_f64.sqrt(), 2.0 / 5.0_f64.sqrt());
        for i in 0..10 {
            let (sin, cos) = libm::sincos(PI * f64::from(i) / 5.0);
            points.push(Vector3::new(
                r * cos,
                r * sin,
                if i % 2 == 0 { z } else { -z },
            ));
        }
        let ring = |i: u32| 2 + i % 10;
        let mut faces = Vec::new();
        for i in 0..5 {
            let k = 2 * i;
            faces.push([0, ring(k), ring(k + 2)]);
            faces.push([1, ring(k + 3), ring(k + 1)]);
            faces.push([ring(k), ring(k + 1), ring(k + 2)]);
            faces.push([ring(k + 1), ring(k + 3), ring(k + 2)]);
        }
        Self { points, faces }
    }

    /// Each face divided in four at the middles of its edges.
    fn divided(self) -> Self {
        let mut points = self.points;
        let mut middles = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            // Two faces share an edge, and its middle with it: the ball stays closed.
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        let mut faces = Vec::with_capacity(4 * self.faces.len());
        for [a, b, c] in self.faces {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            faces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        Self { points, faces }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_are_closed_and_face_outwards() {
        let Sphere { points, faces } = Sphere::icosahedron().divided();
        assert_eq!((points.len(), faces.len()), (42, 80));
        let mut edges = std::collections::BTreeSet::new();
        for [a, b, c] in faces {
            let [p, q, r] = [a, b, c].map(|i| points[i as usize]);
            assert!((q - p).cross(&(r - p)).dot(&p) > 0.0);
            edges.extend([(a, b), (b, c), (c, a)]);
        }
        assert!(edges.iter().all(|(a, b)| edges.contains(&(*b, *a))));
    }
}
