//! `nav_msgs`: odometry and paths.

use openbench_core::{MapPoint, Pose2};

use super::{Definition, Header, Message, Pose, PoseStamped, Twist};
use crate::cdr::{CdrError, CdrReader, CdrWriter};

const POSE_WITH_COVARIANCE: &Definition = &Definition {
    name: "geometry_msgs/PoseWithCovariance",
    fields: "geometry_msgs/Pose pose\nfloat64[36] covariance\n",
    parts: &[Pose::DEFINITION],
};
const TWIST_WITH_COVARIANCE: &Definition = &Definition {
    name: "geometry_msgs/TwistWithCovariance",
    fields: "geometry_msgs/Twist twist\nfloat64[36] covariance\n",
    parts: &[Twist::DEFINITION],
};

/// `nav_msgs/Odometry`.
///
/// Covariances are 6×6, row by row, over x, y, z and the rotations about them. Zeros mean unknown.
#[derive(Debug, Clone, PartialEq)]
pub struct Odometry {
    /// Time stamp and frame of the pose.
    pub header: Header,
    /// The frame whose pose this is, in which the twist is expressed.
    pub child_frame_id: String,
    /// Pose of the child frame.
    pub pose: Pose,
    /// Covariance of the pose.
    pub pose_covariance: [f64; 36],
    /// Velocity of the child frame.
    pub twist: Twist,
    /// Covariance of the twist.
    pub twist_covariance: [f64; 36],
}

impl Odometry {
    /// Pose and velocity of the frame `child`, with unknown covariances.
    pub fn new(header: Header, child: impl Into<String>, pose: Pose, twist: Twist) -> Self {
        let (pose_covariance, twist_covariance) = ([0.0; 36], [0.0; 36]);
        Self {
            header,
            child_frame_id: child.into(),
            pose,
            pose_covariance,
            twist,
            twist_covariance,
        }
    }
}

impl Message for Odometry {
    const DEFINITION: &'static Definition = &Definition {
        name: "nav_msgs/Odometry",
        fields: "std_msgs/Header header\nstring child_frame_id\n\
                 geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n",
        parts: &[
            Header::DEFINITION,
            POSE_WITH_COVARIANCE,
            TWIST_WITH_COVARIANCE,
        ],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.string(&self.child_frame_id);
        self.pose.encode(out);
        out.f64_array(&self.pose_covariance);
        self.twist.encode(out);
        out.f64_array(&self.twist_covariance);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            header: Header::decode(input)?,
            child_frame_id: input.string()?,
            pose: Pose::decode(input)?,
            pose_covariance: input.f64_array()?,
            twist: Twist::decode(input)?,
            twist_covariance: input.f64_array()?,
        })
    }
}

/// `nav_msgs/Path`.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Time stamp and frame.
    pub header: Header,
    /// The poses in driving order.
    pub poses: Vec<PoseStamped>,
}

impl Path {
    /// A path through points on the ground. Each pose faces the next point; the last one has the
    /// heading of the one before it.
    pub fn over(header: Header, points: &[MapPoint]) -> Self {
        let legs = points.windows(2).map(|leg| leg[0].bearing_to(leg[1]));
        let last = points
            .len()
            // A single point has no direction, and gets a heading of zero.
            .checked_sub(2)
            .map_or(0.0, |i| points[i].bearing_to(points[i + 1]));
        let poses = points
            .iter()
            .zip(legs.chain([last]))
            .map(|(point, yaw)| PoseStamped {
                header: header.clone(),
                pose: Pose2::new(point.x, point.y, yaw).into(),
            });
        Self {
            poses: poses.collect(),
            header,
        }
    }

    /// The points of the path on the ground.
    pub fn points(&self) -> Vec<MapPoint> {
        self.poses
            .iter()
            .map(|p| MapPoint::new(p.pose.position[0], p.pose.position[1]))
            .collect()
    }
}

impl Message for Path {
    const DEFINITION: &'static Definition = &Definition {
        name: "nav_msgs/Path",
        fields: "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n",
        parts: &[Header::DEFINITION, PoseStamped::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.count(self.poses.len());
        self.poses.iter().for_each(|p| p.encode(out));
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        // Time stamp, the length of the frame's name, and seven numbers of the pose.
        const SMALLEST: usize = 8 + 4 + 7 * 8;
        Ok(Self {
            header: Header::decode(input)?,
            poses: input.sequence(SMALLEST, PoseStamped::decode)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::SimTime;

    #[test]
    fn odometry_round_trips() {
        let header = Header::new(SimTime(123_456_789), "odom");
        let mut message = Odometry::new(
            header,
            "base_link",
            Pose2::new(1.0, 2.0, 3.0).into(),
            Twist::default(),
        );
        message.twist_covariance[35] = 0.25;
        assert_eq!(Odometry::from_cdr(&message.to_cdr()).unwrap(), message);
    }

    #[test]
    fn poses_of_a_path_face_the_next_point() {
        let points = [
            MapPoint::new(0.0, 0.0),
            MapPoint::new(0.0, 2.0),
            MapPoint::new(-1.0, 2.0),
        ];
        let path = Path::over(Header::new(SimTime::ZERO, "map"), &points);
        let yaw = |i: usize| Pose2::from_pose3(&path.poses[i].pose.to_pose3().unwrap()).yaw;
        assert!((yaw(0) - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((yaw(1).abs() - std::f64::consts::PI).abs() < 1e-12 && yaw(1) == yaw(2));
        let read = Path::from_cdr(&path.to_cdr()).unwrap();
        assert_eq!(read.points(), points);
        assert!(Path::over(Header::default(), &[]).poses.is_empty());
        assert_eq!(
            Path::over(Header::default(), &points[..1]).points(),
            &points[..1]
        );
    }
}
