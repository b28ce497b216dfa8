//! Shadows of the sun.

use openbench_scene::bvh::{LANES, Lane, MISS, PacketHits};
use openbench_scene::{RayPacket, Snapshot};

use super::block::{BLOCK, Block, PACKETS, SIDE, pixel};
use super::illumination::Faces;

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

/// The same of surfaces, where one pixel of four decides for a block that they agree on: a shadow's
/// edge costs four times as much as its inside. What is narrower than two pixels may get lost.
#[inline(always)]
pub(super) fn sunlit_by_samples(
    seen: Snapshot<'_>,
    lag: f32,
    faces: &Faces,
    towards: [f32; 3],
) -> Block {
    let [nx, ny, nz] = &faces.normal;
    let mut facing = [false; BLOCK];
    let mut any = false;
    for i in 0..BLOCK {
        // The sky has no normal, and what turns away from the sun needs no shadow to be dark.
        facing[i] = nx[i] * towards[0] + ny[i] * towards[1] + nz[i] * towards[2] > 0.0;
        any |= facing[i];
    }
    if !any {
        return [1.0; BLOCK];
    }
    let mut starts = [[0.0; BLOCK]; 3];
    for (axis, starts) in starts.iter_mut().enumerate() {
        let (at, normal) = (&faces.at[axis], &faces.normal[axis]);
        for (start, (at, normal)) in starts.iter_mut().zip(at.iter().zip(normal)) {
            *start = at + OFF_SURFACE_M * normal;
        }
    }
    let sun = Sunbeams {
        seen,
        lag,
        starts: &starts,
        facing: &facing,
        towards,
    };
    let mut sampled = [0; LANES];
    for (sample, i) in sampled.iter_mut().enumerate() {
        let (column, row) = (sample % (SIDE / SPARSE), sample / (SIDE / SPARSE));
        *i = pixel(SPARSE * column, SPARSE * row);
    }
    let free = sun.free(&sampled);
    let (mut bright, mut dark) = (false, false);
    for (free, &i) in free.iter().zip(&sampled) {
        bright |= facing[i] && *free;
        dark |= facing[i] && !*free;
    }
    match (bright, dark) {
        (true, false) => [1.0; BLOCK],
        (false, true) => [0.0; BLOCK],
        _ => sun.all(),
    }
}

/// Rays from the surfaces of a block towards the sun.
struct Sunbeams<'a> {
    seen: Snapshot<'a>,
    lag: f32,
    starts: &'a [Block; 3],
    /// Whether a pixel shows a surface that faces the sun.
    facing: &'a [bool; BLOCK],
    towards: [f32; 3],
}

impl Sunbeams<'_> {
    /// Whether nothing stands between these pixels and the sun.
    #[inline(always)]
    fn free(&self, pixels: &[usize; LANES]) -> [bool; LANES] {
        let mut back = RayPacket::idle();
        for axis in 0..3 {
            back.direction[axis] = [self.towards[axis]; LANES];
        }
        for (lane, &i) in pixels.iter().enumerate() {
            for axis in 0..3 {
                back.origin[axis][lane] = self.starts[axis][i];
            }
            back.limit[lane] = if self.facing[i] { SHADOW_RANGE_M } else { -1.0 };
        }
        self.seen.unobstructed(&back, &lags(self.lag))
    }

    #[inline(always)]
    fn all(&self) -> Block {
        let mut sunlit = [0.0; BLOCK];
        for (packet, sunlit) in sunlit.chunks_exact_mut(LANES).enumerate() {
            let mut pixels = [0; LANES];
            for (lane, pixel) in pixels.iter_mut().enumerate() {
                *pixel = packet * LANES + lane;
            }
            for (sunlit, free) in sunlit.iter_mut().zip(self.free(&pixels)) {
                *sunlit = if free { 1.0 } else { 0.0 };
            }
        }
        sunlit
    }
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
