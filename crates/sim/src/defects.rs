//! How a robot differs from its description: what calibration leaves, and what wears off.

use nalgebra::{Translation3, UnitQuaternion};
use openbench_core::{Pose3, SimTime};
use openbench_scene::SemanticClass;
use serde::{Deserialize, Serialize};

/// Marks on the disc of an encoder, unless a suite says otherwise.
const MARKS: u32 = 2048;

/// How a robot differs from its description. Agents get the description.
///
/// ```
/// use openbench_sim::Defects;
///
/// // The left wheels are worn: the robot drifts to the left, and its encoders do not see it.
/// let worn = Defects { left_wheel: 0.99, ..Defects::default() };
/// assert_ne!(worn, Defects::default());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Defects {
    /// Radius of the left wheels, relative to the described one.
    pub left_wheel: f64,
    /// Radius of the right wheels, relative to the described one.
    pub right_wheel: f64,
    /// Distance between left and right wheels, relative to the described one.
    pub track: f64,
    /// The inertial measurement unit, in the frame in which it is described.
    pub imu: Mount,
    /// The LiDAR, in the frame in which it is described.
    pub lidar: Mount,
    /// The camera, in the frame in which it is described.
    pub camera: Mount,
    /// How much later than the other clocks that of the LiDAR is, milliseconds.
    pub lidar_clock_ms: f64,
    /// Marks on the encoders' discs.
    pub encoder_marks: u32,
    /// Angle by which a motor turns before its wheel follows, when it is reversed, radians.
    pub backlash_rad: f64,
    /// Whether tyres grip less on pavements, gravel and grass than on asphalt, and less on wet
    /// ground.
    pub slips: bool,
}

impl Default for Defects {
    /// None: the robot is as described.
    fn default() -> Self {
        Self {
            left_wheel: 1.0,
            right_wheel: 1.0,
            track: 1.0,
            imu: Mount::default(),
            lidar: Mount::default(),
            camera: Mount::default(),
            lidar_clock_ms: 0.0,
            encoder_marks: MARKS,
            backlash_rad: 0.0,
            slips: false,
        }
    }
}

impl Defects {
    /// The stamp that the LiDAR gives to an instant.
    pub(crate) fn lidar_stamp(&self, time: SimTime) -> SimTime {
        let late = (self.lidar_clock_ms * 1e6).round() as i64;
        // Time begins at zero, so that stamps before it are zero.
        SimTime(time.0.saturating_add_signed(late))
    }
}

/// Where a sensor is, in the frame in which it is described.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Mount {
    /// Along x, y and z, millimetres.
    pub offset_mm: [f64; 3],
    /// About x, y and z, degrees, as a rotation vector.
    pub turn_deg: [f64; 3],
}

impl Mount {
    /// The pose of a sensor on the robot that is described at `pose`.
    pub fn of(&self, pose: Pose3) -> Pose3 {
        if *self == Self::default() {
            // Exactly the same, whatever the rounding of a product.
            return pose;
        }
        let [x, y, z] = self.offset_mm.map(|mm| mm * 1e-3);
        let turn = nalgebra::Vector3::from(self.turn_deg.map(f64::to_radians));
        let offset = Translation3::new(x, y, z);
        pose * Pose3::from_parts(offset, UnitQuaternion::from_scaled_axis(turn))
    }
}

/// Friction of rubber on a surface, relative to that on dry asphalt, at a wetness from 0 to 1.
pub(crate) fn grip(class: SemanticClass, wetness: f64) -> f64 {
    // Wong, Theory of Ground Vehicles, lists 0.8 to 0.9 on dry and 0.5 to 0.7 on wet asphalt, 0.68
    // on dry and 0.55 on wet earth.
    let (dry, wet) = match class.coarse() {
        // Grass and bare ground.
        SemanticClass::Ground | SemanticClass::Vegetation => (0.7, 0.65),
        // Slabs are smoother than asphalt.
        SemanticClass::Pavement | SemanticClass::Kerb => (0.85, 0.6),
        SemanticClass::Road => (1.0, 0.7),
        _ => (1.0, 1.0),
    };
    dry + wetness * (wet - dry)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mount_moves_and_turns_its_sensor() {
        let described = Pose3::translation(1.0, 0.0, 0.0);
        assert_eq!(Mount::default().of(described), described);
        let mount = Mount {
            offset_mm: [2.0, 0.0, 0.0],
            turn_deg: [0.0, 0.0, 90.0],
        };
        let pose = mount.of(described);
        assert!((pose.translation.vector.x - 1.002).abs() < 1e-12);
        let ahead = pose.rotation * nalgebra::Vector3::x();
        assert!((ahead.y - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_late_clock_gives_later_stamps() {
        let stamp = |late| {
            let defects = Defects {
                lidar_clock_ms: late,
                ..Defects::default()
            };
            defects.lidar_stamp(SimTime::from_millis(100))
        };
        assert_eq!(stamp(5.0), SimTime::from_millis(105));
        assert_eq!(stamp(-5.0), SimTime::from_millis(95));
        assert_eq!(stamp(-500.0), SimTime::ZERO);
    }
}
