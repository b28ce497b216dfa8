//! People and cars as bodies of the physics engine. The robot collides with them and cannot push
//! them away.
//!
//! Only movers near the robot take part, so the traffic of a town costs the physics engine nothing.

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2};
use openbench_scene::SemanticClass;
use rapier3d_f64::math::Rotation;
use rapier3d_f64::pipeline::PhysicsWorld;
use rapier3d_f64::prelude::{
    ColliderBuilder, ColliderHandle, Pose, RigidBodyBuilder, RigidBodyHandle, SharedShape, Vector,
};

use crate::clock::{OBSERVATION_NS, STEP_NS};
use crate::traffic::{Hull, Mover, car_figure};

/// Bodies farther than this from the robot take no part, metres. No end of a car reaches the robot
/// from there within one leg.
const NEAR_M: f64 = 8.0;
/// Height of a person, metres.
const PERSON_HEIGHT_M: f64 = 1.75;
/// Friction of people and cars.
const FRICTION: f64 = 0.3;
/// Physics steps in a leg.
const STEPS: u64 = OBSERVATION_NS / STEP_NS;

/// The straight motion of a mover from one observation to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leg {
    pub(crate) from: Pose2,
    pub(crate) to: Pose2,
    /// Height of the ground, metres.
    pub(crate) ground: f64,
}

impl Leg {
    /// The pose after a share of the leg, 0 to 1.
    fn at(&self, share: f64) -> Pose2 {
        let turned = wrap_angle(self.to.yaw - self.from.yaw);
        Pose2::new(
            self.from.x + share * (self.to.x - self.from.x),
            self.from.y + share * (self.to.y - self.from.y),
            self.from.yaw + share * turned,
        )
    }
}

struct Slot {
    body: RigidBodyHandle,
    collider: ColliderHandle,
    class: SemanticClass,
    /// The present leg; `None` for a body that takes no part.
    leg: Option<Leg>,
}

/// The bodies of all movers.
#[derive(Default)]
pub(crate) struct Bodies {
    slots: Vec<Slot>,
    /// Physics steps done of the present leg.
    done: u64,
}

impl Bodies {
    /// Adds the body of a mover that is drawn as number `look` of its kind. It takes no part yet.
    pub(crate) fn add(&mut self, world: &mut PhysicsWorld, mover: &Mover, look: u32) {
        let (collider, class) = match mover.hull {
            Hull::Disc { radius } => (person(radius), SemanticClass::Person),
            Hull::Box { .. } => (car(look), SemanticClass::Vehicle),
        };
        // A kinematic body follows its leg whatever touches it, so the robot cannot push it.
        let collider = collider.friction(FRICTION).enabled(false);
        let body = RigidBodyBuilder::kinematic_position_based();
        let (body, collider) = world.insert(body, collider);
        self.slots.push(Slot {
            body,
            collider,
            class,
            leg: None,
        });
    }

    /// Starts new legs, one for each body in the order in which they were added; `None` for movers
    /// that are absent.
    pub(crate) fn set_out(
        &mut self,
        world: &mut PhysicsWorld,
        robot: MapPoint,
        legs: impl Iterator<Item = Option<Leg>>,
    ) {
        self.done = 0;
        for (slot, leg) in self.slots.iter_mut().zip(legs) {
            let near = leg.filter(|leg| leg.to.point().distance(robot) < NEAR_M);
            // A body that begins to take part is set down; one that stops is left where it is.
            if near.is_some() != slot.leg.is_some() {
                world.colliders[slot.collider].set_enabled(near.is_some());
                if let Some(leg) = near {
                    // Not as the goal of a step: the engine would derive a huge speed from the
                    // jump.
                    world.bodies[slot.body].set_position(upright(leg.at(0.0), leg.ground), true);
                }
            }
            slot.leg = near;
        }
    }

    /// Advances the legs by one physics step.
    pub(crate) fn advance(&mut self, world: &mut PhysicsWorld) {
        self.done += 1;
        let share = self.done as f64 / STEPS as f64;
        for slot in &self.slots {
            if let Some(leg) = &slot.leg {
                let pose = upright(leg.at(share), leg.ground);
                world.bodies[slot.body].set_next_kinematic_position(pose);
            }
        }
    }

    /// Class of the mover that a collider belongs to, if it belongs to one.
    pub(crate) fn class(&self, collider: ColliderHandle) -> Option<SemanticClass> {
        self.slots
            .iter()
            .find(|slot| slot.collider == collider)
            .map(|slot| slot.class)
    }
}

/// A cylinder on the ground. Those of the engine stand along y.
fn person(radius: f64) -> ColliderBuilder {
    let half = PERSON_HEIGHT_M / 2.0;
    ColliderBuilder::new(SharedShape::cylinder(half, radius))
        .translation(Vector::new(0.0, 0.0, half))
        .rotation(Vector::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0))
}

/// The convex hull of a car's solid triangles, so that the robot touches it where its sensors see
/// it.
fn car(look: u32) -> ColliderBuilder {
    let solid = car_figure(look).solid;
    let corners: Vec<Vector> = solid
        .positions
        .iter()
        .map(|p| Vector::from_array(p.map(f64::from)))
        .collect();
    let hull = SharedShape::convex_hull(&corners).expect("a car's corners span a volume");
    ColliderBuilder::new(hull)
}

/// A pose on the ground at height `z`, metres, in the types of the physics engine.
pub(crate) fn upright(at: Pose2, z: f64) -> Pose {
    let (sin, cos) = libm::sincos(at.yaw / 2.0);
    let rotation = Rotation::from_xyzw(0.0, 0.0, sin, cos);
    Pose::from_parts(Vector::new(at.x, at.y, z), rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leg_turns_the_shorter_way_round() {
        let (from, to) = (Pose2::new(0.0, 0.0, 3.1), Pose2::new(1.0, 0.0, -3.1));
        let half = Leg {
            from,
            to,
            ground: 0.0,
        }
        .at(0.5);
        assert!((half.x - 0.5).abs() < 1e-12);
        assert!((half.yaw - std::f64::consts::PI).abs() < 1e-9, "{half:?}");
    }
}
