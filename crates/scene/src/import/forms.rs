//! Triangles of boxes, planes, cylinders, spheres and extruded outlines, in the frame of the shape.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, UnitQuaternion, Vector3};

use openbench_core::MapPoint;

use super::mesh::Part;
use crate::beyond::{Rectangle, beyond};
use crate::scene::Corner;
use crate::triangulate::triangulate;

/// Sides of cylinders and balls. A circle of 24 sides is 1 % narrower between its corners.
const SEGMENTS: u32 = 24;
/// Rows of faces on a ball.
const RINGS: u32 = 12;
/// Shortest side of the middle of a collision plane, metres.
const SOLID_PLANE_EDGE_M: f64 = 200.0;

/// A box around the origin. `metres` is the size of one repeat of the image; `None` stretches one
/// repeat over each side.
pub(crate) fn cuboid(size: Vector3<f64>, metres: Option<[f64; 2]>) -> Part {
    let mut part = Part::default();
    let h = size / 2.0;
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut normal = Vector3::zeros();
            normal[axis] = sign;
            // The image stands upright on the sides; top and bottom have no upright, and y is
            // taken.
            let up = if axis == 2 {
                Vector3::y()
            } else {
                Vector3::z()
            };
            let right = up.cross(&normal);
            let extent = |v: Vector3<f64>| v.abs().dot(&size);
            let repeat = metres.map_or([1.0; 2], |[u, v]| [extent(right) / u, extent(up) / v]);
            let middle = normal.component_mul(&h);
            quad(
                &mut part,
                middle,
                right * extent(right),
                up * extent(up),
                repeat,
            );
        }
    }
    part
}

/// A rectangle around the origin that faces `normal`.
pub(crate) fn plane(
    normal: Vector3<f64>,
    size: [f64; 2],
    visual: bool,
    metres: Option<[f64; 2]>,
) -> Part {
    let size = if visual {
        size
    } else {
        size.map(|s| s.max(SOLID_PLANE_EDGE_M))
    };
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &normal)
        // Straight down, no single rotation is the shortest; a half turn about any level axis will
        // do.
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI));
    let repeat = metres.map_or([1.0; 2], |m| [size[0] / m[0], size[1] / m[1]]);
    let mut part = Part::default();
    let (x, y) = (turn * Vector3::x(), turn * Vector3::y());
    quad(
        &mut part,
        Vector3::zeros(),
        x * size[0],
        y * size[1],
        repeat,
    );
    if !visual {
        // In Gazebo collision planes are infinite, whatever `<size>` is.
        let [right, top] = size.map(|s| s / 2.0);
        for Rectangle { low, high } in beyond(Rectangle {
            low: [-right, -top],
            high: [right, top],
        }) {
            let middle = x * ((low[0] + high[0]) / 2.0) + y * ((low[1] + high[1]) / 2.0);
            quad(
                &mut part,
                middle,
                x * (high[0] - low[0]),
                y * (high[1] - low[1]),
                [1.0; 2],
            );
        }
    }
    part
}

fn quad(part: &mut Part, middle: Vector3<f64>, u: Vector3<f64>, v: Vector3<f64>, repeat: [f64; 2]) {
    let base = part.corners.len() as u32;
    let repeat = repeat.map(|r| r as f32);
    for (a, b) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        let at = middle + u * (a - 0.5) + v * (b - 0.5);
        let uv = [a as f32 * repeat[0], b as f32 * repeat[1]];
        part.corners.push(Corner::new(at.into(), uv));
    }
    part.triangles
        .extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
}

/// A cylinder along z around the origin.
pub(crate) fn cylinder(radius: f64, length: f64) -> Part {
    let mut part = Part::default();
    for (z, v) in [(-length / 2.0, 0.0), (length / 2.0, 1.0)] {
        part.corners
            // One corner more than segments: where the image closes, u is 0 and 1 at the same
            // place.
            .extend((0..=SEGMENTS).map(|i| circle_corner(radius, i, z, v)));
    }
    let row = SEGMENTS + 1;
    part.triangles
        .extend((0..SEGMENTS).flat_map(|i| band(i, i + row)));
    for (start, top) in [(0, false), (row, true)] {
        let middle = part.corners.len() as u32;
        let z = if top { length / 2.0 } else { -length / 2.0 };
        let middle_corner = Corner::new(Point3::new(0.0, 0.0, z), [0.5, 0.5]);
        part.corners.push(middle_corner);
        let cap = (start..start + SEGMENTS).map(|i| {
            if top {
                [middle, i, i + 1]
            } else {
                [middle, i + 1, i]
            }
        });
        part.triangles.extend(cap);
    }
    part
}

