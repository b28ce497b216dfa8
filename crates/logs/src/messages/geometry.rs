//! `geometry_msgs` and `tf2_msgs`: poses, velocities and transforms.

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use openbench_core::{Pose2, Pose3, Velocity};

use super::{Definition, Header, Message};
use crate::cdr::{CdrError, CdrReader, CdrWriter};

pub(super) const POINT: &Definition = &Definition {
    name: "geometry_msgs/Point",
    fields: "float64 x\nfloat64 y\nfloat64 z\n",
    parts: &[],
};
pub(super) const QUATERNION: &Definition = &Definition {
    name: "geometry_msgs/Quaternion",
    fields: "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
    parts: &[],
};
pub(super) const VECTOR3: &Definition = &Definition {
    name: "geometry_msgs/Vector3",
    fields: "float64 x\nfloat64 y\nfloat64 z\n",
    parts: &[],
};
const TRANSFORM: &Definition = &Definition {
    name: "geometry_msgs/Transform",
    fields: "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
    parts: &[VECTOR3, QUATERNION],
};

/// `geometry_msgs/Pose`; `geometry_msgs/Transform` has the same encoding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Position x, y, z, metres.
    pub position: [f64; 3],
    /// Quaternion x, y, z, w.
    pub orientation: [f64; 4],
}

impl From<Pose3> for Pose {
    fn from(pose: Pose3) -> Self {
        let (t, q) = (pose.translation.vector, pose.rotation);
        Self {
            position: [t.x, t.y, t.z],
            orientation: [q.i, q.j, q.k, q.w],
        }
    }
}

impl From<Pose2> for Pose {
    fn from(pose: Pose2) -> Self {
        pose.to_pose3(0.0).into()
    }
}

impl Pose {
    /// The rigid transform; `None` if a number is NaN or infinite or the quaternion is nearly zero.
    pub fn to_pose3(self) -> Option<Pose3> {
        let [x, y, z, w] = self.orientation;
        let finite = self
            .position
            .iter()
            .chain(&self.orientation)
            .all(|v| v.is_finite());
        let rotation =
            // ROS puts w last, nalgebra first. The quaternion is normalized: other writers may
            // round it.
            UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-6).filter(|_| finite)?;
        Some(Pose3::from_parts(
            Translation3::from(self.position),
            rotation,
        ))
    }
}

impl Message for Pose {
    const DEFINITION: &'static Definition = &Definition {
        name: "geometry_msgs/Pose",
        fields: "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
        parts: &[POINT, QUATERNION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        out.f64_array(&self.position);
        out.f64_array(&self.orientation);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            position: input.f64_array()?,
            orientation: input.f64_array()?,
        })
    }
}

/// `geometry_msgs/PoseStamped`.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseStamped {
    /// Time stamp and frame.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
}

impl Message for PoseStamped {
    const DEFINITION: &'static Definition = &Definition {
        name: "geometry_msgs/PoseStamped",
        fields: "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
        parts: &[Header::DEFINITION, Pose::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        self.pose.encode(out);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            header: Header::decode(input)?,
            pose: Pose::decode(input)?,
        })
    }
}

/// `geometry_msgs/PoseArray`.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseArray {
    /// Time stamp and frame.
    pub header: Header,
    /// The poses.
    pub poses: Vec<Pose>,
}

impl Message for PoseArray {
    const DEFINITION: &'static Definition = &Definition {
        name: "geometry_msgs/PoseArray",
        fields: "std_msgs/Header header\ngeometry_msgs/Pose[] poses\n",
        parts: &[Header::DEFINITION, Pose::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.count(self.poses.len());
        self.poses.iter().for_each(|p| p.encode(out));
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            header: Header::decode(input)?,
            poses: input.sequence(7 * 8, Pose::decode)?,
        })
    }
}

/// `geometry_msgs/Twist`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// Linear velocity x, y, z, m/s.
    pub linear: [f64; 3],
    /// Angular velocity about x, y, z, rad/s.
    pub angular: [f64; 3],
}

impl From<Velocity> for Twist {
    fn from(velocity: Velocity) -> Self {
        Self {
            linear: [velocity.linear, 0.0, 0.0],
            angular: [0.0, 0.0, velocity.angular],
        }
    }
}

impl Message for Twist {
    const DEFINITION: &'static Definition = &Definition {
        name: "geometry_msgs/Twist",
        fields: "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
        parts: &[VECTOR3],
    };

    fn encode(&self, out: &mut CdrWriter) {
        out.f64_array(&self.linear);
        out.f64_array(&self.angular);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            linear: input.f64_array()?,
            angular: input.f64_array()?,
        })
    }
}

