//! Straight lines over the cells of a grid.

use std::cmp::Ordering;

use super::cells::GridGeometry;

/// Whether the line between the middles of cells `a` and `b` passes only free cells, both ends
/// included. A line through a corner needs both cells beside it free: nothing passes between two
/// blocked cells.
pub fn in_sight(grid: &GridGeometry, free: impl Fn(usize) -> bool, a: usize, b: usize) -> bool {
    passes_all(grid, a, b, |cell, _| free(cell))
}

/// Visits the cells that the line between the middles of cells `a` and `b` passes, in their order,
/// with the share of the line that lies in each, as long as `pass` returns true. Returns whether
/// the end was reached.
///
/// Of a corner that the line passes through, both cells beside it are visited, with a share of
/// zero.
pub fn passes_all(
    grid: &GridGeometry,
    a: usize,
    b: usize,
    mut pass: impl FnMut(usize, f64) -> bool,
) -> bool {
    let ((mut x, mut y), (bx, by)) = (grid.column_row(a), grid.column_row(b));
    let (dx, dy) = ((bx - x).abs(), (by - y).abs());
    let (sx, sy) = ((bx - x).signum(), (by - y).signum());
    let mut pass = |x: i64, y: i64, share: f64| pass(y as usize * grid.width + x as usize, share);
    // Borders of columns and of rows that were passed, and the share of the line behind the last of
    // them.
    let (mut columns, mut rows, mut behind) = (0, 0, 0.0);
    // Infinite for a line along a row or a column, whose other borders are never passed.
    let half = [0.5 / dx as f64, 0.5 / dy as f64];
    let share_at = |passed: i64, half: f64| (2 * passed + 1) as f64 * half;
    loop {
        if (columns, rows) == (dx, dy) {
            return pass(x, y, 1.0 - behind);
        }
        // Which border comes first: (2 columns + 1) / 2 dx against (2 rows + 1) / 2 dy.
        // Multiplied out, so that whole numbers decide and a corner is recognized exactly.
        let first = ((2 * columns + 1) * dy).cmp(&((2 * rows + 1) * dx));
        let until = if first == Ordering::Greater {
            share_at(rows, half[1])
        } else {
            share_at(columns, half[0])
        };
        if !pass(x, y, until - behind) {
            return false;
        }
        if first == Ordering::Equal && !(pass(x + sx, y, 0.0) && pass(x, y + sy, 0.0)) {
            return false;
        }
        behind = until;
        if first != Ordering::Greater {
            (x, columns) = (x + sx, columns + 1);
        }
        if first != Ordering::Less {
            (y, rows) = (y + sy, rows + 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::MapPoint;
    use proptest::prelude::*;

    fn grid() -> GridGeometry {
        GridGeometry {
            origin: MapPoint::new(0.0, 0.0),
            width: 12,
            height: 9,
            cell: 1.0,
        }
    }

    /// Whether the segment between two middles passes through the inside of a cell, by fine
    /// samples.
    fn passes(grid: &GridGeometry, a: usize, b: usize, cell: usize) -> bool {
        let (p, q) = (grid.center(a), grid.center(b));
        (0..=4000).any(|i| {
            let t = f64::from(i) / 4000.0;
            grid.cell_at(MapPoint::new(p.x + t * (q.x - p.x), p.y + t * (q.y - p.y))) == Some(cell)
        })
    }

    proptest! {
        #[test]
        fn a_line_of_sight_passes_no_blocked_cell_and_is_mutual(
            blocked in prop::collection::vec(prop::bool::weighted(0.1), 12 * 9),
            a in 0..12 * 9_usize,
            b in 0..12 * 9_usize,
        ) {
            let grid = grid();
            let clear = in_sight(&grid, |c| !blocked[c], a, b);
            prop_assert_eq!(clear, in_sight(&grid, |c| !blocked[c], b, a));
            if clear {
                prop_assert!((0..blocked.len()).all(|c| !blocked[c] || !passes(&grid, a, b, c)));
            }
        }
    }

    proptest! {
        #[test]
        fn shares_of_a_line_are_those_of_fine_samples(
            a in 0..12 * 9_usize,
            b in 0..12 * 9_usize,
        ) {
            let grid = grid();
            let mut shares = vec![0.0; grid.len()];
            passes_all(&grid, a, b, |cell, share| { shares[cell] += share; share >= 0.0 });
            let (p, q) = (grid.center(a), grid.center(b));
            let samples = 5000;
            for i in 0..samples {
                let t = (f64::from(i) + 0.5) / f64::from(samples);
                let at = MapPoint::new(p.x + t * (q.x - p.x), p.y + t * (q.y - p.y));
                shares[grid.cell_at(at).unwrap()] -= 1.0 / f64::from(samples);
            }
            // On a line along corners rounding may put a sample beside them.
            prop_assert!(shares.iter().all(|left| left.abs() < 2e-3), "{shares:?}");
        }
    }

    #[test]
    fn no_line_passes_between_two_blocked_corners() {
        let grid = grid();
        assert!(!in_sight(&grid, |c| c != 1, 0, 13));
        assert!(in_sight(&grid, |c| c != 2, 0, 13));
    }
}
