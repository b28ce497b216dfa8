//! Area of a polygon.

use super::shape::Polygon;
use super::signed_area::signed_area;

impl Polygon {
    /// Square metres, without the holes.
    pub fn area(&self) -> f64 {
        // Holes are clockwise, so their areas are negative.
        self.rings().map(signed_area).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::courtyard_house;

    #[test]
    fn holes_do_not_count() {
        assert_eq!(courtyard_house().area(), 56.0);
    }
}
