//! What a scan says about the state: the iterated Kalman filter on the manifold, in the dimension of the state.
//!
//! W. Xu, F. Zhang, *FAST-LIO*, 2021: residuals and their Jacobians are its equations 12 to 14, the update 16 to 20. The gain of equation 20 is used in its information
//! form: sums over points are all that is needed of them. Points on one plane share what is not known of that plane, so that their sums are taken plane by
//! plane and joined as one measurement of many points would be (Woodbury's identity).

use nalgebra::{SMatrix, SVector, SymmetricEigen, Vector3};

use super::planes::{ByCube, Plane, PlaneMap};
use super::state::{Covariance, Error, State, at};

/// Dimensions of the state that a point says something about: pose, and the LiDAR's pose on the IMU.
const SEEN: usize = 12;
/// Steps at most, and the step that is none, metres and radians.
const STEPS: usize = 6;
const STILL: f64 = 1e-5;
/// A residual is farther than this from what is expected, in deviations, only if something has moved there.
const GATE: f64 = 4.0;
/// Surfaces are not quite planes, metres.
const ROUGHNESS: f64 = 0.004;

/// What is wrong with a LiDAR.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LidarNoise {
    /// Deviation of a range, metres.
    pub range: f64,
    /// Deviation of a direction, radians.
    pub angle: f64,
}

/// What an update came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Matched {
    /// Points that lay on known planes.
    pub points: usize,
    /// Mean square of their residuals in deviations, about 1 if noise is what it is thought to be.
    pub fit: f64,
    /// Directions in `odom` along which the scan says little: unit vectors.
    pub loose: Vec<Vector3<f64>>,
}

type Sums = SMatrix<f64, SEEN, SEEN>;
type Row = SVector<f64, SEEN>;

/// Sums over the points of one plane.
#[derive(Debug, Clone)]
struct Share {
    /// Of information, of rows weighed, and of weights.
    squares: Sums,
    rows: Row,
    weight: f64,
    /// Of rows times residual, of residuals.
    products: Row,
    residual: f64,
    /// Variance that all points share, m².
    shared: f64,
    count: usize,
    fit: f64,
}

impl Share {
    fn new(shared: f64) -> Self {
        Self {
            squares: Sums::zeros(),
            rows: Row::zeros(),
            weight: 0.0,
            products: Row::zeros(),
            residual: 0.0,
            shared,
            count: 0,
            fit: 0.0,
        }
    }

    fn add(&mut self, row: &Row, residual: f64, variance: f64) {
        let weight = 1.0 / variance;
        self.squares.ger(weight, row, row, 1.0);
        self.rows += row * weight;
        self.products += row * (weight * residual);
        self.residual += weight * residual;
        self.weight += weight;
        self.count += 1;
        self.fit += residual * residual / (variance + self.shared);
    }

    /// Information and its vector with the variance that all share.
    fn joined(&self) -> (Sums, Row) {
        let lost = self.shared / (1.0 + self.shared * self.weight);
        let squares = self.squares - self.rows * self.rows.transpose() * lost;
        (squares, self.products - self.rows * (self.residual * lost))
    }
}

/// Corrects a state by the points of a scan, which are in the LiDAR's frame of the state's instant.
pub fn update(
    state: &mut State,
    covariance: &mut Covariance,
    points: &[Vector3<f64>],
    map: &PlaneMap,
    noise: &LidarNoise,
) -> Option<Matched> {
    let predicted = state.clone();
    let prior = covariance.cholesky()?.inverse();
    let mut matched = None;
    for _ in 0..STEPS {
        let (information, vector, result) = measure(state, covariance, points, map, noise);
        let away = state.minus(&predicted);
        let projection = State::projection(&away);
        // The prior about the state as it is now.
        let here = projection.transpose() * prior * projection;
        let mut sum = here;
        let mut seen = [0; SEEN];
        seen.iter_mut().zip(pose_dimensions()).for_each(|(slot, dimension)| *slot = dimension);
        let mut right: Error = -(projection.transpose() * (prior * away));
        for (i, row) in seen.into_iter().enumerate() {
            right[row] -= vector[i];
            for (j, column) in seen.into_iter().enumerate() {
                sum[(row, column)] += information[(i, j)];
            }
        }
        let factor = sum.cholesky()?;
        let step = factor.solve(&right);
        *state = state.plus(&step);
        matched = Some((factor.inverse(), result));
        if step.fixed_rows::<6>(0).norm() < STILL {
            break;
        }
    }
    let (posterior, result) = matched?;
    *covariance = (posterior + posterior.transpose()) * 0.5;
    Some(result)
}

