//! The robot's body on its four wheels, and what it bumps into.
//!
//! `rapier3d` integrates the body and solves its contacts with the world. A wheel is a ray: a spring and damper
//! along it carry the body, and at its foot Coulomb friction, made continuous near zero slip, pushes against the slip
//! between rim and ground in both directions. A turning skid-steer robot thus slides sideways over all four wheels, as
//! real ones do, and its wheels turn further than it moves.

use std::fmt;
use std::sync::Arc;

use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};
use openbench_core::{MapPoint, Pose2, Pose3, RobotDescription, Velocity};
use openbench_scene::{RayCaster, Scene, SemanticClass};
use rapier3d_f64::geometry::PairContacts;
use rapier3d_f64::pipeline::PhysicsWorld;
use rapier3d_f64::prelude::{
    ColliderBuilder, ColliderHandle, Pose, RigidBodyBuilder, RigidBodyHandle, SharedShape,
    TriMeshFlags, Vector,
};

use crate::SimError;
use crate::bodies::{Bodies, Leg};
use crate::clock::STEP_NS;
use crate::traffic::Mover;

const DT: f64 = STEP_NS as f64 * 1e-9;
const GRAVITY: f64 = 9.8;
/// Mass of chassis and wheels, kg.
const MASS: f64 = 8.2 + 4.0 * 0.5;
/// Wheel hubs relative to the chassis's middle, metres.
const HUBS: [(f64, f64); 4] = [(0.1, 0.13), (0.1, -0.13), (-0.1, 0.13), (-0.1, -0.13)];
/// Spring of one wheel, N/m: 3 mm of travel under the robot's weight.
const SPRING: f64 = 8000.0;
/// Damper of one wheel, N s/m.
const DAMPER: f64 = 160.0;
/// Free length of the suspension below the hub, wheel radius included, metres.
const REACH: f64 = 0.065;
/// Friction of rubber on asphalt.
const FRICTION: f64 = 0.9;
/// Slip at which friction is saturated, m/s.
const SATURATION: f64 = 0.05;
/// Lowest point of the body above the ground, metres.
const CLEARANCE: f64 = 0.045;

/// A touch between the robot and something solid, in one physics step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// What was touched.
    pub class: SemanticClass,
    /// Impulse along the normal, N s.
    pub impulse: f64,
}

/// The robot in the physical world.
pub struct Physics {
    world: PhysicsWorld,
    body: RigidBodyHandle,
    hull: ColliderHandle,
    movers: Bodies,
    classes: Arc<[SemanticClass]>,
    track: f64,
    limits: Limits,
    /// Rim speeds, left and right, m/s.
    rims: [f64; 2],
    radius: f64,
    chassis_height: f64,
}

struct Limits {
    forward: f64,
    backward: f64,
    turn: f64,
    acceleration: f64,
}

/// The solid part of a world as the physics engine wants it: made once, shared by all episodes in it.
#[derive(Clone)]
pub struct Solids {
    mesh: SharedShape,
    classes: Arc<[SemanticClass]>,
}

impl Solids {
    /// The solid triangles of a scene.
    pub fn new(scene: &Scene) -> Result<Self, SimError> {
        let solid = &scene.solid;
        if solid.triangles.is_empty() {
            return Err(SimError::NothingSolid);
        }
        let vertices = solid
            .positions
            .iter()
            .map(|p| Vector::from_array(p.map(f64::from)))
            .collect();
        let mesh = SharedShape::trimesh_with_flags(
            vertices,
            solid.triangles.clone(),
            TriMeshFlags::empty(),
        )
        .map_err(|e| SimError::Mesh(e.to_string()))?;
        Ok(Self {
            mesh,
            classes: solid.classes.as_slice().into(),
        })
    }
}

impl fmt::Debug for Solids {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Solids({} triangles)", self.classes.len())
    }
}

