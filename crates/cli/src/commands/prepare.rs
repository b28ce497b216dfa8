//! `openbench prepare`: a graph file, so that a map need not be read again.

use openbench_routing::partition::CellSizes;
use openbench_routing::{Roads, store};

use crate::args::PrepareArgs;
use crate::outcome::{Outcome, say};

/// Reads a map, puts its roads into cells and writes them.
pub fn run(args: &PrepareArgs) -> anyhow::Result<Outcome> {
    let sizes = if args.cells.is_empty() {
        CellSizes::default()
    } else {
        CellSizes::new(&args.cells)?
    };
    super::spare_inputs(&[&args.map], &[&args.out])?;
    let roads = super::route::read_roads(&args.map, &sizes)?;
    store::write(&roads, &args.out)?;
    say(&summary(&roads))?;
    Ok(Outcome::Done)
}

fn summary(roads: &Roads) -> String {
    let (network, report) = (&roads.network, roads.network.report);
    let mut text = format!(
        "{} vertices, {} edges, {} points, {} turn restrictions\n",
        network.vertices.len(),
        network.edge_count(),
        network.point_count(),
        network.restrictions.len()
    );
    for (index, layer) in roads.vertices.layers.iter().enumerate() {
        text += &format!(
            "layer {}: {:6} cells, {:6} edges between them, {:6} border vertices\n",
            index + 1,
            layer.cells(),
            roads.vertices.edges_between_cells(index),
            layer.state.len()
        );
    }
    for (count, what) in [
        (report.ways_without_points, "ways have no two known nodes"),
        (
            report.conditional,
            "ways have conditional tags, which were ignored",
        ),
        (
            report.odd_restrictions,
            "turn restrictions have unsupported members and were ignored",
        ),
        (
            report.squares_not_crossed,
            "pedestrian areas are not crossed: too many corners, or an incomplete outline",
        ),
        (
            roads.levels.len() - roads.vertices.layers.len(),
            "layers were skipped: their cells have too many border vertices",
        ),
    ] {
        if count > 0 {
            text += &format!("{count} {what}\n");
        }
    }
    text
}
