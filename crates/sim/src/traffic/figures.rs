//! How people and cars look: triangles with materials, at the origin, looking along x, on z = 0.
//!
//! A person is about 1.75 m tall, its limbs prisms between joints. The walking cycle is that of gait analysis (J. Perry, *Gait Analysis: Normal
//! and Pathological Function*, 1992): heel strike, flat foot, heel off, toe off, swing, with rounded angles.

use nalgebra::{Point3, Vector3};
use openbench_scene::scene::Layer;
use openbench_scene::{Material, MaterialId, Scene, SceneBuilder, SemanticClass};

use super::{Mover, MoverKind, TrafficPlan};

/// How many phases of the walking cycle are drawn.
pub const PHASES: usize = 8;
/// How many different people there are; greater numbers repeat them.
pub const PEOPLE: u32 = 24;
/// Swing of the arms and bend of the elbows, radians.
const ARMS: f64 = 0.36;
const ELBOW: f64 = 0.35;
/// Lengths of thigh, shin, upper arm and forearm, metres.
const THIGH: f64 = 0.43;
const SHIN: f64 = 0.43;
const ARM: f64 = 0.28;
const FOREARM: f64 = 0.25;
/// The ankle above the sole, from the ankle to the heel, and to the toe, metres.
const ANKLE: f64 = 0.075;
const HEEL: f64 = 0.07;
const TOE: f64 = 0.18;

/// A leg in each phase, from its heel strike on: how far the thigh is swung forward, the bend of the knee, and by how much the toe is
/// higher than the heel, degrees.
const GAIT: [[f64; 3]; PHASES] = [
    [24.0, 5.0, 14.0],
    [20.0, 18.0, 0.0],
    [5.0, 12.0, 0.0],
    [-10.0, 6.0, 0.0],
    [-20.0, 12.0, -16.0],
    [-9.0, 42.0, -48.0],
    [14.0, 62.0, -32.0],
    [25.0, 32.0, -2.0],
];

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
        let looks =
            |wanted: usize, looks: u32| 0..looks.min(u32::try_from(wanted).unwrap_or(looks));
        let mut phases = |look| std::array::from_fn(|phase| scene.add_figure(&person(look, phase)));
        let people = looks(plan.pedestrians, PEOPLE).map(&mut phases).collect();
        let cars = looks(plan.cars, CARS)
            .map(|look| scene.add_figure(&car(look)))
            .collect();
        Self { plan, people, cars }
    }

    /// Whether these are figures for as many.
    pub fn suffices(&self, plan: TrafficPlan) -> bool {
        plan.pedestrians <= self.plan.pedestrians && plan.cars <= self.plan.cars
    }

    /// The figure of a mover.
    pub(crate) fn of(&self, mover: &Mover) -> usize {
        let look = self.look(mover) as usize;
        match mover.kind {
            MoverKind::Pedestrian => self.people[look][phase_of(mover.gait)],
            MoverKind::Car => self.cars[look],
        }
    }

    /// Which of the [`person`]s or [`car`]s of this gallery a mover is.
    pub(crate) fn look(&self, mover: &Mover) -> u32 {
        let looks = match mover.kind {
            MoverKind::Pedestrian => self.people.len(),
            MoverKind::Car => self.cars.len(),
        };
        mover.look % looks as u32
    }
}

/// The index of the [`person`] to show for a phase of gait from 0 to 1.
pub fn phase_of(gait: f64) -> usize {
    (gait.rem_euclid(1.0) * PHASES as f64) as usize % PHASES
}

/// A person in phase `phase` (of [`PHASES`], repeating) of the walking cycle; `look` chooses clothes, skin and hair.
pub fn person(look: u32, phase: usize) -> Scene {
    let mut figure = Figure::new(look % PEOPLE);
    figure.walk(phase % PHASES);
    figure.builder.build()
}

