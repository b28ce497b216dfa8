//! What the LiDAR returned over each half metre of ground, while the robot drove a few metres.

use nalgebra::{Matrix2, SymmetricEigen, Vector2};
use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2};
use openbench_geometry::grid::GridGeometry;

/// Side of a column, metres.
pub(super) const CELL_M: f64 = 0.5;
/// Columns reach so far from where the stretch began, metres.
const REACH_M: f64 = 55.0;
/// The ground under a column is the lowest return within so many columns of it: slopes are no
/// obstacles.
const GROUND_CELLS: i64 = 2;
/// Returns between these heights above the ground are of things that a robot runs into, metres.
const BODY_M: std::ops::Range<f32> = 0.3..2.5;
/// A column is occupied by so many of them,
const OCCUPIED_RETURNS: u32 = 3;
/// from so many scans: drops of rain and passers-by are gone by the next one.
const OCCUPIED_SCANS: u16 = 2;
/// A facade has this many returns in a column,
const FACADE_RETURNS: u32 = 4;
/// reaches higher than this above the ground, metres,
const FACADE_TOP_M: f32 = 2.2;
/// over at least this height, metres,
const FACADE_SPAN_M: f32 = 1.0;
/// and is no thicker than this, one standard deviation in metres,
const FACADE_THICKNESS_M: f64 = 0.14;
/// but longer, likewise.
const FACADE_LENGTH_M: f64 = 0.22;
/// It goes on: so many other pieces face the same way,
const CONTINUED_BY: usize = 2;
/// within this distance along it, metres,
const ALONG_M: f64 = 2.5;
/// this distance in front of it or behind it, metres,
const ASIDE_M: f64 = 0.35;
/// and this turn, radians. Trunks, crowns and lamps have pieces that stand alone.
const ALIKE_RAD: f64 = 0.35;

/// A return.
#[derive(Debug, Clone, Copy)]
struct Return {
    cell: u32,
    /// Above the robot's ground, metres.
    height: f32,
    scan: u16,
}

/// All returns over a square of ground.
#[derive(Debug, Clone, Copy)]
struct Column {
    /// Those that may be of a facade.
    returns: u32,
    /// The lowest of all returns,
    low: f32,
    /// and the highest that may be of a facade.
    high: f32,
    /// Number of places from which it was seen.
    views: u8,
    last_view: u16,
    /// Sum of the directions towards the sensor.
    towards: [f32; 2],
    /// Sums over the returns, from the column's middle: x, y, xx, xy, yy.
    sums: [f32; 5],
}

const EMPTY: Column = Column {
    returns: 0,
    low: f32::INFINITY,
    high: f32::NEG_INFINITY,
    views: 0,
    last_view: u16::MAX,
    towards: [0.0; 2],
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

impl Facade {
    /// The same in another frame; `by` is the pose of this frame in that one.
    pub(super) fn moved(&self, by: Pose2) -> Self {
        Self {
            at: by.transform(self.at.x, self.at.y),
            facing: wrap_angle(self.facing + by.yaw),
            views: self.views,
        }
    }

    /// Whether another piece can be of the same wall.
    fn is_continued_by(&self, other: &Self) -> bool {
        let (x, y) = (other.at.x - self.at.x, other.at.y - self.at.y);
        let (sine, cosine) = libm::sincos(self.facing);
        let (aside, along) = (x * cosine + y * sine, y * cosine - x * sine);
        aside.abs() < ASIDE_M
            && along.abs() < ALONG_M
            && wrap_angle(other.facing - self.facing).abs() < ALIKE_RAD
    }
}

/// A direction of the grid.
#[derive(Debug, Clone, Copy)]
enum Along {
    Row,
    Column,
}

/// Which surface a return is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Label {
    /// Possibly a facade: geometry decides.
    Facade,
    /// Not a facade.
    Other,
}

/// When and from where a return was measured.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight {
    /// Number of the scan.
    pub(super) scan: u16,
    /// Number of the place.
    pub(super) view: u16,
    /// Where the robot was when it began to see from this place.
    pub(super) from: MapPoint,
}

