//! The simulated robot, its sensors and its world, in lock-step and deterministic: simulated time moves only in
//! [`Simulator::step`], and the same world, seed and velocities give the same bytes.
//!
//! | module | its one job |
//! |---|---|
//! | [`simulator`] | [`Stage`] and [`Simulator`]: everything together, one observation at a time |
//! | [`physics`] | the body on its wheels, and what it bumps into |
//! | [`lidar`] | the MID-360 |
//! | [`inertial`] | IMU and wheel encoders |
//! | `camera`, [`exposure`] | the robot's camera, and how much light it lets in |
//! | [`gnss`] | the satellite receiver, where a robot has one |
//! | [`render`] | pictures |
//! | [`noise`] | seeded random numbers |
//! | `clock` | how time passes |
//! | `rounding` | rounding down in vector instructions |
//! | `crowd`, `bodies` | what moves by itself, as rays and the physics engine meet it |
//! | [`traffic`] | people and cars that move, how they look, and how near the robot came to them |

mod bodies;
mod camera;
mod clock;
mod crowd;
pub mod exposure;
pub mod gnss;
pub mod inertial;
pub mod lidar;
pub mod noise;
pub mod physics;
pub mod render;
mod rounding;
pub mod simulator;
pub mod traffic;

pub use clock::OBSERVATION_NS;
pub use render::{Labels, Renderer, View};
pub use simulator::{Collision, LeftWorld, Simulator, Stage};

/// Why a world cannot be simulated.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SimError {
    /// There is nothing to stand on.
    #[error(
        "the world has no solid surface, not even ground; add a ground plane with a collision shape"
    )]
    NothingSolid,
    /// The physics engine refuses the solid triangles.
    #[error("the world's solid triangles cannot be simulated: {0}")]
    Mesh(String),
    /// More shall move than the stage has figures for.
    #[error("the stage has no figures for so many people and cars; make it with `Stage::peopled`")]
    NoFigures,
}
