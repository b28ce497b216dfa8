//! The map: space in cubes of three sizes, and in each the plane that its points lie on.
//!
//! After C. Yuan, W. Xu, X. Liu, X. Hong, F. Zhang, *Efficient and Probabilistic Adaptive Voxel Mapping for Accurate Online LiDAR Odometry*, 2022: a point is looked
//! up, not searched for; a plane is known the better the more points it has, and says how well. Here no points are kept, only their
//! number, sum and second moments, from which the plane follows.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Sides of cubes, metres, the largest first: the largest cube whose points lie on a plane counts.
const SIDES: [f64; 3] = [1.0, 0.5, 0.25];
/// A plane has that many points at least.
const FEW: u32 = 8;
/// Cubes with that many points take no more: what is known better is not known better by more of them, and a wall stays where it was seen first.
const FULL: u32 = 400;
/// Points lie on a plane if they are no farther from it, metres (one deviation),
const THICK: f64 = 0.04;
/// and so many times farther spread along it in its narrower direction.
const FLAT: f64 = 3.0;

/// A plane that points lie on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Of unit length.
    pub normal: Vector3<f64>,
    /// The middle of its points.
    pub middle: Vector3<f64>,
    /// Directions along it.
    along: [Vector3<f64>; 2],
    /// Variances of its points along these directions, m².
    spread: [f64; 2],
    /// Variance of its points across it, m².
    pub thickness: f64,
    /// How many they are.
    count: f64,
}

impl Plane {
    /// How far a point is from it, on the side of the normal above 0.
    pub fn distance(&self, point: Vector3<f64>) -> f64 {
        self.normal.dot(&(point - self.middle))
    }

    /// How uncertain the plane is at a point, m²: the variance of a regression there.
    pub fn variance(&self, point: Vector3<f64>) -> f64 {
        let offset = point - self.middle;
        let lever = |i: usize| {
            let distance = self.along[i].dot(&offset);
            distance * distance / self.spread[i]
        };
        self.thickness / self.count * (1.0 + lever(0) + lever(1))
    }
}

/// Points of a cube.
#[derive(Debug, Clone, Copy, Default)]
struct Cube {
    count: u32,
    /// How many they were when the plane was fitted.
    fitted: u32,
    /// Relative to the cube's middle.
    sum: Vector3<f64>,
    /// Of products xx, xy, xz, yy, yz, zz.
    moments: [f64; 6],
    plane: Option<Plane>,
}

impl Cube {
    /// Takes a point in; `middle` is the cube's.
    fn add(&mut self, point: Vector3<f64>, middle: Vector3<f64>) {
        if self.count >= FULL {
            return;
        }
        let p = point - middle;
        self.count += 1;
        self.sum += p;
        let products = [p.x * p.x, p.x * p.y, p.x * p.z, p.y * p.y, p.y * p.z, p.z * p.z];
        self.moments.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
        // Each time a third more than before.
        if self.count >= FEW && 3 * self.count >= 4 * self.fitted {
            self.fit(middle);
        }
    }

    fn fit(&mut self, middle: Vector3<f64>) {
        let count = f64::from(self.count);
        self.fitted = self.count;
        let mean = self.sum / count;
        let [xx, xy, xz, yy, yz, zz] = self.moments.map(|sum| sum / count);
        let moments = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let eigen = SymmetricEigen::new(moments - mean * mean.transpose());
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        let [thickness, narrow, wide] = order.map(|i| eigen.eigenvalues[i].max(0.0));
        let direction = |i: usize| eigen.eigenvectors.column(order[i]).into_owned();
        let flat = thickness < THICK * THICK && narrow > FLAT * FLAT * thickness.max(1e-5);
        self.plane = flat.then(|| Plane {
            normal: direction(0),
            middle: middle + mean,
            along: [direction(1), direction(2)],
            spread: [narrow, wide],
            // Points on a line of sight or two lie on any plane: of three degrees of freedom none is left to them.
            thickness: thickness * count / (count - 3.0),
            count,
        });
    }
}

/// Mixes the bits of cubes' numbers; what is looked up comes from our own arithmetic.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u64(u64::from(*byte)));
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
#[derive(Debug, Clone, Default)]
pub struct PlaneMap {
    cubes: [Cubes; SIDES.len()],
}

/// The number of the cube that holds a point, and the cube's middle; `None` a million cubes from the origin.
fn cube_of(point: Vector3<f64>, side: f64) -> Option<(u64, Vector3<f64>)> {
    const HALF: f64 = (1 << 20) as f64;
    let cell = point.map(|x| libm::floor(x / side));
    if !cell.iter().all(|x| x.abs() < HALF) {
        return None;
    }
    let number = cell.iter().fold(0, |number, x| number << 21 | (x + HALF) as u64);
    Some((number, cell.map(|x| (x + 0.5) * side)))
}

