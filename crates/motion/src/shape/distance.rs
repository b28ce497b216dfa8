//! How far two convex outlines are apart, by separating axes and nearest features.

use crate::vector::Vector2;

/// An edge shorter than this has no direction, metres.
const SHORTEST_EDGE: f64 = 1e-12;

/// An edge of an outline.
#[derive(Clone, Copy)]
pub(super) struct Edge {
    pub(super) from: Vector2,
    pub(super) to: Vector2,
}

impl Edge {
    /// From its beginning to its end.
    #[inline]
    pub(super) fn along(self) -> Vector2 {
        self.to - self.from
    }

    /// The point of the edge that is nearest to `point`.
    pub(super) fn nearest_to(self, point: Vector2) -> Vector2 {
        let along = self.along();
        let square = along.dot(along);
        let share = if square > 0.0 {
            ((point - self.from).dot(along) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        self.from + along * share
    }
}

/// The edges of a closed outline: both directions of a wall, none of a single corner.
pub(super) fn edges(corners: &[Vector2]) -> impl Iterator<Item = Edge> {
    let count = if corners.len() > 1 { corners.len() } else { 0 };
    (0..count).map(move |i| Edge {
        from: corners[i],
        to: corners[if i + 1 == corners.len() { 0 } else { i + 1 }],
    })
}

/// Whether an outline whose corners all turn left does so more than once around, as a five-pointed
/// star does.
pub(super) fn winds_twice(corners: &[Vector2]) -> bool {
    let turns = (0..corners.len()).map(|i| turn_after(corners, i));
    // Once around is 2 π, twice 4 π: halfway between, rounding does not matter. With fewer than
    // five corners no outline goes around twice.
    corners.len() > 4 && turns.sum::<f64>() > 3.0 * std::f64::consts::PI
}

/// By how much an outline turns at the end of the edge from corner `i`, radians.
fn turn_after(corners: &[Vector2], i: usize) -> f64 {
    let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % corners.len()]);
    let (along, next) = (b - a, c - b);
    libm::atan2(along.cross(next).abs(), along.dot(next))
}

/// Nearest or deepest points of a footprint and another outline.
pub(super) struct Touch {
    /// Metres; negative where they overlap.
    pub(super) distance: f64,
    /// Unit vector from the footprint to the other.
    pub(super) normal: Vector2,
    /// The point of the footprint.
    pub(super) on_foot: Vector2,
}

/// Distance and contact of two convex outlines.
pub(super) fn between(foot: &[Vector2], other: &[Vector2]) -> Touch {
    let mut best = Touch {
        distance: f64::NEG_INFINITY,
        normal: Vector2::new(1.0, 0.0),
        on_foot: foot[0],
    };
    // Whether the nearest corner faces the inside of the best edge, so that the edge's normal is
    // the direction of the shortest distance.
    let mut settled = false;
    // The largest gap along any edge's outer normal (separating axes). Every edge of a footprint
    // has a length, see `Footprint::new`.
    for edge in edges(foot) {
        let along = edge.along();
        let length = along.norm();
        let normal = Vector2::new(along.y / length, -along.x / length);
        let low = lowest(other, edge.from, normal);
        if low.height > best.distance {
            settled = is_beside(low.corner - edge.from, along, length);
            let on_foot = low.corner - normal * low.height;
            best = Touch {
                distance: low.height,
                normal,
                on_foot,
            };
        }
    }
    for edge in edges(other) {
        let along = edge.along();
        let length = along.norm();
        if length < SHORTEST_EDGE {
            continue;
        }
        let normal = Vector2::new(along.y / length, -along.x / length);
        let low = lowest(foot, edge.from, normal);
        if low.height > best.distance {
            settled = is_beside(low.corner - edge.from, along, length);
            best = Touch {
                distance: low.height,
                normal: -normal,
                on_foot: low.corner,
            };
        }
    }
    // Otherwise two corners face each other, and are further apart than any normal shows.
    if best.distance <= 0.0 || settled {
        best
    } else {
        nearest_features(foot, other)
    }
}

/// Whether the foot of a perpendicular lies on an edge of `length`.
#[inline]
fn is_beside(offset: Vector2, along: Vector2, length: f64) -> bool {
    (0.0..=1.0).contains(&(offset.dot(along) / (length * length)))
}

/// The lowest corner of a shape above a line.
struct Lowest {
    corner: Vector2,
    height: f64,
}

/// The corner that lies least far along `normal` from `base`, and how far.
#[inline]
fn lowest(shape: &[Vector2], base: Vector2, normal: Vector2) -> Lowest {
    let mut low = Lowest {
        corner: shape[0],
        height: (shape[0] - base).dot(normal),
    };
    for &corner in &shape[1..] {
        let height = (corner - base).dot(normal);
        if height < low.height {
            low = Lowest { corner, height };
        }
    }
    low
}

/// A point of each of two shapes.
struct Pair {
    square: f64,
    on_foot: Vector2,
    on_other: Vector2,
}

impl Pair {
    /// Replaces the pair by a nearer one.
    fn offer(&mut self, on_foot: Vector2, on_other: Vector2) {
        let gap = on_other - on_foot;
        let square = gap.dot(gap);
        if square < self.square {
            *self = Self {
                square,
                on_foot,
                on_other,
            };
        }
    }
}

/// For shapes that are apart: the nearest pair of points, each a corner or a point on an edge.
fn nearest_features(foot: &[Vector2], other: &[Vector2]) -> Touch {
    let mut best = Pair {
        square: f64::INFINITY,
        on_foot: foot[0],
        on_other: other[0],
    };
    // Where convex outlines are apart, a corner of one of them is among the nearest points.
    for edge in edges(foot) {
        other
            .iter()
            .for_each(|&corner| best.offer(edge.nearest_to(corner), corner));
    }
    for edge in edges(other) {
        foot.iter()
            .for_each(|&corner| best.offer(corner, edge.nearest_to(corner)));
    }
    let distance = best.square.sqrt();
    let gap = best.on_other - best.on_foot;
    let least = distance.max(1e-12);
    let normal = Vector2::new(gap.x / least, gap.y / least);
    Touch {
        distance,
        normal,
        on_foot: best.on_foot,
    }
}