/// A car; `look` chooses shape and paint. What is solid of it is its body and tyres, as drawn.
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
        let [left, right] = [phase, (phase + PHASES / 2) % PHASES].map(Leg::in_phase);
        // The hip is as high as the leg that stands needs it.
        let hip = left.reach().max(right.reach());
        self.leg(Point3::new(0.0, 0.085, hip), left);
        self.leg(Point3::new(0.0, -0.085, hip), right);
        let swing = ARMS * libm::cos(std::f64::consts::TAU * phase as f64 / PHASES as f64);
        self.arm(Point3::new(0.02, 0.215, hip + 0.57), -swing);
        self.arm(Point3::new(0.02, -0.215, hip + 0.57), swing);
        self.trunk(hip);
    }

    fn trunk(&mut self, hip: f64) {
        let at = |x: f64, z: f64| Point3::new(x, 0.0, hip + z);
        let pelvis = [
            (at(0.0, -0.06), [0.10, 0.155]),
            (at(0.0, 0.12), [0.11, 0.155]),
        ];
        self.tube(self.trousers, 6, &pelvis, [true, false]);
        let chest = [
            (at(0.0, 0.06), [0.125, 0.165]),
            (at(0.02, 0.50), [0.13, 0.19]),
            (at(0.02, 0.60), [0.075, 0.12]),
        ];
        self.tube(self.top, 6, &chest, [true, true]);
        let head = [
            (at(0.02, 0.58), [0.055; 2]),
            (at(0.03, 0.67), [0.055; 2]),
            (at(0.05, 0.70), [0.08, 0.065]),
            (at(0.035, 0.80), [0.085, 0.075]),
        ];
        self.tube(self.skin, 6, &head, [false, false]);
        let hair = [
            (at(0.01, 0.70), [0.075, 0.07]),
            (at(0.02, 0.80), [0.11, 0.09]),
            (at(0.02, 0.88), [0.065, 0.055]),
        ];
        self.tube(self.hair, 6, &hair, [false, true]);
    }

    fn leg(&mut self, hip: Point3<f64>, leg: Leg) {
        let (knee, ankle) = (hip + leg.thigh(), hip + leg.thigh() + leg.shin());
        let rings = [
            (hip, [0.095, 0.07]),
            (knee, [0.062, 0.058]),
            (ankle, [0.045, 0.042]),
        ];
        self.tube(self.trousers, 5, &rings, [false, false]);
        self.shoe(ankle, leg);
    }

    fn shoe(&mut self, ankle: Point3<f64>, leg: Leg) {
        let across =
            |p: Vector3<f64>, half: f64| [-half, half].map(|y| ankle + p + Vector3::y() * y);
        let top = [leg.upon_sole(-HEEL, 0.09), leg.upon_sole(TOE, 0.04)];
        let [[a, b], [e, f]] = leg.sole().map(|p| across(p, 0.045));
        let [[d, c], [h, g]] = top.map(|p| across(p, 0.04));
        let corners = [a, b, c, d, e, f, g, h].map(|p| (p, [0.0; 2]));
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
        let bent = swing + ELBOW;
        let elbow = shoulder + along(swing) * ARM;
        let wrist = elbow + along(bent) * FOREARM;
        let rings = [
            (shoulder, [0.03; 2]),
            (shoulder + along(swing) * 0.06, [0.062, 0.055]),
            (elbow, [0.05, 0.045]),
            (wrist, [0.035; 2]),
        ];
        self.tube(self.top, 4, &rings, [false, true]);
        let hand = [
            (wrist, [0.035; 2]),
            (wrist + along(bent) * 0.13, [0.035, 0.02]),
        ];
        self.tube(self.skin, 4, &hand, [true, false]);
    }

    /// A prism of so many sides through level rings; its lower and its upper end are closed where they can be seen.
    fn tube(&mut self, material: MaterialId, sides: u32, rings: &[Ring], closed: [bool; 2]) {
        // From below to above, so that one winding fits all.
        let mut rings = rings.to_vec();
        rings.sort_by(|a, b| a.0.z.total_cmp(&b.0.z));
        let mut corners = Vec::new();
        for (middle, half) in &rings {
            for k in 0..sides {
                let turn = (f64::from(k) + 0.5) / f64::from(sides);
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * turn);
                corners.push((
                    middle + Vector3::new(half[0] * cos, half[1] * sin, 0.0),
                    [0.0; 2],
                ));
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
        for k in 1..sides - 1 {
            triangles.extend(closed[0].then_some([0, k + 1, k]));
            triangles.extend(closed[1].then_some([last, last + k, last + k + 1]));
        }
        self.builder
            .mesh(Layer::Visible, material, &corners, &triangles);
    }
}

/// A leg in a phase of the walking cycle, radians: swing of the thigh, bend of the knee, and how far the toe is up.
#[derive(Debug, Clone, Copy)]
struct Leg {
    swing: f64,
    bend: f64,
    pitch: f64,
}

