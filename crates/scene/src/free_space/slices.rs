//! Cells of a grid that solid triangles stop a robot in.

use openbench_core::MapPoint;
use openbench_geometry::grid::GridGeometry;
use openbench_geometry::{Bounds, sides, turn};

/// Half a cell's diagonal, in cells, rounded up.
const HALF_DIAGONAL: f64 = 0.71;

/// The part of a triangle between two heights, seen from above: a convex polygon.
pub(super) fn slice(corners: [[f64; 3]; 3], low: f64, high: f64) -> Option<Vec<MapPoint>> {
    // Clipped in space first: of a leaning surface only the part at the robot's height is in the
    // way.
    let above = clip(&corners, |p| p[2] - low);
    let within = clip(&above, |p| high - p[2]);
    (!within.is_empty()).then(|| within.iter().map(|p| MapPoint::new(p[0], p[1])).collect())
}

/// The part of a convex polygon where `side` is not negative (Sutherland and Hodgman 1974).
fn clip(polygon: &[[f64; 3]], side: impl Fn(&[f64; 3]) -> f64) -> Vec<[f64; 3]> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        let (sa, sb) = (side(a), side(b));
        if sa >= 0.0 {
            kept.push(*a);
        }
        if (sa < 0.0) != (sb < 0.0) {
            // The ends lie on different sides, so the difference is not zero.
            let t = sa / (sa - sb);
            kept.push([0, 1, 2].map(|i| a[i] + t * (b[i] - a[i])));
        }
    }
    kept
}

/// Marks every cell that the convex `polygon` comes near to; a degenerate one is a line.
pub(super) fn draw(grid: &GridGeometry, polygon: &[MapPoint], blocked: &mut [bool]) {
    let Some(first) = polygon.first() else { return };
    let Bounds { low, high } = polygon
        .iter()
        .map(|p| Bounds::of_point(*p))
        .fold(Bounds::of_point(*first), Bounds::union);
    let Some((columns, rows)) = grid.window(low, high) else {
        return;
    };
    for row in rows.0..=rows.1 {
        for cell in (columns.0..=columns.1).filter_map(|column| grid.cell_in(column, row)) {
            // A surface anywhere in the cell is within half a diagonal of its middle.
            let reach = HALF_DIAGONAL * grid.cell;
            blocked[cell] = blocked[cell] || touches(polygon, grid.center(cell), reach);
        }
    }
}

/// Whether `p` lies in the convex polygon (of either orientation) or within `reach` of its edges.
fn touches(polygon: &[MapPoint], p: MapPoint, reach: f64) -> bool {
    if sides(polygon).any(|side| side.distance_to_point(p) <= reach) {
        return true;
    }
    // Inside a convex polygon, all sides have the point on the same hand. A polygon without area
    // has no inside, and its edges count alone.
    let turns = || sides(polygon).map(|side| turn(side.start, side.end, p));
    turns().all(|t| t > 0.0) || turns().all(|t| t < 0.0)
}
