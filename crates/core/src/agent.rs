//! The contract between the benchmark and an agent.

use std::fmt;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::address::Address;
use crate::events::Events;
use crate::frames::{Georeference, MapPoint, Pose2};
use crate::robot::RobotDescription;
use crate::sensors::{Camera, GnssFix, Image, ImuSample, LidarScan, WheelSample};
use crate::start::Start;
use crate::time::SimTime;

/// The control program of a delivery robot. The benchmark calls [`begin`](Agent::begin) once, then
/// [`act`](Agent::act) every 50 ms of simulated time, then [`finish`](Agent::finish). An episode
/// ends when each delivery is declared or given up, or when its time is over.
///
/// An agent gets a [`Briefing`] and [`Observation`]s, nothing else. It reads no wall clock and
/// draws no unseeded random numbers: the same briefing and observations must give the same actions.
///
/// ```
/// use openbench_core::{
///     Action, Address, Agent, Briefing, Events, FailureCause, GiveUp, Goal, Observation, SimTime,
///     Velocity,
/// };
///
/// /// Drives straight ahead for a minute and puts the parcel down there.
/// struct Ahead {
///     address: Address,
/// }
///
/// impl Agent for Ahead {
///     fn begin(&mut self, briefing: &Briefing, _: &mut dyn Events) -> Result<(), GiveUp> {
///         let Goal::Instruction(instruction) = &briefing.goal else {
///             return Err(GiveUp {
///                 address: None,
///                 cause: FailureCause::Briefing,
///                 detail: "this agent takes instructions only".into(),
///             });
///         };
///         // A real agent reads the whole instruction, for example by `openbench_language`.
///         if instruction.contains("unit 2") {
///             self.address.unit = Some("unit2".into());
///         }
///         Ok(())
///     }
///
///     fn act(&mut self, observation: &Observation<'_>, _: &mut dyn Events) -> Action {
///         if observation.time < SimTime::from_millis(60_000) {
///             Action::Drive(Velocity::new(0.5, 0.0))
///         } else {
///             Action::Delivered(self.address.clone())
///         }
///     }
/// }
/// ```
pub trait Agent {
    /// Reads the map and the goal.
    ///
    /// # Errors
    /// An agent that cannot begin gives up the whole episode.
    fn begin(&mut self, briefing: &Briefing, events: &mut dyn Events) -> Result<(), GiveUp>;

    /// Decides what to do until the next observation.
    fn act(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action;

    /// The agent's copy of the map with its edits, as OSM XML, if it edits one.
    fn finish(&mut self, events: &mut dyn Events) -> Option<Vec<u8>> {
        let _ = events;
        None
    }
}

/// All information that an agent gets before an episode.
#[derive(Debug, Clone, PartialEq)]
pub struct Briefing {
    /// The public map, OSM XML. It has buildings and roads, but neither doors nor units: an agent
    /// finds those by reading plates.
    pub map_osm: Vec<u8>,
    /// Projection and origin of the `map` frame.
    pub georeference: Georeference,
    /// What to do in the episode.
    pub goal: Goal,
    /// What is known about the pose of the robot in `map`.
    pub start: Start,
    /// Sizes, sensors and limits of the robot.
    pub robot: RobotDescription,
    /// Simulated time that a delivery may take at most. It follows from the public map alone. The
    /// judge's limit may be shorter: it depends on the doors, so agents do not get it.
    pub time_limit: Duration,
}

impl Briefing {
    /// The pose at the start, for an agent that cannot find out where it is.
    ///
    /// # Errors
    /// The agent gives up the whole episode if it gets no pose.
    pub fn start_pose(&self) -> Result<Pose2, GiveUp> {
        self.start.pose().ok_or_else(|| GiveUp {
            address: None,
            cause: FailureCause::Lost,
            detail: format!("{}, and this agent cannot find out where it is", self.start),
        })
    }
}

/// The task of an agent.
#[derive(Debug, Clone, PartialEq)]
pub enum Goal {
    /// Deliver as this instruction in natural language says.
    Instruction(String),
    /// Drive to the place at which this image was taken.
    Image(Image),
    /// Drive to a point in `map`.
    Point(MapPoint),
}

/// The sensor data since the last observation.
pub struct Observation<'a> {
    /// Simulated time now.
    pub time: SimTime,
    /// IMU samples since the last observation, oldest first.
    pub imu: &'a [ImuSample],
    /// Wheel samples since the last observation, oldest first.
    pub wheels: &'a [WheelSample],
    /// The LiDAR scan, if one was completed since the last observation.
    pub scan: Option<&'a LidarScan>,
    /// The satellite fix, if the robot has a receiver and it got one since the last observation.
    pub gnss: Option<&'a GnssFix>,
    /// The camera. It renders an image only on request.
    pub camera: &'a dyn Camera,
}

