//! One ray against one triangle, after Möller and Trumbore, *Fast, Minimum Storage Ray/Triangle
//! Intersection*, 1997; both sides of a triangle are hit.

use super::branchless::mask;

/// Index of a triangle for a ray that hit nothing.
pub const MISS: u32 = u32::MAX;

/// The first hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the direction.
    pub distance: f32,
    /// Index of the triangle.
    pub triangle: u32,
    /// Weight of the triangle's second corner at the hit.
    pub u: f32,
    /// Weight of the triangle's third corner at the hit.
    pub v: f32,
}

/// A triangle as the intersection test needs it.
#[derive(Debug, Clone, Copy)]
#[repr(align(16))]
pub(super) struct LeafTriangle {
    pub(super) corner: [f32; 3],
    pub(super) edge1: [f32; 3],
    pub(super) edge2: [f32; 3],
    pub(super) index: u32,
    /// Whether the triangle may have holes, which the caller tests.
    pub(super) masked: bool,
}

pub(super) fn leaf_triangle(
    t: &obvhs::triangle::Triangle,
    index: u32,
    masked: bool,
) -> LeafTriangle {
    LeafTriangle {
        corner: t.v0.into(),
        edge1: (t.v1 - t.v0).into(),
        edge2: (t.v2 - t.v0).into(),
        index,
        masked,
    }
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Where a ray meets the plane of a triangle.
#[derive(Clone, Copy)]
pub(super) struct Meeting {
    /// In lengths of the direction.
    pub(super) distance: f32,
    /// Weights of the second and the third corner.
    pub(super) u: f32,
    pub(super) v: f32,
    /// Ones in every bit if the triangle is hit before the limit, else zeros.
    pub(super) hit: u32,
}

/// Hits nearer than this are that of the surface from which the ray starts, in lengths of the
/// direction.
const NEAREST: f32 = 1e-5;

/// Where a ray meets a triangle, and whether it hits it before `limit`.
#[inline(always)]
pub(super) fn moeller_trumbore(
    t: &LeafTriangle,
    origin: [f32; 3],
    direction: [f32; 3],
    limit: f32,
) -> Meeting {
    // With s = O - V0, p = D × e2 and q = s × e1, the determinant is e1 · p. Cramer's rule gives u
    // = s · p / det, v = D · q / det and the distance e2 · q / det.
    let p = cross(direction, t.edge2);
    let inverse = 1.0 / dot(t.edge1, p);
    let s = [
        origin[0] - t.corner[0],
        origin[1] - t.corner[1],
        origin[2] - t.corner[2],
    ];
    let u = dot(s, p) * inverse;
    let q = cross(s, t.edge1);
    let v = dot(direction, q) * inverse;
    let distance = dot(t.edge2, q) * inverse;
    Meeting::within(distance, u, v, limit)
}

impl Meeting {
    /// A hit if the weights are those of a place in the triangle, before the limit.
    #[inline(always)]
    fn within(distance: f32, u: f32, v: f32, limit: f32) -> Self {
        // A ray in the plane of the triangle gives NaN or infinity, and no comparison is true.
        // Masks instead of `&&`: a branch for each lane would keep the compiler from using vectors.
        // Edges belong to the triangles on both sides, so that hardly a ray passes between them.
        let hit = mask(u >= 0.0)
            & mask(v >= 0.0)
            & mask(u + v <= 1.0)
            & mask(distance > NEAREST)
            & mask(distance < limit);
        Self {
            distance,
            u,
            v,
            hit,
        }
    }
}

/// A triangle as rays from one point meet it: what [`moeller_trumbore`] computes for each ray, but
/// depends on the origin alone, is computed once. Places differ from its ones by rounding.
#[derive(Clone, Copy)]
pub(super) struct FromPoint {
    /// The determinant for a direction along each axis.
    determinant: [f32; 3],
    /// The same for the weight of the second corner, and for that of the third.
    second: [f32; 3],
    third: [f32; 3],
    /// The distance times the determinant.
    distance: f32,
}

impl FromPoint {
    #[inline(always)]
    pub(super) fn new(t: &LeafTriangle, origin: [f32; 3]) -> Self {
        let s = [
            origin[0] - t.corner[0],
            origin[1] - t.corner[1],
            origin[2] - t.corner[2],
        ];
        // Triple products keep their value when their factors rotate: e1 · (D × e2) = D · (e2 ×
        // e1), and s · (D × e2) = D · (e2 × s).
        let third = cross(s, t.edge1);
        Self {
            determinant: cross(t.edge2, t.edge1),
            second: cross(t.edge2, s),
            third,
            distance: dot(t.edge2, third),
        }
    }

    #[inline(always)]
    pub(super) fn meet(&self, direction: [f32; 3], limit: f32) -> Meeting {
        let inverse = 1.0 / dot(direction, self.determinant);
        let u = dot(direction, self.second) * inverse;
        let v = dot(direction, self.third) * inverse;
        let distance = self.distance * inverse;
        Meeting::within(distance, u, v, limit)
    }
}

#[inline(always)]
pub(super) fn intersect_one(
    triangle: &LeafTriangle,
    origin: [f32; 3],
    direction: [f32; 3],
    best: &mut Hit,
) -> bool {
    let met = moeller_trumbore(triangle, origin, direction, best.distance);
    if met.hit != 0 {
        *best = Hit {
            distance: met.distance,
            triangle: triangle.index,
            u: met.u,
            v: met.v,
        };
    }
    met.hit != 0
}
