//! Trees: round, wide, slender ones, birches and conifers.

use nalgebra::{Point3, Vector3};
use openbench_core::MapPoint;
use rand_pcg::Pcg64Mcg;

use super::Site;
use super::clearance::OBJECT;
use super::seeds::{between, pick};
use super::shapes::{Corner, Surface, at, prism};
use crate::material::SemanticClass;
use crate::scene::{Layer, SceneBuilder};

/// The form of a broadleaved tree.
#[derive(Debug, Clone, Copy)]
enum Form {
    Round,
    /// Several crowns beside each other.
    Wide,
    Slender,
    Birch,
}

/// Trunk and crown of a tree, metres.
struct Build {
    bark: Surface,
    girth: f64,
    trunk: f64,
    radius: f64,
    half: f64,
}

impl Site {
    /// A tree that stands on `p`.
    pub(super) fn tree(&mut self, p: MapPoint, conifer: bool, rng: &mut Pcg64Mcg) {
        if self.is_full() {
            return;
        }
        self.builder.object("tree", SemanticClass::Vegetation);
        let girth = between(rng, 0.11, 0.19);
        if conifer {
            self.conifer(p, girth, rng);
        } else {
            self.broadleaf(p, girth, rng);
        }
        self.clearance.add(p, p, girth, OBJECT);
    }

    fn conifer(&mut self, p: MapPoint, girth: f64, rng: &mut Pcg64Mcg) {
        let height = between(rng, 5.0, 9.5);
        let bark = self.palette.bark;
        prism(
            &mut self.builder,
            Layer::Both,
            bark,
            (p, 6),
            ((0.0, 1.2), (girth, girth * 0.9)),
        );
        let needles = pick(rng, &self.palette.needles);
        let width = height * between(rng, 0.17, 0.25);
        let tiers = if self.detailed { 5 } else { 3 };
        for tier in 0..tiers {
            let share = f64::from(tier) / f64::from(tiers);
            let reach = (share + 1.5 / f64::from(tiers)).min(1.0);
            let z = (
                0.9 + share * (height - 0.9) * 0.85,
                0.9 + reach * (height - 0.9),
            );
            let radius = width * (1.0 - 0.78 * share) * between(rng, 0.88, 1.08);
            prism(
                &mut self.builder,
                Layer::Visible,
                needles,
                (p, 8),
                (z, (radius, 0.0)),
            );
        }
    }

    fn broadleaf(&mut self, p: MapPoint, girth: f64, rng: &mut Pcg64Mcg) {
        let form = pick(
            rng,
            &[
                Form::Round,
                Form::Round,
                Form::Wide,
                Form::Wide,
                Form::Slender,
                Form::Birch,
            ],
        );
        let (bark, pale) = (self.palette.bark, self.palette.pale_bark);
        let mut crown = |radius: (f64, f64), half: (f64, f64)| {
            (
                between(rng, radius.0, radius.1),
                between(rng, half.0, half.1),
            )
        };
        let (bark, trunk, (radius, half)) = match form {
            Form::Round => (bark, 2.2, crown((1.4, 2.3), (1.5, 2.2))),
            Form::Wide => (bark, 2.6, crown((2.0, 2.7), (1.5, 1.9))),
            Form::Slender => (bark, 1.5, crown((0.8, 1.1), (2.8, 4.2))),
            Form::Birch => (pale, 2.4, crown((1.1, 1.5), (1.9, 2.6))),
        };
        let girth = if matches!(form, Form::Birch) {
            girth * 0.75
        } else {
            girth
        };
        let build = Build {
            bark,
            girth,
            trunk: trunk + between(rng, -0.2, 0.4),
            radius,
            half,
        };
        let crowns = &self.palette.crowns;
        let foliage = if matches!(form, Form::Birch) {
            crowns[2]
        } else {
            pick(rng, crowns)
        };
        let wide = matches!(form, Form::Wide) && self.detailed;
        self.crowned(p, &build, (foliage, wide), rng);
    }

