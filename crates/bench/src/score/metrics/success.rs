//! Whether a delivery succeeded.

use openbench_core::MapPoint;

/// Radius of the paper's success, metres from the plate.
pub const PAPER_RADIUS: f64 = 10.0;
/// Radius of the strict success, metres from the approach point.
pub const STRICT_RADIUS: f64 = 2.0;

/// Success in the paper's reading: the robot stood within 10 m of the plate when it declared, whatever lay between.
pub fn paper_success(declared: Option<MapPoint>, plate: MapPoint) -> bool {
    declared.is_some_and(|at| at.distance(plate) <= PAPER_RADIUS)
}

/// The strict reading of one delivery.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Strict {
    /// Within 2 m of the right door's approach point, and the right door.
    pub success: bool,
    /// No other door's approach point is nearer to drive to.
    pub correct_unit: bool,
}

impl Strict {
    /// Judges a declaration. Distances are metres of driving from where the robot declared, infinite where no way leads:
    /// `right_door` to the approach point of the right door, `other_doors` to those of all others.
    pub fn judge(right_door: f64, other_doors: &[f64]) -> Self {
        let correct_unit =
            right_door.is_finite() && other_doors.iter().all(|&other| other >= right_door);
        Self {
            success: correct_unit && right_door <= STRICT_RADIUS,
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
    fn the_paper_counts_ten_metres_through_walls() {
        let plate = MapPoint::new(3.0, 0.0);
        assert!(paper_success(Some(MapPoint::new(13.0, 0.0)), plate));
        assert!(!paper_success(Some(MapPoint::new(13.001, 0.0)), plate));
        assert!(!paper_success(None, plate));
    }

    #[test]
    fn the_neighbour_must_not_be_nearer() {
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
