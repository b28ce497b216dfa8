//! Lots of gravel, paving, bare earth and meadow where the map has no surface, instead of one lawn.
//!
//! Lots are quadrangles between the points of a grid, which are moved at random. They lie just
//! above the ground and below all that the map has.

use openbench_core::MapPoint;
use openbench_geometry::Bounds;
use rand_pcg::Pcg64Mcg;

use super::streams::{Purpose, stream};
use crate::generate::ground::levels::Z_LOT_M;
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{BUILDING, WATER};
use crate::generate::layout::extent::GROUND_MARGIN_M;
use crate::generate::output::Output;
use crate::generate::seeds::{between, chance, pick};
use crate::generate::shapes::{Surface, at, facet};
use crate::material::SemanticClass;
use crate::scene::{Layer, SceneBuilder};

/// Side of a lot in a neighbourhood, metres.
const LOT_M: f64 = 11.0;
/// Lots along one side at most: in a town they are larger.
const MOST_LOTS: f64 = 250.0;
/// Largest distance of a corner from its place in the grid along each axis, as a share of a lot.
/// Up to a quarter all lots are convex.
const MOVED: f64 = 0.24;
/// A lot this near to a house is its garden or yard, metres.
const YARD_M: f64 = 9.0;

/// What a lot is covered with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cover {
    Meadow,
    DryGrass,
    Gravel,
    Paving,
    Earth,
    Setts,
}

/// Around houses, as frequent as it is here.
const YARDS: [Cover; 8] = [
    Cover::Gravel,
    Cover::Paving,
    Cover::Meadow,
    Cover::Earth,
    Cover::Setts,
    Cover::Gravel,
    Cover::DryGrass,
    Cover::Paving,
];
/// Elsewhere.
const OPEN: [Cover; 5] = [
    Cover::Meadow,
    Cover::DryGrass,
    Cover::Earth,
    Cover::Meadow,
    Cover::Gravel,
];

impl Cover {
    fn name(self) -> &'static str {
        match self {
            Self::Meadow => "meadow",
            Self::DryGrass => "dry grass",
            Self::Gravel => "gravel",
            Self::Paving => "paving",
            Self::Earth => "earth",
            Self::Setts => "setts",
        }
    }

    fn class(self) -> SemanticClass {
        match self {
            Self::Meadow | Self::DryGrass => SemanticClass::Grass,
            Self::Earth => SemanticClass::Ground,
            Self::Gravel | Self::Paving | Self::Setts => SemanticClass::Pavement,
        }
    }
}

/// Surfaces that other worlds do not have.
struct Grasses {
    meadow: Surface,
    dry: Surface,
}

impl Grasses {
    fn new(scene: &mut SceneBuilder, lawn: Surface) -> Self {
        let mut tinted = |color: [f32; 3], reflectivity: u8| Surface {
            material: scene.tinted(lawn.material, color, reflectivity),
            // Coarser than a lawn.
            tile: lawn.tile * 1.6,
        };
        Self {
            meadow: tinted([0.82, 0.92, 0.62], 110),
            dry: tinted([1.25, 1.08, 0.66], 120),
        }
    }
}

/// Builds the lots.
pub(crate) fn build(inputs: &Inputs, out: &mut Output) {
    let share = inputs.options.scenery.amounts.ground;
    if share <= 0.0 {
        return;
    }
    let grasses = Grasses::new(&mut out.scene, inputs.palette.grass);
    let grid = Grid::over(
        inputs.extent.grown(GROUND_MARGIN_M),
        inputs.options.scenery.seed,
    );
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            let mut rng = stream(grid.seed, Purpose::Lot, grid.number(column, row));
            if let Some(cover) = drawn(inputs, share, &grid.corners(column, row), &mut rng)
                && !out.is_full()
            {
                out.scene.begin_object(cover.name(), cover.class());
                let surface = surface(inputs, &grasses, cover);
                let corners = grid.corners(column, row).map(|p| at(p, Z_LOT_M));
                facet(&mut out.scene, Layer::Visible, surface, &corners);
                out.drawn_scenery.count_ground(cover.name());
            }
        }
    }
}

fn surface(inputs: &Inputs, grasses: &Grasses, cover: Cover) -> Surface {
    let palette = &inputs.palette;
    match cover {
        Cover::Meadow => grasses.meadow,
        Cover::DryGrass => grasses.dry,
        Cover::Gravel => palette.gravel,
        Cover::Paving => palette.paving,
        Cover::Earth => palette.earth,
        Cover::Setts => palette.path,
    }
}

