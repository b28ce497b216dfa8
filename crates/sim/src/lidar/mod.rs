//! The Livox MID-360: four lines that sweep round, up and down without repeating. It casts 200,000
//! rays a second, each from the sensor's pose at that ray's own instant.
//!
//! | module | job |
//! |---|---|
//! | `pattern` | where each ray points |
//! | `launch` | origins and directions of the rays in the world |
//! | `order` | the order in which rays are cast |
//! | `returns` | detection and noise of the returns |
//! | `beams` | [`BeamErrors`]: edges, panes, mirrors, rain and fog |

mod beams;
mod launch;
mod order;
mod pattern;
mod returns;

use std::num::NonZeroU32;

use openbench_core::{LidarPoint, LidarScan, Pose3, SimTime};
use openbench_scene::bvh::{Kernel, LANES, MISS, PacketHits, widest};
use openbench_scene::{RayPacket, Snapshot, TriangleBvh};

use crate::noise::Noise;
use beams::{Beams, Spoiled};
use launch::Launch;
use order::CastingOrder;
use pattern::{FIRING_NS, VOLLEY};
use returns::{Echo, deviation, light};

pub use beams::{Air, BeamErrors};
pub use pattern::{Aim, LINES, Pattern};
pub use returns::{MAX_RANGE_M, MIN_RANGE_M};

/// Rays in a scan.
pub const RAYS_PER_SCAN: usize = 20_000;
/// Firings in a scan.
const FIRINGS_PER_SCAN: u64 = (RAYS_PER_SCAN / LINES) as u64;
/// Duration of a scan, nanoseconds.
pub(crate) const SCAN_NS: u64 = 100_000_000;

/// How much of a scan is cast. What is left out changes neither the rest of the scan nor the scans
/// that follow: each ray keeps its direction and its noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scanning {
    /// The four rays of one firing in so many, beginning with the first.
    OneFiringIn(NonZeroU32),
    /// Nothing: there is no scan.
    Off,
}

impl Default for Scanning {
    fn default() -> Self {
        Self::OneFiringIn(NonZeroU32::MIN)
    }
}

/// Whether a scan of one firing in `stride` has a point of a whole scan.
pub fn is_of_one_firing_in(point: &LidarPoint, stride: NonZeroU32) -> bool {
    (point.offset_ns / FIRING_NS as u32).is_multiple_of(stride.get())
}

/// The sensor.
#[derive(Debug)]
pub struct Lidar {
    noise: Noise,
    pattern: Pattern,
    /// Firings since the start.
    fired: u64,
    aims: Vec<Aim>,
    launch: Launch,
    order: CastingOrder,
    echoes: Vec<Echo>,
    /// What is wrong with its returns.
    beams: Option<Beams>,
}

impl Lidar {
    /// A sensor with this noise.
    pub fn new(noise: Noise) -> Self {
        Self {
            noise,
            pattern: Pattern::new(),
            fired: 0,
            aims: vec![Aim::default(); RAYS_PER_SCAN],
            launch: Launch::default(),
            order: CastingOrder::new(RAYS_PER_SCAN),
            echoes: vec![Echo::NONE; RAYS_PER_SCAN],
            beams: None,
        }
    }

    /// The same sensor with beams that have faults, drawn by a seed, in this air.
    pub fn with_errors(mut self, errors: BeamErrors, air: Air, seed: u64) -> Self {
        let is_off = errors == BeamErrors::default() && air == Air::default();
        self.beams = (!is_off).then(|| Beams::new(errors, air, seed));
        self
    }

    /// The scan that began at `stamp` and ends at the snapshot's instant. `poses` are those of the
    /// sensor in `map` at equal times from the scan's first instant to its last; at least two. The
    /// rays of one firing in `stride` are cast.
    pub fn scan(
        &mut self,
        seen: Snapshot<'_>,
        stamp: SimTime,
        poses: &[Pose3],
        stride: NonZeroU32,
    ) -> LidarScan {
        LidarScan {
            stamp,
            points: widest(Scan {
                lidar: self,
                seen,
                poses,
                stride: stride.get() as usize,
            }),
        }
    }

    /// Leaves the next scan out.
    pub fn skip(&mut self) {
        self.fired += FIRINGS_PER_SCAN;
        self.noise.skip(RAYS_PER_SCAN as u64);
    }

    /// True ranges of the next scan's rays in the order of firing, metres; 0 where nothing is hit.
    /// Holes in leaves are ignored. For comparing speeds.
    pub fn ranges(&mut self, tree: &TriangleBvh, poses: &[Pose3]) -> Vec<f32> {
        let mut ranges = vec![0.0; RAYS_PER_SCAN];
        widest(Ranges {
            lidar: self,
            tree,
            poses,
            ranges: &mut ranges,
        });
        ranges
    }

