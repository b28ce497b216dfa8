//! Sixteen rays at once.
//!
//! Every step is a loop over sixteen lanes of plain arrays without a branch. The compiler makes it
//! one to four vector instructions of the machine that it compiles for. No operation is fused or
//! approximate, so each instruction set gives the same bits.

use super::branchless::{lower, mask, select, upper};
use super::dispatch::{Kernel, widest};
use super::node::{Children, Node, reciprocal};
use super::tree::TriangleBvh;
use super::triangle::{Hit, LeafTriangle, MISS, Meeting, moeller_trumbore};

/// Rays in a packet.
// One vector of AVX-512, two of AVX2, four of the baseline.
pub const LANES: usize = 16;

/// Depth of the deepest tree that the stack of the packet traversal has room for: each level leaves
/// one sibling behind.
pub(super) const PACKET_STACK: usize = 192;

/// A number for each ray.
pub type Lane = [f32; LANES];

/// Sixteen rays. Directions need not have unit length: distances are in lengths of them.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct RayPacket {
    /// Origins: x, y, z.
    pub origin: [Lane; 3],
    /// Directions: x, y, z.
    pub direction: [Lane; 3],
    /// Largest distance of a hit; a lane with a negative one is idle.
    pub limit: Lane,
}

impl RayPacket {
    /// Sixteen idle rays.
    pub const fn idle() -> Self {
        Self {
            origin: [[0.0; LANES]; 3],
            // Anything but zero, so that idle lanes compute with ordinary numbers.
            direction: [[1.0; LANES]; 3],
            limit: [-1.0; LANES],
        }
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
    /// Numbers of the movers that were hit; [`MISS`] for standing triangles.
    pub mover: [u32; LANES],
}

impl PacketHits {
    /// The hit of one ray; its triangle is [`MISS`] if it hit nothing.
    #[inline]
    pub fn hit(&self, lane: usize) -> Hit {
        Hit {
            distance: self.distance[lane],
            triangle: self.triangle[lane],
            u: self.u[lane],
            v: self.v[lane],
        }
    }

    /// No hits, of rays without length.
    pub(super) const NONE: Self = Self {
        distance: [0.0; LANES],
        triangle: [MISS; LANES],
        u: [0.0; LANES],
        v: [0.0; LANES],
        mover: [MISS; LANES],
    };

    /// No hits of `rays` yet.
    #[inline(always)]
    pub(super) fn none(rays: &RayPacket) -> Self {
        Self {
            distance: rays.limit,
            ..Self::NONE
        }
    }
}

impl TriangleBvh {
    /// The first hit of each of sixteen rays. Fastest when the rays are close to each other.
    pub fn cast_packet(&self, rays: &RayPacket) -> PacketHits {
        self.cast_packet_filtered(rays, |_| true)
    }

