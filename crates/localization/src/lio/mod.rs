//! LiDAR-inertial odometry: how the sensors have moved since the start, from an IMU, the points of
//! a LiDAR, and wheels.
//!
//! After FAST-LIO2 (W. Xu et al. 2021) and FAST-LIO (W. Xu, F. Zhang 2021) for the filter, and
//! VoxelMap (C. Yuan et al. 2022) for the map. The IMU predicts the motion, and thereby where each
//! point was measured. The points' distances from the planes of a map correct the prediction, in an
//! iterated Kalman filter on the manifold of the state.
//!
//! [`LidarInertialOdometry`] is the entry point; `pipeline` shows what becomes of a scan.
//!
//! | module | contents |
//! |---|---|
//! | `settings`, `noise` | [`Settings`], [`ImuNoise`], [`LidarNoise`]: what the sensors are like |
//! | `estimate` | [`Estimate`], [`Status`], [`Refused`]: what the odometry reports |
//! | [`state`], `belief` | what is estimated, on its manifold; that at an instant |
//! | `saturation`, `impacts` | IMU readings at the sensor's limits, and during impacts |
//! | `speed`, `wheel_speeds`, `velocity_update` | wheels' velocities |
//! | `propagation`, `inertial` | motion predicted from the IMU |
//! | `unmeasured_turn` | what a saturated gyroscope does not show |
//! | `reckoning`, `watchdog` | motion by wheels and gyroscope alone; the filter compared with it |
//! | `undistortion` | points as if all were measured at the end of a scan |
//! | [`moments`] | sums over points |
//! | [`planes`] | the map: planes in cubes |
//! | [`matching`] | which points lie on which planes |
//! | `plane_measurement`, `degeneracy` | what these points measure, and what not |
//! | `iterated_update`, `registration` | the filter's update; matching and update in turn |
//! | `scan_match`, `noise_scale` | how well a scan lies on the map; how noisy the LiDAR is |
//! | `drift` | how far off the map is by now, and how it is tilted |
//! | `start` | the first state |
//! | `trust` | whether the sensors contradict each other; the restart of a diverged filter |
//! | `pipeline`, `without_scan` | what becomes of a scan; how the odometry goes on without one |
//! | `odometry` | what waits for what |

mod belief;
mod degeneracy;
mod drift;
mod estimate;
mod impacts;
mod inertial;
mod iterated_update;
pub mod matching;
pub mod moments;
mod noise;
mod noise_scale;
mod odometry;
mod pipeline;
mod plane_measurement;
pub mod planes;
mod propagation;
mod reckoning;
mod registration;
mod saturation;
mod scan_match;
mod settings;
mod speed;
mod start;
pub mod state;
mod trust;
mod undistortion;
mod unmeasured_turn;
mod velocity_update;
mod watchdog;
mod wheel_speeds;
mod without_scan;

pub use estimate::{Estimate, Refused, Status};
pub use noise::{ImuNoise, LidarNoise};
pub use odometry::LidarInertialOdometry;
pub use settings::{ImuLimits, Settings};
pub use speed::Speed;