    /// Sets the directions of the next scan's rays, and the order in which they are cast.
    #[inline(always)]
    fn aim(&mut self, stride: usize) {
        self.order.clear();
        for (i, aims) in self.aims.chunks_mut(LINES * VOLLEY).enumerate() {
            let volley = self.pattern.volley(self.fired + (VOLLEY * i) as u64);
            // A scan's last volley is cut off.
            aims.copy_from_slice(&volley.as_flattened()[..aims.len()]);
            self.order.note(LINES * VOLLEY * i, aims);
        }
        self.fired += FIRINGS_PER_SCAN;
        self.order.sort(stride);
    }

    #[inline(always)]
    fn cast(&mut self, seen: Snapshot<'_>, poses: &[Pose3]) {
        self.launch.set(&self.aims, poses);
        if self.order.rays.len() < self.echoes.len() {
            // Those that are not cast hit nothing.
            self.echoes.fill(Echo::NONE);
        }
        for block in self.order.rays.chunks(BLOCK) {
            let mut met = BlockHits::none();
            for (packet, group) in block.chunks(LANES).enumerate() {
                let rays = self.packet(group);
                let mut lags = [0.0; LANES];
                for (lag, ray) in lags.iter_mut().zip(group) {
                    *lag = lag_of(*ray);
                }
                let hits = seen.cast_packet(&rays, &lags);
                met.note(packet, seen, &rays, &hits);
                if let Some(beams) = &mut self.beams {
                    beams.note(group, seen, &rays, &hits);
                }
            }
            // All casts of a block before any return of it: arithmetic over 64 becomes vector
            // instructions.
            let returns = met.returns();
            for (i, &ray) in block.iter().enumerate() {
                self.echoes[ray as usize] = Echo {
                    range: met.range[i],
                    deviation: returns.deviation[i],
                    light: returns.light[i],
                    reflectivity: met.reflectivity[i],
                };
            }
        }
        if let Some(beams) = &mut self.beams {
            let launch = &self.launch;
            let scan = Spoiled {
                seen,
                ray: |number: u32| launch.ray(number as usize),
                lag: lag_of,
                // The firings of this scan have been counted already.
                first: (self.fired - FIRINGS_PER_SCAN) * LINES as u64,
            };
            beams.spoil(&scan, &self.order.rays, &mut self.echoes);
        }
    }

    /// The rays of a group.
    #[inline(always)]
    fn packet(&self, group: &[u32]) -> RayPacket {
        let mut packet = RayPacket::idle();
        for (lane, &number) in group.iter().enumerate() {
            let ray = self.launch.ray(number as usize);
            packet.set(lane, ray.origin, ray.direction, MAX_RANGE_M);
        }
        packet
    }

    /// The points that the sensor reports: ranges with noise, of the rays that are detected.
    #[inline(always)]
    fn measure(&mut self) -> Vec<LidarPoint> {
        let mut points = Vec::with_capacity(RAYS_PER_SCAN);
        for (ray, (echo, aim)) in (0_u32..).zip(self.echoes.iter().zip(&self.aims)) {
            // Drawn for every ray, so that one ray's hit does not change the noise of the next.
            let drawn = self.noise.quick();
            // The uniform number is never negative, so a probability of 0 drops every ray that
            // hit nothing.
            if drawn.uniform >= echo.detection() {
                continue;
            }
            let range = (echo.range + echo.deviation * drawn.normal).max(MIN_RANGE_M);
            points.push(LidarPoint {
                xyz: aim.direction.map(|c| c * range),
                offset_ns: ray / LINES as u32 * FIRING_NS as u32,
                reflectivity: echo.reflectivity,
                line: (ray % LINES as u32) as u8,
            });
        }
        points
    }
}

/// Time of a ray relative to the scan's end, seconds; negative. The four rays of a firing get
/// slightly different ones; 15 µs move nothing by more than a millimetre.
#[inline(always)]
fn lag_of(ray: u32) -> f32 {
    ray as f32 * (FIRING_NS as f32 * 1e-9 / LINES as f32) - SCAN_NS as f32 * 1e-9
}

/// A scan.
struct Scan<'a> {
    lidar: &'a mut Lidar,
    seen: Snapshot<'a>,
    poses: &'a [Pose3],
    stride: usize,
}

