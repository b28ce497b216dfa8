//! The ROS 2 messages that are written and read.
//!
//! Each type follows the ROS 2 interface definition of its name, with units and axes of REP 103:
//! metres, radians, x forward. A log contains these definitions, so that other tools can decode it.
//! Definitions contain the fields of the standard messages without their comments.

mod camera;
mod cloud_scan;
mod definition;
mod geometry;
mod grid;
mod livox;
mod marker;
mod nav;
mod nav_sat;
mod point_cloud;
mod sensors;
mod standard;

use crate::cdr::{CdrError, CdrReader, CdrWriter};

pub use camera::CameraInfo;
pub use cloud_scan::CloudError;
pub use definition::Definition;
pub use geometry::{
    Pose, PoseArray, PoseStamped, TfMessage, TransformStamped, Twist, TwistStamped,
};
pub use grid::OccupancyGrid;
pub use livox::{CustomMsg, CustomPoint};
pub use marker::{Marker, MarkerArray, Shape};
pub use nav::{Odometry, Path};
pub use nav_sat::NavSatFix;
pub use point_cloud::{PointCloud2, PointField};
pub use sensors::{CAMERA_OPTICAL, CompressedImage, Imu, JointState};
pub use standard::{Clock, Header, StringMessage, Time};

/// A ROS 2 message.
///
/// A type of another crate can be logged if it implements this trait:
///
/// ```
/// use openbench_logs::messages::{Definition, Message};
/// use openbench_logs::cdr::{CdrError, CdrReader, CdrWriter};
///
/// /// `std_msgs/Float64`.
/// #[derive(Debug, PartialEq)]
/// struct Float64(f64);
///
/// impl Message for Float64 {
///     const DEFINITION: &'static Definition =
///         &Definition { name: "std_msgs/Float64", fields: "float64 data\n", parts: &[] };
///
///     fn encode(&self, out: &mut CdrWriter) {
///         out.f64(self.0);
///     }
///
///     fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
///         Ok(Self(input.f64()?))
///     }
/// }
///
/// // The encapsulation header and 8 bytes.
/// let bytes = Float64(0.5).to_cdr();
/// assert_eq!(bytes.len(), 12);
/// assert_eq!(Float64::from_cdr(&bytes)?, Float64(0.5));
/// # Ok::<(), CdrError>(())
/// ```
pub trait Message: Sized {
    /// Name and fields of the type, as ROS 2 defines them.
    const DEFINITION: &'static Definition;

    /// Writes the fields in order.
    fn encode(&self, out: &mut CdrWriter);

    /// Reads the fields in order.
    ///
    /// # Errors
    /// [`CdrError`] if the bytes do not match the fields.
    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError>;

    /// The message as CDR, including its encapsulation header.
    fn to_cdr(&self) -> Vec<u8> {
        let mut out = CdrWriter::new();
        self.encode(&mut out);
        out.as_bytes().to_vec()
    }

    /// Decodes a message. Bytes after the last field are padding and are ignored.
    ///
    /// # Errors
    /// As [`Message::decode`].
    fn from_cdr(bytes: &[u8]) -> Result<Self, CdrError> {
        // Not an error: ROS 2 middleware may pad a message to a multiple of four bytes.
        Self::decode(&mut CdrReader::new(bytes)?)
    }
}
