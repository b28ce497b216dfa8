//! `openbench costmap`: the ground of a map for ROS's map server.

use anyhow::Context;
use openbench_core::{LonLat, MapPoint, RobotDescription};
use openbench_motion::Costmap;
use openbench_motion::costmap::map_server;
use openbench_osm::{OsmMap, Window};

use crate::args::CostmapArgs;
use crate::commands::{read_part, spare_inputs};
use crate::outcome::{Outcome, say};

/// Ground around everything on the map, metres.
const AROUND: f64 = 5.0;

/// Draws the ground and writes it.
pub fn run(args: &CostmapArgs) -> anyhow::Result<Outcome> {
    spare_inputs(&[&args.map], &[&args.out])?;
    let (data, georeference) = read_part(&args.map, &args.cut)?;
    let (map, file) = (OsmMap::new(&data, georeference), args.map.display());
    let (low, high) = match args.cut.window()? {
        // All four corners: in metres, a rectangle of degrees is slightly rotated.
        Some(Window { low: l, high: h }) => {
            let corners = [
                (l.lon, l.lat),
                (h.lon, l.lat),
                (h.lon, h.lat),
                (l.lon, h.lat),
            ];
            bounds(
                corners
                    .into_iter()
                    .map(|(lon, lat)| map.projection.to_map(LonLat::new(lon, lat))),
                0.0,
            )
        }
        None => bounds(everything_of(&map).into_iter(), AROUND),
    }
    .ok_or_else(|| anyhow::anyhow!("{file}: no building, road, barrier or area is on the map"))?;
    let costmap = Costmap::new(&map, low, high, &RobotDescription::sentry())
        .with_context(|| file.to_string())?;
    map_server::write(&args.out, &costmap.occupancy())?;
    let grid = costmap.grid();
    let (out, metres) = (args.out.display(), grid.cell);
    say(&format!(
        "{out}: {} by {} cells of {metres:.2} m, {georeference}\n",
        grid.width, grid.height
    ))?;
    Ok(Outcome::Done)
}

/// Where the buildings, areas, roads and barriers of a map are.
fn everything_of(map: &OsmMap) -> Vec<MapPoint> {
    let outlines = map
        .buildings
        .iter()
        .map(|b| &b.polygon)
        .chain(map.areas.iter().map(|a| &a.polygon));
    let outlines = outlines
        .map(|polygon| polygon.bounds())
        .flat_map(|bounds| [bounds.low, bounds.high]);
    let lines = map
        .roads
        .iter()
        .map(|r| &r.points)
        .chain(map.barriers.iter().map(|b| &b.points));
    outlines.chain(lines.flatten().copied()).collect()
}

/// Lower and upper corner of the rectangle about points, and so many metres more to each side.
fn bounds(mut points: impl Iterator<Item = MapPoint>, more: f64) -> Option<(MapPoint, MapPoint)> {
    let first = points.next()?;
    let (low, high) = points.fold((first, first), |(low, high), p| {
        (
            MapPoint::new(low.x.min(p.x), low.y.min(p.y)),
            MapPoint::new(high.x.max(p.x), high.y.max(p.y)),
        )
    });
    Some((
        MapPoint::new(low.x - more, low.y - more),
        MapPoint::new(high.x + more, high.y + more),
    ))
}
