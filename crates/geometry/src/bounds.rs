//! Axis-aligned bounding boxes.

use openbench_core::MapPoint;

/// An axis-aligned box in the `map` frame.
///
/// ```
/// use openbench_core::MapPoint;
/// use openbench_geometry::Bounds;
///
/// let yard = Bounds { low: MapPoint::new(0.0, 0.0), high: MapPoint::new(20.0, 10.0) };
/// assert_eq!(yard.distance(MapPoint::new(23.0, 14.0)), 5.0);
/// ```
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

    /// The part that both have in common. If there is none, `low` is beyond `high`.
    #[must_use]
    #[inline]
    pub fn intersection(self, other: Self) -> Self {
        Self {
            low: MapPoint::new(self.low.x.max(other.low.x), self.low.y.max(other.low.y)),
            high: MapPoint::new(self.high.x.min(other.high.x), self.high.y.min(other.high.y)),
        }
    }

    /// The box with `margin` more metres on each side.
    #[must_use]
    #[inline]
    pub fn grown(self, margin: f64) -> Self {
        Self {
            low: MapPoint::new(self.low.x - margin, self.low.y - margin),
            high: MapPoint::new(self.high.x + margin, self.high.y + margin),
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

    #[test]
    fn a_grown_box_intersected_with_the_box_is_the_box() {
        let bounds = Bounds {
            low: MapPoint::new(0.0, 0.0),
            high: MapPoint::new(2.0, 1.0),
        };
        let grown = bounds.grown(0.5);
        assert_eq!(grown.low, MapPoint::new(-0.5, -0.5));
        assert_eq!(grown.high, MapPoint::new(2.5, 1.5));
        assert_eq!(grown.intersection(bounds), bounds);
        assert_eq!(grown.union(bounds), grown);
    }
}
