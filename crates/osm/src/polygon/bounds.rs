//! Axis-aligned bounding boxes.

use openbench_core::MapPoint;

use super::shape::Polygon;

/// An axis-aligned box in the `map` frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bounds {
    /// South-west corner.
    pub low: MapPoint,
    /// North-east corner.
    pub high: MapPoint,
}

impl Bounds {
    /// The box that holds one point.
    #[inline]
    pub const fn of_point(point: MapPoint) -> Self {
        Self {
            low: point,
            high: point,
        }
    }

    /// The smallest box that holds both.
    #[must_use]
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self {
            low: MapPoint::new(self.low.x.min(other.low.x), self.low.y.min(other.low.y)),
            high: MapPoint::new(self.high.x.max(other.high.x), self.high.y.max(other.high.y)),
        }
    }

    /// Metres from `point` to the box; 0 inside.
    #[inline]
    pub fn distance(&self, point: MapPoint) -> f64 {
        let dx = (self.low.x - point.x).max(point.x - self.high.x).max(0.0);
        let dy = (self.low.y - point.y).max(point.y - self.high.y).max(0.0);
        (dx * dx + dy * dy).sqrt()
    }
}

impl Polygon {
    /// The bounding box of the outer ring; the origin alone, if the ring is empty.
    pub fn bounds(&self) -> Bounds {
        let start = Bounds::of_point(self.outer.first().copied().unwrap_or_default());
        self.outer.iter().fold(start, |bounds, point| {
            bounds.union(Bounds::of_point(*point))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_count_from_the_nearest_side_or_corner() {
        let bounds = Bounds {
            low: MapPoint::new(0.0, 0.0),
            high: MapPoint::new(2.0, 1.0),
        };
        assert_eq!(bounds.distance(MapPoint::new(1.0, 0.5)), 0.0);
        assert_eq!(bounds.distance(MapPoint::new(1.0, 4.0)), 3.0);
        assert_eq!(bounds.distance(MapPoint::new(5.0, -4.0)), 5.0);
    }
}