/// Outlines extruded from z = 0: the first is the outer one, the others are holes. `metres` is the
/// size of one repeat of the image; `None` stretches one repeat over each wall.
pub(crate) fn extrusion(outlines: &[Vec<[f64; 2]>], height: f64, metres: Option<[f64; 2]>) -> Part {
    let mut part = Part::default();
    let mut rings: Vec<Vec<MapPoint>> = Vec::new();
    for (i, outline) in outlines.iter().enumerate() {
        let mut ring: Vec<MapPoint> = outline.iter().map(|[x, y]| MapPoint::new(*x, *y)).collect();
        // The outer one counter-clockwise, holes clockwise: walls face away from the solid.
        if (area(&ring) > 0.0) != (i == 0) {
            ring.reverse();
        }
        for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let (along, up) = (
                Vector3::new(b.x - a.x, b.y - a.y, 0.0),
                Vector3::z() * height,
            );
            let repeat = metres.map_or([1.0; 2], |[u, v]| [along.norm() / u, height / v]);
            quad(
                &mut part,
                Vector3::new(a.x, a.y, 0.0) + along / 2.0 + up / 2.0,
                along,
                up,
                repeat,
            );
        }
        rings.push(ring);
    }
    let Some((outer, holes)) = rings.split_first() else {
        return part;
    };
    let [u, v] = metres.unwrap_or([1.0; 2]);
    for triangle in triangulate(outer, holes) {
        for (z, order) in [(height, [0, 1, 2]), (0.0, [0, 2, 1])] {
            let base = part.corners.len() as u32;
            part.corners.extend(order.map(|i: usize| {
                let MapPoint { x, y } = triangle[i];
                Corner::new(Point3::new(x, y, z), [(x / u) as f32, (y / v) as f32])
            }));
            part.triangles.push([base, base + 1, base + 2]);
        }
    }
    part
}

/// Signed area, positive counter-clockwise.
fn area(ring: &[MapPoint]) -> f64 {
    let sides = ring.iter().zip(ring.iter().cycle().skip(1));
    sides.map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>() / 2.0
}

/// A ball around the origin.
pub(crate) fn sphere(radius: f64) -> Part {
    let mut part = Part::default();
    for ring in 0..=RINGS {
        let v = f64::from(ring) / f64::from(RINGS);
        let (sin, cos) = libm::sincos(PI * v);
        part.corners
            .extend((0..=SEGMENTS).map(|i| circle_corner(radius * sin, i, -radius * cos, v)));
    }
    let row = SEGMENTS + 1;
    for ring in 0..RINGS {
        part.triangles
            // At the poles one triangle of each pair has no area, and no ray hits it.
            .extend((0..SEGMENTS).flat_map(|i| band(ring * row + i, (ring + 1) * row + i)));
    }
    part
}

fn circle_corner(radius: f64, i: u32, z: f64, v: f64) -> Corner {
    let u = f64::from(i) / f64::from(SEGMENTS);
    let (sin, cos) = libm::sincos(TAU * u);
    Corner::new(
        Point3::new(radius * cos, radius * sin, z),
        [u as f32, v as f32],
    )
}

/// Two triangles between neighbours in a lower and an upper row.
fn band(low: u32, high: u32) -> [[u32; 3]; 2] {
    [[low, low + 1, high + 1], [low, high + 1, high]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume inside the triangles: correct only if every triangle faces outward.
    fn volume(part: &Part) -> f64 {
        let p = |i: u32| part.corners[i as usize].position.coords;
        part.triangles
            .iter()
            .map(|[a, b, c]| p(*a).dot(&p(*b).cross(&p(*c))) / 6.0)
            .sum()
    }

    #[test]
    fn forms_are_closed_and_face_outward() {
        assert!((volume(&cuboid(Vector3::new(1.0, 2.0, 3.0), None)) - 6.0).abs() < 1e-9);
        let cylinder = volume(&cylinder(0.5, 2.0)) / (PI * 0.5);
        assert!((0.97..1.0).contains(&cylinder), "{cylinder}");
        let square = |half: f64| vec![[-half, -half], [half, -half], [half, half], [-half, half]];
        let clockwise = square(0.5).into_iter().rev().collect();
        for hole in [square(0.5), clockwise] {
            let ring = volume(&extrusion(&[square(1.0), hole], 2.0, None));
            assert!(
                (ring - 6.0).abs() < 1e-9,
                "a square yard in a square house: {ring}"
            );
        }
        let sphere = volume(&sphere(2.0)) / (4.0 / 3.0 * PI * 8.0);
        assert!((0.95..1.0).contains(&sphere), "{sphere}");
    }

    #[test]
    fn a_plane_faces_its_normal_and_is_touched_beyond_its_picture() {
        let part = plane(Vector3::x(), [4.0, 2.0], true, None);
        let p = |i: usize| part.corners[i].position;
        assert!(((p(1) - p(0)).cross(&(p(2) - p(0))).normalize() - Vector3::x()).norm() < 1e-9);
        let solid = plane(Vector3::z(), [4.0, 2.0], false, None);
        let touched = |x: f64, y: f64| {
            let holds = |q: &[Corner]| {
                let side = |axis: usize, at: f64| {
                    let of = |c: &Corner| c.position[axis];
                    let low = q.iter().map(of).fold(f64::INFINITY, f64::min);
                    (low..=q.iter().map(of).fold(low, f64::max)).contains(&at)
                };
                side(0, x) && side(1, y)
            };
            solid.corners.chunks(4).any(holds)
        };
        assert!(
            [0.0, 99.9, 100.0, 100.1, 10_000.0]
                .into_iter()
                .all(|d| touched(d, 0.0) && touched(-d, d))
        );
    }
}
