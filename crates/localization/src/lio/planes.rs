//! The map: space in cubes of three sizes, and in each the plane that its points lie on.
//!
//! After C. Yuan, W. Xu, X. Liu, X. Hong, F. Zhang, *Efficient and Probabilistic Adaptive Voxel Mapping for Accurate Online LiDAR Odometry*, 2022: a point is looked
//! up, not searched for; a plane is known the better the more points it has, and says how well. Here no points are kept, only their
//! number, sum and second moments, from which the plane follows.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use nalgebra::{Isometry3, Matrix3, SymmetricEigen, Vector3};

use super::moments::Moments;
use super::update::LidarNoise;

/// Sides of cubes, metres, the largest first: the largest cube whose points lie on a plane counts.
pub(super) const SIDES: [f64; SIZES] = [1.0, 0.5, 0.25];
/// How many sizes there are; each is half as large as the one before.
pub const SIZES: usize = 3;
/// Where the grid's corner is, metres: the ground that the robot stands on at the start, and all that is level with it, is far from the faces of cubes of each size. Points of a
/// surface along a face are dealt to both sides by their noise, and each side's plane leans away from the surface.
pub(super) const CORNER: f64 = 0.375;
/// A plane has that many points at least.
const FEW: f64 = 8.0;
/// Cubes with that many points take no more: what is known better is not known better by more of them, and a wall stays where it was seen first.
const FULL: f64 = 2000.0;
/// Nothing built is as even as many points make it seem, metres: no plane is known better than that (one deviation).
const EVEN: f64 = 0.005;
/// Nor is it known better than that part of the variance of its points beyond the LiDAR's noise.
/// Leaves, cars and whatever else is no plane are seen elsewhere by each scan; noise averages out.
/// Chosen together with [`FLAT`] on thirteen drives of three minutes (ten windows of two towns, the
/// built-in worlds) and five of 450 to 800 m in four of these windows. Compared with counting the
/// noise as unevenness, errors on the ground are 0.88 and 0.71 as large, and the mean NEES is 5.2
/// and 5.0 instead of 3.6 and 4.9.
const UNEVEN: f64 = 0.5;
/// What a LiDAR is known to be like counts as much as that many points.
const BELIEF: f64 = 10.0;
/// Points lie on a plane if they are no farther from it, metres (one deviation),
const THICK: f64 = 0.04;
/// and so many times farther spread along it in its narrower direction. On the drives of [`UNEVEN`]
/// errors are 0.79 and 0.85 as large with 3, 1.02 and 0.69 with 5, and 1.01 on the long ones with 7.
const FLAT: f64 = 4.0;

/// A plane that points lie on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Of unit length, towards where the points were seen from.
    pub normal: Vector3<f64>,
    /// The middle of its points.
    pub middle: Vector3<f64>,
    /// Directions along it.
    along: [Vector3<f64>; 2],
    /// Variances of its points along these directions, m².
    spread: [f64; 2],
    /// Variance of its points across it, m².
    pub thickness: f64,
    /// Variance of the plane that no number of points makes better, m².
    uneven: f64,
    /// How many they are.
    count: f64,
}

impl Plane {
    /// How far a point is from it, on the side of the normal above 0.
    pub fn distance(&self, point: Vector3<f64>) -> f64 {
        self.normal.dot(&(point - self.middle))
    }

    /// In which ways the plane may be off: shifted along its normal, and leaning about each of its two directions. Each as what a point is multiplied by, so that (p - middle)
    /// times it and its shift is how far the plane is off at p, with its variance, m².
    pub(super) fn errors(&self) -> [(Vector3<f64>, f64, f64); 3] {
        let variance = self.uneven + self.thickness / self.count;
        let leaning = |i: usize| (self.along[i], 0.0, variance / self.spread[i]);
        [(Vector3::zeros(), 1.0, variance), leaning(0), leaning(1)]
    }

    /// Covariance of the normal.
    pub fn normal_covariance(&self) -> Matrix3<f64> {
        let variance = self.uneven + self.thickness / self.count;
        let along =
            |i: usize| self.along[i] * self.along[i].transpose() * (variance / self.spread[i]);
        along(0) + along(1)
    }

