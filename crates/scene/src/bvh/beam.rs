//! Blocks of rays from one point, as a camera casts them.
//!
//! Neighbouring packets of an image traverse nearly the same nodes of the tree. A beam is the
//! four-sided cone around all rays of a block. One test of it, six products for each of its planes,
//! decides whether any ray can enter a node; single packets are tested in leaves only. After
//! Reshetov, Soupikov and Hurley, *Multi-Level Ray Tracing Algorithm*, 2005.

use super::branchless::mask;
use super::dispatch::{Kernel, widest};
use super::node::{Children, Node};
use super::packet::{
    LANES, Lane, Meet, PACKET_STACK, PacketHits, RayPacket, Triangles, Visit, enters, intersect,
    intersect_masked, invert, of_lane,
};
use super::tree::TriangleBvh;
use super::triangle::{FromPoint, Hit, Meeting};

/// Sides of a beam.
const SIDES: usize = 4;
/// Margin of a beam around its rays, so that rounding loses no hit, metres. Enough for views of up
/// to 165 degrees.
const SLACK_M: f32 = 1e-3;
/// The same for each metre of the scene's largest coordinate.
const RELATIVE_SLACK: f32 = 1e-6;

/// Half-spaces that contain all rays of a block: those of x with `normal · x >= offset`.
#[derive(Debug, Clone, Copy)]
pub struct Beam {
    /// The parts of the sides' normals above zero and below. With them the corner of a box that
    /// lies farthest inside needs no choice.
    above: [[f32; SIDES]; 3],
    below: [[f32; SIDES]; 3],
    offset: [f32; SIDES],
    far: FarEnd,
    /// Largest coordinate of the origin.
    extent: f32,
}

/// The plane behind the ends of all rays.
#[derive(Debug, Clone, Copy)]
struct FarEnd {
    above: [f32; 3],
    below: [f32; 3],
    offset: f32,
    /// Offset for rays of no length, and its decrease for each length of a direction.
    near: f32,
    stride: f32,
}

/// The parts of a number above zero and below.
#[inline(always)]
fn parts(along: f64) -> [f32; 2] {
    let along = along as f32;
    if along > 0.0 {
        [along, 0.0]
    } else {
        [0.0, along]
    }
}

impl Beam {
    /// The beam of rays from `origin` whose directions lie between four `corners`, in order around
    /// it.
    #[inline(always)]
    pub fn new(origin: [f32; 3], corners: &[[f32; 3]; 4]) -> Self {
        let mut beam = Self {
            above: [[0.0; SIDES]; 3],
            below: [[0.0; SIDES]; 3],
            offset: [f32::NEG_INFINITY; SIDES],
            far: FarEnd {
                above: [0.0; 3],
                below: [0.0; 3],
                offset: 0.0,
                near: 0.0,
                stride: 0.0,
            },
            extent: origin.iter().fold(0.0, |most, c| c.abs().max(most)),
        };
        let mut wide = [[0.0_f64; 3]; 4];
        let mut middle = [0.0; 3];
        for (wide, corner) in wide.iter_mut().zip(corners) {
            for axis in 0..3 {
                wide[axis] = f64::from(corner[axis]);
                middle[axis] += 0.25 * wide[axis];
            }
        }
        // In double precision: the corners are close to each other, and in single precision only
        // noise would be left of their differences.
        for side in 0..4 {
            let normal = cross(wide[side], wide[(side + 1) % 4]);
            // Corners may run either way round; the middle is inside.
            let inward = if dot(normal, middle) < 0.0 { -1.0 } else { 1.0 };
            beam.set(
                side,
                scaled(normal, inward / dot(normal, normal).sqrt()),
                origin,
            );
        }
        let length = dot(middle, middle).sqrt();
        // Along the middle, a ray of t lengths of its direction gets t times `stride` far at most.
        let back = scaled(middle, -1.0 / length);
        for (axis, along) in back.into_iter().enumerate() {
            [beam.far.above[axis], beam.far.below[axis]] = parts(along);
        }
        beam.far.near = offset(back, origin);
        beam.far.offset = beam.far.near;
        for corner in wide {
            let stride = (dot(corner, middle) / length) as f32;
            beam.far.stride = beam.far.stride.max(stride);
        }
        beam
    }

    #[inline(always)]
    fn set(&mut self, side: usize, normal: [f64; 3], origin: [f32; 3]) {
        for (axis, along) in normal.into_iter().enumerate() {
            [self.above[axis][side], self.below[axis][side]] = parts(along);
        }
        self.offset[side] = offset(normal, origin);
    }

