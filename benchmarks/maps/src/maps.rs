//! The maps: ours, and two of points, of whose five nearest neighbours a plane is fitted for each point that is looked up.

use kiddo::SquaredEuclidean;
use nalgebra::{Isometry3, Matrix3, SymmetricEigen, Vector3};
use openbench_localization::lio::LidarNoise;
use openbench_localization::lio::matching::Matching;
use openbench_localization::lio::moments::Moments;
use openbench_localization::lio::planes::PlaneMap;
use openbench_localization::lio::state::{Covariance, State};
use rustc_hash::{FxHashMap, FxHashSet};

const NOISE: LidarNoise = LidarNoise {
    range: 0.02,
    angle: 0.001,
};
/// FAST-LIO2, section V: a plane is fitted to five points, none of which is farther from it than a tenth of a metre, nor farther from the point than the root of five.
const NEIGHBOURS: usize = 5;
const FARTHEST: f64 = 5.0;
const FLAT: f64 = 0.1;
/// Faster-LIO looks into so many voxels: that of the point, and those that share a face or an edge with it.
const AROUND: usize = 19;

/// Points on a plane, with their weights.
pub struct Weighed {
    pub normal: Vector3<f64>,
    pub offset: f64,
    pub points: Moments,
}

/// What scans are laid on.
pub trait Map {
    /// Which points lie on which planes, points being in the LiDAR's frame.
    fn find(&mut self, points: &[Vector3<f64>], pose: &Isometry3<f64>) -> Vec<Weighed>;
    /// Puts a scan in; `find` was asked for it before, if the map had anything.
    fn add(&mut self, points: &[Vector3<f64>], pose: &Isometry3<f64>);
    /// Number of planes or points.
    fn len(&self) -> usize;
}

/// Ours.
pub struct Planes {
    map: PlaneMap,
    matching: Matching,
}

impl Default for Planes {
    fn default() -> Self {
        Self {
            map: PlaneMap::new(NOISE),
            matching: Matching::default(),
        }
    }
}

impl Planes {
    fn look(&mut self, points: &[Vector3<f64>], pose: &Isometry3<f64>) -> State {
        let state = State::at_rest(pose, 9.8);
        let mut covariance = Covariance::zeros();
        for i in 0..6 {
            covariance[(i, i)] = super::GUESS[usize::from(i < 3)].powi(2);
        }
        self.matching.find(
            &state,
            &covariance,
            points,
            &self.map,
            &NOISE,
            f64::INFINITY,
        );
        state
    }
}

impl Map for Planes {
    fn find(&mut self, points: &[Vector3<f64>], pose: &Isometry3<f64>) -> Vec<Weighed> {
        self.look(points, pose);
        let seen = self
            .matching
            .clusters
            .iter()
            .filter_map(|cluster| cluster.plane.as_ref());
        // What is not known of a plane is shared by its points, and counts once.
        let weighed = seen.map(|seen| {
            let share = 1.0 / (1.0 + seen.shared * seen.weighted.weight);
            let mut points = seen.weighted;
            points.weight *= share;
            points.first *= share;
            points.second.iter_mut().for_each(|sum| *sum *= share);
            Weighed {
                normal: seen.normal,
                offset: seen.offset,
                points,
            }
        });
        weighed.collect()
    }

    fn add(&mut self, points: &[Vector3<f64>], pose: &Isometry3<f64>) {
        let state = self.look(points, pose);
        self.matching.insert(&state, &mut self.map);
    }

    fn len(&self) -> usize {
        self.map.len()
    }
}

type Voxel = [i32; 3];

fn voxel(point: &Vector3<f64>, side: f64) -> Voxel {
    [0, 1, 2].map(|i| (point[i] / side).floor() as i32)
}

/// The mean of the points of each voxel of a scan, as FAST-LIO2 thins it.
fn thinned(points: &[Vector3<f64>], side: f64) -> Vec<Vector3<f64>> {
    let mut number = FxHashMap::default();
    let mut sums: Vec<(Vector3<f64>, f64)> = Vec::new();
    for point in points {
        let at = *number.entry(voxel(point, side)).or_insert(sums.len());
        if at == sums.len() {
            sums.push((Vector3::zeros(), 0.0));
        }
        sums[at].0 += point;
        sums[at].1 += 1.0;
    }
    sums.iter().map(|(sum, count)| sum / *count).collect()
}

/// The plane of a point's neighbours, if they lie on one and the point near it: FAST-LIO2's rules.
fn seen(
    point: &Vector3<f64>,
    there: &Vector3<f64>,
    neighbours: &[Vector3<f64>],
) -> Option<Weighed> {
    if neighbours.len() < NEIGHBOURS {
        return None;
    }
    let mean = neighbours.iter().sum::<Vector3<f64>>() / neighbours.len() as f64;
    let spread: Matrix3<f64> = neighbours
        .iter()
        .map(|p| (p - mean) * (p - mean).transpose())
        .sum();
    let eigen = SymmetricEigen::new(spread);
    let normal = eigen
        .eigenvectors
        .column(eigen.eigenvalues.imin())
        .into_owned();
    let flat = neighbours
        .iter()
        .all(|p| normal.dot(&(p - mean)).abs() < FLAT);
    let distance = normal.dot(&(there - mean)).abs();
    if !flat || 1.0 - 0.9 * distance / point.norm().sqrt() < 0.9 {
        return None;
    }
    let mut points = Moments::default();
    points.add(*point, 1.0 / (NOISE.range * NOISE.range));
    Some(Weighed {
        normal,
        offset: normal.dot(&mean),
        points,
    })
}

