//! Shortest routes after Dijkstra (1959), from a place on one segment to a place on another.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use openbench_core::MapPoint;

use crate::graph::{RoadGraph, Snap};
use crate::{Route, RouteError, Router};

/// How far from a place a road may be, metres.
const SNAP_LIMIT: f64 = 1000.0;

/// How much further the largest part of the network may be than a part that leads nowhere, metres.
const ISLAND_LIMIT: f64 = 100.0;

/// Plain Dijkstra over a road graph.
#[derive(Debug, Clone)]
pub struct Dijkstra {
    graph: RoadGraph,
}

impl Dijkstra {
    /// A router over a graph.
    pub fn new(graph: RoadGraph) -> Self {
        Self { graph }
    }

    /// The graph.
    pub fn graph(&self) -> &RoadGraph {
        &self.graph
    }

    fn snap(&self, near: MapPoint) -> Result<Snap, RouteError> {
        self.graph.snap(near, SNAP_LIMIT).ok_or(RouteError::NoSegment { near, limit: SNAP_LIMIT })
    }

    /// Ways off a snapped place: vertex, length, time and road of the part of the segment on the way there.
    fn leave(&self, snap: &Snap) -> Vec<Leg> {
        let (a, b) = snap.ends;
        let part = |from: u32, to: u32, share: f64| {
            self.graph.arc_between(from, to).map(|arc| Leg { vertex: to, share, arc: *arc })
        };
        [part(a, b, 1.0 - snap.share), part(b, a, snap.share)].into_iter().flatten().collect()
    }

    /// Ways on to a snapped place: the vertex they come from.
    fn arrive(&self, snap: &Snap) -> Vec<Leg> {
        let (a, b) = snap.ends;
        let part = |from: u32, to: u32, share: f64| {
            self.graph.arc_between(from, to).map(|arc| Leg { vertex: from, share, arc: *arc })
        };
        [part(a, b, snap.share), part(b, a, 1.0 - snap.share)].into_iter().flatten().collect()
    }

    /// The part of one segment between two places on it, if it may be driven in that direction.
    fn within_segment(&self, from: &Snap, to: &Snap) -> Option<Route> {
        let (a, b) = from.ends;
        // The same piece of road may be listed from either end.
        let to_share = if to.ends == from.ends {
            to.share
        } else if to.ends == (b, a) {
            1.0 - to.share
        } else {
            return None;
        };
        let (tail, head, share) = if to_share >= from.share {
            (a, b, to_share - from.share)
        } else {
            (b, a, from.share - to_share)
        };
        let arc = self.graph.arc_between(tail, head)?;
        let names = Some(self.graph.name(arc.road).to_owned()).filter(|n| !n.is_empty());
        Some(Route {
            points: vec![from.point, to.point],
            distance: share * arc.length,
            duration: share * arc.time,
            names: names.into_iter().collect(),
        })
    }

    fn between(&self, from: &Snap, to: &Snap) -> Option<Route> {
        let (direct, around) = (self.within_segment(from, to), self.search(from, to));
        [direct, around].into_iter().flatten().min_by(|a, b| a.duration.total_cmp(&b.duration))
    }

    fn search(&self, from: &Snap, to: &Snap) -> Option<Route> {
        let count = self.graph.len();
        let mut time = vec![f64::INFINITY; count];
        let mut parent = vec![u32::MAX; count];
        let mut closed = vec![false; count];
        let mut queue = BinaryHeap::new();
        for leg in self.leave(from) {
            let start = leg.share * leg.arc.time;
            if start < time[leg.vertex as usize] {
                time[leg.vertex as usize] = start;
                queue.push(Entry { time: start, vertex: leg.vertex });
            }
        }
        let ends = self.arrive(to);
        let mut best: Option<(f64, Leg)> = None;
        while let Some(Entry { time: now, vertex }) = queue.pop() {
            if best.is_some_and(|(total, _)| now >= total) {
                break;
            }
            if std::mem::replace(&mut closed[vertex as usize], true) {
                continue;
            }
            for leg in ends.iter().filter(|leg| leg.vertex == vertex) {
                let total = now + leg.share * leg.arc.time;
                if best.is_none_or(|(b, _)| total < b) {
                    best = Some((total, *leg));
                }
            }
            for arc in self.graph.arcs(vertex) {
                let next = now + arc.time;
                if next < time[arc.to as usize] {
                    time[arc.to as usize] = next;
                    parent[arc.to as usize] = vertex;
                    queue.push(Entry { time: next, vertex: arc.to });
                }
            }
        }
        best.map(|(duration, last)| self.unpack(from, to, &parent, last, duration))
    }

