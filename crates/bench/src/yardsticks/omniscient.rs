//! What a robot could achieve that knows all but the future.

use openbench_core::{
    Action, Address, Agent, Briefing, Events, FailureCause, GiveUp, LidarScan, Observation, Pose2,
    RobotDescription, SimTime, Velocity,
};
use openbench_scene::FreeSpace;

use super::errands::{Errands, Stop, give_up};
use super::following::Follower;
use crate::run::truth::{Truth, TruthHandle};

/// A robot whose middle is off free ground by at most this much is taken to be on it, metres.
const OFF_GROUND_M: f64 = 1.0;
/// Distance in front of the robot's middle that must be free of people and cars, metres.
const AHEAD_M: f64 = 1.2;
/// Heights above the LiDAR's ground at which a point is part of somebody, metres.
const BODY_M: [f64; 2] = [0.1, 2.0];

/// Follows the shortest path to the nearest door of its instruction, declares the delivery there,
/// and goes on to the next one. It waits for people and cars in front of it, and does not evade
/// them.
pub(super) struct Omniscient {
    handle: TruthHandle,
    free_space: FreeSpace,
    robot: RobotDescription,
    errands: Errands,
    leg: Option<Leg>,
    is_blocked: bool,
}

/// The way to a door.
struct Leg {
    address: Address,
    follower: Follower,
}

impl Omniscient {
    /// For an episode.
    pub(super) fn new(truth: &Truth<'_>) -> Self {
        Self {
            handle: truth.handle.clone(),
            free_space: truth.prepared.free_space.clone(),
            robot: truth.prepared.robot.clone(),
            errands: Errands::of(truth),
            leg: None,
            is_blocked: false,
        }
    }

    /// The way from a pose to a stop; `None` if there is none.
    fn leg(&self, pose: Pose2, stop: &Stop) -> Option<Leg> {
        let from = self
            .free_space
            .nearest_reachable(pose.point(), OFF_GROUND_M)?;
        let path = self.free_space.path(from, stop.approach?)?;
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
    fn sees_somebody(&self, scan: &LidarScan, time: SimTime) -> bool {
        let pose = self.handle.pose_at(time);
        let lidar = pose.to_pose3(0.0) * self.robot.lidar;
        let half_width = self.robot.circumscribed_radius();
        scan.points.iter().any(|point| {
            let at = lidar * nalgebra::Point3::from(point.xyz.map(f64::from));
            let ahead = pose.to_pose3(0.0).inverse() * at;
            (BODY_M[0]..BODY_M[1]).contains(&ahead.z)
                && (0.0..AHEAD_M).contains(&ahead.x)
                && ahead.y.abs() < half_width
                // Walls and trees are never on ground where the robot fits.
                && self.free_space.is_reachable(openbench_core::MapPoint::new(at.x, at.y))
        })
    }
}

impl Agent for Omniscient {
    fn begin(&mut self, _: &Briefing, _: &mut dyn Events) -> Result<(), GiveUp> {
        Ok(())
    }

    fn act(&mut self, observation: &Observation<'_>, _: &mut dyn Events) -> Action {
        let pose = self.handle.pose_at(observation.time);
        if let Some(scan) = observation.scan {
            self.is_blocked = self.sees_somebody(scan, observation.time);
        }
        if self.leg.is_none()
            && let Some(action) = self.set_out(pose)
        {
            return action;
        }
        let Some(leg) = &mut self.leg else {
            return Action::Drive(Velocity::ZERO);
        };
        match leg.follower.velocity(pose, &self.robot) {
            Some(velocity) if self.is_blocked => {
                Action::Drive(Velocity::new(0.0, velocity.angular))
            }
            Some(velocity) => Action::Drive(velocity),
            None => {
                let address = leg.address.clone();
                self.leg = None;
                Action::Delivered(address)
            }
        }
    }
}
