//! What a scan says about the state: the iterated Kalman filter on the manifold, in the dimension of the state.
//!
//! W. Xu, F. Zhang, *FAST-LIO*, 2021: residuals and their Jacobians are its equations 12 to 14, the update 16 to 20. The gain of equation 20 is used in its
//! information form: sums over points are all that is needed of them. Points on one plane share what is not known of that plane, so that they are joined as one
//! measurement of many points would be (Woodbury's identity).

use nalgebra::{Matrix3, SMatrix, SVector, SymmetricEigen, Vector3};

use super::inertial::Known;
use super::matching::{Cluster, Matching, Seen};
use super::planes::PlaneMap;
use super::so3::hat;
use super::state::{Covariance, Error, SIZE, State, at};

/// Steps at most, and the step that is none, metres and radians.
const STEPS: usize = 6;
const STILL: f64 = 1e-5;
/// So well is the position held where it is to be held, 1/m².
const HELD: f64 = 1e10;
/// Points are looked up again where the pose has moved farther than that since: metres and radians.
const MOVED: [f64; 2] = [0.03, 0.003];
/// That often at most.
const SEARCHES: usize = 8;
/// A pose that may be off by more than that is known badly, metres; then points count that are no farther from a plane than that, search by search, metres.
const WIDE: f64 = 0.05;
const GATES: [f64; 5] = [0.6, 0.3, 0.15, 0.1, f64::INFINITY];
/// One point in so many is looked up in all of these searches but the last, if a scan has enough of them.
const THINNED: usize = 4;
const ENOUGH: usize = 2000;

/// What is wrong with a LiDAR.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LidarNoise {
    /// Deviation of a range, metres.
    pub range: f64,
    /// Deviation of a direction, radians.
    pub angle: f64,
}

impl LidarNoise {
    /// Variance across a plane of a point on it, m². `along` is how far the point is from the LiDAR
    /// along the plane's normal, metres, and `squared` the square of its whole distance, m².
    pub(super) fn across(&self, along: f64, squared: f64) -> f64 {
        // The part of the range that is across the plane, squared: sin² α.
        let across = along * along / squared;
        across * self.range * self.range + (1.0 - across) * self.angle * self.angle * squared
    }
}

/// What an update came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Matched {
    /// Points that lay on known planes.
    pub points: usize,
    /// Share of the points where planes are known that lie on them.
    pub agreeing: f64,
    /// Mean square of their residuals in deviations, about 1 if noise is what it is thought to be.
    pub fit: f64,
    /// Directions in `odom` along which the scan says little: unit vectors.
    pub loose: Vec<Vector3<f64>>,
    /// How far the scan moves what IMU and wheels predict, squared, in deviations of that: about 1 if both are as far off as they are thought to be.
    pub surprise: f64,
}

/// With fewer points on known planes a scan says nothing.
const FEW: usize = 60;
/// Of the points on known surfaces that share agrees with the map at least, else something is wrong.
const AGREEING: f64 = 0.5;

impl Matched {
    /// Whether the scan says something, and does not contradict the map.
    pub fn is_good(&self) -> bool {
        self.points >= FEW && self.agreeing >= AGREEING
    }
}

/// Corrects a state by the points of a scan, which are in the LiDAR's frame of the state's instant. `None` leaves the state as it was: the numbers have no solution.
///
/// Where the pose is known badly beforehand, as after a gap, much would pass for a point of a plane that is none: the gate is closed step by step then, about
/// what agrees so far.
pub(super) fn update(
    known: &mut Known,
    points: &[Vector3<f64>],
    map: &PlaneMap,
    noise: &LidarNoise,
    estimate_lidar: bool,
    matching: &mut Matching,
) -> Option<Matched> {
    let covariance = known.covariance;
    let prior = Prior {
        state: known.state.clone(),
        information: covariance.cholesky()?.inverse(),
        covariance,
    };
    let wide = spread(&known.in_map().covariance) > WIDE;
    let gates = if wide { &GATES[..] } else { &[f64::INFINITY] };
    let registration = Registration {
        prior,
        wide,
        gates,
        points,
        map,
        noise,
        estimate_lidar,
    };
    if wide && points.len() >= ENOUGH {
        // Some of the points will do until it is known about where they lie; where they do not, all of them may.
        let thinned: Vec<_> = points.iter().copied().step_by(THINNED).collect();
        let mut there = known.clone();
        let found = registration.search(&mut there, &thinned, matching);
        if let Some(matched) = found.filter(Matched::is_good) {
            *known = there;
            return Some(matched);
        }
    }
    registration.search(known, points, matching)
}

