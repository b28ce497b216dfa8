//! Rays against triangles: a bounding volume hierarchy built by `obvhs`, traversed here ray by ray or in packets of sixteen.
//!
//! One ray and sixteen rays do the same arithmetic lane by lane, so both give the same distances. Intersection after Möller and Trumbore,
//! *Fast, Minimum Storage Ray/Triangle Intersection*, 1997; both sides of a triangle are hit.
//!
//! | module | its one job |
//! |---|---|
//! | [`packet`] | sixteen rays at once |
//! | [`beam`] | blocks of packets from one point, as of a camera |
//! | `movers` | figures that are placed anew for each instant, in a small tree over their boxes |
//! | [`dispatch`] | with the widest vector instructions that the machine has |

pub mod beam;
pub mod dispatch;
pub mod movers;
pub mod packet;

use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;

pub use beam::Beam;
use beam::CastBeam;
pub use dispatch::{Kernel, widest};
pub use movers::{Figure, Movers, Placed, SWEEP};
use packet::{Cast, PACKET_STACK};
pub use packet::{LANES, Lane, PacketHits, RayPacket};

/// Marks a ray that hit nothing.
pub const MISS: u32 = u32::MAX;

/// What one ray hit first.
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

/// A box. Two siblings share a line of the cache.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
struct Node {
    min: [f32; 3],
    /// First child (its sibling follows) or first triangle.
    first: u32,
    max: [f32; 3],
    /// Triangles in a leaf, times 8. In an inner node: twice the axis along which its children lie apart, plus one if the first child is
    /// the upper one.
    kind: u32,
}

impl Node {
    #[inline(always)]
    fn is_leaf(&self) -> bool {
        self.kind >= 8
    }

    #[inline(always)]
    fn axis(&self) -> usize {
        (self.kind >> 1 & 3) as usize
    }

    #[inline(always)]
    fn flipped(&self) -> u32 {
        self.kind & 1
    }

    /// The children of an inner node, the nearer first for rays that run against the axes with a 1.
    #[inline(always)]
    fn ordered(&self, against: &[u32; 3]) -> (u32, u32) {
        let second_first = against[self.axis()] ^ self.flipped();
        (self.first + second_first, self.first + 1 - second_first)
    }
}

#[derive(Debug, Clone, Copy)]
#[repr(align(16))]
struct LeafTriangle {
    corner: [f32; 3],
    edge1: [f32; 3],
    edge2: [f32; 3],
    index: u32,
    /// Whether the triangle may have holes, for the caller to say.
    masked: bool,
}

/// Triangles in a tree.
#[derive(Debug, Clone)]
pub struct TriangleBvh {
    nodes: Vec<Node>,
    triangles: Vec<LeafTriangle>,
    depth: usize,
}

impl TriangleBvh {
    /// Builds the tree over the triangles that `corners` yields, three positions each, in metres.
    pub fn new(corners: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        Self::masked(corners, |_| false)
    }

    /// The same; `masked` says of which triangles (by index) casts with a filter must ask whether a hit goes through a hole.
    pub fn masked(
        corners: impl Iterator<Item = [[f32; 3]; 3]>,
        masked: impl Fn(u32) -> bool,
    ) -> Self {
        Self::numbered(corners, 0, masked)
    }

    /// The same, with the triangles numbered from `first`.
    pub fn numbered(
        corners: impl Iterator<Item = [[f32; 3]; 3]>,
        first: u32,
        masked: impl Fn(u32) -> bool,
    ) -> Self {
        let soup: Vec<obvhs::triangle::Triangle> = corners
            .map(|[a, b, c]| obvhs::triangle::Triangle {
                v0: a.into(),
                v1: b.into(),
                v2: c.into(),
            })
            .collect();
        let mut laid = Self {
            nodes: Vec::new(),
            triangles: Vec::with_capacity(soup.len()),
            depth: 0,
        };
        if !soup.is_empty() {
            let mut elapsed = std::time::Duration::ZERO;
            let tree = build_bvh2_from_tris(&soup, BvhBuildParams::slow_build(), &mut elapsed);
            laid.lay_out(&tree, |i| {
                leaf_triangle(&soup[i as usize], first + i, masked(first + i))
            });
        }
        laid
    }

