//! What each place of the map costs a piece of evidence: negative log-likelihoods as small numbers.

use std::f64::consts::TAU;

use openbench_core::MapPoint;
use openbench_core::frames::wrap_angle;
use openbench_geometry::grid::GridGeometry;
use openbench_geometry::{Bounds, Polygon, Segment};

use super::chart::{Chart, Wall};

/// Side of a cell, metres.
pub const CELL_M: f64 = 1.0;
/// Evidence farther from the robot is not used, cells.
pub const MARGIN_CELLS: usize = 62;
/// Long walls are entered in pieces of this length, metres: the box of a slanting one is large.
const PIECE_M: f64 = 10.0;
/// Most cells of an area along each side.
const MOST_PLACES: usize = 1024;
/// A nat is this many units of cost.
pub const UNITS_PER_NAT: f64 = 16.0;
/// Standard deviation of a wall in the map and of where it was seen, metres.
const WALL_DEVIATION_M: f64 = 1.2;
/// Directions in which facades face are told apart by so many sectors.
pub const SECTORS: usize = 16;
/// A wall counts in a sector whose middle is no farther than this from the direction in which it
/// faces, radians.
const FACING_RAD: f64 = 0.7;
/// Share of the facades seen that are in no map.
const UNMAPPED: f64 = 0.05;
/// From this distance on the likelihood hardly changes, metres.
const TRUNCATION_M: f64 = 4.0 * WALL_DEVIATION_M;
/// Costs of distances are tabulated in steps of this, metres.
const COST_STEP_M: f64 = 0.01;
/// Free ground inside a building costs this many nats for each metre of depth,
const DEPTH_NATS_PER_M: f64 = 0.3;
/// up to this depth, metres.
const MAX_DEPTH_M: f64 = 4.0;

/// Costs around the places of an area.
#[derive(Debug, Clone)]
pub struct Field {
    /// The cells, in the chart's coordinates: those of the area, and those that a robot in it sees.
    pub grid: GridGeometry,
    /// Columns of cells in the area.
    pub columns: usize,
    /// Rows of cells in the area.
    pub rows: usize,
    /// Of a facade that is seen there, by the sector in which it faces.
    pub facade: [Vec<u16>; SECTORS],
    /// Of free ground that is seen there.
    pub free: Vec<u16>,
    /// Metres inside a building; zero outside.
    pub depth: Vec<f32>,
}

impl Field {
    /// The costs over an area. One that is more than 1024 m wide or high is cut off there.
    pub fn over(chart: &Chart, area: Bounds) -> Self {
        let places = GridGeometry::covering(area.low, area.high, CELL_M, MOST_PLACES);
        let margin = MARGIN_CELLS as f64 * CELL_M;
        let grid = GridGeometry {
            origin: MapPoint::new(area.low.x - margin, area.low.y - margin),
            width: places.width + 2 * MARGIN_CELLS,
            height: places.height + 2 * MARGIN_CELLS,
            cell: CELL_M,
        };
        let mut field = Self {
            columns: places.width,
            rows: places.height,
            facade: std::array::from_fn(|_| vec![wall_cost(f64::INFINITY); grid.len()]),
            free: Vec::new(),
            depth: vec![0.0; grid.len()],
            grid,
        };
        let mut distance = vec![f32::MAX; grid.len()];
        let costs = wall_costs();
        for wall in &chart.walls {
            field.add_wall(wall, &costs, &mut distance);
        }
        field.add_depths(&chart.outlines, &distance);
        let depths = field.depth.iter().map(|depth| f64::from(*depth));
        field.free = depths.map(depth_cost).collect();
        field
    }

    /// The middle of a place of the area.
    pub fn place(&self, column: usize, row: usize) -> MapPoint {
        let cell = (row + MARGIN_CELLS) * self.grid.width + column + MARGIN_CELLS;
        self.grid.center(cell)
    }

    /// Metres that a place of the area is inside a building; zero outside.
    pub fn depth_at(&self, column: usize, row: usize) -> f32 {
        self.depth[(row + MARGIN_CELLS) * self.grid.width + column + MARGIN_CELLS]
    }

