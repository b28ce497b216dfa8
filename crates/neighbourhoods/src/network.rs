//! Street networks: irregular, connected, different for each style.

use openbench_core::MapPoint;
use openbench_osm::draws::{between, chance};
use rand_pcg::Pcg64Mcg;

use crate::plan::{Class, Half, Street};
use crate::style::Style;

/// How far streets go on beyond the ground, metres.
const BEYOND_M: f64 = 14.0;
/// Length of the pieces of a curve, metres.
const PIECE_M: f64 = 7.0;
/// Distance between the parallel streets of terraces, metres.
const BETWEEN_TERRACES_M: f64 = 50.0;
/// Smallest half side of a ground that has more than one street, metres.
const SEVERAL_STREETS_M: f64 = 42.0;

/// Draws the streets of a neighbourhood; each after the first touches an earlier one.
pub(crate) fn draw(style: Style, half: Half, draws: &mut Pcg64Mcg) -> Vec<Street> {
    let lines = match style {
        Style::Suburb => suburb(half, draws),
        Style::Blocks => blocks(half, draws),
        Style::Terraces => terraces(half, draws),
        Style::Slabs => slabs(half, draws),
        Style::Village => village(half, draws),
    };
    let shared = match style {
        Style::Suburb | Style::Village => chance(draws, 0.35),
        // As in old towns.
        Style::Blocks => chance(draws, 0.5),
        Style::Terraces | Style::Slabs => false,
    };
    lines
        .into_iter()
        .enumerate()
        .map(|(i, line)| {
            let class = match style {
                Style::Slabs if i > 0 => Class::Service,
                _ if shared && i > 0 => Class::Living,
                _ => Class::Residential,
            };
            let width = match class {
                Class::Residential => between(draws, 5.0, 6.5),
                Class::Living => between(draws, 4.6, 5.6),
                Class::Service => between(draws, 3.6, 4.6),
            };
            Street {
                class,
                line,
                // Maps give widths to a decimetre.
                width: libm::round(width * 10.0) / 10.0,
                joints: Vec::new(),
            }
        })
        .collect()
}

type Line = Vec<MapPoint>;

/// A main street with a loop, and closes.
fn suburb(half: Half, draws: &mut Pcg64Mcg) -> Vec<Line> {
    let Half { x: a, y: b } = half;
    let many = a > SEVERAL_STREETS_M;
    let base = if many {
        between(draws, -0.25, 0.05) * b
    } else {
        between(draws, -0.15, 0.15) * b
    };
    let bend = |draws: &mut Pcg64Mcg| base + between(draws, -0.13, 0.13) * b;
    let west = MapPoint::new(-a - BEYOND_M, bend(draws));
    let east = MapPoint::new(a + BEYOND_M, bend(draws));
    let first = MapPoint::new(between(draws, -0.55, -0.35) * a, bend(draws));
    let middle = MapPoint::new(between(draws, -0.1, 0.15) * a, bend(draws));
    let second = MapPoint::new(between(draws, 0.4, 0.6) * a, bend(draws));
    let mut lines = vec![curve(&[west, first, middle, second, east])];
    let close = |from: MapPoint, up: f64, draws: &mut Pcg64Mcg| {
        let reach = between(draws, 0.55, 0.8) * b * up;
        let lean = between(draws, -0.15, 0.15) * a;
        let knee = MapPoint::new(from.x + lean * 0.2, from.y + 0.5 * (reach - from.y));
        curve(&[from, knee, MapPoint::new(from.x + lean, reach)])
    };
    if !many {
        if chance(draws, 0.5) {
            let up = if chance(draws, 0.5) { 1.0 } else { -1.0 };
            lines.push(close(middle, up, draws));
        }
        return lines;
    }
    if chance(draws, 0.65) {
        let top = between(draws, 0.5, 0.62) * b;
        let left = MapPoint::new(first.x + between(draws, -0.06, 0.1) * a, top);
        let right = MapPoint::new(second.x + between(draws, -0.1, 0.06) * a, top);
        let crown = MapPoint::new(
            (left.x + right.x) / 2.0,
            top + between(draws, 0.0, 0.12) * b,
        );
        lines.push(curve(&[first, left, crown, right, second]));
    } else {
        lines.push(close(first, 1.0, draws));
        lines.push(close(second, 1.0, draws));
    }
    lines.push(close(middle, -1.0, draws));
    if a > 1.8 * SEVERAL_STREETS_M && chance(draws, 0.6) {
        lines.push(close(second, -1.0, draws));
    }
    lines
}

