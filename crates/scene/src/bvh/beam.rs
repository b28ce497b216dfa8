//! Blocks of rays from one point, as a camera casts them.
//!
//! Neighbouring packets of an image traverse nearly the same nodes of the tree. A beam is the
//! four-sided cone around all rays of a block. One test of it, six products for each of its planes,
//! decides whether any ray can enter a node; single packets are tested in leaves only. After
//! Reshetov, Soupikov and Hurley, *Multi-Level Ray Tracing Algorithm*, 2005.

use super::branchless::mask;
use super::dispatch::{Kernel, widest};
use super::node::{Children, Node};
use super::packet::{LANES, PACKET_STACK, PacketHits, RayPacket, Triangles, Visit, enters, invert};
use super::tree::TriangleBvh;
use super::triangle::Hit;

/// Planes of a beam: four sides and the far end. The others contain everything.
const PLANES: usize = 8;
/// Index of the far end.
const FAR: usize = 4;
/// Margin of a beam around its rays, so that rounding loses no hit, metres. Enough for views of up
/// to 165 degrees.
const SLACK_M: f32 = 1e-3;
/// The same for each metre of the scene's largest coordinate.
const RELATIVE_SLACK: f32 = 1e-6;

/// Half-spaces that contain all rays of a block: those of x with `normal · x >= offset`.
#[derive(Debug, Clone, Copy)]
pub struct Beam {
    /// The parts of the normals above zero and below. With them the corner of a box that lies
    /// farthest inside needs no choice.
    above: [[f32; PLANES]; 3],
    below: [[f32; PLANES]; 3],
    offset: [f32; PLANES],
    /// Offset of the far end for rays of no length, and its decrease for each length of a
    /// direction.
    near: f32,
    stride: f32,
    /// Largest coordinate of the origin.
    extent: f32,
}

impl Beam {
    /// The beam of rays from `origin` whose directions lie between four `corners`, in order around
    /// it.
    #[inline(always)]
    pub fn new(origin: [f32; 3], corners: &[[f32; 3]; 4]) -> Self {
        let mut beam = Self {
            above: [[0.0; PLANES]; 3],
            below: [[0.0; PLANES]; 3],
            offset: [f32::NEG_INFINITY; PLANES],
            near: 0.0,
            stride: 0.0,
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
        beam.set(FAR, scaled(middle, -1.0 / length), origin);
        beam.near = beam.offset[FAR];
        for corner in wide {
            beam.stride = beam.stride.max((dot(corner, middle) / length) as f32);
        }
        beam
    }

    #[inline(always)]
    fn set(&mut self, plane: usize, normal: [f64; 3], origin: [f32; 3]) {
        for (axis, along) in normal.into_iter().enumerate() {
            let along = along as f32;
            self.above[axis][plane] = if along > 0.0 { along } else { 0.0 };
            self.below[axis][plane] = if along > 0.0 { 0.0 } else { along };
        }
        self.offset[plane] = dot(
            normal,
            [origin[0].into(), origin[1].into(), origin[2].into()],
        ) as f32;
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
        self.near -= slack;
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
        self.offset[FAR] = self.near - furthest * self.stride;
    }

    /// Whether any ray may enter the node's box.
    #[inline(always)]
    fn enters(&self, node: &Node) -> bool {
        let mut outside = [0_u32; PLANES];
        for (plane, outside) in outside.iter_mut().enumerate() {
            // How far the box reaches inside. For a broken beam this is NaN, and no node is left
            // out.
            let reach = self.above[0][plane] * node.max[0]
                + self.below[0][plane] * node.min[0]
                + (self.above[1][plane] * node.max[1] + self.below[1][plane] * node.min[1])
                + (self.above[2][plane] * node.max[2] + self.below[2][plane] * node.min[2]);
            // Planes that are not used have an offset of minus infinity, and nothing lies outside
            // of them.
            *outside = mask(reach < self.offset[plane]);
        }
        outside.iter().fold(0, |any, plane| any | plane) == 0
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
}

/// Finds the first hits of the rays of a beam in a tree no deeper than [`PACKET_STACK`].
struct CastBeam<'a, F, const K: usize> {
    tree: &'a TriangleBvh,
    beam: &'a Beam,
    rays: &'a [RayPacket; K],
    opaque: &'a F,
    hits: &'a mut [PacketHits; K],
}

impl<F: Fn(&Hit) -> bool, const K: usize> Kernel for CastBeam<'_, F, K> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            tree,
            beam,
            rays,
            opaque,
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
            let mut entered = false;
            for i in 0..K {
                if enters(node, &rays[i].origin, &inverses[i], &hits[i].distance) {
                    Triangles {
                        tree,
                        rays: &rays[i],
                        opaque,
                    }
                    .leaf(node, &mut hits[i]);
                    entered = true;
                }
            }
            // Only triangles shorten rays, and with them the beam.
            if entered {
                beam.end(hits);
            }
        }
    }
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
            for (packet, together) in packets.iter().zip(&together) {
                let alone = tree.cast_packet_filtered(packet, opaque);
                prop_assert_eq!(alone.distance, together.distance);
            }
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
