//! Solid ground beyond the drawn ground, so that nothing falls off.

/// Width of the ground beyond, metres: hours for a robot.
const FAR_M: f64 = 10_000.0;
/// Overlap with the drawn ground, metres, so that no ray passes between the two.
const OVERLAP_M: f64 = 1.0;

/// A rectangle along the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rectangle {
    /// South-western corner, metres.
    pub(crate) low: [f64; 2],
    /// North-eastern corner, metres.
    pub(crate) high: [f64; 2],
}

/// Four rectangles around a rectangle.
pub(crate) fn beyond(drawn: Rectangle) -> [Rectangle; 4] {
    let Rectangle {
        low: [west, south],
        high: [east, north],
    } = drawn;
    let (far_west, far_east) = (west - FAR_M, east + FAR_M);
    [
        Rectangle {
            // South and north span the corners too; west and east lie between them.
            low: [far_west, south - FAR_M],
            high: [far_east, south + OVERLAP_M],
        },
        Rectangle {
            low: [far_west, north - OVERLAP_M],
            high: [far_east, north + FAR_M],
        },
        Rectangle {
            low: [far_west, south],
            high: [west + OVERLAP_M, north],
        },
        Rectangle {
            low: [east - OVERLAP_M, south],
            high: [far_east, north],
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_outside_lies_on_one_of_the_rectangles() {
        let drawn = Rectangle {
            low: [-3.0, 10.0],
            high: [5.0, 30.0],
        };
        let holds =
            |r: &Rectangle, p: [f64; 2]| (0..2).all(|i| r.low[i] <= p[i] && p[i] <= r.high[i]);
        for x in [-9_000.0, -3.1, -3.0, 1.0, 5.0, 5.1, 9_000.0] {
            for y in [-9_000.0, 9.9, 10.0, 20.0, 30.0, 30.1, 9_000.0] {
                let on_one =
                    holds(&drawn, [x, y]) || beyond(drawn).iter().any(|r| holds(r, [x, y]));
                assert!(on_one, "{x}, {y}");
            }
        }
        assert!(
            !beyond(drawn).iter().any(|r| holds(r, [1.0, 20.0])),
            "the drawn ground stays alone"
        );
    }
}
