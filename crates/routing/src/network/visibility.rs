//! Which corners of a pedestrian area see each other. All tests are made with whole numbers.

use std::ops::Range;

use crate::geo::Place;

/// A corner of an outline or a hole.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    /// Index of its node.
    pub(super) node: usize,
    pub(super) place: Place,
    /// The corners before and behind it on its ring.
    pub(super) before: usize,
    pub(super) behind: usize,
    /// Whether the angle inside is above 180 degrees: a shortest path can turn only there.
    pub(super) reflex: bool,
}

/// Whether the straight line between two corners stays inside.
pub(super) fn sees(corners: &[Corner], a: usize, b: usize) -> bool {
    let [p, q] = [a, b].map(|corner| corners[corner].place);
    for (i, corner) in corners.iter().enumerate() {
        let (c, d) = (corner.place, corners[corner.behind].place);
        let [s, t] = [side(p, q, c), side(p, q, d)];
        let [u, v] = [side(c, d, p), side(c, d, q)];
        // A proper crossing: the ends of each line are on different sides of the other.
        if s * t < 0 && u * v < 0 {
            return false;
        }
        // A corner on the line cuts it in two if the outline crosses the line there.
        let is_between = s == 0 && i != a && i != b && strictly_between(p, q, c);
        if is_between && side(p, q, corners[corner.before].place) * t <= 0 {
            return false;
        }
    }
    // No side crosses the line, so all of it is on one side of the outline: any of its points can
    // decide, for example the middle.
    contains_middle(corners, p, q)
}

/// Whether the middle between two places is inside: a ray from it to the east meets an odd number
/// of sides.
fn contains_middle(corners: &[Corner], p: Place, q: Place) -> bool {
    // Everything is doubled, so that the middle is a whole number too.
    let x = i128::from(p.lon) + i128::from(q.lon);
    let y = i128::from(p.lat) + i128::from(q.lat);
    let mut inside = false;
    for corner in corners {
        let [a, b] = [corner.place, corners[corner.behind].place]
            .map(|place| [2 * i128::from(place.lon), 2 * i128::from(place.lat)]);
        // Half-open, so that a ray through a corner meets exactly one of its two sides if the
        // outline crosses the ray there, and none or both if it only touches.
        if (a[1] > y) != (b[1] > y) {
            // To the left of the side, without division.
            let cross = (b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1]);
            if (cross > 0) == (b[1] > a[1]) && cross != 0 {
                inside = !inside;
            }
        }
    }
    inside
}

/// Marks the reflex corners of rings that follow one another, given by their sizes. The largest
/// ring is the outline, the others are holes.
pub(super) fn mark_reflex(corners: &mut [Corner], rings: impl Iterator<Item = usize>) {
    let mut first = 0;
    let mut measured: Vec<(Range<usize>, f64)> = Vec::new();
    for count in rings {
        let ring = first..first + count;
        first += count;
        let area = twice_the_area(corners, ring.clone());
        measured.push((ring, area));
    }
    let largest = measured
        .iter()
        .map(|(_, area)| area.abs())
        .fold(0.0, f64::max);
    for (ring, area) in measured {
        // The inside is to the left of a counter-clockwise outline, and of a clockwise hole.
        let left_is_inside = (area > 0.0) == (area.abs() == largest);
        for i in ring {
            let Corner {
                place,
                before,
                behind,
                ..
            } = corners[i];
            let turn = side(corners[before].place, place, corners[behind].place);
            corners[i].reflex = if left_is_inside { turn < 0 } else { turn > 0 };
        }
    }
}

/// Twice the signed area of a ring about its first corner, in squared units of a [`Place`].
fn twice_the_area(corners: &[Corner], ring: Range<usize>) -> f64 {
    let origin = corners[ring.start].place;
    let relative = |place: Place| {
        let x = f64::from(place.lon) - f64::from(origin.lon);
        let y = f64::from(place.lat) - f64::from(origin.lat);
        [x, y]
    };
    let crosses = ring.map(|i| {
        let [ax, ay] = relative(corners[i].place);
        let [bx, by] = relative(corners[corners[i].behind].place);
        ax * by - bx * ay
    });
    crosses.sum()
}

/// On which side of the line from `a` to `b` a place is: 1 left, -1 right, 0 on it.
#[inline]
fn side(a: Place, b: Place, place: Place) -> i64 {
    // A product of two differences may reach 6.5e18, and the difference of two products twice that:
    // too much for `i64`.
    let [ax, ay, bx, by, x, y] = [a.lon, a.lat, b.lon, b.lat, place.lon, place.lat].map(i128::from);
    ((bx - ax) * (y - ay) - (x - ax) * (by - ay)).signum() as i64
}

/// Whether a place on the line through two others is between them.
fn strictly_between(a: Place, b: Place, place: Place) -> bool {
    let [ax, ay, bx, by, x, y] = [a.lon, a.lat, b.lon, b.lat, place.lon, place.lat].map(i128::from);
    (x - ax) * (x - bx) + (y - ay) * (y - by) < 0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An L of two squares: its corner 3 is reflex.
    fn letter_l() -> Vec<Corner> {
        let places = [[0, 0], [20, 0], [20, 10], [10, 10], [10, 20], [0, 20]];
        let corner = |(i, [lon, lat]): (usize, [i32; 2])| Corner {
            node: i,
            place: Place { lon, lat },
            before: (i + 5) % 6,
            behind: (i + 1) % 6,
            reflex: false,
        };
        let mut corners: Vec<Corner> = places.into_iter().enumerate().map(corner).collect();
        mark_reflex(&mut corners, std::iter::once(6));
        corners
    }

    #[test]
    fn only_inner_angles_above_180_degrees_are_reflex() {
        let reflex: Vec<bool> = letter_l().iter().map(|corner| corner.reflex).collect();
        assert_eq!(reflex, [false, false, false, true, false, false]);
    }

    #[test]
    fn walls_block_the_view() {
        let corners = letter_l();
        assert!(sees(&corners, 0, 3) && sees(&corners, 1, 3));
        assert!(!sees(&corners, 2, 4), "the line leaves the L");
    }
}
