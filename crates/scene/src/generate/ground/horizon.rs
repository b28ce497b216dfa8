//! The view far beyond the map: hills, or the sea where it continues. No robot gets there.

use nalgebra::Point3;
use openbench_core::MapPoint;
use openbench_geometry::sides;
use rand_pcg::Pcg64Mcg;

use super::terrain::RIM_M;
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::WATER;
use crate::generate::layout::extent::GROUND_MARGIN_M;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, between, stream};
use crate::generate::shapes::{Surface, at, level_uv};
use crate::generate::water::coast::SEA_LEVEL_M;
use crate::material::SemanticClass;
use crate::scene::{Corner, Layer, SceneBuilder};

/// A row of hills, metres.
struct Row {
    /// Distance from the ground's edge.
    distance: f64,
    /// Lowest and highest height.
    height: [f64; 2],
}

const ROWS: [Row; 4] = [
    Row {
        distance: 0.0,
        height: [-0.3, -0.3],
    },
    Row {
        distance: 60.0,
        height: [0.5, 6.0],
    },
    Row {
        distance: 150.0,
        height: [4.0, 22.0],
    },
    Row {
        distance: 320.0,
        height: [10.0, 48.0],
    },
];
/// Distance between the columns of hills along the edge of the ground, metres.
const COLUMN_SPACING_M: f64 = 45.0;
/// Columns on one side at most.
const MAX_COLUMNS: usize = 60;
/// Depth of the outermost sea below its level, so that it does not show through, metres.
const BELOW_SEA_M: f64 = 0.02;

/// Points of the hills in one direction, from the ground's edge outwards.
struct Column {
    is_sea: bool,
    points: [Point3<f64>; ROWS.len()],
}

/// Builds the hills and the sea on the horizon.
pub(crate) fn build(inputs: &Inputs, out: &mut Output) {
    out.scene.begin_object("horizon", SemanticClass::Ground);
    let columns = levelled(columns(inputs));
    for (i, this) in columns.iter().enumerate() {
        let next = &columns[(i + 1) % columns.len()];
        let palette = &inputs.palette;
        let surface = if this.is_sea && next.is_sea {
            palette.water
        } else {
            palette.hills
        };
        for row in 0..ROWS.len() - 1 {
            let (a, b) = (&this.points, &next.points);
            slope(
                &mut out.scene,
                surface,
                [a[row], b[row], b[row + 1], a[row + 1]],
            );
        }
    }
}

/// The columns around the ground, counter-clockwise from the south-west.
fn columns(inputs: &Inputs) -> Vec<Column> {
    let inner = inputs.extent.grown(GROUND_MARGIN_M - RIM_M).corners();
    let outer = inputs.extent.grown(GROUND_MARGIN_M).corners();
    let middle = inputs.extent.middle();
    let mut rng = stream(inputs.seed, Purpose::Horizon, 0);
    let mut columns = Vec::new();
    for (inside, edge) in sides(&inner).zip(sides(&outer)) {
        let count = ((edge.length() / COLUMN_SPACING_M) as usize).clamp(2, MAX_COLUMNS);
        for k in 0..count {
            let share = k as f64 / count as f64;
            columns.push(Column {
                // Just inside the ground's edge: beyond it nothing is known to be water.
                is_sea: !inputs.clearance.is_free_at(inside.at(share), 0.0, WATER),
                points: column_points(edge.at(share), middle, &mut rng),
            });
        }
    }
    columns
}

fn column_points(
    foot: MapPoint,
    middle: MapPoint,
    rng: &mut Pcg64Mcg,
) -> [Point3<f64>; ROWS.len()] {
    // Away from the middle of the map, so that columns spread and never cross.
    let away = middle.bearing_to(foot);
    ROWS.map(
        |Row {
             distance,
             height: [low, high],
         }| { at(foot.offset(away, distance), between(rng, low, high)) },
    )
}

/// The columns with those in the sea levelled, and those on land that is no wider than a mole:
/// there are no hills on moles.
fn levelled(columns: Vec<Column>) -> Vec<Column> {
    let n = columns.len();
    let sea: Vec<bool> = columns.iter().map(|column| column.is_sea).collect();
    let mut levelled = columns;
    for (i, column) in levelled.iter_mut().enumerate() {
        // By the columns as they were: what becomes sea here must not spread further.
        column.is_sea = sea[i] || sea[(i + n - 1) % n] || sea[(i + 1) % n];
        if column.is_sea {
            column
                .points
                .iter_mut()
                .for_each(|p| p.z = SEA_LEVEL_M - BELOW_SEA_M);
        }
    }
    levelled
}

/// Two triangles, seen from above.
fn slope(scene: &mut SceneBuilder, surface: Surface, corners: [Point3<f64>; 4]) {
    let corners = corners.map(|p| Corner::new(p, level_uv(surface, MapPoint::new(p.x, p.y))));
    scene.mesh(
        Layer::Visible,
        surface.material,
        &corners,
        &[[0, 2, 1], [0, 3, 2]],
    );
}
