//! `sensor_msgs`: inertial measurements, wheel angles and compressed images.

use openbench_core::{ImuSample, SimTime, WheelSample};

use super::geometry::{QUATERNION, VECTOR3};
use super::{Definition, Header, Message};
use crate::cdr::{CdrError, CdrReader, CdrWriter};

/// `sensor_msgs/Imu`.
///
/// A covariance that begins with -1 means that the quantity is not measured. A covariance of zeros
/// is unknown.
#[derive(Debug, Clone, PartialEq)]
pub struct Imu {
    /// Time stamp and frame of the sensor.
    pub header: Header,
    /// Orientation, quaternion x, y, z, w.
    pub orientation: [f64; 4],
    /// Covariance of the orientation, row by row.
    pub orientation_covariance: [f64; 9],
    /// Angular velocity about x, y, z, rad/s.
    pub angular_velocity: [f64; 3],
    /// Covariance of the angular velocity, row by row.
    pub angular_velocity_covariance: [f64; 9],
    /// Specific force along x, y, z, m/s².
    pub linear_acceleration: [f64; 3],
    /// Covariance of the acceleration, row by row.
    pub linear_acceleration_covariance: [f64; 9],
}

impl From<ImuSample> for Imu {
    fn from(sample: ImuSample) -> Self {
        let mut orientation_covariance = [0.0; 9];
        // The sensor measures no orientation.
        orientation_covariance[0] = -1.0;
        Self {
            header: Header::new(sample.stamp, "imu_link"),
            orientation: [0.0, 0.0, 0.0, 1.0],
            orientation_covariance,
            angular_velocity: sample.gyro,
            angular_velocity_covariance: [0.0; 9],
            linear_acceleration: sample.accel,
            linear_acceleration_covariance: [0.0; 9],
        }
    }
}

impl From<&Imu> for ImuSample {
    fn from(message: &Imu) -> Self {
        Self {
            stamp: message.header.stamp,
            gyro: message.angular_velocity,
            accel: message.linear_acceleration,
        }
    }
}

impl Message for Imu {
    const DEFINITION: &'static Definition = &Definition {
        name: "sensor_msgs/Imu",
        fields: "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n\
                 float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n\
                 float64[9] angular_velocity_covariance\n\
                 geometry_msgs/Vector3 linear_acceleration\n\
                 float64[9] linear_acceleration_covariance\n",
        parts: &[Header::DEFINITION, QUATERNION, VECTOR3],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.f64_array(&self.orientation);
        out.f64_array(&self.orientation_covariance);
        out.f64_array(&self.angular_velocity);
        out.f64_array(&self.angular_velocity_covariance);
        out.f64_array(&self.linear_acceleration);
        out.f64_array(&self.linear_acceleration_covariance);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            header: Header::decode(input)?,
            orientation: input.f64_array()?,
            orientation_covariance: input.f64_array()?,
            angular_velocity: input.f64_array()?,
            angular_velocity_covariance: input.f64_array()?,
            linear_acceleration: input.f64_array()?,
            linear_acceleration_covariance: input.f64_array()?,
        })
    }
}

const LEFT_WHEELS: &str = "left_wheels";
const RIGHT_WHEELS: &str = "right_wheels";

/// `sensor_msgs/JointState`: angles of the wheels. Each array has one number for each joint or
/// none.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointState {
    /// Time stamp and frame.
    pub header: Header,
    /// Names of the joints.
    pub name: Vec<String>,
    /// Angles, rad.
    pub position: Vec<f64>,
    /// Angular velocities, rad/s.
    pub velocity: Vec<f64>,
    /// Torques, Nm.
    pub effort: Vec<f64>,
}

impl From<WheelSample> for JointState {
    fn from(sample: WheelSample) -> Self {
        Self {
            header: Header::new(sample.stamp, "base_link"),
            name: vec![LEFT_WHEELS.to_owned(), RIGHT_WHEELS.to_owned()],
            position: vec![sample.left, sample.right],
            ..Self::default()
        }
    }
}

impl JointState {
    /// The angles of the wheels, if the message contains both sides.
    pub fn wheels(&self) -> Option<WheelSample> {
        let left = self.angle(LEFT_WHEELS)?;
        let right = self.angle(RIGHT_WHEELS)?;
        Some(WheelSample {
            stamp: self.header.stamp,
            left,
            right,
        })
    }

    fn angle(&self, joint: &str) -> Option<f64> {
        let index = self.name.iter().position(|name| name == joint)?;
        self.position.get(index).copied()
    }
}

impl Message for JointState {
    const DEFINITION: &'static Definition = &Definition {
        name: "sensor_msgs/JointState",
        fields: "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n\
                 float64[] effort\n",
        parts: &[Header::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.count(self.name.len());
        self.name.iter().for_each(|n| out.string(n));
        out.f64_sequence(&self.position);
        out.f64_sequence(&self.velocity);
        out.f64_sequence(&self.effort);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            header: Header::decode(input)?,
            // An empty string takes at least its length.
            name: input.sequence(4, CdrReader::string)?,
            position: input.sequence(8, CdrReader::f64)?,
            velocity: input.sequence(8, CdrReader::f64)?,
            effort: input.sequence(8, CdrReader::f64)?,
        })
    }
}

/// The frame of the camera's images: z forward, x to the right (REP 103).
pub const CAMERA_OPTICAL: &str = "camera_optical";

/// `sensor_msgs/CompressedImage`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CompressedImage {
    /// Time stamp and frame of the camera.
    pub header: Header,
    /// Format of the file: `jpeg` or `png`.
    pub format: String,
    /// The bytes of the image file.
    pub data: Vec<u8>,
}

impl CompressedImage {
    /// A JPEG file of the robot's camera.
    pub fn jpeg(stamp: SimTime, data: Vec<u8>) -> Self {
        Self {
            header: Header::new(stamp, CAMERA_OPTICAL),
            format: "jpeg".to_owned(),
            data,
        }
    }
}

impl Message for CompressedImage {
    const DEFINITION: &'static Definition = &Definition {
        name: "sensor_msgs/CompressedImage",
        fields: "std_msgs/Header header\nstring format\nuint8[] data\n",
        parts: &[Header::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.string(&self.format);
        out.octets(&self.data);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        let (header, format) = (Header::decode(input)?, input.string()?);
        Ok(Self {
            header,
            format,
            data: input.octets()?.to_vec(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn imu_samples_round_trip() {
        let sample = ImuSample {
            stamp: SimTime(10),
            gyro: [0.1, 0.2, 0.3],
            accel: [0.0, -0.1, 9.8],
        };
        let read = Imu::from_cdr(&Imu::from(sample).to_cdr()).unwrap();
        assert_eq!(read.orientation_covariance[0], -1.0);
        assert_eq!(ImuSample::from(&read), sample);
    }

    #[test]
    fn wheel_samples_round_trip() {
        let sample = WheelSample {
            stamp: SimTime(20),
            left: 1.5,
            right: -2.5,
        };
        let mut read = JointState::from_cdr(&JointState::from(sample).to_cdr()).unwrap();
        assert_eq!(read.wheels(), Some(sample));
        read.position.pop();
        assert_eq!(read.wheels(), None);
    }

    #[test]
    fn images_round_trip() {
        let image = CompressedImage::jpeg(SimTime(5), vec![0xff, 0xd8, 1]);
        assert_eq!(CompressedImage::from_cdr(&image.to_cdr()).unwrap(), image);
    }
}
