//! Right of way: whether the robot stepped in front of somebody who could no longer stop.
//!
//! The path of a mover is its hull, swept straight ahead. The braking distance of a car is that of
//! a full brake on dry asphalt. That of a person is the distance in which the social force model's
//! drive brings a walk to rest, speed times relaxation time.
//!
//! The robot is to blame for a collision, even if it stands by then, if within the braking distance
//! it enters the path from the side, or drives towards the mover. It is not to blame if a mover
//! runs into it while it stands, nor for where it is pushed. A mover whose path swings over the
//! robot, because it turns or sets out, leaves the robot the time to notice and to brake.

use openbench_core::MapPoint;

use super::driver_model::HARDEST;
use super::mover::{Hull, Mover, MoverKind, RobotState};
use super::social_force::RELAXATION_S;

/// A slower mover has no path, m/s.
const STANDING_SPEED: f64 = 0.05;
/// Longest path that is regarded, metres.
const FAR_M: f64 = 100.0;
/// A robot that has left a path is to blame for this time, seconds: a contact changes the path.
const BLAME_S: f64 = 0.5;
/// Time in which a robot can notice a turn, seconds: a scan of its LiDAR and one of its commands.
const REACTION_S: f64 = 0.2;
/// A path that left the robot for less than this time has stayed, seconds: people sway.
const SWAY_S: f64 = 0.5;

/// Watches the robot among movers, observation by observation.
#[derive(Debug, Clone)]
pub(crate) struct RobotWatch {
    /// The robot's largest, m/s².
    deceleration: f64,
    watched: Vec<Watched>,
    robot: Option<MapPoint>,
}

/// What is remembered of one mover.
#[derive(Debug, Clone, Copy, Default)]
struct Watched {
    /// Seconds for which the robot is still to blame.
    blame: f64,
    /// Seconds for which the mover has had no path, or one elsewhere.
    elsewhere: f64,
    /// Seconds that the robot still has to brake.
    grace: f64,
}

impl RobotWatch {
    /// Watches a robot with this largest deceleration, m/s².
    pub(crate) fn new(deceleration: f64) -> Self {
        Self {
            deceleration,
            watched: Vec::new(),
            robot: None,
        }
    }

    /// Takes in an instant, `dt` seconds after the last. `drives` tells whether the robot's wheels
    /// turn: if not, it moves because it is pushed. `movers` must keep their order.
    pub(crate) fn update(&mut self, dt: f64, robot: &RobotState, drives: bool, movers: &[Mover]) {
        // At the first instant the robot has not moved.
        let before = self.robot.replace(robot.position).unwrap_or(robot.position);
        let moved = [robot.position.x - before.x, robot.position.y - before.y];
        let speed = libm::hypot(robot.velocity[0], robot.velocity[1]);
        let time_to_stop = REACTION_S + speed / self.deceleration;
        self.watched.resize(movers.len(), Watched::default());
        for (mover, watched) in movers.iter().zip(&mut self.watched) {
            watched.blame = (watched.blame - dt).max(0.0);
            watched.grace = (watched.grace - dt).max(0.0);
            // Blame outlasts the path for a moment, since a contact changes it.
            if !lies_in_path(robot.position, robot.radius, mover, FAR_M) {
                watched.elsewhere += dt;
                continue;
            }
            // Where the robot was, in the path as it is now: so it moved in, rather than the path.
            let from_aside = !lies_in_path(before, robot.radius, mover, FAR_M);
            // Half a step of tolerance, here and below: times are sums of steps.
            let swung = !from_aside && watched.elsewhere > SWAY_S - dt / 2.0;
            watched.elsewhere = 0.0;
            if swung {
                watched.grace = time_to_stop;
            }
            let [u, v] = mover.velocity;
            // Not divided by zero: a mover with a path is faster than STANDING_SPEED.
            let approach = -(moved[0] * u + moved[1] * v) / libm::hypot(u, v);
            let against = approach > STANDING_SPEED * dt;
            // A robot whose wheels stand is pushed, and enters nothing.
            let enters = drives && (from_aside || against && watched.grace < dt / 2.0);
            let cannot_stop =
                lies_in_path(robot.position, robot.radius, mover, braking_distance(mover));
            // Once to blame, the robot stays so while it is within the braking distance.
            if cannot_stop && (watched.blame > 0.0 || enters) {
                watched.blame = BLAME_S;
            }
        }
    }

    /// Whether the robot entered the path of the nearest mover of a kind within its braking
    /// distance.
    pub(crate) fn cut_off(&self, kind: MoverKind, movers: &[Mover]) -> bool {
        let Some(robot) = self.robot else {
            return false;
        };
        let candidates = movers
            .iter()
            .zip(&self.watched)
            .filter(|(m, _)| m.present && m.kind == kind);
        let apart = |mover: &Mover| distance_to_path(robot, mover, 0.0);
        // A contact names a class and no mover: the one that touches the robot is the nearest.
        let nearest = candidates.min_by(|a, b| apart(a.0).total_cmp(&apart(b.0)));
        nearest.is_some_and(|(_, watched)| watched.blame > 0.0)
    }
}

