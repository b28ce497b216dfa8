//! The extent of a world on the ground.

use openbench_core::MapPoint;
use openbench_scene::Scene;

/// A rectangle in `map`, parallel to its axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    low: MapPoint,
    high: MapPoint,
}

impl Bounds {
    /// Holds no point.
    const EMPTY: Self = Self {
        low: MapPoint::new(f64::INFINITY, f64::INFINITY),
        high: MapPoint::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
    };
    /// Holds every point but those with NaN.
    const EVERYWHERE: Self = Self {
        low: Self::EMPTY.high,
        high: Self::EMPTY.low,
    };

    /// Around the static triangles of a scene; everywhere if it has none.
    pub(crate) fn of(scene: &Scene) -> Self {
        let corners = scene
            .standing()
            .iter()
            .flat_map(|triangle| triangle.corners);
        let bounds = corners.fold(Self::EMPTY, |bounds, corner| {
            let [x, y, _] = scene.vertices[corner as usize].position.map(f64::from);
            bounds.with(MapPoint::new(x, y))
        });
        if bounds.low.x <= bounds.high.x {
            bounds
        } else {
            Self::EVERYWHERE
        }
    }

    fn with(self, point: MapPoint) -> Self {
        Self {
            low: MapPoint::new(self.low.x.min(point.x), self.low.y.min(point.y)),
            high: MapPoint::new(self.high.x.max(point.x), self.high.y.max(point.y)),
        }
    }

    /// Whether `point` lies at most `margin` metres outside along each axis. A point with NaN does
    /// not.
    pub(crate) fn hold(&self, point: MapPoint, margin: f64) -> bool {
        point.x >= self.low.x - margin
            && point.x <= self.high.x + margin
            && point.y >= self.low.y - margin
            && point.y <= self.high.y + margin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_with_nan_lies_nowhere() {
        let nowhere = MapPoint::new(f64::NAN, 0.0);
        assert!(!Bounds::EVERYWHERE.hold(nowhere, 50.0));
        assert!(Bounds::EVERYWHERE.hold(MapPoint::new(1e9, -1e9), 0.0));
    }

    #[test]
    fn the_margin_counts_along_each_axis() {
        let bounds = Bounds::EMPTY
            .with(MapPoint::new(0.0, 0.0))
            .with(MapPoint::new(10.0, 20.0));
        assert!(bounds.hold(MapPoint::new(-5.0, 25.0), 5.0));
        assert!(!bounds.hold(MapPoint::new(-5.1, 20.0), 5.0));
        assert!(!bounds.hold(MapPoint::new(10.0, 25.1), 5.0));
    }
}
