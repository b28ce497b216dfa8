//! A neighbourhood cut out of a larger map.
//!
//! Buildings and other areas are kept whole, so that no house is cut in two. Lines (roads, walls)
//! end one node outside the window. Coastlines continue for some 300 m, so that the sea can be
//! closed around the outermost houses. A line that leaves the window and comes back becomes several
//! ways, the later ones with new negative numbers. Of the relations only multipolygons are kept:
//! routes and boundaries mean nothing in a cut-out.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use openbench_core::LonLat;

use crate::areas::{is_area, is_multipolygon};
use crate::data::OsmData;
use crate::element::{ElementKind, Relation, Way};

/// Metres per degree of latitude; accurate to half a percent everywhere.
const METRES_PER_DEGREE: f64 = 111_320.0;
/// How far outside the window coastlines are kept, metres.
const COAST_MARGIN_M: f64 = 300.0;

/// A rectangle between two meridians and two parallels, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// South-west corner.
    pub low: LonLat,
    /// North-east corner.
    pub high: LonLat,
}

/// The edges do not bound a rectangle on the Earth.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "`{0}` is not a window; give west, south, east, north in degrees, \
     west of east and south of north"
)]
pub struct WindowError(Window);

impl Window {
    /// A window from its edges, degrees.
    ///
    /// # Errors
    /// If an edge is off the Earth, west is not west of east (as across the date line), or south is
    /// not south of north.
    pub fn new(west: f64, south: f64, east: f64, north: f64) -> Result<Self, WindowError> {
        let window = Self {
            low: LonLat::new(west, south),
            high: LonLat::new(east, north),
        };
        let good = west >= -180.0 && east <= 180.0 && south >= -90.0 && north <= 90.0;
        if good && west < east && south < north {
            Ok(window)
        } else {
            Err(WindowError(window))
        }
    }

    /// The square that extends `radius` metres to each side of `middle`.
    ///
    /// # Errors
    /// If it extends across the date line or beyond a pole.
    ///
    /// ```
    /// use openbench_core::LonLat;
    /// use openbench_osm::Window;
    ///
    /// // The middle of Monaco: 500 m are 0.0045 degrees of latitude and 0.0062 of longitude.
    /// let window = Window::around(LonLat::new(7.42, 43.73), 500.0)?;
    /// assert!(window.contains(LonLat::new(7.4261, 43.734)));
    /// assert!(!window.contains(LonLat::new(7.4263, 43.73)));
    /// # Ok::<(), openbench_osm::WindowError>(())
    /// ```
    pub fn around(middle: LonLat, radius: f64) -> Result<Self, WindowError> {
        let tall = radius / METRES_PER_DEGREE;
        // Meridians converge towards the poles, where the cosine is 0.
        let wide = tall / libm::cos(middle.lat.to_radians()).max(1e-6);
        Self::new(
            middle.lon - wide,
            middle.lat - tall,
            middle.lon + wide,
            middle.lat + tall,
        )
    }

    /// The window grown by some metres to each side.
    fn grown(&self, metres: f64) -> Self {
        let tall = metres / METRES_PER_DEGREE;
        let wide = tall / libm::cos(self.low.lat.to_radians()).max(1e-6);
        let (low, high) = (self.low, self.high);
        Self {
            low: LonLat::new(low.lon - wide, low.lat - tall),
            high: LonLat::new(high.lon + wide, high.lat + tall),
        }
    }

    /// Whether a position is inside.
    pub fn contains(&self, p: LonLat) -> bool {
        self.meets(p, p)
    }

    /// Whether it intersects the rectangle between two corners.
    fn meets(&self, a: LonLat, b: LonLat) -> bool {
        a.lon.max(b.lon) >= self.low.lon
            && a.lon.min(b.lon) <= self.high.lon
            && a.lat.max(b.lat) >= self.low.lat
            && a.lat.min(b.lat) <= self.high.lat
    }
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{},{},{},{}",
            self.low.lon, self.low.lat, self.high.lon, self.high.lat
        )
    }
}

/// The part of `data` inside `window`. Buildings with a corner inside are kept, and all other areas
/// that reach into the window.
pub fn cut_out(data: &OsmData, window: &Window) -> OsmData {
    let mut cut = Cut {
        data,
        window,
        out: OsmData::default(),
    };
    // Relations come first: their ways are kept whole, and must not be cut as lines afterwards.
    for relation in data.relations.values().filter(|r| is_multipolygon(r)) {
        cut.relation(relation);
    }
    let mut next = data
        .ways
        .first_key_value()
        // Below all numbers in use, and negative, as editors number elements that the OSM database
        // lacks.
        .map_or(-1, |(id, _)| (*id).min(0).saturating_sub(1));
    for way in data.ways.values() {
        cut.way(way, &mut next);
    }
    cut.nodes();
    let mut out = cut.out;
    // The report is of the file that was read, except for references: the cut-out has only those
    // whose targets it has.
    out.report = data.report;
    (
        out.report.ways_with_missing_nodes,
        out.report.relations_with_missing_members,
    ) = (0, 0);
    out
}

