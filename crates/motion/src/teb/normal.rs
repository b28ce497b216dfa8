//! Normal equations of a least-squares problem along a chain of knots, and their solution.
//!
//! Every residual depends on at most three knots in a row, of four variables each. So the rows of
//! a knot are zero left of the columns of the second knot before it, and so are those of the
//! Cholesky factor. Memory and time grow with the length of the band, not with its square or cube.
//!
//! The four rows of a knot are stored column by column and treated together: one after the other,
//! each addition of a scalar product would wait for the one before it.

/// Variables of a knot.
pub(crate) const BLOCK: usize = 4;
/// Relative damping of the steps of a knot's variables: x, y, yaw, time.
const SCALE: [f64; BLOCK] = [1.0, 1.0, 0.1, 0.02];
/// Knots before a knot that share residuals with it.
const KNOTS_BEFORE: usize = 2;
/// Columns before those of the knot itself.
const OWN: usize = KNOTS_BEFORE * BLOCK;
/// Columns of a knot's rows that may differ from zero.
const WIDTH: usize = OWN + BLOCK;

/// A column of a knot's rows.
type Column = [f64; BLOCK];

/// The rows of a knot, as columns: those of the two knots before it, and its own. What lies right
/// of the diagonal is never read.
type Rows = [Column; WIDTH];

/// Rows before the first knot of a factor, so that it has two knots before it too: the identity.
const BEFORE_FIRST: Rows = {
    let mut rows = [[0.0; BLOCK]; WIDTH];
    let mut i = 0;
    while i < BLOCK {
        rows[OWN + i][i] = 1.0;
        i += 1;
    }
    rows
};

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
    /// The rows of each knot.
    matrix: Vec<Rows>,
    gradient: Vec<f64>,
    /// Two times [`BEFORE_FIRST`], then the rows of each knot.
    factor: Vec<Rows>,
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
        let right = &mut self.gradient[first..first + K];
        for (right, by) in right.iter_mut().zip(gradient) {
            *right += weight * by * residual;
        }
        for (later, by_rows) in gradient.chunks(BLOCK).enumerate() {
            // The columns of the residual's first knot are those of a knot `later` before.
            let columns = &mut self.matrix[knot + later][OWN - later * BLOCK..];
            for (column, by_column) in columns.iter_mut().zip(gradient) {
                for (entry, by_row) in column.iter_mut().zip(by_rows) {
                    *entry += weight * by_row * by_column;
                }
            }
        }
    }
}

impl Normal {
    /// Empties the equations for `knots` knots.
    pub(crate) fn clear(&mut self, knots: usize) {
        self.matrix.clear();
        self.matrix.resize(knots, [[0.0; BLOCK]; WIDTH]);
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
        let (knot, place) = (variable / BLOCK, variable % BLOCK);
        for column in &mut self.matrix[knot] {
            column[place] = 0.0;
        }
        for (later, rows) in self.matrix[knot..]
            .iter_mut()
            .enumerate()
            .take(KNOTS_BEFORE + 1)
        {
            rows[OWN - later * BLOCK + place] = [0.0; BLOCK];
        }
        self.matrix[knot][OWN + place][place] = 1.0;
        self.gradient[variable] = 0.0;
    }

    /// The step that minimizes the sum of squares plus `damping` times the square of the step
    /// itself (Levenberg); `None` if the matrix is not positive definite or not finite.
    pub(crate) fn step(&mut self, damping: f64) -> Option<Step<'_>> {
        self.factorize(damping)?;
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

    /// Cholesky factorization of the damped matrix, knot by knot.
    fn factorize(&mut self, damping: f64) -> Option<()> {
        self.factor.clear();
        self.factor.resize(KNOTS_BEFORE, BEFORE_FIRST);
        self.factor.extend_from_slice(&self.matrix);
        for knot in KNOTS_BEFORE..self.factor.len() {
            let (before, rest) = self.factor.split_at_mut(knot);
            let rows = &mut rest[0];
            for (i, scale) in SCALE.iter().enumerate() {
                rows[OWN + i][i] += damping * scale;
            }
            factorize_rows(rows, before.last_chunk()?)?;
        }
        Some(())
    }

    /// Forward and backward substitution.
    fn substitute(&mut self) {
        let factor = &self.factor[KNOTS_BEFORE..];
        self.step.clear();
        self.step.extend(self.gradient.iter().map(|g| -g));
        // Forward: L y = -g, by rows of L.
        for (knot, rows) in factor.iter().enumerate() {
            let (known, rest) = self.step.split_at_mut(knot * BLOCK);
            let known = &known[known.len().saturating_sub(OWN)..];
            let mut products = [0.0; BLOCK];
            for (column, value) in rows[OWN - known.len()..OWN].iter().zip(known) {
                add_multiple(&mut products, column, *value);
            }
            for i in 0..BLOCK {
                let column = &rows[OWN + i];
                let value = (rest[i] - products[i]) / column[i];
                rest[i] = value;
                add_multiple(&mut products, column, value);
            }
        }
        // Backward: Lᵀ δ = y. The columns of Lᵀ are rows of L: each value, once known, is taken out
        // of those before it.
        for (knot, rows) in factor.iter().enumerate().rev() {
            let first = knot * BLOCK;
            for i in (0..BLOCK).rev() {
                let value = self.step[first + i] / rows[OWN + i][i];
                self.step[first + i] = value;
                let before = &mut self.step[first.saturating_sub(OWN)..first + i];
                let columns = &rows[OWN + i - before.len()..];
                for (step, column) in before.iter_mut().zip(columns) {
                    *step -= column[i] * value;
                }
            }
        }
    }
}

/// Turns the rows of a knot into those of the Cholesky factor, given the factor's rows of the two
/// knots before it; `None` if a pivot is not positive.
#[inline]
fn factorize_rows(rows: &mut Rows, before: &[Rows; KNOTS_BEFORE]) -> Option<()> {
    for k in 0..OWN {
        // Column k is the diagonal of row k % 4 of an earlier knot: an entry is what the scalar
        // product of both rows leaves of the matrix.
        let (knot, i) = (k / BLOCK, k % BLOCK);
        let earlier = &before[knot];
        let diagonal = OWN + i;
        let mut products = [0.0; BLOCK];
        for (column, factor) in rows[..k].iter().zip(&earlier[diagonal - k..]) {
            add_multiple(&mut products, column, factor[i]);
        }
        let pivot = earlier[diagonal][i];
        for (entry, product) in rows[k].iter_mut().zip(products) {
            *entry = (*entry - product) / pivot;
        }
    }
    for i in 0..BLOCK {
        let k = OWN + i;
        let mut products = [0.0; BLOCK];
        for column in &rows[..k] {
            add_multiple(&mut products, column, column[i]);
        }
        let square = rows[k][i] - products[i];
        // Written so that NaN ends here too.
        if !(square > 0.0 && square.is_finite()) {
            return None;
        }
        let pivot = square.sqrt();
        for (entry, product) in rows[k].iter_mut().zip(products) {
            *entry = (*entry - product) / pivot;
        }
        rows[k][i] = pivot;
    }
    Some(())
}

/// Adds `factor * column` to `sum`.
#[inline]
fn add_multiple(sum: &mut Column, column: &Column, factor: f64) {
    for (sum, entry) in sum.iter_mut().zip(column) {
        *sum += entry * factor;
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
