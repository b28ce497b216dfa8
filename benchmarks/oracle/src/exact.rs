//! Who is right where the pictures differ: every triangle, in double precision, without a tree and without a grid of pixels.

use nalgebra::{Point3, Vector3};
use openbench_scene::{Scene, Triangle, nearest_texel};
use openbench_sim::View;

use crate::rasterizer::Sight;

/// What the middle of a pixel sees.
pub fn sight(scene: &Scene, view: &View, (u, v): (u32, u32)) -> Option<Sight> {
    let axis = |size: u32| (f64::from(size) - 1.0) / 2.0;
    let f = view.focal_length;
    let ray = Vector3::new(
        1.0,
        (axis(view.size.width) - f64::from(u)) / f,
        (axis(view.size.height) - f64::from(v)) / f,
    );
    let (eye, ray) = (
        Point3::from(view.pose.translation.vector),
        view.pose.rotation * ray,
    );
    let mut nearest = (f64::from(view.range), None);
    for (number, triangle) in (0..).zip(&scene.triangles) {
        match depth(scene, triangle, eye, ray) {
            Some(depth) if depth < nearest.0 => nearest = (depth, Some(number)),
            _ => {}
        }
    }
    nearest.1.map(|triangle| Sight {
        triangle,
        depth: nearest.0 as f32,
    })
}

/// Depth at which a ray meets a triangle, holes left out (Cramer's rule on origin + depth * ray = corner + b * edge + c * edge).
fn depth(scene: &Scene, triangle: &Triangle, eye: Point3<f64>, ray: Vector3<f64>) -> Option<f64> {
    let corners = triangle.corners.map(|i| &scene.vertices[i as usize]);
    let [p, q, r] = corners.map(|v| Point3::from(v.position.map(f64::from)));
    let (e, f, from) = (q - p, r - p, eye - p);
    let volume = -ray.dot(&e.cross(&f));
    let (depth, b) = (
        from.dot(&e.cross(&f)) / volume,
        -ray.dot(&from.cross(&f)) / volume,
    );
    let c = -ray.dot(&e.cross(&from)) / volume;
    if !(b >= 0.0 && c >= 0.0 && b + c <= 1.0 && depth > 0.0) {
        return None;
    }
    let material = &scene.materials[triangle.material.0 as usize];
    let texture = material
        .texture
        .filter(|_| material.cutout)
        .map(|t| &scene.textures[t.0 as usize]);
    let at = |k: usize| {
        let [x, y, z] = corners.map(|v| f64::from(v.uv[k]));
        (x + b * (y - x) + c * (z - x)).rem_euclid(1.0) as f32
    };
    let hole = texture.is_some_and(|t| nearest_texel(t, [at(0), at(1)])[3] < 128);
    (!hole).then_some(depth)
}
