//! The robot as an agent knows it.

use serde::{Deserialize, Serialize};

use crate::distortion::Distortion;
use crate::frames::Pose3;
use crate::sensors::CameraIntrinsics;

/// Size, sensor poses and limits of the robot. Poses are relative to `base_link`.
///
/// ```
/// use openbench_core::RobotDescription;
///
/// let robot = RobotDescription::sentry();
/// assert_eq!((robot.max_forward, robot.max_turn), (0.5, 1.0));
/// assert!((robot.circumscribed_radius() - 0.223).abs() < 1e-3);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotDescription {
    /// Length of the footprint along x, metres, wheels included.
    pub length: f64,
    /// Width of the footprint along y, metres, wheels included.
    pub width: f64,
    /// Height, metres.
    pub height: f64,
    /// Radius of the wheels, metres.
    pub wheel_radius: f64,
    /// Distance between the centres of the left and right wheels, metres.
    pub wheel_separation: f64,
    /// Separation that gives a skid-steered robot's turn rate from its wheels' speeds, metres. It
    /// is larger than the wheels' own, because they slide sideways in turns.
    pub effective_track: f64,
    /// Largest forward speed, m/s.
    pub max_forward: f64,
    /// Largest backward speed, m/s.
    pub max_backward: f64,
    /// Largest turn rate, rad/s.
    pub max_turn: f64,
    /// Largest acceleration of the wheels' rims, m/s².
    pub max_acceleration: f64,
    /// Pose of the inertial measurement unit.
    pub imu: Pose3,
    /// Pose of the LiDAR.
    pub lidar: Pose3,
    /// Pose of the camera, x forward.
    pub camera: Pose3,
    /// Size and field of view of the camera's images.
    pub camera_intrinsics: CameraIntrinsics,
    /// Pose of the satellite receiver's antenna; `None` without a receiver, as in the built-in
    /// suites.
    #[serde(default)]
    pub gnss: Option<Pose3>,
}

impl RobotDescription {
    /// The robot of the OpenBench paper (its `sentry_robot_sim.xacro`). Heights there count from
    /// the middle of the chassis; here from the ground, `wheel_radius` below it.
    pub fn sentry() -> Self {
        let at = |x, z| Pose3::translation(x, 0.0, z);
        Self {
            length: 0.32,
            width: 0.31,
            height: 0.3,
            wheel_radius: 0.06,
            wheel_separation: 0.26,
            effective_track: 0.414,
            max_forward: 0.5,
            max_backward: 0.2,
            max_turn: 1.0,
            max_acceleration: 1.0,
            // Each height is the wheel's radius plus the height above the middle of the chassis.
            imu: at(0.12, 0.06 + 0.125),
            lidar: at(0.12, 0.06 + 0.175),
            camera: at(0.15, 0.06 + 0.2),
            camera_intrinsics: CameraIntrinsics {
                width: 640,
                height: 480,
                // 80 degrees.
                horizontal_fov: 1.3963,
                distortion: Distortion::default(),
            },
            gnss: None,
        }
    }

    /// The same robot with a satellite receiver, its antenna on top behind the LiDAR.
    pub fn with_gnss(self) -> Self {
        Self {
            gnss: Some(Pose3::translation(-0.1, 0.0, self.height)),
            ..self
        }
    }

    /// Radius of the smallest circle about `base_link` that holds the footprint, metres.
    pub fn circumscribed_radius(&self) -> f64 {
        libm::hypot(self.length, self.width) / 2.0
    }

    /// Radius of the largest circle about `base_link` inside the footprint, metres.
    pub fn inscribed_radius(&self) -> f64 {
        self.length.min(self.width) / 2.0
    }
}
