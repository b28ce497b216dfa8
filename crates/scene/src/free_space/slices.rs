//! Cells of a grid that solid triangles stop a robot in.

use openbench_core::MapPoint;
use openbench_geometry::grid::GridGeometry;

/// Half a cell's diagonal, in cells, rounded up.
const HALF_DIAGONAL: f64 = 0.71;

/// The part of a triangle between two heights, seen from above: a convex polygon.
pub(super) fn slice(corners: [[f64; 3]; 3], low: f64, high: f64) -> Option<Vec<MapPoint>> {
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
            let t = sa / (sa - sb);
            kept.push([0, 1, 2].map(|i| a[i] + t * (b[i] - a[i])));
        }
    }
    kept
}

/// Marks every cell that the convex `polygon` comes near to; a degenerate one is a line.
pub(super) fn draw(grid: &GridGeometry, polygon: &[MapPoint], blocked: &mut [bool]) {
    let Some(first) = polygon.first() else { return };
    let lower = |a: MapPoint, p: &MapPoint| MapPoint::new(a.x.min(p.x), a.y.min(p.y));
    let upper = |a: MapPoint, p: &MapPoint| MapPoint::new(a.x.max(p.x), a.y.max(p.y));
    let low = polygon.iter().fold(*first, lower);
    let high = polygon.iter().fold(*first, upper);
    let Some((columns, rows)) = grid.window(low, high) else {
        return;
    };
    for row in rows.0..=rows.1 {
        for cell in (columns.0..=columns.1).filter_map(|column| grid.cell_in(column, row)) {
            let reach = HALF_DIAGONAL * grid.cell;
            blocked[cell] = blocked[cell] || touches(polygon, grid.center(cell), reach);
        }
    }
}

/// Whether `p` lies in the convex polygon (of either orientation) or within `reach` of its edges.
fn touches(polygon: &[MapPoint], p: MapPoint, reach: f64) -> bool {
    let edges = || (0..polygon.len()).map(|i| [polygon[i], polygon[(i + 1) % polygon.len()]]);
    if edges().any(|[a, b]| distance_to_edge(p, a, b) <= reach) {
        return true;
    }
    let turn = |[a, b]: [MapPoint; 2]| (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    edges().map(turn).all(|t| t > 0.0) || edges().map(turn).all(|t| t < 0.0)
}

fn distance_to_edge(p: MapPoint, a: MapPoint, b: MapPoint) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let squared = dx * dx + dy * dy;
    let t = if squared > 0.0 {
        (((p.x - a.x) * dx + (p.y - a.y) * dy) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    p.distance(MapPoint::new(a.x + t * dx, a.y + t * dy))
}
