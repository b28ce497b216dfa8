//! The forces of the social force model, as accelerations.
//!
//! After D. Helbing and P. Molnár, *Social force model for pedestrian dynamics*, Phys. Rev. E 51,
//! 1995 (arXiv cond-mat/9805244):
//!
//! - the drive towards the desired velocity, `(v0 e - v) / tau`;
//! - repulsion between people, minus the gradient of `V0 exp(-b / sigma)`, with the strengths given
//!   there; what is out of sight counts half;
//! - exponential repulsion from walls.
//!
//! The semi-minor axis `b` of the ellipse is that of A. Johansson, D. Helbing and P. Shukla,
//! *Specification of the social force pedestrian model by evolutionary adjustment to video tracking
//! data*, Adv. Complex Syst. 10, 2007 (arXiv 0810.4587), from the relative motion:
//! `2 b = sqrt((|d| + |d - y|)² - |y|²)` with `y` the other's approach in a while. (In 1995 it was
//! the other's motion alone.) Ours are: the foresight of 1 s, the softer walls, the cars, and that
//! distances are those between rims.

use openbench_core::MapPoint;

use super::ground::Clearance;
use super::hull::CarHull;
use super::mover::{PERSON_RADIUS_M, RobotState};

/// An exponential repulsion.
struct Repulsion {
    /// At distance zero, m/s².
    strength: f64,
    /// Distance over which it falls by the factor e, metres.
    range: f64,
}

/// Time in which the desired velocity is taken up, seconds (Helbing and Molnár).
pub(super) const RELAXATION_S: f64 = 0.5;
/// Between people: V0 / sigma and sigma (Helbing and Molnár: V0 = 2.1 m²/s²).
const PEOPLE: Repulsion = Repulsion {
    strength: 2.1 / 0.3,
    range: 0.3,
};
/// From obstacles, by the distance from the body's rim. Weaker than Helbing and Molnár's 10 m²/s²
/// over 0.2 m, which keeps people out of gates.
const OBSTACLES: Repulsion = Repulsion {
    strength: 4.0,
    range: 0.2,
};
/// From cars; ours.
const CARS: Repulsion = Repulsion {
    strength: 6.0,
    range: 0.4,
};
/// Largest strength of the repulsion from a body, m/s². It multiplies the sum of two unit vectors.
const STRONGEST: f64 = 8.0;
/// How far ahead the motion of others is extrapolated, seconds.
const FORESIGHT_S: f64 = 1.0;
/// Weight of what is behind one's back (Helbing and Molnár's c).
const BEHIND: f64 = 0.5;
/// Cosine of 100 degrees: what lies farther off the desired direction is behind (their 2 phi is 200
/// degrees).
const BACK_COSINE: f64 = -0.173_648;
/// How far people see each other, metres.
pub(super) const SIGHT_M: f64 = 4.0;

/// A person or a robot: a disc that moves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    pub position: MapPoint,
    /// In `map`, m/s.
    pub velocity: [f64; 2],
    /// Metres.
    pub radius: f64,
}

impl From<RobotState> for Body {
    fn from(robot: RobotState) -> Self {
        Self {
            position: robot.position,
            velocity: robot.velocity,
            radius: robot.radius,
        }
    }
}

/// The drive towards walking at `speed` m/s in the direction of the unit vector `heading`.
pub(super) fn drive(body: Body, heading: [f64; 2], speed: f64) -> [f64; 2] {
    [0, 1].map(|k| (speed * heading[k] - body.velocity[k]) / RELAXATION_S)
}

/// Repulsion from another body: minus the gradient of `V0 exp(-b / sigma)`, which is
/// `V0 / sigma exp(-b / sigma) (|d| + |d - y|) / (4 b) (d / |d| + (d - y) / |d - y|)`. The exponent
/// has the distance between rims plus one usual diameter, so that wide bodies keep wider apart.
pub(super) fn from_body(body: Body, heading: [f64; 2], other: Body) -> [f64; 2] {
    let d = [
        body.position.x - other.position.x,
        body.position.y - other.position.y,
    ];
    let away = libm::hypot(d[0], d[1]);
    if !(1e-6..=SIGHT_M).contains(&away) {
        return [0.0; 2];
    }
    // The other's approach during the foresight.
    let y = [0, 1].map(|k| (other.velocity[k] - body.velocity[k]) * FORESIGHT_S);
    let e = [d[0] - y[0], d[1] - y[1]];
    let later = libm::hypot(e[0], e[1]).max(1e-6);
    let sum = away + later;
    // At least 10 cm: for bodies on one another the force would have no bound.
    let b = (sum * sum - y[0] * y[0] - y[1] * y[1]).max(0.04).sqrt() / 2.0;
    let rims = b - (body.radius + other.radius - 2.0 * PERSON_RADIUS_M);
    // `d` points from the other to this body, hence the sign.
    let in_sight = -(d[0] * heading[0] + d[1] * heading[1]) >= BACK_COSINE * away;
    let weight = if in_sight { 1.0 } else { BEHIND };
    let force = PEOPLE.strength * libm::exp(-rims / PEOPLE.range) * sum / (4.0 * b);
    let strength = weight * force.min(STRONGEST);
    [0, 1].map(|k| strength * (d[k] / away + e[k] / later))
}