/// `geometry_msgs/TwistStamped`.
#[derive(Debug, Clone, PartialEq)]
pub struct TwistStamped {
    /// Time stamp and frame.
    pub header: Header,
    /// The velocity.
    pub twist: Twist,
}

impl Message for TwistStamped {
    const DEFINITION: &'static Definition = &Definition {
        name: "geometry_msgs/TwistStamped",
        fields: "std_msgs/Header header\ngeometry_msgs/Twist twist\n",
        parts: &[Header::DEFINITION, Twist::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        self.twist.encode(out);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            header: Header::decode(input)?,
            twist: Twist::decode(input)?,
        })
    }
}

/// `geometry_msgs/TransformStamped`: pose of the child frame in the frame of the header.
#[derive(Debug, Clone, PartialEq)]
pub struct TransformStamped {
    /// Time stamp and parent frame.
    pub header: Header,
    /// The child frame.
    pub child_frame_id: String,
    /// Pose of the child in the parent.
    pub transform: Pose,
}

impl Message for TransformStamped {
    const DEFINITION: &'static Definition = &Definition {
        name: "geometry_msgs/TransformStamped",
        fields: "std_msgs/Header header\nstring child_frame_id\n\
                 geometry_msgs/Transform transform\n",
        parts: &[Header::DEFINITION, TRANSFORM],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.string(&self.child_frame_id);
        self.transform.encode(out);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        let (header, child_frame_id) = (Header::decode(input)?, input.string()?);
        Ok(Self {
            header,
            child_frame_id,
            transform: Pose::decode(input)?,
        })
    }
}

/// `tf2_msgs/TFMessage`, the type of the topics `/tf` and `/tf_static`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TfMessage(pub Vec<TransformStamped>);

impl Message for TfMessage {
    const DEFINITION: &'static Definition = &Definition {
        name: "tf2_msgs/TFMessage",
        fields: "geometry_msgs/TransformStamped[] transforms\n",
        parts: &[TransformStamped::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        out.count(self.0.len());
        self.0.iter().for_each(|t| t.encode(out));
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        // Time stamp, lengths of two names of frames, and seven numbers of the transform.
        const SMALLEST: usize = 8 + 4 + 4 + 7 * 8;
        Ok(Self(input.sequence(SMALLEST, TransformStamped::decode)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::SimTime;

    #[test]
    fn poses_convert_to_transforms_and_back() {
        let pose = Pose2::new(1.0, -2.0, 0.5);
        let message = PoseStamped {
            header: Header::new(SimTime(7), "map"),
            pose: pose.into(),
        };
        let read = PoseStamped::from_cdr(&message.to_cdr()).unwrap();
        assert_eq!(read, message);
        let back = Pose2::from_pose3(&read.pose.to_pose3().unwrap());
        assert!((back.yaw - 0.5).abs() < 1e-12 && back.x == 1.0);
    }

    #[test]
    fn pose_arrays_round_trip() {
        for count in [0, 1, 3] {
            let poses = (0..count)
                .map(|i| Pose2::new(f64::from(i), 1.0, 0.1).into())
                .collect();
            let message = PoseArray {
                header: Header::new(SimTime(9), "map"),
                poses,
            };
            assert_eq!(PoseArray::from_cdr(&message.to_cdr()).unwrap(), message);
        }
    }

    #[test]
    fn invalid_poses_have_no_transform() {
        let pose = Pose {
            position: [0.0; 3],
            orientation: [0.0; 4],
        };
        assert_eq!(pose.to_pose3(), None);
        let pose = Pose {
            position: [f64::NAN, 0.0, 0.0],
            orientation: [0.0, 0.0, 0.0, 1.0],
        };
        assert_eq!(pose.to_pose3(), None);
    }

    #[test]
    fn transforms_and_twists_round_trip() {
        let transform = |child: &str| TransformStamped {
            header: Header::new(SimTime::from_millis(50), "base_link"),
            child_frame_id: child.into(),
            transform: Pose2::new(0.1, 0.2, 0.3).into(),
        };
        let message = TfMessage(vec![transform("livox_frame"), transform("c")]);
        assert_eq!(TfMessage::from_cdr(&message.to_cdr()).unwrap(), message);
        let twist = TwistStamped {
            header: Header::default(),
            twist: Velocity::new(0.5, -1.0).into(),
        };
        assert_eq!(TwistStamped::from_cdr(&twist.to_cdr()).unwrap(), twist);
    }
}
