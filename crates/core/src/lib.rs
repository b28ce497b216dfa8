#![doc = include_str!("../README.md")]
//!
//! | module | contents |
//! |---|---|
//! | [`frames`] | [`MapPoint`], [`LonLat`], [`Pose2`], [`Pose3`], [`Georeference`] |
//! | [`time`] | [`SimTime`]: simulated time in nanoseconds |
//! | [`sensors`] | [`LidarScan`], [`ImuSample`], [`WheelSample`], [`Image`], [`Camera`] |
//! | [`sensed`] | [`Sensed`]: an observation that can be kept and sent |
//! | [`distortion`] | [`Distortion`]: how a lens bends straight lines |
//! | [`robot`] | [`RobotDescription`]: size, sensor poses and limits of the robot |
//! | [`address`] | [`Address`]: building and unit |
//! | [`plan`] | [`Plan`], [`PlannedDelivery`], [`TravelTimes`]: deliveries in driving order |
//! | [`stage`] | [`Stage`]: what an agent is doing about a delivery |
//! | [`start`] | [`Start`]: what an agent knows about where it starts |
//! | [`agent`] | [`Agent`], [`Briefing`], [`Observation`], [`Action`]: the contract |
//! | [`health`] | [`Health`], [`Doubt`]: how far an estimated pose can be trusted |
//! | [`input`] | reading files that users name |
//! | [`model_use`] | [`ModelUse`]: use of language and vision models |
//! | [`registry`] | [`Registry`]: exchangeable parts by name |
//! | [`causes`] | [`with_causes`]: an error and its causes as text |
//! | [`comparison`] | [`MapComparison`]: what an agent finds when it looks for itself on its map |
//! | [`events`] | [`Event`], [`Events`]: what an agent reports for the log |
//! | [`work`] | [`Work`]: what an agent computes |

pub mod address;
pub mod agent;
pub mod causes;
pub mod comparison;
pub mod distortion;
pub mod events;
pub mod frames;
pub mod health;
pub mod input;
pub mod model_use;
pub mod plan;
pub mod registry;
pub mod robot;
pub mod sensed;
pub mod sensors;
pub mod stage;
pub mod start;
pub mod time;
pub mod work;

pub use address::Address;
pub use agent::{Action, Agent, Briefing, FailureCause, GiveUp, Goal, Observation, Velocity};
pub use causes::with_causes;
pub use comparison::{AcceptedPose, Hypothesis, MapComparison, PlaceScores};
pub use distortion::{Distortion, PlanePoint};
pub use events::{CostGrid, Discard, Event, Events, PoseEstimate};
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
pub use stage::Stage;
pub use start::Start;
pub use time::SimTime;
pub use work::Work;
