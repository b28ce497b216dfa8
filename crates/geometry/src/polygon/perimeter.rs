//! Perimeter of a polygon.

use super::shape::Polygon;
use crate::segment::{Segment, sides};

impl Polygon {
    /// Length of the outer ring, metres.
    pub fn perimeter(&self) -> f64 {
        sides(&self.outer).map(Segment::length).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::courtyard_house;

    #[test]
    fn the_walls_of_holes_do_not_count() {
        assert_eq!(courtyard_house().perimeter(), 32.0);
    }
}