/// A scan that is laid on a map.
struct Registration<'a> {
    prior: Prior,
    /// Whether that is badly known.
    wide: bool,
    gates: &'a [f64],
    points: &'a [Vector3<f64>],
    map: &'a PlaneMap,
    noise: &'a LidarNoise,
    estimate_lidar: bool,
}

impl Registration<'_> {
    /// Looks points up and corrects the state, in turn, until the state stays where it is; `rough` are the points that are looked up in all searches that have a gate but the last.
    fn search(
        &self,
        known: &mut Known,
        rough: &[Vector3<f64>],
        matching: &mut Matching,
    ) -> Option<Matched> {
        let mut here = known.clone();
        for search in 0..SEARCHES {
            let gate = self.gates.get(search).copied().unwrap_or(f64::INFINITY);
            let points = if search + 1 < self.gates.len() {
                rough
            } else {
                self.points
            };
            let in_map = here.in_map();
            matching.find(
                &in_map.state,
                &in_map.covariance,
                points,
                self.map,
                self.noise,
                gate,
            );
            let (there, posterior, matched) = if self.estimate_lidar {
                settle::<12>(&self.prior, here.state, &matching.clusters)?
            } else {
                settle::<6>(&self.prior, here.state, &matching.clusters)?
            };
            let moved = there.in_map().minus(&in_map.state);
            let far = moved.fixed_rows::<3>(at::POSITION).norm() > MOVED[0]
                || moved.fixed_rows::<3>(at::ROTATION).norm() > MOVED[1];
            here.state = there;
            if self.wide {
                here.covariance = posterior;
            }
            if !far && search + 1 >= self.gates.len() {
                if !here.state.is_finite() {
                    return None;
                }
                let surprise = self.prior.surprise(&here.state, &posterior);
                known.state = here.state;
                known.covariance = (posterior + posterior.transpose()) * 0.5;
                return Some(Matched {
                    agreeing: matching.agreeing(),
                    surprise,
                    ..matched
                });
            }
        }
        None
    }
}

/// How far off a surface at some distance may seem to be by the pose alone, metres (one deviation).
fn spread(covariance: &Covariance) -> f64 {
    const DISTANCE: f64 = 10.0;
    let trace = |first: usize| (first..first + 3).map(|i| covariance[(i, i)]).sum::<f64>();
    (trace(at::POSITION) + DISTANCE * DISTANCE * trace(at::ROTATION)).sqrt()
}

/// What was known before.
struct Prior {
    state: State,
    information: Covariance,
    covariance: Covariance,
}

impl Prior {
    /// The normalized innovation squared (Bar-Shalom, Li, Kirubarajan 2001, section 5.4) over what is right on average, by what became of the state: as many numbers as the scan
    /// tells, those that it tells in part counted in part.
    fn surprise(&self, state: &State, posterior: &Covariance) -> f64 {
        let away = state.minus(&self.state);
        let told = SIZE as f64 - self.information.component_mul(posterior).sum();
        away.dot(&(self.information * away)) / told.max(1.0)
    }

    /// What is not known of the position along loose directions, and what hangs on it as far as `left`, what the scan leaves of an error before it (S. F. Schmidt's filter with states
    /// that are considered, not estimated).
    fn along(&self, loose: &[Vector3<f64>], left: &Covariance) -> Covariance {
        let mut sum = Covariance::zeros();
        let mut rest = self.covariance;
        // One direction after the other, what is left being independent of those before.
        for direction in loose {
            let column = rest.fixed_columns::<3>(at::POSITION) * direction;
            let variance = direction.dot(&column.fixed_rows::<3>(at::POSITION));
            if variance > 0.0 {
                let column = column / variance.sqrt();
                rest -= column * column.transpose();
                let column = left * column;
                sum += column * column.transpose();
            }
        }
        sum
    }
}