    fn unpack(&self, from: &Snap, to: &Snap, parent: &[u32], last: Leg, duration: f64) -> Route {
        let mut vertices = vec![last.vertex];
        while let Some(&p) = vertices.last().map(|&v| &parent[v as usize]).filter(|&&p| p != u32::MAX) {
            vertices.push(p);
        }
        vertices.reverse();
        let first = self.leave(from).into_iter().find(|leg| leg.vertex == vertices[0]);
        let (mut distance, mut names) = (0.0, Vec::new());
        let mut pass = |share: f64, arc: &crate::graph::Arc| {
            distance += share * arc.length;
            let name = self.graph.name(arc.road);
            if share > 0.0 && !name.is_empty() && names.last().is_none_or(|n| n != name) {
                names.push(name.to_owned());
            }
        };
        if let Some(leg) = first {
            pass(leg.share, &leg.arc);
        }
        for pair in vertices.windows(2) {
            if let Some(arc) = self.graph.arc_between(pair[0], pair[1]) {
                pass(1.0, arc);
            }
        }
        pass(last.share, &last.arc);
        let middle = vertices.iter().map(|&v| self.graph.point(v));
        let mut points: Vec<MapPoint> = std::iter::once(from.point).chain(middle).chain([to.point]).collect();
        points.dedup_by(|a, b| a.distance(*b) < 1e-6);
        Route { points, distance, duration, names }
    }
}

impl Router for Dijkstra {
    fn route(&self, from: MapPoint, to: MapPoint) -> Result<Route, RouteError> {
        let (start, goal) = (self.snap(from)?, self.snap(to)?);
        let nearest = self.between(&start, &goal);
        // A courtyard's path or a bridge cut off at the map's edge may be nearest and lead nowhere.
        let connected = || {
            let away = |snap: &Snap| snap.away + ISLAND_LIMIT;
            let start = self.graph.snap_to_largest(from, away(&start))?;
            self.between(&start, &self.graph.snap_to_largest(to, away(&goal))?)
        };
        nearest.or_else(connected).ok_or(RouteError::NoRoute { from, to })
    }
}

/// Part of an arc at the beginning or end of a route.
#[derive(Debug, Clone, Copy)]
struct Leg {
    vertex: u32,
    share: f64,
    arc: crate::graph::Arc,
}

#[derive(PartialEq)]
struct Entry {
    time: f64,
    vertex: u32,
}

