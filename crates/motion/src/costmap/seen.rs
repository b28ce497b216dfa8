//! What the LiDAR saw: evidence for and against something in each cell.

use openbench_core::MapPoint;
use openbench_grid::GridGeometry;

use crate::obstacles::{Beam, RangeRing, ScanPoint};

/// Evidence of one hit, and its bounds; one miss counts -1.
const HIT: i8 = 4;
const EVIDENCE: (i8, i8) = (-6, 12);
/// Evidence below which a cell is known to be free.
const FREE: i8 = -3;
/// A beam clears one line of cells as far as so many cells, where its degree is two thirds of a
/// cell wide. It clears two lines as far again, and so on to so many lines.
const LINE: usize = 38;
const LINES: usize = 4;
/// Beyond that every fourth scan clears: what stands there is not yet in the way, metres.
const NEAR: f64 = 20.0;
const FAR_EVERY: u16 = 4;
/// No beam is believed to reach further, metres.
const FURTHEST: f64 = 500.0;
/// Scans after which an obstacle that is not seen again is forgotten: a minute of a LiDAR that scans ten times a second.
const MEMORY: u16 = 600;
/// Scans ago that are a moment: two seconds of it.
const MOMENT: u16 = 20;

/// What is known of one cell.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    evidence: i8,
    /// Height above the ground of the highest hit since it was last free, centimetres.
    top: u8,
    /// Number of the scan that last hit it.
    hit_in: u16,
    /// Number of the scan by which it was last known to be free; 0 if never.
    free_in: u16,
    /// Number of the scan that last cleared it: beams crowd near the sensor, and one scan is one piece of evidence.
    cleared_in: u16,
}

/// Evidence for each cell of a grid.
#[derive(Debug, Clone)]
pub struct Seen {
    cells: Vec<Cell>,
    /// Number of the newest scan. Numbers begin anew before there are too many of them for a cell to hold.
    scans: u16,
}

impl Seen {
    /// Nothing was seen yet.
    pub fn nothing(cells: usize) -> Self {
        Self { cells: vec![Cell::default(); cells], scans: 0 }
    }

    /// Whether something was seen in a cell.
    pub fn is_hit(&self, cell: usize) -> bool {
        self.cells[cell].evidence > 0
    }

    /// Whether nothing was seen in a cell so often that there is nothing.
    pub fn is_free(&self, cell: usize) -> bool {
        self.cells[cell].evidence <= FREE
    }

    /// Whether a cell was free a moment ago.
    pub fn was_free(&self, cell: usize) -> bool {
        let free_in = self.cells[cell].free_in;
        free_in > 0 && self.scans - free_in < MOMENT
    }

    /// Believes from now on that nothing is in a cell.
    pub fn clear(&mut self, cell: usize) {
        self.cells[cell].evidence = EVIDENCE.0;
    }

    /// Takes in what a scan shows, without the points of which `moves` says that they do not stay.
    pub fn observe(&mut self, grid: &GridGeometry, ring: &RangeRing, moves: impl Fn(MapPoint) -> bool) {
        self.count();
        let furthest = if self.scans.is_multiple_of(FAR_EVERY) { FURTHEST } else { NEAR };
        for (degrees, &beam) in ring.beams.iter().enumerate() {
            let bearing = |part: f64| (degrees as f64 + part).to_radians();
            for lines in 1..=LINES {
                let end = if lines == LINES { usize::MAX } else { lines * LINE };
                let part = (lines - 1) * LINE..end;
                if beam.reach.min(furthest) < part.start as f64 * grid.cell {
                    break;
                }
                for line in 0..lines {
                    let bearing = bearing((line as f64 + 0.5) / lines as f64);
                    self.mark_clear(grid, ring, (beam, bearing), (furthest, part.clone()));
                }
            }
        }
        for &ScanPoint { at, height } in &ring.obstacles {
            let Some(cell) = grid.cell_at(at).filter(|_| !moves(at)) else { continue };
            let cell = &mut self.cells[cell];
            let before = if cell.evidence > 0 { cell.top } else { 0 };
            cell.top = before.max((height * 100.0) as u8);
            if cell.hit_in != self.scans {
                cell.evidence = (cell.evidence.max(0) + HIT).min(EVIDENCE.1);
                cell.hit_in = self.scans;
            }
        }
    }

    /// Counts a scan.
    fn count(&mut self) {
        if self.scans == u16::MAX {
            // What was longer ago than anybody asks for was never.
            let kept = 2 * MEMORY;
            let gone = self.scans - kept;
            for cell in &mut self.cells {
                for number in [&mut cell.hit_in, &mut cell.free_in, &mut cell.cleared_in] {
                    *number = number.saturating_sub(gone);
                }
            }
            self.scans = kept;
        }
        self.scans += 1;
    }

