//! Whose way it was: whether the robot stepped before somebody who could no longer stop.
//!
//! The path of somebody who moves is the hull, swept straight ahead. The braking distance is, of a car, that of a full
//! brake on dry asphalt, and of a person the way in which the social force model's drive brings a walk to rest, speed times
//! relaxation time. A robot is to blame for what comes of it, even if it stands by then, if within the braking distance it gets into the path from
//! the side, or drives towards who comes. Who moves into a standing robot's place is no concern of the robot's, nor where it is pushed.
//! Who turns, or sets out, so that his path comes over the robot leaves it the time to notice and to brake.

use openbench_core::MapPoint;

use super::{Hull, Mover, MoverKind, RobotState, cars, pedestrians};

/// Slower than this nobody has a path, m/s.
const STANDS: f64 = 0.05;
/// All of a path that can matter, metres.
const FAR: f64 = 100.0;
/// A robot that has left a path is to blame for so long, seconds: a touch changes the path.
const LASTS: f64 = 0.5;
/// Seconds until a robot can know of a turn: a round of its LiDAR and one of its commands.
const NOTICES: f64 = 0.2;
/// A path that left the robot for less than this has not been anywhere else, seconds: people waver.
const WAVERS: f64 = 0.5;

/// Watches a robot among those who move, observation by observation.
#[derive(Debug, Clone)]
pub struct Yielding {
    /// m/s².
    deceleration: f64,
    watched: Vec<Watched>,
    robot: Option<MapPoint>,
}

/// What is remembered of one mover.
#[derive(Debug, Clone, Copy, Default)]
struct Watched {
    /// Seconds for which the robot is still to blame.
    blame: f64,
    /// Seconds for which he has had no path, or one elsewhere.
    elsewhere: f64,
    /// Seconds that the robot still has to brake in.
    grace: f64,
}

impl Yielding {
    /// Watches a robot that brakes with so many m/s² at most.
    pub fn new(deceleration: f64) -> Self {
        Self {
            deceleration,
            watched: Vec::new(),
            robot: None,
        }
    }

    /// Takes in an instant, `dt` seconds after the last. `drives` says whether the robot's wheels turn: if not, it moves because it is pushed. `movers` must keep their order.
    pub fn update(&mut self, dt: f64, robot: &RobotState, drives: bool, movers: &[Mover]) {
        let before = self.robot.replace(robot.position).unwrap_or(robot.position);
        let moved = [robot.position.x - before.x, robot.position.y - before.y];
        let brakes =
            NOTICES + libm::hypot(robot.velocity[0], robot.velocity[1]) / self.deceleration;
        self.watched.resize(movers.len(), Watched::default());
        for (mover, watched) in movers.iter().zip(&mut self.watched) {
            let lies = |at, ahead| lies_in_path(at, robot.radius, mover, ahead);
            watched.blame = (watched.blame - dt).max(0.0);
            watched.grace = (watched.grace - dt).max(0.0);
            if !lies(robot.position, FAR) {
                watched.elsewhere += dt;
                continue;
            }
            let from_aside = !lies(before, FAR);
            let swung = !from_aside && watched.elsewhere > WAVERS - dt / 2.0;
            watched.elsewhere = 0.0;
            if swung {
                watched.grace = brakes;
            }
            let [u, v] = mover.velocity;
            let against = -(moved[0] * u + moved[1] * v) / libm::hypot(u, v) > STANDS * dt;
            let enters = drives && (from_aside || against && watched.grace < dt / 2.0);
            if lies(robot.position, braking(mover)) && (watched.blame > 0.0 || enters) {
                watched.blame = LASTS;
            }
        }
    }

    /// Whether the robot got into the way of the nearest of those of a kind within their braking distance.
    pub fn cut_off(&self, kind: MoverKind, movers: &[Mover]) -> bool {
        let Some(robot) = self.robot else {
            return false;
        };
        let those = movers
            .iter()
            .zip(&self.watched)
            .filter(|(m, _)| m.present && m.kind == kind);
        let apart = |m: &Mover| outside(robot, m, 0.0);
        those
            .min_by(|a, b| apart(a.0).total_cmp(&apart(b.0)))
            .is_some_and(|(_, watched)| watched.blame > 0.0)
    }
}

/// Braking distance, metres.
fn braking(mover: &Mover) -> f64 {
    let speed = libm::hypot(mover.velocity[0], mover.velocity[1]);
    match mover.kind {
        MoverKind::Pedestrian => speed * pedestrians::RELAXATION,
        MoverKind::Car => speed * speed / (2.0 * cars::HARDEST),
    }
}

/// Whether a disc lies in the path of somebody as far as so many metres ahead.
fn lies_in_path(at: MapPoint, radius: f64, mover: &Mover, ahead: f64) -> bool {
    let speed = libm::hypot(mover.velocity[0], mover.velocity[1]);
    mover.present && speed > STANDS && outside(at, mover, ahead) < radius
}

