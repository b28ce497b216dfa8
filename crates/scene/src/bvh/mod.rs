//! Rays against triangles: a bounding volume hierarchy built by `obvhs`, traversed here ray by ray
//! or in packets of sixteen.
//!
//! One ray and sixteen rays do the same arithmetic lane by lane, so both give the same distances.
//! The same holds for every instruction set: no operation is fused or approximate.
//!
//! | module | contents |
//! |---|---|
//! | `branchless` | comparisons and choices without a branch |
//! | `bounds` | boxes in space |
//! | `node`, `triangle` | one ray against a box or a triangle |
//! | `tree` | the tree: how it is built, and one ray in it |
//! | `packet` | sixteen rays at once |
//! | `beam` | blocks of packets from one point, as of a camera |
//! | `movers` | figures that are placed anew for each instant |
//! | `dispatch` | the widest vector instructions of the machine |

mod beam;
mod bounds;
mod branchless;
mod dispatch;
mod movers;
mod node;
mod packet;
mod tree;
mod triangle;

pub use beam::Beam;
pub use bounds::Bounds3;
pub use dispatch::{Kernel, widest};
pub(crate) use movers::CastAmong;
pub use movers::{Movers, Placed, SWEEP_S};
pub use packet::{LANES, Lane, PacketHits, RayPacket};
pub use tree::TriangleBvh;
pub use triangle::{Hit, MISS};

#[cfg(test)]
mod tests {
    use super::dispatch::Vectors;
    use super::packet::Cast;
    use super::triangle::{intersect_one, leaf_triangle};
    use super::*;
    use proptest::prelude::*;

    fn coordinate() -> impl Strategy<Value = f32> {
        -10.0_f32..10.0
    }

    fn triangle() -> impl Strategy<Value = [[f32; 3]; 3]> {
        prop::array::uniform3(prop::array::uniform3(coordinate()))
    }

    /// Origin and direction.
    fn ray() -> impl Strategy<Value = [[f32; 3]; 2]> {
        prop::array::uniform2(prop::array::uniform3(coordinate()))
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
            rays in prop::collection::vec(ray(), LANES),
        ) {
            let tree = TriangleBvh::new(soup.iter().copied());
            let mut packet = RayPacket::idle();
            for (lane, [origin, direction]) in rays.iter().enumerate() {
                packet.set(lane, *origin, *direction, 100.0);
            }
            let together = tree.cast_packet(&packet);
            for (lane, [origin, direction]) in rays.iter().enumerate() {
                let alone = tree.cast(*origin, *direction, 100.0);
                prop_assert_eq!(alone.map(|h| h.distance), brute_force(&soup, *origin, *direction));
                let is_hit = together.triangle[lane] != MISS;
                let from_packet = is_hit.then_some(together.distance[lane]);
                prop_assert_eq!(alone.map(|h| h.distance), from_packet);
            }
        }

        #[test]
        fn every_instruction_set_gives_the_same_bits(
            soup in prop::collection::vec(triangle(), 1..200),
            rays in prop::collection::vec(ray(), LANES),
        ) {
            let tree = TriangleBvh::masked(soup.iter().copied(), |i| i % 3 == 0);
            let mut packet = RayPacket::idle();
            for (lane, [origin, direction]) in rays.iter().enumerate() {
                packet.set(lane, *origin, *direction, 100.0);
            }
            let bits = |h: &PacketHits| {
                let numbers = [h.distance, h.u, h.v].map(|lane| lane.map(f32::to_bits));
                (numbers, h.triangle)
            };
            let mut seen = Vec::new();
            for vectors in Vectors::available() {
                let mut hits = PacketHits::none(&packet);
                let opaque = |hit: &Hit| hit.u > 0.3;
                vectors.run(Cast { tree: &tree, rays: &packet, opaque: &opaque, hits: &mut hits });
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
