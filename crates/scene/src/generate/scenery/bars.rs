//! Bars in any direction, and wheels of bars.

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3};
use openbench_core::Pose2;

use crate::generate::shapes::{Surface, facet};
use crate::scene::{Layer, SceneBuilder};

/// Bars of a wheel's tyre.
const WHEEL_BARS: usize = 10;

/// A point in the frame of a pose: forward, left, up, metres.
pub(super) fn placed(pose: Pose2, [forward, left, up]: [f64; 3]) -> Point3<f64> {
    let p = pose.transform(forward, left);
    Point3::new(p.x, p.y, up)
}

/// A visible bar with a square cross section between two points, open at its ends.
pub(super) fn bar(
    scene: &mut SceneBuilder,
    surface: Surface,
    from: Point3<f64>,
    to: Point3<f64>,
    thickness: f64,
) {
    let Some(along) = (to - from).try_normalize(1e-9) else {
        return;
    };
    // Any direction that is not along the bar.
    let other = if along.z.abs() < 0.9 {
        Vector3::z()
    } else {
        Vector3::x()
    };
    let side = along.cross(&other).normalize() * (thickness / 2.0);
    let up = side.cross(&along).normalize() * (thickness / 2.0);
    let ring = [side + up, up - side, -side - up, side - up];
    for i in 0..4 {
        let (a, b) = (ring[i], ring[(i + 1) % 4]);
        facet(
            scene,
            Layer::Visible,
            surface,
            &[from + b, from + a, to + a, to + b],
        );
    }
}

/// A wheel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wheel {
    /// Its middle: forward, left, up, metres.
    pub middle: [f64; 3],
    /// Metres.
    pub radius: f64,
}

/// A wheel that stands along a pose.
pub(super) fn wheel(scene: &mut SceneBuilder, surface: Surface, pose: Pose2, wheel: Wheel) {
    let [forward, left, up] = wheel.middle;
    let rim = |i: usize| {
        let (sin, cos) = libm::sincos(TAU * i as f64 / WHEEL_BARS as f64);
        placed(
            pose,
            [forward + wheel.radius * cos, left, up + wheel.radius * sin],
        )
    };
    for i in 0..WHEEL_BARS {
        bar(scene, surface, rim(i), rim(i + 1), 0.04);
    }
    // Two spokes that cross are enough to see where the hub is.
    for i in [0, WHEEL_BARS / 4] {
        bar(scene, surface, rim(i), rim(i + WHEEL_BARS / 2), 0.012);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Material, SemanticClass};

    #[test]
    fn a_bar_has_four_faces_and_none_without_length() {
        let mut scene = SceneBuilder::new();
        let material = scene.material(Material::plain(SemanticClass::Furniture, [0.5; 3]));
        let surface = Surface {
            material,
            tile: 1.0,
        };
        let p = Point3::new(1.0, 2.0, 3.0);
        bar(&mut scene, surface, p, p, 0.1);
        assert_eq!(scene.triangles(), 0);
        bar(&mut scene, surface, p, p + Vector3::z(), 0.1);
        assert_eq!(scene.triangles(), 8);
    }
}
