#![doc = include_str!("../README.md")]
//!
//! | module | job |
//! |---|---|
//! | `simulator` | [`Simulator`]: everything together, one observation at a time |
//! | `stage`, `solids`, `bounds` | [`Stage`]: a world prepared for simulation |
//! | `physics`, `wheels` | the body on its wheels, and its contacts |
//! | `collision`, `left_world` | [`Collision`], [`LeftWorld`]: what goes wrong |
//! | [`lidar`] | the Livox MID-360 |
//! | `defects` | [`Defects`]: how a robot differs from its description |
//! | `imu`, `encoders` | inertial measurement unit and wheel encoders |
//! | `camera`, `exposure` | the robot's camera and its automatic exposure |
//! | `surroundings` | [`Surroundings`]: faults of camera and LiDAR, light and weather |
//! | `weather` | [`Weather`]: rain, fog and wet ground |
//! | `real_camera`, `optics` | a camera with faults: [`CameraErrors`] |
//! | `daylight` | [`Daylight`]: the light of any day and hour, and of lamps |
//! | `gnss` | the satellite receiver of a robot that has one |
//! | `render` | [`Renderer`]: images of a scene |
//! | [`traffic`] | people and cars that move, and how near the robot came to them |
//! | `crowd`, `bodies` | people and cars as rays and the physics engine meet them |
//! | [`noise`] | seeded random numbers |
//! | `clock` | steps of simulated time |
//! | `rounding` | rounding down in vector instructions |

mod bodies;
mod bounds;
mod camera;
mod clock;
mod collision;
mod crowd;
mod daylight;
mod defects;
mod encoders;
mod error;
mod exposure;
mod gnss;
mod imu;
mod left_world;
pub mod lidar;
pub mod noise;
mod optics;
mod physics;
mod real_camera;
mod render;
mod rounding;
mod simulator;
mod solids;
mod stage;
mod surroundings;
pub mod traffic;
mod weather;
mod wheels;

pub use clock::OBSERVATION_NS;
pub use collision::Collision;
pub use daylight::Daylight;
pub use defects::{Defects, Mount};
pub use error::SimError;
pub use left_world::LeftWorld;
pub use optics::{CameraErrors, LensBuild, LensDrop};
pub use render::{ImageSize, Labels, Renderer, View};
pub use simulator::Simulator;
pub use stage::Stage;
pub use surroundings::Surroundings;
pub use weather::Weather;
