//! Partition of the network into nested cells.
//!
//! Delling, Goldberg, Pajor, Werneck, *Customizable Route Planning in Road Networks*,
//! Transportation Science 2017: the distances through a cell are computed once and serve every
//! search that passes through it, so cells should have few edges between them.
//!
//! Cells come from repeated bisection (`inertial`): the network is bisected until its parts fit the
//! largest cells, these until they fit the next smaller ones, and so on. Each cell is a range of
//! vertices if these are in the order in which bisection leaves them.
//!
//! | module | contents |
//! |---|---|
//! | `inertial` | bisection with few edges between the halves |
//! | `flow` | minimum cuts |

mod flow;
mod inertial;

use crate::geo::Place;
use inertial::{Halver, Part};

/// The halves of parts larger than this are bisected in parallel.
const SEQUENTIAL_SIZE: usize = 10_000;

/// The most vertices in a cell of each level.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CellSizes(Vec<usize>);

/// Cell sizes that are not ascending, or out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cell sizes must be 1 to 7 numbers from 2 to 1073741824, each larger than the one before")]
pub struct CellSizesError;

impl CellSizes {
    /// The most vertices in a cell, smallest cells first.
    ///
    /// # Errors
    /// If the sizes do not ascend, are out of range, or there are none or more than seven.
    pub fn new(sizes: &[usize]) -> Result<Self, CellSizesError> {
        let ascending = sizes.windows(2).all(|pair| pair[0] < pair[1]);
        let fits = sizes.iter().all(|size| (2..=1 << 30).contains(size));
        let good = (1..=7).contains(&sizes.len()) && ascending && fits;
        if good {
            Ok(Self(sizes.to_vec()))
        } else {
            Err(CellSizesError)
        }
    }
}

impl Default for CellSizes {
    /// Measured best on a city of 100,000 vertices, and extrapolated. Levels too large for a
    /// network are left out.
    fn default() -> Self {
        Self(vec![32, 256, 2048, 16_384, 131_072, 1 << 20, 1 << 23])
    }
}

/// Vertices in cells.
#[derive(Debug, Clone, Default)]
pub struct Partition {
    /// The vertices in their new order.
    pub order: Vec<u32>,
    /// For each level, smallest cells first: the begin of each cell in that order, and the end of
    /// the last one.
    pub levels: Vec<Vec<u32>>,
}

impl Partition {
    /// Puts vertices into cells. Levels whose cells could contain the whole network are left out.
    pub fn new(places: &[Place], edges: &[[u32; 2]], sizes: &CellSizes) -> Self {
        let levels = sizes
            .0
            .iter()
            .take_while(|size| **size < places.len())
            .count();
        let mut partition = Self::of_part(
            Part::new(places, edges),
            levels,
            sizes,
            &mut Halver::default(),
        );
        partition
            .levels
            .iter_mut()
            .for_each(|level| level.push(places.len() as u32));
        partition
    }

