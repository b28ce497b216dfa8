//! The rays that a step between columns of a grid crosses.

use openbench_core::MapPoint;
use openbench_geometry::grid::GridGeometry;

/// Which rays a step from each column to the next one east crosses, if it is north of their
/// clusters.
#[derive(Debug, Default)]
pub(super) struct Crossings {
    /// Numbers of clusters, column by column.
    clusters: Vec<usize>,
    /// For each column where its own begin.
    first: Vec<usize>,
}

impl Crossings {
    /// Sorts clusters into the columns of a grid.
    pub(super) fn lay(&mut self, grid: &GridGeometry, standing: &[MapPoint]) {
        self.clusters.clear();
        self.first.clear();
        for column in 0..grid.width {
            self.first.push(self.clusters.len());
            let crossed = standing.iter().enumerate().filter(|(_, cluster)| {
                column + 1 < grid.width
                    && is_west(grid, column, cluster) != is_west(grid, column + 1, cluster)
            });
            self.clusters.extend(crossed.map(|(number, _)| number));
        }
        self.first.push(self.clusters.len());
    }

    /// Those between two columns that are the same or neighbours.
    pub(super) fn between(&self, a: i64, b: i64) -> &[usize] {
        let column = a.min(b) as usize;
        if a == b {
            &[]
        } else {
            &self.clusters[self.first[column]..self.first[column + 1]]
        }
    }
}

/// Whether the middle of a column lies west of a cluster.
fn is_west(grid: &GridGeometry, column: usize, cluster: &MapPoint) -> bool {
    grid.center(column).x < cluster.x
}