    /// Widens the beam to allow for rounding in the scene under this node.
    #[inline(always)]
    fn widen(&mut self, root: &Node) {
        let mut extent = self.extent;
        for corner in root.min.iter().chain(&root.max) {
            extent = extent.max(corner.abs());
        }
        // Rounding grows with the largest coordinate, and so does the slack.
        let slack = SLACK_M + RELATIVE_SLACK * extent;
        for offset in &mut self.offset {
            *offset -= slack;
        }
        self.far.near -= slack;
        self.far.offset -= slack;
    }

    /// Moves the far end to where the longest ray ends.
    #[inline(always)]
    fn end<const K: usize>(&mut self, hits: &[PacketHits; K]) {
        let mut furthest = [0.0_f32; LANES];
        for packet in hits {
            for (furthest, &distance) in furthest.iter_mut().zip(&packet.distance) {
                *furthest = if distance > *furthest {
                    distance
                } else {
                    *furthest
                };
            }
        }
        // Across the lanes only once: all that comes before is lane by lane, in vector
        // instructions.
        let furthest = furthest
            .iter()
            .fold(0.0_f32, |most, &d| if d > most { d } else { most });
        self.far.offset = self.far.near - furthest * self.far.stride;
    }

    /// Whether any ray may enter the node's box.
    #[inline(always)]
    fn enters(&self, node: &Node) -> bool {
        let mut outside = [0_u32; SIDES];
        for (side, outside) in outside.iter_mut().enumerate() {
            // How far the box reaches inside. For a broken beam this is NaN, and no node is left
            // out.
            let reach = self.above[0][side] * node.max[0]
                + self.below[0][side] * node.min[0]
                + (self.above[1][side] * node.max[1] + self.below[1][side] * node.min[1])
                + (self.above[2][side] * node.max[2] + self.below[2][side] * node.min[2]);
            *outside = mask(reach < self.offset[side]);
        }
        outside.iter().fold(0, |any, side| any | side) == 0 && self.far.enters(node)
    }
}

impl FarEnd {
    #[inline(always)]
    fn enters(&self, node: &Node) -> bool {
        let mut reach = 0.0;
        for axis in 0..3 {
            reach += self.above[axis] * node.max[axis] + self.below[axis] * node.min[axis];
        }
        // Written so that NaN enters.
        let outside = reach < self.offset;
        !outside
    }
}

impl TriangleBvh {
    /// The first hit of each ray of a block of packets. All rays lie within `beam` and begin at its
    /// origin. Hits of masked triangles count only where `opaque` is true.
    ///
    /// Where several triangles are hit at one distance, the triangle may differ from that of
    /// [`cast_packet`](Self::cast_packet).
    #[inline(always)]
    pub(crate) fn cast_block<const K: usize>(
        &self,
        beam: &Beam,
        rays: &[RayPacket; K],
        opaque: impl Fn(&Hit) -> bool,
    ) -> [PacketHits; K] {
        let opaque = &opaque;
        let tree = self;
        self.cast_beam(beam, rays, opaque, EachPacket { tree, rays, opaque })
    }

    /// The same, faster, with distances and weights that differ by rounding. Idle rays, too, begin
    /// at the origin.
    #[inline(always)]
    pub(crate) fn cast_block_from_point<const K: usize>(
        &self,
        beam: &Beam,
        rays: &[RayPacket; K],
        opaque: impl Fn(&Hit) -> bool,
    ) -> [PacketHits; K] {
        let (opaque, origin) = (&opaque, of_lane(&rays[0].origin, 0));
        let leaves = FromOrigin {
            tree: self,
            origin,
            rays,
            opaque,
        };
        self.cast_beam(beam, rays, opaque, leaves)
    }

    #[inline(always)]
    fn cast_beam<const K: usize>(
        &self,
        beam: &Beam,
        rays: &[RayPacket; K],
        opaque: &impl Fn(&Hit) -> bool,
        leaves: impl VisitBlock<K>,
    ) -> [PacketHits; K] {
        let mut hits = [PacketHits::NONE; K];
        for (hits, rays) in hits.iter_mut().zip(rays) {
            hits.distance = rays.limit;
            if self.depth >= PACKET_STACK {
                self.cast_each(rays, opaque, hits);
            }
        }
        if self.depth < PACKET_STACK {
            widest(CastBeam {
                tree: self,
                beam,
                rays,
                leaves,
                hits: &mut hits,
            });
        }
        hits
    }
}

/// Finds the first hits of the rays of a beam in a tree no deeper than [`PACKET_STACK`].
struct CastBeam<'a, L, const K: usize> {
    tree: &'a TriangleBvh,
    beam: &'a Beam,
    rays: &'a [RayPacket; K],
    leaves: L,
    hits: &'a mut [PacketHits; K],
}