impl Kernel for Scan<'_> {
    type Output = Vec<LidarPoint>;

    #[inline(always)]
    fn run(self) -> Vec<LidarPoint> {
        self.lidar.aim(self.stride);
        self.lidar.cast(self.seen, self.poses);
        self.lidar.measure()
    }
}

/// True ranges alone.
struct Ranges<'a> {
    lidar: &'a mut Lidar,
    tree: &'a TriangleBvh,
    poses: &'a [Pose3],
    ranges: &'a mut [f32],
}

impl Kernel for Ranges<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.lidar.aim(1);
        self.lidar.launch.set(&self.lidar.aims, self.poses);
        for group in self.lidar.order.rays.chunks_exact(LANES) {
            // The tree alone, without surfaces and movers: that is what other ray casters are
            // compared with.
            let hits = self.tree.cast_packet(&self.lidar.packet(group));
            for (lane, &ray) in group.iter().enumerate() {
                let hit = hits.triangle[lane] != MISS;
                self.ranges[ray as usize] = if hit { hits.distance[lane] } else { 0.0 };
            }
        }
    }
}

/// Rays whose returns are computed together. In loops over this many the compiler uses vector
/// instructions more readily than over sixteen.
const BLOCK: usize = 4 * LANES;

/// What the rays of a block hit.
struct BlockHits {
    /// Metres; 0 where nothing was hit.
    range: [f32; BLOCK],
    /// Cosine of the angle between the ray and the surface's normal.
    along: [f32; BLOCK],
    reflectivity: [u8; BLOCK],
}

/// Noise of a block's returns.
struct BlockReturns {
    /// Standard deviations of the reported ranges, metres.
    deviation: [f32; BLOCK],
    /// Light that comes back.
    light: [f32; BLOCK],
}

impl BlockHits {
    fn none() -> Self {
        Self {
            range: [0.0; BLOCK],
            along: [0.0; BLOCK],
            reflectivity: [0; BLOCK],
        }
    }

    /// Takes in the hits of the block's packet number `packet`.
    #[inline(always)]
    fn note(&mut self, packet: usize, seen: Snapshot<'_>, rays: &RayPacket, hits: &PacketHits) {
        for lane in 0..LANES {
            if hits.triangle[lane] == MISS {
                continue;
            }
            let (i, normal) = (packet * LANES + lane, seen.normal(hits, lane));
            self.range[i] = hits.distance[lane];
            self.along[i] = normal[0] * rays.direction[0][lane]
                + normal[1] * rays.direction[1][lane]
                + normal[2] * rays.direction[2][lane];
            self.reflectivity[i] = seen.caster.surface(hits.triangle[lane]).reflectivity;
        }
    }

    #[inline(always)]
    fn returns(&self) -> BlockReturns {
        let mut returns = BlockReturns {
            deviation: [0.0; BLOCK],
            light: [0.0; BLOCK],
        };
        for i in 0..BLOCK {
            // Either side of a triangle reflects. Rounding may give cosines above 1, whose slant
            // would be the root of a negative number.
            let along = self.along[i].abs();
            let cosine = if along < 1.0 { along } else { 1.0 };
            returns.deviation[i] = deviation(self.range[i], cosine);
            returns.light[i] = light(self.range[i], cosine, f32::from(self.reflectivity[i]));
        }
        returns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, UnitQuaternion, Vector3};
    use openbench_scene::{
        Finish, Layer, Material, Movers, RayCaster, SceneBuilder, SemanticClass,
    };
    use std::sync::Arc;

    fn scan(lidar: &mut Lidar, caster: &RayCaster, poses: &[Pose3]) -> LidarScan {
        strided_scan(lidar, caster, poses, 1)
    }

    fn strided_scan(
        lidar: &mut Lidar,
        caster: &RayCaster,
        poses: &[Pose3],
        stride: u32,
    ) -> LidarScan {
        let movers = &Movers::default();
        let seen = Snapshot { caster, movers };
        let stride = NonZeroU32::new(stride).unwrap();
        lidar.scan(seen, SimTime::ZERO, poses, stride)
    }

    fn room(half: f64) -> RayCaster {
        let mut builder = SceneBuilder::new();
        let wall = builder.material(Material::plain(SemanticClass::Wall, [0.5; 3]));
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        for (corner, u) in [
            ((-half, -half), x),
            ((half, -half), y),
            ((-half, half), x),
            ((-half, -half), y),
        ] {
            let origin = Point3::new(corner.0, corner.1, -1.0);
            builder.rectangle(
                Layer::Visible,
                wall,
                origin,
                u * 2.0 * half,
                z * 100.0,
                [1.0; 2],
            );
        }
        RayCaster::new(Arc::new(builder.build()))
    }

