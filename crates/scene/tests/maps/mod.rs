//! Small maps that are written out in tests.
#![allow(dead_code)]

use openbench_core::{Georeference, LonLat, MapPoint};
use openbench_osm::{Node, OsmData, Tags, Way};

/// Corners in metres about a point, and tags.
pub type WayOf<'a> = (&'a [(f64, f64)], &'a [(&'a str, &'a str)]);

/// A map of ways; buildings, their parts and waters are closed.
pub fn map_of(ways: &[WayOf]) -> (OsmData, Georeference) {
    let georeference = Georeference::tangent_plane(LonLat::new(8.0, 48.0));
    let projection = openbench_osm::Projection::new(georeference);
    let mut data = OsmData::default();
    for (i, (ring, tags)) in ways.iter().enumerate() {
        let mut nodes = Vec::new();
        for (x, y) in *ring {
            let id = data.nodes.len() as i64 + 1;
            let position = projection.to_lonlat(MapPoint::new(*x, *y));
            data.nodes.insert(
                id,
                Node {
                    id,
                    position,
                    tags: Tags::new(),
                },
            );
            nodes.push(id);
        }
        if tags
            .iter()
            .any(|(k, v)| k.starts_with("building") || *v == "water")
        {
            nodes.push(nodes[0]);
        }
        let id = i as i64 + 1;
        data.ways.insert(
            id,
            Way {
                id,
                nodes,
                tags: tags.iter().copied().collect(),
            },
        );
    }
    (data, georeference)
}

/// A row of equal houses along a street of that name, 14 m apart, with more tags.
pub fn row_of_houses(
    count: usize,
    street: &[(&str, &str)],
    tags: &[(&str, &str)],
) -> (OsmData, Georeference) {
    let rings: Vec<Vec<(f64, f64)>> = (0..count)
        .map(|i| {
            let x = 14.0 * i as f64;
            vec![(x, 6.0), (x + 10.0, 6.0), (x + 10.0, 14.0), (x, 14.0)]
        })
        .collect();
    let road: &[(f64, f64)] = &[(-20.0, 0.0), (14.0 * count as f64, 0.0)];
    let mut ways: Vec<WayOf> = rings.iter().map(|ring| (ring.as_slice(), tags)).collect();
    ways.push((road, street));
    map_of(&ways)
}

/// The corners of a rectangle, counter-clockwise.
pub fn rectangle((x0, y0): (f64, f64), (x1, y1): (f64, f64)) -> [(f64, f64); 4] {
    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
}
