//! Shadows of the sun.

use openbench_scene::bvh::{LANES, Lane, MISS, PacketHits};
use openbench_scene::{RayPacket, Snapshot};

use super::block::{BLOCK, Block, PACKETS, SIDE, pixel};

/// Distance from a surface at which a ray towards the sun begins, metres. It keeps the surface
/// from shadowing itself.
const OFF_SURFACE_M: f32 = 0.01;
/// Largest distance of an object that casts a shadow, metres.
const SHADOW_RANGE_M: f32 = 150.0;
/// Of each second column and row a pixel is looked at first.
const SPARSE: usize = 2;

/// Rays of a block and what they hit.
#[derive(Clone, Copy)]
pub(super) struct Cast<'a> {
    pub(super) seen: Snapshot<'a>,
    pub(super) rays: &'a [RayPacket; PACKETS],
    pub(super) hits: &'a [PacketHits; PACKETS],
    /// Time of the rays relative to the instant of the movers, seconds.
    pub(super) lag: f32,
}

/// For each pixel 1 if the sun shines on what was hit, 0 if an object stands between.
pub(super) fn sunlit(cast: Cast<'_>, towards: [f32; 3]) -> Block {
    let mut sunlit = [0.0; BLOCK];
    for (packet, sunlit) in sunlit.chunks_exact_mut(LANES).enumerate() {
        let mut back = RayPacket::idle();
        for lane in (0..LANES).filter(|&lane| cast.hits[packet].triangle[lane] != MISS) {
            back.set(
                lane,
                cast.off_surface(packet, lane),
                towards,
                SHADOW_RANGE_M,
            );
        }
        // Lanes without a hit are idle and come back as sunlit; those pixels show the sky.
        let between = cast.seen.cast_packet(&back, &lags(cast.lag));
        for (sunlit, triangle) in sunlit.iter_mut().zip(&between.triangle) {
            *sunlit = if *triangle == MISS { 1.0 } else { 0.0 };
        }
    }
    sunlit
}

/// The same where one pixel of four decides for a block that they agree on: a shadow's edge costs
/// four times as much as its inside. What is narrower than two pixels may get lost.
#[inline(always)]
pub(super) fn sunlit_by_samples(cast: Cast<'_>, towards: [f32; 3]) -> Block {
    let mut back = RayPacket::idle();
    let mut asked = [false; LANES];
    let mut any = false;
    for (sample, asked) in asked.iter_mut().enumerate() {
        let (column, row) = (sample % (SIDE / SPARSE), sample / (SIDE / SPARSE));
        let i = pixel(SPARSE * column, SPARSE * row);
        let (packet, lane) = (i / LANES, i % LANES);
        if cast.hits[packet].triangle[lane] == MISS || !cast.faces(packet, lane, towards) {
            continue;
        }
        back.set(
            sample,
            cast.off_surface(packet, lane),
            towards,
            SHADOW_RANGE_M,
        );
        (*asked, any) = (true, true);
    }
    if !any {
        // Sky, or surfaces that face away from the sun, which need no shadow to be dark.
        return sunlit_if_any(cast, towards);
    }
    let between = cast.seen.cast_packet(&back, &lags(cast.lag));
    let (mut bright, mut dark) = (false, false);
    for (asked, triangle) in asked.iter().zip(&between.triangle) {
        bright |= *asked && *triangle == MISS;
        dark |= *asked && *triangle != MISS;
    }
    match (bright, dark) {
        (true, true) => sunlit(cast, towards),
        (true, false) => [1.0; BLOCK],
        _ => [0.0; BLOCK],
    }
}

/// Where no sample faces the sun, other pixels of the block still may.
#[inline(always)]
fn sunlit_if_any(cast: Cast<'_>, towards: [f32; 3]) -> Block {
    for i in 0..BLOCK {
        let (packet, lane) = (i / LANES, i % LANES);
        if cast.hits[packet].triangle[lane] != MISS && cast.faces(packet, lane, towards) {
            return sunlit(cast, towards);
        }
    }
    [1.0; BLOCK]
}

fn lags(lag: f32) -> Lane {
    [lag; LANES]
}

impl Cast<'_> {
    /// The normal of what a lane hit, on the side from which it is seen: triangles have two sides.
    #[inline(always)]
    fn normal(&self, packet: usize, lane: usize) -> [f32; 3] {
        let normal = self.seen.normal(&self.hits[packet], lane);
        let direction = &self.rays[packet].direction;
        let facing: f32 = (0..3)
            .map(|axis| normal[axis] * direction[axis][lane])
            .sum();
        if facing > 0.0 {
            normal.map(|c| -c)
        } else {
            normal
        }
    }

    #[inline(always)]
    fn faces(&self, packet: usize, lane: usize, towards: [f32; 3]) -> bool {
        let normal = self.normal(packet, lane);
        normal[0] * towards[0] + normal[1] * towards[1] + normal[2] * towards[2] > 0.0
    }

    /// A point just before what a lane hit.
    #[inline(always)]
    fn off_surface(&self, packet: usize, lane: usize) -> [f32; 3] {
        let (rays, normal) = (&self.rays[packet], self.normal(packet, lane));
        let distance = self.hits[packet].distance[lane];
        [0, 1, 2].map(|axis| {
            let along = distance * rays.direction[axis][lane];
            rays.origin[axis][lane] + along + OFF_SURFACE_M * normal[axis]
        })
    }
}