    /// Counts against every obstacle that is high enough for a beam to have hit it on a part of its
    /// way, counted in cells, as far as `furthest` metres.
    fn mark_clear(
        &mut self,
        grid: &GridGeometry,
        ring: &RangeRing,
        (beam, bearing): (Beam, f64),
        (furthest, part): (f64, std::ops::Range<usize>),
    ) {
        let (sin, cos) = libm::sincos(bearing);
        // Stop short of what was hit, by a cell's diagonal.
        let steps = (beam.reach.min(furthest) - 1.5 * grid.cell) / grid.cell;
        // In cells, since divisions at each step would take longer than all the rest.
        let [x, y] = [ring.center.x - grid.origin.x, ring.center.y - grid.origin.y].map(|at| at / grid.cell);
        let [width, height] = [grid.width as f64, grid.height as f64];
        // Beams reach farther than many a grid.
        let within = steps_within(grid, ring.center, [cos, sin], steps);
        for i in within.start.max(part.start)..within.end.min(part.end) {
            let (x, y) = (x + i as f64 * cos, y + i as f64 * sin);
            // Written so that what is no number is nowhere.
            if !(x >= 0.0 && y >= 0.0 && x < width && y < height) {
                continue;
            }
            let cell = &mut self.cells[y as usize * grid.width + x as usize];
            if cell.cleared_in == self.scans {
                continue;
            }
            let passes_over =
                cell.evidence > 0 && f64::from(cell.top) < 100.0 * ring.height_at(beam, i as f64 * grid.cell);
            if !passes_over {
                cell.cleared_in = self.scans;
                cell.evidence = (cell.evidence - 1).max(EVIDENCE.0);
                if cell.evidence <= FREE {
                    cell.free_in = self.scans;
                }
            }
        }
    }

    /// Forgets obstacles that were not seen for a minute: they may have moved, and the robot's idea of where it was then has drifted from its idea of now.
    pub fn forget(&mut self) {
        for cell in &mut self.cells {
            if cell.evidence > 0 && self.scans - cell.hit_in > MEMORY {
                cell.evidence = 0;
            }
        }
    }

    /// Moves what is known from one grid over to another with cells of the same size in the same places.
    pub fn carry(&mut self, from: &GridGeometry, to: &GridGeometry) {
        let cells = |a: f64, b: f64| ((a - b) / to.cell).round() as i64;
        let (columns, rows) = (cells(to.origin.x, from.origin.x), cells(to.origin.y, from.origin.y));
        let old = std::mem::replace(&mut self.cells, vec![Cell::default(); to.len()]);
        for (cell, known) in self.cells.iter_mut().enumerate() {
            let (x, y) = to.column_row(cell);
            if let Some(before) = from.cell_in(x + columns, y + rows) {
                *known = old[before];
            }
        }
    }
}

/// Those of the first `steps` steps of a cell's side each in a direction that lie on a grid, and a step before and after.
fn steps_within(
    grid: &GridGeometry,
    from: MapPoint,
    direction: [f64; 2],
    steps: f64,
) -> std::ops::Range<usize> {
    let (mut first, mut end) = (0.0_f64, steps);
    let sides = [
        (from.x - grid.origin.x, direction[0], grid.width as f64),
        (from.y - grid.origin.y, direction[1], grid.height as f64),
    ];
    for (at, way, cells) in sides {
        let at = at / grid.cell;
        let (near, far) = (-at / way, (cells - at) / way);
        // Along a side both are infinite, or no numbers on it; then the other direction decides.
        first = first.max(near.min(far) - 1.0);
        end = end.min(near.max(far) + 1.0);
    }
    // Casts take what is below zero, or no number, for zero.
    first as usize..end.max(first) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a line of cells that beams pass over, and of one that is hit.
    fn after(scans: u32) -> [Cell; 2] {
        let grid = GridGeometry { origin: MapPoint::new(-1.0, -1.0), width: 40, height: 20, cell: 0.1 };
        let mut seen = Seen::nothing(grid.len());
        let post = MapPoint::new(2.05, 0.05);
        let ring = RangeRing::new(MapPoint::default(), 0.25, std::iter::once(ScanPoint::new(post, 0.3)));
        (0..scans).for_each(|_| seen.observe(&grid, &ring, |_| false));
        seen.forget();
        [MapPoint::new(1.05, 0.02), post].map(|at| seen.cells[grid.cell_at(at).unwrap()])
    }

    #[test]
    fn what_is_known_does_not_depend_on_how_many_scans_there_were() {
        let [free, hit] = after(1000);
        assert!(free.evidence <= FREE && hit.evidence == EVIDENCE.1);
        for scans in [u32::from(u16::MAX) - 1, u32::from(u16::MAX) + 1, 200_000] {
            let [late_free, late_hit] = after(scans);
            assert_eq!((late_free.evidence, late_hit.evidence), (free.evidence, hit.evidence), "{scans}");
        }
    }
}
