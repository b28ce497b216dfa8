//! Whether a motion keeps the whole footprint off all obstacles, all the time.

use openbench_core::{Pose2, Velocity};

use crate::kinematics::Motion;
use crate::limits::Limits;
use crate::shape::{Footprint, Obstacle, standing};
use crate::trajectory::Trajectory;

/// Seconds between two checks along a motion: at 0.5 m/s and 1 rad/s no corner moves further than 4
/// cm.
const CHECK_S: f64 = 0.05;
/// A motion that begins nearer to an obstacle than it should keeps this share of the distance:
/// moving away gains much, and little can be lost.
const KEPT_SHARE: f64 = 0.5;
/// Distance that a motion which begins inside an obstacle may lose to rounding, metres.
const ROUNDING_M: f64 = 1e-6;
/// Checks along one motion, at most.
const MOST_CHECKS: usize = 10_000;

/// The clearance that a motion which begins with `clearance` may not fall below, metres.
fn floor(clearance: f64, margin: f64) -> f64 {
    if clearance > 0.0 {
        margin.min(KEPT_SHARE * clearance)
    } else {
        clearance - ROUNDING_M
    }
}

/// How near to one obstacle a motion may come.
struct Floor {
    /// The obstacle's number.
    obstacle: usize,
    /// Metres.
    least: f64,
}

/// How near to each obstacle a motion may come: `margin`, except to those that it begins nearer to.
pub(crate) struct Floors {
    margin: f64,
    /// Obstacles that the motion begins near to. A distance gained from one does not make up for
    /// another.
    near: Vec<Floor>,
}

impl Floors {
    /// The floors of a motion that begins at `pose`.
    pub(crate) fn new<'a>(
        footprint: &Footprint,
        obstacles: impl Iterator<Item = &'a Obstacle>,
        pose: Pose2,
        margin: f64,
    ) -> Self {
        let (placed, circle) = (footprint.at(pose), footprint.circumscribed());
        // Further away the floor is the margin itself.
        let reach = margin / KEPT_SHARE;
        let near = obstacles.enumerate().filter_map(|(number, obstacle)| {
            let contact = obstacle.contact(&placed, circle, 0.0, reach)?;
            (contact.distance < reach).then(|| Floor {
                obstacle: number,
                least: floor(contact.distance, margin),
            })
        });
        Self {
            margin,
            near: near.collect(),
        }
    }

    /// Whether a pose `seconds` ahead keeps off all obstacles; distance gained until then counts
    /// from here on.
    pub(crate) fn keep<'a>(
        &mut self,
        footprint: &Footprint,
        obstacles: impl Iterator<Item = &'a Obstacle>,
        pose: Pose2,
        seconds: f64,
    ) -> bool {
        let (placed, circle, reach) = (
            footprint.at(pose),
            footprint.circumscribed(),
            self.margin / KEPT_SHARE,
        );
        for (i, obstacle) in obstacles.enumerate() {
            let contact = obstacle.contact(&placed, circle, seconds, reach);
            // Without a contact the distance is at least `reach`, which is above every floor.
            let distance = contact.map_or(reach, |c| c.distance);
            let near = self.near.iter_mut().find(|floor| floor.obstacle == i);
            let least = near.as_ref().map_or(self.margin, |floor| floor.least);
            if distance < least {
                return false;
            }
            if let Some(near) = near {
                // A floor only rises: what has moved away may not come back.
                near.least = near.least.max(floor(distance, self.margin));
            }
        }
        true
    }
}

/// Distance from the footprint at `pose` to the nearest obstacle as it will be after `seconds`,
/// metres: `reach` at most, negative inside.
pub fn clearance<'a>(
    footprint: &Footprint,
    obstacles: impl Iterator<Item = &'a Obstacle>,
    pose: Pose2,
    seconds: f64,
    reach: f64,
) -> f64 {
    let (placed, circle) = (footprint.at(pose), footprint.circumscribed());
    let near = obstacles.filter_map(|o| o.contact(&placed, circle, seconds, reach));
    near.map(|contact| contact.distance).fold(reach, f64::min)
}

/// Seconds in which any robot stops.
const LONGEST_STOP_S: f64 = 20.0;
/// Seconds between two checks of a robot that brakes.
const STOP_STEP_S: f64 = 0.025;

/// Looks for conflicts of a robot's motions with obstacles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ConflictCheck<'a> {
    /// The robot's outline.
    pub(crate) footprint: &'a Footprint,
    /// What the robot can do.
    pub(crate) limits: &'a Limits,
    /// Standing and moving obstacles.
    pub(crate) obstacles: &'a [Obstacle],
    /// A motion that comes nearer to an obstacle than this has a conflict, metres. One that begins
    /// nearer may move away.
    pub(crate) margin: f64,
}

impl ConflictCheck<'_> {
    /// Seconds until the first conflict on a trajectory that is driven no faster than the robot's
    /// limits; `None` if there is none.
    pub(crate) fn first_conflict(&self, trajectory: &Trajectory) -> Option<f64> {
        // Moving obstacles are met when the robot can be there, not when the band promises it.
        let driven = trajectory.slowed(self.limits);
        let obstacles = || self.obstacles.iter();
        let start = driven.pose_at(0.0);
        let mut floors = Floors::new(self.footprint, obstacles(), start, self.margin);
        let checks = (driven.duration() / CHECK_S).ceil() as usize;
        let mut times =
            (1..=checks.min(MOST_CHECKS)).map(|i| driven.duration().min(i as f64 * CHECK_S));
        let met = times
            .find(|&time| !floors.keep(self.footprint, obstacles(), driven.pose_at(time), time));
        // What is not checked is not known to be free.
        met.or_else(|| (checks > MOST_CHECKS).then_some(MOST_CHECKS as f64 * CHECK_S))
    }

    /// Seconds until a conflict with a standing obstacle, if the robot is driven as commanded for
    /// `hold` seconds and then brakes; `None` if it stops before.
    ///
    /// Moving obstacles are left out: to stop in somebody's path is worse than to be gone.
    pub(crate) fn conflict_before_stop(&self, motion: Motion, hold: f64) -> Option<f64> {
        let standing = || standing(self.obstacles);
        let mut motion = motion;
        let mut floors = Floors::new(self.footprint, standing(), motion.pose, self.margin);
        let mut time = 0.0;
        // A robot that does not come to stand, with an impossible speed, counts as one that
        // collides.
        let longest = hold + LONGEST_STOP_S;
        while time < hold || !motion.stands() {
            if time > longest {
                return Some(time);
            }
            if time >= hold {
                motion.command = Velocity::ZERO;
            }
            motion.step(self.limits, STOP_STEP_S);
            time += STOP_STEP_S;
            if !floors.keep(self.footprint, standing(), motion.pose, 0.0) {
                return Some(time);
            }
        }
        None
    }
}
