//! An observation that owns its data, to be kept or sent to another process.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::agent::Observation;
use crate::sensors::{Camera, GnssFix, Image, ImuSample, LidarScan, WheelSample};
use crate::time::SimTime;

/// A copy of an [`Observation`]'s data.
///
/// ```
/// use openbench_core::{Observation, Sensed, SimTime};
///
/// # struct Blind;
/// # impl openbench_core::Camera for Blind {
/// #     fn image(&self) -> Option<std::sync::Arc<openbench_core::Image>> { None }
/// # }
/// let observation = Observation {
///     time: SimTime::from_millis(50),
///     imu: &[],
///     wheels: &[],
///     scan: None,
///     gnss: None,
///     camera: &Blind,
/// };
/// let sensed = Sensed::of(&observation);
/// assert_eq!(sensed.observation().time, observation.time);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sensed {
    /// Simulated time of the observation.
    pub time: SimTime,
    /// IMU samples since the last observation, oldest first.
    pub imu: Vec<ImuSample>,
    /// Wheel samples since the last observation, oldest first.
    pub wheels: Vec<WheelSample>,
    /// The LiDAR scan, if one was completed since the last observation.
    pub scan: Option<LidarScan>,
    /// The satellite fix, if the robot got one since the last observation.
    pub gnss: Option<GnssFix>,
    /// The image of this instant, if one was requested and the camera had one.
    pub image: Option<Arc<Image>>,
}

impl Sensed {
    /// Copies an observation without an image; none is rendered for it.
    pub fn of(observation: &Observation<'_>) -> Self {
        Self {
            time: observation.time,
            imu: observation.imu.to_vec(),
            wheels: observation.wheels.to_vec(),
            scan: observation.scan.cloned(),
            gnss: observation.gnss.copied(),
            image: None,
        }
    }

    /// The same with an image, if the camera has one now. Rendering it costs as much as when an
    /// agent requests it.
    pub fn with_image(observation: &Observation<'_>) -> Self {
        Self {
            image: observation.camera.image(),
            ..Self::of(observation)
        }
    }

    /// The observation as an agent sees it. Its camera has the kept image, or none.
    pub fn observation(&self) -> Observation<'_> {
        Observation {
            time: self.time,
            imu: &self.imu,
            wheels: &self.wheels,
            scan: self.scan.as_ref(),
            gnss: self.gnss.as_ref(),
            camera: self,
        }
    }
}

impl Camera for Sensed {
    fn image(&self) -> Option<Arc<Image>> {
        self.image.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::LidarPoint;

    /// A camera that counts the requests for images.
    #[derive(Default)]
    struct Counting(std::cell::Cell<u32>);

    impl Camera for Counting {
        fn image(&self) -> Option<Arc<Image>> {
            self.0.set(self.0.get() + 1);
            let stamp = SimTime::from_millis(100);
            Some(Arc::new(Image {
                stamp,
                width: 1,
                height: 2,
                rgb: vec![1, 2, 3, 4, 5, 6],
            }))
        }
    }

    fn scan() -> LidarScan {
        let point = LidarPoint {
            xyz: [1.0, -0.1, 0.25],
            offset_ns: 7,
            reflectivity: 40,
            line: 3,
        };
        LidarScan {
            stamp: SimTime::ZERO,
            points: vec![point],
        }
    }

    #[test]
    fn an_image_is_rendered_only_on_request() {
        let (camera, scan) = (Counting::default(), scan());
        let time = SimTime::from_millis(100);
        let seen = Observation {
            time,
            imu: &[],
            wheels: &[],
            scan: Some(&scan),
            gnss: None,
            camera: &camera,
        };
        assert!(Sensed::of(&seen).observation().camera.image().is_none());
        assert_eq!(camera.0.get(), 0);
        let sensed = Sensed::with_image(&seen);
        assert_eq!(camera.0.get(), 1);
        assert_eq!(sensed.observation().scan, Some(&scan));
        assert_eq!(
            sensed
                .observation()
                .camera
                .image()
                .map(|image| image.rgb.len()),
            Some(6)
        );
    }

    #[test]
    fn sensor_data_survive_serialization() {
        let camera = Counting::default();
        let (scan, time) = (scan(), SimTime::from_millis(100));
        let imu = [ImuSample {
            stamp: time,
            gyro: [0.1 + 0.2, 0.0, 1e-9],
            accel: [0.0, 0.0, 9.81],
        }];
        let wheels = [WheelSample {
            stamp: time,
            left: 1.0,
            right: 2.0,
        }];
        let seen = Observation {
            time,
            imu: &imu,
            wheels: &wheels,
            scan: Some(&scan),
            gnss: None,
            camera: &camera,
        };
        let sensed = Sensed::with_image(&seen);
        let text = serde_json::to_string(&sensed).unwrap();
        assert_eq!(serde_json::from_str::<Sensed>(&text).unwrap(), sensed);
    }
}