    /// The cells of a part that is larger than cells of `level` and above may be, without the end
    /// of the last one.
    fn of_part(part: Part, mut level: usize, sizes: &CellSizes, halver: &mut Halver) -> Self {
        let mut partition = Self {
            order: Vec::new(),
            levels: vec![Vec::new(); level],
        };
        // The part fits a cell of this level: it is one, and begins at 0 within itself. It may be a
        // cell of several levels at once.
        while level > 0 && part.len() <= sizes.0[level - 1] {
            level -= 1;
            partition.levels[level].push(0);
        }
        if level == 0 {
            partition.order = part.vertices;
            return partition;
        }
        let (size, [first, second]) = (part.len(), halver.halve(&part));
        // Frees the memory before the halves are bisected further.
        drop(part);
        let (first, second) = if size > SEQUENTIAL_SIZE {
            // Each thread needs memory of its own.
            let of_part = |part| Self::of_part(part, level, sizes, &mut Halver::default());
            rayon::join(|| of_part(first), || of_part(second))
        } else {
            (
                Self::of_part(first, level, sizes, halver),
                Self::of_part(second, level, sizes, halver),
            )
        };
        for (all, half) in partition.levels.iter_mut().zip(first.levels) {
            all.extend(half);
        }
        let begin = first.order.len() as u32;
        for (all, half) in partition.levels.iter_mut().zip(second.levels) {
            // The second half's cells follow all vertices of the first.
            all.extend(half.iter().map(|start| start + begin));
        }
        partition.order = first.order;
        partition.order.extend(second.order);
        partition
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn grid(width: u32, height: u32) -> (Vec<Place>, Vec<[u32; 2]>) {
        let places = (0..width * height).map(|i| Place {
            lon: (i % width) as i32,
            lat: (i / width) as i32,
        });
        let across = (0..width * height)
            .filter(|i| i % width > 0)
            .map(|i| [i - 1, i]);
        let up = (width..width * height).map(|i| [i - width, i]);
        (places.collect(), across.chain(up).collect())
    }

    /// The number of edges between cells of a level.
    fn cut(partition: &Partition, level: usize, edges: &[[u32; 2]]) -> usize {
        let mut position = vec![0; partition.order.len()];
        for (i, vertex) in partition.order.iter().enumerate() {
            position[*vertex as usize] = i as u32;
        }
        let cell = |v: u32| {
            partition.levels[level].partition_point(|start| *start <= position[v as usize])
        };
        edges.iter().filter(|[a, b]| cell(*a) != cell(*b)).count()
    }

    #[test]
    fn two_towns_are_cut_at_the_bridge() {
        let (mut places, mut edges) = grid(8, 8);
        let (other, more) = grid(8, 8);
        places.extend(other.iter().map(|p| Place {
            lon: p.lon + 20,
            lat: p.lat,
        }));
        edges.extend(more.iter().map(|ends| ends.map(|end| end + 64)));
        edges.push([7, 64]);
        let partition = Partition::new(&places, &edges, &CellSizes::new(&[64]).unwrap());
        assert_eq!(
            (partition.levels[0].as_slice(), cut(&partition, 0, &edges)),
            ([0, 64, 128].as_slice(), 1)
        );
    }

    #[test]
    fn squares_are_cut_straight() {
        let (places, edges) = grid(32, 32);
        let partition = Partition::new(&places, &edges, &CellSizes::new(&[300]).unwrap());
        // Three straight cuts through all, or two and then two through the rest.
        assert!(
            cut(&partition, 0, &edges) <= 100,
            "{}",
            cut(&partition, 0, &edges)
        );
    }

    #[test]
    fn a_network_in_one_place_is_bisected_too() {
        let places = vec![Place::default(); 100];
        let partition = Partition::new(&places, &[], &CellSizes::new(&[2, 7]).unwrap());
        assert!(
            partition.levels[0]
                .windows(2)
                .all(|cell| cell[1] - cell[0] <= 2)
        );
        assert!(
            Partition::new(&[], &[], &CellSizes::default())
                .levels
                .is_empty()
        );
    }

    #[test]
    fn cell_sizes_must_ascend() {
        for bad in [
            [].as_slice(),
            &[1],
            &[8, 8],
            &[16, 8],
            &[2, 1 << 31],
            &[2, 3, 4, 5, 6, 7, 8, 9],
        ] {
            assert_eq!(CellSizes::new(bad), Err(CellSizesError));
        }
    }

    proptest! {
        #[test]
        fn every_vertex_is_in_one_cell_of_each_level_and_cells_are_nested(
            places in proptest::collection::vec((-50_i32..50, -50_i32..50), 1..200),
            edges in proptest::collection::vec((0_u32..200, 0_u32..200), 0..400),
        ) {
            let place = |(lon, lat): (i32, i32)| Place { lon, lat };
            let places: Vec<Place> = places.into_iter().map(place).collect();
            let count = places.len() as u32;
            let edges: Vec<_> = edges.iter().map(|(a, b)| [a % count, b % count]).collect();
            let sizes = [3, 10, 40];
            let partition = Partition::new(&places, &edges, &CellSizes::new(&sizes).unwrap());
            let mut all = partition.order.clone();
            all.sort_unstable();
            prop_assert!(all.iter().copied().eq(0..count));
            for (level, cells) in partition.levels.iter().enumerate() {
                prop_assert_eq!((cells[0], cells[cells.len() - 1]), (0, count));
                let largest = sizes[level] as u32;
                let fits = |cell: &[u32]| cell[0] < cell[1] && cell[1] - cell[0] <= largest;
                prop_assert!(cells.windows(2).all(fits));
                let above = partition.levels.get(level + 1).into_iter().flatten();
                prop_assert!(above.copied().all(|start| cells.contains(&start)));
            }
        }
    }
}
