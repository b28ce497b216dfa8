//! Origins and directions of a scan's rays in the world.

use openbench_core::Pose3;

use super::pattern::{Aim, LINES};

/// Rays in `map`, in the order of firing. The four rays of a firing have one origin.
#[derive(Debug, Default)]
pub(super) struct Launch {
    origins: Vec<[f32; 3]>,
    directions: Vec<[f32; 3]>,
}

/// A ray in `map`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: [f32; 3],
    pub(super) direction: [f32; 3],
}

impl Launch {
    /// Takes the aims of a scan, whole firings, into `map`. `poses` are those of the sensor at
    /// equal times, from the first firing to just after the last. Between two of them, 2.5 ms
    /// apart, the linear blend of the rotation matrices is a rotation to 1e-6.
    #[inline(always)]
    pub(super) fn set(&mut self, aims: &[Aim], poses: &[Pose3]) {
        self.origins.clear();
        self.directions.clear();
        let knots: Vec<Knot> = poses.iter().map(Knot::new).collect();
        let (Some(first), Some(last)) = (knots.first(), knots.last()) else {
            return;
        };
        // Without aims this is no finite number, and the loop does not run.
        let knots_a_firing = (knots.len() - 1) as f32 / (aims.len() / LINES) as f32;
        for (firing, lines) in aims.chunks_exact(LINES).enumerate() {
            let at = firing as f32 * knots_a_firing;
            let before = at as usize;
            let a = knots.get(before).unwrap_or(first);
            // After the last pose, as with one pose alone, the last one holds.
            let b = knots.get(before + 1).unwrap_or(last);
            let knot = a.blend(b, at - before as f32);
            self.origins.push(knot.origin);
            let mut turned = [[0.0; 3]; LINES];
            for (direction, aim) in turned.iter_mut().zip(lines) {
                *direction = knot.turn(aim.direction);
            }
            self.directions.extend_from_slice(&turned);
        }
    }

    /// The ray with this number in the order of firing.
    #[inline(always)]
    pub(super) fn ray(&self, number: usize) -> Ray {
        Ray {
            origin: self.origins[number / LINES],
            direction: self.directions[number],
        }
    }
}

/// A pose as numbers that can be blended: origin, and rotation matrix by columns.
#[derive(Debug, Clone, Copy)]
struct Knot {
    origin: [f32; 3],
    columns: [[f32; 3]; 3],
}

impl Knot {
    fn new(pose: &Pose3) -> Self {
        let matrix = pose
            .rotation
            .to_rotation_matrix()
            .into_inner()
            .cast::<f32>();
        let column = |i: usize| [matrix[(0, i)], matrix[(1, i)], matrix[(2, i)]];
        let origin = pose.translation.vector.cast::<f32>();
        Self {
            origin: origin.into(),
            columns: [column(0), column(1), column(2)],
        }
    }

    #[inline(always)]
    fn blend(&self, other: &Self, s: f32) -> Self {
        let mut blended = *self;
        for i in 0..3 {
            blended.origin[i] += s * (other.origin[i] - self.origin[i]);
            for column in 0..3 {
                let change = other.columns[column][i] - self.columns[column][i];
                blended.columns[column][i] += s * change;
            }
        }
        blended
    }

    #[inline(always)]
    fn turn(&self, v: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = self.columns;
        let mut turned = [0.0; 3];
        for (i, out) in turned.iter_mut().enumerate() {
            *out = x[i] * v[0] + y[i] * v[1] + z[i] * v[2];
        }
        turned
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, UnitQuaternion, Vector3};

    #[test]
    fn rays_begin_and_run_as_the_pose_of_their_instant_says() {
        let pose = |s: f64| {
            let turn = UnitQuaternion::from_euler_angles(0.01 * s, 0.02, 0.05 * s);
            Pose3::from_parts(Vector3::new(0.1 * s, 2.0, 0.3).into(), turn)
        };
        let poses: Vec<Pose3> = (0..=40).map(|i| pose(f64::from(i) / 40.0)).collect();
        let aim = Aim {
            direction: [0.6, 0.0, 0.8],
            turn: 0.0,
            elevation: 0.0,
        };
        let mut launch = Launch::default();
        launch.set(&[aim; 400], &poses);
        for ray in [0, 1, 7, 123, 399] {
            let Ray { origin, direction } = launch.ray(ray);
            let at = pose((ray / LINES) as f64 / 100.0);
            let true_direction = at.rotation * Vector3::new(0.6, 0.0, 0.8);
            let off = Vector3::from(direction.map(f64::from)) - true_direction;
            assert!(off.norm() < 1e-6, "{ray}: {off}");
            assert!(
                (Point3::from(origin.map(f64::from)) - Point3::from(at.translation.vector)).norm()
                    < 1e-6
            );
        }
    }

    #[test]
    fn without_poses_or_aims_there_are_no_rays() {
        let mut launch = Launch::default();
        launch.set(&[], &[Pose3::identity(); 2]);
        launch.set(
            &[Aim {
                direction: [1.0, 0.0, 0.0],
                turn: 0.0,
                elevation: 0.0,
            }; 4],
            &[],
        );
        assert!(launch.origins.is_empty() && launch.directions.is_empty());
    }
}