    /// How uncertain the plane is at a point, m²: the variance of a regression there, and what no regression makes better.
    pub fn variance(&self, point: Vector3<f64>) -> f64 {
        let offset = point - self.middle;
        let lever = |i: usize| {
            let distance = self.along[i].dot(&offset);
            distance * distance / self.spread[i]
        };
        self.uneven + self.thickness / self.count * (1.0 + lever(0) + lever(1))
    }
}

/// Points of a cube.
#[derive(Debug, Clone, Copy, Default)]
struct Cube {
    /// How many they were when the plane was fitted.
    fitted: f64,
    /// Relative to the cube's middle.
    points: Moments,
    /// Of those that are not yet put right for the angle that rays meet the plane under, how many they are and the sum of their ways from the LiDAR.
    raw: (f64, Vector3<f64>),
    /// Of those that are, the sum of the variances across the plane that the LiDAR's noise gives
    /// them, m².
    noisy: f64,
    /// The sum of their directions to the LiDAR, of unit length each.
    towards: Vector3<f64>,
    plane: Option<Plane>,
}

impl Cube {
    /// Takes points in, relative to the cube's `middle` as is the LiDAR.
    fn add(
        &mut self,
        points: &Moments,
        rays: Rays,
        lidar: Vector3<f64>,
        middle: Vector3<f64>,
        noise: &LidarNoise,
    ) {
        if self.points.weight >= FULL {
            return;
        }
        self.points.merge(points);
        let direction = (lidar - points.mean())
            .try_normalize(0.0)
            .unwrap_or_default();
        self.towards += direction * points.weight;
        match rays {
            Rays::Right(variance) => self.noisy += variance * points.weight,
            Rays::Raw(ray) => {
                self.raw.0 += points.weight;
                self.raw.1 += ray * points.weight;
            }
        }
        // Each time a third more than before.
        if self.points.weight >= FEW && 3.0 * self.points.weight >= 4.0 * self.fitted {
            self.fit(middle, noise);
        }
    }

    /// Whether the LiDAR is where it cannot see the plane.
    fn is_seen_from_behind(&self, lidar: Vector3<f64>) -> bool {
        self.plane.is_some_and(|plane| plane.distance(lidar) < 0.0)
    }

    fn fit(&mut self, middle: Vector3<f64>, noise: &LidarNoise) {
        let count = self.points.weight;
        self.fitted = count;
        let eigen = SymmetricEigen::new(self.points.covariance());
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        let [thickness, narrow, wide] = order.map(|i| eigen.eigenvalues[i].max(0.0));
        let direction = |i: usize| eigen.eigenvectors.column(order[i]).into_owned();
        let flat = thickness < THICK * THICK && narrow > FLAT * FLAT * thickness.max(1e-5);
        let across = direction(0);
        let normal = if across.dot(&self.towards) < 0.0 {
            -across
        } else {
            across
        };
        if flat {
            self.put_right(normal, noise);
        }
        self.plane = flat.then(|| Plane {
            normal,
            middle: middle + self.points.mean(),
            along: [direction(1), direction(2)],
            spread: [narrow, wide],
            // Three degrees of freedom of the points went into the plane; what few of them say about their own noise counts little.
            thickness: (thickness * count + BELIEF * noise.range * noise.range)
                / (count - 3.0 + BELIEF),
            count,
            uneven: EVEN * EVEN + UNEVEN * (thickness - self.noisy / count).max(0.0),
        });
    }

    /// Moves points to where they are on average, now that the plane's normal is known.
    fn put_right(&mut self, normal: Vector3<f64>, noise: &LidarNoise) {
        let (count, sum) = std::mem::take(&mut self.raw);
        if count > 0.0 {
            let ray = sum / count;
            let along = normal.dot(&ray);
            self.noisy += noise.across(along, ray.norm_squared().max(1e-6)) * count;
            let too_far = normal * (along * grazing(along, ray.norm_squared(), noise));
            let shift = -too_far * (count / self.points.weight);
            self.points = self
                .points
                .moved(&Isometry3::translation(shift.x, shift.y, shift.z));
        }
    }
}

/// Flatter than that no ray meets a plane, as the square of an angle.
const FLATTEST: f64 = 1e-5;

