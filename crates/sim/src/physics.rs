//! The robot's body on its four wheels, and its contacts with the world.
//!
//! `rapier3d` integrates the body and solves its contacts. A wheel is a ray: a spring and a damper
//! along it carry the body. At its foot, Coulomb friction, made continuous near zero slip, opposes
//! the slip between rim and ground in both directions. A turning skid-steer robot therefore slides
//! sideways over all four wheels, as real ones do, and its wheels turn further than it moves.

use std::sync::Arc;

use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};
use openbench_core::{MapPoint, Pose2, Pose3, RobotDescription, Velocity};
use openbench_scene::{RayCaster, SemanticClass};
use rapier3d_f64::geometry::{ContactManifold, PairContacts};
use rapier3d_f64::pipeline::PhysicsWorld;
use rapier3d_f64::prelude::{
    ColliderBuilder, ColliderHandle, RigidBodyBuilder, RigidBodyHandle, Vector,
};

use crate::bodies::{Bodies, Leg, upright};
use crate::clock::STEP_NS;
use crate::defects::{Defects, grip};
use crate::solids::Solids;
use crate::traffic::Mover;
use crate::wheels::WheelSpeeds;

const STEP_S: f64 = STEP_NS as f64 * 1e-9;
/// Gravity, m/s², as Gazebo Classic has it by default; the standard value is 9.80665.
pub(crate) const GRAVITY: f64 = 9.8;
/// Mass of chassis and wheels, kg.
const MASS_KG: f64 = 8.2 + 4.0 * 0.5;
/// Spring of one wheel, N/m: 3 mm of travel under the robot's weight.
const SPRING: f64 = 8000.0;
/// Damper of one wheel, N s/m: 0.56 of the critical damping for a quarter of the mass.
const DAMPER: f64 = 160.0;
/// Largest load of one wheel, N: four times the robot's weight. It bounds the kick of a wheel that
/// is pressed deep into the ground.
const MAX_LOAD_N: f64 = 400.0;
/// Free length of the suspension below the hub, wheel radius included, metres.
const REACH_M: f64 = 0.065;
/// Height above the hub at which a wheel's ray begins, metres. A wheel that is pressed into the
/// ground still finds it.
const LIFT_M: f64 = 0.05;
/// Friction of rubber on asphalt.
const TYRE_FRICTION: f64 = 0.9;
/// Friction of the hull and of the world's solids.
const HULL_FRICTION: f64 = 0.3;
/// Slip at which the friction of a tyre is saturated, m/s. Friction that jumps at zero slip would
/// make a standing robot tremble.
const SATURATION: f64 = 0.05;
/// Height of the hull's lowest point above the ground, metres.
const CLEARANCE_M: f64 = 0.045;

/// A wheel.
#[derive(Clone, Copy)]
struct Wheel {
    /// Its hub relative to the middle of the chassis, metres.
    x: f64,
    y: f64,
    side: Side,
    /// Its radius relative to the described one.
    radius: f64,
    /// Friction below it, relative to that on asphalt.
    grip: f64,
}

impl Wheel {
    const fn at(x: f64, y: f64, side: Side) -> Self {
        Self {
            x,
            y,
            side,
            radius: 1.0,
            grip: 1.0,
        }
    }

    fn with_defects(self, defects: &Defects) -> Self {
        Self {
            y: self.y * defects.track,
            radius: match self.side {
                Side::Left => defects.left_wheel,
                Side::Right => defects.right_wheel,
            },
            ..self
        }
    }
}

#[derive(Clone, Copy)]
enum Side {
    Left,
    Right,
}

const WHEELS: [Wheel; 4] = [
    Wheel::at(0.1, 0.13, Side::Left),
    Wheel::at(0.1, -0.13, Side::Right),
    Wheel::at(-0.1, 0.13, Side::Left),
    Wheel::at(-0.1, -0.13, Side::Right),
];

/// A contact of the robot's hull in one physics step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Contact {
    /// Class of the object that is touched.
    pub(crate) class: SemanticClass,
    /// Impulse along the normal, N s.
    pub(crate) impulse: f64,
}

