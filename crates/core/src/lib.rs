//! The words that everyone in OpenBench speaks: frames and poses, simulated time, sensor messages, and the contract
//! between a benchmark and an agent. Types and traits only; the algorithms live in the crates above.
//!
//! | module | what it names |
//! |---|---|
//! | [`frames`] | [`MapPoint`], [`LonLat`], [`Pose2`], [`Pose3`], [`Georeference`]: where things are |
//! | [`time`] | [`SimTime`]: when, in simulated nanoseconds |
//! | [`sensors`] | [`LidarScan`], [`ImuSample`], [`WheelSample`], [`GnssFix`], [`Image`], [`Camera`]: what the robot perceives |
//! | [`sensed`] | [`Sensed`]: an observation that can be kept and sent |
//! | [`registry`] | [`Registry`]: exchangeable parts by name |
//! | [`robot`] | [`RobotDescription`]: size, sensor poses and limits of the robot |
//! | [`address`] | [`Address`]: building and unit |
//! | [`plan`] | [`Plan`], [`PlannedDelivery`], [`TravelTimes`]: what a language planner and a router exchange |
//! | [`agent`] | [`Agent`], [`Briefing`], [`Observation`], [`Action`]: the contract |
//! | [`health`] | [`Health`], [`Doubt`]: how far a pose can be trusted |
//! | [`model_use`] | [`ModelUse`]: what was asked of language and vision models |
//! | [`causes`] | [`with_causes`]: an error and its causes in words |
//! | [`events`] | [`Event`], [`Events`]: what an agent wishes to have recorded |

pub mod address;
pub mod agent;
pub mod causes;
pub mod events;
pub mod frames;
pub mod health;
pub mod model_use;
pub mod plan;
pub mod registry;
pub mod robot;
pub mod sensed;
pub mod sensors;
pub mod time;

pub use address::Address;
pub use agent::{Action, Agent, Briefing, FailureCause, GiveUp, Goal, Observation, Velocity};
pub use causes::with_causes;
pub use events::{Discard, Event, Events, PoseEstimate};
pub use frames::{Georeference, GeoreferenceError, LonLat, MapPoint, Pose2, Pose3};
pub use health::{Doubt, Health};
pub use model_use::ModelUse;
pub use plan::{
    AddressLevel, Deadline, Fallback, Level, Plan, PlanPart, PlannedDelivery, Step, StepMode,
    TravelTimes,
};
pub use registry::{Registry, UnknownName};
pub use robot::RobotDescription;
pub use sensed::Sensed;
pub use sensors::{
    Camera, CameraIntrinsics, GnssFix, Image, ImuSample, LidarPoint, LidarScan, WheelSample,
};
pub use time::SimTime;
