//! How people look: triangles with materials, at the origin, facing along x, on z = 0.
//!
//! A person is about 1.75 m tall, its limbs prisms between joints.

use nalgebra::{Point3, Vector3};
use openbench_scene::{Corner, Layer, Material, MaterialId, Scene, SceneBuilder, SemanticClass};

use super::gait::{HEEL_M, Leg, PHASES, TOE_M, arm_swing, opposite, swung};

/// Number of different people; greater numbers repeat them.
pub(super) const PEOPLE: u32 = 24;
/// Bend of the elbows, radians.
const ELBOW_RAD: f64 = 0.35;
/// Lengths of upper arm, forearm and hand, metres.
const ARM_M: f64 = 0.28;
const FOREARM_M: f64 = 0.25;
const HAND_M: f64 = 0.13;
/// Half the distance between the hips, metres.
const HIP_M: f64 = 0.085;
/// Shoulders: in front of the hips, to the side, and above them, metres.
const SHOULDER_M: [f64; 3] = [0.02, 0.215, 0.57];

const SKINS: [[f32; 3]; 4] = [
    [0.93, 0.76, 0.65],
    [0.80, 0.60, 0.46],
    [0.56, 0.38, 0.27],
    [0.36, 0.24, 0.18],
];
const HAIRS: [[f32; 3]; 3] = [[0.12, 0.09, 0.07], [0.36, 0.24, 0.14], [0.62, 0.58, 0.54]];
const TOPS: [[f32; 3]; 8] = [
    [0.70, 0.16, 0.15],
    [0.16, 0.27, 0.48],
    [0.86, 0.86, 0.84],
    [0.15, 0.16, 0.17],
    [0.25, 0.42, 0.30],
    [0.88, 0.68, 0.20],
    [0.48, 0.32, 0.48],
    [0.55, 0.58, 0.60],
];
const TROUSERS: [[f32; 3]; 5] = [
    [0.16, 0.20, 0.32],
    [0.11, 0.11, 0.12],
    [0.52, 0.46, 0.36],
    [0.32, 0.33, 0.35],
    [0.36, 0.24, 0.18],
];

/// A person in phase `phase` (of [`PHASES`], repeating) of the walking cycle; `look` selects
/// clothes, skin and hair.
pub(super) fn person(look: u32, phase: usize) -> Scene {
    let mut figure = Figure::new(look % PEOPLE);
    figure.walk(phase % PHASES);
    figure.builder.build()
}

struct Figure {
    builder: SceneBuilder,
    skin: MaterialId,
    hair: MaterialId,
    top: MaterialId,
    trousers: MaterialId,
    shoes: MaterialId,
}

/// A cross section of a limb, metres.
#[derive(Debug, Clone, Copy)]
struct Ring {
    middle: Point3<f64>,
    /// Half its extent forward and sideways.
    half: [f64; 2],
}

const fn ring(middle: Point3<f64>, forward: f64, sideways: f64) -> Ring {
    Ring {
        middle,
        half: [forward, sideways],
    }
}

/// Which ends of a limb are closed: those that can be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Closed {
    Neither,
    Lower,
    Upper,
    Both,
}

impl Figure {
    fn new(look: u32) -> Self {
        let mut builder = SceneBuilder::new();
        let look = look as usize;
        let mut cloth = |color| builder.material(Material::plain(SemanticClass::Person, color));
        // The lists have different lengths. Hair and top alone tell 24 people apart: 3 and 8 have
        // no common divisor.
        let skin = cloth(SKINS[(look / 2) % SKINS.len()]);
        let hair = cloth(HAIRS[look % HAIRS.len()]);
        let top = cloth(TOPS[look % TOPS.len()]);
        let trousers = cloth(TROUSERS[look % TROUSERS.len()]);
        let shoes = cloth([0.10, 0.09, 0.09]);
        Self {
            skin,
            hair,
            top,
            trousers,
            shoes,
            builder,
        }
    }

    fn walk(&mut self, phase: usize) {
        let [left, right] = [phase, opposite(phase)].map(Leg::in_phase);
        // The standing leg sets the height of the hip.
        let hip = left.reach().max(right.reach());
        self.leg(Point3::new(0.0, HIP_M, hip), left);
        self.leg(Point3::new(0.0, -HIP_M, hip), right);
        let swing = arm_swing(phase);
        let [x, y, z] = SHOULDER_M;
        // Arms swing against the legs of their side.
        self.arm(Point3::new(x, y, hip + z), -swing);
        self.arm(Point3::new(x, -y, hip + z), swing);
        self.trunk(hip);
    }