/// The robot in the physical world.
pub(crate) struct Physics {
    world: PhysicsWorld,
    body: RigidBodyHandle,
    hull: ColliderHandle,
    movers: Bodies,
    classes: Arc<[SemanticClass]>,
    motors: Motors,
    wheels: [Wheel; 4],
    wheel_radius: f64,
    chassis_height: f64,
}

/// Speeds of the wheels' rims and the limits of the motors that turn them.
struct Motors {
    /// Rim speeds, m/s.
    left: f64,
    right: f64,
    /// Effective track, metres.
    track: f64,
    /// Limits of the commanded velocity, m/s and rad/s.
    max_forward: f64,
    max_backward: f64,
    max_turn: f64,
    /// Largest acceleration of a rim, m/s².
    max_acceleration: f64,
}

impl Motors {
    fn new(robot: &RobotDescription) -> Self {
        Self {
            left: 0.0,
            right: 0.0,
            track: robot.effective_track,
            max_forward: robot.max_forward,
            max_backward: robot.max_backward,
            max_turn: robot.max_turn,
            max_acceleration: robot.max_acceleration,
        }
    }

    /// Brings the rims' speeds towards those of the commanded velocity, as fast as the motors can.
    /// NaN and infinity count as zero.
    fn drive(&mut self, command: Velocity) {
        // The limits of velocity apply to the command, that of acceleration to each rim.
        let linear = or_zero(command.linear).clamp(-self.max_backward, self.max_forward);
        let turn = or_zero(command.angular).clamp(-self.max_turn, self.max_turn) * self.track / 2.0;
        let change = self.max_acceleration * STEP_S;
        self.left += (linear - turn - self.left).clamp(-change, change);
        self.right += (linear + turn - self.right).clamp(-change, change);
    }

    fn rim(&self, side: Side) -> f64 {
        match side {
            Side::Left => self.left,
            Side::Right => self.right,
        }
    }
}