/// Whether points were put right for the angle that rays meet their plane under.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rays {
    /// They were; the variance across the plane that the LiDAR's noise gives each on average, m².
    Right(f64),
    /// They could not be, since no plane was known yet; the way from the LiDAR to their middle.
    Raw(Vector3<f64>),
}

/// Which part too far off points on a plane seem to be, on average.
///
/// A direction that is off by ε, under an angle α to the plane, meets it at the range h / sin(α + ε), so that the point is told to be sin α / sin(α + ε)
/// times as far from the sensor's height as it should be: 1 + σ² / α² times on average. Far off on level ground that is millimetres, always downwards, and the map would
/// bend. `along` is how far the point is from the LiDAR along the plane's normal, `squared` how far in all, squared.
pub(super) fn grazing(along: f64, squared: f64, noise: &LidarNoise) -> f64 {
    noise.angle * noise.angle / (along * along / squared.max(1e-6)).max(FLATTEST)
}

/// Mixes the bits of cubes' numbers; what is looked up comes from our own arithmetic.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes
            .iter()
            .for_each(|byte| self.write_u64(u64::from(*byte)));
    }

    fn write_u64(&mut self, number: u64) {
        let mixed = (self.0 ^ number).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 = mixed ^ (mixed >> 32);
    }
}

/// Tables by numbers of cubes.
pub(super) type ByCube<T> = HashMap<u64, T, BuildHasherDefault<Mix>>;
type Cubes = ByCube<Cube>;

/// The map.
///
/// A surface is seen from one side. Where the LiDAR is behind a cube's plane, the cube's points are not on that surface,
/// however near they are to it: beside the corner of a house, the points of one wall near the edge pass for points of the
/// other, all of them on the same side of it, and would pull the pose along. What is seen from behind has cubes of its
/// own.
#[derive(Debug, Clone)]
pub struct PlaneMap {
    /// Of each size of [`SIDES`].
    cubes: [Cubes; SIZES],
    /// What is seen of cubes from behind their planes.
    backs: [Cubes; SIZES],
    /// What points are expected to be off by.
    noise: LidarNoise,
}

/// A cube of the map's grid of one size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Which size.
    pub size: usize,
    /// Which cube of that size.
    number: u64,
    /// Its middle.
    pub middle: Vector3<f64>,
}

impl Place {
    /// The cube of a size that holds a point; `None` a million cubes from the origin.
    pub fn of(point: Vector3<f64>, size: usize) -> Option<Self> {
        const HALF: f64 = (1 << 20) as f64;
        let cell = point.map(|x| libm::floor((x - CORNER) / SIDES[size]));
        if !cell.iter().all(|x| x.abs() < HALF) {
            return None;
        }
        let number = cell
            .iter()
            .fold(0, |number, x| number << 21 | (x + HALF) as u64);
        Some(Self {
            size,
            number,
            middle: cell.map(|x| (x + 0.5) * SIDES[size] + CORNER),
        })
    }
}

/// What is known of a cube.
#[derive(Debug, Clone, Copy)]
pub(super) struct Looked<'a> {
    /// The plane of its points, if they lie on one.
    pub(super) plane: Option<&'a Plane>,
    /// Whether there is a plane and it takes no more points.
    pub(super) full: bool,
}

impl PlaneMap {
    /// An empty map of a LiDAR's points.
    pub fn new(noise: LidarNoise) -> Self {
        Self {
            cubes: Default::default(),
            backs: Default::default(),
            noise,
        }
    }

    /// Takes points of one cube in; they and where the LiDAR was are relative to its middle. If the cube has a plane, the
    /// share of its points that these are.
    pub fn add(
        &mut self,
        place: &Place,
        points: &Moments,
        rays: Rays,
        lidar: Vector3<f64>,
    ) -> Option<f64> {
        let front = self.cubes[place.size].entry(place.number).or_default();
        let cube = if front.is_seen_from_behind(lidar + place.middle) {
            self.backs[place.size].entry(place.number).or_default()
        } else {
            front
        };
        let before = cube.points.weight;
        cube.add(points, rays, lidar, place.middle, &self.noise);
        cube.plane
            .map(|_| (cube.points.weight - before) / cube.points.weight)
    }

