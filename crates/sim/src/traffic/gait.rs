//! The walking cycle of gait analysis (J. Perry, *Gait Analysis: Normal and Pathological Function*,
//! 1992): heel strike, flat foot, heel off, toe off, swing, with rounded angles.

use nalgebra::Vector3;

/// Number of phases of the walking cycle that are drawn.
pub(super) const PHASES: usize = 8;
/// Swing of the arms, radians.
const ARM_SWING_RAD: f64 = 0.36;
/// Lengths of thigh and shin, metres.
const THIGH_M: f64 = 0.43;
const SHIN_M: f64 = 0.43;
/// Height of the ankle above the sole, metres.
pub(super) const ANKLE_M: f64 = 0.075;
/// From the ankle back to the heel and forward to the toe, metres.
pub(super) const HEEL_M: f64 = 0.07;
pub(super) const TOE_M: f64 = 0.18;

/// Angles of a leg, degrees.
struct Angles {
    /// Swing of the thigh forward.
    swing: f64,
    /// Bend of the knee.
    bend: f64,
    /// Pitch of the foot, toe up.
    pitch: f64,
}

const fn angles(swing: f64, bend: f64, pitch: f64) -> Angles {
    Angles { swing, bend, pitch }
}

/// A leg in each phase, from its heel strike on.
const GAIT: [Angles; PHASES] = [
    // Heel strike, flat foot three times, heel off, toe off, swing twice.
    angles(24.0, 5.0, 14.0),
    angles(20.0, 18.0, 0.0),
    angles(5.0, 12.0, 0.0),
    angles(-10.0, 6.0, 0.0),
    angles(-20.0, 12.0, -16.0),
    angles(-9.0, 42.0, -48.0),
    angles(14.0, 62.0, -32.0),
    angles(25.0, 32.0, -2.0),
];

/// The phase to draw for a share of the walking cycle, 0 to 1.
pub(super) fn phase_of(gait: f64) -> usize {
    (gait.rem_euclid(1.0) * PHASES as f64) as usize % PHASES
}

/// The phase of the other leg.
pub(super) fn opposite(phase: usize) -> usize {
    (phase + PHASES / 2) % PHASES
}

/// Swing of the right arm forward in a phase, radians; the left arm swings the other way.
pub(super) fn arm_swing(phase: usize) -> f64 {
    ARM_SWING_RAD * libm::cos(std::f64::consts::TAU * phase as f64 / PHASES as f64)
}

/// A direction downwards, swung forward by an angle in radians.
pub(super) fn swung(angle: f64) -> Vector3<f64> {
    Vector3::new(libm::sin(angle), 0.0, -libm::cos(angle))
}

/// A leg in a phase of the walking cycle. Angles in radians.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leg {
    swing: f64,
    bend: f64,
    pitch: f64,
}

impl Leg {
    pub(super) fn in_phase(phase: usize) -> Self {
        let Angles { swing, bend, pitch } = GAIT[phase];
        Self {
            swing: swing.to_radians(),
            bend: bend.to_radians(),
            pitch: pitch.to_radians(),
        }
    }

    /// From hip to knee.
    pub(super) fn thigh(self) -> Vector3<f64> {
        swung(self.swing) * THIGH_M
    }

    /// From knee to ankle.
    pub(super) fn shin(self) -> Vector3<f64> {
        swung(self.swing - self.bend) * SHIN_M
    }

    /// From the ankle to the underside of heel and toe.
    pub(super) fn sole(self) -> [Vector3<f64>; 2] {
        [self.upon_sole(-HEEL_M, 0.0), self.upon_sole(TOE_M, 0.0)]
    }

    /// From the ankle to the point of the shoe `forward` metres in front of the ankle and `up`
    /// metres above the sole.
    pub(super) fn upon_sole(self, forward: f64, up: f64) -> Vector3<f64> {
        let (sin, cos) = libm::sincos(self.pitch);
        let up = up - ANKLE_M;
        Vector3::new(forward * cos - up * sin, 0.0, forward * sin + up * cos)
    }

    /// Distance of the lower of heel and toe below the hip, metres.
    pub(super) fn reach(self) -> f64 {
        let [heel, toe] = self.sole();
        -(self.thigh().z + self.shin().z + heel.z.min(toe.z))
    }
}

#[cfg(test)]
mod tests {
    use super::super::pedestrians::STRIDE_M;
    use super::*;

    /// From the ground under the hip to a leg's ankle.
    fn ankle(phase: usize) -> Vector3<f64> {
        let (leg, other) = (Leg::in_phase(phase), Leg::in_phase(opposite(phase)));
        leg.thigh() + leg.shin() + Vector3::z() * leg.reach().max(other.reach())
    }

    #[test]
    fn feet_stand_while_the_body_passes_over_them() {
        // From flat foot to heel off, the ankle moves back as fast as the body moves on, and stays
        // at one height.
        let stand = [1, 2, 3].map(ankle);
        assert!(
            stand.iter().all(|a| (a.z - ANKLE_M).abs() < 0.03),
            "{stand:?}"
        );
        let slip = stand[0].x - stand[2].x - STRIDE_M / 4.0;
        assert!(slip.abs() < 0.03, "{slip}");
        // The swinging foot passes clear of the ground, but not as high as in a march.
        let swing = ankle(6).z - ANKLE_M;
        assert!((0.02..0.25).contains(&swing), "{swing}");
    }

    #[test]
    fn phases_repeat() {
        let phases = (
            phase_of(0.0),
            phase_of(0.999),
            phase_of(-0.1),
            phase_of(f64::NAN),
        );
        assert_eq!(phases, (0, 7, 7, 0));
    }
}
