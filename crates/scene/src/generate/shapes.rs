//! Boxes, prisms, strips and filled outlines, with texture coordinates in metres.

use nalgebra::Point3;
use openbench_core::{MapPoint, Pose2};

use crate::material::MaterialId;
use crate::scene::{Layer, SceneBuilder};
use crate::triangulate::{triangulate, turn};

/// A material, and how many metres its image covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Surface {
    pub material: MaterialId,
    pub tile: f64,
}

/// Corner with texture coordinates in tiles.
pub(super) type Corner = (Point3<f64>, [f32; 2]);

pub(super) fn at(p: MapPoint, z: f64) -> Point3<f64> {
    Point3::new(p.x, p.y, z)
}

/// A vertical rectangle over the line from `a` to `b`, seen from its right; the image is tiled by metres.
pub(super) fn wall(
    builder: &mut SceneBuilder,
    layer: Layer,
    surface: Surface,
    (a, b): (MapPoint, MapPoint),
    z: (f64, f64),
) {
    let u = (a.distance(b) / surface.tile) as f32;
    let v = ((z.0 / surface.tile) as f32, (z.1 / surface.tile) as f32);
    let corners = [
        (at(a, z.0), [0.0, v.0]),
        (at(b, z.0), [u, v.0]),
        (at(b, z.1), [u, v.1]),
        (at(a, z.1), [0.0, v.1]),
    ];
    builder.mesh(layer, surface.material, &corners, &[[0, 1, 2], [0, 2, 3]]);
}

/// The same with the image fitted to the rectangle once.
pub(super) fn panel(
    builder: &mut SceneBuilder,
    layer: Layer,
    material: MaterialId,
    (a, b): (MapPoint, MapPoint),
    z: (f64, f64),
) {
    let corners = [
        (at(a, z.0), [0.0, 0.0]),
        (at(b, z.0), [1.0, 0.0]),
        (at(b, z.1), [1.0, 1.0]),
        (at(a, z.1), [0.0, 1.0]),
    ];
    builder.mesh(layer, material, &corners, &[[0, 1, 2], [0, 2, 3]]);
}

/// A planar polygon in space, convex, counter-clockwise from outside; texture coordinates along its first edge and
/// across it.
pub(super) fn facet(
    builder: &mut SceneBuilder,
    layer: Layer,
    surface: Surface,
    points: &[Point3<f64>],
) {
    if points.len() < 3 {
        return;
    }
    let along = (points[1] - points[0])
        .try_normalize(1e-9)
        .unwrap_or_else(nalgebra::Vector3::x);
    let normal = (points[1] - points[0]).cross(&(points[points.len() - 1] - points[0]));
    let across = normal
        .cross(&along)
        .try_normalize(1e-9)
        .unwrap_or_else(nalgebra::Vector3::y);
    let uv = |p: &Point3<f64>| {
        let d = p - points[0];
        [
            (d.dot(&along) / surface.tile) as f32,
            (d.dot(&across) / surface.tile) as f32,
        ]
    };
    let corners: Vec<Corner> = points.iter().map(|p| (*p, uv(p))).collect();
    let fan: Vec<[u32; 3]> = (2..points.len() as u32).map(|i| [0, i - 1, i]).collect();
    builder.mesh(layer, surface.material, &corners, &fan);
}

/// A box on a pose: from `min` to `max` (forward, left, up), without its underside if it stands on the ground.
pub(super) fn cuboid(
    builder: &mut SceneBuilder,
    layer: Layer,
    surface: Surface,
    pose: Pose2,
    (min, max): ([f64; 3], [f64; 3]),
) {
    let p = |x: f64, y: f64| pose.transform(x, y);
    let ring = [
        p(min[0], min[1]),
        p(max[0], min[1]),
        p(max[0], max[1]),
        p(min[0], max[1]),
    ];
    for i in 0..4 {
        wall(
            builder,
            layer,
            surface,
            (ring[i], ring[(i + 1) % 4]),
            (min[2], max[2]),
        );
    }
    facet(builder, layer, surface, &ring.map(|q| at(q, max[2])));
    if min[2] > 0.05 {
        let [a, b, c, d] = ring.map(|q| at(q, min[2]));
        facet(builder, layer, surface, &[a, d, c, b]);
    }
}

/// A frustum with `sides` sides, its axis upright, closed at the top.
pub(super) fn prism(
    builder: &mut SceneBuilder,
    layer: Layer,
    surface: Surface,
    (center, sides): (MapPoint, usize),
    (z, radius): ((f64, f64), (f64, f64)),
) {
    let direction = |i: usize| std::f64::consts::TAU * i as f64 / sides as f64;
    let bottom = |i: usize| at(center.offset(direction(i), radius.0), z.0);
    let top = |i: usize| at(center.offset(direction(i), radius.1), z.1);
    for i in 0..sides {
        if radius.1 > 1e-6 {
            facet(
                builder,
                layer,
                surface,
                &[bottom(i), bottom(i + 1), top(i + 1), top(i)],
            );
        } else {
            facet(builder, layer, surface, &[bottom(i), bottom(i + 1), top(i)]);
        }
    }
    if radius.1 > 1e-6 {
        let cap: Vec<_> = (0..sides).map(top).collect();
        facet(builder, layer, surface, &cap);
    }
}

