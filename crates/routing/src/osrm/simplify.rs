//! Lines with as few points as the overview of a route needs.
//!
//! D. Douglas, T. Peucker, *Algorithms for the reduction of the number of points required to
//! represent a digitized line*, 1973, in Mercator's projection, at the resolution of a map of eight
//! by five tiles.

use crate::geo::Place;

/// Units of a [`Place`] around the equator.
const EQUATOR: f64 = 3.6e9;
/// A tile's side, pixels, and how many tiles are displayed.
const TILE: f64 = 256.0;
const SEEN: [f64; 2] = [8.0, 5.0];
/// The highest zoom, and the squared distance from a straight line, in units, below which points
/// are on the line at that zoom. Each zoom below quadruples it.
// A pixel at zoom 18 is 3.6e9 / (256 * 2^18) = 53.6 units, so this is (4.85 pixels)^2.
const FINEST: (i32, f64) = (18, 67_600.0);

/// The points of some lines that are kept, where each line begins at the end of the one before. The
/// first and the last point of each line are always kept.
pub(crate) fn simplified(lines: &[&[Place]]) -> Vec<Place> {
    let points: Vec<Vec<[f64; 2]>> = lines
        .iter()
        .map(|line| line.iter().map(mercator).collect())
        .collect();
    // One zoom for the whole route, so that its legs are equally fine.
    let limit = FINEST.1 * 4_f64.powi(FINEST.0 - zoom(&points.concat()));
    let mut kept: Vec<Place> = Vec::new();
    for (line, points) in lines.iter().zip(&points) {
        kept.extend(
            line.iter()
                .zip(keep(points, limit))
                .filter(|(_, keep)| *keep)
                .map(|(point, _)| *point),
        );
    }
    kept.dedup();
    kept
}

/// Which points of a line are needed for all of its points to be within a squared distance of it.
fn keep(points: &[[f64; 2]], limit: f64) -> Vec<bool> {
    let mut kept = vec![false; points.len()];
    // A stack of stretches instead of recursion, which is as deep as the line is long in the worst
    // case.
    let mut waiting = if points.is_empty() {
        Vec::new()
    } else {
        vec![(0, points.len() - 1)]
    };
    while let Some((first, last)) = waiting.pop() {
        kept[first] = true;
        kept[last] = true;
        let away = |i: usize| (away(points[i], points[first], points[last]), i);
        let furthest = (first + 1..last)
            .map(away)
            .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, middle)) = furthest.filter(|(away, _)| *away > limit) {
            waiting.push((first, middle));
            waiting.push((middle, last));
        }
    }
    kept
}

fn mercator(place: &Place) -> [f64; 2] {
    let latitude = place
        .position()
        .lat
        // Where the square of the web's Mercator maps ends. The projection of a pole is infinite.
        .clamp(-85.051_13, 85.051_13)
        .to_radians();
    let y = libm::log(libm::tan(std::f64::consts::FRAC_PI_4 + latitude / 2.0));
    [f64::from(place.lon), y * EQUATOR / std::f64::consts::TAU]
}

/// The highest zoom at which all points are displayed.
fn zoom(points: &[[f64; 2]]) -> i32 {
    let extent = |i: usize| {
        let values = points.iter().map(|p| p[i]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    // At zoom z the equator is TILE * 2^z pixels long.
    // `max(1.0)`: the extent of a single point would divide by zero.
    let fits = |i: usize| {
        libm::floor(libm::log2(
            SEEN[i] * TILE * EQUATOR / (TILE * extent(i).max(1.0)),
        ))
    };
    (fits(0).min(fits(1)) as i32).clamp(1, FINEST.0)
}

/// Squared distance of a point from a segment.
fn away(point: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let [px, py] = [point[0] - a[0], point[1] - a[1]];
    let square = dx * dx + dy * dy;
    let share = if square > 0.0 {
        ((px * dx + py * dy) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let [x, y] = [px - share * dx, py - share * dy];
    x * x + y * y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_needs_its_ends_and_a_corner_is_kept() {
        let line: Vec<Place> = (0..100)
            .map(|i| Place {
                lon: i * 10_000,
                lat: i % 2 * 20,
            })
            .collect();
        assert_eq!(simplified(&[&line]), [line[0], line[99]]);
        let corner = [
            line.clone(),
            vec![Place {
                lon: 990_000,
                lat: 900_000,
            }],
        ]
        .concat();
        assert_eq!(simplified(&[&corner]), [line[0], line[99], corner[100]]);
        assert_eq!(simplified(&[&line[..1]]), [line[0]]);
        // The point between two lines is kept.
        assert_eq!(
            simplified(&[&line[..50], &line[49..]]),
            [line[0], line[49], line[99]]
        );
    }
}
