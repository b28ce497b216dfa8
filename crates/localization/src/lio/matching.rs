//! Which points of a scan lie on which planes of the map, as sums: what a plane's points say needs no more than their moments.
//!
//! A point's distance from a plane and how it changes with the pose are linear in the point, so that all that a filter adds up over a plane's points follows from the
//! moments of these points, at whatever pose the filter has come to (Z. Liu, X. Liu, F. Zhang, *Efficient and Consistent Bundle Adjustment on Lidar Point
//! Clouds*, 2023, call them point clusters). A scan is gone through once, not once an iteration, and all its points count.

use nalgebra::{Isometry3, Matrix3, SMatrix, Vector3};

use super::moments::Moments;
use super::planes::{CORNER, Place, Plane, PlaneMap, Rays, SIDES, SIZES, grazing};
use super::scatter::Scatter;
use super::state::{Covariance, State};
use super::update::LidarNoise;

/// A residual is farther than this from what is expected, in deviations, only if something has moved there.
const GATE: f64 = 4.0;
/// Surfaces are not quite planes, metres.
const ROUGHNESS: f64 = 0.004;

/// Points of a scan in one cube, in the LiDAR's frame.
#[derive(Debug, Clone)]
pub struct Cluster {
    /// Which cube.
    pub place: Place,
    /// Each with weight 1.
    pub points: Moments,
    /// The plane that they lie on, if there is one.
    pub seen: Option<Seen>,
    /// Whether the cube takes no more points.
    full: bool,
}

/// A plane as a scan sees it.
#[derive(Debug, Clone)]
pub struct Seen {
    /// In `odom`.
    pub normal: Vector3<f64>,
    /// How far the plane is from the origin of `odom` along its normal, metres.
    pub offset: f64,
    /// The points, weighed by what each is known to across the plane, 1/m².
    pub weighed: Moments,
    /// Variance that all of them share: that of the plane at their place, m².
    pub shared: f64,
    /// How a plane that is shifted or leans moves under a point: rows that (p, 1) is multiplied by.
    pub errors: SMatrix<f64, 3, 4>,
    /// One over the variances of that, 1/m².
    pub known: Vector3<f64>,
    /// Covariance of the normal.
    pub leaning: Matrix3<f64>,
}

/// Buffers that are used again for each scan.
#[derive(Debug, Clone, Default)]
pub struct Matching {
    /// Where the points are in `odom`.
    places: Vec<Vector3<f64>>,
    /// Cubes and points' numbers, so that points of one cube stand together.
    order: Vec<u64>,
    /// The points in this order, and where they are in `odom`.
    sorted: Vec<Vector3<f64>>,
    sorted_places: Vec<Vector3<f64>>,
    rest: [Vec<u64>; SIZES],
    /// What came of it.
    pub clusters: Vec<Cluster>,
    /// Points in cubes with planes that lie on none of them.
    contradicting: usize,
    /// How noisy the LiDAR turns out to be. What passes for a point of a plane does not depend on it: a wider gate lets in what
    /// lies beside the plane.
    pub(super) scatter: Scatter,
}

/// Bits of a key: the point's number, then one bit an axis for each size below the largest, then nine an axis.
const NUMBER: u32 = 31;
const SPLITS: u32 = SIZES as u32 - 1;
const AXIS: u32 = 9;

impl Matching {
    /// Looks up a scan's points, which are in the LiDAR's frame of the state's instant; of the covariance the pose's part counts. None farther than `gate` metres from a plane lies on it.
    pub fn find(
        &mut self,
        state: &State,
        covariance: &Covariance,
        points: &[Vector3<f64>],
        map: &PlaneMap,
        noise: &LidarNoise,
        gate: f64,
    ) {
        self.sort(state, points);
        self.clusters.clear();
        let mut search = Search {
            state,
            lidar: lidar(state),
            covariance,
            points: &self.sorted,
            places: &self.sorted_places,
            map,
            noise,
            gate,
            clusters: &mut self.clusters,
            contradicting: 0,
            certainty: 1.0 / (self.scatter.factor() * self.scatter.factor()),
        };
        search.split(&self.order, 0, false, &mut self.rest);
        self.contradicting = search.contradicting;
    }

