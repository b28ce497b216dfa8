//! The MID-360: four lines that sweep round and up and down without repeating, 200,000 rays a second, each cast from
//! where the sensor is at that ray's own instant.
//!
//! | module | its one job |
//! |---|---|
//! | [`pattern`] | where each ray points |
//! | `launch` | where it begins and runs in the world |
//! | [`returns`] | what comes back of it |

mod launch;
pub mod pattern;
pub mod returns;

use openbench_core::{LidarPoint, LidarScan, Pose3, SimTime};
use openbench_scene::bvh::{LANES, MISS};
use openbench_scene::{RayCaster, RayPacket, TriangleBvh};

use crate::noise::Noise;
use launch::Launch;
use pattern::{Aim, FIRING_NS, LINES, Pattern};
use returns::{Echo, RANGE};

/// Rays in a scan.
pub const RAYS: usize = 20_000;
/// Duration of a scan, nanoseconds.
pub const SCAN_NS: u64 = 100_000_000;

/// The sensor.
#[derive(Debug)]
pub struct Lidar {
    noise: Noise,
    pattern: Pattern,
    /// Firings since the start.
    fired: u64,
    aims: Vec<Aim>,
    launch: Launch,
    /// Rays ordered by where they point, so that packets are of a kind.
    order: Vec<u32>,
    buckets: Vec<u16>,
    echoes: Vec<Option<Echo>>,
}

impl Lidar {
    /// A sensor whose noise is drawn from `noise`.
    pub fn new(noise: Noise) -> Self {
        let nowhere = Aim { direction: [0.0; 3], turn: 0.0, elevation: 0.0 };
        Self {
            noise,
            pattern: Pattern::new(),
            fired: 0,
            aims: vec![nowhere; RAYS],
            launch: Launch::default(),
            order: vec![0; RAYS],
            buckets: vec![0; RAYS],
            echoes: vec![None; RAYS],
        }
    }

    /// The scan that began at `stamp`. `poses` are those of the sensor in `map` at equal times from the scan's first
    /// instant to its last; at least two.
    pub fn scan(&mut self, caster: &RayCaster, stamp: SimTime, poses: &[Pose3]) -> LidarScan {
        self.aim();
        self.cast(caster, poses);
        let mut points = Vec::with_capacity(RAYS);
        points.extend((0..RAYS).filter_map(|ray| self.measure(ray)));
        LidarScan { stamp, points }
    }

    /// True ranges of the next scan's rays in the order of firing, 0 for nothing, holes in leaves not regarded: for comparing speeds.
    pub fn ranges(&mut self, tree: &TriangleBvh, poses: &[Pose3]) -> Vec<f32> {
        self.aim();
        self.launch.set(&self.aims, poses);
        let mut ranges = vec![0.0; RAYS];
        for group in self.order.chunks(LANES) {
            let hits = tree.cast_packet(&self.packet(group));
            for (lane, &ray) in group.iter().enumerate() {
                if hits.triangle[lane] != MISS {
                    ranges[ray as usize] = hits.distance[lane];
                }
            }
        }
        ranges
    }

    /// Sets the directions of the next scan's rays.
    fn aim(&mut self) {
        let mut begins = [0_u32; BUCKETS + 1];
        for (firing, aims) in self.aims.chunks_exact_mut(LINES).enumerate() {
            aims.copy_from_slice(&self.pattern.firing(self.fired + firing as u64));
        }
        self.fired += (RAYS / LINES) as u64;
        for (slot, aim) in self.buckets.iter_mut().zip(&self.aims) {
            let bucket = bucket(aim);
            *slot = bucket as u16;
            begins[bucket + 1] += 1;
        }
        for bucket in 0..BUCKETS {
            begins[bucket + 1] += begins[bucket];
        }
        for (ray, bucket) in self.buckets.iter().enumerate() {
            let slot = &mut begins[usize::from(*bucket)];
            self.order[*slot as usize] = ray as u32;
            *slot += 1;
        }
    }

    fn cast(&mut self, caster: &RayCaster, poses: &[Pose3]) {
        self.launch.set(&self.aims, poses);
        for group in self.order.chunks(LANES) {
            let packet = self.packet(group);
            let hits = caster.cast_packet(&packet);
            for (lane, &ray) in group.iter().enumerate() {
                self.echoes[ray as usize] = (hits.triangle[lane] != MISS).then(|| {
                    let surface = caster.surface(hits.triangle[lane]);
                    let along = (0..3).map(|axis| surface.normal[axis] * packet.direction[axis][lane]);
                    Echo {
                        range: hits.distance[lane],
                        cosine: along.sum::<f32>().abs().min(1.0),
                        reflectivity: surface.reflectivity,
                    }
                });
            }
        }
    }

