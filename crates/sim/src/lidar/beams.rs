//! What is wrong with the returns of real beams: edges, panes, mirrors, rain and fog.
//!
//! Where a beam falls on two surfaces that are nearly as far, the sensor reports a range between
//! them ("mixed pixels", Tang, Huber and Akinci 2007). The share of such beams grows with their
//! width. It would cost as many rays again to find them all, so of one beam in [`ONE_IN`] a second
//! ray is cast, farther from the first by as much, to one side alone: about a third of them is
//! found.
//!
//! Panes throw a beam back as a mirror does, or let it through into rooms that are not modelled
//! (Foster, Sun, Park and Kuipers 2013). Only beams along the normal come back.

use openbench_scene::bvh::{LANES, MISS, PacketHits};
use openbench_scene::{Finish, RayPacket, Snapshot};
use serde::{Deserialize, Serialize};

use super::launch::Ray;
use super::returns::{Echo, MAX_RANGE_M, deviation, left_by_air, light};

/// One beam of so many is looked at for edges.
const ONE_IN: u32 = 4;
/// Surfaces that are farther apart give two returns, of which the first counts, metres.
const LONGEST_MIX_M: f32 = 1.5;
/// A second ray that ends this near to the plane of the first hit found no edge, metres.
const SAME_PLANE_M: f32 = 0.05;
/// Cosine from which a pane throws enough light back along the beam: 11 degrees.
const ALONG_NORMAL: f32 = 0.98;
/// Distance from a pane at which a mirrored ray begins, metres.
const OFF_PANE_M: f32 = 0.02;
/// Share of the light that a pane mirrors and lets back, as a factor on the reflectivity.
const MIRRORED: f32 = 0.5;
/// Nearest and farthest drops that are seen, metres: light falls with the square of the range.
const NEAREST_DROP_M: f32 = 0.4;
const FARTHEST_DROP_M: f32 = 8.0;
/// Standard deviation of the range of a drop, and its reflectivity, of 255.
const DROP_DEVIATION_M: f32 = 0.02;
const DROP_REFLECTIVITY: u8 = 5;
/// Light of the drops that are counted: all of them are detected.
const DROP_LIGHT: f32 = 2.0;

/// What is wrong with the returns of a LiDAR's beams; 0 is what it always returned.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BeamErrors {
    /// Width of a beam where it meets an edge, milliradians.
    pub beam_mrad: f64,
    /// Share of the beams that panes do not return, unless along the normal.
    pub glass: f64,
    /// Share of these that return what the pane mirrors, as far behind it.
    pub ghosts: f64,
}

/// The air that beams pass through.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Air {
    /// Share of the light that is lost on each metre, for short ways.
    pub extinction: f32,
    /// Share of the beams that hit a drop before anything else within 8 m.
    pub drops: f32,
}

/// Spoils the returns of scans.
#[derive(Debug, Clone)]
pub(super) struct Beams {
    errors: BeamErrors,
    air: Air,
    key: u32,
    /// Hits of panes in the present scan.
    panes: Vec<Pane>,
}

/// A beam that fell on a pane.
#[derive(Debug, Clone, Copy)]
struct Pane {
    ray: u32,
    range: f32,
    normal: [f32; 3],
    cosine: f32,
}

/// Rays of a packet by their numbers in the scan; fewer than the packet's at the end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Numbers {
    rays: [u32; LANES],
    count: usize,
}

impl Numbers {
    fn none() -> Self {
        Self {
            rays: [0; LANES],
            count: 0,
        }
    }

    fn push(&mut self, ray: u32) {
        self.rays[self.count] = ray;
        self.count += 1;
    }

    fn is_full(&self) -> bool {
        self.count == LANES
    }
}

/// A scan whose returns are spoiled.
pub(super) struct Spoiled<'a, L, T> {
    pub(super) seen: Snapshot<'a>,
    /// The rays of the scan, by number.
    pub(super) ray: L,
    /// The time of a ray relative to the instant of the movers, seconds.
    pub(super) lag: T,
    /// Number of the scan's first ray since the start.
    pub(super) first: u64,
}

impl Beams {
    pub(super) fn new(errors: BeamErrors, air: Air, seed: u64) -> Self {
        let bits = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        Self {
            errors,
            air,
            key: (bits >> 32) as u32 ^ bits as u32,
            panes: Vec::new(),
        }
    }

    /// Notes the panes that a packet's rays, numbered by `group`, hit.
    #[inline(always)]
    pub(super) fn note(
        &mut self,
        group: &[u32],
        seen: Snapshot<'_>,
        rays: &RayPacket,
        hits: &PacketHits,
    ) {
        if self.errors.glass <= 0.0 {
            return;
        }
        for (lane, &ray) in group.iter().enumerate() {
            let triangle = hits.triangle[lane];
            if triangle == MISS || seen.caster.surface(triangle).finish != Finish::Glass {
                continue;
            }
            let normal = seen.normal(hits, lane);
            let direction = [0, 1, 2].map(|axis| rays.direction[axis][lane]);
            self.panes.push(Pane {
                ray,
                range: hits.distance[lane],
                normal,
                cosine: dot(normal, direction),
            });
        }
    }