impl Eq for Entry {}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        other.time.total_cmp(&self.time).then(other.vertex.cmp(&self.vertex))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::Profile;
    use openbench_core::{Georeference, LonLat};
    use openbench_osm::{OsmData, OsmMap};

    /// A square of streets, 0.001 degrees a side, its north side one-way eastwards, and an island of road far away.
    const SQUARE: &str = r#"<osm version="0.6">
      <node id="1" lat="50.000" lon="8.000"/><node id="2" lat="50.000" lon="8.001"/>
      <node id="3" lat="50.001" lon="8.001"/><node id="4" lat="50.001" lon="8.000"/>
      <node id="8" lat="50.005" lon="8.005"/><node id="9" lat="50.005" lon="8.006"/>
      <way id="10"><nd ref="1"/><nd ref="2"/><tag k="highway" v="residential"/><tag k="name" v="South"/></way>
      <way id="11"><nd ref="2"/><nd ref="3"/><tag k="highway" v="residential"/><tag k="name" v="East"/></way>
      <way id="12"><nd ref="4"/><nd ref="3"/><tag k="highway" v="residential"/><tag k="oneway" v="yes"/><tag k="name" v="North"/></way>
      <way id="13"><nd ref="4"/><nd ref="1"/><tag k="highway" v="residential"/></way>
      <way id="14"><nd ref="8"/><nd ref="9"/><tag k="highway" v="footway"/></way>
    </osm>"#;

    fn router(profile: Profile) -> (Dijkstra, OsmMap) {
        let data = OsmData::from_xml(SQUARE.as_bytes()).unwrap();
        let map = OsmMap::new(&data, Georeference::TangentPlane(LonLat::new(8.0, 50.0)));
        (Dijkstra::new(RoadGraph::new(&map, profile)), map)
    }

    fn at(map: &OsmMap, lon: f64, lat: f64) -> MapPoint {
        map.projection.to_map(LonLat::new(lon, lat))
    }

    #[test]
    fn one_ways_are_kept_by_cars_and_not_by_robots() {
        for (profile, expected) in [(Profile::Car, 3), (Profile::Delivery, 1)] {
            let (router, map) = router(profile);
            let route = router.route(at(&map, 8.001, 50.001), at(&map, 8.0, 50.001)).unwrap();
            assert_eq!(route.points.len(), expected + 1, "{profile:?} {:?}", route.points);
        }
    }

    #[test]
    fn routes_begin_and_end_between_nodes() {
        let (router, map) = router(Profile::Delivery);
        let (a, b) = (at(&map, 8.0002, 50.0), at(&map, 8.001, 50.0003));
        let route = router.route(a, b).unwrap();
        let expected = a.distance(at(&map, 8.001, 50.0)) + b.distance(at(&map, 8.001, 50.0));
        assert!((route.distance - expected).abs() < 0.1, "{} {expected}", route.distance);
        assert_eq!(route.names, ["South", "East"]);
    }

    #[test]
    fn both_ends_on_one_segment() {
        let (router, map) = router(Profile::Car);
        let (a, b) = (at(&map, 8.0008, 50.001), at(&map, 8.0002, 50.001));
        let forward = router.route(b, a).unwrap();
        assert!((forward.distance - a.distance(b)).abs() < 0.1);
        // Against the one-way street a car must go round.
        let round = router.route(a, b).unwrap();
        assert!(round.distance > 3.0 * forward.distance && round.points.len() >= 6, "{round:?}");
    }

    #[test]
    fn what_does_not_hang_together_has_no_route() {
        let (router, map) = router(Profile::Delivery);
        let result = router.route(at(&map, 8.0, 50.0), at(&map, 8.0055, 50.005));
        assert!(matches!(result, Err(RouteError::NoRoute { .. })), "{result:?}");
        let result = router.route(at(&map, 8.0, 50.0), at(&map, 8.5, 50.0));
        assert!(matches!(result, Err(RouteError::NoSegment { .. })), "{result:?}");
    }

    #[test]
    fn an_island_near_the_network_is_left_for_it() {
        // A path of two nodes 20 m off the square's south side.
        let yard = r#"<node id="20" lat="49.9998" lon="8.0004"/><node id="21" lat="49.9998" lon="8.0005"/>
          <way id="22"><nd ref="20"/><nd ref="21"/><tag k="highway" v="footway"/></way></osm>"#;
        let data = OsmData::from_xml(SQUARE.replace("</osm>", yard).as_bytes()).unwrap();
        let map = OsmMap::new(&data, Georeference::TangentPlane(LonLat::new(8.0, 50.0)));
        let router = Dijkstra::new(RoadGraph::new(&map, Profile::Delivery));
        let route = router.route(at(&map, 8.00045, 49.99981), at(&map, 8.001, 50.001)).unwrap();
        assert!(route.distance > 100.0, "{route:?}");
    }

    #[test]
    fn a_map_without_roads_has_no_segment() {
        let map = OsmMap::new(&OsmData::default(), Georeference::TangentPlane(LonLat::new(8.0, 50.0)));
        let router = Dijkstra::new(RoadGraph::new(&map, Profile::Delivery));
        let result = router.route(MapPoint::default(), MapPoint::new(1.0, 1.0));
        assert!(matches!(result, Err(RouteError::NoSegment { .. })));
    }
}