    /// The rays of a group.
    #[inline]
    fn packet(&self, group: &[u32]) -> RayPacket {
        let mut packet = RayPacket::idle();
        for (lane, &ray) in group.iter().enumerate() {
            let (origin, direction) = self.launch.ray(ray as usize);
            packet.set(lane, origin, direction, RANGE.1);
        }
        packet
    }

    /// What the sensor reports of one ray: its range with noise, or nothing.
    fn measure(&mut self, ray: usize) -> Option<LidarPoint> {
        // Drawn for every ray, so that what one ray meets does not change the noise of the next.
        let (noise, chance) = self.noise.quick_normal_and_uniform();
        let echo = self.echoes[ray].filter(|echo| chance < echo.detection())?;
        let range = (echo.range + echo.deviation() * noise).max(RANGE.0);
        Some(LidarPoint {
            xyz: self.aims[ray].direction.map(|c| c * range),
            offset_ns: ((ray / LINES) as u64 * FIRING_NS) as u32,
            reflectivity: echo.reflectivity,
            line: (ray % LINES) as u8,
        })
    }
}

const BUCKET_COLUMNS: usize = 72;
const BUCKET_ROWS: usize = 16;
const BUCKETS: usize = BUCKET_COLUMNS * BUCKET_ROWS;

/// Elevations between which rays point, radians, with a little room.
const ELEVATION: (f32, f32) = (-0.13, 0.92);

fn bucket(aim: &Aim) -> usize {
    let column = ((aim.turn * BUCKET_COLUMNS as f32) as usize).min(BUCKET_COLUMNS - 1);
    let height = (aim.elevation - ELEVATION.0) / (ELEVATION.1 - ELEVATION.0);
    let row = ((height * BUCKET_ROWS as f32) as usize).min(BUCKET_ROWS - 1);
    // Up one column, down the next: a packet that ends one column begins the next beside it.
    column * BUCKET_ROWS + if column.is_multiple_of(2) { row } else { BUCKET_ROWS - 1 - row }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, UnitQuaternion, Vector3};
    use openbench_scene::scene::Layer;
    use openbench_scene::{Material, SceneBuilder, SemanticClass};
    use std::sync::Arc;

    fn room(half: f64) -> RayCaster {
        let mut builder = SceneBuilder::new();
        let wall = builder.material(Material::plain(SemanticClass::Wall, [0.5; 3]));
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        for (corner, u) in [((-half, -half), x), ((half, -half), y), ((-half, half), x), ((-half, -half), y)]
        {
            let origin = Point3::new(corner.0, corner.1, -1.0);
            builder.rectangle(Layer::Visible, wall, origin, (u * 2.0 * half, z * 100.0), [1.0; 2]);
        }
        RayCaster::new(Arc::new(builder.build()))
    }

    #[test]
    fn walls_lie_where_they_are_and_noise_is_of_two_centimetres() {
        let caster = room(5.0);
        let poses = vec![Pose3::identity(); 3];
        let scan = Lidar::new(Noise::new(1, 1)).scan(&caster, SimTime::ZERO, &poses);
        assert!(scan.points.len() > RAYS * 90 / 100, "{}", scan.points.len());
        let errors: Vec<f32> = scan.points.iter().map(|p| p.xyz[0].abs().max(p.xyz[1].abs()) - 5.0).collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f32>() / errors.len() as f32).sqrt();
        assert!((0.012..0.03).contains(&rms), "{rms}");
    }

    #[test]
    fn each_point_is_seen_from_the_pose_of_its_own_instant() {
        // Turning by half a radian during the scan: undone point by point, the walls are straight again.
        let caster = room(5.0);
        let pose = |s: f64| {
            Pose3::from_parts(Vector3::zeros().into(), UnitQuaternion::from_euler_angles(0.0, 0.0, 0.5 * s))
        };
        let poses: Vec<Pose3> = (0..=40).map(|i| pose(f64::from(i) / 40.0)).collect();
        let scan = Lidar::new(Noise::new(1, 1)).scan(&caster, SimTime::ZERO, &poses);
        for p in &scan.points {
            let at = pose(f64::from(p.offset_ns) / SCAN_NS as f64);
            let q = at * Point3::from(p.xyz.map(f64::from));
            assert!((q.x.abs().max(q.y.abs()) - 5.0).abs() < 0.15, "{q}");
        }
    }

    #[test]
    fn scans_do_not_repeat() {
        let caster = room(5.0);
        let mut lidar = Lidar::new(Noise::new(1, 1));
        let poses = vec![Pose3::identity(); 2];
        let (a, b) = (lidar.scan(&caster, SimTime::ZERO, &poses), lidar.scan(&caster, SimTime::ZERO, &poses));
        assert!(a.points.iter().zip(&b.points).all(|(p, q)| p.xyz != q.xyz));
    }
}