/// Where the dimensions that a point says something about are among a state's.
fn pose_dimensions() -> impl Iterator<Item = usize> {
    [at::ROTATION, at::POSITION, at::MOUNT_ROTATION, at::MOUNT_POSITION]
        .into_iter()
        .flat_map(|first| first..first + 3)
}

/// The information of all points about a state, and its vector.
fn measure(
    state: &State,
    covariance: &Covariance,
    points: &[Vector3<f64>],
    map: &PlaneMap,
    noise: &LidarNoise,
) -> (Sums, Row, Matched) {
    // In the order in which planes are met, so that sums are the same each time.
    let (mut shares, mut places): (Vec<Share>, ByCube<usize>) = (Vec::new(), ByCube::default());
    let pose = covariance.fixed_view::<6, 6>(0, 0).into_owned();
    for point in points {
        let on_imu = state.mount_rotation * point + state.mount_position;
        let in_odom = state.rotation * on_imu + state.position;
        let Some((cube, plane)) = map.find(in_odom) else { continue };
        let row = jacobian(state, plane, point, &on_imu);
        let variance = point_variance(state, plane, point, noise);
        let shared = plane.variance(in_odom);
        let known = row.fixed_rows::<6>(0);
        let expected = variance + shared + (known.transpose() * pose * known)[0];
        let residual = plane.distance(in_odom);
        if residual * residual < GATE * GATE * expected {
            let place = *places.entry(cube).or_insert(shares.len());
            if place == shares.len() {
                shares.push(Share::new(shared));
            }
            shares[place].add(&row, residual, variance);
        }
    }
    let (mut information, mut vector, mut count, mut fit) = (Sums::zeros(), Row::zeros(), 0, 0.0);
    for share in &shares {
        let (squares, products) = share.joined();
        information += squares;
        vector += products;
        count += share.count;
        fit += share.fit;
    }
    let fit = fit / count.max(1) as f64;
    (information, vector, Matched { points: count, fit, loose: loose(&information) })
}

/// How a point's distance from a plane changes with the state.
fn jacobian(state: &State, plane: &Plane, point: &Vector3<f64>, on_imu: &Vector3<f64>) -> Row {
    let normal = state.rotation.inverse() * plane.normal;
    let turned = on_imu.cross(&normal);
    let mount = point.cross(&(state.mount_rotation.inverse() * normal));
    let mut row = Row::zeros();
    for (first, part) in [(0, turned), (3, plane.normal), (6, mount), (9, normal)] {
        row.fixed_rows_mut::<3>(first).copy_from(&part);
    }
    row
}

/// Variance of a point across a plane by the LiDAR's own noise, m².
fn point_variance(state: &State, plane: &Plane, point: &Vector3<f64>, noise: &LidarNoise) -> f64 {
    let range = point.norm().max(1e-3);
    let ray = state.rotation * (state.mount_rotation * (point / range));
    let cosine = plane.normal.dot(&ray);
    let across = 1.0 - cosine * cosine;
    let sideways = noise.angle * range;
    cosine * cosine * noise.range * noise.range + across * sideways * sideways + ROUGHNESS * ROUGHNESS
}

/// Directions along which the position is known a hundred times worse than along the best one.
fn loose(information: &Sums) -> Vec<Vector3<f64>> {
    const RATIO: f64 = 1e-4;
    let eigen = SymmetricEigen::new(information.fixed_view::<3, 3>(3, 3).into_owned());
    let best = eigen.eigenvalues.max();
    let weak = (0..3).filter(|i| eigen.eigenvalues[*i] <= best * RATIO);
    weak.map(|i| eigen.eigenvectors.column(i).into_owned()).collect()
}
