//! The equations of a robot's pose and of the offsets of buildings, linear about an estimate.
//!
//! The first three variables are x, y and yaw of the pose; then come x and y of each offset.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Vector2};

use super::matching::BuildingEvidence;

/// Linear equations of pose and offsets.
pub(super) struct Equations {
    /// Information of what was known before.
    prior: DMatrix<f64>,
    information: DMatrix<f64>,
    /// Of half the squared error.
    pub(super) gradient: DVector<f64>,
}

impl Equations {
    pub(super) fn of(prior: DMatrix<f64>) -> Self {
        Self {
            information: prior.clone(),
            gradient: DVector::zeros(prior.nrows()),
            prior,
        }
    }

    /// Drops all evidence. What is left is the prior, at a departure from its mean.
    pub(super) fn reset_to_prior(&mut self, departure: &DVector<f64>) {
        self.information.copy_from(&self.prior);
        self.gradient = &self.prior * departure;
    }

    /// Takes in another building at an offset, of which a standard deviation is expected; gives
    /// its place among them.
    pub(super) fn extend(&mut self, expected_m: f64, offset: Vector2<f64>) -> usize {
        let known = self.prior.nrows();
        let own = 1.0 / (expected_m * expected_m);
        for matrix in [&mut self.prior, &mut self.information] {
            let mut larger = std::mem::take(matrix).resize(known + 2, known + 2, 0.0);
            larger[(known, known)] = own;
            larger[(known + 1, known + 1)] = own;
            *matrix = larger;
        }
        let gradient = std::mem::take(&mut self.gradient);
        self.gradient = gradient.resize_vertically(known + 2, 0.0);
        self.gradient
            .fixed_rows_mut::<2>(known)
            .copy_from(&(offset * own));
        (known - 3) / 2
    }

    /// Takes in what the facades of a building say.
    pub(super) fn add(&mut self, evidence: &BuildingEvidence, place: usize) {
        let at = 3 + 2 * place;
        let information = &mut self.information;
        let mut pose = information.fixed_view_mut::<3, 3>(0, 0);
        pose += evidence.pose;
        let mut mixed = information.fixed_view_mut::<3, 2>(0, at);
        mixed += evidence.mixed;
        let mut mixed = information.fixed_view_mut::<2, 3>(at, 0);
        mixed += evidence.mixed.transpose();
        let mut own = information.fixed_view_mut::<2, 2>(at, at);
        own += evidence.own;
        let mut pose = self.gradient.fixed_rows_mut::<3>(0);
        pose += evidence.pose_gradient;
        let mut own = self.gradient.fixed_rows_mut::<2>(at);
        own += evidence.own_gradient;
    }

    pub(super) fn solver(&self) -> Option<Cholesky<f64, Dyn>> {
        self.information.clone().cholesky()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector3};

    use super::*;

    /// A wall across x that is seen two metres farther than by pose and offset together.
    fn wall() -> BuildingEvidence {
        let mut evidence = BuildingEvidence::of(0);
        evidence.pose = Matrix3::from_diagonal(&Vector3::new(4.0, 0.0, 0.0));
        evidence.own = Matrix2::from_diagonal(&Vector2::new(4.0, 0.0));
        evidence.mixed = Matrix3x2::zeros();
        evidence.mixed[(0, 0)] = -4.0;
        evidence.pose_gradient = Vector3::new(-8.0, 0.0, 0.0);
        evidence.own_gradient = Vector2::new(8.0, 0.0);
        evidence
    }

    fn step(equations: &Equations) -> DVector<f64> {
        -equations.solver().unwrap().solve(&equations.gradient)
    }

    #[test]
    fn pose_and_offset_share_an_error_by_what_is_known_of_each() {
        let mut equations = Equations::of(DMatrix::identity(3, 3));
        let place = equations.extend(1.0, Vector2::zeros());
        assert_eq!(place, 0);
        equations.add(&wall(), place);
        let step = step(&equations);
        // Both are known to a metre, the wall to half a metre: 2 m * 1 / (1 + 1 + 0.25) each.
        let share = 2.0 / 2.25;
        assert!(
            (step[0] - share).abs() < 1e-9 && (step[3] + share).abs() < 1e-9,
            "{step}"
        );
        assert_eq!(equations.extend(1.0, Vector2::zeros()), 1);
    }

    #[test]
    fn what_is_forgotten_leaves_the_prior_which_draws_back() {
        let mut equations = Equations::of(DMatrix::identity(3, 3));
        let place = equations.extend(1.0, Vector2::zeros());
        equations.add(&wall(), place);
        let departure = DVector::from_vec(vec![0.5, 0.0, 0.0, 0.0, -0.25]);
        equations.reset_to_prior(&departure);
        assert!((step(&equations) + departure).norm() < 1e-12);
    }

    #[test]
    fn a_building_that_is_new_is_drawn_to_no_offset() {
        let mut equations = Equations::of(DMatrix::identity(3, 3));
        equations.extend(0.5, Vector2::new(1.0, -2.0));
        let step = step(&equations);
        assert!((step[3] + 1.0).abs() < 1e-12 && (step[4] - 2.0).abs() < 1e-12);
    }
}
