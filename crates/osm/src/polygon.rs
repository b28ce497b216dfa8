//! An outline with holes: is a point inside, how far is the wall, which way does it face.
//!
//! Rings are taken as they are; where one crosses itself, inside is what an odd number of its windings encloses.

use openbench_core::MapPoint;

/// An area in the `map` frame. No ring repeats its first point at its end.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Polygon {
    /// The outer ring, counter-clockwise.
    pub outer: Vec<MapPoint>,
    /// The holes, each clockwise: the area lies to the left of every side.
    pub holes: Vec<Vec<MapPoint>>,
}

impl Polygon {
    /// A polygon from rings of any direction. Repeated points are dropped, and holes without area too; `None` if the outer ring
    /// encloses no area.
    pub fn new(outer: Vec<MapPoint>, holes: Vec<Vec<MapPoint>>) -> Option<Self> {
        let outer = ring(outer, true)?;
        Some(Self {
            outer,
            holes: holes
                .into_iter()
                .filter_map(|hole| ring(hole, false))
                .collect(),
        })
    }

    /// Whether `point` lies inside the outline and in no hole. On the boundary either answer may come.
    pub fn contains(&self, point: MapPoint) -> bool {
        self.sides().filter(|&(a, b)| crosses(a, b, point)).count() % 2 == 1
    }

    /// Metres from `point` to the nearest ring, whether `point` is inside or outside.
    pub fn distance_to_boundary(&self, point: MapPoint) -> f64 {
        self.nearest_boundary_point(point).0.distance(point)
    }

    /// The nearest point on any ring, and the direction that points out of the area there: radians, counter-clockwise from
    /// east, at right angles to the side.
    pub fn nearest_boundary_point(&self, point: MapPoint) -> (MapPoint, f64) {
        let mut best = (f64::INFINITY, point, 0.0);
        for (a, b) in self.sides() {
            let foot = nearest_on_segment(a, b, point).0;
            let squared =
                (foot.x - point.x) * (foot.x - point.x) + (foot.y - point.y) * (foot.y - point.y);
            if squared < best.0 {
                best = (squared, foot, libm::atan2(a.x - b.x, b.y - a.y));
            }
        }
        (best.1, best.2)
    }

    /// Square metres, holes taken off.
    pub fn area(&self) -> f64 {
        self.rings().map(signed_area).sum()
    }

    /// Metres around the outer ring.
    pub fn perimeter(&self) -> f64 {
        sides(&self.outer).map(|(a, b)| a.distance(b)).sum()
    }

    /// Centre of mass. It may lie outside of an area that is bent or has holes.
    pub fn centroid(&self) -> MapPoint {
        // Relative to a corner, so that large coordinates cost no digits.
        let Some(&origin) = self.outer.first() else {
            return MapPoint::default();
        };
        let (mut x, mut y, mut twice) = (0.0, 0.0, 0.0);
        for (a, b) in self.sides() {
            let (ax, ay, bx, by) = (
                a.x - origin.x,
                a.y - origin.y,
                b.x - origin.x,
                b.y - origin.y,
            );
            let cross = ax * by - bx * ay;
            x += (ax + bx) * cross;
            y += (ay + by) * cross;
            twice += cross;
        }
        if twice == 0.0 {
            return origin;
        }
        MapPoint::new(origin.x + x / (3.0 * twice), origin.y + y / (3.0 * twice))
    }

    /// A point inside, away from the boundary: the best of the centroid and the middles of some level cuts.
    pub fn interior_point(&self) -> MapPoint {
        let centroid = self.centroid();
        let (low, high) = self.bounds();
        let cuts =
            (1..8).filter_map(|i| self.widest_cut(low.y + (high.y - low.y) * f64::from(i) / 8.0));
        let inside = std::iter::once(centroid)
            .chain(cuts)
            .filter(|p| self.contains(*p));
        let best = inside
            .map(|p| (self.distance_to_boundary(p), p))
            .reduce(|a, b| if b.0 > a.0 { b } else { a });
        best.map_or(centroid, |(_, point)| point)
    }

    /// South-west and north-east corners of the outer ring's bounding box.
    pub fn bounds(&self) -> (MapPoint, MapPoint) {
        let start = self.outer.first().copied().unwrap_or_default();
        self.outer.iter().fold((start, start), |(low, high), p| {
            (
                MapPoint::new(low.x.min(p.x), low.y.min(p.y)),
                MapPoint::new(high.x.max(p.x), high.y.max(p.y)),
            )
        })
    }

    /// The outer ring, then the holes.
    pub fn rings(&self) -> impl Iterator<Item = &[MapPoint]> {
        std::iter::once(self.outer.as_slice()).chain(self.holes.iter().map(Vec::as_slice))
    }

    /// All sides of all rings; the area lies to the left of each.
    pub fn sides(&self) -> impl Iterator<Item = (MapPoint, MapPoint)> {
        self.rings().flat_map(sides)
    }

    /// The middle of the longest stretch inside on the level line through `y`.
    fn widest_cut(&self, y: f64) -> Option<MapPoint> {
        let cut = |(a, b): (MapPoint, MapPoint)| {
            ((a.y > y) != (b.y > y)).then(|| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x))
        };
        let mut xs: Vec<f64> = self.sides().filter_map(cut).collect();
        xs.sort_by(f64::total_cmp);
        let stretches = xs
            .chunks_exact(2)
            .map(|pair| (pair[1] - pair[0], (pair[0] + pair[1]) / 2.0));
        let widest = stretches.reduce(|a, b| if b.0 > a.0 { b } else { a })?;
        Some(MapPoint::new(widest.1, y))
    }
}

