//! How near the robot came to people and cars.
//!
//! Personal spaces are those of E. T. Hall, *The Hidden Dimension*, 1966: intimate below 0.45 m
//! (1.5 feet), personal below 1.2 m (4 feet), here between hulls and for people only. The time to
//! collision (J. C. Hayward, *Near-miss determination through use of a scale of danger*, 1972) is
//! that of hulls at constant velocity.

use openbench_core::MapPoint;

use super::mover::{Hull, Mover, MoverKind, RobotState};

/// Intimate space, metres (Hall).
pub const INTIMATE_M: f64 = 0.45;
/// Personal space, metres (Hall).
pub const PERSONAL_M: f64 = 1.2;
/// A time to collision below this is a near miss, seconds. The robot needs that time to come to
/// rest: one second to notice and half a second from 0.5 m/s at 1 m/s². It is also the value with
/// which van der Horst (1990) separates conflicts from ordinary traffic.
pub const NEAR_MISS_S: f64 = 1.5;
/// An encounter is over when the time to collision has been above twice the threshold for this
/// time, seconds.
const ENCOUNTER_ENDS_S: f64 = 2.0;

/// The measures over an episode.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct EncounterTotals {
    /// Seconds measured.
    pub seconds: f64,
    /// Smallest distance between the robot's hull and a person's, metres; infinite without people.
    pub nearest_person_m: f64,
    /// Smallest distance between the robot's hull and a car's, metres; infinite without cars.
    pub nearest_car_m: f64,
    /// Smallest time to collision, seconds; infinite if no mover was ever on a collision course.
    pub least_time_to_collision_s: f64,
    /// Seconds with somebody in [intimate space](INTIMATE_M).
    pub intimate_seconds: f64,
    /// Seconds with somebody in [personal space](PERSONAL_M), intimate space included.
    pub personal_seconds: f64,
    /// Encounters with a person in which the time to collision fell below [`NEAR_MISS_S`].
    pub near_misses_people: usize,
    /// The same with a car.
    pub near_misses_cars: usize,
}

impl Default for EncounterTotals {
    fn default() -> Self {
        Self {
            seconds: 0.0,
            nearest_person_m: f64::INFINITY,
            nearest_car_m: f64::INFINITY,
            least_time_to_collision_s: f64::INFINITY,
            intimate_seconds: 0.0,
            personal_seconds: 0.0,
            near_misses_people: 0,
            near_misses_cars: 0,
        }
    }
}

/// Measures one episode, step by step.
///
/// A person who walks at 1.2 m/s towards a robot that stands 2 m ahead:
///
/// ```
/// use openbench_core::{MapPoint, Pose2};
/// use openbench_sim::traffic::{Encounters, Hull, Mover, MoverKind, RobotState};
///
/// let position = MapPoint::new(2.0, 0.0);
/// let robot = RobotState { position, velocity: [0.0; 2], radius: 0.22 };
/// let person = Mover {
///     kind: MoverKind::Pedestrian,
///     present: true,
///     pose: Pose2::new(0.0, 0.0, 0.0),
///     velocity: [1.2, 0.0],
///     hull: Hull::Disc { radius: 0.25 },
///     gait: 0.0,
///     look: 0,
/// };
/// let mut encounters = Encounters::new();
/// encounters.update(0.05, &robot, &[person]);
/// let totals = encounters.totals();
/// assert!((totals.nearest_person_m - 1.53).abs() < 1e-9);
/// assert!((totals.least_time_to_collision_s - 1.53 / 1.2).abs() < 1e-9);
/// assert_eq!(totals.near_misses_people, 1);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Encounters {
    totals: EncounterTotals,
    /// For each mover: seconds until its near miss is over; 0 if it is in none.
    open: Vec<f64>,
}