struct Cut<'a> {
    data: &'a OsmData,
    window: &'a Window,
    out: OsmData,
}

impl Cut<'_> {
    fn relation(&mut self, relation: &Relation) {
        let ways: Vec<&Way> = relation
            .members
            .iter()
            .filter(|m| m.kind == ElementKind::Way)
            .filter_map(|m| self.data.ways.get(&m.id))
            .collect();
        let nodes = || ways.iter().flat_map(|way| &way.nodes);
        // A building counts by its corners. A lake may contain the window without a corner in it,
        // so other areas count by their bounds.
        let wanted = if relation.tags.says("building") {
            self.has_corner(nodes())
        } else {
            is_area(&relation.tags) && self.reaches(nodes())
        };
        if !wanted {
            return;
        }
        let ids: BTreeSet<i64> = ways.iter().map(|way| way.id).collect();
        let mut kept = relation.clone();
        kept.members
            .retain(|m| m.kind == ElementKind::Way && ids.contains(&m.id));
        let whole: Vec<Way> = ways.iter().map(|way| self.complete(way)).collect();
        self.out
            .ways
            .extend(whole.into_iter().map(|way| (way.id, way)));
        self.out.relations.insert(kept.id, kept);
    }

    fn way(&mut self, way: &Way, next: &mut i64) {
        let area = way.is_closed() && (way.tags.says("building") || is_area(&way.tags));
        if area {
            let wanted = if way.tags.says("building") {
                self.has_corner(way.nodes.iter())
            } else {
                self.reaches(way.nodes.iter())
            };
            if wanted {
                self.out.ways.insert(way.id, self.complete(way));
            }
            return;
        }
        // A member of a multipolygon that was kept whole.
        if self.out.ways.contains_key(&way.id) {
            return;
        }
        for (i, nodes) in self.stretches(way).into_iter().enumerate() {
            // The first stretch keeps the way's number, so that references to it still have a
            // target.
            let id = if i == 0 { way.id } else { *next };
            *next -= i64::from(i > 0);
            self.out.ways.insert(
                id,
                Way {
                    id,
                    nodes,
                    tags: way.tags.clone(),
                },
            );
        }
    }

    /// The way without the nodes that the data lacks.
    fn complete(&self, way: &Way) -> Way {
        let nodes = way
            .nodes
            .iter()
            .copied()
            .filter(|id| self.data.nodes.contains_key(id))
            .collect();
        Way {
            id: way.id,
            nodes,
            tags: way.tags.clone(),
        }
    }

    /// The stretches of a line whose segments reach into the window.
    fn stretches(&self, way: &Way) -> Vec<Vec<i64>> {
        let coast = way.tags.is("natural", "coastline");
        let window = if coast {
            self.window.grown(COAST_MARGIN_M)
        } else {
            *self.window
        };
        let mut stretches: Vec<Vec<i64>> = Vec::new();
        let mut open = false;
        for pair in way.nodes.windows(2) {
            let ends = self.position(pair[0]).zip(self.position(pair[1]));
            // The segment's own bounds are tested, so some segments that pass a corner of the
            // window are kept as well. A segment without a known end is a gap.
            if !ends.is_some_and(|(a, b)| window.meets(a, b)) {
                open = false;
                continue;
            }
            match stretches.last_mut().filter(|_| open) {
                Some(stretch) => stretch.push(pair[1]),
                None => stretches.push(pair.to_vec()),
            }
            open = true;
        }
        stretches
    }

    /// Keeps nodes that ways use, and nodes with tags inside the window.
    fn nodes(&mut self) {
        let used: BTreeSet<i64> = self
            .out
            .ways
            .values()
            .flat_map(|way| way.nodes.iter().copied())
            .collect();
        let wanted = self.data.nodes.values().filter(|node| {
            used.contains(&node.id) || !node.tags.is_empty() && self.window.contains(node.position)
        });
        self.out.nodes = wanted
            .map(|node| (node.id, node.clone()))
            .collect::<BTreeMap<_, _>>();
    }

    fn position(&self, node: i64) -> Option<LonLat> {
        self.data.nodes.get(&node).map(|n| n.position)
    }

    fn has_corner<'n>(&self, mut nodes: impl Iterator<Item = &'n i64>) -> bool {
        nodes.any(|id| self.position(*id).is_some_and(|p| self.window.contains(p)))
    }

    fn reaches<'n>(&self, nodes: impl Iterator<Item = &'n i64>) -> bool {
        let places = nodes.filter_map(|id| self.position(*id));
        let bounds = places.fold(None, |bounds: Option<(LonLat, LonLat)>, p| {
            let (a, b) = bounds.unwrap_or((p, p));
            let low = LonLat::new(a.lon.min(p.lon), a.lat.min(p.lat));
            Some((low, LonLat::new(b.lon.max(p.lon), b.lat.max(p.lat))))
        });
        bounds.is_some_and(|(low, high)| self.window.meets(low, high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{ElementId, Member};

    /// Whether every reference has its target.
    fn is_whole(data: &OsmData) -> bool {
        let members = data.relations.values().flat_map(|r| &r.members);
        data.ways
            .values()
            .flat_map(|w| &w.nodes)
            .all(|n| data.has(ElementId::node(*n)))
            && members.map(Member::element).all(|e| data.has(e))
    }

    /// A road that leaves the window and comes back, a house on its edge, a park around it all, and
    /// a house outside.
    fn town() -> OsmData {
        let node =
            |id: i64, lon: f64, lat: f64| format!("<node id='{id}' lat='{lat}' lon='{lon}'/>");
        let way = |id: i64, nodes: &[i64], tag: (&str, &str)| {
            let nodes: String = nodes.iter().map(|n| format!("<nd ref='{n}'/>")).collect();
            format!(
                "<way id='{id}'>{nodes}<tag k='{}' v='{}'/></way>",
                tag.0, tag.1
            )
        };
        let mut text = String::from("<osm>");
        for (i, (lon, lat)) in [
            (0.1, 0.1),
            (0.2, 0.1),
            (1.5, 0.1),
            (1.6, 0.9),
            (1.5, 0.9),
            (0.5, 0.9),
        ]
        .into_iter()
        .enumerate()
        {
            text += &node(1 + i as i64, lon, lat);
        }
        for (first, x) in [(10, 0.9), (20, 1.2)] {
            for (k, (dx, dy)) in [(0.0, 0.0), (0.2, 0.0), (0.2, 0.2), (0.0, 0.2)]
                .into_iter()
                .enumerate()
            {
                text += &node(first + k as i64, x + dx, 0.4 + dy);
            }
        }
        for (k, (x, y)) in [(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)]
            .into_iter()
            .enumerate()
        {
            text += &node(30 + k as i64, x, y);
        }
        text += &way(1, &[1, 2, 3, 4, 5, 6], ("highway", "residential"));
        text += &way(2, &[10, 11, 12, 13, 10], ("building", "yes"));
        text += &way(3, &[20, 21, 22, 23, 20], ("building", "yes"));
        text += &way(4, &[30, 31, 32, 33, 30], ("leisure", "park"));
        OsmData::from_xml((text + "</osm>").as_bytes()).unwrap()
    }

    #[test]
    fn houses_stay_whole_and_roads_end_one_node_outside_the_window() {
        let cut = cut_out(&town(), &Window::new(0.0, 0.0, 1.0, 1.0).unwrap());
        assert!(is_whole(&cut));
        assert_eq!(cut.ways[&1].nodes, [1, 2, 3]);
        assert_eq!(
            cut.ways[&-1].nodes,
            [5, 6],
            "the way back is a way of its own"
        );
        assert_eq!(cut.ways[&2].nodes.len(), 5);
        assert!(!cut.ways.contains_key(&3), "outside");
        assert!(cut.ways.contains_key(&4), "around the window");
    }

    #[test]
    fn parts_of_buildings_stay_whole() {
        let mut town = town();
        town.ways.get_mut(&2).unwrap().tags = [("building:part", "yes")].into_iter().collect();
        let cut = cut_out(&town, &Window::new(0.0, 0.0, 1.0, 1.0).unwrap());
        assert_eq!(cut.ways[&2].nodes, [10, 11, 12, 13, 10]);
    }

    #[test]
    fn multipolygons_keep_their_ways() {
        let court = OsmData::from_xml(include_bytes!("../tests/fixtures/court.osm")).unwrap();
        let cut = cut_out(&court, &Window::new(-1.0, -1.0, 1.0, 1.0).unwrap());
        assert!(is_whole(&cut));
        assert_eq!(
            cut.relations[&40].members.len(),
            court.relations[&40].members.len()
        );
        assert!(
            cut_out(&court, &Window::new(50.0, 50.0, 51.0, 51.0).unwrap())
                .nodes
                .is_empty()
        );
    }

    #[test]
    fn invalid_windows_are_refused() {
        assert!(
            Window::new(2.0, 0.0, 1.0, 1.0).is_err()
                && Window::new(0.0, f64::NAN, 1.0, 1.0).is_err()
        );
        assert!(Window::around(LonLat::new(179.9999, 0.0), 500.0).is_err());
        let window = Window::around(LonLat::new(7.42, 43.73), 500.0).unwrap();
        assert!(
            window.contains(LonLat::new(7.4261, 43.734))
                && !window.contains(LonLat::new(7.4263, 43.73))
        );
    }
}