fn or_zero(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

impl Physics {
    /// Puts the robot at `start` among solids, its wheels on the ground at height `ground`, metres.
    pub(crate) fn new(
        solids: &Solids,
        robot: &RobotDescription,
        defects: &Defects,
        start: Pose2,
        ground: f64,
    ) -> Self {
        // The engine is built for double precision, so that a body kilometres from the origin moves
        // as one near it.
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, 0.0, -GRAVITY);
        world.integration_parameters.dt = STEP_S;
        let ground_collider = ColliderBuilder::new(solids.mesh.clone()).friction(HULL_FRICTION);
        world.insert_collider(ground_collider, None);
        // The body's origin is at the height of the hubs; `base_link` is below it on the ground.
        let chassis_height = robot.wheel_radius;
        let pose = upright(start, ground + chassis_height);
        // A sleeping body would not feel the forces of its wheels.
        let body = RigidBodyBuilder::dynamic().pose(pose).can_sleep(false);
        let half_height = (robot.height - CLEARANCE_M) / 2.0;
        let middle = CLEARANCE_M + half_height - chassis_height;
        let hull = ColliderBuilder::cuboid(robot.length / 2.0, robot.width / 2.0, half_height)
            .translation(Vector::new(0.0, 0.0, middle))
            .friction(HULL_FRICTION)
            .mass(MASS_KG);
        let (body, hull) = world.insert(body, hull);
        Self {
            world,
            body,
            hull,
            movers: Bodies::default(),
            classes: solids.classes.clone(),
            motors: Motors::new(robot),
            wheels: WHEELS.map(|wheel| wheel.with_defects(defects)),
            wheel_radius: robot.wheel_radius,
            chassis_height,
        }
    }

    /// Puts the robot on the ground elsewhere, at rest.
    pub(crate) fn put(&mut self, place: Pose2, ground: f64) {
        let body = &mut self.world.bodies[self.body];
        body.set_position(upright(place, ground + self.chassis_height), true);
        body.set_linvel(Vector::ZERO, true);
        body.set_angvel(Vector::ZERO, true);
        (self.motors.left, self.motors.right) = (0.0, 0.0);
    }

    /// Advances by one step towards the commanded velocity.
    pub(crate) fn step(&mut self, caster: &RayCaster, command: Velocity) {
        // Forces and goals of movers hold for the engine's next step, so they are set before it.
        self.motors.drive(command);
        self.push_wheels(caster);
        self.movers.advance(&mut self.world);
        self.world.step();
    }

    /// Lets each tyre grip as the surface below it allows, at a wetness from 0 to 1.
    pub(crate) fn feel_surfaces(&mut self, caster: &RayCaster, wetness: f64) {
        let pose = *self.world.bodies[self.body].position();
        let (forward, left) = (pose.rotation * Vector::X, pose.rotation * Vector::Y);
        let up = pose.rotation * Vector::Z;
        for wheel in &mut self.wheels {
            let hub = pose.translation + forward * wheel.x + left * wheel.y;
            let length = (REACH_M + LIFT_M) as f32;
            let hit = caster.cast(single(hub + up * LIFT_M), single(up * -1.0), length);
            // A wheel in the air keeps what it had.
            if let Some(hit) = hit {
                wheel.grip = grip(caster.material(hit.triangle).class, wetness);
            }
        }
    }

    /// Adds the body of a mover. It takes part from the first [leg](Self::set_movers_out) on.
    pub(crate) fn add_mover(&mut self, mover: &Mover, look: u32) {
        self.movers.add(&mut self.world, mover, look);
    }

    /// Sends the movers' bodies on their next legs, in the order in which they were added; `None`
    /// for movers that are absent.
    pub(crate) fn set_movers_out(
        &mut self,
        robot: MapPoint,
        legs: impl Iterator<Item = Option<Leg>>,
    ) {
        self.movers.set_out(&mut self.world, robot, legs);
    }

    /// Pose of `base_link` in `map`.
    pub(crate) fn base_link(&self) -> Pose3 {
        let at = self.world.bodies[self.body].position();
        let (t, q) = (at.translation, at.rotation);
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z));
        let chassis = Pose3::from_parts(Translation3::new(t.x, t.y, t.z), rotation);
        chassis * Pose3::translation(0.0, 0.0, -self.chassis_height)
    }

    /// Velocity in `map` of the point at `offset` in `base_link`, m/s.
    pub(crate) fn velocity_at(&self, offset: Vector3<f64>) -> Vector3<f64> {
        let body = &self.world.bodies[self.body];
        let point = self.base_link() * nalgebra::Point3::from(offset);
        let v = body.velocity_at_point(Vector::new(point.x, point.y, point.z));
        Vector3::new(v.x, v.y, v.z)
    }

    /// Angular velocity in `map`, rad/s.
    pub(crate) fn angular_velocity(&self) -> Vector3<f64> {
        let w = self.world.bodies[self.body].angvel();
        Vector3::new(w.x, w.y, w.z)
    }

    pub(crate) fn wheel_speeds(&self) -> WheelSpeeds {
        WheelSpeeds {
            left: self.motors.left / self.wheel_radius,
            right: self.motors.right / self.wheel_radius,
        }
    }

    /// The hull's contact now: the impulse of all contacts, with the class of the deepest.
    pub(crate) fn contact(&self) -> Option<Contact> {
        let mut impulse = 0.0;
        let mut class = SemanticClass::Other;
        let mut nearest = f64::INFINITY;
        for pair in self.world.narrow_phase.contact_pairs_with(self.hull) {
            let PairContacts::Rigid(contacts) = &pair.contacts else {
                continue;
            };
            // The engine may solve clusters of contacts instead of the contacts: those hold the
            // impulses.
            let solved = contacts.solver_manifolds().iter().flat_map(|m| &m.points);
            impulse += solved.map(|p| p.data.impulse).sum::<f64>();
            let hull_is_second = pair.collider2 == self.hull;
            let other = if hull_is_second {
                pair.collider1
            } else {
                pair.collider2
            };
            for manifold in &contacts.manifolds {
                let distance = distance(manifold);
                if distance < nearest {
                    nearest = distance;
                    // A part of a triangle mesh is a triangle, numbered as in the scene's solid
                    // layer.
                    let triangle = if hull_is_second {
                        manifold.subshape1
                    } else {
                        manifold.subshape2
                    };
                    class = self.class(other, triangle as usize);
                }
            }
        }
        // Pairs without an impulse are near each other and do not touch.
        (impulse > 0.0).then_some(Contact { class, impulse })
    }

    /// Class of a mover, or of a triangle of the static world.
    fn class(&self, collider: ColliderHandle, triangle: usize) -> SemanticClass {
        self.movers.class(collider).unwrap_or_else(|| {
            self.classes
                .get(triangle)
                .copied()
                .unwrap_or(SemanticClass::Other)
        })
    }

    /// The body's state as bytes, for the hash chain.
    pub(crate) fn state_bytes(&self) -> Vec<u8> {
        let body = &self.world.bodies[self.body];
        let (p, v, w) = (body.position(), body.linvel(), body.angvel());
        let (t, q) = (p.translation, p.rotation);
        let rims = [self.motors.left, self.motors.right];
        [
            t.x, t.y, t.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y, w.z,
        ]
        .iter()
        .chain(&rims)
        .flat_map(|f| f.to_le_bytes())
        .collect()
    }

    /// Applies the forces of the suspension and of the tyres to the body.
    fn push_wheels(&mut self, caster: &RayCaster) {
        let body = &mut self.world.bodies[self.body];
        // Forces persist in the engine until they are reset.
        body.reset_forces(true);
        body.reset_torques(true);
        let pose = *body.position();
        // Skid steering comes out of this by itself: in a turn all four tyres slide sideways, and
        // the rims run faster than the body turns. That is why `effective_track` is wider than the
        // wheels are apart.
        let forward = pose.rotation * Vector::X;
        let left = pose.rotation * Vector::Y;
        let up = pose.rotation * Vector::Z;
        let down = up * -1.0;
        for wheel in &self.wheels {
            let hub = pose.translation + forward * wheel.x + left * wheel.y;
            let from = hub + up * LIFT_M;
            let length = (REACH_M + LIFT_M) as f32;
            // Wheels roll on solid triangles only: on no leaves, and on no movers. The ray is in
            // single precision, but on level ground its length depends on heights alone.
            let Some(hit) = caster.solid().cast(single(from), single(down), length) else {
                continue;
            };
            let distance = f64::from(hit.distance);
            let foot = from + down * distance;
            let velocity = body.velocity_at_point(foot);
            let travel = REACH_M + LIFT_M - distance;
            // A wheel pushes and never pulls: the ground does not hold it.
            let load = (SPRING * travel - DAMPER * velocity.dot(up)).clamp(0.0, MAX_LOAD_N);
            let slip_x = velocity.dot(forward) - wheel.radius * self.motors.rim(wheel.side);
            let slip_y = velocity.dot(left);
            let slip = (slip_x * slip_x + slip_y * slip_y).sqrt();
            // Both directions share one slip, so their forces together stay within the friction
            // circle. Below the saturation the force grows in proportion to the slip.
            let grip = wheel.grip * TYRE_FRICTION * load / slip.max(SATURATION);
            let force = up * load - forward * (grip * slip_x) - left * (grip * slip_y);
            body.add_force_at_point(force, foot, true);
        }
    }
}

/// Distance between the surfaces of a contact, metres; negative where they overlap.
fn distance(manifold: &ContactManifold) -> f64 {
    manifold
        .points
        .iter()
        .map(|p| p.dist)
        .fold(f64::INFINITY, f64::min)
}

fn single(v: Vector) -> [f32; 3] {
    v.to_array().map(|c| c as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rims_accelerate_no_faster_than_the_motors_can() {
        let mut motors = Motors::new(&RobotDescription::sentry());
        motors.drive(Velocity::new(0.5, 0.0));
        assert_eq!((motors.left, motors.right), (STEP_S, STEP_S));
        for _ in 0..1000 {
            motors.drive(Velocity::new(9.0, f64::NAN));
        }
        assert!((motors.left - 0.5).abs() < 1e-12 && motors.left == motors.right);
    }
}