    fn add_wall(&mut self, wall: &Wall, costs: &[u16], distance: &mut [f32]) {
        let outward = wall.segment.outward();
        let is_near = |i: &usize| wrap_angle(outward - sector_middle(*i)).abs() < FACING_RAD;
        let sectors: Vec<usize> = (0..SECTORS).filter(is_near).collect();
        let pieces = (wall.segment.length() / PIECE_M).ceil().max(1.0);
        for i in 0..pieces as usize {
            let (from, to) = (i as f64 / pieces, (i + 1) as f64 / pieces);
            self.add_piece(wall.segment.part(from, to), &sectors, costs, distance);
        }
    }

    fn add_piece(
        &mut self,
        piece: Segment,
        sectors: &[usize],
        costs: &[u16],
        distance: &mut [f32],
    ) {
        let (a, b) = (piece.start, piece.end);
        let reach = TRUNCATION_M;
        let low = MapPoint::new(a.x.min(b.x) - reach, a.y.min(b.y) - reach);
        let high = MapPoint::new(a.x.max(b.x) + reach, a.y.max(b.y) + reach);
        for cell in self.grid.cells_between(low, high) {
            let away = piece.distance_to_point(self.grid.center(cell));
            if away > reach {
                continue;
            }
            distance[cell] = distance[cell].min(away as f32);
            let cost = costs[(away / COST_STEP_M).round() as usize];
            for sector in sectors {
                let least = &mut self.facade[*sector][cell];
                *least = cost.min(*least);
            }
        }
    }

    /// Writes how deep cells are inside outlines.
    fn add_depths(&mut self, outlines: &[Polygon], distance: &[f32]) {
        // Where outlines begin and end along each row; how many a cell is in is the sum so far.
        // Outlines may overlap, and each costs no more than the rows that it crosses.
        let width = self.grid.width + 1;
        let mut ends = vec![0_i32; width * self.grid.height];
        for outline in outlines {
            self.add_ends(outline, &mut ends);
        }
        let rows = ends
            .chunks_exact(width)
            .zip(self.depth.chunks_exact_mut(width - 1));
        for ((ends, depths), distances) in rows.zip(distance.chunks_exact(width - 1)) {
            let mut inside = 0;
            for ((end, depth), distance) in ends.iter().zip(depths).zip(distances) {
                inside += end;
                if inside > 0 {
                    *depth = distance.min(TRUNCATION_M as f32);
                }
            }
        }
    }

    /// Adds 1 to the first cell of each run of cells inside an outline, and takes 1 from the first
    /// one behind it.
    fn add_ends(&self, outline: &Polygon, ends: &mut [i32]) {
        let bounds = outline.bounds();
        let Some((_, rows)) = self.grid.window(bounds.low, bounds.high) else {
            return;
        };
        let width = self.grid.width + 1;
        let mut crossings = Vec::new();
        for row in rows.0..=rows.1 {
            let y = self.grid.origin.y + (row as f64 + 0.5) * CELL_M;
            crossings.clear();
            crossings.extend(outline.sides().filter_map(|side| crossing(side, y)));
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                // The first cell whose middle is behind the crossing.
                let first = |x: f64| {
                    let cell = ((x - self.grid.origin.x) / CELL_M - 0.5).ceil();
                    cell.clamp(0.0, self.grid.width as f64) as usize
                };
                ends[row as usize * width + first(pair[0])] += 1;
                ends[row as usize * width + first(pair[1])] -= 1;
            }
        }
    }
}

/// Where a side crosses a line to the east. Each end belongs to one side only.
fn crossing(side: Segment, y: f64) -> Option<f64> {
    let Segment { start: a, end: b } = side;
    ((a.y > y) != (b.y > y)).then(|| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y))
}

/// The direction in the middle of a sector, radians.
fn sector_middle(sector: usize) -> f64 {
    sector as f64 * TAU / SECTORS as f64
}

/// The sector that a direction belongs to.
pub fn sector(direction: f64) -> usize {
    ((direction.rem_euclid(TAU) / TAU * SECTORS as f64).round() as usize) % SECTORS
}

/// Cost of a facade at a distance from the nearest wall of the map: the negative log-likelihood,
/// less that at a wall.
fn wall_cost(distance: f64) -> u16 {
    let z = distance / WALL_DEVIATION_M;
    units(-libm::log(
        (1.0 - UNMAPPED) * libm::exp(-0.5 * z * z) + UNMAPPED,
    ))
}