    #[test]
    fn walls_are_measured_in_place_with_noise_of_two_centimetres() {
        let caster = room(5.0);
        let poses = vec![Pose3::identity(); 3];
        let scan = scan(&mut Lidar::new(Noise::new(1, 1)), &caster, &poses);
        assert!(
            scan.points.len() > RAYS_PER_SCAN * 90 / 100,
            "{}",
            scan.points.len()
        );
        let errors: Vec<f32> = scan
            .points
            .iter()
            .map(|p| p.xyz[0].abs().max(p.xyz[1].abs()) - 5.0)
            .collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f32>() / errors.len() as f32).sqrt();
        assert!((0.012..0.03).contains(&rms), "{rms}");
    }

    #[test]
    fn each_point_is_measured_from_the_pose_of_its_own_instant() {
        // The sensor turns by half a radian during the scan. Deskewed, the walls are straight
        // again.
        let caster = room(5.0);
        let pose = |s: f64| {
            Pose3::from_parts(
                Vector3::zeros().into(),
                UnitQuaternion::from_euler_angles(0.0, 0.0, 0.5 * s),
            )
        };
        let poses: Vec<Pose3> = (0..=40).map(|i| pose(f64::from(i) / 40.0)).collect();
        let scan = scan(&mut Lidar::new(Noise::new(1, 1)), &caster, &poses);
        for p in &scan.points {
            let at = pose(f64::from(p.offset_ns) / SCAN_NS as f64);
            let q = at * Point3::from(p.xyz.map(f64::from));
            assert!((q.x.abs().max(q.y.abs()) - 5.0).abs() < 0.15, "{q}");
        }
    }

    /// A scan with errors of a room of 5 m with a wall of panes, and of the same without errors.
    fn scans(errors: BeamErrors, finish: Finish) -> [LidarScan; 2] {
        let mut builder = SceneBuilder::new();
        let wall = builder.material(Material::plain(SemanticClass::Wall, [0.5; 3]));
        let pane = builder.material(Material {
            finish,
            ..Material::plain(SemanticClass::Building, [0.5; 3])
        });
        let (y, z) = (Vector3::y(), Vector3::z());
        let mut board = |material, x: f64, width: f64| {
            let corner = Point3::new(x, -width / 2.0, -2.0);
            builder.rectangle(
                Layer::Visible,
                material,
                corner,
                y * width,
                z * 12.0,
                [1.0; 2],
            );
        };
        board(pane, 5.0, 30.0);
        board(wall, -5.0, 30.0);
        // A post whose edges are 1 m before the wall behind it.
        board(wall, -4.0, 0.4);
        let caster = RayCaster::new(Arc::new(builder.build()));
        let poses = [Pose3::identity(); 2];
        [errors, BeamErrors::default()].map(|errors| {
            let mut lidar = Lidar::new(Noise::new(1, 1)).with_errors(errors, Air::default(), 3);
            scan(&mut lidar, &caster, &poses)
        })
    }

    #[test]
    fn beams_on_edges_report_ranges_between_the_two_surfaces() {
        let errors = BeamErrors {
            beam_mrad: 6.0,
            ..BeamErrors::default()
        };
        let between = |scan: &LidarScan| {
            let is_between = |p: &&LidarPoint| (-4.8..-4.2).contains(&p.xyz[0]);
            scan.points.iter().filter(is_between).count()
        };
        let [real, ideal] = scans(errors, Finish::Matt);
        assert_eq!(between(&ideal), 0);
        assert!(between(&real) > 0);
        assert_eq!(real.points.len(), ideal.points.len());
    }

    #[test]
    fn panes_return_beams_along_their_normal_and_lose_most_others() {
        let errors = BeamErrors {
            glass: 0.9,
            ghosts: 0.0,
            ..BeamErrors::default()
        };
        let [real, ideal] = scans(errors, Finish::Glass);
        let count = |scan: &LidarScan, side: f32| {
            let aside = |p: &LidarPoint| (p.xyz[1] / p.xyz[0]).abs();
            let on_pane = |p: &&LidarPoint| p.xyz[0] > 4.0 && aside(p) >= side;
            scan.points.iter().filter(on_pane).count() as f64
        };
        let lost = 1.0 - count(&real, 0.3) / count(&ideal, 0.3);
        assert!((0.85..0.95).contains(&lost), "{lost}");
        assert!(count(&real, 0.0) - count(&real, 0.1) > 0.0);
        // Nothing else changes.
        let rest = |scan: &LidarScan| {
            let behind = scan.points.iter().filter(|p| p.xyz[0] < 0.0);
            behind.copied().collect::<Vec<_>>()
        };
        assert_eq!(rest(&real), rest(&ideal));
    }

    #[test]
    fn panes_show_what_they_mirror_as_far_behind_them() {
        let errors = BeamErrors {
            glass: 1.0,
            ghosts: 1.0,
            ..BeamErrors::default()
        };
        let [real, _] = scans(errors, Finish::Glass);
        // The wall 10 m before the pane seems to be 10 m behind it.
        let behind = |p: &&LidarPoint| (14.5..15.5).contains(&p.xyz[0]);
        assert!(real.points.iter().filter(behind).count() > 50);
    }

    #[test]
    fn rain_returns_near_drops_and_fog_takes_far_walls() {
        let air = Air {
            extinction: 0.0,
            drops: 0.05,
        };
        let caster = room(20.0);
        let poses = [Pose3::identity(); 2];
        let in_air = |air| {
            let lidar = Lidar::new(Noise::new(1, 1));
            let mut lidar = lidar.with_errors(BeamErrors::default(), air, 3);
            scan(&mut lidar, &caster, &poses)
        };
        let range = |p: &&LidarPoint| p.xyz.iter().map(|c| c * c).sum::<f32>().sqrt();
        let near = |scan: &LidarScan| scan.points.iter().filter(|p| range(p) < 10.0).count();
        assert_eq!(near(&in_air(Air::default())), 0);
        let drops = near(&in_air(air)) as f64 / RAYS_PER_SCAN as f64;
        assert!((0.04..0.06).contains(&drops), "{drops}");
        let fog = Air {
            extinction: 0.1,
            drops: 0.0,
        };
        assert!(in_air(fog).points.len() < RAYS_PER_SCAN / 5);
    }

    #[test]
    fn errors_do_not_depend_on_the_scans_and_firings_that_are_left_out() {
        let caster = room(5.0);
        let poses = [Pose3::identity(); 2];
        let errors = BeamErrors {
            beam_mrad: 5.0,
            glass: 0.5,
            ghosts: 0.5,
        };
        let air = Air {
            extinction: 0.01,
            drops: 0.03,
        };
        let lidar = || Lidar::new(Noise::new(1, 1)).with_errors(errors, air, 3);
        let (mut all, mut second) = (lidar(), lidar());
        scan(&mut all, &caster, &poses);
        second.skip();
        let mut expected = scan(&mut all, &caster, &poses);
        let one_in = NonZeroU32::new(7).unwrap();
        let is_cast = |point: &LidarPoint| is_of_one_firing_in(point, one_in);
        expected.points.retain(is_cast);
        assert_eq!(strided_scan(&mut second, &caster, &poses, 7), expected);
    }

    #[test]
    fn a_scan_of_some_firings_is_that_part_of_the_whole_scan() {
        let (caster, poses) = (room(5.0), [Pose3::identity(); 2]);
        let mut whole = Lidar::new(Noise::new(1, 1));
        let mut part = Lidar::new(Noise::new(1, 1));
        // The stride of 7 leaves a packet that is not full, and comes between whole scans.
        for stride in [1, 7, 8, 1] {
            let mut expected = scan(&mut whole, &caster, &poses);
            let one_in = NonZeroU32::new(stride).unwrap();
            expected
                .points
                .retain(|point| is_of_one_firing_in(point, one_in));
            let got = strided_scan(&mut part, &caster, &poses, stride);
            assert!(got.points.len() > RAYS_PER_SCAN * 9 / 10 / stride as usize);
            assert_eq!(got, expected, "{stride}");
        }
    }

    #[test]
    fn a_scan_that_is_left_out_does_not_change_the_next() {
        let (caster, poses) = (room(5.0), [Pose3::identity(); 2]);
        let mut all = Lidar::new(Noise::new(1, 1));
        let mut second = Lidar::new(Noise::new(1, 1));
        scan(&mut all, &caster, &poses);
        second.skip();
        let next = scan(&mut second, &caster, &poses);
        assert_eq!(next, scan(&mut all, &caster, &poses));
    }

    #[test]
    fn scans_do_not_repeat() {
        let caster = room(5.0);
        let mut lidar = Lidar::new(Noise::new(1, 1));
        let poses = vec![Pose3::identity(); 2];
        let (a, b) = (
            scan(&mut lidar, &caster, &poses),
            scan(&mut lidar, &caster, &poses),
        );
        assert!(a.points.iter().zip(&b.points).all(|(p, q)| p.xyz != q.xyz));
    }
}
