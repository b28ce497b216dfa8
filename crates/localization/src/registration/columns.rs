//! What the LiDAR returned over each half metre of ground, while the robot drove a few metres.

use nalgebra::{Matrix2, SymmetricEigen, Vector2};
use openbench_core::MapPoint;
use openbench_geometry::grid::GridGeometry;

/// Side of a column, metres.
pub(super) const CELL_M: f64 = 0.5;
/// Columns reach so far from where the stretch began, metres.
pub(super) const REACH_M: f64 = 55.0;
/// Returns between these heights are of things that a robot runs into, metres.
const BODY_M: std::ops::Range<f32> = 0.3..2.5;
/// A column with this many of them is occupied.
const OCCUPIED: u32 = 3;
/// A facade has this many returns in a column,
const FACADE_RETURNS: u32 = 4;
/// reaches higher than this above the ground where the robot is, metres,
const FACADE_TOP_M: f32 = 2.2;
/// over at least this height, metres,
const FACADE_SPAN_M: f32 = 1.0;
/// and is no thicker than this, one standard deviation in metres,
const FACADE_THICKNESS_M: f64 = 0.14;
/// but longer, likewise.
const FACADE_LENGTH_M: f64 = 0.22;

/// Returns over a square of ground.
#[derive(Debug, Clone, Copy)]
struct Column {
    returns: u32,
    body: u32,
    low: f32,
    high: f32,
    views: u8,
    last_view: u16,
    /// Sums over the returns, from the column's middle: x, y, xx, xy, yy.
    sums: [f32; 5],
}

const EMPTY: Column = Column {
    returns: 0,
    body: 0,
    low: f32::INFINITY,
    high: f32::NEG_INFINITY,
    views: 0,
    last_view: u16::MAX,
    sums: [0.0; 5],
};

/// A piece of a facade: what is thin, long and high.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Facade {
    /// Mean of its returns.
    pub at: MapPoint,
    /// Direction in which it faces, radians: to the side from which it was seen.
    pub facing: f64,
    /// From how many places, a metre apart, it was seen.
    pub views: u8,
}

/// All columns of a stretch.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    grid: GridGeometry,
    columns: Vec<Column>,
}

impl Columns {
    pub(super) fn around(centre: MapPoint) -> Self {
        let side = (2.0 * REACH_M / CELL_M) as usize;
        let grid = GridGeometry {
            origin: MapPoint::new(centre.x - REACH_M, centre.y - REACH_M),
            width: side,
            height: side,
            cell: CELL_M,
        };
        Self {
            columns: vec![EMPTY; grid.len()],
            grid,
        }
    }

    /// Takes in a return at a height above the ground where the robot is.
    pub(super) fn add(&mut self, at: MapPoint, height: f32, view: u16) {
        let Some(cell) = self.grid.cell_at(at) else {
            return;
        };
        let middle = self.grid.center(cell);
        let (x, y) = ((at.x - middle.x) as f32, (at.y - middle.y) as f32);
        let column = &mut self.columns[cell];
        column.returns += 1;
        column.body += u32::from(BODY_M.contains(&height));
        column.low = column.low.min(height);
        column.high = column.high.max(height);
        if column.last_view != view {
            column.last_view = view;
            column.views = column.views.saturating_add(1);
        }
        for (sum, value) in column.sums.iter_mut().zip([x, y, x * x, x * y, y * y]) {
            *sum += value;
        }
    }

    /// Whether something stands there.
    pub(super) fn is_occupied(&self, at: MapPoint) -> bool {
        self.grid
            .cell_at(at)
            .is_some_and(|cell| self.columns[cell].body >= OCCUPIED)
    }

    /// The pieces of facades, as seen from about there.
    pub(super) fn facades(&self, seen_from: MapPoint) -> Vec<Facade> {
        let cells = 0..self.columns.len();
        cells
            .filter_map(|cell| self.facade(cell, seen_from))
            .collect()
    }

