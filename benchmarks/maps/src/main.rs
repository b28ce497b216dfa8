//! Which map an odometry should have: the same scans are laid on maps of three kinds, and put into them where they came to lie.
//!
//! Scans come without distortion (the recorded truth undoes it) and with a guess of the motion since the last, a little wrong, as an IMU gives it; so all that differs is the map, and how each weighs what it finds. Printed are
//! how far the way is off, aligned at the first pose, and CPU time a scan.

mod maps;
mod scans;

use std::time::Duration;

use cpu_time::ThreadTime;
use nalgebra::{Isometry3, Matrix6, SMatrix, Vector3, Vector6};

use maps::{Grid, Map, Planes, Tree, Weighed};
use scans::{Scan, read};

/// Steps of a registration; before each the points are looked up anew.
const STEPS: usize = 4;
/// The guess is off by that, metres and radians (one deviation).
const GUESS: [f64; 2] = [5e-3, 1e-3];

/// Noise that is the same each time.
struct Noise(u64);

impl Noise {
    fn normal(&mut self) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            sum += (self.0 >> 33) as f64 / (1_u64 << 31) as f64;
        }
        sum
    }

    fn vector(&mut self, deviation: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal() * deviation)
    }
}

/// What came of a log.
#[derive(Default)]
struct Outcome {
    squares: f64,
    last: f64,
    scans: usize,
    looking: Duration,
    adding: Duration,
}

fn main() {
    let logs: Vec<_> = std::env::args().skip(1).collect();
    if logs.is_empty() {
        eprintln!("usage: openbench-maps LOG.mcap...");
        std::process::exit(2);
    }
    println!(
        "| log | map | rms, cm | at the end, cm | looking up, ms a scan | putting in, ms a scan | entries |"
    );
    println!("|---|---|---|---|---|---|---|");
    for log in &logs {
        let scans = match read(log) {
            Ok(scans) => scans,
            Err(error) => {
                eprintln!("{log}: {error}");
                std::process::exit(1);
            }
        };
        let name = std::path::Path::new(log)
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy();
        let maps: [(&str, Box<dyn Map>); 5] = [
            ("planes in cubes", Box::new(Planes::default())),
            ("voxels of points, 0.5 m", Box::new(Grid::new(0.5))),
            ("voxels of points, 0.25 m", Box::new(Grid::new(0.25))),
            ("k-d tree, 0.5 m", Box::new(Tree::new(0.5))),
            ("k-d tree, 0.25 m", Box::new(Tree::new(0.25))),
        ];
        for (kind, mut map) in maps {
            let out = drive(&scans, map.as_mut());
            let each = |time: Duration| time.as_secs_f64() * 1e3 / out.scans as f64;
            println!(
                "| {name} | {kind} | {:.2} | {:.2} | {:.2} | {:.2} | {} |",
                100.0 * (out.squares / out.scans as f64).sqrt(),
                100.0 * out.last,
                each(out.looking),
                each(out.adding),
                map.len()
            );
        }
    }
}

/// Odometry by nothing but a map.
fn drive(scans: &[Scan], map: &mut dyn Map) -> Outcome {
    let (mut out, mut noise) = (Outcome::default(), Noise(7));
    let (mut pose, mut before) = (scans[0].truth, scans[0].truth);
    for scan in scans {
        let off = Isometry3::new(noise.vector(GUESS[0]), noise.vector(GUESS[1]));
        let guess = pose * (before.inverse() * scan.truth);
        pose = if out.scans == 0 {
            guess
        } else {
            register(scan, guess * off, map, &mut out.looking)
        };
        before = scan.truth;
        let began = ThreadTime::now();
        map.add(&scan.points, &pose);
        out.adding += began.elapsed();
        out.last = (pose.translation.vector - scan.truth.translation.vector).norm();
        out.squares += out.last * out.last;
        out.scans += 1;
    }
    out
}

/// Where a scan lies on a map: Gauss and Newton on the points' distances from planes, the guess being held as well as it is known.
fn register(
    scan: &Scan,
    guess: Isometry3<f64>,
    map: &mut dyn Map,
    looking: &mut Duration,
) -> Isometry3<f64> {
    let mut pose = guess;
    let held = Vector6::from_fn(|i, _| GUESS[usize::from(i < 3)].powi(-2));
    for _ in 0..STEPS {
        let began = ThreadTime::now();
        let found = map.find(&scan.points, &pose);
        *looking += began.elapsed();
        let away = guess.inverse() * pose;
        let off = away.rotation.scaled_axis().push(0.0).push(0.0).push(0.0)
            + Vector6::new(
                0.0,
                0.0,
                0.0,
                away.translation.x,
                away.translation.y,
                away.translation.z,
            );
        let mut information = Matrix6::from_diagonal(&held);
        let mut vector = -held.component_mul(&off);
        for seen in &found {
            let (distance, jacobian) = residual(&pose, seen);
            let sums = seen.points.matrix();
            information += jacobian * sums * jacobian.transpose();
            vector -= jacobian * (sums * distance);
        }
        let Some(factor) = information.cholesky() else {
            return pose;
        };
        let step = factor.solve(&vector);
        let turned = step.fixed_rows::<3>(0).into_owned();
        pose *= Isometry3::new(step.fixed_rows::<3>(3).into_owned(), turned);
        if step.norm() < 1e-5 {
            break;
        }
    }
    pose
}

/// A point's distance from its plane and how that changes with the pose (rotation, then position, both in the LiDAR's frame), as what (p, 1) is multiplied by.
fn residual(pose: &Isometry3<f64>, seen: &Weighed) -> (nalgebra::Vector4<f64>, SMatrix<f64, 6, 4>) {
    let normal = pose.rotation.inverse() * seen.normal;
    let offset = seen.normal.dot(&pose.translation.vector) - seen.offset;
    let mut jacobian = SMatrix::<f64, 6, 4>::zeros();
    // p x n = -n x p.
    jacobian
        .fixed_view_mut::<3, 3>(0, 0)
        .copy_from(&-normal.cross_matrix());
    jacobian.fixed_view_mut::<3, 1>(3, 3).copy_from(&normal);
    (normal.push(offset), jacobian)
}
