//! How far the robot differs from its description.

use openbench_sim::noise::Noise;
use openbench_sim::{Defects, Mount};
use serde::{Deserialize, Serialize};

use super::level::{Condition, check_ranges};

/// Stream of random numbers, distinct from those of sensors, traffic, fixes and starts.
const RANDOM_STREAM: u64 = 34;

/// How far the robot differs from its description: standard deviations, unless a number is said to
/// be exact.
///
/// ```
/// use openbench_bench::suite::RobotErrors;
///
/// let errors = RobotErrors { wheel_radius: 0.01, ..RobotErrors::default() };
/// let robot = errors.draw(7);
/// assert!(robot.left_wheel != 1.0 && (robot.left_wheel - 1.0).abs() < 0.06);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RobotErrors {
    /// Error of the radius of the wheels of each side, a share of it.
    pub wheel_radius: f64,
    /// Error of the distance between left and right wheels, a share of it.
    pub wheel_track: f64,
    /// Error of the position of IMU, LiDAR and camera along each axis, millimetres.
    pub sensor_mm: f64,
    /// Error of their orientation about each axis, degrees.
    pub sensor_deg: f64,
    /// How much the clock of the LiDAR differs from the others, milliseconds.
    pub clock_ms: f64,
    /// Marks on the disc of each encoder, exact.
    pub encoder_marks: u32,
    /// Angle by which a motor turns before its wheel follows, when it is reversed, degrees, exact.
    pub backlash_deg: f64,
    /// Whether tyres grip less on pavements and grass than on asphalt, and less on wet ground.
    pub slips: bool,
}

impl RobotErrors {
    const EXACT: Self = Self {
        wheel_radius: 0.0,
        wheel_track: 0.0,
        sensor_mm: 0.0,
        sensor_deg: 0.0,
        clock_ms: 0.0,
        encoder_marks: 2048,
        backlash_deg: 0.0,
        slips: false,
    };

    /// A robot.
    pub fn draw(&self, seed: u64) -> Defects {
        let mut noise = Noise::new(seed, RANDOM_STREAM);
        // In this order whatever is off, so that one number changes nothing about the others.
        let [left, right, track, clock] = std::array::from_fn(|_| noise.normal());
        let [imu, lidar, camera] = std::array::from_fn(|_| self.mount(&mut noise));
        Defects {
            left_wheel: relative(self.wheel_radius * left),
            right_wheel: relative(self.wheel_radius * right),
            track: relative(self.wheel_track * track),
            imu,
            lidar,
            camera,
            lidar_clock_ms: self.clock_ms * clock,
            encoder_marks: self.encoder_marks,
            backlash_rad: self.backlash_deg.to_radians(),
            slips: self.slips,
        }
    }

    fn mount(&self, noise: &mut Noise) -> Mount {
        Mount {
            offset_mm: std::array::from_fn(|_| self.sensor_mm * noise.normal()),
            turn_deg: std::array::from_fn(|_| self.sensor_deg * noise.normal()),
        }
    }
}

/// A length relative to the described one: no wheel vanishes or doubles.
fn relative(error: f64) -> f64 {
    (1.0 + error).clamp(0.5, 1.5)
}

impl Default for RobotErrors {
    fn default() -> Self {
        Self::EXACT
    }
}

impl Condition for RobotErrors {
    const KEY: &'static str = "robot";
    const LEVELS: &'static [(&'static str, Self)] = &[
        ("exact", Self::EXACT),
        (
            "calibrated",
            Self {
                wheel_radius: 0.003,
                wheel_track: 0.01,
                sensor_mm: 2.0,
                sensor_deg: 0.2,
                clock_ms: 1.0,
                slips: true,
                ..Self::EXACT
            },
        ),
        (
            "worn",
            Self {
                wheel_radius: 0.01,
                wheel_track: 0.03,
                sensor_mm: 5.0,
                sensor_deg: 0.5,
                clock_ms: 5.0,
                encoder_marks: 512,
                backlash_deg: 1.0,
                slips: true,
            },
        ),
    ];

    fn check(&self) -> Result<(), String> {
        let numbers = [
            ("wheel_radius", self.wheel_radius, 0.2),
            ("wheel_track", self.wheel_track, 0.2),
            ("sensor_mm", self.sensor_mm, 100.0),
            ("sensor_deg", self.sensor_deg, 30.0),
            ("clock_ms", self.clock_ms, 50.0),
            ("backlash_deg", self.backlash_deg, 30.0),
        ];
        check_ranges(&numbers)?;
        if self.encoder_marks == 0 {
            return Err("encoder_marks = 0: give at least 1".to_owned());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_without_errors_is_as_described() {
        assert_eq!(RobotErrors::EXACT.draw(5), Defects::default());
    }

    #[test]
    fn one_number_changes_nothing_about_the_others() {
        let worn = RobotErrors::LEVELS[2].1;
        let less = RobotErrors {
            wheel_radius: 0.0,
            clock_ms: 0.0,
            ..worn
        };
        let (worn, less) = (worn.draw(5), less.draw(5));
        assert_eq!((worn.camera, worn.track), (less.camera, less.track));
        assert_eq!((less.left_wheel, less.lidar_clock_ms), (1.0, 0.0));
        assert_ne!(worn.left_wheel, worn.right_wheel);
    }
}
