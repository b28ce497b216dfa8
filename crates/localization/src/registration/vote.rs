//! Every pose of a region gets a cost: where the submap's evidence would lie in the map.
//!
//! For a fixed heading this is a correlation of evidence and map, by direct sums of 16-bit numbers,
//! one row of places at a time. Their number grows with that of the pieces of evidence, which are
//! few.

use std::f64::consts::TAU;

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::grid::GridGeometry;

use super::field::{CELL_M, Field, MARGIN_CELLS, sector};
use super::submap::Submap;

/// Most pieces of evidence of each kind.
const MOST_EVIDENCE: usize = 160;
/// Most weight of a piece.
const MOST_VIEWS: u16 = 4;
/// Free ground is counted in squares of this side, metres.
const FREE_CELL_M: f64 = 2.0;
/// Evidence farther from the robot is not used, metres: what a field has around its area, less what
/// rounding and means of squares may add.
const REACH_M: f64 = (MARGIN_CELLS - 2) as f64 * CELL_M;
/// Free ground farther from where it was seen is left out, metres.
const FREE_RANGE_M: f64 = 25.0;
/// Free ground nearer than this to what ended it is left out, metres.
const FREE_MARGIN_M: f64 = 0.7;

/// A piece of evidence.
#[derive(Debug, Clone, Copy)]
struct Piece {
    at: MapPoint,
    /// Of a facade.
    facing: f64,
    weight: u16,
}

/// A submap, thinned out for voting.
#[derive(Debug, Clone, Default)]
pub struct Evidence {
    facades: Vec<Piece>,
    free: Vec<Piece>,
}

impl Evidence {
    /// From a submap in the robot's frame.
    pub fn of(submap: &Submap) -> Self {
        let facades = submap.facades.iter().map(|facade| Piece {
            at: facade.at,
            facing: facade.facing,
            weight: u16::from(facade.views).min(MOST_VIEWS),
        });
        let near = |piece: &Piece| piece.at.distance(MapPoint::default()) < REACH_M;
        let facades = joined(facades.filter(near).collect(), CELL_M);
        Self {
            facades: chosen(&facades),
            free: chosen(&free_places(submap)),
        }
    }

    /// Number of pieces of facades.
    pub fn facades(&self) -> usize {
        self.facades.len()
    }
}

/// Free ground: one piece for each square that a ray of a panorama passes.
fn free_places(submap: &Submap) -> Vec<Piece> {
    let side = (2.0 * REACH_M / FREE_CELL_M) as usize;
    let squares = GridGeometry {
        origin: MapPoint::new(-REACH_M, -REACH_M),
        width: side,
        height: side,
        cell: FREE_CELL_M,
    };
    let mut is_free = vec![false; squares.len()];
    for panorama in &submap.panoramas {
        for (bearing, free) in panorama.rays().step_by(2) {
            let (sine, cosine) = libm::sincos(bearing);
            let end = (free - FREE_MARGIN_M).clamp(0.0, FREE_RANGE_M);
            let mut range = 1.0;
            while range < end {
                let (x, y) = (cosine * range, sine * range);
                let at = MapPoint::new(panorama.from.x + x, panorama.from.y + y);
                if let Some(square) = squares.cell_at(at) {
                    is_free[square] = true;
                }
                range += FREE_CELL_M / 2.0;
            }
        }
    }
    let places = (0..squares.len()).filter(|square| is_free[*square]);
    let pieces = places.map(|square| Piece {
        at: squares.center(square),
        facing: 0.0,
        weight: 1,
    });
    pieces
        .filter(|piece| piece.at.distance(MapPoint::default()) < REACH_M)
        .collect()
}

/// One piece for each square, at the mean of those in it and with the greatest weight.
fn joined(mut pieces: Vec<Piece>, side: f64) -> Vec<Piece> {
    let cell = |piece: &Piece| {
        let index = |value: f64| (value / side).floor() as i64;
        (index(piece.at.y), index(piece.at.x))
    };
    pieces.sort_by_key(cell);
    let squares = pieces.chunk_by(|a, b| cell(a) == cell(b));
    squares
        .map(|same| {
            let n = same.len() as f64;
            let x = same.iter().map(|one| one.at.x).sum::<f64>() / n;
            let y = same.iter().map(|one| one.at.y).sum::<f64>() / n;
            Piece {
                at: MapPoint::new(x, y),
                facing: same[same.len() / 2].facing,
                weight: same.iter().map(|one| one.weight).max().unwrap_or(1),
            }
        })
        .collect()
}

/// An even choice of at most [`MOST_EVIDENCE`] pieces.
fn chosen(pieces: &[Piece]) -> Vec<Piece> {
    let count = pieces.len();
    if count <= MOST_EVIDENCE {
        return pieces.to_vec();
    }
    let index = |i| i * count / MOST_EVIDENCE;
    (0..MOST_EVIDENCE).map(|i| pieces[index(i)]).collect()
}

/// Headings that are asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Headings {
    /// The first one, radians.
    pub first: f64,
    /// From one to the next, radians.
    pub step: f64,
    /// How many.
    pub count: usize,
}

impl Headings {
    /// All of them, three degrees apart.
    pub const ALL: Self = Self {
        first: 0.0,
        step: TAU / 120.0,
        count: 120,
    };
}