impl fmt::Debug for Observation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Counts instead of samples: a scan has thousands of points. A camera would have to render.
        f.debug_struct("Observation")
            .field("time", &self.time)
            .field("imu", &self.imu.len())
            .field("wheels", &self.wheels.len())
            .field("scan", &self.scan.map(|s| s.points.len()))
            .field("gnss", &self.gnss)
            .finish_non_exhaustive()
    }
}

/// A commanded velocity in `base_link`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Velocity {
    /// Forward, m/s.
    pub linear: f64,
    /// Counter-clockwise, rad/s.
    pub angular: f64,
}

impl Velocity {
    /// Standing still.
    pub const ZERO: Self = Self {
        linear: 0.0,
        angular: 0.0,
    };

    /// A velocity from m/s and rad/s.
    pub const fn new(linear: f64, angular: f64) -> Self {
        Self { linear, angular }
    }
}

/// An agent's decision.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Drive with this velocity until the next observation. What is beyond the robot's limits is
    /// reduced to them.
    Drive(Velocity),
    /// Declares the parcel for this address delivered, here and now.
    ///
    /// The address must be one of the instruction, unit included. Another one fails the first
    /// delivery that is still open. A second declaration of the same address has no effect.
    Delivered(Address),
    /// Gives up a delivery, or all that are left. An address that is not in the instruction ends no
    /// delivery, but its cause is that of a target that the agent never mentions.
    GiveUp(GiveUp),
}

/// Why an agent gives up.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("{cause}: {detail}")]
pub struct GiveUp {
    /// The delivery that is given up, or `None` for all that are left.
    pub address: Option<Address>,
    /// The kind of cause.
    pub cause: FailureCause,
    /// Details of the cause, for people.
    pub detail: String,
}

/// Why a delivery failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureCause {
    /// The agent could not use its briefing, or does not take goals of that kind.
    Briefing,
    /// The instruction could not be understood.
    NotUnderstood,
    /// The map lacks the building in the instruction, or has several of that name.
    UnknownAddress,
    /// The language planner's model was unreachable, or its answer was unusable.
    PlannerUnavailable,
    /// The plate reader's model was unreachable, or its answer was unusable.
    ReaderUnavailable,
    /// The policy server was unreachable, or its answer was unusable.
    PolicyUnavailable,
    /// No route leads to the building.
    NoRoute,
    /// The robot could not move on.
    Stuck,
    /// The door was not found at any of the candidate places.
    DoorNotFound,
    /// The time was over.
    Timeout,
    /// The agent never declared this delivery.
    NotDeclared,
    /// The agent declared the delivery at the wrong place.
    WrongPlace,
    /// The agent failed with an error of its own.
    AgentError,
    /// The robot left the ground or the bounds of the world, or tipped over.
    LeftWorld,
    /// The agent lost its localization, or cannot find out where it starts.
    Lost,
}

impl fmt::Display for FailureCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Briefing => "unreadable briefing",
            Self::NotUnderstood => "instruction not understood",
            Self::UnknownAddress => "unknown address",
            Self::PlannerUnavailable => "planner failed",
            Self::ReaderUnavailable => "plate reader failed",
            Self::PolicyUnavailable => "policy server failed",
            Self::NoRoute => "no route",
            Self::Stuck => "stuck",
            Self::DoorNotFound => "door not found",
            Self::Timeout => "time over",
            Self::NotDeclared => "not declared",
            Self::WrongPlace => "wrong place",
            Self::AgentError => "agent failed",
            Self::LeftWorld => "left the world",
            Self::Lost => "lost",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn briefing(start: Start) -> Briefing {
        Briefing {
            map_osm: Vec::new(),
            georeference: Georeference::tangent_plane(crate::LonLat::default()),
            goal: Goal::Instruction(String::new()),
            start,
            robot: RobotDescription::sentry(),
            time_limit: Duration::ZERO,
        }
    }

    #[test]
    fn an_agent_that_needs_a_pose_gives_up_without_one() {
        let area = Start::Area {
            centre: MapPoint::new(1.0, 2.0),
            radius_m: 75.0,
        };
        let given_up = briefing(area).start_pose().unwrap_err();
        assert_eq!(given_up.cause, FailureCause::Lost);
        assert!(given_up.detail.contains("within 75 m of (1.00, 2.00)"));
        assert!(briefing(Start::Anywhere).start_pose().is_err());
        let pose = Pose2::new(1.0, 2.0, 0.5);
        assert_eq!(briefing(Start::exact(pose)).start_pose(), Ok(pose));
    }
}