    fn facade(&self, cell: usize, seen_from: MapPoint) -> Option<Facade> {
        let column = &self.columns[cell];
        let is_high = column.high >= FACADE_TOP_M && column.high - column.low >= FACADE_SPAN_M;
        if !is_high || column.returns < FACADE_RETURNS {
            return None;
        }
        let spread = self.spread_around(cell);
        let eigen = SymmetricEigen::new(spread);
        let (short, long) = if eigen.eigenvalues[0] < eigen.eigenvalues[1] {
            (0, 1)
        } else {
            (1, 0)
        };
        let deviation = |i: usize| eigen.eigenvalues[i].max(0.0).sqrt();
        if deviation(short) > FACADE_THICKNESS_M || deviation(long) < FACADE_LENGTH_M {
            return None;
        }
        let axis = eigen.eigenvectors.column(short);
        let middle = self.grid.center(cell);
        let n = f64::from(column.returns);
        let at = MapPoint::new(
            middle.x + f64::from(column.sums[0]) / n,
            middle.y + f64::from(column.sums[1]) / n,
        );
        let towards = (seen_from.x - at.x) * axis[0] + (seen_from.y - at.y) * axis[1];
        let side = if towards < 0.0 { -1.0 } else { 1.0 };
        Some(Facade {
            at,
            facing: libm::atan2(side * axis[1], side * axis[0]),
            views: column.views,
        })
    }

    /// Covariance of the returns in a column and its neighbours that are high too.
    fn spread_around(&self, cell: usize) -> Matrix2<f64> {
        let middle = self.grid.center(cell);
        let mut n = 0.0;
        let mut sum = Vector2::zeros();
        let mut squares = Matrix2::zeros();
        for near in std::iter::once(cell).chain(self.grid.neighbours(cell)) {
            let column = &self.columns[near];
            if column.high < FACADE_TOP_M || column.returns == 0 {
                continue;
            }
            let center = self.grid.center(near);
            let offset = Vector2::new(center.x - middle.x, center.y - middle.y);
            let count = f64::from(column.returns);
            let [x, y, xx, xy, yy] = column.sums.map(f64::from);
            let first = Vector2::new(x, y);
            n += count;
            sum += first + offset * count;
            squares += Matrix2::new(xx, xy, xy, yy)
                + offset * first.transpose()
                + first * offset.transpose()
                + offset * offset.transpose() * count;
        }
        let mean = sum / n;
        squares / n - mean * mean.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns with returns of something, seen once.
    fn seen(returns: impl Iterator<Item = (f64, f64, f32)>) -> Columns {
        let mut columns = Columns::around(MapPoint::default());
        returns.for_each(|(x, y, height)| columns.add(MapPoint::new(x, y), height, 0));
        columns
    }

    /// Returns from a wall along the x axis, 5 m north, up to a height.
    fn wall(top: f32) -> impl Iterator<Item = (f64, f64, f32)> {
        (0..60).flat_map(move |i| {
            let heights = (0..20).map(move |j| top * j as f32 / 20.0);
            heights.map(move |height| (0.1 * f64::from(i) - 3.0, 5.2, height))
        })
    }

    #[test]
    fn a_high_wall_is_a_facade_that_faces_who_sees_it() {
        let facades = seen(wall(5.0)).facades(MapPoint::default());
        assert!((11..=13).contains(&facades.len()), "{}", facades.len());
        for facade in &facades {
            assert!((facade.at.y - 5.2).abs() < 1e-6, "{facade:?}");
            assert!((facade.facing + std::f64::consts::FRAC_PI_2).abs() < 1e-6);
        }
        let behind = seen(wall(5.0)).facades(MapPoint::new(0.0, 9.0));
        assert!((behind[0].facing - std::f64::consts::FRAC_PI_2).abs() < 1e-6);
    }

    #[test]
    fn a_fence_is_occupied_and_no_facade() {
        let columns = seen(wall(1.5));
        assert!(columns.is_occupied(MapPoint::new(0.1, 5.2)));
        assert!(!columns.is_occupied(MapPoint::new(0.1, 4.2)));
        assert!(columns.facades(MapPoint::default()).is_empty());
    }

    #[test]
    fn a_tree_is_no_facade() {
        // A crown of two metres, filled evenly.
        let crown = (0..4000).map(|i| {
            let (a, r) = (f64::from(i) * 2.4, f64::from(i % 61) / 61.0);
            (
                4.0 + r * libm::cos(a),
                r * libm::sin(a),
                1.0 + (i % 37) as f32 * 0.1,
            )
        });
        assert!(seen(crown).facades(MapPoint::default()).is_empty());
    }

    #[test]
    fn returns_far_away_and_numbers_that_are_none_are_left_out() {
        let columns = seen([(1e9, 0.0, 1.0), (f64::NAN, 0.0, 1.0)].into_iter());
        assert!(columns.facades(MapPoint::default()).is_empty());
    }
}