impl Leg {
    fn in_phase(phase: usize) -> Self {
        let [swing, bend, pitch] = GAIT[phase].map(f64::to_radians);
        Self { swing, bend, pitch }
    }

    /// From hip to knee.
    fn thigh(self) -> Vector3<f64> {
        along(self.swing) * THIGH
    }

    /// From knee to ankle.
    fn shin(self) -> Vector3<f64> {
        along(self.swing - self.bend) * SHIN
    }

    /// From the ankle to heel and toe, on the ground when the foot is.
    fn sole(self) -> [Vector3<f64>; 2] {
        [self.upon_sole(-HEEL, 0.0), self.upon_sole(TOE, 0.0)]
    }

    /// From the ankle to a point of the shoe, so far in front of the ankle and so far above the sole.
    fn upon_sole(self, forward: f64, up: f64) -> Vector3<f64> {
        let (sin, cos) = libm::sincos(self.pitch);
        let up = up - ANKLE;
        Vector3::new(forward * cos - up * sin, 0.0, forward * sin + up * cos)
    }

    /// How far below the hip the lower of heel and toe is, metres.
    fn reach(self) -> f64 {
        let [heel, toe] = self.sole();
        -(self.thigh().z + self.shin().z + heel.z.min(toe.z))
    }
}

/// Downwards, swung forward by an angle.
fn along(swing: f64) -> Vector3<f64> {
    Vector3::new(libm::sin(swing), 0.0, -libm::cos(swing))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use openbench_scene::RayCaster;

    use super::super::pedestrians::STRIDE;
    use super::*;

    fn bounds(scene: &Scene) -> ([f32; 3], [f32; 3]) {
        let start = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        scene.vertices.iter().fold(start, |(low, high), v| {
            let p = v.position;
            (
                [0, 1, 2].map(|k| low[k].min(p[k])),
                [0, 1, 2].map(|k| high[k].max(p[k])),
            )
        })
    }

    #[test]
    fn people_stand_on_the_ground_and_are_as_tall_and_wide_as_people() {
        for phase in 0..PHASES {
            let figure = person(3, phase);
            let (low, high) = bounds(&figure);
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
    fn people_are_seen_from_outside_from_everywhere() {
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
    fn feet_stand_while_the_body_passes_over_them() {
        // From flat foot to heel off the ankle moves back as fast as the body moves on, and stays at one height.
        let ankle = |phase| {
            let leg = Leg::in_phase(phase);
            let other = Leg::in_phase((phase + PHASES / 2) % PHASES);
            leg.thigh() + leg.shin() + Vector3::z() * leg.reach().max(other.reach())
        };
        let stand = [1, 2, 3].map(ankle);
        assert!(
            stand.iter().all(|a| (a.z - ANKLE).abs() < 0.03),
            "{stand:?}"
        );
        let slip = stand[0].x - stand[2].x - STRIDE / 4.0;
        assert!(slip.abs() < 0.03, "{slip}");
        // The swinging foot passes clear of the ground, and not as in a march.
        let swing = ankle(6).z - ANKLE;
        assert!((0.02..0.25).contains(&swing), "{swing}");
    }

    #[test]
    fn half_a_cycle_mirrors_a_person() {
        let [a, b] = [person(0, 1), person(0, 1 + PHASES / 2)].map(|f| bounds(&f));
        assert!(
            (a.0[1] + b.1[1]).abs() < 1e-5 && (a.1[0] - b.1[0]).abs() < 1e-5,
            "{a:?} {b:?}"
        );
        assert_ne!(person(0, 0).vertices, person(0, 1).vertices);
        assert_eq!(
            (
                phase_of(0.0),
                phase_of(0.999),
                phase_of(-0.1),
                phase_of(f64::NAN)
            ),
            (0, 7, 7, 0)
        );
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
            assert!(
                high[0] <= half[0] + 0.01 && low[0] >= -half[0] - 0.01,
                "{low:?} {high:?}"
            );
            assert!(
                high[1] <= half[1] + 0.03 && high[2] < 2.0 && low[2].abs() < 0.02,
                "{low:?} {high:?}"
            );
            assert!(
                figure
                    .materials
                    .iter()
                    .all(|m| m.class == SemanticClass::Vehicle)
            );
        }
    }
}