/// Streets across each other, none at a right angle, some ending where they meet another.
fn blocks(half: Half, draws: &mut Pcg64Mcg) -> Vec<Line> {
    let Half { x: a, y: b } = half;
    let columns = across(a, 36.0);
    let rows = across(b, 45.0);
    let at =
        |i: usize, n: usize, reach: f64| ((i as f64 + 1.0) / (n as f64 + 1.0) * 2.0 - 1.0) * reach;
    let jitter = |draws: &mut Pcg64Mcg| between(draws, -5.0, 5.0);
    let grid: Vec<Vec<MapPoint>> = (0..rows)
        .map(|row| {
            let slope = between(draws, -0.12, 0.12);
            (0..columns)
                .map(|column| {
                    let x = at(column, columns, a) + jitter(draws);
                    let y = at(row, rows, b) + slope * x + between(draws, -3.0, 3.0);
                    MapPoint::new(x, y)
                })
                .collect()
        })
        .collect();
    let mut lines = Vec::new();
    for row in &grid {
        let (first, last) = (row[0], row[row.len() - 1]);
        let lean = between(draws, -5.0, 5.0);
        let mut line = vec![MapPoint::new(-a - BEYOND_M, first.y + lean)];
        line.extend(row);
        line.push(MapPoint::new(a + BEYOND_M, last.y - lean));
        lines.push(line);
    }
    for column in 0..columns {
        let inner: Line = grid.iter().map(|row| row[column]).collect();
        let (first, last) = (inner[0], inner[inner.len() - 1]);
        // At least one end goes on, so that the street is more than a link.
        let (down, up) = match between(draws, 0.0, 1.0) {
            share if share < 0.25 => (true, false),
            share if share < 0.5 => (false, true),
            _ => (true, true),
        };
        let lean = between(draws, -6.0, 6.0);
        let mut line = Line::new();
        if down {
            line.push(MapPoint::new(first.x + lean, -b - BEYOND_M));
        }
        line.extend(&inner);
        if up {
            line.push(MapPoint::new(last.x - lean, b + BEYOND_M));
        }
        lines.push(line);
    }
    lines
}

/// The number of streets across a ground whose half side is `reach` metres.
fn across(reach: f64, block: f64) -> usize {
    ((reach / block) as usize).clamp(1, 3)
}

/// Parallel streets, joined at one end or both.
fn terraces(half: Half, draws: &mut Pcg64Mcg) -> Vec<Line> {
    let Half { x: a, y: b } = half;
    let count = ((2.0 * b / BETWEEN_TERRACES_M) as usize).max(1);
    let tilt = between(draws, -0.08, 0.08);
    let bow = between(draws, -3.0, 3.0);
    // Where the cross street runs.
    let joined_at = between(draws, 0.62, 0.78) * a * if chance(draws, 0.5) { 1.0 } else { -1.0 };
    let mut lines = Vec::new();
    let mut joints = Vec::new();
    for i in 0..count {
        let middle = ((i as f64 + 0.5) / count as f64 * 2.0 - 1.0) * b + between(draws, -3.0, 3.0);
        let y = |x: f64| middle + tilt * x + bow * (1.0 - (x / a) * (x / a));
        let joint = MapPoint::new(joined_at + between(draws, -2.0, 2.0), y(joined_at));
        joints.push(joint);
        // The first street is open at both ends, others end in the cross street or go on.
        let open_far = i == 0 || chance(draws, 0.5);
        let near = MapPoint::new(-joined_at.signum() * (a - 4.0), y(-joined_at.signum() * a));
        let mut line = vec![near];
        if i == 0 {
            let end = -joined_at.signum() * (a + BEYOND_M);
            line.insert(0, MapPoint::new(end, y(end)));
        }
        line.push(MapPoint::new(0.0, y(0.0)));
        line.push(joint);
        if open_far {
            let end = joined_at.signum() * (a + BEYOND_M);
            line.push(MapPoint::new(end, y(end)));
        }
        lines.push(curve(&line));
    }
    if count > 1 {
        lines.push(joints);
    }
    lines
}

/// A street along one edge, and access roads into the ground.
fn slabs(half: Half, draws: &mut Pcg64Mcg) -> Vec<Line> {
    let Half { x: a, y: b } = half;
    let base = between(draws, -0.88, -0.72) * b;
    let y = |draws: &mut Pcg64Mcg| base + between(draws, -0.06, 0.06) * b;
    let access = MapPoint::new(between(draws, -0.3, 0.3) * a, y(draws));
    let west = MapPoint::new(-a - BEYOND_M, y(draws));
    let east = MapPoint::new(a + BEYOND_M, y(draws));
    let mut lines = vec![curve(&[west, access, east])];
    let inner = MapPoint::new(
        access.x + between(draws, -4.0, 4.0),
        between(draws, 0.0, 0.25) * b,
    );
    let end = MapPoint::new(
        inner.x + between(draws, 0.3, 0.5) * a * if inner.x > 0.0 { -1.0 } else { 1.0 },
        inner.y + between(draws, -0.08, 0.12) * b,
    );
    lines.push(vec![access, inner, end]);
    lines
}

