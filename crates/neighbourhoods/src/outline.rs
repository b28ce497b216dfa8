//! Shapes of buildings, in the frame of their lot: x along the street, y away from it.

use openbench_core::{MapPoint, Pose2};

/// The shape of a building.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    Rectangle,
    /// A main house along the street, and a wing behind one end of it.
    Ell {
        /// Share of the depth that the main house takes.
        main: f64,
        /// Share of the width that the wing takes.
        wing: f64,
        right: bool,
    },
    /// A part of the front stands back.
    Notched {
        /// Share of the width at which the recess begins.
        from: f64,
        /// Metres.
        depth: f64,
        right: bool,
    },
    /// Two wings around an open court behind the house.
    Horseshoe {
        /// Metres.
        wing: f64,
        /// Depth of the main house, metres.
        main: f64,
    },
    /// Around a closed court.
    Ring {
        /// Depth of the house on all sides of the court, metres.
        depth: f64,
    },
}

/// Where a building stands on its lot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Footprint {
    /// Metres along the street.
    pub width: f64,
    /// Metres away from the street.
    pub depth: f64,
    /// Metres from the edge of the pavement.
    pub setback: f64,
    /// Middle of the building from the middle of the lot, metres along the street.
    pub aside: f64,
}

impl Footprint {
    /// The same place with all walls moved inwards by so many metres.
    pub fn shrunk(self, by: f64) -> Self {
        Self {
            width: self.width - 2.0 * by,
            depth: self.depth - 2.0 * by,
            setback: self.setback + by,
            ..self
        }
    }

    /// The outer ring of a shape on the ground, counter-clockwise.
    pub fn outer(self, shape: Shape, pose: Pose2) -> Vec<MapPoint> {
        let (half, d) = (self.width / 2.0, self.depth);
        let corners = match shape {
            Shape::Rectangle | Shape::Ring { .. } => {
                vec![[-half, 0.0], [half, 0.0], [half, d], [-half, d]]
            }
            Shape::Ell { main, wing, right } => {
                let (inner, back) = (half - wing * self.width, main * d);
                let ring = vec![
                    [-half, 0.0],
                    [half, 0.0],
                    [half, d],
                    [inner, d],
                    [inner, back],
                    [-half, back],
                ];
                mirrored(ring, !right)
            }
            Shape::Notched { from, depth, right } => {
                let inner = -half + from * self.width;
                let ring = vec![
                    [-half, 0.0],
                    [inner, 0.0],
                    [inner, depth],
                    [half, depth],
                    [half, d],
                    [-half, d],
                ];
                mirrored(ring, !right)
            }
            Shape::Horseshoe { wing, main } => vec![
                [-half, 0.0],
                [half, 0.0],
                [half, d],
                [half - wing, d],
                [half - wing, main],
                [-half + wing, main],
                [-half + wing, d],
                [-half, d],
            ],
        };
        self.on_ground(&corners, pose)
    }

    /// The court of a ring on the ground.
    pub fn court(self, shape: Shape, pose: Pose2) -> Option<Vec<MapPoint>> {
        let Shape::Ring { depth: t } = shape else {
            return None;
        };
        let (half, d) = (self.width / 2.0, self.depth);
        let corners = [
            [-half + t, t],
            [half - t, t],
            [half - t, d - t],
            [-half + t, d - t],
        ];
        Some(self.on_ground(&corners, pose))
    }

    fn on_ground(self, corners: &[[f64; 2]], pose: Pose2) -> Vec<MapPoint> {
        corners
            .iter()
            .map(|[x, y]| pose.transform(x + self.aside, y + self.setback))
            .collect()
    }
}

/// The ring with left and right exchanged, still counter-clockwise.
fn mirrored(ring: Vec<[f64; 2]>, mirror: bool) -> Vec<[f64; 2]> {
    if mirror {
        ring.into_iter().rev().map(|[x, y]| [-x, y]).collect()
    } else {
        ring
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_geometry::signed_area;

    #[test]
    fn every_shape_runs_counter_clockwise_and_fills_no_more_than_its_rectangle() {
        let place = Footprint {
            width: 30.0,
            depth: 24.0,
            setback: 3.0,
            aside: -1.0,
        };
        let shapes = [
            Shape::Rectangle,
            Shape::Ell {
                main: 0.5,
                wing: 0.4,
                right: true,
            },
            Shape::Ell {
                main: 0.5,
                wing: 0.4,
                right: false,
            },
            Shape::Notched {
                from: 0.6,
                depth: 1.5,
                right: false,
            },
            Shape::Horseshoe {
                wing: 9.0,
                main: 10.0,
            },
            Shape::Ring { depth: 8.0 },
        ];
        for shape in shapes {
            let area = signed_area(&place.outer(shape, Pose2::new(5.0, 1.0, 0.7)));
            assert!(area > 300.0 && area <= 720.0 + 1e-6, "{shape:?}: {area}");
        }
        let court = place.court(Shape::Ring { depth: 8.0 }, Pose2::default());
        assert!((signed_area(&court.unwrap()) - 14.0 * 8.0).abs() < 1e-9);
    }
}