    fn trunk(&mut self, hip: f64) {
        let at = |x: f64, z: f64| Point3::new(x, 0.0, hip + z);
        // Each piece reaches a little into the next, so open ends are not seen.
        let pelvis = [
            ring(at(0.0, -0.06), 0.10, 0.155),
            ring(at(0.0, 0.12), 0.11, 0.155),
        ];
        self.tube(self.trousers, 6, &pelvis, Closed::Lower);
        let chest = [
            ring(at(0.0, 0.06), 0.125, 0.165),
            ring(at(0.02, 0.50), 0.13, 0.19),
            ring(at(0.02, 0.60), 0.075, 0.12),
        ];
        self.tube(self.top, 6, &chest, Closed::Both);
        let head = [
            ring(at(0.02, 0.58), 0.055, 0.055),
            ring(at(0.03, 0.67), 0.055, 0.055),
            ring(at(0.05, 0.70), 0.08, 0.065),
            ring(at(0.035, 0.80), 0.085, 0.075),
        ];
        self.tube(self.skin, 6, &head, Closed::Neither);
        let hair = [
            ring(at(0.01, 0.70), 0.075, 0.07),
            ring(at(0.02, 0.80), 0.11, 0.09),
            ring(at(0.02, 0.88), 0.065, 0.055),
        ];
        self.tube(self.hair, 6, &hair, Closed::Upper);
    }

    fn leg(&mut self, hip: Point3<f64>, leg: Leg) {
        let (knee, ankle) = (hip + leg.thigh(), hip + leg.thigh() + leg.shin());
        let rings = [
            ring(hip, 0.095, 0.07),
            ring(knee, 0.062, 0.058),
            ring(ankle, 0.045, 0.042),
        ];
        self.tube(self.trousers, 5, &rings, Closed::Neither);
        self.shoe(ankle, leg);
    }

    fn shoe(&mut self, ankle: Point3<f64>, leg: Leg) {
        let across =
            |p: Vector3<f64>, half: f64| [-half, half].map(|y| ankle + p + Vector3::y() * y);
        let top = [leg.upon_sole(-HEEL_M, 0.09), leg.upon_sole(TOE_M, 0.04)];
        let [[a, b], [e, f]] = leg.sole().map(|p| across(p, 0.045));
        let [[d, c], [h, g]] = top.map(|p| across(p, 0.04));
        let corners = [a, b, c, d, e, f, g, h].map(|p| Corner::new(p, [0.0; 2]));
        let sides = [
            [0, 5, 4],
            [0, 1, 5],
            [1, 6, 5],
            [1, 2, 6],
            [2, 7, 6],
            [2, 3, 7],
            [3, 4, 7],
            [3, 0, 4],
        ];
        let ends = [[0, 3, 2], [0, 2, 1], [4, 5, 6], [4, 6, 7]];
        let triangles: Vec<[u32; 3]> = sides.into_iter().chain(ends).collect();
        self.builder
            .mesh(Layer::Visible, self.shoes, &corners, &triangles);
    }

    fn arm(&mut self, shoulder: Point3<f64>, swing: f64) {
        let bent = swing + ELBOW_RAD;
        let elbow = shoulder + swung(swing) * ARM_M;
        let wrist = elbow + swung(bent) * FOREARM_M;
        let rings = [
            ring(shoulder, 0.03, 0.03),
            ring(shoulder + swung(swing) * 0.06, 0.062, 0.055),
            ring(elbow, 0.05, 0.045),
            ring(wrist, 0.035, 0.035),
        ];
        self.tube(self.top, 4, &rings, Closed::Upper);
        let hand = [
            ring(wrist, 0.035, 0.035),
            ring(wrist + swung(bent) * HAND_M, 0.035, 0.02),
        ];
        self.tube(self.skin, 4, &hand, Closed::Lower);
    }