/// Returns of a stretch.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    grid: GridGeometry,
    columns: Vec<Column>,
    returns: Vec<Return>,
}

/// What the returns of a stretch show.
#[derive(Debug, Clone)]
pub(super) struct Surveyed {
    grid: GridGeometry,
    occupied: Vec<bool>,
    pub(super) facades: Vec<Facade>,
}

impl Surveyed {
    /// Whether something stands there.
    pub(super) fn is_occupied(&self, at: MapPoint) -> bool {
        self.grid
            .cell_at(at)
            .is_some_and(|cell| self.occupied[cell])
    }
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
            returns: Vec::new(),
            grid,
        }
    }

    /// Takes in a return at a height above the ground where the robot is.
    pub(super) fn add(&mut self, at: MapPoint, height: f32, label: Label, sight: &Sight) {
        let Some(cell) = self.grid.cell_at(at).filter(|_| height.is_finite()) else {
            return;
        };
        self.returns.push(Return {
            cell: cell as u32,
            height,
            scan: sight.scan,
        });
        let middle = self.grid.center(cell);
        let (x, y) = ((at.x - middle.x) as f32, (at.y - middle.y) as f32);
        let column = &mut self.columns[cell];
        column.low = column.low.min(height);
        if label == Label::Other {
            return;
        }
        column.returns += 1;
        column.high = column.high.max(height);
        if column.last_view != sight.view {
            column.last_view = sight.view;
            column.views = column.views.saturating_add(1);
        }
        column.towards[0] += (sight.from.x - at.x) as f32;
        column.towards[1] += (sight.from.y - at.y) as f32;
        for (sum, value) in column.sums.iter_mut().zip([x, y, x * x, x * y, y * y]) {
            *sum += value;
        }
    }

    /// What all returns together show.
    pub(super) fn survey(&self) -> Surveyed {
        let ground = self.ground();
        Surveyed {
            grid: self.grid,
            occupied: self.occupied(&ground),
            facades: self.facades(&ground),
        }
    }

    /// Height of the ground under each column, by the lowest return around it.
    fn ground(&self) -> Vec<f32> {
        let low = |cell: usize| self.columns[cell].low;
        let along_rows = self.least_around(low, Along::Row);
        self.least_around(|cell| along_rows[cell], Along::Column)
    }

    /// The least value within [`GROUND_CELLS`] columns or rows.
    fn least_around(&self, value: impl Fn(usize) -> f32, along: Along) -> Vec<f32> {
        let least = |cell: usize| {
            let (column, row) = self.grid.column_row(cell);
            let near = (-GROUND_CELLS..=GROUND_CELLS).filter_map(|k| match along {
                Along::Row => self.grid.cell_in(column + k, row),
                Along::Column => self.grid.cell_in(column, row + k),
            });
            near.map(&value).fold(f32::INFINITY, f32::min)
        };
        (0..self.grid.len()).map(least).collect()
    }

    fn occupied(&self, ground: &[f32]) -> Vec<bool> {
        /// Returns of something that a robot runs into.
        #[derive(Clone, Copy)]
        struct Body {
            returns: u32,
            scans: u16,
            last_scan: u16,
        }
        let nothing = Body {
            returns: 0,
            scans: 0,
            last_scan: u16::MAX,
        };
        let mut bodies = vec![nothing; self.grid.len()];
        for seen in &self.returns {
            let cell = seen.cell as usize;
            if !BODY_M.contains(&(seen.height - ground[cell])) {
                continue;
            }
            let body = &mut bodies[cell];
            body.returns += 1;
            if body.last_scan != seen.scan {
                body.last_scan = seen.scan;
                body.scans += 1;
            }
        }
        let is_occupied =
            |body: &Body| body.returns >= OCCUPIED_RETURNS && body.scans >= OCCUPIED_SCANS;
        bodies.iter().map(is_occupied).collect()
    }

    /// A piece of a facade over a square, whatever is beside it.
    fn facade(&self, cell: usize, ground: &[f32]) -> Option<Facade> {
        let column = &self.columns[cell];
        let is_high =
            column.high - ground[cell] >= FACADE_TOP_M && column.high - column.low >= FACADE_SPAN_M;
        if !is_high || column.returns < FACADE_RETURNS {
            return None;
        }
        let eigen = SymmetricEigen::new(self.spread_around(cell, ground));
        let (short, long) = if eigen.eigenvalues[0] < eigen.eigenvalues[1] {
            (0, 1)
        } else {
            (1, 0)
        };
        let deviation = |i: usize| eigen.eigenvalues[i].max(0.0).sqrt();
        if deviation(short) > FACADE_THICKNESS_M || deviation(long) < FACADE_LENGTH_M {
            return None;
        }
        let middle = self.grid.center(cell);
        let n = f64::from(column.returns);
        let normal = eigen.eigenvectors.column(short);
        let towards = column.towards.map(f64::from);
        let side = if towards[0] * normal[0] + towards[1] * normal[1] < 0.0 {
            -1.0
        } else {
            1.0
        };
        Some(Facade {
            at: MapPoint::new(
                middle.x + f64::from(column.sums[0]) / n,
                middle.y + f64::from(column.sums[1]) / n,
            ),
            facing: libm::atan2(side * normal[1], side * normal[0]),
            views: column.views,
        })
    }

    /// The facades that belong to something longer.
    fn facades(&self, ground: &[f32]) -> Vec<Facade> {
        let cells = 0..self.columns.len();
        let pieces = cells.filter_map(|cell| {
            let (_, row) = self.grid.column_row(cell);
            Some((row, self.facade(cell, ground)?))
        });
        let pieces: Vec<(i64, Facade)> = pieces.collect();
        let reach = (ALONG_M / CELL_M) as i64 + 1;
        let is_continued = |(row, piece): &&(i64, Facade)| {
            let first = pieces.partition_point(|(other, _)| *other < row - reach);
            let last = pieces.partition_point(|(other, _)| *other <= row + reach);
            let near = pieces[first..last].iter();
            // One of them is the piece itself.
            let alike = near.filter(|(_, other)| piece.is_continued_by(other));
            alike.take(CONTINUED_BY + 1).count() > CONTINUED_BY
        };
        let continued = pieces.iter().filter(is_continued);
        continued.map(|(_, piece)| *piece).collect()
    }

    /// Covariance of the returns in a column and its neighbours that are high too.
    fn spread_around(&self, cell: usize, ground: &[f32]) -> Matrix2<f64> {
        let middle = self.grid.center(cell);
        let mut n = 0.0;
        let mut sum = Vector2::zeros();
        let mut squares = Matrix2::zeros();
        for near in std::iter::once(cell).chain(self.grid.neighbours(cell)) {
            let column = &self.columns[near];
            if column.returns == 0 || column.high - ground[near] < FACADE_TOP_M {
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

    /// A return: x, y and height, metres.
    type Xyh = (f64, f64, f32);

    /// What returns show, seen from one place in three scans.
    fn seen_from(from: MapPoint, returns: impl Iterator<Item = Xyh> + Clone) -> Surveyed {
        let mut columns = Columns::around(MapPoint::default());
        for scan in 0..3 {
            let sight = Sight {
                scan,
                view: 0,
                from,
            };
            for (x, y, height) in returns.clone() {
                columns.add(MapPoint::new(x, y), height, Label::Facade, &sight);
            }
        }
        columns.survey()
    }

    fn seen(returns: impl Iterator<Item = Xyh> + Clone) -> Surveyed {
        seen_from(MapPoint::default(), returns)
    }

    /// Returns from a wall along the x axis, 5 m north, up to a height.
    fn wall(top: f32) -> impl Iterator<Item = Xyh> + Clone {
        (0..60).flat_map(move |i| {
            let heights = (0..20).map(move |j| top * j as f32 / 20.0);
            heights.map(move |height| (0.1 * f64::from(i) - 3.0, 5.2, height))
        })
    }

    /// Ground that rises by one in ten to the north, up to 20 m away.
    fn slope() -> impl Iterator<Item = Xyh> + Clone {
        (0..80).flat_map(|i| {
            let y = 0.25 * f64::from(i);
            (0..80).map(move |j| (0.25 * f64::from(j) - 10.0, y, 0.1 * y as f32))
        })
    }

    #[test]
    fn a_high_wall_is_a_facade_that_faces_who_sees_it() {
        let facades = seen(wall(5.0)).facades;
        assert!((11..=13).contains(&facades.len()), "{}", facades.len());
        for facade in &facades {
            assert!((facade.at.y - 5.2).abs() < 1e-6, "{facade:?}");
            assert!((facade.facing + std::f64::consts::FRAC_PI_2).abs() < 1e-6);
        }
        let behind = seen_from(MapPoint::new(0.0, 9.0), wall(5.0)).facades;
        assert!((behind[0].facing - std::f64::consts::FRAC_PI_2).abs() < 1e-6);
    }

    #[test]
    fn a_fence_is_occupied_and_no_facade() {
        let fence = seen(wall(1.5));
        assert!(fence.is_occupied(MapPoint::new(0.1, 5.2)));
        assert!(!fence.is_occupied(MapPoint::new(0.1, 4.2)));
        assert!(fence.facades.is_empty());
    }

    #[test]
    fn rising_ground_is_free_and_a_wall_on_it_is_a_facade() {
        let free = seen(slope());
        assert!((0..19).all(|y| !free.is_occupied(MapPoint::new(0.1, f64::from(y)))));
        assert!(free.facades.is_empty());
        // A car of 1.6 m stands 1.5 m higher than the robot: its roof is no facade.
        let on_slope = |top: f32| {
            let raised = wall(top).map(|(x, y, height)| (x, y + 10.0, height + 1.52));
            seen(slope().chain(raised))
        };
        let car = on_slope(1.6);
        assert!(car.is_occupied(MapPoint::new(0.1, 15.2)));
        assert!(car.facades.is_empty());
        assert!(on_slope(4.0).facades.len() > 8);
    }

    #[test]
    fn what_is_gone_in_the_next_scan_occupies_nothing() {
        let mut columns = Columns::around(MapPoint::default());
        let sight = Sight {
            scan: 7,
            view: 0,
            from: MapPoint::default(),
        };
        for i in 0..30 {
            columns.add(
                MapPoint::new(3.1, 0.1),
                0.06 * i as f32,
                Label::Facade,
                &sight,
            );
        }
        assert!(!columns.survey().is_occupied(MapPoint::new(3.1, 0.1)));
    }

    #[test]
    fn a_tree_is_no_facade() {
        // A crown of two metres, filled evenly.
        let crown = (0..4000).map(|i| {
            let (a, r) = (f64::from(i) * 2.4, f64::from(i % 61) / 61.0);
            let height = 1.0 + (i % 37) as f32 * 0.1;
            (4.0 + r * libm::cos(a), r * libm::sin(a), height)
        });
        assert!(seen(crown).facades.is_empty());
    }

    #[test]
    fn a_piece_that_stands_alone_is_no_facade() {
        // A board of half a metre, as wide as the side of a trunk.
        let board = |x: f64| {
            let returns = wall(4.0).filter(move |(at, _, _)| (at - x).abs() < 0.26);
            seen(returns).facades.len()
        };
        assert_eq!(board(0.25), 0);
        let side = wall(4.0).filter(|(at, _, _)| at.abs() < 1.0);
        assert!(seen(side).facades.len() >= 3);
    }

    #[test]
    fn returns_far_away_and_numbers_that_are_none_are_left_out() {
        let odd = [(1e9, 0.0, 1.0), (f64::NAN, 0.0, 1.0), (1.0, 1.0, f32::NAN)];
        let odd = seen(odd.into_iter());
        assert!(odd.facades.is_empty() && !odd.is_occupied(MapPoint::new(1.0, 1.0)));
    }
}