    /// Of the points where planes are known the share that lies on them; 1 where there are none.
    pub(super) fn agreeing(&self) -> f64 {
        let seen = self
            .clusters
            .iter()
            .filter(|cluster| cluster.seen.is_some());
        let agreeing: f64 = seen.map(|cluster| cluster.points.weight).sum();
        let all = agreeing + self.contradicting as f64;
        if all > 0.0 { agreeing / all } else { 1.0 }
    }

    /// Adds what was found to the map, with the scan at `state`. Of what is known now of the planes that were seen, the share that came with this scan.
    pub fn insert(&self, state: &State, map: &mut PlaneMap) -> f64 {
        let lidar = lidar(state);
        let (mut new, mut all) = (0.0, 0.0);
        for cluster in &self.clusters {
            if cluster.full {
                all += cluster.points.weight;
                continue;
            }
            let about = lidar.translation.vector - cluster.place.middle;
            let motion = Isometry3::from_parts(about.into(), lidar.rotation);
            let rays = match &cluster.seen {
                // Of points that are weighed by one over their variances the harmonic mean of these.
                Some(seen) => Rays::Right(cluster.points.weight / seen.weighed.weight),
                None => Rays::Raw(lidar.rotation * cluster.points.mean()),
            };
            if let Some(share) =
                map.add(&cluster.place, &cluster.points.moved(&motion), rays, about)
            {
                new += share * cluster.points.weight;
                all += cluster.points.weight;
            }
        }
        if all > 0.0 { new / all } else { 0.0 }
    }

    fn sort(&mut self, state: &State, points: &[Vector3<f64>]) {
        let lidar = lidar(state);
        let rotation = lidar.rotation.to_rotation_matrix();
        let cell = |p: Vector3<f64>| p.map(|x| libm::floor(x / SIDES[SIZES - 1]));
        let corner = state
            .position
            .map(|x| libm::floor((x - CORNER) / SIDES[0]) * SIDES[0] + CORNER);
        let corner = corner.map(|x| x - f64::from(1 << (AXIS - 1)) * SIDES[0]);
        self.places.clear();
        self.order.clear();
        for (number, point) in points.iter().enumerate().take(1 << NUMBER) {
            let place = rotation * point + lidar.translation.vector;
            self.places.push(place);
            let cell = cell(place - corner);
            let far = f64::from(1 << (AXIS + SPLITS));
            if cell.iter().all(|x| (0.0..far).contains(x)) {
                self.order
                    .push(key(cell.map(|x| x as u64)) << NUMBER | number as u64);
            }
        }
        self.order.sort_unstable();
        // Points that are looked at together lie together, and are numbered anew.
        self.sorted.clear();
        self.sorted_places.clear();
        for (new, key) in self.order.iter_mut().enumerate() {
            let old = number(*key);
            self.sorted.push(points[old]);
            self.sorted_places.push(self.places[old]);
            *key = *key - old as u64 + new as u64;
        }
    }
}

/// The number of a cube among those round the robot: the largest cubes first, then the parts of each.
fn key(cell: Vector3<u64>) -> u64 {
    let mut key = cell.iter().fold(0, |key, x| key << AXIS | x >> SPLITS);
    for split in (0..SPLITS).rev() {
        key = cell.iter().fold(key, |key, x| key << 1 | (x >> split & 1));
    }
    key
}

/// The LiDAR's pose in `odom`.
fn lidar(state: &State) -> Isometry3<f64> {
    let mount = Isometry3::from_parts(state.mount_position.into(), state.mount_rotation);
    Isometry3::from_parts(state.position.into(), state.rotation) * mount
}

/// What a search goes by.
struct Search<'a> {
    state: &'a State,
    lidar: Isometry3<f64>,
    covariance: &'a Covariance,
    points: &'a [Vector3<f64>],
    places: &'a [Vector3<f64>],
    map: &'a PlaneMap,
    noise: &'a LidarNoise,
    gate: f64,
    clusters: &'a mut Vec<Cluster>,
    contradicting: usize,
    certainty: f64,
}

