//! People and cars as bodies: the robot bumps into them, and they do not give way to its weight.
//!
//! Only those near the robot take part; a city's traffic costs the physics engine nothing.

use openbench_core::{MapPoint, Pose2};
use openbench_scene::SemanticClass;
use rapier3d_f64::pipeline::PhysicsWorld;
use rapier3d_f64::prelude::{
    ColliderBuilder, ColliderHandle, Pose, RigidBodyBuilder, RigidBodyHandle, SharedShape, Vector,
};

use crate::clock::{OBSERVATION_NS, STEP_NS};
use crate::traffic::{Hull, Mover, figures};

/// Bodies further from the robot than this take no part, metres: no car's end reaches the robot from there within a leg.
const NEAR: f64 = 8.0;
/// Height of a person, metres.
const PERSON_HEIGHT: f64 = 1.75;

/// A straight piece of a mover's way, from one observation to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leg {
    pub(crate) from: Pose2,
    pub(crate) to: Pose2,
    /// Height of the ground, metres.
    pub(crate) ground: f64,
}

/// Physics steps in a leg.
const STEPS: u64 = OBSERVATION_NS / STEP_NS;

struct Slot {
    body: RigidBodyHandle,
    collider: ColliderHandle,
    class: SemanticClass,
    /// The way that it goes now; `None` if it takes no part.
    leg: Option<Leg>,
}

/// The movers' bodies.
#[derive(Default)]
pub(crate) struct Bodies {
    slots: Vec<Slot>,
    /// Steps done of the present leg.
    done: u64,
}

impl Bodies {
    /// Adds the body of a mover that is drawn as number `look` of its kind. It takes no part yet.
    pub(crate) fn add(&mut self, world: &mut PhysicsWorld, mover: &Mover, look: u32) {
        let (collider, class) = match mover.hull {
            Hull::Disc { radius } => (person(radius), SemanticClass::Person),
            Hull::Box { .. } => (car(look), SemanticClass::Vehicle),
        };
        let collider = collider.friction(0.3).enabled(false);
        let (body, collider) = world.insert(RigidBodyBuilder::kinematic_position_based(), collider);
        self.slots.push(Slot {
            body,
            collider,
            class,
            leg: None,
        });
    }

    /// Sets out on new legs, one for each body in the order in which they were added; `None` for who is not there.
    pub(crate) fn set_out(
        &mut self,
        world: &mut PhysicsWorld,
        robot: MapPoint,
        legs: impl Iterator<Item = Option<Leg>>,
    ) {
        self.done = 0;
        for (slot, leg) in self.slots.iter_mut().zip(legs) {
            let near = leg.filter(|leg| leg.to.point().distance(robot) < NEAR);
            if near.is_some() != slot.leg.is_some() {
                world.colliders[slot.collider].set_enabled(near.is_some());
                if let Some(leg) = near {
                    world.bodies[slot.body].set_position(pose(&leg, 0.0), true);
                }
            }
            slot.leg = near;
        }
    }

    /// Goes on by one step.
    pub(crate) fn advance(&mut self, world: &mut PhysicsWorld) {
        self.done += 1;
        let share = self.done as f64 / STEPS as f64;
        for slot in &self.slots {
            if let Some(leg) = &slot.leg {
                world.bodies[slot.body].set_next_kinematic_position(pose(leg, share));
            }
        }
    }

    /// What a collider belongs to, if it is one of these.
    pub(crate) fn class(&self, collider: ColliderHandle) -> Option<SemanticClass> {
        self.slots
            .iter()
            .find(|slot| slot.collider == collider)
            .map(|slot| slot.class)
    }
}

/// A cylinder on the ground. Those of the engine stand along y.
fn person(radius: f64) -> ColliderBuilder {
    let half = PERSON_HEIGHT / 2.0;
    ColliderBuilder::new(SharedShape::cylinder(half, radius))
        .translation(Vector::new(0.0, 0.0, half))
        .rotation(Vector::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0))
}

/// The convex hull of what is drawn: a robot meets a car where its sensors see one.
fn car(look: u32) -> ColliderBuilder {
    let solid = figures::car(look).solid;
    let corners: Vec<Vector> = solid
        .positions
        .iter()
        .map(|p| Vector::from_array(p.map(f64::from)))
        .collect();
    ColliderBuilder::new(
        SharedShape::convex_hull(&corners).expect("a car's corners lie in no plane"),
    )
}

/// Where a body is after a share of its leg.
fn pose(leg: &Leg, share: f64) -> Pose {
    let between = |a: f64, b: f64| a + share * (b - a);
    let turned = openbench_core::frames::wrap_angle(leg.to.yaw - leg.from.yaw);
    let (sin, cos) = libm::sincos((leg.from.yaw + share * turned) / 2.0);
    let rotation = rapier3d_f64::math::Rotation::from_xyzw(0.0, 0.0, sin, cos);
    let at = Vector::new(
        between(leg.from.x, leg.to.x),
        between(leg.from.y, leg.to.y),
        leg.ground,
    );
    Pose::from_parts(at, rotation)
}
