//! Straight lines over a grid.

use std::cmp::Ordering;

use crate::geometry::GridGeometry;

/// Whether every cell that the line between the middles of cells `a` and `b` passes is free, `b` and `a` included. A line
/// through a corner needs both cells beside it free: nothing squeezes between two blocked cells.
pub fn in_sight(grid: &GridGeometry, free: impl Fn(usize) -> bool, a: usize, b: usize) -> bool {
    let ((mut x, mut y), (bx, by)) = (grid.column_row(a), grid.column_row(b));
    let (dx, dy) = ((bx - x).abs(), (by - y).abs());
    let (sx, sy) = ((bx - x).signum(), (by - y).signum());
    let free = |x: i64, y: i64| free(y as usize * grid.width + x as usize);
    let mut error = dx - dy;
    loop {
        if !free(x, y) {
            return false;
        }
        if (x, y) == (bx, by) {
            return true;
        }
        match error.cmp(&0) {
            Ordering::Greater => {
                x += sx;
                error -= 2 * dy;
            }
            Ordering::Less => {
                y += sy;
                error += 2 * dx;
            }
            Ordering::Equal => {
                if !free(x + sx, y) || !free(x, y + sy) {
                    return false;
                }
                x += sx;
                y += sy;
                error += 2 * (dx - dy);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::MapPoint;
    use proptest::prelude::*;

    fn grid() -> GridGeometry {
        GridGeometry { origin: MapPoint::new(0.0, 0.0), width: 12, height: 9, cell: 1.0 }
    }

    /// Whether the segment between two middles passes through the inside of a cell, by sampling it finely.
    fn passes(grid: &GridGeometry, a: usize, b: usize, cell: usize) -> bool {
        let (p, q) = (grid.center(a), grid.center(b));
        (0..=4000).any(|i| {
            let t = f64::from(i) / 4000.0;
            grid.cell_at(MapPoint::new(p.x + t * (q.x - p.x), p.y + t * (q.y - p.y))) == Some(cell)
        })
    }

    proptest! {
        #[test]
        fn a_clear_line_touches_no_blocked_cell_and_sight_is_mutual(
            blocked in prop::collection::vec(prop::bool::weighted(0.1), 12 * 9), a in 0..12 * 9_usize, b in 0..12 * 9_usize,
        ) {
            let grid = grid();
            let clear = in_sight(&grid, |c| !blocked[c], a, b);
            prop_assert_eq!(clear, in_sight(&grid, |c| !blocked[c], b, a));
            if clear {
                prop_assert!((0..blocked.len()).all(|c| !blocked[c] || !passes(&grid, a, b, c)));
            }
        }
    }

    #[test]
    fn no_line_squeezes_between_two_corners() {
        let grid = grid();
        assert!(!in_sight(&grid, |c| c != 1, 0, 13));
        assert!(in_sight(&grid, |c| c != 2, 0, 13));
    }
}
