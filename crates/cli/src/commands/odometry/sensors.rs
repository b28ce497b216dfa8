//! What the sensors of a log's robot are like, from a file.

use std::path::Path;

use anyhow::{Context, ensure};
use nalgebra::{Translation3, UnitQuaternion};
use openbench_core::{ImuSample, Pose3, RobotDescription, input};
use openbench_localization::lidar_inertial::sensor_settings;
use openbench_localization::lio::{ImuLimits, Settings};
use serde::Deserialize;

/// A sensor's place on the robot.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct Mount {
    /// In `base_link`, metres.
    xyz: [f64; 3],
    /// Roll, pitch and yaw as in URDF, radians.
    #[serde(default)]
    rpy: [f64; 3],
}

impl Mount {
    fn pose(&self) -> Pose3 {
        let [roll, pitch, yaw] = self.rpy;
        Pose3::from_parts(
            Translation3::from(self.xyz),
            UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        )
    }

    fn is_sound(&self) -> bool {
        // Millimetres and degrees usually exceed these bounds, and NaN is below none.
        self.xyz.iter().all(|x| x.abs() < 100.0) && self.rpy.iter().all(|x| x.abs() < 10.0)
    }
}

/// The file. What is left out is as on the benchmark's robot.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    imu: Option<Mount>,
    lidar: Option<Mount>,
    imu_topic: Option<String>,
    lidar_topic: Option<String>,
    accel_unit: Option<f64>,
    gyro_noise: Option<f64>,
    accel_noise: Option<f64>,
    gyro_walk: Option<f64>,
    accel_walk: Option<f64>,
    imu_limits: Option<[f64; 2]>,
    range_noise: Option<f64>,
    angle_noise: Option<f64>,
    blind: Option<f64>,
    typical_speed: Option<f64>,
    #[serde(default)]
    estimate_lidar: bool,
}

/// The sensors, and which messages are theirs.
#[derive(Debug, Clone)]
pub struct Sensors {
    pub settings: Settings,
    imu_topic: Option<String>,
    lidar_topic: Option<String>,
    accel_unit: f64,
}

impl Sensors {
    /// Of the benchmark's robot, or as a file says.
    pub fn new(file: Option<&Path>) -> anyhow::Result<Self> {
        let Some(path) = file else {
            return File::default().sensors();
        };
        let text = input::read_text(path).with_context(|| path.display().to_string())?;
        let file: File = toml::from_str(&text).with_context(|| path.display().to_string())?;
        file.sensors().with_context(|| path.display().to_string())
    }

    /// Whether the IMU's messages come on that topic.
    pub fn imu_is_on(&self, topic: &str) -> bool {
        self.imu_topic.as_ref().is_none_or(|own| own == topic)
    }

    /// Whether the LiDAR's do.
    pub fn lidar_is_on(&self, topic: &str) -> bool {
        self.lidar_topic.as_ref().is_none_or(|own| own == topic)
    }

    /// A sample with its specific force in m/s².
    pub fn sample(&self, sample: ImuSample) -> ImuSample {
        ImuSample {
            accel: sample.accel.map(|a| a * self.accel_unit),
            ..sample
        }
    }
}

impl File {
    fn sensors(self) -> anyhow::Result<Sensors> {
        let robot = RobotDescription::sentry();
        let mut settings = sensor_settings(&robot);
        for mount in [self.imu, self.lidar].into_iter().flatten() {
            ensure!(
                mount.is_sound(),
                "a sensor's xyz is in metres, its rpy in radians"
            );
        }
        let imu = self.imu.map_or(robot.imu, |mount| mount.pose());
        let lidar = self.lidar.map_or(robot.lidar, |mount| mount.pose());
        // The file has both on the robot. The odometry takes the pose of the LiDAR on the IMU.
        (settings.imu, settings.lidar) = (imu, imu.inverse() * lidar);
        settings.estimate_lidar = self.estimate_lidar;
        settings.imu_limits = self
            .imu_limits
            .map(|[gyro, accel]| ImuLimits { gyro, accel });
        for limit in self.imu_limits.into_iter().flatten() {
            ensure!(
                limit.is_finite() && limit > 0.0,
                "imu_limits are rad/s and m/s² above 0"
            );
        }
        // What the file names replaces the value of the benchmark's robot.
        for (name, value, place) in [
            ("gyro_noise", self.gyro_noise, &mut settings.imu_noise.gyro),
            (
                "accel_noise",
                self.accel_noise,
                &mut settings.imu_noise.accel,
            ),
            (
                "gyro_walk",
                self.gyro_walk,
                &mut settings.imu_noise.gyro_walk,
            ),
            (
                "accel_walk",
                self.accel_walk,
                &mut settings.imu_noise.accel_walk,
            ),
            (
                "range_noise",
                self.range_noise,
                &mut settings.lidar_noise.range,
            ),
            (
                "angle_noise",
                self.angle_noise,
                &mut settings.lidar_noise.angle,
            ),
            ("blind", self.blind, &mut settings.min_range_m),
            (
                "typical_speed",
                self.typical_speed,
                &mut settings.typical_speed_m_s,
            ),
        ] {
            if let Some(value) = value {
                ensure!(
                    (1e-9..1e3).contains(&value),
                    "{name} is a number above 0, not {value}"
                );
                *place = value;
            }
        }
        let accel_unit = self.accel_unit.unwrap_or(1.0);
        ensure!(
            (1e-3..1e3).contains(&accel_unit),
            "accel_unit is how many m/s² a recorded 1 is, not {accel_unit}"
        );
        Ok(Sensors {
            settings,
            imu_topic: self.imu_topic,
            lidar_topic: self.lidar_topic,
            accel_unit,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> anyhow::Result<Sensors> {
        toml::from_str::<File>(text)?.sensors()
    }

    #[test]
    fn mounts_are_in_the_robots_frame_and_the_rest_may_be_left_out() {
        let text = "imu = { xyz = [1.0, 0.0, 0.5] }\n\
                    lidar = { xyz = [1.0, 0.0, 1.5], rpy = [3.14159, 0, 0] }\n\
                    accel_unit = 9.80665";
        let sensors = read(text).unwrap();
        assert!((sensors.settings.lidar.translation.z - 1.0).abs() < 1e-12);
        let up = sensors.settings.lidar.rotation * nalgebra::Vector3::z();
        assert!((up.z + 1.0).abs() < 1e-9, "upside down: {up}");
        assert_eq!(
            sensors.settings.min_range_m,
            sensor_settings(&RobotDescription::sentry()).min_range_m
        );
        assert!(sensors.imu_is_on("/any") && sensors.lidar_is_on("/any"));
        let still = ImuSample {
            stamp: openbench_core::SimTime::ZERO,
            gyro: [0.0; 3],
            accel: [0.0, 0.0, 1.0],
        };
        assert!((sensors.sample(still).accel[2] - 9.80665).abs() < 1e-12);
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        for (text, name) in [
            ("blind = -1.0", "blind"),
            ("range_noise = nan", "range_noise"),
            ("accel_unit = 0.0", "accel_unit"),
            ("imu_limits = [0.0, 1.0]", "imu_limits"),
            ("imu = { xyz = [1e9, 0, 0] }", "xyz"),
            ("wheels = 4", "wheels"),
        ] {
            let error = format!("{:#}", read(text).unwrap_err());
            assert!(error.contains(name), "{text}: {error}");
        }
    }
}