    /// The same; hits of masked triangles count only where `opaque` is true.
    pub(crate) fn cast_packet_filtered(
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

    /// Finds out which of sixteen rays hit anything; hits of masked triangles count only where
    /// `opaque` is true. Distances and places of the hits mean nothing.
    #[inline(always)]
    pub(crate) fn any_hits(&self, rays: &RayPacket, opaque: impl Fn(&Hit) -> bool) -> PacketHits {
        let mut hits = PacketHits::none(rays);
        if self.depth >= PACKET_STACK {
            self.cast_each(rays, &opaque, &mut hits);
        } else {
            widest(AnyHits {
                tree: self,
                rays,
                opaque: &opaque,
                hits: &mut hits,
            });
        }
        hits
    }

    /// Casts ray by ray: for trees deeper than the packet's stack, which only degenerate scenes
    /// have.
    pub(super) fn cast_each(
        &self,
        rays: &RayPacket,
        opaque: &impl Fn(&Hit) -> bool,
        hits: &mut PacketHits,
    ) {
        for lane in 0..LANES {
            let (origin, direction) = (of_lane(&rays.origin, lane), of_lane(&rays.direction, lane));
            if let Some(hit) = self.cast_filtered(origin, direction, rays.limit[lane], opaque) {
                hits.distance[lane] = hit.distance;
                hits.triangle[lane] = hit.triangle;
                (hits.u[lane], hits.v[lane]) = (hit.u, hit.v);
            }
        }
    }
}

/// Sixteen rays prepared for a traversal.
pub(super) struct Traversal<'a> {
    rays: &'a RayPacket,
    /// One over the directions.
    inverse: [Lane; 3],
    /// For each axis 1 if most rays run against it, else 0.
    against: [u32; 3],
}

impl<'a> Traversal<'a> {
    #[inline(always)]
    pub(super) fn new(rays: &'a RayPacket) -> Self {
        let mut against = [0; 3];
        for (against, directions) in against.iter_mut().zip(&rays.direction) {
            let mut backward = 0;
            for &along in directions {
                backward += u32::from(along < 0.0);
            }
            // The order of visits matters for speed only, so the majority decides.
            *against = u32::from(backward > LANES as u32 / 2);
        }
        Self {
            rays,
            inverse: invert(&rays.direction),
            against,
        }
    }
}

/// One over the directions.
#[inline(always)]
pub(super) fn invert(directions: &[Lane; 3]) -> [Lane; 3] {
    // Loops instead of `map`, which is not inlined and therefore not compiled for the chosen
    // instructions.
    let mut inverse = [[0.0; LANES]; 3];
    for axis in 0..3 {
        for (inverse, &along) in inverse[axis].iter_mut().zip(&directions[axis]) {
            *inverse = reciprocal(along);
        }
    }
    inverse
}

/// Whether any ray enters the box of the node before its hit so far.
#[inline(always)]
pub(super) fn enters(node: &Node, origin: &[Lane; 3], inverse: &[Lane; 3], limit: &Lane) -> bool {
    let mut inside = [0_u32; LANES];
    for lane in 0..LANES {
        let (mut enter, mut leave) = (0.0_f32, limit[lane]);
        for axis in 0..3 {
            let a = (node.min[axis] - origin[axis][lane]) * inverse[axis][lane];
            let b = (node.max[axis] - origin[axis][lane]) * inverse[axis][lane];
            enter = upper(lower(a, b), enter);
            leave = lower(upper(a, b), leave);
        }
        inside[lane] = mask(enter <= leave);
    }
    inside.iter().fold(0, |any, lane| any | lane) != 0
}

/// The work in a leaf. A trait instead of a closure, since only `#[inline(always)]` functions are
/// compiled for the chosen instructions.
pub(super) trait Visit {
    fn leaf(&mut self, node: &Node, hits: &mut PacketHits);
}

/// Visits the leaves that the rays enter, near ones first. A box is tested when its turn comes, not
/// when its parent is opened: by then nearer hits may have shortened the rays.
#[inline(always)]
pub(super) fn traverse(
    nodes: &[Node],
    traversal: &Traversal<'_>,
    hits: &mut PacketHits,
    mut visit: impl Visit,
) {
    if nodes.is_empty() {
        return;
    }
    // Node 0 is on it: the root.
    let mut stack = [0_u32; PACKET_STACK + 2];
    let mut top = 1;
    while top > 0 {
        top -= 1;
        let node = &nodes[stack[top] as usize];
        if !enters(
            node,
            &traversal.rays.origin,
            &traversal.inverse,
            &hits.distance,
        ) {
            continue;
        }
        if node.is_leaf() {
            visit.leaf(node, hits);
        } else {
            let Children { near, far } = node.ordered(&traversal.against);
            (stack[top], stack[top + 1]) = (far, near);
            top += 2;
        }
    }
}

/// Finds the first hits of the rays in a tree no deeper than [`PACKET_STACK`].
pub(super) struct Cast<'a, F> {
    pub(super) tree: &'a TriangleBvh,
    pub(super) rays: &'a RayPacket,
    pub(super) opaque: &'a F,
    pub(super) hits: &'a mut PacketHits,
}

impl<F: Fn(&Hit) -> bool> Kernel for Cast<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            tree,
            rays,
            opaque,
            hits,
        } = self;
        traverse(
            &tree.nodes,
            &Traversal::new(rays),
            hits,
            Triangles { tree, rays, opaque },
        );
    }
}

/// Finds any hits of the rays in a tree no deeper than [`PACKET_STACK`].
struct AnyHits<'a, F> {
    tree: &'a TriangleBvh,
    rays: &'a RayPacket,
    opaque: &'a F,
    hits: &'a mut PacketHits,
}

impl<F: Fn(&Hit) -> bool> Kernel for AnyHits<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            tree,
            rays,
            opaque,
            hits,
        } = self;
        let triangles = Triangles { tree, rays, opaque };
        traverse(
            &tree.nodes,
            &Traversal::new(rays),
            hits,
            Obstacles(triangles),
        );
    }
}

/// Intersects the triangles of leaves, and ends rays that hit any.
struct Obstacles<'a, F>(Triangles<'a, F>);

impl<F: Fn(&Hit) -> bool> Visit for Obstacles<'_, F> {
    #[inline(always)]
    fn leaf(&mut self, node: &Node, hits: &mut PacketHits) {
        self.0.leaf(node, hits);
        for lane in 0..LANES {
            // An idle lane enters no other node.
            let hit = mask(hits.triangle[lane] != MISS);
            hits.distance[lane] = select(hit, -1.0, hits.distance[lane]);
        }
    }
}

