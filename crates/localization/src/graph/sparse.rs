//! Normal equations of a graph: a symmetric matrix of blocks, of which the lower half is kept, by columns.

use std::collections::BTreeSet;

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Mat, Side};
use nalgebra::{SMatrix, SVector};

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
    /// Of so many unknown poses, of which pairs are coupled; `None` if it is too large for this machine's memory.
    pub(super) fn new(
        unknowns: usize,
        pairs: impl Iterator<Item = (usize, usize)>,
    ) -> Option<Self> {
        let mut below = vec![BTreeSet::new(); unknowns];
        for (a, b) in pairs.filter(|(a, b)| a != b) {
            below[a.min(b)].insert(a.max(b));
        }
        let rows: Vec<Vec<usize>> = below
            .into_iter()
            .enumerate()
            .map(|(i, below)| std::iter::once(i).chain(below).collect())
            .collect();
        let (mut starts, mut indices) = (vec![0], Vec::new());
        for blocks in &rows {
            for column in 0..D {
                let diagonal = blocks[0] * D + column..(blocks[0] + 1) * D;
                indices.extend(
                    diagonal.chain(blocks[1..].iter().flat_map(|row| row * D..(row + 1) * D)),
                );
                starts.push(indices.len());
            }
        }
        let (size, entries) = (unknowns * D, indices.len());
        let symbolic = SymbolicSparseColMat::new_checked(size, size, starts.clone(), None, indices);
        let factoring = SymbolicLlt::try_new(symbolic.as_ref(), Side::Lower).ok()?;
        Some(Self {
            rows,
            starts,
            symbolic,
            factoring,
            values: vec![0.0; entries],
            right: vec![0.0; size],
        })
    }

    pub(super) fn clear(&mut self) {
        self.values.fill(0.0);
        self.right.fill(0.0);
    }

    /// Adds to the block of two poses, in the lower half or on the diagonal; else its transpose.
    pub(super) fn add(&mut self, row: usize, column: usize, block: &SMatrix<f64, D, D>) {
        if row < column {
            return self.add(column, row, &block.transpose());
        }
        let Ok(place) = self.rows[column].binary_search(&row) else {
            return;
        };
        for c in 0..D {
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

    /// The largest number on the diagonal.
    pub(super) fn largest(&self) -> f64 {
        self.starts[..self.starts.len() - 1]
            .iter()
            .map(|start| self.values[*start])
            .fold(0.0, f64::max)
    }

    /// The solution with something added to the diagonal; `None` if the matrix is not positive definite.
    pub(super) fn solve(&self, damping: f64) -> Option<Vec<SVector<f64, D>>> {
        let mut values = self.values.clone();
        self.starts[..self.starts.len() - 1]
            .iter()
            .for_each(|start| values[*start] += damping);
        let matrix = SparseColMat::new(self.symbolic.clone(), values);
        let factor =
            Llt::try_new_with_symbolic(self.factoring.clone(), matrix.as_ref(), Side::Lower)
                .ok()?;
        let mut solution = Mat::from_fn(self.right.len(), 1, |row, _| self.right[row]);
        factor.solve_in_place(&mut solution);
        let parts = (0..self.rows.len()).map(|i| SVector::from_fn(|r, _| solution[(i * D + r, 0)]));
        let steps: Vec<SVector<f64, D>> = parts.collect();
        steps
            .iter()
            .all(|step| step.iter().all(|x| x.is_finite()))
            .then_some(steps)
    }
}
