//! `<road>`: a ribbon through points with mitred joints.
//!
//! Roads of Gazebo have no collision shape and may float above the ground, so that wheels sink into
//! them. Here they are moved onto a near ground plane: a floating sheet would be an obstacle to a
//! LiDAR.

use nalgebra::{Point3, Vector2};

use super::mesh::Part;
use super::sdf::Road;
use crate::scene::Corner;

/// At joints sharper than this the ribbon is cut square, since a mitre would be a long spike.
const MAX_MITRE: f64 = 3.0;
/// Largest distance of roads from the ground plane that they belong to, metres.
const NEAR_GROUND_M: f64 = 0.5;
/// Height of the lowest road above the ground, metres.
const CLEARANCE_M: f64 = 0.01;

/// By how much all roads have to be raised (lowered if negative) to lie on the ground at height
/// `ground`, metres.
pub(crate) fn shift_to_ground(roads: &[Road], ground: Option<f64>) -> f64 {
    let lowest = roads
        .iter()
        .flat_map(|r| &r.points)
        .map(|p| p[2])
        .min_by(f64::total_cmp);
    match (lowest, ground) {
        (Some(lowest), Some(ground)) if (lowest - ground).abs() < NEAR_GROUND_M => {
            ground + CLEARANCE_M - lowest
        }
        _ => 0.0,
    }
}

/// The surface of a road, raised by `shift` metres. u runs across from 0 to 1; v runs along, 1 for
/// each `repeat` metres.
pub(crate) fn ribbon(road: &Road, shift: f64, repeat: f64) -> Part {
    let points = distinct(&road.points);
    let mut part = Part::default();
    let mut along = 0.0;
    for (i, p) in points.iter().enumerate() {
        if i > 0 {
            along += (flat(p) - flat(&points[i - 1])).norm();
        }
        let before = i.checked_sub(1).map(|j| direction(&points[j], p));
        let after = points.get(i + 1).map(|next| direction(p, next));
        // One direction at the ends of the road, two at a joint.
        let side = mitre(before, after) * (road.width / 2.0);
        for (offset, u) in [(side, 0.0), (-side, 1.0)] {
            let at = Point3::new(p[0] + offset.x, p[1] + offset.y, p[2] + shift);
            let uv = [u, (along / repeat) as f32];
            part.corners.push(Corner::new(at, uv));
        }
    }
    for i in 1..points.len() as u32 {
        let (left, right) = (2 * i - 2, 2 * i - 1);
        part.triangles
            .extend([[left, right, right + 2], [left, right + 2, left + 2]]);
    }
    part
}

fn distinct(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut kept: Vec<[f64; 3]> = Vec::new();
    for p in points {
        if kept
            .last()
            // Between equal points there is no direction.
            .is_none_or(|last| (flat(p) - flat(last)).norm() > 1e-6)
        {
            kept.push(*p);
        }
    }
    kept
}

fn flat(p: &[f64; 3]) -> Vector2<f64> {
    Vector2::new(p[0], p[1])
}

fn direction(from: &[f64; 3], to: &[f64; 3]) -> Vector2<f64> {
    (flat(to) - flat(from)).normalize()
}

/// Offset of the left edge of a ribbon of half width one at a joint between the directions `before`
/// and `after`.
fn mitre(before: Option<Vector2<f64>>, after: Option<Vector2<f64>>) -> Vector2<f64> {
    let left = |d: Vector2<f64>| Vector2::new(-d.y, d.x);
    let (Some(before), Some(after)) = (before, after) else {
        return before.or(after).map_or(Vector2::y(), left);
    };
    // The offset m lies one half width from both lines: m · l = 1 for both normals l. Hence m = 2
    // (l1 + l2) / |l1 + l2|².
    let middle = left(before) + left(after);
    let length = 2.0 / middle.norm_squared().max(1e-12);
    let mitred = middle * length;
    if mitred.norm() < MAX_MITRE {
        mitred
    } else {
        left(before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn road(points: &[[f64; 3]]) -> Road {
        Road {
            name: "r".into(),
            width: 4.0,
            points: points.to_vec(),
            paint: None,
        }
    }

    #[test]
    fn a_corner_is_mitred() {
        let part = ribbon(
            &road(&[[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 10.0, 0.0]]),
            0.0,
            8.0,
        );
        let at = |i: usize| part.corners[i].position;
        assert!(
            (at(2) - Point3::new(8.0, 2.0, 0.0)).norm() < 1e-9,
            "{}",
            at(2)
        );
        assert!(
            (at(3) - Point3::new(12.0, -2.0, 0.0)).norm() < 1e-9,
            "{}",
            at(3)
        );
        assert!((part.corners[5].uv[1] - 2.5).abs() < 1e-6);
        for [a, b, c] in &part.triangles {
            let [a, b, c] = [a, b, c].map(|i| at(*i as usize));
            assert!((b - a).cross(&(c - a)).z > 0.0, "faces up");
        }
    }

    #[test]
    fn points_that_repeat_and_turn_back_are_survived() {
        let part = ribbon(
            &road(&[[0.0; 3], [0.0; 3], [5.0, 0.0, 0.0], [0.0; 3]]),
            0.0,
            8.0,
        );
        assert!(part.corners.iter().all(|c| c.position.coords.norm() < 10.0));
        assert!(
            ribbon(&road(&[[0.0; 3], [0.0; 3]]), 0.0, 8.0)
                .triangles
                .is_empty()
        );
    }

    #[test]
    fn floating_roads_are_laid_down() {
        let roads = [road(&[[0.0, 0.0, 0.01], [1.0, 0.0, 0.015]])];
        assert!((shift_to_ground(&roads, Some(-0.1)) + 0.1).abs() < 1e-9);
        assert_eq!(shift_to_ground(&roads, Some(-5.0)), 0.0);
        assert_eq!(shift_to_ground(&roads, None), 0.0);
    }
}
