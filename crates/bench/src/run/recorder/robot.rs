//! The robot as viewers need it: its frames, and its form as URDF.

use std::f64::consts::FRAC_PI_2;

use nalgebra::UnitQuaternion;
use openbench_core::{Pose3, RobotDescription, SimTime};
use openbench_logs::messages::{CAMERA_OPTICAL, Header, TfMessage, TransformStamped};

/// A frame that is fixed to another one.
struct Link {
    parent: &'static str,
    name: &'static str,
    pose: Pose3,
}

/// The frames on the robot.
fn links(robot: &RobotDescription) -> Vec<Link> {
    let on_base = |name, pose| Link {
        parent: "base_link",
        name,
        pose,
    };
    let mut links = vec![
        on_base("imu_link", robot.imu),
        on_base("livox_frame", robot.lidar),
        on_base("camera_link", robot.camera),
        Link {
            parent: "camera_link",
            name: CAMERA_OPTICAL,
            pose: optical(),
        },
    ];
    links.extend(robot.gnss.map(|pose| on_base("gnss_link", pose)));
    links
}

/// The axes of an image in those of its camera: z forward, x to the right (REP 103).
fn optical() -> Pose3 {
    let turn = UnitQuaternion::from_euler_angles(-FRAC_PI_2, 0.0, -FRAC_PI_2);
    Pose3::from_parts(nalgebra::Translation3::identity(), turn)
}

/// The transforms that never change: those of the frames on the robot.
pub(super) fn fixed_transforms(robot: &RobotDescription) -> TfMessage {
    let links = links(robot).into_iter();
    TfMessage(
        links
            .map(|link| transform(SimTime::ZERO, link.parent, link.name, link.pose))
            .collect(),
    )
}

/// The pose of a frame in another one.
pub(super) fn transform(time: SimTime, parent: &str, name: &str, pose: Pose3) -> TransformStamped {
    TransformStamped {
        header: Header::new(time, parent),
        child_frame_id: name.to_owned(),
        transform: pose.into(),
    }
}

/// The robot's body, wheels and sensors in the Unified Robot Description Format. All joints are
/// fixed, since wheels that turn show nothing.
pub(super) fn urdf(robot: &RobotDescription) -> String {
    let (length, width, radius) = (robot.length, robot.width, robot.wheel_radius);
    let (height, middle) = (
        robot.height - radius,
        radius + (robot.height - radius) / 2.0,
    );
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<robot name=\"openbench\">\n  <link name=\"base_link\">\n    \
         <visual>\n      <origin xyz=\"0 0 {middle}\"/>\n      \
         <geometry><box size=\"{length} {inner} {height}\"/></geometry>\n      \
         <material name=\"body\"><color rgba=\"0.2 0.45 0.8 1\"/></material>\n    </visual>\n",
        inner = 2.0 * robot.wheel_separation - width,
    );
    let (x, y) = (length / 2.0 - radius, robot.wheel_separation / 2.0);
    for (x, y) in [(x, y), (x, -y), (-x, y), (-x, -y)] {
        text += &format!(
            "    <visual>\n      <origin xyz=\"{x} {y} {radius}\" rpy=\"{FRAC_PI_2} 0 0\"/>\n      \
             <geometry><cylinder radius=\"{radius}\" length=\"{}\"/></geometry>\n      \
             <material name=\"tyre\"><color rgba=\"0.1 0.1 0.1 1\"/></material>\n    </visual>\n",
            width - robot.wheel_separation,
        );
    }
    text += "  </link>\n";
    for link in links(robot) {
        let at = link.pose.translation.vector;
        let (roll, pitch, yaw) = link.pose.rotation.euler_angles();
        text += &format!(
            "  <link name=\"{name}\"/>\n  <joint name=\"{name}_joint\" type=\"fixed\">\n    \
             <parent link=\"{parent}\"/>\n    <child link=\"{name}\"/>\n    \
             <origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/>\n  </joint>\n",
            at.x,
            at.y,
            at.z,
            name = link.name,
            parent = link.parent,
        );
    }
    text + "</robot>\n"
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn the_optical_axis_points_forward_and_down_is_down() {
        let optical = optical();
        assert!((optical * Vector3::z() - Vector3::x()).norm() < 1e-12);
        assert!((optical * Vector3::y() + Vector3::z()).norm() < 1e-12);
    }

    #[test]
    fn every_frame_has_a_link_and_a_transform() {
        let robot = RobotDescription::sentry().with_gnss();
        let (urdf, transforms) = (urdf(&robot), fixed_transforms(&robot));
        let names: Vec<&str> = transforms
            .0
            .iter()
            .map(|t| t.child_frame_id.as_str())
            .collect();
        assert_eq!(
            names,
            [
                "imu_link",
                "livox_frame",
                "camera_link",
                "camera_optical",
                "gnss_link"
            ]
        );
        for name in names {
            assert!(
                urdf.contains(&format!("<child link=\"{name}\"/>")),
                "{urdf}"
            );
        }
    }
}
