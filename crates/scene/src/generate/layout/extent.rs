//! The rectangle that a world covers: around the buildings of its map.

use std::ops::Range;

use openbench_core::{Georeference, MapPoint};
use openbench_geometry::{Bounds, Polygon, Segment};
use openbench_osm::OsmMap;

use crate::generate::error::{GenerateError, MAX_BUILDINGS, MAX_EXTENT_M};

/// Ground beyond the outermost mapped building, metres.
pub(crate) const GROUND_MARGIN_M: f64 = 80.0;
/// Farther than this from UTM's central meridian lengths are half a percent too long, metres.
const MAX_FROM_MERIDIAN_M: f64 = 640_000.0;
/// Farther than this from the point at which a plane touches the Earth lengths are half a percent
/// too short, metres.
const MAX_FROM_TOUCH_M: f64 = 640_000.0;

/// A rectangle along the axes of the `map` frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extent {
    /// South-western corner.
    pub min: MapPoint,
    /// North-eastern corner.
    pub max: MapPoint,
}

impl Extent {
    /// The rectangle around a map's buildings.
    ///
    /// Roads and areas may reach far out of an extract; the buildings say where the neighbourhood
    /// is.
    ///
    /// # Errors
    /// A map without buildings, one that is too large, and one that lies where the georeference
    /// distorts lengths.
    pub fn of_map(map: &OsmMap, georeference: Georeference) -> Result<Self, GenerateError> {
        if map.buildings.is_empty() {
            let broken = map.report.broken_buildings;
            return Err(GenerateError::NoBuildings { broken });
        }
        if map.buildings.len() > MAX_BUILDINGS {
            let buildings = map.buildings.len();
            return Err(GenerateError::TooMany { buildings });
        }
        let mut extent = Self {
            min: MapPoint::new(f64::INFINITY, f64::INFINITY),
            max: MapPoint::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
        };
        for p in map.buildings.iter().flat_map(|b| &b.polygon.outer) {
            extent.min = MapPoint::new(extent.min.x.min(p.x), extent.min.y.min(p.y));
            extent.max = MapPoint::new(extent.max.x.max(p.x), extent.max.y.max(p.y));
        }
        let metres = (extent.max.x - extent.min.x).max(extent.max.y - extent.min.y);
        if metres > MAX_EXTENT_M {
            return Err(GenerateError::TooLarge { metres });
        }
        extent.check_scale(georeference)?;
        Ok(extent)
    }

    fn check_scale(self, georeference: Georeference) -> Result<(), GenerateError> {
        let metres = georeference.distance_from_true_scale(self.middle());
        let limit = match georeference {
            Georeference::Utm { .. } => MAX_FROM_MERIDIAN_M,
            Georeference::TangentPlane { .. } => MAX_FROM_TOUCH_M,
        };
        if metres.is_nan() || metres > limit {
            let georeference = georeference.to_string();
            return Err(GenerateError::Distorted {
                metres,
                georeference,
            });
        }
        Ok(())
    }

    pub fn middle(self) -> MapPoint {
        MapPoint::new(
            (self.min.x + self.max.x) / 2.0,
            (self.min.y + self.max.y) / 2.0,
        )
    }

    /// The rectangle with `margin` more metres on each side.
    pub fn grown(self, margin: f64) -> Self {
        let (min, max) = (self.min, self.max);
        Self {
            min: MapPoint::new(min.x - margin, min.y - margin),
            max: MapPoint::new(max.x + margin, max.y + margin),
        }
    }

    /// The corners, counter-clockwise from the south-west.
    pub fn corners(self) -> [MapPoint; 4] {
        let (min, max) = (self.min, self.max);
        [
            min,
            MapPoint::new(max.x, min.y),
            max,
            MapPoint::new(min.x, max.y),
        ]
    }

    /// Whether a polygon may have something in common with the rectangle grown by `margin` metres.
    pub fn meets(self, polygon: &Polygon, margin: f64) -> bool {
        let Bounds { low, high } = polygon.bounds();
        let (min, max) = (self.min, self.max);
        low.x <= max.x + margin
            && high.x >= min.x - margin
            && low.y <= max.y + margin
            && high.y >= min.y - margin
    }

    /// Whether `point` is inside the rectangle grown by `margin` metres.
    pub fn holds(self, point: MapPoint, margin: f64) -> bool {
        let inside = |v: f64, low: f64, high: f64| v >= low - margin && v <= high + margin;
        inside(point.x, self.min.x, self.max.x) && inside(point.y, self.min.y, self.max.y)
    }

    /// The part of a segment that lies in the rectangle, as shares of it (Liang and Barsky, *A New
    /// Concept and Method for Line Clipping*, 1984).
    pub fn clip(self, Segment { start: a, end: b }: Segment) -> Option<Range<f64>> {
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        // For each edge: the speed at which the segment leaves it, and the room inside of it at
        // `a`.
        let edges = [
            (-dx, a.x - self.min.x),
            (dx, self.max.x - a.x),
            (-dy, a.y - self.min.y),
            (dy, self.max.y - a.y),
        ];
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (leaving, room) in edges {
            if leaving == 0.0 && room < 0.0 {
                return None;
            }
            if leaving < 0.0 {
                from = from.max(room / leaving);
            } else if leaving > 0.0 {
                to = to.min(room / leaving);
            }
        }
        (from < to).then_some(from..to)
    }
}
