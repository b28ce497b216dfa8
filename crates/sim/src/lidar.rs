//! The MID-360: four lines that sweep round and up and down without repeating, 200,000 rays a second, each cast from
//! where the sensor is at that ray's own instant.

use openbench_core::{LidarPoint, LidarScan, Pose3, SimTime};
use openbench_scene::bvh::LANES;
use openbench_scene::{Hit, RayCaster, RayPacket};

use crate::noise::Noise;

/// Rays in a scan.
pub const RAYS: usize = 20_000;
/// Duration of a scan, nanoseconds.
pub const SCAN_NS: u64 = 100_000_000;
/// Nanoseconds between two rays.
const RAY_NS: u64 = SCAN_NS / RAYS as u64;
const LINES: usize = 4;
const RANGE: (f32, f32) = (0.1, 50.0);
/// Deviation of the range, metres, at short range and normal incidence.
const RANGE_NOISE: f32 = 0.02;
/// Elevations, degrees.
const ELEVATION: (f64, f64) = (-7.2, 52.2);
/// Turns of the azimuth in the time of one ray of a line (four rays of the sensor).
const AZIMUTH_STEP: f64 = -1.0 / 291.7;
/// Periods of the elevation in that time: near the golden section of the azimuth's, so that rosettes fill evenly.
const ELEVATION_STEP: f64 = 1.0 / 472.618_034;

/// The sensor.
#[derive(Debug)]
pub struct Lidar {
    noise: Noise,
    /// Rays fired by each line since the start.
    fired: u64,
    directions: Vec<[f32; 3]>,
    /// Rays ordered by where they point, so that packets are of a kind.
    order: Vec<u32>,
    buckets: Vec<u16>,
    circle: SineTable,
    ranges: Vec<f32>,
    reflectivity: Vec<u8>,
}

impl Lidar {
    /// A sensor whose noise is drawn from `noise`.
    pub fn new(noise: Noise) -> Self {
        Self {
            noise,
            fired: 0,
            directions: vec![[0.0; 3]; RAYS],
            order: vec![0; RAYS],
            buckets: vec![0; RAYS],
            circle: SineTable::new(),
            ranges: vec![0.0; RAYS],
            reflectivity: vec![0; RAYS],
        }
    }

    /// The scan that began at `stamp`. `poses` are those of the sensor in `map` at equal times from the scan's first
    /// instant to its last; at least two.
    pub fn scan(&mut self, caster: &RayCaster, stamp: SimTime, poses: &[Pose3]) -> LidarScan {
        self.aim();
        self.cast(caster, poses);
        let points = (0..RAYS).filter_map(|ray| self.measure(ray)).collect();
        LidarScan { stamp, points }
    }

    /// Sets the directions of the next scan's rays.
    fn aim(&mut self) {
        let mut begins = [0_u32; BUCKETS + 1];
        for ray in 0..RAYS {
            let (azimuth, elevation) = direction_of(self.fired + (ray / LINES) as u64, ray % LINES);
            let ((sa, ca), (se, ce)) = (self.circle.sincos(azimuth), self.circle.sincos(elevation));
            self.directions[ray] = [(ca * ce) as f32, (sa * ce) as f32, se as f32];
            let bucket = bucket(azimuth, elevation);
            self.buckets[ray] = bucket as u16;
            begins[bucket + 1] += 1;
        }
        self.fired += (RAYS / LINES) as u64;
        for bucket in 0..BUCKETS {
            begins[bucket + 1] += begins[bucket];
        }
        for ray in 0..RAYS {
            let slot = &mut begins[usize::from(self.buckets[ray])];
            self.order[*slot as usize] = ray as u32;
            *slot += 1;
        }
    }

    fn cast(&mut self, caster: &RayCaster, poses: &[Pose3]) {
        let path = SensorPath::new(poses);
        let mut hits: [Option<Hit>; LANES] = [None; LANES];
        for group in self.order.chunks(LANES) {
            let mut packet = RayPacket::idle();
            for (lane, &ray) in group.iter().enumerate() {
                let (origin, direction) = path.ray(ray as usize, self.directions[ray as usize]);
                packet.set(lane, origin, direction, RANGE.1);
            }
            caster.cast_packet(&packet, &mut hits);
            for (lane, &ray) in group.iter().enumerate() {
                let hit = hits[lane].filter(|h| h.distance >= RANGE.0);
                self.ranges[ray as usize] = hit.map_or(0.0, |h| h.distance);
                self.reflectivity[ray as usize] = hit.map_or(0, |h| caster.material(h.triangle).reflectivity);
            }
        }
    }

    /// What the sensor reports of one ray: its range with noise, or nothing.
    fn measure(&mut self, ray: usize) -> Option<LidarPoint> {
        let noise = self.noise.quick_normal();
        let true_range = self.ranges[ray];
        if true_range <= 0.0 {
            return None;
        }
        let range = (true_range + RANGE_NOISE * noise).max(RANGE.0);
        Some(LidarPoint {
            xyz: self.directions[ray].map(|c| c * range),
            offset_ns: (ray as u64 * RAY_NS) as u32,
            reflectivity: self.reflectivity[ray],
            line: (ray % LINES) as u8,
        })
    }
}