/// Points in voxels that are looked up, after Faster-LIO (C. Bai et al. 2022).
pub struct Grid {
    side: f64,
    voxels: FxHashMap<Voxel, Vec<Vector3<f64>>>,
    size: usize,
}

impl Grid {
    /// Voxels and the distance of points have that size.
    pub fn new(side: f64) -> Self {
        Self {
            side,
            voxels: FxHashMap::default(),
            size: 0,
        }
    }

    fn nearest(&self, there: &Vector3<f64>, near: &mut Vec<(f64, Vector3<f64>)>) {
        // Points are a voxel apart, so that five are found in voxels of twice the size.
        let [x, y, z] = voxel(there, 2.0 * self.side);
        near.clear();
        let all =
            (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [i, j, k])));
        let around = all.filter(|[i, j, k]: &[i32; 3]| i.abs() + j.abs() + k.abs() <= 2);
        debug_assert_eq!(around.clone().count(), AROUND);
        for [i, j, k] in around {
            for point in self
                .voxels
                .get(&[x + i, y + j, z + k])
                .into_iter()
                .flatten()
            {
                near.push(((point - there).norm_squared(), *point));
            }
        }
        near.retain(|(squared, _)| *squared < FARTHEST);
        if near.len() > NEIGHBOURS {
            near.select_nth_unstable_by(NEIGHBOURS - 1, |a, b| a.0.total_cmp(&b.0));
            near.truncate(NEIGHBOURS);
        }
    }
}

impl Map for Grid {
    fn find(&mut self, points: &[Vector3<f64>], pose: &Isometry3<f64>) -> Vec<Weighed> {
        let mut near = Vec::new();
        let thinned = thinned(points, self.side);
        let found = thinned.iter().filter_map(|point| {
            let there = pose.rotation * point + pose.translation.vector;
            self.nearest(&there, &mut near);
            if near.len() < NEIGHBOURS {
                return None;
            }
            let neighbours: [Vector3<f64>; NEIGHBOURS] = std::array::from_fn(|i| near[i].1);
            seen(point, &there, &neighbours)
        });
        found.collect()
    }

    fn add(&mut self, points: &[Vector3<f64>], pose: &Isometry3<f64>) {
        for point in thinned(points, self.side) {
            let there = pose.rotation * point + pose.translation.vector;
            let points = self
                .voxels
                .entry(voxel(&there, 2.0 * self.side))
                .or_default();
            let taken = voxel(&there, self.side);
            if points.iter().all(|point| voxel(point, self.side) != taken) {
                points.push(there);
                self.size += 1;
            }
        }
    }

    fn len(&self) -> usize {
        self.size
    }
}

/// Points in a k-d tree that grows, in place of the ikd-Tree of FAST-LIO2 (Y. Cai, W. Xu, F. Zhang 2021), which also balances itself and forgets.
pub struct Tree {
    side: f64,
    tree: kiddo::float::kdtree::KdTree<f64, u64, 3, 64, u32>,
    points: Vec<Vector3<f64>>,
    taken: FxHashSet<Voxel>,
}

impl Tree {
    /// Points are that far from each other.
    pub fn new(side: f64) -> Self {
        Self {
            side,
            tree: Default::default(),
            points: Vec::new(),
            taken: Default::default(),
        }
    }
}

impl Map for Tree {
    fn find(&mut self, points: &[Vector3<f64>], pose: &Isometry3<f64>) -> Vec<Weighed> {
        let thinned = thinned(points, self.side);
        let found = thinned.iter().filter_map(|point| {
            let there = pose.rotation * point + pose.translation.vector;
            let near = self
                .tree
                .nearest_n::<SquaredEuclidean>(&there.into(), NEIGHBOURS);
            let near = near.iter().filter(|near| near.distance < FARTHEST);
            let neighbours: Vec<_> = near.map(|near| self.points[near.item as usize]).collect();
            seen(point, &there, &neighbours)
        });
        found.collect()
    }

    fn add(&mut self, points: &[Vector3<f64>], pose: &Isometry3<f64>) {
        for point in thinned(points, self.side) {
            let there = pose.rotation * point + pose.translation.vector;
            if self.taken.insert(voxel(&there, self.side)) {
                self.tree.add(&there.into(), self.points.len() as u64);
                self.points.push(there);
            }
        }
    }

    fn len(&self) -> usize {
        self.points.len()
    }
}
