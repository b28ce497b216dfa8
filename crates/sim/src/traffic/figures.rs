//! How people and cars look: triangles with materials, at the origin, looking along x, on z = 0.
//!
//! A person is about 1.75 m tall, its limbs prisms between joints. The walking cycle is the usual outline of human gait: hips
//! and arms swing like sines, arms against the legs; a knee bends while its leg swings forward.

use nalgebra::{Point3, Vector3};
use openbench_scene::scene::Layer;
use openbench_scene::{Material, MaterialId, Scene, SceneBuilder, SemanticClass};

use super::{Mover, MoverKind, TrafficPlan};

/// How many phases of the walking cycle are drawn.
pub const PHASES: usize = 8;
/// How many different people there are; greater numbers repeat them.
pub const PEOPLE: u32 = 24;
/// Sides of a limb.
const SIDES: usize = 6;
/// Swing of the hip and of the shoulder, and the bend of a knee, radians.
const SWING: f64 = 0.42;
const ARMS: f64 = 0.38;
const KNEE: f64 = 0.9;
/// Lengths of thigh, shin (with foot), upper arm and forearm, metres.
const THIGH: f64 = 0.43;
const SHIN: f64 = 0.43;
const ARM: f64 = 0.29;
const FOREARM: f64 = 0.27;
/// From ankle to toe, metres.
const FOOT: f64 = 0.17;

const SKINS: [[f32; 3]; 4] = [[0.93, 0.76, 0.65], [0.80, 0.60, 0.46], [0.56, 0.38, 0.27], [0.36, 0.24, 0.18]];
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
const TROUSERS: [[f32; 3]; 5] =
    [[0.16, 0.20, 0.32], [0.11, 0.11, 0.12], [0.52, 0.46, 0.36], [0.32, 0.33, 0.35], [0.36, 0.24, 0.18]];

/// How many different cars a world has; greater numbers repeat them.
pub const CARS: u32 = 15;

/// The figures of a traffic plan in a scene.
#[derive(Debug, Clone, Default)]
pub struct Gallery {
    plan: TrafficPlan,
    /// For each look of a person its phases.
    people: Vec<[usize; PHASES]>,
    cars: Vec<usize>,
}

impl Gallery {
    /// Adds to a scene as many figures as a plan needs.
    pub fn add(scene: &mut Scene, plan: TrafficPlan) -> Self {
        let looks = |wanted: usize, looks: u32| 0..looks.min(u32::try_from(wanted).unwrap_or(looks));
        let mut phases = |look| std::array::from_fn(|phase| scene.add_figure(&person(look, phase)));
        let people = looks(plan.pedestrians, PEOPLE).map(&mut phases).collect();
        let cars = looks(plan.cars, CARS).map(|look| scene.add_figure(&car(look))).collect();
        Self { plan, people, cars }
    }

    /// Whether these are figures for as many.
    pub fn suffices(&self, plan: TrafficPlan) -> bool {
        plan.pedestrians <= self.plan.pedestrians && plan.cars <= self.plan.cars
    }

    /// The figure of a mover.
    pub(crate) fn of(&self, mover: &Mover) -> usize {
        let look = mover.look as usize;
        match mover.kind {
            MoverKind::Pedestrian => self.people[look % self.people.len()][phase_of(mover.gait)],
            MoverKind::Car => self.cars[look % self.cars.len()],
        }
    }
}

/// The index of the [`person`] to show for a phase of gait from 0 to 1.
pub fn phase_of(gait: f64) -> usize {
    (gait.rem_euclid(1.0) * PHASES as f64) as usize % PHASES
}

/// A person in phase `phase` (of [`PHASES`], repeating) of the walking cycle; `look` chooses clothes, skin and hair.
pub fn person(look: u32, phase: usize) -> Scene {
    let mut figure = Figure::new(look % PEOPLE);
    figure.walk(std::f64::consts::TAU * (phase % PHASES) as f64 / PHASES as f64);
    figure.builder.build()
}

/// A car; `look` chooses shape and paint. Its solid part is the box about it.
pub fn car(look: u32) -> Scene {
    openbench_scene::generate::car_figure(look)
}

struct Figure {
    builder: SceneBuilder,
    skin: MaterialId,
    hair: MaterialId,
    top: MaterialId,
    trousers: MaterialId,
    shoes: MaterialId,
}

/// A ring of a limb: its middle, and half its extent forward and sideways, metres.
type Ring = (Point3<f64>, [f64; 2]);

impl Figure {
    fn new(look: u32) -> Self {
        let mut builder = SceneBuilder::new();
        let look = look as usize;
        let mut cloth = |color| builder.material(Material::plain(SemanticClass::Person, color));
        let skin = cloth(SKINS[(look / 2) % SKINS.len()]);
        let hair = cloth(HAIRS[look % HAIRS.len()]);
        let top = cloth(TOPS[look % TOPS.len()]);
        let trousers = cloth(TROUSERS[look % TROUSERS.len()]);
        let shoes = cloth([0.10, 0.09, 0.09]);
        Self { skin, hair, top, trousers, shoes, builder }
    }

