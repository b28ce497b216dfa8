//! Where people walk: footways, paths and crossings of a map, and pavements beside its streets.
//!
//! Ways are cut into places about 2 m apart. Places are linked if one can walk straight between
//! them: along a way, across a gap in it (a street's mouth), and from way to way where they come
//! near each other.

use openbench_core::MapPoint;
use openbench_geometry::line::parallel;
use openbench_osm::{OsmMap, Road};

use super::ground::Ground;
use super::neighbours::Neighbours;
use super::road_tags::{carriageway, footway_half_width};
use super::walk_graph::{Pair, Place, WalkGraph};

/// Distance between places along a way, metres.
const SPACING_M: f64 = 2.0;
/// Places of different ways that are nearer to each other than this are linked, metres.
const JOIN_M: f64 = 2.5;
/// Longest gap in a way that is crossed, metres: a street's mouth.
const MOUTH_M: f64 = 16.0;
/// Room that a place needs beyond that of a person, metres.
const ROOM_M: f64 = 0.1;
/// Half the width of a pavement, metres.
const PAVEMENT_HALF_WIDTH_M: f64 = 0.7;

/// A line to walk along.
struct Line {
    points: Vec<MapPoint>,
    /// Metres.
    half_width: f64,
    /// Whether it is a pavement, which does not lead over carriageways.
    is_pavement: bool,
}

/// First and last place along a line.
struct Ends {
    first: u32,
    last: u32,
}

/// The network of places under construction.
struct Builder<'a> {
    ground: &'a Ground,
    places: Vec<Place>,
    pairs: Vec<Pair>,
}

/// The network that people walk on.
pub(super) fn walk_graph(map: &OsmMap, ground: &Ground) -> WalkGraph {
    let mut builder = Builder {
        ground,
        places: Vec::new(),
        pairs: Vec::new(),
    };
    for road in &map.roads {
        let ends: Vec<_> = lines(road).iter().map(|line| builder.lay(line)).collect();
        // A street's pavements meet at its ends: people cross there.
        if let [Some(left), Some(right)] = &ends[..] {
            builder.link(left.first, right.first);
            builder.link(left.last, right.last);
        }
    }
    builder.join();
    WalkGraph::new(builder.places, builder.pairs)
}

impl Builder<'_> {
    /// Puts places along a line and links them. `None` if there is no room for any.
    fn lay(&mut self, line: &Line) -> Option<Ends> {
        let from = self.places.len() as u32;
        for w in line.points.windows(2) {
            // The bound keeps a single absurd segment from filling memory.
            let steps = (w[0].distance(w[1]) / SPACING_M).ceil().clamp(1.0, 2_000.0) as usize;
            for i in 0..=steps {
                let share = i as f64 / steps as f64;
                let point = MapPoint::new(
                    w[0].x + (w[1].x - w[0].x) * share,
                    w[0].y + (w[1].y - w[0].y) * share,
                );
                // The end of a segment is the beginning of the next.
                let repeated = self.places[from as usize..]
                    .last()
                    .is_some_and(|p| p.point == point);
                if !repeated && self.is_walkable(point, line) {
                    self.places.push(Place {
                        point,
                        half_width: line.half_width,
                    });
                }
            }
        }
        let to = self.places.len() as u32;
        // Where places were left out, the two beside the gap are next to each other here; `link`
        // refuses if the gap is too wide.
        (from + 1..to).for_each(|i| self.link(i - 1, i));
        (to > from).then(|| Ends {
            first: from,
            last: to - 1,
        })
    }

    fn is_walkable(&self, point: MapPoint, line: &Line) -> bool {
        self.ground.clearance(point).distance >= ROOM_M
            && !(line.is_pavement && self.ground.is_road(point))
    }

    /// Links two places that see each other and are not too far apart.
    fn link(&mut self, a: u32, b: u32) {
        let (p, q) = (self.places[a as usize].point, self.places[b as usize].point);
        if a != b && p.distance(q) <= MOUTH_M && self.ground.sees(p, q) {
            self.pairs.push([a, b]);
        }
    }

    /// Links places of different ways that are near each other.
    fn join(&mut self) {
        let mut neighbours = Neighbours::new(JOIN_M);
        neighbours.fill(self.places.iter().map(|p| Some(p.point)));
        for (i, place) in self.places.iter().enumerate() {
            neighbours.near(place.point, |j| {
                let other = self.places[j].point;
                let near = place.point.distance(other) <= JOIN_M;
                // Each pair once. Neighbours along a way may be found again; the graph drops
                // repeated links.
                if j > i && near && self.ground.sees(place.point, other) {
                    self.pairs.push([i as u32, j as u32]);
                }
            });
        }
    }
}

/// The lines of a way that people walk along: its middle, or its left and its right side.
fn lines(road: &Road) -> Vec<Line> {
    if let Some(half_width) = footway_half_width(&road.tags) {
        return vec![Line {
            points: road.points.clone(),
            half_width,
            is_pavement: false,
        }];
    }
    let Some(way) = carriageway(&road.tags) else {
        return Vec::new();
    };
    let left = way.walkers.left.map(|distance| pavement(road, distance));
    let right = way.walkers.right.map(|distance| pavement(road, -distance));
    left.into_iter().chain(right).collect()
}

/// The pavement `offset` metres to the left of a road's middle.
fn pavement(road: &Road, offset: f64) -> Line {
    Line {
        points: parallel(&road.points, offset),
        half_width: PAVEMENT_HALF_WIDTH_M,
        is_pavement: true,
    }
}
