//! Points near a point: a uniform grid of unbounded extent. Its cells are hashed into about twice
//! as many buckets as there are points.
//!
//! Building and searching take time in proportion to the points, however large the map is, and
//! allocate nothing once the buffers have grown.

use openbench_core::MapPoint;

/// Points by cell.
#[derive(Debug, Clone)]
pub(super) struct Neighbours {
    /// Side of a cell, metres.
    side: f64,
    /// Where each bucket begins in `entries`; one more at the end.
    first: Vec<u32>,
    entries: Vec<Entry>,
    unsorted: Vec<Entry>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Cell {
    column: i32,
    row: i32,
}

#[derive(Debug, Clone, Copy, Default)]
struct Entry {
    cell: Cell,
    index: u32,
}

impl Neighbours {
    /// Cells with this side in metres: [`near`](Self::near) misses no point within that distance.
    pub fn new(side: f64) -> Self {
        Self {
            side,
            first: Vec::new(),
            entries: Vec::new(),
            unsorted: Vec::new(),
        }
    }

    /// Takes in new points; their indices count up from 0. Those that are `None` are left out.
    pub fn fill(&mut self, points: impl Iterator<Item = Option<MapPoint>>) {
        self.unsorted.clear();
        for (index, point) in points.enumerate() {
            let Some(point) = point else { continue };
            self.unsorted.push(Entry {
                cell: self.cell_of(point),
                index: index as u32,
            });
        }
        // A power of two, so that a mask takes the place of a division.
        let buckets = (2 * self.unsorted.len()).next_power_of_two();
        self.first.clear();
        self.first.resize(buckets + 1, 0);
        for entry in &self.unsorted {
            self.first[entry.cell.bucket(buckets) + 1] += 1;
        }
        for i in 1..self.first.len() {
            self.first[i] += self.first[i - 1];
        }
        // Filled from behind, each bucket's begin moves to its place; points of a cell stay in
        // order.
        self.entries.clear();
        self.entries.resize(self.unsorted.len(), Entry::default());
        for i in (0..self.unsorted.len()).rev() {
            let entry = self.unsorted[i];
            let end = &mut self.first[entry.cell.bucket(buckets) + 1];
            *end -= 1;
            self.entries[*end as usize] = entry;
        }
        // Each begin stands one place too far right now; the first place held a 0 that nobody
        // needs.
        self.first.rotate_left(1);
        self.first[buckets] = self.entries.len() as u32;
    }

    /// Calls `visit` with every point in the nine cells about `point`, in a fixed order: all points
    /// within one cell's side, and some farther off.
    pub fn near(&self, point: MapPoint, mut visit: impl FnMut(usize)) {
        if self.entries.is_empty() {
            return;
        }
        let Cell { column, row } = self.cell_of(point);
        let buckets = self.first.len() - 1;
        // Saturating, since casts of absurd coordinates end at the bounds of the integers.
        for row in row.saturating_sub(1)..=row.saturating_add(1) {
            for column in column.saturating_sub(1)..=column.saturating_add(1) {
                let cell = Cell { column, row };
                let bucket = cell.bucket(buckets);
                let range = self.first[bucket] as usize..self.first[bucket + 1] as usize;
                for entry in self.entries[range]
                    .iter()
                    // Different cells may share a bucket.
                    .filter(|entry| entry.cell == cell)
                {
                    visit(entry.index as usize);
                }
            }
        }
    }

    fn cell_of(&self, point: MapPoint) -> Cell {
        Cell {
            column: (point.x / self.side).floor() as i32,
            row: (point.y / self.side).floor() as i32,
        }
    }
}

impl Cell {
    /// After Teschner et al., *Optimized Spatial Hashing for Collision Detection of Deformable
    /// Objects*, 2003.
    fn bucket(self, buckets: usize) -> usize {
        let column = (self.column as u32).wrapping_mul(73_856_093);
        let row = (self.row as u32).wrapping_mul(19_349_663);
        (column ^ row) as usize & (buckets - 1)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn every_point_nearby_is_visited_once(
            points in prop::collection::vec((-30.0..30.0, -30.0..30.0), 0..60)
        ) {
            let points: Vec<MapPoint> =
                points.into_iter().map(|(x, y)| MapPoint::new(x, y)).collect();
            let mut neighbours = Neighbours::new(4.0);
            neighbours.fill(points.iter().map(|p| Some(*p)));
            for p in &points {
                let mut seen = vec![0; points.len()];
                neighbours.near(*p, |i| seen[i] += 1);
                for (q, seen) in points.iter().zip(&seen) {
                    prop_assert!(*seen <= 1);
                    prop_assert!(*seen == 1 || p.distance(*q) > 4.0);
                }
            }
        }
    }
}