    /// A prism with this many sides through level rings.
    fn tube(&mut self, material: MaterialId, sides: u32, rings: &[Ring], closed: Closed) {
        // From below to above, so that one winding fits all.
        let mut rings = rings.to_vec();
        rings.sort_by(|a, b| a.middle.z.total_cmp(&b.middle.z));
        let mut corners = Vec::new();
        for Ring { middle, half } in &rings {
            for k in 0..sides {
                let turn = (f64::from(k) + 0.5) / f64::from(sides);
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * turn);
                let corner = middle + Vector3::new(half[0] * cos, half[1] * sin, 0.0);
                corners.push(Corner::new(corner, [0.0; 2]));
            }
        }
        let last = sides * (rings.len() as u32 - 1);
        let mut triangles = Vec::new();
        for base in (0..last).step_by(sides as usize) {
            for k in 0..sides {
                let (a, b) = (base + k, base + (k + 1) % sides);
                triangles.extend([[a, b, b + sides], [a, b + sides, a + sides]]);
            }
        }
        // Fans about the first corner of the lowest and of the highest ring.
        for k in 1..sides - 1 {
            if matches!(closed, Closed::Lower | Closed::Both) {
                triangles.push([0, k + 1, k]);
            }
            if matches!(closed, Closed::Upper | Closed::Both) {
                triangles.push([last, last + k, last + k + 1]);
            }
        }
        self.builder
            .mesh(Layer::Visible, material, &corners, &triangles);
    }
}

/// The box around a figure.
#[cfg(test)]
pub(super) fn bounds(scene: &Scene) -> openbench_scene::bvh::Bounds3 {
    let corner = |i: u32| scene.vertices[i as usize].position;
    let triangles = scene.triangles.iter().map(|t| t.corners.map(corner));
    openbench_scene::TriangleBvh::new(triangles)
        .bounds()
        .expect("a figure has triangles")
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use openbench_scene::RayCaster;
    use openbench_scene::bvh::Bounds3;

    use super::*;

    #[test]
    fn people_stand_on_the_ground_and_are_as_tall_and_wide_as_people() {
        for phase in 0..PHASES {
            let figure = person(3, phase);
            let Bounds3 {
                min: low,
                max: high,
            } = bounds(&figure);
            assert!(low[2].abs() < 1e-6, "phase {phase}: {low:?}");
            assert!((1.65..1.85).contains(&high[2]), "phase {phase}: {high:?}");
            assert!(
                high[1] < 0.32 && low[1] > -0.32 && high[0] < 0.65 && low[0] > -0.65,
                "{low:?} {high:?}"
            );
            assert!(figure.triangles.len() <= 250, "{}", figure.triangles.len());
            assert!(
                figure
                    .materials
                    .iter()
                    .all(|m| m.class == SemanticClass::Person)
            );
        }
    }

    #[test]
    fn people_are_closed_surfaces_from_everywhere() {
        for phase in 0..PHASES {
            let caster = RayCaster::new(Arc::new(person(5, phase)));
            let (mut seen, mut inside) = (0, 0);
            for (turn, height, row, column) in views() {
                let (sin, cos) = libm::sincosf(turn);
                let target = [column * -sin, column * cos, row];
                let eye = [3.0 * cos - column * sin, 3.0 * sin + column * cos, height];
                let direction = [0, 1, 2].map(|i| target[i] - eye[i]);
                let Some(hit) = caster.cast(eye, direction, 2.0) else {
                    continue;
                };
                let normal = caster.surface(hit.triangle).normal;
                seen += 1;
                inside += usize::from((0..3).map(|i| normal[i] * direction[i]).sum::<f32>() > 0.0);
            }
            // About the area of a person over that of the window through which it is looked at.
            assert!((1500..3000).contains(&seen), "phase {phase}: {seen}");
            assert!(
                inside * 200 < seen,
                "phase {phase}: {inside} of {seen} rays see the inside"
            );
        }
    }

    /// Turns round a person, heights of the eye, and rows and columns of rays, radians and metres.
    fn views() -> impl Iterator<Item = (f32, f32, f32, f32)> {
        let looks = (0..8).flat_map(|turn| [0.2, 1.6].map(|height| (turn as f32 * 0.8, height)));
        looks.flat_map(|(turn, height)| {
            (0..400).map(move |i| {
                let (row, column) = ((i / 20) as f32, (i % 20) as f32);
                (turn, height, 0.02 + 0.09 * row, -0.38 + 0.04 * column)
            })
        })
    }

    #[test]
    fn half_a_cycle_mirrors_a_person() {
        let [a, b] = [person(0, 1), person(0, 1 + PHASES / 2)].map(|f| bounds(&f));
        assert!(
            (a.min[1] + b.max[1]).abs() < 1e-5 && (a.max[0] - b.max[0]).abs() < 1e-5,
            "{a:?} {b:?}"
        );
        assert_ne!(person(0, 0).vertices, person(0, 1).vertices);
    }

    #[test]
    fn looks_differ() {
        assert_ne!(person(0, 0).materials, person(1, 0).materials);
        assert_eq!(person(0, 0).materials, person(PEOPLE, 0).materials);
    }
}
