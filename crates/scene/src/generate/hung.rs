//! Plates and signs that hang on walls, poles and cars.

use nalgebra::{Point3, Vector3};
use openbench_core::Pose2;

use crate::material::MaterialId;
use crate::plates::Extent;
use crate::scene::{Layer, SceneBuilder};

/// A drawn plate with its materials.
#[derive(Debug, Clone, Copy)]
pub(super) struct HungFace {
    pub material: MaterialId,
    pub edge: MaterialId,
    pub size: Extent,
    /// Size of its text, and of the capitals.
    pub text: Extent,
    /// Middle of the text above the middle of the plate, metres.
    pub text_above_m: f64,
    pub has_holes: bool,
    pub thickness_m: f64,
}

impl HungFace {
    /// Hangs it in the frame of a pose that faces out of a wall: its back has its middle at `back`
    /// (forward, left, up), and it is turned counter-clockwise by `tilt` radians.
    pub fn hang(&self, scene: &mut SceneBuilder, wall: Pose2, back: Point3<f64>, tilt: f64) {
        let point = |forward: f64, left: f64, up: f64| {
            let at = wall.transform(forward, left);
            Point3::new(at.x, at.y, up)
        };
        let origin = point(0.0, 0.0, 0.0);
        let out = point(1.0, 0.0, 0.0) - origin;
        // A reader has the wall's left on the right.
        let across = point(0.0, 1.0, 0.0) - origin;
        let (sin, cos) = libm::sincos(tilt);
        let right = (across * cos + Vector3::z() * sin) * self.size.width_m;
        let up = (Vector3::z() * cos - across * sin) * self.size.height_m;
        let deep = out * self.thickness_m;
        let back = point(back.x, back.y, back.z) - (right + up) / 2.0;
        let front = back + deep;
        scene.rectangle(Layer::Visible, self.material, front, right, up, [1.0; 2]);
        // Figures have no board.
        if self.has_holes {
            return;
        }
        let sides = [
            (front + right, -deep, up),
            (back, deep, up),
            (front + up, right, -deep),
            (back, right, deep),
        ];
        for (corner, u, v) in sides {
            scene.rectangle(Layer::Visible, self.edge, corner, u, v, [1.0; 2]);
        }
    }
}