/// The state that agrees best with what was known and with the clusters; `N` dimensions of it are seen.
fn settle<const N: usize>(
    prior: &Prior,
    mut state: State,
    clusters: &[Cluster],
) -> Option<(State, Covariance, Matched)> {
    let mut last = None;
    for _ in 0..STEPS {
        let seen = state.in_map();
        let (information, vector, matched) = measure::<N>(&seen, clusters);
        let observed = observed::<N>(&seen);
        let away = state.minus(&prior.state);
        let projection = State::projection(&away);
        // The prior about the state as it is now.
        let mut before = projection.transpose() * prior.information * projection;
        let mut right: Error = -(projection.transpose() * (prior.information * away));
        // Where a scan says nothing the position is held. The direction itself is known to milliradians only, and where it is long unknown how far one has come, the little that
        // is said across it would seem to say how far.
        for direction in &matched.loose {
            let held = direction * HELD;
            let off = held * direction.dot(&away.fixed_rows::<3>(at::POSITION));
            let mut block = before.fixed_view_mut::<3, 3>(at::POSITION, at::POSITION);
            block += held * direction.transpose();
            let mut rows = right.fixed_rows_mut::<3>(at::POSITION);
            rows -= off;
        }
        right -= observed.transpose() * vector;
        let sum = before + observed.transpose() * information * observed;
        let factor = sum.cholesky()?;
        let step = factor.solve(&right);
        state = state.plus(&step);
        let still = (observed * step).norm() < STILL;
        last = Some((factor, matched, before));
        if still {
            break;
        }
    }
    let (factor, matched, before) = last?;
    let posterior = factor.inverse();
    let posterior = posterior + prior.along(&matched.loose, &(posterior * before));
    Some((state, posterior, matched))
}

impl Known {
    /// The same in the map as it leans; of the covariance the pose's alone.
    pub(super) fn in_map(&self) -> Self {
        let state = self.state.in_map();
        let observed = observed::<6>(&state);
        let mut covariance = self.covariance;
        covariance
            .fixed_view_mut::<6, 6>(0, 0)
            .copy_from(&(observed * self.covariance * observed.transpose()));
        Self {
            stamp: self.stamp,
            state,
            covariance,
        }
    }
}

/// How what a point says something about, which is the pose in the map and then the LiDAR's pose on the IMU, changes with a state that is `seen` in the map.
fn observed<const N: usize>(seen: &State) -> SMatrix<f64, N, SIZE> {
    let mut observed = SMatrix::<f64, N, SIZE>::zeros();
    let firsts = [
        at::ROTATION,
        at::POSITION,
        at::MOUNT_ROTATION,
        at::MOUNT_POSITION,
    ];
    for (row, column) in firsts
        .into_iter()
        .flat_map(|first| first..first + 3)
        .take(N)
        .enumerate()
    {
        observed[(row, column)] = 1.0;
    }
    let upright = seen.rotation.inverse().to_rotation_matrix();
    observed
        .fixed_view_mut::<3, 2>(0, at::MAP_TILT)
        .copy_from(&upright.matrix().fixed_columns::<2>(0));
    observed
}

/// The information of all points about a state, and its vector.
fn measure<const N: usize>(
    state: &State,
    clusters: &[Cluster],
) -> (SMatrix<f64, N, N>, SVector<f64, N>, Matched) {
    let (mut information, mut vector) = (SMatrix::<f64, N, N>::zeros(), SVector::<f64, N>::zeros());
    let (mut points, mut fit, mut feigned) = (0.0, 0.0, Matrix3::zeros());
    for (cluster, seen) in clusters
        .iter()
        .filter_map(|cluster| Some((cluster, cluster.seen.as_ref()?)))
    {
        let (distance, jacobian) = residual::<N>(state, seen);
        let sums = seen.weighed.matrix();
        let weighed = jacobian * sums;
        let off = sums * distance;
        // The points share what is wrong with their plane: their covariance is that of their own noise and of three numbers more, and its inverse after Woodbury.
        let bent = seen.errors * sums;
        let shared = bent * seen.errors.transpose() + Matrix3::from_diagonal(&seen.known);
        let Some(shared) = shared.try_inverse() else {
            continue;
        };
        let (rows, bent) = (jacobian * bent.transpose(), bent * distance);
        information += weighed * jacobian.transpose() - rows * shared * rows.transpose();
        vector += weighed * distance - rows * (shared * bent);
        fit += distance.dot(&off) - bent.dot(&(shared * bent));
        let lost = seen.shared / (1.0 + seen.shared * seen.weighed.weight);
        feigned += seen.leaning * (seen.weighed.weight * (1.0 - lost * seen.weighed.weight));
        points += cluster.points.weight;
    }
    let loose = loose(&information.fixed_view::<3, 3>(3, 3).into_owned(), &feigned);
    for direction in &loose {
        forget(&mut information, &mut vector, direction);
    }
    let fit = fit / points.max(1.0);
    let matched = Matched {
        points: points as usize,
        agreeing: 1.0,
        fit,
        loose,
        surprise: 0.0,
    };
    (information, vector, matched)
}

