//! Normal equations of a least-squares problem along a chain of knots, and their solution.
//!
//! Every residual depends on at most three knots in a row, of four variables each. So row i of the
//! symmetric matrix is zero left of column i - 11, and so is its Cholesky factor. Memory and time
//! grow with the length of the band, not with its square or cube.

/// Variables of a knot.
pub(crate) const BLOCK: usize = 4;
/// Relative damping of the steps of a knot's variables: x, y, yaw, time.
const SCALE: [f64; BLOCK] = [1.0, 1.0, 0.1, 0.02];
/// Columns of a row that may differ from zero, the diagonal included.
const WIDTH: usize = 3 * BLOCK;

/// Receives weighted residuals and their derivatives by the `K` variables from the first one of
/// knot `knot` on.
pub(crate) trait Sink {
    /// Adds `weight * residual²` to what is minimized.
    fn add<const K: usize>(&mut self, knot: usize, weight: f64, residual: f64, gradient: &[f64; K]);
}

/// Sums the squares only.
#[derive(Debug, Default)]
pub(crate) struct Total(pub f64);

impl Sink for Total {
    #[inline]
    fn add<const K: usize>(
        &mut self,
        _knot: usize,
        weight: f64,
        residual: f64,
        _gradient: &[f64; K],
    ) {
        self.0 += weight * residual * residual;
    }
}

/// A step of all variables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step<'a> {
    /// By how much each variable moves.
    pub by: &'a [f64],
    /// Predicted decrease of the sum of squares, if it were quadratic.
    pub fall: f64,
}

/// JᵀWJ, JᵀWr and rᵀWr.
#[derive(Debug, Clone, Default)]
pub(crate) struct Normal {
    /// Row i holds columns i - 11 to i.
    matrix: Vec<[f64; WIDTH]>,
    gradient: Vec<f64>,
    factor: Vec<[f64; WIDTH]>,
    step: Vec<f64>,
    total: f64,
}

impl Sink for Normal {
    #[inline]
    fn add<const K: usize>(
        &mut self,
        knot: usize,
        weight: f64,
        residual: f64,
        gradient: &[f64; K],
    ) {
        self.total += weight * residual * residual;
        let first = knot * BLOCK;
        let rows = &mut self.matrix[first..first + K];
        let right = &mut self.gradient[first..first + K];
        for (a, (row, right)) in rows.iter_mut().zip(right).enumerate() {
            let scaled = weight * gradient[a];
            *right += scaled * residual;
            // Row a of the block ends at its diagonal: the upper half is not stored.
            for (entry, b) in row[WIDTH - 1 - a..].iter_mut().zip(gradient) {
                *entry += scaled * b;
            }
        }
    }
}

impl Normal {
    /// Empties the equations for `knots` knots.
    pub(crate) fn clear(&mut self, knots: usize) {
        self.matrix.clear();
        self.matrix.resize(knots * BLOCK, [0.0; WIDTH]);
        self.gradient.clear();
        self.gradient.resize(knots * BLOCK, 0.0);
        self.total = 0.0;
    }

    /// Sum of the weighted squares.
    pub(crate) fn total(&self) -> f64 {
        self.total
    }

    /// Fixes a variable: its step will be zero.
    pub(crate) fn hold(&mut self, variable: usize) {
        self.matrix[variable] = [0.0; WIDTH];
        self.matrix[variable][WIDTH - 1] = 1.0;
        self.gradient[variable] = 0.0;
        let after = self.matrix.len().min(variable + WIDTH);
        for (k, row) in self.matrix[variable + 1..after].iter_mut().enumerate() {
            row[WIDTH - 2 - k] = 0.0;
        }
    }