    fn crowned(
        &mut self,
        p: MapPoint,
        build: &Build,
        ((core, shell), wide): ((Surface, Surface), bool),
        rng: &mut Pcg64Mcg,
    ) {
        let (radius, half) = (build.radius, build.half);
        let girth = (build.girth, build.girth * 0.7);
        prism(
            &mut self.builder,
            Layer::Both,
            build.bark,
            (p, 6),
            ((0.0, build.trunk + 0.5), girth),
        );
        let center = at(p, build.trunk + half * 0.85);
        let builder = &mut self.builder;
        let dense = (center, radius * 0.78, half * 0.8);
        blob(builder, (core, Layer::Visible), dense, 0, rng);
        if !wide {
            blob(
                builder,
                (shell, Layer::Visible),
                (center, radius, half),
                1,
                rng,
            );
            return;
        }
        blob(
            builder,
            (shell, Layer::Visible),
            (center, radius * 0.75, half),
            1,
            rng,
        );
        let turn = between(rng, 0.0, std::f64::consts::TAU);
        for i in 0..4 {
            let beside = p.offset(
                turn + std::f64::consts::FRAC_PI_2 * f64::from(i),
                radius * 0.58,
            );
            let lobe = at(beside, center.z - half * between(rng, 0.05, 0.4));
            let size = between(rng, 0.5, 0.62);
            blob(
                builder,
                (core, Layer::Visible),
                (lobe, radius * size, half * size * 1.1),
                0,
                rng,
            );
        }
    }
}

/// A dented ball: an icosahedron, its faces divided in four `divisions` times.
pub(super) fn blob(
    builder: &mut SceneBuilder,
    (surface, layer): (Surface, Layer),
    (center, radius, half_height): (Point3<f64>, f64, f64),
    divisions: usize,
    rng: &mut Pcg64Mcg,
) {
    let (mut points, mut faces) = icosahedron();
    for _ in 0..divisions {
        (points, faces) = divided(&points, &faces);
    }
    let spin = between(rng, 0.0, std::f64::consts::TAU);
    let (sin, cos) = libm::sincos(spin);
    let corners: Vec<Corner> = points
        .iter()
        .map(|d| {
            let dent = between(rng, 0.82, 1.12);
            let (x, y) = (cos * d.x - sin * d.y, sin * d.x + cos * d.y);
            let p = center
                + Vector3::new(
                    x * radius * dent,
                    y * radius * dent,
                    d.z * half_height * dent,
                );
            // Texture from the side that the surface looks to; stretched leaves are leaves.
            let around = libm::atan2(y, x) * radius;
            (
                p,
                [
                    (around / surface.tile) as f32,
                    ((p.z + 0.3 * x) / surface.tile) as f32,
                ],
            )
        })
        .collect();
    builder.mesh(layer, surface.material, &corners, &faces);
}

fn icosahedron() -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    // Two poles and two rings of five.
    let mut points = vec![Vector3::z(), -Vector3::z()];
    let (z, r) = (1.0 / 5.0_f64.sqrt(), 2.0 / 5.0_f64.sqrt());
    for i in 0..10 {
        let (sin, cos) = libm::sincos(std::f64::consts::PI * f64::from(i) / 5.0);
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
    (points, faces)
}

fn divided(points: &[Vector3<f64>], faces: &[[u32; 3]]) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let mut points = points.to_vec();
    let mut middles = std::collections::BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            points.push((points[a as usize] + points[b as usize]).normalize());
            points.len() as u32 - 1
        })
    };
    let split = |[a, b, c]: &[u32; 3]| {
        let (ab, bc, ca) = (middle(*a, *b), middle(*b, *c), middle(*c, *a));
        [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
    };
    let faces = faces.iter().flat_map(split).collect();
    (points, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_are_closed_and_face_outwards() {
        let (points, faces) = icosahedron();
        let (points, faces) = divided(&points, &faces);
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