/// Metres from a point to a hull that is swept ahead.
fn outside(at: MapPoint, mover: &Mover, ahead: f64) -> f64 {
    let (x, y) = (at.x - mover.pose.x, at.y - mover.pose.y);
    match mover.hull {
        Hull::Disc { radius } => {
            let [u, v] = mover.velocity;
            let speed = libm::hypot(u, v).max(1e-9);
            let along = ((x * u + y * v) / speed).clamp(0.0, ahead);
            (libm::hypot(x - along * u / speed, y - along * v / speed) - radius).max(0.0)
        }
        Hull::Box {
            half_length,
            half_width,
        } => {
            let (forward, left) = mover.pose.inverse_transform(at);
            let long = forward - forward.clamp(-half_length, half_length + ahead);
            libm::hypot(long, (left.abs() - half_width).max(0.0))
        }
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::Pose2;

    use super::*;

    fn walker(x: f64) -> Mover {
        Mover {
            kind: MoverKind::Pedestrian,
            present: true,
            pose: Pose2::new(x, 0.0, 0.0),
            velocity: [1.2, 0.0],
            hull: Hull::Disc { radius: 0.25 },
            gait: 0.0,
            look: 0,
        }
    }

    fn car(x: f64) -> Mover {
        Mover {
            kind: MoverKind::Car,
            velocity: [8.0, 0.0],
            hull: Hull::Box {
                half_length: 2.0,
                half_width: 0.9,
            },
            ..walker(x)
        }
    }

    fn robot(x: f64, y: f64) -> RobotState {
        RobotState {
            position: MapPoint::new(x, y),
            velocity: [0.0; 2],
            radius: 0.2,
        }
    }

    /// Whether a robot is to blame that came from one place to another while somebody came nearer.
    fn blame(from: RobotState, to: RobotState, who: fn(f64) -> Mover) -> bool {
        came(from, to, who, true)
    }

    fn came(from: RobotState, to: RobotState, who: fn(f64) -> Mover, drives: bool) -> bool {
        let mut yielding = Yielding::new(1.0);
        yielding.update(0.05, &from, drives, &[who(-0.06)]);
        yielding.update(0.05, &to, drives, &[who(0.0)]);
        yielding.cut_off(who(0.0).kind, &[who(0.0)])
    }

    #[test]
    fn who_steps_before_somebody_is_to_blame() {
        assert!(blame(robot(0.7, 0.6), robot(0.7, 0.4), walker));
        assert!(blame(robot(5.5, 1.2), robot(5.5, 1.0), car));
    }

    #[test]
    fn who_stands_or_comes_from_afar_is_not() {
        // Somebody walks up to where the robot has stood all along.
        assert!(!blame(robot(1.05, 0.0), robot(1.05, 0.0), walker));
        // Somebody comes up to a robot that drives away before him.
        assert!(!blame(robot(1.00, 0.0), robot(1.03, 0.0), walker));
        // There is room to stop.
        assert!(
            !blame(robot(1.5, 0.6), robot(1.5, 0.4), walker)
                && !blame(robot(6.5, 1.2), robot(6.5, 1.0), car)
        );
        // Pushed by somebody else.
        assert!(!came(robot(0.7, 0.6), robot(0.7, 0.4), walker, false));
        // Behind a back.
        assert!(!blame(robot(-0.6, 0.0), robot(-0.5, 0.0), walker));
    }

    #[test]
    fn who_drives_at_somebody_too_near_is_to_blame_whenever_it_is_looked_at() {
        for phase in 0..10 {
            let mut yielding = Yielding::new(1.0);
            let mut apart = 3.0 + 0.01 * f64::from(phase);
            // Both go on, until the robot stands with a metre, or with half a metre, between middles.
            for stop in [1.3, 0.8] {
                while apart > stop {
                    yielding.update(0.05, &robot(apart, 0.0), true, &[walker(0.0)]);
                    apart -= 0.025;
                }
                let too_near = stop < 1.0;
                assert_eq!(
                    yielding.cut_off(MoverKind::Pedestrian, &[walker(0.0)]),
                    too_near,
                    "{phase}"
                );
            }
        }
    }

    #[test]
    fn who_is_turned_upon_may_brake_but_not_go_on() {
        // Somebody walks aside for some seconds and then turns to a robot that comes towards him, and brakes after some time.
        let blame = |aside: f64, apart: f64, waits: f64| {
            let mut yielding = Yielding::new(1.0);
            let (mut driven, mut speed, mut walked) = (-0.4 * aside, 0.4, 0.0);
            for i in 0..35 {
                let time = 0.05 * f64::from(i) - aside;
                let walks = if time < 0.0 { [0.0, 0.6] } else { [0.6, 0.0] };
                speed = if time > waits {
                    f64::max(speed - 0.05, 0.0)
                } else {
                    speed
                };
                driven += 0.05 * speed;
                walked += 0.05 * walks[0];
                let state = RobotState {
                    velocity: [-speed, 0.0],
                    ..robot(apart - driven, 0.0)
                };
                yielding.update(
                    0.05,
                    &state,
                    speed > 0.0,
                    &[Mover {
                        velocity: walks,
                        ..walker(walked)
                    }],
                );
            }
            yielding.cut_off(MoverKind::Pedestrian, &[walker(walked)])
        };
        assert!(!blame(1.0, 0.85, 0.1) && blame(1.0, 1.3, 1.0));
        // Who only wavered is to be reckoned with.
        assert!(blame(0.3, 0.85, 0.1));
    }

    #[test]
    fn blame_ends_a_while_after_the_path_is_left() {
        let mut yielding = Yielding::new(1.0);
        for (y, seconds) in [(0.6, 0.05), (0.4, 0.05), (0.9, 0.05)] {
            yielding.update(seconds, &robot(0.7, y), true, &[walker(0.0)]);
        }
        assert!(yielding.cut_off(MoverKind::Pedestrian, &[walker(0.0)]));
        yielding.update(LASTS, &robot(0.7, 0.9), true, &[walker(0.0)]);
        assert!(!yielding.cut_off(MoverKind::Pedestrian, &[walker(0.0)]));
    }
}