/// A filled outline at height `z`, seen from above.
pub(super) fn floor(
    builder: &mut SceneBuilder,
    surface: Surface,
    (outer, holes): (&[MapPoint], &[Vec<MapPoint>]),
    z: f64,
) {
    let uv = |p: MapPoint| [(p.x / surface.tile) as f32, (p.y / surface.tile) as f32];
    for t in triangulate(outer, holes) {
        let corners = t.map(|p| (at(p, z), uv(p)));
        builder.mesh(Layer::Visible, surface.material, &corners, &[[0, 1, 2]]);
    }
}

/// A flat band along a line, `half` metres to either side, with mitred bends and rounded ends.
pub(super) fn band(
    builder: &mut SceneBuilder,
    surface: Surface,
    line: &[MapPoint],
    half: f64,
    z: f64,
) {
    let sides = parallel(line, half).into_iter().zip(parallel(line, -half));
    let (mut corners, mut run) = (Vec::<Corner>::new(), 0.0);
    for (i, (left, right)) in sides.enumerate() {
        run += if i > 0 {
            line[i].distance(line[i - 1])
        } else {
            0.0
        };
        let u = (run / surface.tile) as f32;
        corners.push((at(right, z), [u, 0.0]));
        corners.push((at(left, z), [u, (2.0 * half / surface.tile) as f32]));
    }
    let quads = (1..line.len() as u32).flat_map(|i| {
        let k = 2 * i;
        [[k - 2, k, k + 1], [k - 2, k + 1, k - 1]]
    });
    builder.mesh(
        Layer::Visible,
        surface.material,
        &corners,
        &quads.collect::<Vec<_>>(),
    );
    if line.len() > 1 {
        for (end, from) in [
            (line[0], line[1]),
            (line[line.len() - 1], line[line.len() - 2]),
        ] {
            half_disc(builder, surface, (end, from.bearing_to(end)), half, z);
        }
    }
}

fn half_disc(
    builder: &mut SceneBuilder,
    surface: Surface,
    (center, facing): (MapPoint, f64),
    radius: f64,
    z: f64,
) {
    const STEPS: usize = 6;
    let angle = |i: usize| facing + std::f64::consts::PI * (i as f64 / STEPS as f64 - 0.5);
    let points: Vec<MapPoint> = (0..=STEPS)
        .map(|i| center.offset(angle(i), radius))
        .collect();
    let uv = |p: MapPoint| [(p.x / surface.tile) as f32, (p.y / surface.tile) as f32];
    let corners: Vec<Corner> = points.iter().map(|p| (at(*p, z), uv(*p))).collect();
    let fan: Vec<[u32; 3]> = (2..corners.len() as u32).map(|i| [0, i - 1, i]).collect();
    builder.mesh(Layer::Visible, surface.material, &corners, &fan);
}

/// The line moved `offset` metres to its left (right if negative), mitred; bends sharper than about 120 degrees are cut.
pub(super) fn parallel(line: &[MapPoint], offset: f64) -> Vec<MapPoint> {
    let normal = |a: MapPoint, b: MapPoint| {
        let length = a.distance(b).max(1e-9);
        (-(b.y - a.y) / length, (b.x - a.x) / length)
    };
    let n = line.len();
    (0..n)
        .map(|i| {
            let before = (i > 0).then(|| normal(line[i - 1], line[i]));
            let after = (i + 1 < n).then(|| normal(line[i], line[i + 1]));
            let (a, b) = (
                before.or(after).unwrap_or((0.0, 1.0)),
                after.or(before).unwrap_or((0.0, 1.0)),
            );
            let scale = offset / (1.0 + a.0 * b.0 + a.1 * b.1).max(0.5);
            MapPoint::new(
                line[i].x + (a.0 + b.0) * scale,
                line[i].y + (a.1 + b.1) * scale,
            )
        })
        .collect()
}

/// A closed ring moved `inset` metres to its left (inwards for an outline, outwards for a hole seen from the building);
/// `None` if an edge would be turned round.
pub(super) fn inset(ring: &[MapPoint], inset: f64) -> Option<Vec<MapPoint>> {
    let n = ring.len();
    if n < 3 {
        return None;
    }
    let padded: Vec<MapPoint> = (0..n + 2).map(|i| ring[(i + n - 1) % n]).collect();
    let moved = parallel(&padded, inset)[1..=n].to_vec();
    let kept = (0..n).all(|i| {
        let (a, b, p, q) = (ring[i], ring[(i + 1) % n], moved[i], moved[(i + 1) % n]);
        (b.x - a.x) * (q.x - p.x) + (b.y - a.y) * (q.y - p.y) > 0.0
    });
    kept.then_some(moved)
}

/// Sum of signed areas; positive for a counter-clockwise ring.
pub(super) fn signed_area(ring: &[MapPoint]) -> f64 {
    let origin = MapPoint::default();
    (0..ring.len())
        .map(|i| turn(origin, ring[i], ring[(i + 1) % ring.len()]) / 2.0)
        .sum()
}

/// The point `share` of the way from `a` to `b`.
pub(super) fn along(a: MapPoint, b: MapPoint, share: f64) -> MapPoint {
    MapPoint::new(a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_shrinks_until_it_turns_round() {
        let square =
            [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)].map(|(x, y)| MapPoint::new(x, y));
        let smaller = inset(&square, 1.0).unwrap();
        assert!((signed_area(&smaller) - 4.0).abs() < 1e-9);
        assert_eq!(inset(&square, 2.5), None);
    }

    #[test]
    fn a_bend_is_mitred() {
        let line = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0)].map(|(x, y)| MapPoint::new(x, y));
        let left = parallel(&line, 1.0);
        assert!(left[1].distance(MapPoint::new(3.0, 1.0)) < 1e-9);
    }
}