    /// Copies nodes and triangles in the order in which a traversal meets them, siblings in pairs.
    fn lay_out(&mut self, tree: &Bvh2, triangle: impl Fn(u32) -> LeafTriangle) {
        // The root has no sibling; a place left empty beside it lets every pair begin at an even one.
        self.nodes = vec![node(tree, 0); 2];
        let mut todo = vec![(0_u32, 0_usize, 1_usize)];
        while let Some((from, to, depth)) = todo.pop() {
            self.depth = self.depth.max(depth);
            let source = &tree.nodes[from as usize];
            if source.prim_count == 0 {
                let first = self.nodes.len();
                self.nodes[to].first = first as u32;
                self.nodes
                    .extend([source.first_index, source.first_index + 1].map(|i| node(tree, i)));
                todo.push((source.first_index + 1, first + 1, depth + 1));
                todo.push((source.first_index, first, depth + 1));
            } else {
                self.nodes[to].first = self.triangles.len() as u32;
                let primitives = source.first_index..source.first_index + source.prim_count;
                let indices = primitives.map(|i| tree.primitive_indices[i as usize]);
                self.triangles.extend(indices.map(&triangle));
            }
        }
    }

    /// Lowest and highest corner of the box around everything, metres; `None` if there is nothing.
    pub fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        self.nodes.first().map(|root| (root.min, root.max))
    }

    /// What a ray from `origin` along `direction` hits first within `limit` lengths of `direction`.
    pub fn cast(&self, origin: [f32; 3], direction: [f32; 3], limit: f32) -> Option<Hit> {
        self.cast_filtered(origin, direction, limit, |_| true)
    }

    /// The same, hits of masked triangles only where `opaque` says so.
    pub fn cast_filtered(
        &self,
        origin: [f32; 3],
        direction: [f32; 3],
        limit: f32,
        opaque: impl Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        let inverse = direction.map(reciprocal);
        let mut best = Hit {
            distance: limit,
            triangle: MISS,
            u: 0.0,
            v: 0.0,
        };
        let mut stack = Stack::new();
        if !self.nodes.is_empty() {
            stack.push((0, 0.0));
        }
        while let Some((index, entry)) = stack.pop() {
            if entry > best.distance {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.is_leaf() {
                for triangle in self.leaf(node) {
                    let mut hit = best;
                    if intersect_one(triangle, origin, direction, &mut hit)
                        && (!triangle.masked || opaque(&hit))
                    {
                        best = hit;
                    }
                }
                continue;
            }
            let enter = |i: u32| {
                slab_one(&self.nodes[i as usize], origin, inverse, best.distance).map(|t| (i, t))
            };
            match (enter(node.first), enter(node.first + 1)) {
                (Some(a), Some(b)) => {
                    let (near, far) = if a.1 <= b.1 { (a, b) } else { (b, a) };
                    stack.push(far);
                    stack.push(near);
                }
                (Some(one), None) | (None, Some(one)) => stack.push(one),
                (None, None) => {}
            }
        }
        (best.triangle != MISS).then_some(best)
    }

    /// What each of sixteen rays hits first. Fastest when the rays are close to each other.
    pub fn cast_packet(&self, rays: &RayPacket) -> PacketHits {
        self.cast_packet_filtered(rays, |_| true)
    }

    /// The same, hits of masked triangles only where `opaque` says so.
    pub fn cast_packet_filtered(
        &self,
        rays: &RayPacket,
        opaque: impl Fn(&Hit) -> bool,
    ) -> PacketHits {
        let mut hits = PacketHits::none(rays);
        if self.depth >= PACKET_STACK {
            self.cast_each(rays, &opaque, &mut hits);
        } else {
            widest(Cast {
                tree: self,
                rays,
                opaque: &opaque,
                hits: &mut hits,
            });
        }
        hits
    }

    /// What each ray of a block of packets hits first, all of them within `beam` and from its origin; hits of masked triangles only where
    /// `opaque` says so. Of triangles at one distance it need not be the same as for a packet alone.
    #[inline(always)]
    pub fn cast_block<const K: usize>(
        &self,
        beam: &Beam,
        rays: &[RayPacket; K],
        opaque: impl Fn(&Hit) -> bool,
    ) -> [PacketHits; K] {
        let mut hits = [PacketHits::NONE; K];
        for (hits, rays) in hits.iter_mut().zip(rays) {
            hits.distance = rays.limit;
            if self.depth >= PACKET_STACK {
                self.cast_each(rays, &opaque, hits);
            }
        }
        if self.depth < PACKET_STACK {
            widest(CastBeam {
                tree: self,
                beam,
                rays,
                opaque: &opaque,
                hits: &mut hits,
            });
        }
        hits
    }

    /// For trees deeper than the packet's stack, which only degenerate scenes have.
    fn cast_each(&self, rays: &RayPacket, opaque: &impl Fn(&Hit) -> bool, hits: &mut PacketHits) {
        for lane in 0..LANES {
            let at = |v: &[[f32; LANES]; 3]| [v[0][lane], v[1][lane], v[2][lane]];
            let (origin, direction) = (at(&rays.origin), at(&rays.direction));
            if let Some(hit) = self.cast_filtered(origin, direction, rays.limit[lane], opaque) {
                hits.distance[lane] = hit.distance;
                hits.triangle[lane] = hit.triangle;
                (hits.u[lane], hits.v[lane]) = (hit.u, hit.v);
            }
        }
    }

    #[inline(always)]
    fn leaf(&self, node: &Node) -> &[LeafTriangle] {
        &self.triangles[node.first as usize..(node.first + node.kind / 8) as usize]
    }
}