impl Encounters {
    /// Measures from now on.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes in an instant that stands for the last `dt` seconds. `movers` must keep their order.
    pub fn update(&mut self, dt: f64, robot: &RobotState, movers: &[Mover]) {
        self.open.resize(movers.len(), 0.0);
        self.totals.seconds += dt;
        let mut nearest = f64::INFINITY;
        for (mover, open) in movers.iter().zip(&mut self.open) {
            if !mover.present {
                *open = 0.0;
                continue;
            }
            let distance = distance(robot, mover);
            let time = time_to_collision(robot, mover);
            let totals = &mut self.totals;
            totals.least_time_to_collision_s = totals.least_time_to_collision_s.min(time);
            let (closest, near_misses) = match mover.kind {
                MoverKind::Pedestrian => {
                    (&mut totals.nearest_person_m, &mut totals.near_misses_people)
                }
                MoverKind::Car => (&mut totals.nearest_car_m, &mut totals.near_misses_cars),
            };
            *closest = closest.min(distance);
            if mover.kind == MoverKind::Pedestrian {
                nearest = nearest.min(distance);
            }
            if time < NEAR_MISS_S && *open == 0.0 {
                *near_misses += 1;
            }
            // Twice the threshold: who hesitates near the robot does not count again and again.
            let goes_on = time < NEAR_MISS_S || (*open > 0.0 && time < 2.0 * NEAR_MISS_S);
            *open = if goes_on {
                ENCOUNTER_ENDS_S
            } else {
                (*open - dt).max(0.0)
            };
        }
        if nearest < INTIMATE_M {
            self.totals.intimate_seconds += dt;
        }
        if nearest < PERSONAL_M {
            self.totals.personal_seconds += dt;
        }
    }

    /// The measures so far.
    pub fn totals(&self) -> EncounterTotals {
        self.totals
    }
}

/// Metres between the robot's disc and a mover's hull; 0 when they touch.
pub(super) fn distance(robot: &RobotState, mover: &Mover) -> f64 {
    let away = match mover.hull {
        Hull::Disc { radius } => robot.position.distance(mover.pose.point()) - radius,
        Hull::Box {
            half_length,
            half_width,
        } => {
            let (x, y) = mover.pose.inverse_transform(robot.position);
            libm::hypot(
                (x.abs() - half_length).max(0.0),
                (y.abs() - half_width).max(0.0),
            )
        }
    };
    (away - robot.radius).max(0.0)
}

/// Seconds until the hulls meet if both keep their velocities; infinite if they do not, 0 when they
/// touch. A car's corners count as square when the robot's radius is added to them.
fn time_to_collision(robot: &RobotState, mover: &Mover) -> f64 {
    // Seen from the mover, which then stands: only relative motion matters.
    let velocity = [0, 1].map(|k| robot.velocity[k] - mover.velocity[k]);
    match mover.hull {
        Hull::Disc { radius } => {
            let center = mover.pose.point();
            let from = [robot.position.x - center.x, robot.position.y - center.y];
            time_to_disc(from, velocity, radius + robot.radius)
        }
        Hull::Box {
            half_length,
            half_width,
        } => {
            let (x, y) = mover.pose.inverse_transform(robot.position);
            // The velocity as an arrow from the car's place: in the car's axes its tip is the
            // velocity there.
            let tip = MapPoint::new(mover.pose.x + velocity[0], mover.pose.y + velocity[1]);
            let (u, v) = mover.pose.inverse_transform(tip);
            let half = [half_length + robot.radius, half_width + robot.radius];
            time_to_box([x, y], [u, v], half)
        }
    }
}

/// Seconds until a point at `from` reaches a disc about the origin.
fn time_to_disc(from: [f64; 2], velocity: [f64; 2], radius: f64) -> f64 {
    let square = velocity[0] * velocity[0] + velocity[1] * velocity[1];
    let approach = from[0] * velocity[0] + from[1] * velocity[1];
    let outside = from[0] * from[0] + from[1] * from[1] - radius * radius;
    if outside <= 0.0 {
        return 0.0;
    }
    // The lower root of |p + v t|² = r², with p · v = `approach` and |p|² - r² = `outside`.
    let root = approach * approach - square * outside;
    if approach >= 0.0 || root < 0.0 || square < 1e-12 {
        return f64::INFINITY;
    }
    (-approach - root.sqrt()) / square
}