    /// The plane of a cube's points, if they lie on one; as seen from where the LiDAR is.
    pub fn plane(&self, place: &Place, lidar: Vector3<f64>) -> Option<&Plane> {
        self.look(place, lidar)?.plane
    }

    /// What is known of a cube that has points; as seen from where the LiDAR is.
    pub(super) fn look(&self, place: &Place, lidar: Vector3<f64>) -> Option<Looked<'_>> {
        let mut cube = self.cubes[place.size].get(&place.number)?;
        if cube.is_seen_from_behind(lidar) {
            cube = self.backs[place.size].get(&place.number)?;
        }
        // A cube without a plane is not passed over, since its points are no part of what is known.
        let full = cube.plane.is_some() && cube.points.weight >= FULL;
        Some(Looked {
            plane: cube.plane.as_ref(),
            full,
        })
    }

    /// Forgets what is farther than so many metres from a place along some axis.
    pub fn forget(&mut self, place: Vector3<f64>, distance: f64) {
        const HALF: i64 = 1 << 20;
        let sides = SIDES.iter().chain(&SIDES);
        for (cubes, side) in self.cubes.iter_mut().chain(&mut self.backs).zip(sides) {
            cubes.retain(|number, _| {
                (0..3).all(|axis| {
                    let cell = (number >> (42 - 21 * axis) & ((1 << 21) - 1)) as i64 - HALF;
                    ((cell as f64 + 0.5) * side + CORNER - place[axis]).abs() <= distance
                })
            });
        }
    }

    /// Number of cubes of all sizes.
    pub fn len(&self) -> usize {
        self.cubes.iter().chain(&self.backs).map(HashMap::len).sum()
    }

    /// Whether it is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the LiDAR is in most tests.
    const LIDAR: Vector3<f64> = Vector3::new(5.0, 4.0, 3.0);

    fn add(map: &mut PlaneMap, point: Vector3<f64>) {
        add_from(map, point, LIDAR);
    }

    fn add_from(map: &mut PlaneMap, point: Vector3<f64>, lidar: Vector3<f64>) {
        for place in (0..SIZES).filter_map(|size| Place::of(point, size)) {
            let mut points = Moments::default();
            points.add(point - place.middle, 1.0);
            map.add(&place, &points, Rays::Right(0.0), lidar - place.middle);
        }
    }

    fn plane(map: &PlaneMap, point: Vector3<f64>) -> Option<&Plane> {
        plane_from(map, point, LIDAR)
    }

    fn plane_from(map: &PlaneMap, point: Vector3<f64>, lidar: Vector3<f64>) -> Option<&Plane> {
        (0..SIZES).find_map(|size| map.plane(&Place::of(point, size)?, lidar))
    }

    /// Points on a slope, a little off it now and then.
    fn slope() -> PlaneMap {
        let mut map = PlaneMap::new(LidarNoise {
            range: 0.003,
            angle: 0.001,
        });
        for i in 0..4000 {
            let (x, y) = (
                f64::from(i % 63) / 21.0 - 1.5,
                f64::from(i / 63) / 21.0 - 1.5,
            );
            let off = f64::from(i * 7 % 5 - 2) * 0.002;
            add(&mut map, Vector3::new(x, y, 0.1 * x + 0.3 + off));
        }
        map
    }

    #[test]
    fn points_on_a_slope_make_its_plane() {
        let map = slope();
        let plane = plane(&map, Vector3::new(0.4, -0.3, 0.33)).unwrap();
        let normal = Vector3::new(-0.1, 0.0, 1.0).normalize();
        assert!(
            (plane.normal.dot(&normal).abs() - 1.0).abs() < 1e-5,
            "{plane:?}"
        );
        assert!(plane.distance(Vector3::new(0.4, -0.3, 0.34)).abs() < 1e-3);
        // 1.4 times two millimetres.
        assert!(
            (plane.thickness.sqrt() - 0.0028).abs() < 5e-4,
            "{}",
            plane.thickness.sqrt()
        );
        assert!((EVEN..EVEN + 1e-3).contains(&plane.variance(plane.middle).sqrt()));
        assert!(plane.variance(plane.middle + plane.along[0]) > plane.variance(plane.middle));
        assert!(super::tests::plane(&map, Vector3::new(5.0, 0.0, 0.5)).is_none());
    }

    #[test]
    fn what_is_far_is_forgotten_and_what_is_nowhere_is_not_taken() {
        let mut map = slope();
        let before = map.len();
        add(&mut map, Vector3::new(f64::NAN, 0.0, 0.0));
        add(&mut map, Vector3::new(1e9, 0.0, 0.0));
        assert_eq!(map.len(), before);
        map.forget(Vector3::new(0.0, 0.0, 0.0), 1.0);
        assert!(map.len() < before && plane(&map, Vector3::new(0.4, -0.3, 0.34)).is_some());
        map.forget(Vector3::new(100.0, 0.0, 0.0), 50.0);
        assert!(map.is_empty());
    }

    #[test]
    fn a_corner_has_planes_in_small_cubes_only() {
        let mut map = PlaneMap::new(LidarNoise {
            range: 0.01,
            angle: 0.001,
        });
        for i in 0..10_000 {
            // All over the walls, as rays are.
            let i = i * 7919 % 10_000;
            let (a, b) = (f64::from(i % 100) / 100.0, f64::from(i / 100) / 100.0);
            add(&mut map, Vector3::new(a, b, 0.005));
            add(&mut map, Vector3::new(0.005, a, b));
        }
        // The largest cube holds both.
        let middle = Vector3::new(0.5, 0.5, 0.5);
        assert!(map.plane(&Place::of(middle, 0).unwrap(), LIDAR).is_none());
        let wall = plane(&map, Vector3::new(0.005, 0.6, 0.6)).unwrap();
        assert!(wall.normal.x.abs() > 0.99);
        let floor = plane(&map, Vector3::new(0.6, 0.6, 0.005)).unwrap();
        assert!(floor.normal.z.abs() > 0.99);
    }

    #[test]
    fn a_wall_has_two_sides() {
        let mut map = PlaneMap::new(LidarNoise {
            range: 0.01,
            angle: 0.001,
        });
        let (front, behind) = (Vector3::new(0.0, 5.0, 0.7), Vector3::new(0.0, -5.0, 0.7));
        for i in 0..2500 {
            let (x, z) = (f64::from(i % 50) / 25.0, f64::from(i / 50) / 25.0);
            add_from(&mut map, Vector3::new(x, 0.50, z), front);
        }
        let middle = Vector3::new(0.9, 0.5, 0.9);
        let plane = plane_from(&map, middle, front).unwrap();
        assert!(plane.normal.y > 0.99, "{plane:?}");
        assert!(plane_from(&map, middle, behind).is_none());
        let before = *plane;
        // The other side of the wall is 4 cm farther back.
        for i in 0..2500 {
            let (x, z) = (f64::from(i % 50) / 25.0, f64::from(i / 50) / 25.0);
            add_from(&mut map, Vector3::new(x, 0.46, z), behind);
        }
        assert_eq!(plane_from(&map, middle, front), Some(&before));
        let back = plane_from(&map, middle, behind).unwrap();
        assert!(
            back.normal.y < -0.99 && (back.middle.y - 0.46).abs() < 1e-6,
            "{back:?}"
        );
    }

    #[test]
    fn unevenness_is_what_is_beyond_the_noise() {
        let noise = LidarNoise {
            range: 0.02,
            angle: 0.001,
        };
        // Two layers of points, 4 cm apart, seen from straight ahead.
        let uneven = |rays: Rays| {
            let mut cube = Cube::default();
            let mut points = Moments::default();
            for i in 0..400 {
                let layer = f64::from(i % 2) * 0.04;
                points.add(
                    Vector3::new(f64::from(i % 20) * 0.05, f64::from(i / 20) * 0.05, layer),
                    1.0,
                );
            }
            cube.add(&points, rays, Vector3::z() * 5.0, Vector3::zeros(), &noise);
            cube.plane.unwrap().uneven
        };
        let most = EVEN * EVEN + UNEVEN * 0.02 * 0.02;
        assert!((uneven(Rays::Right(0.0)) / most - 1.0).abs() < 0.02);
        for noisy in [
            Rays::Right(0.02 * 0.02),
            Rays::Right(1.0),
            Rays::Raw(Vector3::z() * 5.0),
        ] {
            assert!(uneven(noisy) <= EVEN * EVEN, "{noisy:?}");
        }
    }
}