/// Metres.
fn braking_distance(mover: &Mover) -> f64 {
    let speed = libm::hypot(mover.velocity[0], mover.velocity[1]);
    match mover.kind {
        MoverKind::Pedestrian => speed * RELAXATION_S,
        MoverKind::Car => speed * speed / (2.0 * HARDEST),
    }
}

/// Whether a disc touches the path of a mover up to `ahead` metres ahead.
fn lies_in_path(at: MapPoint, radius: f64, mover: &Mover, ahead: f64) -> bool {
    let speed = libm::hypot(mover.velocity[0], mover.velocity[1]);
    mover.present && speed > STANDING_SPEED && distance_to_path(at, mover, ahead) < radius
}

/// Metres from a point to a mover's hull, swept `ahead` metres.
fn distance_to_path(at: MapPoint, mover: &Mover, ahead: f64) -> f64 {
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

    /// Whether a robot is to blame that moved from one place to another while a mover came nearer.
    fn blame(from: RobotState, to: RobotState, who: fn(f64) -> Mover) -> bool {
        came(from, to, who, true)
    }

    fn came(from: RobotState, to: RobotState, who: fn(f64) -> Mover, drives: bool) -> bool {
        let mut watch = RobotWatch::new(1.0);
        watch.update(0.05, &from, drives, &[who(-0.06)]);
        watch.update(0.05, &to, drives, &[who(0.0)]);
        watch.cut_off(who(0.0).kind, &[who(0.0)])
    }

    #[test]
    fn a_robot_that_steps_in_front_of_somebody_is_to_blame() {
        assert!(blame(robot(0.7, 0.6), robot(0.7, 0.4), walker));
        assert!(blame(robot(5.5, 1.2), robot(5.5, 1.0), car));
    }

    #[test]
    fn a_robot_that_stands_or_leaves_room_to_stop_is_not() {
        // A person walks up to where the robot has always stood.
        assert!(!blame(robot(1.05, 0.0), robot(1.05, 0.0), walker));
        // A person catches up with a robot that drives ahead.
        assert!(!blame(robot(1.00, 0.0), robot(1.03, 0.0), walker));
        // There is room to stop.
        assert!(
            !blame(robot(1.5, 0.6), robot(1.5, 0.4), walker)
                && !blame(robot(6.5, 1.2), robot(6.5, 1.0), car)
        );
        // The robot is pushed by another person.
        assert!(!came(robot(0.7, 0.6), robot(0.7, 0.4), walker, false));
        // The robot is behind the person.
        assert!(!blame(robot(-0.6, 0.0), robot(-0.5, 0.0), walker));
    }

    #[test]
    fn a_robot_that_drives_at_somebody_too_near_is_to_blame_at_every_sampling_phase() {
        for phase in 0..10 {
            let mut watch = RobotWatch::new(1.0);
            let mut apart = 3.0 + 0.01 * f64::from(phase);
            // Both go on, until the robot stands with 1.3 m or 0.8 m between the centres.
            for stop in [1.3, 0.8] {
                while apart > stop {
                    watch.update(0.05, &robot(apart, 0.0), true, &[walker(0.0)]);
                    apart -= 0.025;
                }
                let too_near = stop < 1.0;
                assert_eq!(
                    watch.cut_off(MoverKind::Pedestrian, &[walker(0.0)]),
                    too_near,
                    "{phase}"
                );
            }
        }
    }

    #[test]
    fn a_robot_that_somebody_turns_towards_may_brake_but_not_go_on() {
        // A person walks aside for some seconds, then turns towards a robot that approaches. The
        // robot brakes after some time.
        let blame = |aside: f64, apart: f64, waits: f64| {
            let mut watch = RobotWatch::new(1.0);
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
                watch.update(
                    0.05,
                    &state,
                    speed > 0.0,
                    &[Mover {
                        velocity: walks,
                        ..walker(walked)
                    }],
                );
            }
            watch.cut_off(MoverKind::Pedestrian, &[walker(walked)])
        };
        assert!(!blame(1.0, 0.85, 0.1) && blame(1.0, 1.3, 1.0));
        // A person who only swayed has kept his path.
        assert!(blame(0.3, 0.85, 0.1));
    }

    #[test]
    fn blame_ends_a_while_after_the_path_is_left() {
        let mut watch = RobotWatch::new(1.0);
        for (y, seconds) in [(0.6, 0.05), (0.4, 0.05), (0.9, 0.05)] {
            watch.update(seconds, &robot(0.7, y), true, &[walker(0.0)]);
        }
        assert!(watch.cut_off(MoverKind::Pedestrian, &[walker(0.0)]));
        watch.update(BLAME_S, &robot(0.7, 0.9), true, &[walker(0.0)]);
        assert!(!watch.cut_off(MoverKind::Pedestrian, &[walker(0.0)]));
    }
}
