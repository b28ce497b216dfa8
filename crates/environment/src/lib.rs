#![doc = include_str!("../README.md")]
//! ## Modules
//!
//! | module | content |
//! |---|---|
//! | `options` | [`Options`]: what is observed, asked and rewarded |
//! | `world` | [`World`]: a suite ready for many environments |
//! | `environment` | [`Environment`]: reset and step |
//! | `many` | [`Environments`]: several on several threads |
//! | `observation` | [`Observation`]: what a policy gets, as arrays |
//! | `range_image` | a scan as an image of distances |
//! | `adapter` | [`Adapter`]: sensor data to observations, actions to velocities |
//! | `course` | what the robot drives during an action |
//! | `beginning` | where episodes of training begin |
//! | `progress` | [`WayField`](progress::WayField): how far it is from anywhere to a door |
//! | `error` | [`EnvironmentError`] |

mod adapter;
mod beginning;
mod course;
mod environment;
mod error;
mod many;
mod observation;
mod options;
pub mod progress;
mod range_image;
mod world;

pub use adapter::Adapter;
pub use environment::{Environment, Outcome, Step};
pub use error::EnvironmentError;
pub use many::{AfterEnd, Beginning, Environments, ResettingStep};
pub use observation::Observation;
pub use options::{
    Actions, Declaration, Observe, Options, PoseSource, RangeImage, Rewards, StartDistance,
};
pub use world::World;