impl Physics {
    /// Puts the robot at `start` among solids, its wheels on the ground at height `ground`.
    pub fn new(solids: &Solids, robot: &RobotDescription, start: Pose2, ground: f64) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, 0.0, -GRAVITY);
        world.integration_parameters.dt = DT;
        world.insert_collider(
            ColliderBuilder::new(solids.mesh.clone()).friction(0.3),
            None,
        );
        let classes = solids.classes.clone();
        let chassis_height = robot.wheel_radius;
        let z = ground + chassis_height;
        let (sin, cos) = libm::sincos(start.yaw / 2.0);
        let rotation = rapier3d_f64::math::Rotation::from_xyzw(0.0, 0.0, sin, cos);
        let at = Pose::from_parts(Vector::new(start.x, start.y, z), rotation);
        let body = RigidBodyBuilder::dynamic().pose(at).can_sleep(false);
        let half_height = (robot.height - CLEARANCE) / 2.0;
        let middle = CLEARANCE + half_height - chassis_height;
        let hull = ColliderBuilder::cuboid(robot.length / 2.0, robot.width / 2.0, half_height)
            .translation(Vector::new(0.0, 0.0, middle))
            .friction(0.3)
            .mass(MASS);
        let (body, hull) = world.insert(body, hull);
        let limits = Limits {
            forward: robot.max_forward,
            backward: robot.max_backward,
            turn: robot.max_turn,
            acceleration: robot.max_acceleration,
        };
        let (track, radius) = (robot.effective_track, robot.wheel_radius);
        Self {
            world,
            body,
            hull,
            movers: Bodies::default(),
            classes,
            track,
            limits,
            rims: [0.0; 2],
            radius,
            chassis_height,
        }
    }

    /// Advances by one step towards the wanted velocity.
    pub fn step(&mut self, caster: &RayCaster, wanted: Velocity) {
        self.drive(wanted);
        self.push_wheels(caster);
        self.movers.advance(&mut self.world);
        self.world.step();
    }

    /// Adds a body that moves by itself. It takes no part yet.
    pub(crate) fn add_mover(&mut self, mover: &Mover, look: u32) {
        self.movers.add(&mut self.world, mover, look);
    }

    /// Sends those bodies on their next legs, in the order in which they were added; `None` for who is not there.
    pub(crate) fn set_movers_out(
        &mut self,
        robot: MapPoint,
        legs: impl Iterator<Item = Option<Leg>>,
    ) {
        self.movers.set_out(&mut self.world, robot, legs);
    }

    /// Pose of `base_link`.
    pub fn base_link(&self) -> Pose3 {
        let at = self.world.bodies[self.body].position();
        let (t, q) = (at.translation, at.rotation);
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z));
        let chassis = Pose3::from_parts(Translation3::new(t.x, t.y, t.z), rotation);
        chassis * Pose3::translation(0.0, 0.0, -self.chassis_height)
    }

    /// Velocity of the point at `offset` from `base_link` (in its axes), m/s in `map`.
    pub fn velocity_at(&self, offset: Vector3<f64>) -> Vector3<f64> {
        let body = &self.world.bodies[self.body];
        let point = self.base_link() * nalgebra::Point3::from(offset);
        let v = body.velocity_at_point(Vector::new(point.x, point.y, point.z));
        Vector3::new(v.x, v.y, v.z)
    }

    /// Angular velocity, rad/s in `map`.
    pub fn angular_velocity(&self) -> Vector3<f64> {
        let w = self.world.bodies[self.body].angvel();
        Vector3::new(w.x, w.y, w.z)
    }

    /// Angular speeds of the left and right wheels, rad/s.
    pub fn wheel_speeds(&self) -> [f64; 2] {
        self.rims.map(|rim| rim / self.radius)
    }

    /// What the robot's hull touches now: the impulse of all touches, ascribed to what is touched deepest.
    pub fn contact(&self) -> Option<Contact> {
        let pairs = self.world.narrow_phase.contact_pairs_with(self.hull);
        let (mut impulse, mut deepest) = (0.0, (f64::INFINITY, SemanticClass::Other));
        for pair in pairs {
            let PairContacts::Rigid(contacts) = &pair.contacts else {
                continue;
            };
            let solved = contacts.solver_manifolds().iter().flat_map(|m| &m.points);
            impulse += solved.map(|p| p.data.impulse).sum::<f64>();
            for manifold in &contacts.manifolds {
                let hull_is_second = pair.collider2 == self.hull;
                let triangle = if hull_is_second {
                    manifold.subshape1
                } else {
                    manifold.subshape2
                } as usize;
                let depth = manifold
                    .points
                    .iter()
                    .map(|p| p.dist)
                    .fold(f64::INFINITY, f64::min);
                if depth < deepest.0 {
                    let other = if hull_is_second {
                        pair.collider1
                    } else {
                        pair.collider2
                    };
                    let standing = || {
                        self.classes
                            .get(triangle)
                            .copied()
                            .unwrap_or(SemanticClass::Other)
                    };
                    deepest = (depth, self.movers.class(other).unwrap_or_else(standing));
                }
            }
        }
        (impulse > 0.0).then_some(Contact {
            class: deepest.1,
            impulse,
        })
    }

    /// The body's state as bytes, for the hash chain.
    pub fn state_bytes(&self) -> Vec<u8> {
        let body = &self.world.bodies[self.body];
        let (p, v, w) = (body.position(), body.linvel(), body.angvel());
        let (t, q) = (p.translation, p.rotation);
        [
            t.x,
            t.y,
            t.z,
            q.x,
            q.y,
            q.z,
            q.w,
            v.x,
            v.y,
            v.z,
            w.x,
            w.y,
            w.z,
            self.rims[0],
            self.rims[1],
        ]
        .iter()
        .flat_map(|f| f.to_le_bytes())
        .collect()
    }

    /// Brings the rims' speeds towards what the wanted velocity asks for, as fast as the motors can.
    fn drive(&mut self, wanted: Velocity) {
        let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
        let linear = finite(wanted.linear).clamp(-self.limits.backward, self.limits.forward);
        let turn =
            finite(wanted.angular).clamp(-self.limits.turn, self.limits.turn) * self.track / 2.0;
        let change = self.limits.acceleration * DT;
        for (rim, target) in self.rims.iter_mut().zip([linear - turn, linear + turn]) {
            *rim += (target - *rim).clamp(-change, change);
        }
    }

    fn push_wheels(&mut self, caster: &RayCaster) {
        let body = &mut self.world.bodies[self.body];
        body.reset_forces(true);
        body.reset_torques(true);
        let pose = *body.position();
        let axis = |v: Vector| pose.rotation * v;
        let (forward, left, up) = (axis(Vector::X), axis(Vector::Y), axis(Vector::Z));
        for (i, (x, y)) in HUBS.into_iter().enumerate() {
            let hub = pose.translation + forward * x + left * y;
            // From a little above the hub, so that a wheel pressed into the ground still finds it.
            let lift = 0.05;
            let (from, down) = (hub + up * lift, up * -1.0);
            let single = |v: Vector| v.to_array().map(|c| c as f32);
            let hit = caster
                .solid()
                .cast(single(from), single(down), (REACH + lift) as f32);
            let Some(hit) = hit else { continue };
            let distance = f64::from(hit.distance);
            let foot = from + down * distance;
            let velocity = body.velocity_at_point(foot);
            let travel = REACH + lift - distance;
            let load = (SPRING * travel - DAMPER * velocity.dot(up)).clamp(0.0, 400.0);
            let slip_x = velocity.dot(forward) - self.rims[i % 2];
            let slip_y = velocity.dot(left);
            let slip = (slip_x * slip_x + slip_y * slip_y).sqrt();
            let grip = FRICTION * load / slip.max(SATURATION);
            let force = up * load - forward * (grip * slip_x) - left * (grip * slip_y);
            body.add_force_at_point(force, foot, true);
        }
    }
}