/// What is done in a leaf of which `entered` tells which packets enter it.
trait VisitBlock<const K: usize> {
    fn leaf(&self, node: &Node, entered: &[bool; K], hits: &mut [PacketHits; K]);
}

/// Packet by packet, each with the test for rays from anywhere.
struct EachPacket<'a, F, const K: usize> {
    tree: &'a TriangleBvh,
    rays: &'a [RayPacket; K],
    opaque: &'a F,
}

impl<F: Fn(&Hit) -> bool, const K: usize> VisitBlock<K> for EachPacket<'_, F, K> {
    #[inline(always)]
    fn leaf(&self, node: &Node, entered: &[bool; K], hits: &mut [PacketHits; K]) {
        let (tree, opaque) = (self.tree, self.opaque);
        for ((rays, hits), entered) in self.rays.iter().zip(hits).zip(entered) {
            if *entered {
                Triangles { tree, rays, opaque }.leaf(node, hits);
            }
        }
    }
}

/// Triangle by triangle: what the rays' common origin decides is computed once.
struct FromOrigin<'a, F, const K: usize> {
    tree: &'a TriangleBvh,
    origin: [f32; 3],
    rays: &'a [RayPacket; K],
    opaque: &'a F,
}

impl<F: Fn(&Hit) -> bool, const K: usize> VisitBlock<K> for FromOrigin<'_, F, K> {
    #[inline(always)]
    fn leaf(&self, node: &Node, entered: &[bool; K], hits: &mut [PacketHits; K]) {
        for triangle in self.tree.leaf(node) {
            let (index, seen) = (triangle.index, FromPoint::new(triangle, self.origin));
            for ((rays, hits), entered) in self.rays.iter().zip(&mut *hits).zip(entered) {
                if !*entered {
                    continue;
                }
                let met = Along {
                    seen,
                    direction: &rays.direction,
                };
                if triangle.masked {
                    intersect_masked(index, &met, hits, self.opaque);
                } else {
                    intersect(index, &met, hits);
                }
            }
        }
    }
}

/// A triangle and rays from the point that it is seen from.
struct Along<'a> {
    seen: FromPoint,
    direction: &'a [Lane; 3],
}

impl Meet for Along<'_> {
    #[inline(always)]
    fn meet(&self, lane: usize, limit: f32) -> Meeting {
        self.seen.meet(of_lane(self.direction, lane), limit)
    }
}

impl<L: VisitBlock<K>, const K: usize> Kernel for CastBeam<'_, L, K> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            tree,
            beam,
            rays,
            leaves,
            hits,
        } = self;
        let Some(root) = tree.nodes.first() else {
            return;
        };
        let mut beam = *beam;
        beam.widen(root);
        beam.end(hits);
        let mut inverses = [[[0.0; LANES]; 3]; K];
        for (inverse, rays) in inverses.iter_mut().zip(rays) {
            *inverse = invert(&rays.direction);
        }
        let mut against = [0; 3];
        // One ray stands for all, as they run nearly alike. The order of visits matters for speed
        // only.
        for (against, along) in against.iter_mut().zip(&rays[0].direction) {
            *against = u32::from(along[0] < 0.0);
        }
        let mut stack = [0_u32; PACKET_STACK + 2];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let node = &tree.nodes[stack[top] as usize];
            if !beam.enters(node) {
                continue;
            }
            if !node.is_leaf() {
                let Children { near, far } = node.ordered(&against);
                (stack[top], stack[top + 1]) = (far, near);
                top += 2;
                continue;
            }
            let mut entered = [false; K];
            for i in 0..K {
                entered[i] = enters(node, &rays[i].origin, &inverses[i], &hits[i].distance);
            }
            // Only triangles shorten rays, and with them the beam.
            if entered.contains(&true) {
                leaves.leaf(node, &entered, hits);
                beam.end(hits);
            }
        }
    }
}