    fn walk(&mut self, phase: f64) {
        let legs = [(0.09, phase), (-0.09, phase + std::f64::consts::PI)];
        let bends = legs.map(|(_, p)| leg_angles(p));
        // The hip is as high as the leg that stands needs it.
        let hip = bends.iter().map(|b| reach(*b)).fold(0.0, f64::max) + 0.07;
        for ((left, _), bend) in legs.into_iter().zip(bends) {
            self.leg(Point3::new(0.0, left, hip), bend);
        }
        for (left, p) in [(0.23, phase + std::f64::consts::PI), (-0.23, phase)] {
            self.arm(Point3::new(0.0, left, hip + 0.52), ARMS * libm::cos(p));
        }
        self.trunk(hip);
    }

    fn trunk(&mut self, hip: f64) {
        let at = |x: f64, z: f64| Point3::new(x, 0.0, hip + z);
        let (top, skin, hair, trousers) = (self.top, self.skin, self.hair, self.trousers);
        self.tube(trousers, &[(at(0.0, -0.06), [0.10, 0.16]), (at(0.0, 0.10), [0.11, 0.16])]);
        let chest = [
            (at(0.0, 0.08), [0.115, 0.165]),
            (at(0.0, 0.30), [0.12, 0.18]),
            (at(0.0, 0.48), [0.12, 0.20]),
            (at(0.0, 0.58), [0.08, 0.13]),
        ];
        self.tube(top, &chest);
        self.tube(skin, &[(at(0.0, 0.56), [0.055; 2]), (at(0.01, 0.66), [0.055; 2])]);
        let head = [
            (at(0.025, 0.63), [0.055, 0.05]),
            (at(0.025, 0.70), [0.09, 0.075]),
            (at(0.02, 0.78), [0.10, 0.08]),
        ];
        self.tube(skin, &head);
        let crown = [
            (at(0.005, 0.76), [0.105, 0.085]),
            (at(0.005, 0.82), [0.095, 0.08]),
            (at(0.0, 0.865), [0.05, 0.045]),
        ];
        self.tube(hair, &crown);
    }

    fn leg(&mut self, hip: Point3<f64>, [swing, bend]: [f64; 2]) {
        let knee = hip + along(swing) * THIGH;
        let ankle = knee + along(swing - bend) * SHIN;
        self.tube(self.trousers, &[(hip, [0.09, 0.085]), (knee, [0.06; 2])]);
        self.tube(self.trousers, &[(knee, [0.06; 2]), (ankle, [0.045; 2])]);
        let pitch = foot_pitch([swing, bend]);
        let toe = ankle + Vector3::new(libm::cos(pitch), 0.0, libm::sin(pitch)) * FOOT;
        let heel = ankle + Vector3::new(-0.06, 0.0, 0.0);
        self.foot(heel, toe);
    }

    fn foot(&mut self, heel: Point3<f64>, toe: Point3<f64>) {
        let corner = |p: Point3<f64>, y: f64, z: f64| (p + Vector3::new(0.0, y, z), [0.0; 2]);
        let ring = |p: Point3<f64>, high: f64| {
            [corner(p, -0.045, -0.07), corner(p, 0.045, -0.07), corner(p, 0.04, high), corner(p, -0.04, high)]
        };
        let corners: Vec<_> = ring(heel, 0.02).into_iter().chain(ring(toe, -0.02)).collect();
        let sides = (0..4_u32).flat_map(|i| {
            let j = (i + 1) % 4;
            [[i, i + 4, j + 4], [i, j + 4, j]]
        });
        let flipped = sides.map(|[a, b, c]| [a, c, b]);
        let ends = [[0, 3, 2], [0, 2, 1], [4, 5, 6], [4, 6, 7]];
        let triangles: Vec<[u32; 3]> = flipped.chain(ends).collect();
        self.builder.mesh(Layer::Visible, self.shoes, &corners, &triangles);
    }

    fn arm(&mut self, shoulder: Point3<f64>, swing: f64) {
        let elbow = shoulder + along(swing) * ARM;
        let wrist = elbow + along(swing + 0.35) * FOREARM;
        let tip = wrist + along(swing + 0.35) * 0.09;
        self.tube(self.top, &[(shoulder, [0.055; 2]), (elbow, [0.045; 2]), (wrist, [0.038; 2])]);
        self.tube(self.skin, &[(wrist, [0.04, 0.03]), (tip, [0.03, 0.02])]);
    }

