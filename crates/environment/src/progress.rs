//! How far it is from anywhere to a door: for rewards only. The judge measures otherwise.

use openbench_core::MapPoint;
use openbench_geometry::grid::{Frontier, GridGeometry};
use openbench_scene::FreeSpace;

/// Cells of the free space on one side of a cell of the field.
const COARSER: usize = 3;
/// The length of the way from each place to a goal, along a grid of eight directions: up to 8 %
/// longer than the shortest way.
#[derive(Debug, Clone)]
pub struct WayField {
    grid: GridGeometry,
    goal: MapPoint,
    /// Metres from the middle of each cell; infinite where there is no way.
    lengths: Vec<f32>,
}

impl WayField {
    /// The field of a goal.
    pub fn new(space: &FreeSpace, goal: MapPoint) -> Self {
        let grid = coarser(space.grid());
        let is_free = |cell: &usize| space.is_reachable(grid.center(*cell));
        let mut lengths = vec![f32::INFINITY; grid.len()];
        let mut frontier = Frontier::default();
        // From all cells about the goal, whose own cell may have its middle in a wall.
        for cell in around(&grid, goal).filter(is_free) {
            let length = grid.center(cell).distance(goal);
            lengths[cell] = length as f32;
            frontier.push(length, cell);
        }
        while let Some((length, cell)) = frontier.pop() {
            // Reached by a shorter way since.
            if length as f32 > lengths[cell] {
                continue;
            }
            for next in grid.neighbours(cell).filter(is_free) {
                let longer = length + grid.cell * grid.cells_apart(cell, next);
                if (longer as f32) < lengths[next] {
                    lengths[next] = longer as f32;
                    frontier.push(longer, next);
                }
            }
        }
        Self {
            grid,
            goal,
            lengths,
        }
    }

    /// Length of the way from a place, metres; `None` where there is none.
    pub fn length(&self, from: MapPoint) -> Option<f64> {
        // Straight where the goal is near, since a grid says little there.
        let straight = from.distance(self.goal);
        if straight < 2.0 * self.grid.cell {
            return Some(straight);
        }
        let over =
            |cell: usize| f64::from(self.lengths[cell]) + self.grid.center(cell).distance(from);
        let shortest = around(&self.grid, from).map(over).min_by(f64::total_cmp)?;
        Some(shortest).filter(|length| length.is_finite())
    }
}

/// A grid with larger cells over the same place.
fn coarser(grid: &GridGeometry) -> GridGeometry {
    GridGeometry {
        cell: grid.cell * COARSER as f64,
        width: grid.width.div_ceil(COARSER),
        height: grid.height.div_ceil(COARSER),
        ..*grid
    }
}

/// The cell of a place and the cells about it.
fn around(grid: &GridGeometry, place: MapPoint) -> impl Iterator<Item = usize> {
    let cell = grid.cell_at(place).into_iter();
    cell.flat_map(|cell| grid.neighbours(cell).chain([cell]))
}

#[cfg(test)]
mod tests {
    use openbench_bench::{Prepared, builtin_suite};

    use super::*;

    #[test]
    fn ways_are_as_long_as_the_shortest_paths_to_some_percent() {
        let prepared = Prepared::new(builtin_suite("small").unwrap(), None).unwrap();
        let goal = prepared.approach[0].unwrap();
        let field = WayField::new(&prepared.free_space, goal);
        let mut compared = 0;
        for from in prepared.approach.iter().flatten() {
            let (way, shortest) = (
                field.length(*from).unwrap(),
                prepared.free_space.distance(*from, goal).unwrap(),
            );
            // A cell more at both ends, where ways go from middle to middle.
            assert!(
                way > shortest - 0.7 && way < 1.09 * shortest + 0.7,
                "{way} {shortest}"
            );
            compared += 1;
        }
        assert!(compared > 3);
    }

    #[test]
    fn a_small_step_towards_the_goal_shortens_the_way_a_little() {
        let prepared = Prepared::new(builtin_suite("small").unwrap(), None).unwrap();
        let goal = prepared.approach[1].unwrap();
        let field = WayField::new(&prepared.free_space, goal);
        let path = prepared
            .free_space
            .path(prepared.world.start.point(), goal)
            .unwrap();
        let mut last = field.length(path[0]).unwrap();
        for corner in path.windows(2) {
            let steps = (corner[0].distance(corner[1]) / 0.025) as usize;
            for step in 1..=steps {
                let part = step as f64 / steps as f64;
                let place = MapPoint::new(
                    corner[0].x + part * (corner[1].x - corner[0].x),
                    corner[0].y + part * (corner[1].y - corner[0].y),
                );
                let length = field.length(place).unwrap();
                assert!((length - last).abs() < 0.3, "{length} after {last}");
                last = length;
            }
        }
        assert!(last < 0.1);
    }

    #[test]
    fn there_is_no_way_out_of_a_wall() {
        let prepared = Prepared::new(builtin_suite("small").unwrap(), None).unwrap();
        let field = WayField::new(&prepared.free_space, prepared.approach[0].unwrap());
        assert_eq!(field.length(MapPoint::new(1e6, 0.0)), None);
    }
}