/// Costs of all places with one heading.
pub struct Slice<'a> {
    /// The heading.
    pub yaw: f64,
    /// Row by row; in [units](super::field::UNITS_PER_NAT).
    pub costs: &'a [u16],
}

/// Asks all places of a field's area, one heading after the other.
pub fn vote(
    field: &Field,
    evidence: &Evidence,
    headings: &Headings,
    each: &mut dyn FnMut(Slice<'_>),
) {
    let mut costs = vec![0_u16; field.columns * field.rows];
    for index in 0..headings.count {
        let yaw = headings.first + index as f64 * headings.step;
        let shifts = shifts(field, evidence, yaw);
        for (row, sums) in costs.chunks_exact_mut(field.columns).enumerate() {
            sums.fill(0);
            for shift in &shifts {
                let from = shift.first + row * field.grid.width;
                let costs = &shift.layer[from..from + field.columns];
                for (sum, cost) in sums.iter_mut().zip(costs) {
                    // Neither overflows: 320 pieces cost 48 units at most, times a weight of 4.
                    *sum = sum.wrapping_add(cost.wrapping_mul(shift.weight));
                }
            }
        }
        let costs = &costs;
        each(Slice { yaw, costs });
    }
}

/// Where a piece of evidence lies, seen from the first place of the area.
struct Shift<'a> {
    layer: &'a [u16],
    weight: u16,
    /// Its cell if the robot is at the first place.
    first: usize,
}

/// Where all evidence lies if the robot has a heading.
fn shifts<'a>(field: &'a Field, evidence: &Evidence, yaw: f64) -> Vec<Shift<'a>> {
    let pose = Pose2::new(0.0, 0.0, yaw);
    let first = |at: MapPoint| {
        let turned = pose.transform(at.x, at.y);
        // No piece is farther away than the margin is wide.
        let cell = |value: f64| (MARGIN_CELLS as f64 + (value / CELL_M).round()) as usize;
        cell(turned.y) * field.grid.width + cell(turned.x)
    };
    let facades = evidence.facades.iter().map(|piece| Shift {
        layer: &field.facade[sector(piece.facing + yaw)],
        weight: piece.weight.min(MOST_VIEWS),
        first: first(piece.at),
    });
    let free = evidence.free.iter().map(|piece| Shift {
        layer: &field.free,
        weight: 1,
        first: first(piece.at),
    });
    facades.chain(free).collect()
}

#[cfg(test)]
mod tests {
    use openbench_geometry::Bounds;

    use super::super::town::{chart, stretch_at, town};
    use super::*;

    #[test]
    fn each_cost_is_the_sum_over_the_evidence() {
        let half = MapPoint::new(6.0, 6.0);
        let area = Bounds {
            low: MapPoint::new(-half.x, -half.y),
            high: half,
        };
        let field = Field::over(&chart(&town()), area);
        let submap = Submap::of(&[stretch_at(&town(), Pose2::new(1.0, 2.0, 0.3))]);
        let evidence = Evidence::of(&submap);
        assert!(evidence.facades() > 50 && evidence.free.len() > 50);
        let headings = Headings {
            first: -0.4,
            step: 0.7,
            count: 3,
        };
        let mut compared = 0;
        vote(&field, &evidence, &headings, &mut |slice| {
            for (place, cost) in slice.costs.iter().enumerate() {
                let column = (place % field.columns) as i64;
                let row = (place / field.columns) as i64;
                assert_eq!(
                    i64::from(*cost),
                    cost_at(&field, &evidence, slice.yaw, column, row),
                    "{column}, {row} at {}",
                    slice.yaw
                );
                compared += 1;
            }
        });
        assert_eq!(compared, 3 * 144);
    }

    /// The same, one piece after the other.
    fn cost_at(field: &Field, evidence: &Evidence, yaw: f64, column: i64, row: i64) -> i64 {
        let pose = Pose2::new(0.0, 0.0, yaw);
        let margin = MARGIN_CELLS as i64;
        let cell = |piece: &Piece| {
            let turned = pose.transform(piece.at.x, piece.at.y);
            let column = column + margin + turned.x.round() as i64;
            let row = row + margin + turned.y.round() as i64;
            field.grid.cell_in(column, row).unwrap()
        };
        let facades = evidence.facades.iter().map(|piece| {
            let costs = &field.facade[sector(piece.facing + yaw)];
            i64::from(piece.weight) * i64::from(costs[cell(piece)])
        });
        let free = evidence.free.iter();
        facades.sum::<i64>()
            + free
                .map(|piece| i64::from(field.free[cell(piece)]))
                .sum::<i64>()
    }

    #[test]
    fn of_much_evidence_an_even_choice_is_kept() {
        let pieces = (0..2000).map(|i| Piece {
            at: MapPoint::new(f64::from(i % 50), f64::from(i / 50)),
            facing: 0.0,
            weight: 1,
        });
        let kept = chosen(&joined(pieces.collect(), CELL_M));
        assert_eq!(kept.len(), MOST_EVIDENCE);
        let north = kept.iter().filter(|piece| piece.at.y >= 20.0).count();
        assert!((75..=85).contains(&north), "{north}");
    }
}
