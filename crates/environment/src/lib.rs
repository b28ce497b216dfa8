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
//! | `course` | what the robot drives during an action |
//! | `beginning` | where episodes of training begin |
//! | `progress` | [`WayField`](progress::WayField): how far it is from anywhere to a door |
//! | `error` | [`EnvironmentError`] |

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

pub use environment::{Environment, Outcome, Step};
pub use error::EnvironmentError;
pub use many::{AfterEnd, Beginning, Environments, ResettingStep};
pub use observation::Observation;
pub use options::{
    Actions, Declaration, Observe, Options, PoseSource, RangeImage, Rewards, StartDistance,
};
pub use world::World;