/// A node of the builder's tree; `first` is still the builder's.
fn node(tree: &Bvh2, index: u32) -> Node {
    let source = &tree.nodes[index as usize];
    let kind = match source.prim_count {
        0 => {
            let [a, b] = [0, 1].map(|i| &tree.nodes[source.first_index as usize + i].aabb);
            let apart: [f32; 3] = ((b.min + b.max) - (a.min + a.max)).into();
            let axis = (0..3).fold(0, |best, i| {
                if apart[i].abs() > apart[best].abs() {
                    i
                } else {
                    best
                }
            });
            2 * axis as u32 + u32::from(apart[axis] < 0.0)
        }
        count => 8 * count,
    };
    Node {
        min: source.aabb.min.into(),
        first: source.first_index,
        max: source.aabb.max.into(),
        kind,
    }
}

/// Nodes still to be visited with the distances at which they are entered: an array, and a vector for degenerate trees.
struct Stack {
    shallow: [(u32, f32); 64],
    count: usize,
    deep: Vec<(u32, f32)>,
}

impl Stack {
    fn new() -> Self {
        Self {
            shallow: [(0, 0.0); 64],
            count: 0,
            deep: Vec::new(),
        }
    }

    #[inline(always)]
    fn push(&mut self, entry: (u32, f32)) {
        match self.shallow.get_mut(self.count) {
            Some(slot) => {
                *slot = entry;
                self.count += 1;
            }
            None => self.deep.push(entry),
        }
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<(u32, f32)> {
        if let Some(entry) = self.deep.pop() {
            return Some(entry);
        }
        self.count = self.count.checked_sub(1)?;
        Some(self.shallow[self.count])
    }
}

fn leaf_triangle(t: &obvhs::triangle::Triangle, index: u32, masked: bool) -> LeafTriangle {
    LeafTriangle {
        corner: t.v0.into(),
        edge1: (t.v1 - t.v0).into(),
        edge2: (t.v2 - t.v0).into(),
        index,
        masked,
    }
}

/// One over `component`, kept finite so that no slab test multiplies zero by infinity.
#[inline(always)]
fn reciprocal(component: f32) -> f32 {
    1.0 / if component.abs() < 1e-18 {
        1e-18
    } else {
        component
    }
}

#[inline(always)]
fn lower(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn upper(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Distance at which the ray enters the box, if it does before `limit`.
#[inline(always)]
fn slab_one(node: &Node, origin: [f32; 3], inverse: [f32; 3], limit: f32) -> Option<f32> {
    let (mut enter, mut leave) = (0.0_f32, limit);
    for axis in 0..3 {
        let a = (node.min[axis] - origin[axis]) * inverse[axis];
        let b = (node.max[axis] - origin[axis]) * inverse[axis];
        enter = upper(lower(a, b), enter);
        leave = lower(upper(a, b), leave);
    }
    (enter <= leave).then_some(enter)
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

/// Distance and corner weights of the hit, and a mask of ones if there is one before `limit`.
#[inline(always)]
fn moeller_trumbore(
    t: &LeafTriangle,
    origin: [f32; 3],
    direction: [f32; 3],
    limit: f32,
) -> (f32, f32, f32, u32) {
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
    // A ray in the triangle's plane gives NaN or infinity, and no comparison holds. Masks rather than `&&`: a branch for
    // each lane would keep the compiler from using vectors.
    let hit = mask(u >= 0.0)
        & mask(v >= 0.0)
        & mask(u + v <= 1.0)
        & mask(distance > 1e-5)
        & mask(distance < limit);
    (distance, u, v, hit)
}

#[inline(always)]
fn mask(holds: bool) -> u32 {
    u32::from(holds).wrapping_neg()
}

#[inline(always)]
fn select(mask: u32, yes: f32, no: f32) -> f32 {
    f32::from_bits((yes.to_bits() & mask) | (no.to_bits() & !mask))
}

#[inline(always)]
fn intersect_one(
    triangle: &LeafTriangle,
    origin: [f32; 3],
    direction: [f32; 3],
    best: &mut Hit,
) -> bool {
    let (distance, u, v, hit) = moeller_trumbore(triangle, origin, direction, best.distance);
    if hit != 0 {
        *best = Hit {
            distance,
            triangle: triangle.index,
            u,
            v,
        };
    }
    hit != 0
}

#[cfg(test)]
mod tests {
    use super::dispatch::Vectors;
    use super::*;
    use proptest::prelude::*;

    fn coordinate() -> impl Strategy<Value = f32> {
        -10.0_f32..10.0
    }

    fn triangle() -> impl Strategy<Value = [[f32; 3]; 3]> {
        prop::array::uniform3(prop::array::uniform3(coordinate()))
    }

    fn brute_force(soup: &[[[f32; 3]; 3]], origin: [f32; 3], direction: [f32; 3]) -> Option<f32> {
        let mut best = Hit {
            distance: 100.0,
            triangle: MISS,
            u: 0.0,
            v: 0.0,
        };
        for (i, [a, b, c]) in soup.iter().enumerate() {
            let t = obvhs::triangle::Triangle {
                v0: (*a).into(),
                v1: (*b).into(),
                v2: (*c).into(),
            };
            intersect_one(
                &leaf_triangle(&t, i as u32, false),
                origin,
                direction,
                &mut best,
            );
        }
        (best.triangle != MISS).then_some(best.distance)
    }

    proptest! {
        #[test]
        fn the_tree_finds_what_a_loop_over_all_triangles_finds(
            soup in prop::collection::vec(triangle(), 1..60),
            rays in prop::collection::vec((prop::array::uniform3(coordinate()), prop::array::uniform3(coordinate())), LANES),
        ) {
            let tree = TriangleBvh::new(soup.iter().copied());
            let mut packet = RayPacket::idle();
            for (lane, (origin, direction)) in rays.iter().enumerate() {
                packet.set(lane, *origin, *direction, 100.0);
            }
            let together = tree.cast_packet(&packet);
            for (lane, (origin, direction)) in rays.iter().enumerate() {
                let alone = tree.cast(*origin, *direction, 100.0);
                prop_assert_eq!(alone.map(|h| h.distance), brute_force(&soup, *origin, *direction));
                let from_packet = (together.triangle[lane] != MISS).then_some(together.distance[lane]);
                prop_assert_eq!(alone.map(|h| h.distance), from_packet);
            }
        }

        #[test]
        fn every_instruction_set_gives_the_same_bits(
            soup in prop::collection::vec(triangle(), 1..200),
            rays in prop::collection::vec((prop::array::uniform3(coordinate()), prop::array::uniform3(coordinate())), LANES),
        ) {
            let tree = TriangleBvh::masked(soup.iter().copied(), |i| i % 3 == 0);
            let mut packet = RayPacket::idle();
            for (lane, (origin, direction)) in rays.iter().enumerate() {
                packet.set(lane, *origin, *direction, 100.0);
            }
            let bits = |h: &PacketHits| (h.distance.map(f32::to_bits), h.triangle, h.u.map(f32::to_bits), h.v.map(f32::to_bits));
            let mut seen = Vec::new();
            for vectors in Vectors::available() {
                let mut hits = PacketHits::none(&packet);
                vectors.run(Cast { tree: &tree, rays: &packet, opaque: &|hit: &Hit| hit.u > 0.3, hits: &mut hits });
                seen.push(bits(&hits));
            }
            prop_assert!(seen.windows(2).all(|w| w[0] == w[1]), "{:?}", Vectors::available());
        }
    }

    #[test]
    fn an_empty_tree_is_missed() {
        let tree = TriangleBvh::new(std::iter::empty());
        assert_eq!(tree.cast([0.0; 3], [1.0, 0.0, 0.0], 10.0), None);
        assert_eq!(tree.cast_packet(&RayPacket::idle()).triangle, [MISS; LANES]);
    }

    #[test]
    fn axis_parallel_rays_hit_a_floor() {
        let floor = [[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]];
        let tree = TriangleBvh::new(floor.into_iter());
        let hit = tree.cast([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], 10.0).unwrap();
        assert_eq!(hit.distance, 2.0);
        assert_eq!(tree.cast([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], 1.9), None);
        assert_eq!(tree.cast([0.0, 0.0, 2.0], [0.0, 0.0, 1.0], 10.0), None);
    }
}
