//! Cells of a grid around an obstacle.

use openbench_core::MapPoint;
use openbench_geometry::grid::GridGeometry;

use crate::shape::Obstacle;

/// Shows `visit` each cell of the box that reaches `reach` metres beyond an obstacle, with the
/// distance of its middle to the obstacle, metres.
pub(crate) fn each_cell_near(
    grid: &GridGeometry,
    obstacle: &Obstacle,
    reach: f64,
    mut visit: impl FnMut(usize, f64),
) {
    let (middle, far) = (obstacle.middle(), obstacle.radius() + reach);
    let low = MapPoint::new(middle.x - far, middle.y - far);
    let high = MapPoint::new(middle.x + far, middle.y + far);
    for cell in grid.cells_between(low, high) {
        visit(cell, obstacle.distance_to(grid.center(cell)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_within_reach_is_visited_once() {
        let grid = GridGeometry {
            origin: MapPoint::default(),
            width: 30,
            height: 20,
            cell: 0.1,
        };
        let disc = Obstacle::disc(MapPoint::new(1.0, 0.3), 0.2).unwrap();
        let mut visits = vec![0; grid.len()];
        each_cell_near(&grid, &disc, 0.4, |cell, distance| {
            assert_eq!(distance, disc.distance_to(grid.center(cell)));
            visits[cell] += 1;
        });
        for (cell, visits) in visits.into_iter().enumerate() {
            let is_near = disc.distance_to(grid.center(cell)) < 0.4;
            assert!(visits <= 1 && (visits == 1 || !is_near), "{cell}");
        }
    }
}