/// The costs at multiples of [`COST_STEP_M`], up to where they hardly change.
fn wall_costs() -> Vec<u16> {
    let count = (TRUNCATION_M / COST_STEP_M).round() as usize + 1;
    (0..=count)
        .map(|i| wall_cost(i as f64 * COST_STEP_M))
        .collect()
}

/// Cost of free ground inside a building.
fn depth_cost(depth: f64) -> u16 {
    units(depth.min(MAX_DEPTH_M) * DEPTH_NATS_PER_M)
}

fn units(nats: f64) -> u16 {
    (nats * UNITS_PER_NAT).round() as u16
}

#[cfg(test)]
mod tests {
    use super::super::town::{block, chart};
    use super::*;

    fn square(half: f64) -> Bounds {
        Bounds {
            low: MapPoint::new(-half, -half),
            high: MapPoint::new(half, half),
        }
    }

    #[test]
    fn a_facade_costs_nothing_at_a_wall_that_faces_the_same_way() {
        let field = Field::over(&chart(&[block(0.0, 0.0, 10.0, 8.0)]), square(30.0));
        let cost = |x, y, facing| {
            let cell = field.grid.cell_at(MapPoint::new(x, y)).unwrap();
            field.facade[sector(facing)][cell]
        };
        // The south wall lies along y = -4 and faces south.
        let south = -std::f64::consts::FRAC_PI_2;
        assert!(cost(0.5, -4.5, south) <= 3, "{}", cost(0.5, -4.5, south));
        let most = wall_cost(f64::INFINITY);
        assert_eq!(
            cost(0.5, -4.5, -south),
            most,
            "the wall faces the other way"
        );
        assert_eq!(cost(0.5, -15.5, south), most, "no wall is near");
        assert!(cost(0.5, -6.5, south) > 10 && cost(0.5, -6.5, south) < most);
    }

    #[test]
    fn free_ground_costs_more_the_deeper_it_lies_in_a_building() {
        let field = Field::over(&chart(&[block(0.0, 0.0, 20.0, 20.0)]), square(30.0));
        let cost = |x, y| field.free[field.grid.cell_at(MapPoint::new(x, y)).unwrap()];
        assert_eq!(cost(-12.5, 0.5), 0);
        assert!(cost(-9.5, 0.5) < cost(-7.5, 0.5));
        assert_eq!(cost(-2.5, 0.5), cost(0.5, 0.5), "the cost is bounded");
    }

    #[test]
    fn cells_are_deep_where_their_middles_are_inside() {
        // A courtyard, a slanting side, and a house that overlaps another.
        let ring = |corners: &[(f64, f64)]| -> Vec<MapPoint> {
            corners.iter().map(|(x, y)| MapPoint::new(*x, *y)).collect()
        };
        let court = Polygon::new(
            ring(&[(-15.0, -12.0), (11.0, -14.5), (14.0, 9.3), (-13.0, 12.1)]),
            vec![ring(&[(-5.0, -4.0), (4.0, -4.0), (4.0, 3.0), (-5.0, 3.0)])],
        );
        let houses = [court.unwrap(), block(12.2, 0.3, 9.0, 30.0)];
        let field = Field::over(&chart(&houses), square(25.0));
        let mut deep = 0;
        for row in 0..field.rows {
            for column in 0..field.columns {
                let at = field.place(column, row);
                let is_inside = houses.iter().any(|house| house.contains(at));
                assert_eq!(field.depth_at(column, row) > 0.0, is_inside, "{at}");
                deep += usize::from(is_inside);
            }
        }
        assert!(deep > 400);
    }

    #[test]
    fn many_large_houses_in_one_place_take_bounded_work() {
        let tower = block(0.0, 0.0, 900.0, 900.0);
        let field = Field::over(&chart(&vec![tower; 1000]), square(500.0));
        assert!(field.depth_at(field.columns / 2, field.rows / 2) > 0.0);
    }

    #[test]
    fn without_buildings_all_places_are_alike() {
        let field = Field::over(&Chart::default(), square(10.0));
        assert_eq!((field.columns, field.rows), (20, 20));
        assert!(field.free.iter().all(|cost| *cost == 0));
        assert!(
            field
                .facade
                .iter()
                .flatten()
                .all(|cost| *cost == field.facade[0][0])
        );
    }
}