/// A point's distance from a plane, and how that changes with the state, both as what (p, 1) is multiplied by, p being in the LiDAR's frame.
fn residual<const N: usize>(
    state: &State,
    seen: &Seen,
) -> (nalgebra::Vector4<f64>, SMatrix<f64, N, 4>) {
    let on_imu = state.rotation.inverse() * seen.normal;
    let on_lidar = state.mount_rotation.inverse() * on_imu;
    let middle = state.rotation * state.mount_position + state.position;
    let distance = on_lidar.push(seen.normal.dot(&middle) - seen.offset);
    let mut jacobian = SMatrix::<f64, N, 4>::zeros();
    // p × n = -n × p.
    let turned: Matrix3<f64> =
        -hat(on_imu) * state.mount_rotation.to_rotation_matrix().into_inner();
    jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&turned);
    jacobian
        .fixed_view_mut::<3, 1>(0, 3)
        .copy_from(&state.mount_position.cross(&on_imu));
    jacobian
        .fixed_view_mut::<3, 1>(3, 3)
        .copy_from(&seen.normal);
    if N > 6 {
        jacobian.view_mut((6, 0), (3, 3)).copy_from(&-hat(on_lidar));
        jacobian.view_mut((9, 3), (3, 1)).copy_from(&on_imu);
    }
    (distance, jacobian)
}

/// Directions along which the scan does not say where it is: what it seems to say there is little beside what the leaning of the planes' normals feigns. Two smooth
/// walls have normals that lean forward and back by chance, and seem to tell how far one has come between them.
fn loose(information: &Matrix3<f64>, feigned: &Matrix3<f64>) -> Vec<Vector3<f64>> {
    /// So many times what is feigned is real.
    const REAL: f64 = 1.0;
    /// Known that much worse than along the best direction is not known, as a ratio of information.
    const RATIO: f64 = 1e-4;
    let eigen = SymmetricEigen::new(*information);
    let best = eigen.eigenvalues.max();
    let directions = (0..3).map(|i| {
        (
            eigen.eigenvalues[i],
            eigen.eigenvectors.column(i).into_owned(),
        )
    });
    let weak = directions
        .filter(|(known, u)| *known <= best * RATIO || *known < REAL * u.dot(&(feigned * u)));
    weak.map(|(_, direction)| direction).collect()
}

/// Takes away what is said about the position along a direction (J. Zhang, M. Kaess, S. Singh, *On Degeneracy of Optimization-based State Estimation Problems*,
/// 2016).
fn forget<const N: usize>(
    information: &mut SMatrix<f64, N, N>,
    vector: &mut SVector<f64, N>,
    direction: &Vector3<f64>,
) {
    let mut keep = SMatrix::<f64, N, N>::identity();
    let others = Matrix3::identity() - direction * direction.transpose();
    keep.fixed_view_mut::<3, 3>(at::POSITION, at::POSITION)
        .copy_from(&others);
    *information = keep * *information * keep;
    *vector = keep * *vector;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lio::so3::exp;
    use nalgebra::Vector2;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_seen_changes_with_the_state_as_its_jacobian_says(
            numbers in proptest::collection::vec(-1.0_f64..1.0, 8),
            step in proptest::collection::vec(-1e-4_f64..1e-4, SIZE),
        ) {
            let part = |i: usize| Vector3::new(numbers[i], numbers[i + 1], numbers[i + 2]);
            let state = State {
                rotation: exp(part(0)),
                position: part(3),
                velocity: Vector3::zeros(),
                gyro_bias: Vector3::zeros(),
                accel_bias: Vector3::zeros(),
                gravity: Vector3::z() * -9.8,
                mount_rotation: exp(Vector3::x()),
                mount_position: part(1),
                map_tilt: Vector2::new(numbers[6], numbers[7]) * 0.01,
            };
            let step = Error::from_vec(step);
            let seen = state.in_map();
            let moved = state.plus(&step).in_map().minus(&seen);
            let told = observed::<12>(&seen) * step;
            prop_assert!((moved.fixed_rows::<6>(at::ROTATION) - told.fixed_rows::<6>(0)).norm() < 4e-6);
            prop_assert!((moved.fixed_rows::<6>(at::MOUNT_ROTATION) - told.fixed_rows::<6>(6)).norm() < 1e-9);
        }
    }
}
