//! Sixteen rays at once.
//!
//! Every step is a loop over sixteen lanes of plain arrays, without a branch in it, so that the compiler makes it one to four vector
//! instructions of whatever machine it compiles for. No operation is fused or approximate: each instruction set gives the same bits.

use super::{
    Hit, LeafTriangle, MISS, Node, TriangleBvh, lower, mask, moeller_trumbore, reciprocal, select, upper,
};

/// Rays in a packet.
pub const LANES: usize = 16;

/// Depth of tree that the packet traversal's stack has room for: each level leaves one sibling behind.
pub(super) const PACKET_STACK: usize = 192;

type Lane = [f32; LANES];

/// Sixteen rays. Directions need not have unit length: distances count in their lengths.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct RayPacket {
    /// Origins: x, y, z.
    pub origin: [Lane; 3],
    /// Directions: x, y, z.
    pub direction: [Lane; 3],
    /// Distance beyond which nothing is hit; a lane with a negative one is idle.
    pub limit: Lane,
}

impl RayPacket {
    /// Sixteen idle rays.
    pub fn idle() -> Self {
        Self { origin: [[0.0; LANES]; 3], direction: [[1.0; LANES]; 3], limit: [-1.0; LANES] }
    }

    /// Sets one ray.
    #[inline]
    pub fn set(&mut self, lane: usize, origin: [f32; 3], direction: [f32; 3], limit: f32) {
        for axis in 0..3 {
            self.origin[axis][lane] = origin[axis];
            self.direction[axis][lane] = direction[axis];
        }
        self.limit[lane] = limit;
    }
}

/// What sixteen rays hit first.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct PacketHits {
    /// Distances in lengths of the directions; the limit where nothing was hit.
    pub distance: Lane,
    /// Indices of the triangles, or [`MISS`].
    pub triangle: [u32; LANES],
    /// Weight of the triangle's second corner at the hit.
    pub u: Lane,
    /// Weight of the triangle's third corner at the hit.
    pub v: Lane,
}

impl PacketHits {
    /// What one ray hit; [`MISS`] as its triangle if nothing.
    #[inline]
    pub fn hit(&self, lane: usize) -> Hit {
        Hit { distance: self.distance[lane], triangle: self.triangle[lane], u: self.u[lane], v: self.v[lane] }
    }

    /// No hits of `rays` yet.
    pub(super) fn none(rays: &RayPacket) -> Self {
        Self { distance: rays.limit, triangle: [MISS; LANES], u: [0.0; LANES], v: [0.0; LANES] }
    }
}

/// Sixteen rays with what their traversal needs.
struct Traversal<'a> {
    rays: &'a RayPacket,
    /// One over the directions.
    inverse: [Lane; 3],
    /// For each axis 1 if most rays run against it, else 0.
    against: [u32; 3],
}

impl<'a> Traversal<'a> {
    #[inline(always)]
    fn new(rays: &'a RayPacket) -> Self {
        let inverse = rays.direction.map(|axis| axis.map(reciprocal));
        let against = rays.direction.map(|axis| u32::from(axis.iter().sum::<f32>() < 0.0));
        Self { rays, inverse, against }
    }

    /// Whether any ray enters the node's box before its hit so far.
    #[inline(always)]
    fn enters(&self, node: &Node, limit: &Lane) -> bool {
        let mut inside = [0_u32; LANES];
        for lane in 0..LANES {
            let (mut enter, mut leave) = (0.0_f32, limit[lane]);
            for axis in 0..3 {
                let a = (node.min[axis] - self.rays.origin[axis][lane]) * self.inverse[axis][lane];
                let b = (node.max[axis] - self.rays.origin[axis][lane]) * self.inverse[axis][lane];
                enter = upper(lower(a, b), enter);
                leave = lower(upper(a, b), leave);
            }
            inside[lane] = mask(enter <= leave);
        }
        inside.iter().fold(0, |any, lane| any | lane) != 0
    }

    /// The children of an inner node, the one that most rays enter first before the other.
    #[inline(always)]
    fn ordered(&self, node: &Node) -> (u32, u32) {
        let second_first = self.against[node.axis()] ^ node.flipped();
        (node.first + second_first, node.first + 1 - second_first)
    }
}

/// What the rays hit first in `tree`. A box is tested when its turn comes, not when its parent is opened: by then nearer hits may have
/// shortened the rays.
#[inline(always)]
pub(super) fn traverse(
    tree: &TriangleBvh,
    rays: &RayPacket,
    opaque: &impl Fn(&Hit) -> bool,
    hits: &mut PacketHits,
) {
    let traversal = Traversal::new(rays);
    let mut stack = [0_u32; PACKET_STACK + 2];
    let mut top = 1;
    while top > 0 {
        top -= 1;
        let node = &tree.nodes[stack[top] as usize];
        if !traversal.enters(node, &hits.distance) {
            continue;
        }
        if node.is_leaf() {
            for triangle in tree.leaf(node) {
                if triangle.masked {
                    intersect_masked(triangle, rays, hits, opaque);
                } else {
                    intersect(triangle, rays, hits);
                }
            }
        } else {
            let (near, far) = traversal.ordered(node);
            (stack[top], stack[top + 1]) = (far, near);
            top += 2;
        }
    }
}

#[inline(always)]
fn intersect(triangle: &LeafTriangle, rays: &RayPacket, hits: &mut PacketHits) {
    let triangle = *triangle;
    for lane in 0..LANES {
        let at = |v: &[Lane; 3]| [v[0][lane], v[1][lane], v[2][lane]];
        let (distance, u, v, hit) =
            moeller_trumbore(&triangle, at(&rays.origin), at(&rays.direction), hits.distance[lane]);
        hits.distance[lane] = select(hit, distance, hits.distance[lane]);
        hits.triangle[lane] = (triangle.index & hit) | (hits.triangle[lane] & !hit);
        hits.u[lane] = select(hit, u, hits.u[lane]);
        hits.v[lane] = select(hit, v, hits.v[lane]);
    }
}

/// As [`intersect`], but asks for each hit whether it goes through a hole.
#[inline(always)]
fn intersect_masked(
    triangle: &LeafTriangle,
    rays: &RayPacket,
    hits: &mut PacketHits,
    opaque: &impl Fn(&Hit) -> bool,
) {
    let mut candidates =
        PacketHits { distance: hits.distance, triangle: [MISS; LANES], u: [0.0; LANES], v: [0.0; LANES] };
    intersect(triangle, rays, &mut candidates);
    let mut hit = 0_u32;
    for lane in 0..LANES {
        hit |= u32::from(candidates.triangle[lane] != MISS) << lane;
    }
    while hit != 0 {
        let lane = hit.trailing_zeros() as usize;
        hit &= hit - 1;
        let (distance, u, v) = (candidates.distance[lane], candidates.u[lane], candidates.v[lane]);
        if opaque(&Hit { distance, triangle: triangle.index, u, v }) {
            hits.distance[lane] = distance;
            hits.triangle[lane] = triangle.index;
            (hits.u[lane], hits.v[lane]) = (u, v);
        }
    }
}