impl PlaneMap {
    /// Takes a point in.
    pub fn add(&mut self, point: Vector3<f64>) {
        for (cubes, side) in self.cubes.iter_mut().zip(SIDES) {
            if let Some((number, middle)) = cube_of(point, side) {
                cubes.entry(number).or_default().add(point, middle);
            }
        }
    }

    /// The plane of the largest cube round a point whose points lie on one, with that cube's number.
    pub fn find(&self, point: Vector3<f64>) -> Option<(u64, &Plane)> {
        self.cubes.iter().zip(SIDES).enumerate().find_map(|(size, (cubes, side))| {
            let (number, _) = cube_of(point, side)?;
            let plane = cubes.get(&number)?.plane.as_ref()?;
            // Numbers have 63 bits; of different sizes they need only differ most of the time near one place.
            Some((number ^ (size as u64) << 62, plane))
        })
    }

    /// Forgets what is farther than so many metres from a place along some axis.
    pub fn forget(&mut self, place: Vector3<f64>, distance: f64) {
        const HALF: i64 = 1 << 20;
        for (cubes, side) in self.cubes.iter_mut().zip(SIDES) {
            cubes.retain(|number, _| {
                (0..3).all(|axis| {
                    let cell = (number >> (42 - 21 * axis) & ((1 << 21) - 1)) as i64 - HALF;
                    ((cell as f64 + 0.5) * side - place[axis]).abs() <= distance
                })
            });
        }
    }

    /// Number of cubes of all sizes.
    pub fn len(&self) -> usize {
        self.cubes.iter().map(HashMap::len).sum()
    }

    /// Whether it is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a slope, a little off it now and then.
    fn slope() -> PlaneMap {
        let mut map = PlaneMap::default();
        for i in 0..4000 {
            let (x, y) = (f64::from(i % 63) / 21.0 - 1.5, f64::from(i / 63) / 21.0 - 1.5);
            let off = f64::from(i * 7 % 5 - 2) * 0.002;
            map.add(Vector3::new(x, y, 0.1 * x + 0.3 + off));
        }
        map
    }

    #[test]
    fn points_on_a_slope_make_its_plane() {
        let map = slope();
        let plane = map.find(Vector3::new(0.4, -0.3, 0.33)).unwrap().1;
        let normal = Vector3::new(-0.1, 0.0, 1.0).normalize();
        assert!((plane.normal.dot(&normal).abs() - 1.0).abs() < 1e-5, "{plane:?}");
        assert!(plane.distance(Vector3::new(0.4, -0.3, 0.34)).abs() < 1e-3);
        // 1.4 times two millimetres, and known ten times better than that.
        assert!((plane.thickness.sqrt() - 0.0028).abs() < 5e-4, "{}", plane.thickness.sqrt());
        assert!(plane.variance(plane.middle).sqrt() < 5e-4);
        assert!(plane.variance(plane.middle + plane.along[0]) > plane.variance(plane.middle));
        assert!(map.find(Vector3::new(5.0, 0.0, 0.5)).is_none());
    }

    #[test]
    fn what_is_far_is_forgotten_and_what_is_nowhere_is_not_taken() {
        let mut map = slope();
        let before = map.len();
        map.add(Vector3::new(f64::NAN, 0.0, 0.0));
        map.add(Vector3::new(1e9, 0.0, 0.0));
        assert_eq!(map.len(), before);
        map.forget(Vector3::new(0.0, 0.0, 0.0), 1.0);
        assert!(map.len() < before && map.find(Vector3::new(0.4, -0.3, 0.34)).is_some());
        map.forget(Vector3::new(100.0, 0.0, 0.0), 50.0);
        assert!(map.is_empty());
    }

    #[test]
    fn a_corner_has_planes_in_small_cubes_only() {
        let mut map = PlaneMap::default();
        for i in 0..10_000 {
            // All over the walls, as rays are.
            let i = i * 7919 % 10_000;
            let (a, b) = (f64::from(i % 100) / 100.0, f64::from(i / 100) / 100.0);
            map.add(Vector3::new(a, b, 0.005));
            map.add(Vector3::new(0.005, a, b));
        }
        // The largest cube holds both.
        let middle = Vector3::new(0.5, 0.5, 0.5);
        assert!(map.cubes[0][&cube_of(middle, 1.0).unwrap().0].plane.is_none());
        let wall = map.find(Vector3::new(0.005, 0.6, 0.6)).unwrap().1;
        assert!(wall.normal.x.abs() > 0.99);
        let floor = map.find(Vector3::new(0.6, 0.6, 0.005)).unwrap().1;
        assert!(floor.normal.z.abs() > 0.99);
    }
}