impl Search<'_> {
    /// Goes through points in their order, cube by cube of a size; `met` if there is a plane in the larger cube round them.
    fn split(&mut self, order: &[u64], size: usize, met: bool, rest: &mut [Vec<u64>]) {
        let shift = NUMBER + 3 * (SPLITS - size as u32);
        for run in order.chunk_by(|a, b| a >> shift == b >> shift) {
            self.cube(run, size, met, rest);
        }
    }

    /// Points on the cube's plane are its own; others, and all if it has none, are looked up in smaller cubes.
    fn cube(&mut self, run: &[u64], size: usize, met: bool, rest: &mut [Vec<u64>]) {
        let Some(place) = Place::of(self.places[number(run[0])], size) else {
            return;
        };
        let (mine, below) = rest.split_at_mut(1);
        let left = &mut mine[0];
        left.clear();
        let mut points = Moments::default();
        let known = self.map.look(&place, self.lidar.translation.vector);
        let full = known.is_some_and(|known| known.full);
        let plane = known.and_then(|known| known.plane);
        let seen = plane.map(|plane| self.seen(plane, run, &mut points, left));
        if seen.is_none() {
            run.iter()
                .for_each(|key| points.add(self.points[number(*key)], 1.0));
        }
        let (met, next) = if seen.is_some() {
            (true, &left[..])
        } else {
            (met, run)
        };
        if points.weight > 0.0 {
            self.clusters.push(Cluster {
                place,
                points,
                seen,
                full,
            });
        }
        if size + 1 < SIZES {
            self.split(next, size + 1, met, below);
        } else if met {
            self.contradicting += next.len();
        }
    }

    /// Those of a cube's points that lie on its plane go into `points`, the others into `left`.
    fn seen(&self, plane: &Plane, run: &[u64], points: &mut Moments, left: &mut Vec<u64>) -> Seen {
        let gate = Gate::new(self, plane, self.places[number(run[0])]);
        let mut weighed = Moments::default();
        for key in run {
            match gate.pass(&self.points[number(*key)]) {
                Some((point, weight)) => {
                    weighed.add(point, weight);
                    points.add(point, 1.0);
                }
                None => left.push(*key),
            }
        }
        let middle = self.lidar * nalgebra::Point3::from(points.mean());
        let from_middle = self.lidar.translation.vector - plane.middle;
        let errors = plane.errors();
        let rows = errors.map(|(along, shift, _)| {
            (self.lidar.rotation.inverse() * along)
                .push(shift + along.dot(&from_middle))
                .transpose()
        });
        Seen {
            normal: plane.normal,
            offset: plane.normal.dot(&plane.middle),
            weighed,
            shared: plane.variance(middle.coords),
            errors: SMatrix::from_rows(&rows),
            known: errors.map(|(_, _, variance)| 1.0 / variance).into(),
            leaning: plane.normal_covariance(),
        }
    }
}

/// The number of a key's point.
fn number(key: u64) -> usize {
    (key & ((1 << NUMBER) - 1)) as usize
}

/// Whether points lie on a plane, in the LiDAR's frame.
struct Gate {
    normal: Vector3<f64>,
    offset: f64,
    /// What is expected beside a point's own noise, m².
    known: f64,
    noise: LidarNoise,
    /// Nothing farther off lies on it, m².
    widest: f64,
    /// What a point's weight is multiplied by.
    certainty: f64,
}

impl Gate {
    /// With what the pose's covariance says near a place in `odom`.
    fn new(search: &Search<'_>, plane: &Plane, place: Vector3<f64>) -> Self {
        let state = search.state;
        let arm = state.rotation.inverse() * (place - state.position);
        let turned = arm.cross(&(state.rotation.inverse() * plane.normal));
        let row = nalgebra::Vector6::new(
            turned.x,
            turned.y,
            turned.z,
            plane.normal.x,
            plane.normal.y,
            plane.normal.z,
        );
        let pose = search.covariance.fixed_view::<6, 6>(0, 0);
        Self {
            normal: search.lidar.rotation.inverse() * plane.normal,
            offset: plane.distance(search.lidar.translation.vector),
            known: plane.variance(place) + (row.transpose() * pose * row)[0],
            noise: *search.noise,
            widest: search.gate * search.gate,
            certainty: search.certainty,
        }
    }

    /// A point that lies on the plane, where it is on average ([`grazing`]), and one over its variance across the plane by the LiDAR's own noise, 1/m².
    fn pass(&self, point: &Vector3<f64>) -> Option<(Vector3<f64>, f64)> {
        let along = self.normal.dot(point);
        let squared = point.norm_squared().max(1e-6);
        let variance = self.noise.across(along, squared) + ROUGHNESS * ROUGHNESS;
        let residual = along + self.offset;
        let passes = residual * residual < (GATE * GATE * (variance + self.known)).min(self.widest);
        passes.then(|| {
            (
                point * (1.0 - grazing(along, squared, &self.noise)),
                self.certainty / variance,
            )
        })
    }
}