/// Azimuth and elevation, radians, of the `count`-th ray of a line.
fn direction_of(count: u64, line: usize) -> (f64, f64) {
    let turns = count as f64 * AZIMUTH_STEP;
    let phase = count as f64 * ELEVATION_STEP + line as f64 / LINES as f64;
    let triangle = 2.0 * (phase - libm::floor(phase + 0.5)).abs();
    let elevation = ELEVATION.0 + (ELEVATION.1 - ELEVATION.0) * triangle;
    ((turns - libm::floor(turns)) * std::f64::consts::TAU, elevation.to_radians())
}

/// Sines and cosines from a table, linear in between: off by at most the square of the step over 8, 7.4e-8.
#[derive(Debug)]
struct SineTable(Vec<(f64, f64)>);

impl SineTable {
    const ENTRIES: usize = 8192;

    fn new() -> Self {
        let angle = |i: usize| i as f64 * std::f64::consts::TAU / Self::ENTRIES as f64;
        Self((0..=Self::ENTRIES).map(|i| libm::sincos(angle(i))).collect())
    }

    fn sincos(&self, angle: f64) -> (f64, f64) {
        let turns = angle / std::f64::consts::TAU;
        let at = (turns - turns.floor()) * Self::ENTRIES as f64;
        let i = (at as usize).min(Self::ENTRIES - 1);
        let (a, b, t) = (self.0[i], self.0[i + 1], at - i as f64);
        (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1))
    }
}

const BUCKET_COLUMNS: usize = 72;
const BUCKET_ROWS: usize = 16;
const BUCKETS: usize = BUCKET_COLUMNS * BUCKET_ROWS;

fn bucket(azimuth: f64, elevation: f64) -> usize {
    let column = (azimuth / std::f64::consts::TAU * BUCKET_COLUMNS as f64) as usize % BUCKET_COLUMNS;
    let low = ELEVATION.0.to_radians();
    let row = ((elevation - low) / (ELEVATION.1.to_radians() - low) * BUCKET_ROWS as f64) as usize;
    let row = row.min(BUCKET_ROWS - 1);
    // Up one column, down the next: a packet that ends one column begins the next beside it.
    column * BUCKET_ROWS + if column.is_multiple_of(2) { row } else { BUCKET_ROWS - 1 - row }
}

/// Where the sensor is during a scan, interpolated between known poses.
struct SensorPath {
    knots: Vec<([f32; 3], [f32; 9])>,
    rays_per_knot: f32,
}

impl SensorPath {
    fn new(poses: &[Pose3]) -> Self {
        let knot = |p: &Pose3| {
            let (t, r) = (p.translation.vector, p.rotation.to_rotation_matrix());
            let m = r.matrix();
            let rows = [
                m[(0, 0)],
                m[(0, 1)],
                m[(0, 2)],
                m[(1, 0)],
                m[(1, 1)],
                m[(1, 2)],
                m[(2, 0)],
                m[(2, 1)],
                m[(2, 2)],
            ];
            ([t.x as f32, t.y as f32, t.z as f32], rows.map(|c| c as f32))
        };
        let knots: Vec<_> = poses.iter().map(knot).collect();
        let rays_per_knot = RAYS as f32 / (knots.len() - 1).max(1) as f32;
        Self { knots, rays_per_knot }
    }

    /// Origin and direction in `map` of a ray that the sensor calls `direction`. Over the 2.5 ms between knots the
    /// linear blend of two rotation matrices is a rotation to 1e-6.
    fn ray(&self, ray: usize, direction: [f32; 3]) -> ([f32; 3], [f32; 3]) {
        let at = ray as f32 / self.rays_per_knot;
        let knot = (at as usize).min(self.knots.len().saturating_sub(2));
        let (a, b) = (&self.knots[knot], &self.knots[(knot + 1).min(self.knots.len() - 1)]);
        let s = at - knot as f32;
        let blend = |x: f32, y: f32| x + s * (y - x);
        let origin = [0, 1, 2].map(|i| blend(a.0[i], b.0[i]));
        let row =
            |r: usize| (0..3).map(|c| blend(a.1[3 * r + c], b.1[3 * r + c]) * direction[c]).sum::<f32>();
        (origin, [row(0), row(1), row(2)])
    }
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
        assert!(scan.points.len() > RAYS * 95 / 100);
        let errors: Vec<f32> = scan.points.iter().map(|p| p.xyz[0].abs().max(p.xyz[1].abs()) - 5.0).collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f32>() / errors.len() as f32).sqrt();
        assert!((0.01..0.025).contains(&rms), "{rms}");
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
            assert!((q.x.abs().max(q.y.abs()) - 5.0).abs() < 0.12, "{q}");
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
