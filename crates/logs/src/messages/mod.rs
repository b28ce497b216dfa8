//! The messages that are written and read.
//!
//! Each follows the ROS 2 interface definition of its name (REP 103 units and axes: metres, radians, x forward) and
//! carries that definition, so that a log explains itself. Definitions are the fields of the standard messages alone,
//! without their comments.

mod cloud_scan;
mod definition;
mod geometry;
mod livox;
mod nav;
mod nav_sat;
mod point_cloud;
mod sensors;
mod standard;

use crate::cdr::{CdrError, CdrReader, CdrWriter};

pub use cloud_scan::CloudError;
pub use definition::Definition;
pub use geometry::{Pose, PoseArray, PoseStamped, TfMessage, TransformStamped, Twist, TwistStamped};
pub use livox::{CustomMsg, CustomPoint};
pub use nav::{Odometry, Path};
pub use nav_sat::NavSatFix;
pub use point_cloud::{PointCloud2, PointField};
pub use sensors::{CompressedImage, Imu, JointState};
pub use standard::{Header, StringMessage, Time};

/// A ROS 2 message.
pub trait Message: Sized {
    /// Name and fields of the type.
    const DEFINITION: &'static Definition;

    /// Writes the fields in order.
    fn encode(&self, out: &mut CdrWriter);

    /// Reads the fields in order.
    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError>;

    /// The whole message as CDR, its encapsulation header included.
    fn to_cdr(&self) -> Vec<u8> {
        let mut out = CdrWriter::new();
        self.encode(&mut out);
        out.as_bytes().to_vec()
    }

    /// The message that `bytes` hold. Bytes after the last field are padding and are not looked at.
    fn from_cdr(bytes: &[u8]) -> Result<Self, CdrError> {
        Self::decode(&mut CdrReader::new(bytes)?)
    }
}
