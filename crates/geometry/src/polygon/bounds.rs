//! Bounding box of a polygon.

use super::shape::Polygon;
use crate::bounds::Bounds;

impl Polygon {
    /// The bounding box of the outer ring; the origin alone, if the ring is empty.
    pub fn bounds(&self) -> Bounds {
        let start = Bounds::of_point(self.outer.first().copied().unwrap_or_default());
        self.outer.iter().fold(start, |bounds, point| {
            bounds.union(Bounds::of_point(*point))
        })
    }
}
