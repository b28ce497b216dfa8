//! What a robot could achieve that knows all but the future.

use nalgebra::{Point3, Vector3};
use openbench_core::{
    Action, Address, Agent, Briefing, Events, FailureCause, GiveUp, Observation, Pose2,
    RobotDescription, SimTime, Velocity,
};
use openbench_scene::bvh::{LANES, MISS};
use openbench_scene::{FreeSpace, RayPacket};
use openbench_sim::Stage;

use super::errands::{Errands, Stop, give_up};
use super::following::Follower;
use crate::run::truth::{Instant, Truth, TruthHandle};

/// Clearance beside the footprint where there is room for it, metres. The judge's shortest paths
/// are drawn on a grid of 0.1 m, and a footprint that follows them may graze what they pass.
const CLEARANCE_M: f64 = 0.05;
/// A robot whose middle is off free ground by at most this much is taken to be on it, metres.
const OFF_GROUND_M: f64 = 1.0;
/// The way with clearance may end so far from the approach point, metres.
const OFF_APPROACH_M: f64 = 0.2;
/// Distance in front of the robot's middle that must be free of people and cars, metres.
const AHEAD_M: f32 = 1.2;
/// Heights at which somebody is looked for, metres.
const HEIGHTS_M: [f64; 2] = [0.3, 0.9];

/// Follows the shortest path to the nearest door of its instruction, declares the delivery there,
/// and goes on to the next one. It waits for people and cars in front of it, and does not evade
/// them.
pub(super) struct Omniscient {
    handle: TruthHandle,
    /// Where there is room for the clearance.
    roomy: FreeSpace,
    /// Where the footprint fits.
    free_space: FreeSpace,
    stage: Stage,
    robot: RobotDescription,
    errands: Errands,
    leg: Option<Leg>,
}

/// The way to a door.
struct Leg {
    address: Address,
    follower: Follower,
}

impl Omniscient {
    /// For an episode.
    pub(super) fn new(truth: &Truth<'_>) -> Self {
        let (stage, robot) = (&truth.prepared.stage, &truth.prepared.robot);
        let start = truth.prepared.world.start.point();
        let radius = robot.circumscribed_radius() + CLEARANCE_M;
        Self {
            handle: truth.handle.clone(),
            roomy: FreeSpace::new(stage.caster(), start, radius),
            free_space: truth.prepared.free_space.clone(),
            stage: truth.prepared.stage.clone(),
            robot: truth.prepared.robot.clone(),
            errands: Errands::of(truth),
            leg: None,
        }
    }

    /// The way from a pose to a stop; `None` if there is none.
    fn leg(&self, pose: Pose2, stop: &Stop) -> Option<Leg> {
        let to = stop.approach?;
        let path = |space: &FreeSpace| {
            let from = space.nearest_reachable(pose.point(), OFF_GROUND_M)?;
            let near = space.nearest_reachable(to, OFF_APPROACH_M)?;
            space.path(from, near)
        };
        let path = path(&self.roomy).or_else(|| path(&self.free_space))?;
        Some(Leg {
            address: stop.address.clone(),
            follower: Follower::new(path),
        })
    }

    /// Begins the next leg; an action if there is nothing to drive to.
    fn set_out(&mut self, pose: Pose2) -> Option<Action> {
        let Some(stop) = self.errands.take_nearest(pose.point()) else {
            let detail = "no door is left";
            return Some(give_up(None, FailureCause::UnknownAddress, detail));
        };
        self.leg = self.leg(pose, &stop);
        self.leg.is_none().then(|| {
            let detail = "no path leads to the door";
            give_up(Some(stop.address), FailureCause::NoRoute, detail)
        })
    }

    /// Whether somebody stands or moves in front of the robot.
    fn sees_somebody(&self, time: SimTime) -> bool {
        let instant = self.handle.instant(time).unwrap_or_default();
        if instant.movers.is_empty() {
            return false;
        }
        let rays = self.rays_ahead(&instant);
        let snapshot = self.stage.snapshot(&instant.movers);
        let hits = snapshot.cast_packet(&rays, &[0.0; LANES]);
        hits.mover.iter().any(|mover| *mover != MISS)
    }

    /// Rays straight ahead over the width of the robot, at the heights of knees and chests.
    fn rays_ahead(&self, instant: &Instant) -> RayPacket {
        let base = instant.base_link;
        let ahead = (base.rotation * Vector3::x()).cast::<f32>();
        let half_width = self.robot.circumscribed_radius();
        let columns = LANES / HEIGHTS_M.len();
        let mut rays = RayPacket::idle();
        for lane in 0..LANES {
            let across = (lane % columns) as f64 / (columns - 1) as f64;
            let side = half_width * (2.0 * across - 1.0);
            let from = base * Point3::new(0.0, side, HEIGHTS_M[lane / columns]);
            let from = from.cast::<f32>();
            rays.set(lane, from.into(), ahead.into(), AHEAD_M);
        }
        rays
    }
}

impl Agent for Omniscient {
    fn begin(&mut self, _: &Briefing, _: &mut dyn Events) -> Result<(), GiveUp> {
        Ok(())
    }

    fn act(&mut self, observation: &Observation<'_>, _: &mut dyn Events) -> Action {
        let pose = self.handle.pose_at(observation.time);
        let is_blocked = self.sees_somebody(observation.time);
        if self.leg.is_none()
            && let Some(action) = self.set_out(pose)
        {
            return action;
        }
        let Some(leg) = &mut self.leg else {
            return Action::Drive(Velocity::ZERO);
        };
        match leg.follower.velocity(pose, &self.robot) {
            Some(velocity) if is_blocked => Action::Drive(Velocity::new(0.0, velocity.angular)),
            Some(velocity) => Action::Drive(velocity),
            None => {
                let address = leg.address.clone();
                self.leg = None;
                Action::Delivered(address)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::scenery::{NOTHING_SENSED, PEOPLED, truth_with};
    use super::*;

    /// What the agent does at the start, when it looks along its way, with somebody so far ahead.
    fn speed_with_somebody(ahead: Option<f64>) -> f64 {
        let start = PEOPLED.world.start.point();
        let towards = |yaw| Pose2::new(start.x, start.y, yaw);
        let stop = Errands::of(&truth_with(towards(0.0), None))
            .take_nearest(start)
            .unwrap();
        let path = PEOPLED.free_space.path(start, stop.approach.unwrap());
        let yaw = start.bearing_to(path.unwrap()[1]);
        let person = ahead.map(|ahead| start.offset(yaw, ahead));
        let mut agent = Omniscient::new(&truth_with(towards(yaw), person));
        match agent.act(&NOTHING_SENSED.observation(), &mut Vec::new()) {
            Action::Drive(velocity) => velocity.linear,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn it_waits_for_whoever_is_in_front_of_it() {
        assert!(speed_with_somebody(None) > 0.1);
        assert_eq!(speed_with_somebody(Some(1.0)), 0.0);
        // Too far ahead to wait for, and behind it.
        assert!(speed_with_somebody(Some(3.0)) > 0.1);
        assert!(speed_with_somebody(Some(-1.0)) > 0.1);
    }
}
