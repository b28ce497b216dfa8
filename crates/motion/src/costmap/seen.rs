//! The layer of the LiDAR: evidence for and against an obstacle in each cell.

use std::ops::Range;

use openbench_core::MapPoint;
use openbench_geometry::grid::GridGeometry;

use crate::obstacles::{Beam, RangeRing, ScanPoint};
use crate::vector::Vector2;

/// Evidence of one hit; a beam that passes counts -1.
const HIT: i8 = 4;
/// Least evidence.
const LEAST: i8 = -6;
/// Most evidence.
const MOST: i8 = 12;
/// Evidence up to which a cell is known to be free.
const FREE: i8 = -3;
/// A beam stands for one degree. It clears one line of cells up to this many cells away, where a
/// degree is two thirds of a cell wide; two lines as far again, and so on.
const LINE: usize = 38;
/// Lines of cells that a beam clears at most.
const LINES: usize = 4;
/// Beyond this distance only every fourth scan clears, metres: obstacles there do not matter yet.
const NEAR_M: f64 = 20.0;
/// See [`NEAR_M`].
const FAR_EVERY: u16 = 4;
/// No beam reaches further, metres.
const FURTHEST_M: f64 = 500.0;
/// Scans after which an obstacle that is not seen again is forgotten: a minute at 10 Hz.
const MEMORY_SCANS: u16 = 600;
/// Scans that make a moment: two seconds at 10 Hz.
const MOMENT_SCANS: u16 = 20;

/// What is known of one cell.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    /// From [`LEAST`] (free) to [`MOST`] (an obstacle).
    evidence: i8,
    /// Height above the ground of the highest hit since it was last free, centimetres.
    top: u8,
    /// Number of the scan that last hit it.
    hit_in: u16,
    /// Number of the scan by which it was last known to be free; 0 if never.
    free_in: u16,
    /// Number of the scan that last cleared it: many beams pass near the sensor, and one scan is
    /// one piece of evidence.
    cleared_in: u16,
}

/// A line of cells that a beam clears.
struct Line {
    beam: Beam,
    /// Radians counter-clockwise from east.
    bearing: f64,
    /// Metres.
    furthest: f64,
    /// The part of the line, in steps of a cell's side.
    part: Range<usize>,
}

/// Evidence for each cell of a grid.
#[derive(Debug, Clone)]
pub(crate) struct Seen {
    cells: Vec<Cell>,
    /// Number of the newest scan. Numbers are lowered before a cell cannot hold them.
    scans: u16,
}

impl Seen {
    /// Without any data.
    pub(crate) fn nothing(cells: usize) -> Self {
        Self {
            cells: vec![Cell::default(); cells],
            scans: 0,
        }
    }

    /// Whether an obstacle was seen in a cell.
    pub(crate) fn is_hit(&self, cell: usize) -> bool {
        self.cells[cell].evidence > 0
    }

    /// Whether beams passed a cell so often that it is free.
    pub(crate) fn is_free(&self, cell: usize) -> bool {
        self.cells[cell].evidence <= FREE
    }

    /// Whether a cell was free within the last two seconds.
    pub(crate) fn was_free(&self, cell: usize) -> bool {
        let free_in = self.cells[cell].free_in;
        free_in > 0 && self.scans - free_in < MOMENT_SCANS
    }

    /// Marks a cell as free.
    pub(crate) fn clear(&mut self, cell: usize) {
        self.cells[cell].evidence = LEAST;
    }

    /// Takes in a scan, without the points for which `moves` says that they belong to moving
    /// bodies.
    pub(crate) fn observe(
        &mut self,
        grid: &GridGeometry,
        ring: &RangeRing,
        moves: impl Fn(MapPoint) -> bool,
    ) {
        self.count();
        // Before the hits: in a cell that beams of the scan pass and hit, the hit has the last
        // word.
        self.mark_beams(grid, ring);
        for &ScanPoint { at, height } in &ring.obstacles {
            if let Some(cell) = grid.cell_at(at).filter(|_| !moves(at)) {
                self.mark_hit(cell, height);
            }
        }
    }

    /// Counts for an obstacle in a cell, hit at a height in metres.
    fn mark_hit(&mut self, cell: usize, height: f64) {
        let cell = &mut self.cells[cell];
        // The height of an obstacle that is gone says nothing about the new one.
        let before = if cell.evidence > 0 { cell.top } else { 0 };
        cell.top = before.max((height * 100.0) as u8);
        if cell.hit_in != self.scans {
            // From zero on, however long the cell was free: a single hit makes an obstacle.
            cell.evidence = (cell.evidence.max(0) + HIT).min(MOST);
            cell.hit_in = self.scans;
        }
    }

    /// Counts against obstacles along all beams.
    fn mark_beams(&mut self, grid: &GridGeometry, ring: &RangeRing) {
        let is_far_scan = self.scans.is_multiple_of(FAR_EVERY);
        let furthest = if is_far_scan { FURTHEST_M } else { NEAR_M };
        for (degrees, &beam) in ring.beams.iter().enumerate() {
            // Each part of the beam has one line more than the part before; the last one reaches to
            // its end.
            for lines in 1..=LINES {
                let end = if lines == LINES {
                    usize::MAX
                } else {
                    lines * LINE
                };
                let part = (lines - 1) * LINE..end;
                if beam.reach.min(furthest) < part.start as f64 * grid.cell {
                    break;
                }
                for line in 0..lines {
                    // Evenly over the degree, and symmetric about its middle.
                    let share = (line as f64 + 0.5) / lines as f64;
                    let bearing = (degrees as f64 + share).to_radians();
                    let line = Line {
                        beam,
                        bearing,
                        furthest,
                        part: part.clone(),
                    };
                    self.mark_clear(grid, ring, line);
                }
            }
        }
    }