/// Seconds until a point at `from` reaches a rectangle about the origin with these half sides.
fn time_to_box(from: [f64; 2], velocity: [f64; 2], half: [f64; 2]) -> f64 {
    // Slabs: the point is inside the rectangle while it is between both pairs of sides. `enters`
    // begins at 0, so a point inside needs no time.
    let (mut enters, mut leaves) = (0.0_f64, f64::INFINITY);
    for k in 0..2 {
        // Along this axis nothing changes: the point is between the sides for ever, or never.
        if velocity[k].abs() < 1e-9 {
            if from[k].abs() > half[k] {
                return f64::INFINITY;
            }
            continue;
        }
        let (a, b) = (
            (-half[k] - from[k]) / velocity[k],
            (half[k] - from[k]) / velocity[k],
        );
        enters = enters.max(a.min(b));
        leaves = leaves.min(a.max(b));
    }
    if enters <= leaves {
        enters
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::Pose2;

    use super::*;

    fn robot(x: f64, speed: f64) -> RobotState {
        RobotState {
            position: MapPoint::new(x, 0.0),
            velocity: [speed, 0.0],
            radius: 0.2,
        }
    }

    fn mover(kind: MoverKind, x: f64, speed: f64) -> Mover {
        let hull = match kind {
            MoverKind::Pedestrian => Hull::Disc { radius: 0.3 },
            MoverKind::Car => Hull::Box {
                half_length: 2.0,
                half_width: 1.0,
            },
        };
        let (pose, velocity) = (Pose2::new(x, 0.0, 0.0), [speed, 0.0]);
        Mover {
            kind,
            present: true,
            pose,
            velocity,
            hull,
            gait: 0.0,
            look: 0,
        }
    }

    #[test]
    fn times_to_collision_are_those_of_hulls_at_constant_velocity() {
        let person = mover(MoverKind::Pedestrian, 5.0, -1.0);
        assert!((time_to_collision(&robot(0.0, 0.5), &person) - 3.0).abs() < 1e-12);
        assert!((distance(&robot(0.0, 0.5), &person) - 4.5).abs() < 1e-12);
        let car = mover(MoverKind::Car, 10.0, -4.0);
        assert!((time_to_collision(&robot(0.0, 0.0), &car) - 7.8 / 4.0).abs() < 1e-12);
        assert_eq!(time_to_collision(&robot(0.0, -5.0), &car), f64::INFINITY);
        let aside = RobotState {
            position: MapPoint::new(0.0, 1.3),
            ..robot(0.0, 0.0)
        };
        assert_eq!(time_to_collision(&aside, &car), f64::INFINITY);
    }

    #[test]
    fn a_near_miss_counts_once_for_each_encounter() {
        let mut encounters = Encounters::new();
        // Somebody comes, hesitates within the same encounter, goes, and comes again.
        for (x, speed) in [
            (6.0, -1.0),
            (1.5, -1.0),
            (1.5, 0.0),
            (1.5, -1.0),
            (9.0, 1.0),
        ] {
            encounters.update(
                0.5,
                &robot(0.0, 0.0),
                &[mover(MoverKind::Pedestrian, x, speed)],
            );
        }
        (0..5).for_each(|_| {
            encounters.update(
                0.5,
                &robot(0.0, 0.0),
                &[mover(MoverKind::Pedestrian, 9.0, 1.0)],
            )
        });
        assert_eq!(encounters.totals().near_misses_people, 1);
        encounters.update(
            0.5,
            &robot(0.0, 0.0),
            &[mover(MoverKind::Pedestrian, 0.9, -1.0)],
        );
        let totals = encounters.totals();
        assert_eq!((totals.near_misses_people, totals.near_misses_cars), (2, 0));
        assert!(
            (totals.nearest_person_m - 0.4).abs() < 1e-12 && totals.nearest_car_m == f64::INFINITY
        );
        assert_eq!(
            (totals.intimate_seconds, totals.personal_seconds),
            (0.5, 2.0)
        );
    }

    #[test]
    fn absent_movers_do_not_count() {
        let mut encounters = Encounters::new();
        let gone = Mover {
            present: false,
            ..mover(MoverKind::Car, 0.0, 0.0)
        };
        encounters.update(0.1, &robot(0.0, 0.0), &[gone]);
        assert_eq!(
            encounters.totals(),
            EncounterTotals {
                seconds: 0.1,
                ..EncounterTotals::default()
            }
        );
    }
}