    /// Spoils the echoes of a scan whose rays are cast in this order.
    #[inline(always)]
    pub(super) fn spoil<L, T>(
        &mut self,
        scan: &Spoiled<'_, L, T>,
        order: &[u32],
        echoes: &mut [Echo],
    ) where
        L: Fn(u32) -> Ray,
        T: Fn(u32) -> f32,
    {
        if self.errors.beam_mrad > 0.0 {
            self.mix(scan, order, echoes);
        }
        self.lose_on_panes(scan, echoes);
        if self.air != Air::default() {
            self.weather(scan.first, order, echoes);
        }
    }

    /// Blends the ranges of beams that fall on two surfaces.
    #[inline(always)]
    fn mix<L, T>(&self, scan: &Spoiled<'_, L, T>, order: &[u32], echoes: &mut [Echo])
    where
        L: Fn(u32) -> Ray,
        T: Fn(u32) -> f32,
    {
        let mut numbers = Numbers::none();
        for &ray in order {
            let bits = self.bits(scan.first, ray, 0);
            if bits.is_multiple_of(ONE_IN) && echoes[ray as usize].range > 0.0 {
                numbers.push(ray);
            }
            if numbers.is_full() {
                self.mix_packet(scan, &numbers, echoes);
                numbers = Numbers::none();
            }
        }
        self.mix_packet(scan, &numbers, echoes);
    }

    #[inline(always)]
    fn mix_packet<L, T>(&self, scan: &Spoiled<'_, L, T>, numbers: &Numbers, echoes: &mut [Echo])
    where
        L: Fn(u32) -> Ray,
        T: Fn(u32) -> f32,
    {
        let (mut packet, mut lags) = (RayPacket::idle(), [0.0; LANES]);
        // Half the beam's width, and farther as fewer beams are looked at.
        let out = 0.5e-3 * self.errors.beam_mrad as f32 * ONE_IN as f32;
        for (lane, &number) in numbers.rays[..numbers.count].iter().enumerate() {
            let ray = (scan.ray)(number);
            let aside = aside(ray.direction, self.bits(scan.first, number, 1), out);
            packet.set(lane, ray.origin, aside, MAX_RANGE_M);
            lags[lane] = (scan.lag)(number);
        }
        let hits = scan.seen.cast_packet(&packet, &lags);
        for (lane, &number) in numbers.rays[..numbers.count].iter().enumerate() {
            if hits.triangle[lane] == MISS {
                continue;
            }
            let (ray, echo) = ((scan.ray)(number), &mut echoes[number as usize]);
            let jump = hits.distance[lane] - echo.range;
            let normal = scan.seen.normal(&hits, lane);
            // From the second hit to the first, along the normal of the second.
            let apart: f32 = (0..3)
                .map(|axis| {
                    let first = echo.range * ray.direction[axis];
                    let second = hits.distance[lane] * packet.direction[axis][lane];
                    normal[axis] * (first - second)
                })
                .sum();
            if jump.abs() <= LONGEST_MIX_M && apart.abs() > SAME_PLANE_M {
                echo.range += jump * share(self.bits(scan.first, number, 2));
            }
        }
    }

    /// Takes away what panes do not return, or moves it to where mirrored things seem to be.
    #[inline(always)]
    fn lose_on_panes<L, T>(&mut self, scan: &Spoiled<'_, L, T>, echoes: &mut [Echo])
    where
        L: Fn(u32) -> Ray,
        T: Fn(u32) -> f32,
    {
        let panes = std::mem::take(&mut self.panes);
        for group in panes.chunks(LANES) {
            let (mut packet, mut lags) = (RayPacket::idle(), [0.0; LANES]);
            let mut asked = false;
            for (lane, pane) in group.iter().enumerate() {
                let drawn = share(self.bits(scan.first, pane.ray, 3));
                if pane.cosine.abs() >= ALONG_NORMAL || f64::from(drawn) >= self.errors.glass {
                    continue;
                }
                let echo = &mut echoes[pane.ray as usize];
                echo.light = 0.0;
                let drawn = share(self.bits(scan.first, pane.ray, 4));
                if f64::from(drawn) >= self.errors.ghosts || pane.range >= MAX_RANGE_M {
                    continue;
                }
                let ray = (scan.ray)(pane.ray);
                let mirrored = [0, 1, 2]
                    .map(|axis| ray.direction[axis] - 2.0 * pane.cosine * pane.normal[axis]);
                let before = pane.range - OFF_PANE_M;
                let at = [0, 1, 2].map(|axis| ray.origin[axis] + before * ray.direction[axis]);
                packet.set(lane, at, mirrored, MAX_RANGE_M - pane.range);
                lags[lane] = (scan.lag)(pane.ray);
                asked = true;
            }
            if asked {
                ghosts(scan.seen, group, &packet, &lags, echoes);
            }
        }
        self.panes = panes;
        self.panes.clear();
    }

    /// Weakens all returns, and puts drops before some.
    #[inline(always)]
    fn weather(&self, first: u64, order: &[u32], echoes: &mut [Echo]) {
        for &ray in order {
            let echo = &mut echoes[ray as usize];
            echo.light *= left_by_air(self.air.extinction, echo.range);
            if share(self.bits(first, ray, 5)) >= self.air.drops {
                continue;
            }
            // Uniform in the inverse of the range.
            let inverse = share(self.bits(first, ray, 6));
            let (near, far) = (1.0 / NEAREST_DROP_M, 1.0 / FARTHEST_DROP_M);
            let range = 1.0 / (far + inverse * inverse * (near - far));
            if echo.range <= 0.0 || range < echo.range {
                *echo = Echo {
                    range,
                    deviation: DROP_DEVIATION_M,
                    light: DROP_LIGHT,
                    reflectivity: DROP_REFLECTIVITY,
                };
            }
        }
    }

    /// Random bits for a ray: they depend on seed, ray and purpose alone, so rays may come in any
    /// order, and some may be left out.
    #[inline(always)]
    fn bits(&self, first: u64, ray: u32, purpose: u32) -> u32 {
        let number = first.wrapping_add(u64::from(ray)) as u32;
        // `lowbias32` (Wellons, "Hash Prospector").
        let mut bits = number ^ self.key;
        bits ^= bits >> 16;
        bits = bits.wrapping_mul(0x7feb_352d);
        bits ^= (bits >> 15) ^ purpose.wrapping_mul(0x9e37_79b9);
        bits = bits.wrapping_mul(0x846c_a68b);
        bits ^ bits >> 16
    }
}

/// Returns of mirrored rays: as far behind the pane as the thing is before it.
#[inline(always)]
fn ghosts(
    seen: Snapshot<'_>,
    group: &[Pane],
    packet: &RayPacket,
    lags: &[f32; LANES],
    echoes: &mut [Echo],
) {
    let hits = seen.cast_packet(packet, lags);
    for (lane, pane) in group.iter().enumerate() {
        if hits.triangle[lane] == MISS {
            continue;
        }
        let direction = [0, 1, 2].map(|axis| packet.direction[axis][lane]);
        let cosine = dot(seen.normal(&hits, lane), direction).abs().min(1.0);
        let reflectivity = seen.caster.surface(hits.triangle[lane]).reflectivity;
        let range = pane.range - OFF_PANE_M + hits.distance[lane];
        echoes[pane.ray as usize] = Echo {
            range,
            deviation: deviation(range, cosine),
            light: light(range, cosine, MIRRORED * f32::from(reflectivity)),
            reflectivity,
        };
    }
}

/// A number from 0 to 1 from random bits.
#[inline(always)]
fn share(bits: u32) -> f32 {
    (bits >> 8) as f32 / 16_777_216.0
}

/// The direction `out` radians beside another one, to one of eight sides.
#[inline(always)]
fn aside(direction: [f32; 3], bits: u32, out: f32) -> [f32; 3] {
    const SIDES: [[f32; 2]; 8] = [
        [1.0, 0.0],
        [0.707, 0.707],
        [0.0, 1.0],
        [-0.707, 0.707],
        [-1.0, 0.0],
        [-0.707, -0.707],
        [0.0, -1.0],
        [0.707, -0.707],
    ];
    let [x, y, z] = direction;
    // Level, and across both. Beams never point straight up.
    let level = (x * x + y * y).sqrt().max(1e-6);
    let right = [y / level, -x / level, 0.0];
    let up = [-x * z / level, -y * z / level, level];
    let [u, v] = SIDES[(bits % 8) as usize];
    [0, 1, 2].map(|axis| direction[axis] + out * (u * right[axis] + v * up[axis]))
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_beside_another_are_as_far_from_it_to_all_sides() {
        let direction = [0.6, 0.48, 0.64];
        for bits in 0..8 {
            let other = aside(direction, bits, 0.006);
            let off = [0, 1, 2].map(|axis| other[axis] - direction[axis]);
            let angle = dot(off, off).sqrt();
            assert!((angle - 0.006).abs() < 1e-5, "{bits}: {angle}");
            assert!(dot(off, direction).abs() < 1e-5);
        }
        assert!(
            aside([0.0, 0.0, 1.0], 3, 0.006)
                .iter()
                .all(|c| c.is_finite())
        );
    }

    #[test]
    fn random_numbers_are_even_and_differ_by_purpose() {
        let beams = Beams::new(BeamErrors::default(), Air::default(), 3);
        for purpose in 0..7 {
            let sum: f32 = (0..10_000)
                .map(|ray| share(beams.bits(5, ray, purpose)))
                .sum();
            assert!((sum / 1e4 - 0.5).abs() < 0.02, "{purpose}: {sum}");
        }
        assert_ne!(beams.bits(5, 1, 0), beams.bits(5, 1, 1));
        // The second ray of one scan is the first one of a scan that begins a ray later.
        assert_eq!(beams.bits(5, 1, 0), beams.bits(6, 0, 0));
    }
}