/// Offset of the plane through a point.
#[inline(always)]
fn offset(normal: [f64; 3], point: [f32; 3]) -> f32 {
    let point = [point[0].into(), point[1].into(), point[2].into()];
    dot(normal, point) as f32
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
fn scaled(a: [f64; 3], by: f64) -> [f64; 3] {
    [a[0] * by, a[1] * by, a[2] * by]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::MISS;
    use nalgebra::{UnitQuaternion, Vector3};
    use proptest::prelude::*;

    const SIDE: usize = 8;

    /// The rays of a block of 8 x 8 pixels, as tiles of 4 x 4, in the direction of a rotated x
    /// axis; `angle` radians a pixel.
    fn block(origin: [f32; 3], turn: [f64; 3], angle: f64) -> ([RayPacket; 4], Beam) {
        let turn = UnitQuaternion::from_euler_angles(turn[0], turn[1], turn[2]);
        let along = |u: usize, v: usize| {
            let (u, v) = (u as f64 - 3.5, v as f64 - 3.5);
            let direction = turn * Vector3::new(1.0, -u * angle, -v * angle);
            [direction.x as f32, direction.y as f32, direction.z as f32]
        };
        let packets = std::array::from_fn(|i| {
            let mut packet = RayPacket::idle();
            for lane in 0..LANES {
                let (u, v) = (4 * (i % 2) + lane % 4, 4 * (i / 2) + lane / 4);
                packet.set(lane, origin, along(u, v), 300.0);
            }
            packet
        });
        let far = SIDE - 1;
        (
            packets,
            Beam::new(
                origin,
                &[along(0, 0), along(far, 0), along(far, far), along(0, far)],
            ),
        )
    }

    fn point(size: f32) -> impl Strategy<Value = [f32; 3]> {
        prop::array::uniform3(-size..size)
    }

    proptest! {
        #[test]
        fn a_block_hits_what_its_packets_hit_one_by_one(
            soup in prop::collection::vec((point(30.0), prop::array::uniform3(point(4.0))), 1..120),
            origin in point(10.0),
            turn in prop::array::uniform3(-3.2_f64..3.2),
            angle in prop_oneof![Just(1e-5), Just(0.003), 0.001_f64..0.2],
            away in prop_oneof![Just(0.0_f32), Just(900.0), Just(-40_000.0)],
        ) {
            let moved = |p: [f32; 3]| p.map(|c| c + away);
            let corner = |at: &[f32; 3], c: [f32; 3]| moved([0, 1, 2].map(|i| at[i] + c[i]));
            let corners = soup.iter().map(|(at, t)| t.map(|c| corner(at, c)));
            let tree = TriangleBvh::masked(corners, |i| i % 3 == 0);
            let opaque = |hit: &Hit| hit.u > 0.3;
            let (packets, beam) = block(moved(origin), turn, angle);
            let together = tree.cast_block(&beam, &packets, opaque);
            let from_point = tree.cast_block_from_point(&beam, &packets, opaque);
            let mut near_edges = 0;
            for (i, packet) in packets.iter().enumerate() {
                let alone = tree.cast_packet_filtered(packet, opaque);
                prop_assert_eq!(alone.distance, together[i].distance);
                let blocked = tree.any_hits(packet, opaque);
                for lane in 0..LANES {
                    let hit = alone.triangle[lane] != MISS;
                    prop_assert_eq!(hit, blocked.triangle[lane] != MISS);
                    // Rounding may move a ray over an edge, and far from the origin a little more.
                    let (a, b) = (alone.distance[lane], from_point[i].distance[lane]);
                    let coarse = 1e-3 * a + 1e-5 * away.abs();
                    near_edges += u32::from((a - b).abs() > coarse);
                    let is_same = alone.triangle[lane] == from_point[i].triangle[lane];
                    if hit && is_same && away == 0.0 {
                        prop_assert!((alone.u[lane] - from_point[i].u[lane]).abs() < 0.05);
                        prop_assert!((alone.v[lane] - from_point[i].v[lane]).abs() < 0.05);
                    }
                }
            }
            prop_assert!(near_edges <= 4, "{} of 64 rays differ", near_edges);
        }
    }

    #[test]
    fn broken_beams_lose_nothing() {
        let tree = TriangleBvh::new(std::iter::once([
            [5.0, -9.0, -9.0],
            [5.0, 9.0, -9.0],
            [5.0, 0.0, 9.0],
        ]));
        let (packets, _) = block([0.0; 3], [0.0; 3], 0.001);
        for corners in [[[0.0; 3]; 4], [[f32::NAN; 3]; 4], [[1.0, 0.0, 0.0]; 4]] {
            let hits = tree.cast_block(&Beam::new([0.0; 3], &corners), &packets, |_| true);
            assert!(
                hits.iter().all(|packet| packet.triangle == [0; LANES]),
                "{corners:?}"
            );
        }
    }

    #[test]
    fn an_empty_tree_is_missed() {
        let (packets, beam) = block([0.0; 3], [0.0; 3], 0.01);
        let hits = TriangleBvh::new(std::iter::empty()).cast_block(&beam, &packets, |_| true);
        assert!(
            hits.iter()
                .all(|packet| packet.triangle == [super::super::triangle::MISS; LANES])
        );
    }
}
