//! The streets of a map between its junctions.

use std::collections::BTreeMap;

use openbench_core::MapPoint;
use openbench_osm::{OsmMap, Road};

use super::road_tags::{Carriageway, carriageway};

/// A street between two junctions.
pub(super) struct Street {
    pub points: Vec<MapPoint>,
    pub carriageway: Carriageway,
    /// Number of the junction at the first point.
    pub from: usize,
    /// Number of the junction at the last point.
    pub to: usize,
}

/// Where streets meet or end.
pub(super) struct Junction {
    /// Half widths of the carriageways that meet, metres.
    arms: Vec<f64>,
}

impl Junction {
    /// Distance from the junction's middle at which its streets end, metres.
    pub fn setback(&self) -> f64 {
        let widest = self.arms.iter().copied().fold(0.0, f64::max);
        match self.arms.len() {
            // A dead end, a road that goes on as another, and a crossing, which begins beyond its
            // widest road.
            0 | 1 => 0.0,
            2 => 1.5,
            _ => widest + 2.5,
        }
    }
}

/// Streets and junctions.
pub(super) struct StreetNetwork {
    pub streets: Vec<Street>,
    pub junctions: Vec<Junction>,
}

impl StreetNetwork {
    /// The roads that cars drive on, cut at junctions.
    pub fn new(map: &OsmMap) -> Self {
        let arms = arms(map);
        let mut numbers: BTreeMap<i64, usize> = BTreeMap::new();
        let mut junctions = Vec::new();
        let mut streets = Vec::new();
        for (road, carriageway) in carriageways(map) {
            let mut begin = 0;
            for i in 1..road.nodes.len() {
                // Two arms at an inner node are this road itself, which goes on.
                if i + 1 < road.nodes.len() && arms[&road.nodes[i]].len() == 2 {
                    continue;
                }
                let [from, to] = [begin, i].map(|k| {
                    *numbers.entry(road.nodes[k]).or_insert_with(|| {
                        junctions.push(Junction {
                            arms: arms[&road.nodes[k]].clone(),
                        });
                        junctions.len() - 1
                    })
                });
                let points = road.points[begin..=i].to_vec();
                streets.push(Street {
                    points,
                    carriageway,
                    from,
                    to,
                });
                begin = i;
            }
        }
        Self { streets, junctions }
    }
}

/// Half widths of the carriageways that meet at each node, metres. A road that goes on counts
/// twice.
fn arms(map: &OsmMap) -> BTreeMap<i64, Vec<f64>> {
    let mut arms: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
    for (road, carriageway) in carriageways(map) {
        for (i, node) in road.nodes.iter().enumerate() {
            let inner = i > 0 && i + 1 < road.nodes.len();
            let list = arms.entry(*node).or_default();
            list.extend(std::iter::repeat_n(
                carriageway.half_width,
                if inner { 2 } else { 1 },
            ));
        }
    }
    arms
}

/// Roads with a carriageway and finite coordinates.
fn carriageways(map: &OsmMap) -> impl Iterator<Item = (&Road, Carriageway)> {
    let roads = map
        .roads
        .iter()
        .filter(|road| road.points.iter().all(is_finite));
    roads.filter_map(|road| Some((road, carriageway(&road.tags)?)))
}

fn is_finite(point: &MapPoint) -> bool {
    point.x.is_finite() && point.y.is_finite()
}