/// What a lot is covered with; `None` for a lawn, and where there is water.
fn drawn(
    inputs: &Inputs,
    share: f64,
    corners: &[MapPoint; 4],
    rng: &mut Pcg64Mcg,
) -> Option<Cover> {
    let is_other = chance(rng, share);
    let (yard, open) = (pick(rng, &YARDS), pick(rng, &OPEN));
    let middle = middle_of(corners);
    let reach = corners
        .iter()
        .map(|p| middle.distance(*p))
        .fold(0.0, f64::max);
    let is_dry = inputs.clearance.is_free_at(middle, reach, WATER);
    let is_yard = !inputs.clearance.is_free_at(middle, YARD_M, BUILDING);
    // A lot would cover the hole.
    let wells = &inputs.relief.wells;
    let is_whole = wells.iter().all(|well| {
        let near = |p: &MapPoint| p.distance(middle) < reach;
        !well.ring().iter().any(near)
    });
    (is_other && is_dry && is_whole).then_some(if is_yard { yard } else { open })
}

fn middle_of(corners: &[MapPoint; 4]) -> MapPoint {
    let sum = |of: fn(&MapPoint) -> f64| corners.iter().map(of).sum::<f64>() / 4.0;
    MapPoint::new(sum(|p| p.x), sum(|p| p.y))
}

/// A grid whose inner points are moved at random.
struct Grid {
    bounds: Bounds,
    columns: usize,
    rows: usize,
    seed: u64,
}

impl Grid {
    fn over(bounds: Bounds, seed: u64) -> Self {
        let (width, depth) = (bounds.high.x - bounds.low.x, bounds.high.y - bounds.low.y);
        let side = LOT_M.max(width.max(depth) / MOST_LOTS);
        let count = |length: f64| ((length / side) as usize).max(1);
        Self {
            bounds,
            columns: count(width),
            rows: count(depth),
            seed,
        }
    }

    fn number(&self, column: usize, row: usize) -> u64 {
        (row * (self.columns + 1) + column) as u64
    }

    /// The corners of a lot, counter-clockwise.
    fn corners(&self, column: usize, row: usize) -> [MapPoint; 4] {
        [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| self.point(column + i, row + j))
    }

    fn point(&self, column: usize, row: usize) -> MapPoint {
        let mut rng = stream(self.seed, Purpose::LotCorner, self.number(column, row));
        let moved = |rng: &mut Pcg64Mcg, i: usize, last: usize| {
            let moved = between(rng, -MOVED, MOVED);
            // Points of the border stay on it.
            let share = if i == 0 || i == last { 0.0 } else { moved };
            (i as f64 + share) / last as f64
        };
        let x = moved(&mut rng, column, self.columns);
        let y = moved(&mut rng, row, self.rows);
        let Bounds { low, high } = self.bounds;
        MapPoint::new(low.x + (high.x - low.x) * x, low.y + (high.y - low.y) * y)
    }
}

#[cfg(test)]
mod tests {
    use openbench_geometry::{signed_area, turn};

    use super::*;

    #[test]
    fn lots_are_convex() {
        let bounds = Bounds {
            low: MapPoint::new(-200.0, -150.0),
            high: MapPoint::new(250.0, 200.0),
        };
        for seed in 0..50 {
            let grid = Grid::over(bounds, seed);
            for row in 0..grid.rows {
                for column in 0..grid.columns {
                    let [a, b, c, d] = grid.corners(column, row);
                    for [p, q, r] in [[a, b, c], [b, c, d], [c, d, a], [d, a, b]] {
                        assert!(turn(p, q, r) > 0.0, "{seed} {column} {row}");
                    }
                }
            }
        }
    }

    #[test]
    fn lots_cover_the_ground_once() {
        let bounds = Bounds {
            low: MapPoint::new(-30.0, 10.0),
            high: MapPoint::new(70.0, 65.0),
        };
        let grid = Grid::over(bounds, 5);
        let mut whole = 0.0;
        for row in 0..grid.rows {
            for column in 0..grid.columns {
                let area = signed_area(&grid.corners(column, row));
                assert!(area > 0.0, "{column} {row}");
                whole += area;
            }
        }
        assert!((whole - 100.0 * 55.0).abs() < 1e-6, "{whole}");
    }
}