    /// Counts a scan, and lowers all numbers of scans before they overflow.
    fn count(&mut self) {
        if self.scans == u16::MAX {
            // Scans longer ago than any question reaches are as good as none.
            let kept = 2 * MEMORY_SCANS;
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

    /// Counts against every obstacle on a line that is high enough for the beam to have hit it.
    fn mark_clear(&mut self, grid: &GridGeometry, ring: &RangeRing, line: Line) {
        let Line {
            beam,
            bearing,
            furthest,
            part,
        } = line;
        let (sin, cos) = libm::sincos(bearing);
        // Stop short of the obstacle that was hit, by a cell's diagonal.
        let steps = (beam.reach.min(furthest) - 1.5 * grid.cell) / grid.cell;
        // In sides of cells: a division at each step would take longer than all the rest.
        let start_x = (ring.center.x - grid.origin.x) / grid.cell;
        let start_y = (ring.center.y - grid.origin.y) / grid.cell;
        let (width, height) = (grid.width as f64, grid.height as f64);
        // Beams reach further than many grids.
        let within = steps_within(grid, ring.center, Vector2::new(cos, sin), steps);
        for i in within.start.max(part.start)..within.end.min(part.end) {
            let (x, y) = (start_x + i as f64 * cos, start_y + i as f64 * sin);
            // Written so that NaN is nowhere.
            if !(x >= 0.0 && y >= 0.0 && x < width && y < height) {
                continue;
            }
            let cell = &mut self.cells[y as usize * grid.width + x as usize];
            if cell.cleared_in == self.scans {
                continue;
            }
            let passes_over = cell.evidence > 0
                && f64::from(cell.top) < 100.0 * ring.height_at(beam, i as f64 * grid.cell);
            if !passes_over {
                cell.cleared_in = self.scans;
                cell.evidence = (cell.evidence - 1).max(LEAST);
                if cell.evidence <= FREE {
                    cell.free_in = self.scans;
                }
            }
        }
    }

    /// Forgets obstacles that were not seen for a minute: they may have moved, and the robot's
    /// estimated pose has drifted since.
    pub(crate) fn forget(&mut self) {
        for cell in &mut self.cells {
            if cell.evidence > 0 && self.scans - cell.hit_in > MEMORY_SCANS {
                cell.evidence = 0;
            }
        }
    }

    /// Carries the evidence from one grid over to another whose cells have the same size and
    /// places.
    pub(crate) fn carry(&mut self, from: &GridGeometry, to: &GridGeometry) {
        let columns = ((to.origin.x - from.origin.x) / to.cell).round() as i64;
        let rows = ((to.origin.y - from.origin.y) / to.cell).round() as i64;
        let old = std::mem::replace(&mut self.cells, vec![Cell::default(); to.len()]);
        for (cell, known) in self.cells.iter_mut().enumerate() {
            let (x, y) = to.column_row(cell);
            if let Some(before) = from.cell_in(x + columns, y + rows) {
                *known = old[before];
            }
        }
    }
}

/// Those of the first `steps` steps of a cell's side in a direction (a unit vector) that lie on a
/// grid, and a step before and after.
fn steps_within(
    grid: &GridGeometry,
    from: MapPoint,
    direction: Vector2,
    steps: f64,
) -> Range<usize> {
    let (mut first, mut end) = (0.0_f64, steps);
    let sides = [
        (from.x - grid.origin.x, direction.x, grid.width as f64),
        (from.y - grid.origin.y, direction.y, grid.height as f64),
    ];
    for (at, step, cells) in sides {
        let at = at / grid.cell;
        // The beam is between both borders of an axis from the nearer to the further one (slab
        // method).
        let (near, far) = (-at / step, (cells - at) / step);
        // Parallel to a side both are infinite or NaN; then the other direction decides.
        first = first.max(near.min(far) - 1.0);
        end = end.min(near.max(far) + 1.0);
    }
    // Casts turn negative numbers and NaN into zero.
    first as usize..end.max(first) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell that beams pass over and one that is hit, after some scans.
    fn after(scans: u32) -> [Cell; 2] {
        let grid = GridGeometry {
            origin: MapPoint::new(-1.0, -1.0),
            width: 40,
            height: 20,
            cell: 0.1,
        };
        let mut seen = Seen::nothing(grid.len());
        let post = MapPoint::new(2.05, 0.05);
        let ring = RangeRing::new(
            MapPoint::default(),
            0.25,
            std::iter::once(ScanPoint::new(post, 0.3)),
        );
        (0..scans).for_each(|_| seen.observe(&grid, &ring, |_| false));
        seen.forget();
        [MapPoint::new(1.05, 0.02), post].map(|at| seen.cells[grid.cell_at(at).unwrap()])
    }

    #[test]
    fn evidence_does_not_depend_on_the_number_of_scans() {
        let [free, hit] = after(1000);
        assert!(free.evidence <= FREE && hit.evidence == MOST);
        for scans in [u32::from(u16::MAX) - 1, u32::from(u16::MAX) + 1, 200_000] {
            let [late_free, late_hit] = after(scans);
            assert_eq!(
                (late_free.evidence, late_hit.evidence),
                (free.evidence, hit.evidence),
                "{scans}"
            );
        }
    }
}