/// The point of segment `a`-`b` nearest to `point`, and how far along it is: 0 at `a`, 1 at `b`.
pub fn nearest_on_segment(a: MapPoint, b: MapPoint, point: MapPoint) -> (MapPoint, f64) {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let squared = dx * dx + dy * dy;
    let t = ((point.x - a.x) * dx + (point.y - a.y) * dy) / squared;
    let t = if squared > 0.0 {
        t.clamp(0.0, 1.0)
    } else {
        0.0
    };
    (MapPoint::new(a.x + t * dx, a.y + t * dy), t)
}

fn sides(ring: &[MapPoint]) -> impl Iterator<Item = (MapPoint, MapPoint)> + '_ {
    let next = ring.iter().cycle().skip(1);
    ring.iter().copied().zip(next.copied())
}

/// Whether a ray from `point` to the east crosses the side; each end belongs to one side only.
fn crosses(a: MapPoint, b: MapPoint, point: MapPoint) -> bool {
    (a.y > point.y) != (b.y > point.y)
        && point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y) + a.x
}

/// Positive for a counter-clockwise ring.
fn signed_area(ring: &[MapPoint]) -> f64 {
    let Some(&o) = ring.first() else { return 0.0 };
    sides(ring)
        .map(|(a, b)| (a.x - o.x) * (b.y - o.y) - (b.x - o.x) * (a.y - o.y))
        .sum::<f64>()
        / 2.0
}

/// The ring without repeated points, in the direction asked for; `None` if it encloses nothing.
fn ring(mut points: Vec<MapPoint>, counter_clockwise: bool) -> Option<Vec<MapPoint>> {
    points.dedup();
    while points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    let area = signed_area(&points);
    // A square millimetre; what is smaller is rounding. Also false for coordinates that are no numbers.
    if !(area.abs() > 1e-6 && area.is_finite()) {
        return None;
    }
    if (area > 0.0) != counter_clockwise {
        points.reverse();
    }
    Some(points)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use proptest::prelude::*;

    use super::*;

    fn p(x: f64, y: f64) -> MapPoint {
        MapPoint::new(x, y)
    }

    /// A courtyard house: 10 x 6 m with a hole of 2 x 2 m, given the wrong way round.
    fn courtyard() -> Polygon {
        let outer = vec![
            p(0.0, 0.0),
            p(0.0, 6.0),
            p(10.0, 6.0),
            p(10.0, 0.0),
            p(0.0, 0.0),
        ];
        let hole = vec![p(4.0, 2.0), p(6.0, 2.0), p(6.0, 4.0), p(4.0, 4.0)];
        Polygon::new(outer, vec![hole]).unwrap()
    }

    #[test]
    fn a_hole_is_outside_and_takes_area() {
        let house = courtyard();
        assert_eq!((house.area(), house.perimeter()), (56.0, 32.0));
        assert!(
            house.contains(p(1.0, 1.0))
                && !house.contains(p(5.0, 3.0))
                && !house.contains(p(-1.0, 3.0))
        );
        assert_eq!(house.centroid(), p(5.0, 3.0));
        assert!(house.contains(house.interior_point()));
    }

    #[test]
    fn normals_point_out_of_the_area() {
        let house = courtyard();
        assert_eq!(
            house.nearest_boundary_point(p(3.0, -2.0)),
            (p(3.0, 0.0), -FRAC_PI_2)
        );
        assert_eq!(
            house.nearest_boundary_point(p(3.0, 0.5)),
            (p(3.0, 0.0), -FRAC_PI_2)
        );
        assert_eq!(
            house.nearest_boundary_point(p(12.0, 3.0)),
            (p(10.0, 3.0), 0.0)
        );
        // From the courtyard's west wall, out of the house is east, into the courtyard.
        let (wall, normal) = house.nearest_boundary_point(p(4.1, 3.0));
        assert_eq!((wall, normal), (p(4.0, 3.0), 0.0));
        let (_, normal) = house.nearest_boundary_point(p(5.9, 3.0));
        assert!((normal.abs() - PI).abs() < 1e-12);
    }

    #[test]
    fn rings_without_area_are_no_polygons() {
        assert_eq!(Polygon::new(vec![], vec![]), None);
        assert_eq!(
            Polygon::new(vec![p(0.0, 0.0), p(1.0, 1.0), p(2.0, 2.0)], vec![]),
            None
        );
        assert_eq!(
            Polygon::new(vec![p(0.0, 0.0), p(f64::NAN, 1.0), p(2.0, 0.0)], vec![]),
            None
        );
    }

    proptest! {
        /// Stars around the origin are simple polygons; a little way in along the normal is inside, out is outside.
        #[test]
        fn the_normal_leads_out(radii in prop::collection::vec(2.0f64..9.0, 5..12), x in -12.0f64..12.0, y in -12.0f64..12.0) {
            let turn = |i: usize| i as f64 / radii.len() as f64 * std::f64::consts::TAU;
            let outer = radii.iter().enumerate().map(|(i, r)| p(0.0, 0.0).offset(turn(i), *r)).collect();
            let star = Polygon::new(outer, vec![]).unwrap();
            let (wall, normal) = star.nearest_boundary_point(p(x, y));
            let at_corner = star.outer.iter().any(|c| c.distance(wall) < 1e-2);
            prop_assume!(!at_corner);
            prop_assert!(!star.contains(wall.offset(normal, 1e-3)));
            prop_assert!(star.contains(wall.offset(normal, -1e-3)));
            prop_assert!(star.contains(star.interior_point()));
        }
    }
}