/// Repulsion from the nearest obstacle.
pub(super) fn from_obstacles(clearance: Clearance) -> [f64; 2] {
    let strength = OBSTACLES.strength * libm::exp(-clearance.distance / OBSTACLES.range);
    clearance.gradient.map(|s| strength * s)
}

/// Repulsion from a car and from where it will be after the foresight.
pub(super) fn from_car(body: Body, car: &CarHull) -> [f64; 2] {
    let stretch = car.speed * FORESIGHT_S;
    // Farther off, the force is below 1 % of an acceleration that matters.
    if !car.may_reach(body.position, stretch + 6.0 * CARS.range) {
        return [0.0; 2];
    }
    let near = car.nearest(body.position, stretch);
    let (dx, dy) = (body.position.x - near.x, body.position.y - near.y);
    let away = libm::hypot(dx, dy).max(1e-6);
    let strength = CARS.strength * libm::exp(-(away - body.radius) / CARS.range);
    [dx / away * strength, dy / away * strength]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, velocity: [f64; 2]) -> Body {
        Body {
            position: MapPoint::new(x, y),
            velocity,
            radius: PERSON_RADIUS_M,
        }
    }

    /// `V0 exp(-b / sigma)` at `d` from a person who moves with the `relative` velocity.
    fn potential(d: [f64; 2], relative: [f64; 2]) -> f64 {
        let (x, y) = (
            d[0] - relative[0] * FORESIGHT_S,
            d[1] - relative[1] * FORESIGHT_S,
        );
        let sum = libm::hypot(d[0], d[1]) + libm::hypot(x, y);
        let approach = libm::hypot(relative[0], relative[1]) * FORESIGHT_S;
        let b = (sum * sum - approach * approach).sqrt() / 2.0;
        PEOPLE.strength * PEOPLE.range * libm::exp(-b / PEOPLE.range)
    }

    #[test]
    fn people_repel_each_other_down_the_gradient_of_the_potential() {
        let cases = [
            ([-1.0, 0.3], [-0.4, 0.1]),
            ([-0.7, -0.6], [0.3, 1.2]),
            ([-1.6, 0.1], [-1.3, 0.0]),
        ];
        for (d, velocity) in cases {
            let own = [0.5, 0.2];
            let force = from_body(at(0.0, 0.0, own), [1.0, 0.0], at(-d[0], -d[1], velocity));
            let relative = [velocity[0] - own[0], velocity[1] - own[1]];
            let h = 1e-5;
            let slope = [[h, 0.0], [0.0, h]].map(|s| {
                let at = |sign: f64| potential([d[0] + sign * s[0], d[1] + sign * s[1]], relative);
                (at(1.0) - at(-1.0)) / (2.0 * h)
            });
            for k in 0..2 {
                let sum = (force[k] + slope[k]).abs();
                assert!(sum < 1e-6 * (1.0 + force[k].abs()), "{force:?} {slope:?}");
            }
        }
    }

    #[test]
    fn people_behind_count_half() {
        let still = |x: f64| at(x, 0.0, [0.0; 2]);
        let force = |x: f64| from_body(still(0.0), [1.0, 0.0], still(x))[0];
        assert!(force(1.0) < 0.0 && (force(-1.0) + BEHIND * force(1.0)).abs() < 1e-12);
    }

    #[test]
    fn obstacles_repel_along_the_gradient_of_the_clearance() {
        let force = from_obstacles(Clearance {
            distance: 0.2,
            gradient: [0.0, 1.0],
        });
        assert_eq!(force[0], 0.0);
        assert!((force[1] - OBSTACLES.strength / std::f64::consts::E).abs() < 1e-12);
    }
}
