//! Normal equations of a graph: a symmetric matrix of blocks, of which the lower half is stored, by
//! columns.

use std::collections::BTreeSet;
use std::iter::once;

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Mat, Side};
use nalgebra::{SMatrix, SVector};

/// Two unknown poses that an edge couples.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coupling {
    pub(super) from: usize,
    pub(super) to: usize,
}

/// The matrix, its right side, and how to factor it.
pub(super) struct Normal<const D: usize> {
    /// For each column of blocks the rows of blocks from the diagonal down, in order.
    rows: Vec<Vec<usize>>,
    /// Where each scalar column begins.
    starts: Vec<usize>,
    symbolic: SymbolicSparseColMat<usize>,
    factoring: SymbolicLlt<usize>,
    values: Vec<f64>,
    right: Vec<f64>,
}

impl<const D: usize> Normal<D> {
    /// For so many unknown poses. `None` if the matrix does not fit into memory.
    pub(super) fn new(unknowns: usize, couplings: impl Iterator<Item = Coupling>) -> Option<Self> {
        let rows = block_rows(unknowns, couplings);
        let mut starts = vec![0];
        let mut indices = Vec::new();
        for blocks in &rows {
            for column in 0..D {
                indices.extend(scalar_rows::<D>(blocks, column));
                starts.push(indices.len());
            }
        }
        let size = unknowns * D;
        let values = vec![0.0; indices.len()];
        // The pattern stays the same while a graph is solved. So the order of elimination is found
        // once, and each step only factors numbers.
        let symbolic = SymbolicSparseColMat::new_checked(size, size, starts.clone(), None, indices);
        let factoring = SymbolicLlt::try_new(symbolic.as_ref(), Side::Lower).ok()?;
        Some(Self {
            rows,
            starts,
            symbolic,
            factoring,
            values,
            right: vec![0.0; size],
        })
    }

    pub(super) fn clear(&mut self) {
        self.values.fill(0.0);
        self.right.fill(0.0);
    }

    /// Adds to the block of two poses, in the lower half or on the diagonal; otherwise adds its
    /// transpose.
    pub(super) fn add(&mut self, row: usize, column: usize, block: &SMatrix<f64, D, D>) {
        if row < column {
            return self.add(column, row, &block.transpose());
        }
        let Ok(place) = self.rows[column].binary_search(&row) else {
            return;
        };
        for c in 0..D {
            // Scalar column `c` begins on the diagonal. Of the first block it holds the rows from
            // `c` on, of each block below all of them.
            let start = self.starts[column * D + c];
            if place == 0 {
                (c..D).for_each(|r| self.values[start + r - c] += block[(r, c)]);
            } else {
                let first = start + D - c + (place - 1) * D;
                (0..D).for_each(|r| self.values[first + r] += block[(r, c)]);
            }
        }
    }

    pub(super) fn add_right(&mut self, row: usize, part: &SVector<f64, D>) {
        (0..D).for_each(|r| self.right[row * D + r] += part[r]);
    }

    /// Where the diagonal is in the values.
    fn diagonal(&self) -> &[usize] {
        &self.starts[..self.starts.len() - 1]
    }

    /// The largest number on the diagonal.
    pub(super) fn largest(&self) -> f64 {
        self.diagonal()
            .iter()
            .map(|start| self.values[*start])
            .fold(0.0, f64::max)
    }

    /// The solution with `damping` added to the diagonal: one motion for each unknown pose. `None`
    /// if the matrix is not positive definite.
    pub(super) fn solve(&self, damping: f64) -> Option<Vec<SVector<f64, D>>> {
        let mut values = self.values.clone();
        self.diagonal()
            .iter()
            .for_each(|start| values[*start] += damping);
        let matrix = SparseColMat::new(self.symbolic.clone(), values);
        let factoring = self.factoring.clone();
        let factor = Llt::try_new_with_symbolic(factoring, matrix.as_ref(), Side::Lower).ok()?;
        let mut solution = Mat::from_fn(self.right.len(), 1, |row, _| self.right[row]);
        factor.solve_in_place(&mut solution);
        let motion = |i: usize| SVector::from_fn(|r, _| solution[(i * D + r, 0)]);
        let motions: Vec<SVector<f64, D>> = (0..self.rows.len()).map(motion).collect();
        let is_finite = motions
            .iter()
            .all(|motion| motion.iter().all(|x| x.is_finite()));
        is_finite.then_some(motions)
    }
}

/// For each column of blocks the rows of blocks from the diagonal down.
fn block_rows(unknowns: usize, couplings: impl Iterator<Item = Coupling>) -> Vec<Vec<usize>> {
    let mut below = vec![BTreeSet::new(); unknowns];
    for Coupling { from, to } in couplings.filter(|coupling| coupling.from != coupling.to) {
        below[from.min(to)].insert(from.max(to));
    }
    let columns = below.into_iter().enumerate();
    columns
        .map(|(column, below)| once(column).chain(below).collect())
        .collect()
}

/// The scalar rows of a scalar column, from the diagonal down.
fn scalar_rows<const D: usize>(blocks: &[usize], column: usize) -> impl Iterator<Item = usize> {
    let diagonal = blocks[0] * D + column..(blocks[0] + 1) * D;
    let below = blocks[1..].iter().flat_map(|row| row * D..(row + 1) * D);
    diagonal.chain(below)
}
