//! Success of a delivery, by the paper's and by the strict criterion.

use openbench_core::MapPoint;

/// Maximum distance from the plate for success by the paper's criterion.
pub const PAPER_RADIUS_M: f64 = 10.0;
/// Maximum distance from the approach point for success by the strict criterion.
pub const STRICT_RADIUS_M: f64 = 2.0;

/// Success by the paper's criterion: declared within 10 m of the plate in a straight line, even
/// through walls. `declared` is the position of the declaration, in the `map` frame like `plate`.
pub fn paper_success(declared: Option<MapPoint>, plate: MapPoint) -> bool {
    declared.is_some_and(|at| at.distance(plate) <= PAPER_RADIUS_M)
}

/// The strict criterion of one delivery.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Strict {
    /// Declared within 2 m of the correct door's approach point, and `correct_unit`.
    pub success: bool,
    /// No other door's approach point is nearer, by geodesic distance.
    pub correct_unit: bool,
}

impl Strict {
    /// Judges a declaration by geodesic distances from its position, metres, infinite if there is
    /// no path: `right_door` to the approach point of the correct door, `other_doors` to those of
    /// the other doors.
    pub fn judge(right_door: f64, other_doors: &[f64]) -> Self {
        let correct_unit =
            right_door.is_finite() && other_doors.iter().all(|&other| other >= right_door);
        Self {
            success: correct_unit && right_door <= STRICT_RADIUS_M,
            correct_unit,
        }
    }

    /// A delivery that was never declared.
    pub const NOT_DECLARED: Self = Self {
        success: false,
        correct_unit: false,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_radius_is_ten_metres() {
        let plate = MapPoint::new(3.0, 0.0);
        assert!(paper_success(Some(MapPoint::new(13.0, 0.0)), plate));
        assert!(!paper_success(Some(MapPoint::new(13.001, 0.0)), plate));
        assert!(!paper_success(None, plate));
    }

    #[test]
    fn no_other_door_may_be_nearer() {
        assert_eq!(
            Strict::judge(1.5, &[1.6, 9.0]),
            Strict {
                success: true,
                correct_unit: true
            }
        );
        assert_eq!(
            Strict::judge(1.5, &[1.4]),
            Strict {
                success: false,
                correct_unit: false
            }
        );
        assert_eq!(
            Strict::judge(2.5, &[9.0]),
            Strict {
                success: false,
                correct_unit: true
            }
        );
        assert_eq!(Strict::judge(f64::INFINITY, &[]), Strict::NOT_DECLARED);
    }
}