    /// A closed prism through level rings.
    fn tube(&mut self, material: MaterialId, rings: &[Ring]) {
        // From below to above, so that one winding fits all.
        let mut rings = rings.to_vec();
        rings.sort_by(|a, b| a.0.z.total_cmp(&b.0.z));
        let mut corners = Vec::new();
        for (middle, half) in &rings {
            for k in 0..SIDES {
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * (k as f64 + 0.5) / SIDES as f64);
                corners.push((middle + Vector3::new(half[0] * cos, half[1] * sin, 0.0), [0.0; 2]));
            }
        }
        let sides = SIDES as u32;
        let last = sides * (rings.len() as u32 - 1);
        let mut triangles = Vec::new();
        for base in (0..last).step_by(SIDES) {
            for k in 0..sides {
                let (a, b) = (base + k, base + (k + 1) % sides);
                triangles.extend([[a, b, b + sides], [a, b + sides, a + sides]]);
            }
        }
        for k in 1..sides - 1 {
            triangles.extend([[0, k + 1, k], [last, last + k, last + k + 1]]);
        }
        self.builder.mesh(Layer::Visible, material, &corners, &triangles);
    }
}

/// Swing of the hip and bend of the knee in a phase; the leg is in front at 0 and swings forward in the second half.
fn leg_angles(phase: f64) -> [f64; 2] {
    let bend = (-libm::sin(phase)).max(0.0);
    [SWING * libm::cos(phase), 0.08 + KNEE * bend * bend]
}

/// How far below the hip the lower of ankle and toe is, metres.
fn reach([swing, bend]: [f64; 2]) -> f64 {
    let ankle = THIGH * libm::cos(swing) + SHIN * libm::cos(swing - bend);
    ankle - FOOT * libm::sin(foot_pitch([swing, bend]))
}

/// A foot behind the body points down, half as much as its shin; one in front is level.
fn foot_pitch([swing, bend]: [f64; 2]) -> f64 {
    0.5 * (swing - bend).min(0.0)
}

/// Downwards, swung forward by an angle.
fn along(swing: f64) -> Vector3<f64> {
    Vector3::new(libm::sin(swing), 0.0, -libm::cos(swing))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(scene: &Scene) -> ([f32; 3], [f32; 3]) {
        let start = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        scene.vertices.iter().fold(start, |(low, high), v| {
            let p = v.position;
            ([0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k])))
        })
    }

    /// Six times the volume, from the divergence theorem: positive if triangles are seen from outside.
    fn volume(scene: &Scene) -> f64 {
        let corner = |i: u32| Vector3::from(scene.vertices[i as usize].position.map(f64::from));
        scene
            .triangles
            .iter()
            .map(|t| corner(t.corners[0]).dot(&corner(t.corners[1]).cross(&corner(t.corners[2]))))
            .sum()
    }

    #[test]
    fn people_stand_on_the_ground_and_are_as_tall_and_wide_as_people() {
        for phase in 0..PHASES {
            let figure = person(3, phase);
            let (low, high) = bounds(&figure);
            assert!(low[2].abs() < 0.03, "phase {phase}: {low:?}");
            assert!((1.65..1.85).contains(&high[2]), "phase {phase}: {high:?}");
            assert!(high[1] < 0.32 && low[1] > -0.32 && high[0] < 0.65 && low[0] > -0.65, "{low:?} {high:?}");
            assert!(figure.triangles.len() < 500, "{}", figure.triangles.len());
            let litres = volume(&figure) / 6.0 * 1000.0;
            assert!((40.0..110.0).contains(&litres), "{litres}");
            assert!(figure.materials.iter().all(|m| m.class == SemanticClass::Person));
        }
    }

    #[test]
    fn half_a_cycle_mirrors_a_person() {
        let [a, b] = [person(0, 1), person(0, 1 + PHASES / 2)].map(|f| bounds(&f));
        assert!((a.0[1] + b.1[1]).abs() < 1e-5 && (a.1[0] - b.1[0]).abs() < 1e-5, "{a:?} {b:?}");
        assert_ne!(person(0, 0).vertices, person(0, 1).vertices);
        assert_eq!((phase_of(0.0), phase_of(0.999), phase_of(-0.1), phase_of(f64::NAN)), (0, 7, 7, 0));
    }

    #[test]
    fn looks_differ() {
        assert_ne!(person(0, 0).materials, person(1, 0).materials);
        assert_eq!(person(0, 0).materials, person(PEOPLE, 0).materials);
    }

    #[test]
    fn cars_are_as_large_as_the_hull_that_others_keep_off() {
        for look in 0..10 {
            let figure = car(look);
            let (low, high) = bounds(&figure);
            let half = super::super::HALF.map(|h| h as f32);
            assert!(high[0] <= half[0] + 0.01 && low[0] >= -half[0] - 0.01, "{low:?} {high:?}");
            assert!(high[1] <= half[1] + 0.03 && high[2] < 2.0 && low[2].abs() < 0.02, "{low:?} {high:?}");
            assert!(figure.materials.iter().all(|m| m.class == SemanticClass::Vehicle));
        }
    }
}