/// A winding street with a fork and a lane.
fn village(half: Half, draws: &mut Pcg64Mcg) -> Vec<Line> {
    let Half { x: a, y: b } = half;
    let y = |draws: &mut Pcg64Mcg| between(draws, -0.32, 0.32) * b;
    let west = MapPoint::new(-a - BEYOND_M, y(draws));
    let east = MapPoint::new(a + BEYOND_M, y(draws));
    let first = MapPoint::new(between(draws, -0.6, -0.3) * a, y(draws));
    let second = MapPoint::new(between(draws, 0.2, 0.5) * a, y(draws));
    let mut lines = vec![curve(&[west, first, second, east])];
    if a < SEVERAL_STREETS_M && chance(draws, 0.5) {
        return lines;
    }
    let up = if first.y + second.y < 0.0 { 1.0 } else { -1.0 };
    let fork = MapPoint::new(
        second.x + between(draws, -0.1, 0.3) * a,
        up * (b + BEYOND_M),
    );
    let knee = MapPoint::new(
        second.x + between(draws, -0.05, 0.1) * a,
        second.y + 0.5 * (fork.y - second.y),
    );
    lines.push(curve(&[second, knee, fork]));
    if a > SEVERAL_STREETS_M {
        let lane = MapPoint::new(first.x + between(draws, -0.2, 0.1) * a, -up * 0.75 * b);
        let knee = MapPoint::new(
            first.x + between(draws, -0.1, 0.1) * a,
            first.y + 0.5 * (lane.y - first.y),
        );
        lines.push(curve(&[first, knee, lane]));
    }
    lines
}

/// A smooth line through all points, after Catmull and Rom (1974).
fn curve(points: &[MapPoint]) -> Line {
    let n = points.len();
    let mut line = vec![points[0]];
    for i in 0..n - 1 {
        let (p1, p2) = (points[i], points[i + 1]);
        let p0 = if i == 0 { p1 } else { points[i - 1] };
        let p3 = points.get(i + 2).copied().unwrap_or(p2);
        let pieces = (p1.distance(p2) / PIECE_M).ceil().max(1.0) as usize;
        for k in 1..pieces {
            let t = k as f64 / pieces as f64;
            line.push(MapPoint::new(
                blend([p0.x, p1.x, p2.x, p3.x], t),
                blend([p0.y, p1.y, p2.y, p3.y], t),
            ));
        }
        // The point itself, exactly: other streets may begin there.
        line.push(p2);
    }
    line
}

fn blend(p: [f64; 4], t: f64) -> f64 {
    let a = 2.0 * p[1];
    let b = p[2] - p[0];
    let c = 2.0 * p[0] - 5.0 * p[1] + 4.0 * p[2] - p[3];
    let d = 3.0 * (p[1] - p[2]) + p[3] - p[0];
    0.5 * (a + t * (b + t * (c + t * d)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::Kind;
    use crate::purpose::{Purpose, Seed};

    #[test]
    fn every_street_touches_an_earlier_one() {
        for seed in 0..100 {
            for kind in Kind::ALL {
                for style in Style::ALL {
                    let mut draws = Seed::new(kind, seed).stream(Purpose::Network, 0);
                    let half = style.ground(kind, &mut draws);
                    let streets = draw(style, half, &mut draws);
                    for (i, street) in streets.iter().enumerate().skip(1) {
                        let earlier = streets[..i].iter().flat_map(|s| &s.line);
                        let joined = earlier.clone().any(|p| street.line.contains(p));
                        // Of blocks the rows come first, and columns join them.
                        let later = streets[i + 1..].iter().flat_map(|s| &s.line);
                        let joined = joined || later.clone().any(|p| street.line.contains(p));
                        assert!(joined, "{style:?} {kind} {seed}: street {i}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_curve_goes_through_its_points() {
        let points = [(0.0, 0.0), (20.0, 5.0), (40.0, -3.0)].map(|(x, y)| MapPoint::new(x, y));
        let line = curve(&points);
        assert!(points.iter().all(|p| line.contains(p)));
        assert!(line.len() > 5);
    }
}
