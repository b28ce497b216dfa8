//! Named frames of a model or world, and poses relative to them (SDF 1.7, "pose frame semantics").
//!
//! Left out: frames inside nested models (`a::b`), unless the file lists them flat as saved worlds
//! do.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{Translation3, UnitQuaternion};
use openbench_core::Pose3;
use roxmltree::Node;

use super::error::ImportError;
use super::warnings::Warnings;
use super::xml::{child, children, malformed, numbers};

/// Frames that are given in each other, one after the other, at most: a longer chain is a circle.
const MAX_CHAIN: usize = 64;

/// A pose in a frame.
#[derive(Debug)]
pub(crate) struct RelativePose {
    pub(crate) pose: Pose3,
    /// Name of the frame; `None` is the enclosing model or world.
    frame: Option<String>,
}

/// The frames directly in one `<model>` or `<world>`.
#[derive(Debug, Default)]
pub(crate) struct Frames(BTreeMap<String, RelativePose>);

impl Frames {
    /// Collects the frames of `scope`: links, frames and models in it.
    pub(crate) fn read(path: &Path, scope: Node) -> Result<Self, ImportError> {
        let mut frames = BTreeMap::new();
        for tag in ["link", "model", "frame"] {
            for node in children(scope, tag) {
                let Some(name) = node.attribute("name") else {
                    continue;
                };
                let RelativePose { pose, frame } = pose_of(path, node)?;
                // Without `relative_to`, a pose is given in the frame to which its own is attached.
                let frame = frame.or_else(|| node.attribute("attached_to").map(str::to_owned));
                frames.insert(name.to_owned(), RelativePose { pose, frame });
            }
        }
        Ok(Self(frames))
    }

    /// The pose of `node` in the frame of the scope; `None` if it is given in no named frame.
    pub(crate) fn explicit(
        &self,
        path: &Path,
        node: Node,
        warnings: &mut Warnings,
    ) -> Result<Option<Pose3>, ImportError> {
        let RelativePose { pose, frame } = pose_of(path, node)?;
        match frame {
            None => Ok(None),
            Some(frame) => Ok(Some(self.origin(path, node, &frame, warnings)? * pose)),
        }
    }

    /// The pose of the frame called `name`.
    fn origin(
        &self,
        path: &Path,
        node: Node,
        name: &str,
        warnings: &mut Warnings,
    ) -> Result<Pose3, ImportError> {
        let mut pose = Pose3::identity();
        let mut next = Some(name);
        for _ in 0..MAX_CHAIN {
            // These are names of the scope's own frame.
            let Some(name) = next.filter(|n| !matches!(*n, "" | "__model__" | "world")) else {
                return Ok(pose);
            };
            let Some(own) = self.0.get(name) else {
                warnings.add(format!(
                    "frame `{name}` is not in its model; the model's own frame is used"
                ));
                return Ok(pose);
            };
            // From the inside out, until the frame of the scope itself is reached.
            pose = own.pose * pose;
            next = own.frame.as_deref();
        }
        Err(malformed(
            path,
            node,
            format!("frame `{name}` is defined by itself"),
        ))
    }
}

/// The `<pose>` of `node`. Without `<pose>` it is the identity.
pub(crate) fn pose_of(path: &Path, node: Node) -> Result<RelativePose, ImportError> {
    let Some(pose) = child(node, "pose") else {
        return Ok(RelativePose {
            pose: Pose3::identity(),
            frame: None,
        });
    };
    let frame = pose
        .attribute("relative_to")
        // The name of the attribute before SDF 1.7.
        .or_else(|| pose.attribute("frame"));
    Ok(RelativePose {
        pose: parse_pose(path, pose)?,
        frame: frame.filter(|f| !f.is_empty()).map(str::to_owned),
    })
}

/// `x y z roll pitch yaw`: metres and radians, or degrees if the element has `degrees`.
pub(crate) fn parse_pose(path: &Path, node: Node) -> Result<Pose3, ImportError> {
    if node.text().is_none_or(|t| t.trim().is_empty()) {
        return Ok(Pose3::identity());
    }
    let [x, y, z, roll, pitch, yaw] = numbers::<6>(path, node)?;
    let degrees = matches!(node.attribute("degrees"), Some("true" | "1"));
    let unit = if degrees {
        std::f64::consts::PI / 180.0
    } else {
        1.0
    };
    // About fixed axes, first x, then y, then z: nalgebra's convention is that of SDF.
    let rotation = UnitQuaternion::from_euler_angles(roll * unit, pitch * unit, yaw * unit);
    Ok(Pose3::from_parts(Translation3::new(x, y, z), rotation))
}

#[cfg(test)]
mod tests {
    use super::super::xml::parse;
    use super::*;
    use nalgebra::Point3;

    fn explicit(text: &str) -> Result<Option<Pose3>, ImportError> {
        let path = Path::new("f");
        let doc = parse(path, text).unwrap();
        let frames = Frames::read(path, doc.root_element())?;
        let node = child(doc.root_element(), "visual").unwrap();
        frames.explicit(path, node, &mut Warnings::default())
    }

    #[test]
    fn frames_chain_through_relative_to_and_attached_to() {
        let pose = explicit(
            "<model><link name='a'><pose>1 0 0 0 0 1.5707963267948966</pose></link>\
             <frame name='b' attached_to='a'><pose>2 0 0 0 0 0</pose></frame>\
             <visual><pose relative_to='b'>0 1 0 0 0 0</pose></visual></model>",
        );
        let at = pose.unwrap().unwrap() * Point3::origin();
        assert!((at - Point3::new(0.0, 2.0, 0.0)).norm() < 1e-12, "{at}");
    }

    #[test]
    fn a_circle_of_frames_is_an_error() {
        let error = explicit(
            "<model><frame name='a'><pose relative_to='b'>0 0 0 0 0 0</pose></frame>\
             <frame name='b'><pose relative_to='a'>0 0 0 0 0 0</pose></frame>\
             <visual><pose relative_to='b'>0 1 0 0 0 0</pose></visual></model>",
        );
        assert!(error.unwrap_err().to_string().contains("defined by itself"));
    }

    #[test]
    fn angles_turn_about_fixed_axes_roll_first() {
        let doc = parse(Path::new("f"), "<pose degrees='true'>0 0 0 90 0 90</pose>").unwrap();
        let pose = parse_pose(Path::new("f"), doc.root_element()).unwrap();
        let turned = pose * Point3::new(0.0, 1.0, 0.0);
        assert!(
            (turned - Point3::new(0.0, 0.0, 1.0)).norm() < 1e-12,
            "{turned}"
        );
    }
}