/// Intersects the triangles of leaves.
pub(super) struct Triangles<'a, F> {
    pub(super) tree: &'a TriangleBvh,
    pub(super) rays: &'a RayPacket,
    pub(super) opaque: &'a F,
}

impl<F: Fn(&Hit) -> bool> Visit for Triangles<'_, F> {
    #[inline(always)]
    fn leaf(&mut self, node: &Node, hits: &mut PacketHits) {
        for triangle in self.tree.leaf(node) {
            let met = Anywhere {
                triangle: *triangle,
                rays: self.rays,
            };
            if triangle.masked {
                intersect_masked(triangle.index, &met, hits, self.opaque);
            } else {
                intersect(triangle.index, &met, hits);
            }
        }
    }
}

/// How the rays of a packet meet a triangle.
pub(super) trait Meet {
    fn meet(&self, lane: usize, limit: f32) -> Meeting;
}

/// A triangle and rays from anywhere.
struct Anywhere<'a> {
    triangle: LeafTriangle,
    rays: &'a RayPacket,
}

impl Meet for Anywhere<'_> {
    #[inline(always)]
    fn meet(&self, lane: usize, limit: f32) -> Meeting {
        moeller_trumbore(
            &self.triangle,
            of_lane(&self.rays.origin, lane),
            of_lane(&self.rays.direction, lane),
            limit,
        )
    }
}

#[inline(always)]
pub(super) fn intersect(index: u32, met: &impl Meet, hits: &mut PacketHits) {
    let met = Meetings::of(met, hits);
    if met.any() {
        met.write(index, hits);
    }
}

/// How sixteen rays meet a triangle.
struct Meetings {
    distance: Lane,
    u: Lane,
    v: Lane,
    /// Ones in every bit of the lanes that hit it before the limit.
    inside: [u32; LANES],
}

impl Meetings {
    #[inline(always)]
    fn of(met: &impl Meet, hits: &PacketHits) -> Self {
        let mut all = Self {
            distance: [0.0; LANES],
            u: [0.0; LANES],
            v: [0.0; LANES],
            inside: [0; LANES],
        };
        for lane in 0..LANES {
            let met = met.meet(lane, hits.distance[lane]);
            (all.distance[lane], all.u[lane], all.v[lane]) = (met.distance, met.u, met.v);
            all.inside[lane] = met.hit;
        }
        all
    }

    /// Whether any ray hits. Most triangles are missed by all: that test takes one instruction,
    /// writing takes many, and masked writes are slow on some machines.
    #[inline(always)]
    fn any(&self) -> bool {
        self.inside.iter().fold(0, |any, lane| any | lane) != 0
    }

    /// Writes the hits, all lanes at once: reading a vector after single lanes of it were written
    /// stalls.
    #[inline(always)]
    fn write(&self, index: u32, hits: &mut PacketHits) {
        for lane in 0..LANES {
            let hit = self.inside[lane];
            hits.distance[lane] = select(hit, self.distance[lane], hits.distance[lane]);
            hits.triangle[lane] = (index & hit) | (hits.triangle[lane] & !hit);
            hits.u[lane] = select(hit, self.u[lane], hits.u[lane]);
            hits.v[lane] = select(hit, self.v[lane], hits.v[lane]);
        }
    }
}

/// As [`intersect`], but tests each hit for a hole.
#[inline(always)]
pub(super) fn intersect_masked(
    index: u32,
    met: &impl Meet,
    hits: &mut PacketHits,
    opaque: &impl Fn(&Hit) -> bool,
) {
    let mut met = Meetings::of(met, hits);
    if !met.any() {
        return;
    }
    let mut left = bits(&met.inside);
    let mut kept = 0;
    while left != 0 {
        // Below sixteen anyway; the remainder spares the compiler a test of each index.
        let lane = left.trailing_zeros() as usize % LANES;
        left &= left - 1;
        let hit = Hit {
            distance: met.distance[lane],
            triangle: index,
            u: met.u[lane],
            v: met.v[lane],
        };
        kept |= u32::from(opaque(&hit)) << lane;
    }
    for (lane, inside) in met.inside.iter_mut().enumerate() {
        *inside = mask(kept & 1 << lane != 0);
    }
    met.write(index, hits);
}

/// The vector of one ray.
#[inline(always)]
pub(super) fn of_lane(vectors: &[Lane; 3], lane: usize) -> [f32; 3] {
    [vectors[0][lane], vectors[1][lane], vectors[2][lane]]
}

/// A bit for each lane whose mask is set.
#[inline(always)]
fn bits(masks: &[u32; LANES]) -> u32 {
    let mut bits = [0; LANES];
    for lane in 0..LANES {
        bits[lane] = masks[lane] & 1 << lane;
    }
    bits.iter().fold(0, |all, bit| all | bit)
}