    /// The step that minimizes the sum of squares plus `damping` times the square of the step
    /// itself (Levenberg); `None` if the matrix is not positive definite or not finite.
    pub(crate) fn step(&mut self, damping: f64) -> Option<Step<'_>> {
        self.factor.clone_from(&self.matrix);
        for (i, row) in self.factor.iter_mut().enumerate() {
            row[WIDTH - 1] += damping * SCALE[i % BLOCK];
        }
        self.factorize()?;
        self.substitute();
        let each = self.step.iter().zip(&self.gradient).enumerate();
        let fall = each
            // The fall is -2 gᵀδ - δᵀHδ, and (H + λD) δ = -g.
            .map(|(i, (step, g))| step * (damping * SCALE[i % BLOCK] * step - g))
            .sum();
        Some(Step {
            by: &self.step,
            fall,
        })
    }

    /// Cholesky factorization, row by row: each entry is one short scalar product of two rows.
    fn factorize(&mut self) -> Option<()> {
        for i in 0..self.factor.len() {
            let (above, rest) = self.factor.split_at_mut(i);
            let row = &mut rest[0];
            for j in i.saturating_sub(WIDTH - 1)..i {
                // Column j of row i is entry j - i + 11; the entries of row j before its diagonal
                // pair with those before this one.
                let at = WIDTH - 1 - (i - j);
                let upper = &above[j];
                let product: f64 = row[..at]
                    .iter()
                    .zip(&upper[i - j..])
                    .map(|(a, b)| a * b)
                    .sum();
                row[at] = (row[at] - product) / upper[WIDTH - 1];
            }
            let square: f64 = row[..WIDTH - 1].iter().map(|a| a * a).sum();
            let pivot = row[WIDTH - 1] - square;
            // Written so that NaN ends here too.
            if !(pivot > 0.0 && pivot.is_finite()) {
                return None;
            }
            row[WIDTH - 1] = pivot.sqrt();
        }
        Some(())
    }

    /// Forward and backward substitution.
    fn substitute(&mut self) {
        let n = self.gradient.len();
        self.step.clear();
        self.step.extend(self.gradient.iter().map(|g| -g));
        // Forward: L y = -g, by rows of L.
        for i in 0..n {
            let first = i.saturating_sub(WIDTH - 1);
            let row = &self.factor[i];
            let known = row[WIDTH - 1 - (i - first)..WIDTH - 1]
                .iter()
                .zip(&self.step[first..i]);
            let product: f64 = known.map(|(a, b)| a * b).sum();
            self.step[i] = (self.step[i] - product) / row[WIDTH - 1];
        }
        // Backward: Lᵀ δ = y. The columns of Lᵀ are rows of L: each value, once known, is taken out
        // of those before it.
        for i in (0..n).rev() {
            let row = &self.factor[i];
            let value = self.step[i] / row[WIDTH - 1];
            self.step[i] = value;
            for (k, entry) in (i.saturating_sub(WIDTH - 1)..i)
                .rev()
                .zip(row[..WIDTH - 1].iter().rev())
            {
                self.step[k] -= entry * value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    /// Knot, weight, residual and gradient.
    fn residual() -> impl Strategy<Value = (usize, f64, f64, [f64; 12])> {
        let gradient = prop::array::uniform12(-1.0..1.0_f64);
        (0..5_usize, 0.1..9.0_f64, -2.0..2.0_f64, gradient)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

        #[test]
        fn steps_are_those_of_the_full_matrix(
            residuals in prop::collection::vec(residual(), 60..90),
            held in 0..28_usize,
            damping in 0.0..0.1_f64,
        ) {
            let knots = 7;
            let n = knots * BLOCK;
            let mut normal = Normal::default();
            normal.clear(knots);
            let mut matrix = DMatrix::<f64>::zeros(n, n);
            let mut right = DVector::<f64>::zeros(n);
            let mut total = 0.0;
            for (knot, weight, residual, gradient) in &residuals {
                normal.add(*knot, *weight, *residual, gradient);
                let mut row = DVector::<f64>::zeros(n);
                row.rows_mut(knot * BLOCK, 12).copy_from_slice(gradient);
                matrix += *weight * &row * row.transpose();
                right += *weight * *residual * row;
                total += weight * residual * residual;
            }
            prop_assert!((normal.total() - total).abs() < 1e-9 * total);
            normal.hold(held);
            matrix.row_mut(held).fill(0.0);
            matrix.column_mut(held).fill(0.0);
            (matrix[(held, held)], right[held]) = (1.0, 0.0);
            for i in 0..n {
                matrix[(i, i)] += damping * SCALE[i % BLOCK];
            }
            let expected = matrix.cholesky().map(|c| -c.solve(&right));
            match (normal.step(damping), expected) {
                (Some(Step { by: step, fall }), Some(expected)) => {
                    prop_assert!(fall >= 0.0);
                    let scale = expected.amax().max(1.0);
                    let mut pairs = step.iter().zip(expected.iter());
                    prop_assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-6 * scale));
                    prop_assert_eq!(step[held], 0.0);
                }
                (ours, theirs) => prop_assert!(damping < 1e-6, "{:?} {:?}", ours, theirs),
            }
        }
    }

    #[test]
    fn equations_with_nan_have_no_step() {
        let mut normal = Normal::default();
        normal.clear(1);
        normal.add(0, 1.0, 1.0, &[f64::NAN, 0.0, 0.0, 0.0]);
        assert!(normal.step(0.1).is_none());
    }
}
