//! How a lens bends straight lines.

use serde::{Deserialize, Serialize};

/// Steps of the iteration that takes distortion away. Each makes the error several times smaller.
const STEPS: usize = 30;
/// Step along the radius at which a lens is checked.
const CHECK_STEP: f64 = 0.01;
/// Largest radius before distortion that is checked: 72 degrees off the optical axis.
const CHECKED_RADIUS: f64 = 3.0;
/// Least growth of the radius behind the lens. Where it falls, two directions share a pixel.
const LEAST_GROWTH: f64 = 0.05;

/// A point of the image plane at distance 1 from the camera: x to the right, y down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanePoint {
    /// To the right, in distances from the camera.
    pub x: f64,
    /// Down, in distances from the camera.
    pub y: f64,
}

/// Distortion after Brown (1966) and Conrady (1919), as in `plumb_bob` of ROS and OpenCV, without
/// the third radial term.
///
/// ```
/// use openbench_core::{Distortion, PlanePoint};
///
/// let barrel = Distortion { k1: -0.1, ..Distortion::default() };
/// let seen = barrel.distort(PlanePoint { x: 0.5, y: 0.0 }).unwrap();
/// assert_eq!(seen.x, 0.5 * (1.0 - 0.1 * 0.25));
/// assert!((barrel.undistort(seen).x - 0.5).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Distortion {
    /// Radial, with the square of the radius.
    pub k1: f64,
    /// Radial, with its fourth power.
    pub k2: f64,
    /// Tangential, upright.
    pub p1: f64,
    /// Tangential, across.
    pub p2: f64,
}

impl Distortion {
    /// Whether straight lines stay straight.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Where a point appears; `None` where the lens folds, far outside of the image.
    pub fn distort(&self, straight: PlanePoint) -> Option<PlanePoint> {
        let square = straight.x * straight.x + straight.y * straight.y;
        // False for NaN as well.
        (self.growth(square) > LEAST_GROWTH).then(|| {
            let shift = self.tangential(straight, square);
            let radial = self.radial(square);
            PlanePoint {
                x: straight.x * radial + shift.x,
                y: straight.y * radial + shift.y,
            }
        })
    }

    /// The point that appears at `seen`, by fixed-point iteration.
    pub fn undistort(&self, seen: PlanePoint) -> PlanePoint {
        let mut straight = seen;
        if self.is_none() {
            return straight;
        }
        for _ in 0..STEPS {
            let square = straight.x * straight.x + straight.y * straight.y;
            let shift = self.tangential(straight, square);
            let radial = self.radial(square);
            straight = PlanePoint {
                x: (seen.x - shift.x) / radial,
                y: (seen.y - shift.y) / radial,
            };
        }
        straight
    }

    /// Whether each point of the image up to `radius` shows one direction only.
    pub fn reaches(&self, radius: f64) -> bool {
        let mut straight = 0.0;
        while straight < CHECKED_RADIUS {
            let square = straight * straight;
            if self.growth(square) <= LEAST_GROWTH {
                return false;
            }
            if straight * self.radial(square) >= radius {
                return true;
            }
            straight += CHECK_STEP;
        }
        false
    }

    fn radial(&self, square: f64) -> f64 {
        1.0 + square * (self.k1 + square * self.k2)
    }

    /// Growth of the radius behind the lens with that before it.
    fn growth(&self, square: f64) -> f64 {
        1.0 + square * (3.0 * self.k1 + 5.0 * square * self.k2)
    }

    fn tangential(&self, at: PlanePoint, square: f64) -> PlanePoint {
        let Self { p1, p2, .. } = *self;
        let PlanePoint { x, y } = at;
        PlanePoint {
            x: 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
            y: p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RobotDescription;

    const CHEAP: Distortion = Distortion {
        k1: -0.15,
        k2: 0.02,
        p1: 0.001,
        p2: -0.0005,
    };

    #[test]
    fn pixels_and_directions_agree_through_a_lens() {
        let mut camera = RobotDescription::sentry().camera_intrinsics;
        let straight = camera.ray(10.0, 20.0);
        camera.distortion = CHEAP;
        for (u, v) in [(320.0, 240.0), (10.0, 20.0), (630.0, 470.0), (5.0, 300.0)] {
            let ray = camera.ray(u, v);
            let (u_again, v_again) = camera.project(ray.map(|c| 3.0 * c)).unwrap();
            assert!(
                (u - u_again).abs() < 1e-3 && (v - v_again).abs() < 1e-3,
                "{u} {v}"
            );
        }
        // Barrel distortion: the corner shows what is farther out.
        assert!(camera.ray(10.0, 20.0)[1] > straight[1]);
    }

    #[test]
    fn a_lens_that_folds_shows_nothing_from_beyond_the_fold() {
        let folding = Distortion {
            k1: -0.3,
            ..Distortion::default()
        };
        assert!(folding.distort(PlanePoint { x: 2.0, y: 0.0 }).is_none());
        assert!(
            folding
                .distort(PlanePoint {
                    x: f64::NAN,
                    y: 0.0
                })
                .is_none()
        );
        assert!(!folding.reaches(1.05) && CHEAP.reaches(1.05));
        assert!(Distortion::default().reaches(1.05));
    }

    #[test]
    fn a_camera_without_distortion_is_written_without_it() {
        let camera = RobotDescription::sentry().camera_intrinsics;
        let json = serde_json::to_string(&camera).unwrap();
        assert!(!json.contains("distortion"), "{json}");
    }
}
