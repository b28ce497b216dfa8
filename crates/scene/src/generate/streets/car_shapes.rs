//! More shapes of parked cars, where streets differ: estates, small cars, off-roaders, pick-ups,
//! box vans and lorries.

use openbench_core::MapPoint;

use super::car::{HALF_LENGTH_M, Shape, p};
use crate::generate::inputs::Inputs;
use crate::generate::scenery::streams::{Purpose, place_number, stream};
use crate::generate::seeds::{chance, pick};

/// Half the length of a lorry, metres.
const LORRY_HALF_LENGTH_M: f64 = 2.9;

static ESTATE: Shape = Shape {
    outline: &[
        p(-2.16, 0.18),
        p(2.12, 0.18),
        p(2.20, 0.52),
        p(2.12, 0.76),
        p(1.22, 0.94),
        p(0.52, 1.42),
        p(-1.70, 1.46),
        p(-2.10, 1.00),
        p(-2.20, 0.56),
    ],
    glass: &[4, 6],
    window: &[p(1.02, 0.99), p(0.48, 1.36), p(-1.62, 1.39), p(-1.86, 1.03)],
    waist: 0.94..1.46,
    axle: 1.35,
};
static SMALL: Shape = Shape {
    outline: &[
        p(-1.34, 0.18),
        p(1.34, 0.18),
        p(1.42, 0.56),
        p(1.32, 0.86),
        p(0.92, 1.02),
        p(0.40, 1.52),
        p(-0.96, 1.54),
        p(-1.34, 1.04),
        p(-1.40, 0.60),
    ],
    glass: &[4, 6],
    window: &[p(0.80, 1.06), p(0.34, 1.45), p(-0.88, 1.47), p(-1.10, 1.08)],
    waist: 1.02..1.54,
    axle: 0.92,
};
static OFF_ROADER: Shape = Shape {
    outline: &[
        p(-2.10, 0.28),
        p(2.10, 0.28),
        p(2.18, 0.62),
        p(2.12, 1.00),
        p(1.10, 1.12),
        p(0.58, 1.74),
        p(-1.86, 1.78),
        p(-2.12, 1.16),
        p(-2.18, 0.66),
    ],
    glass: &[4, 6],
    window: &[p(0.96, 1.18), p(0.52, 1.66), p(-1.78, 1.69), p(-1.94, 1.20)],
    waist: 1.12..1.95,
    axle: 1.34,
};
static PICK_UP: Shape = Shape {
    outline: &[
        p(-2.14, 0.26),
        p(2.12, 0.26),
        p(2.20, 0.60),
        p(2.12, 0.94),
        p(1.30, 1.04),
        p(0.80, 1.66),
        p(-0.40, 1.68),
        p(-0.56, 1.06),
        p(-2.14, 1.02),
        p(-2.20, 0.60),
    ],
    glass: &[4, 6],
    window: &[p(1.12, 1.10), p(0.72, 1.58), p(-0.32, 1.60), p(-0.40, 1.10)],
    waist: 1.04..1.80,
    axle: 1.38,
};
static BOX_VAN: Shape = Shape {
    outline: &[
        p(-2.18, 0.24),
        p(2.14, 0.24),
        p(2.20, 0.66),
        p(2.08, 1.06),
        p(1.58, 1.22),
        p(1.10, 1.96),
        p(0.92, 2.36),
        p(-2.18, 2.36),
    ],
    glass: &[4],
    window: &[p(1.42, 1.26), p(1.04, 1.88), p(0.52, 1.90), p(0.52, 1.26)],
    // The upper end lies far above the roof: its sides are upright.
    waist: 1.20..6.0,
    axle: 1.40,
};
static LORRY: Shape = Shape {
    outline: &[
        // Skirts: without them a LiDAR of a robot looks below it.
        p(-2.88, 0.20),
        p(2.82, 0.20),
        p(2.90, 0.80),
        p(2.86, 1.30),
        p(2.62, 2.10),
        p(2.20, 2.22),
        p(1.60, 2.26),
        p(1.58, 2.70),
        p(-2.88, 2.70),
    ],
    glass: &[3],
    window: &[p(2.56, 1.40), p(2.44, 2.00), p(1.84, 2.02), p(1.84, 1.40)],
    waist: 1.40..12.0,
    axle: 1.95,
};

/// Shapes as frequent as they are here.
static MORE: [&Shape; 8] = [
    &ESTATE,
    &ESTATE,
    &SMALL,
    &SMALL,
    &OFF_ROADER,
    &PICK_UP,
    &BOX_VAN,
    &BOX_VAN,
];
/// Share of the cars of other shapes that are lorries, where there is room.
const LORRIES: f64 = 0.12;

/// Another shape for a car.
pub(super) struct OtherShape {
    pub shape: &'static Shape,
    /// A lorry in its place, where there is room for one: half its length, metres.
    pub lorry: Option<f64>,
}

impl OtherShape {
    /// The shape of the lorry, or of the car where that does not fit.
    pub fn fitting(&self, has_room: impl Fn(f64) -> bool) -> FittedShape {
        match self.lorry.filter(|half| has_room(*half)) {
            Some(half_length) => FittedShape {
                shape: &LORRY,
                half_length,
            },
            None => FittedShape {
                shape: self.shape,
                half_length: HALF_LENGTH_M,
            },
        }
    }
}

/// A shape that there is room for.
pub(super) struct FittedShape {
    pub shape: &'static Shape,
    /// Metres.
    pub half_length: f64,
}

/// The shape of a car at `place` that has another one than usual.
pub(super) fn at_place(inputs: &Inputs, place: MapPoint) -> Option<OtherShape> {
    let scenery = &inputs.options.scenery;
    let share = scenery.amounts.shapes;
    let mut rng = stream(scenery.seed, Purpose::Car, place_number(place));
    if share <= 0.0 || !chance(&mut rng, share) {
        return None;
    }
    let shape = pick(&mut rng, &MORE);
    let is_lorry = chance(&mut rng, LORRIES);
    Some(OtherShape {
        shape,
        lorry: is_lorry.then_some(LORRY_HALF_LENGTH_M),
    })
}

#[cfg(test)]
mod tests {
    use super::super::car::SidePoint;
    use super::*;

    #[test]
    fn shapes_are_no_longer_than_their_places() {
        for shape in MORE.iter().chain([&&LORRY]) {
            let half = if std::ptr::eq(*shape, &raw const LORRY) {
                LORRY_HALF_LENGTH_M
            } else {
                HALF_LENGTH_M
            };
            for point in shape.outline {
                assert!(point.forward.abs() <= half, "{point:?}");
            }
            let lowest = |up: f64, point: &SidePoint| up.min(point.up);
            let foot = shape.outline.iter().fold(f64::INFINITY, lowest);
            assert!(foot < 0.4, "{foot}");
            assert!(shape.axle + 0.31 < half);
            assert!(shape.glass.iter().all(|i| *i < shape.outline.len()));
        }
    }
}
