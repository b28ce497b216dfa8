//! Leaving near contact: the small motion that gains most room. Within millimetres of an obstacle
//! soft penalties are no help, and a search over cells and headings is too coarse.

use openbench_core::{Pose2, Velocity};

use crate::feasible::{Floors, clearance};
use crate::kinematics::Motion;
use crate::limits::Limits;
use crate::local::Situation;
use crate::shape::{Footprint, Obstacle, standing};
use crate::trajectory::{TimedPose, Trajectory};

/// Distance from obstacles beyond which more is no gain, metres.
const ENOUGH_M: f64 = 0.03;
/// Distance that a motion has to gain to be worth it, metres.
const GAIN_M: f64 = 0.0005;
/// Least distance that is kept during the motion, metres, or half of what there is.
pub(crate) const KEEP_M: f64 = 0.001;
/// A motion that takes longer comes from an impossible speed, seconds.
const LONGEST_S: f64 = 10.0;
/// Seconds between two checks.
const STEP_S: f64 = 0.02;
/// Phases of the motions that are tried. Rims that accelerate as fast as they can do not turn the
/// robot before they have their speed.
const PHASES: [Phases; 5] = [
    Phases {
        turning: 0.2,
        straight: 0.0,
    },
    Phases {
        turning: 0.5,
        straight: 0.0,
    },
    Phases {
        turning: 0.2,
        straight: 0.5,
    },
    Phases {
        turning: 0.4,
        straight: 0.9,
    },
    Phases {
        turning: 0.35,
        straight: 1.7,
    },
];
/// The furthest that such a motion leads, metres.
const AWAY_M: f64 = 0.7;
/// Speeds that are tried, m/s.
const SPEEDS_MPS: [f64; 5] = [0.0, -0.1, 0.1, -0.25, 0.25];
/// Turn rates that are tried, rad/s.
const TURNS_RADPS: [f64; 11] = [
    0.0, -0.03, 0.03, -0.06, 0.06, -0.15, 0.15, -0.4, 0.4, -0.8, 0.8,
];

/// The motion that gains most distance from standing obstacles, from how the robot moves now until
/// it stands again; `None` if none gains any.
pub(crate) fn leave(
    footprint: &Footprint,
    limits: &Limits,
    situation: &Situation<'_>,
) -> Option<Trajectory> {
    let (placed, circle) = (footprint.at(situation.pose), footprint.circumscribed());
    let near =
        standing(situation.obstacles).filter(|o| o.contact(&placed, circle, 0.0, AWAY_M).is_some());
    let search = Search {
        footprint,
        limits,
        near: near.collect(),
    };
    let start_room = search.room(situation.pose) + GAIN_M;
    let mut best = Best {
        room: start_room,
        attempt: None,
    };
    // 5 speeds, 11 turn rates and 5 pairs of phases are few enough to try them all.
    for linear in SPEEDS_MPS.map(|v| v.clamp(-limits.backward, limits.forward)) {
        for angular in TURNS_RADPS.map(|w| w.clamp(-limits.turn, limits.turn)) {
            for phases in PHASES {
                let start = motion(situation, Velocity::new(linear, angular));
                search.offer(&mut best, Attempt { start, phases });
            }
        }
    }
    let attempt = best.attempt?;
    let mut poses = vec![TimedPose {
        pose: attempt.start.pose,
        time: 0.0,
    }];
    // Driven once more, now for its poses.
    search.is_free(attempt, &mut |time, pose| {
        poses.push(TimedPose { pose, time })
    });
    Trajectory::new(poses)
}

/// The robot's motion with a command.
fn motion(situation: &Situation<'_>, command: Velocity) -> Motion {
    Motion {
        pose: situation.pose,
        velocity: situation.velocity,
        command,
    }
}

/// A motion: it turns, then goes on straight, then brakes.
#[derive(Debug, Clone, Copy)]
struct Phases {
    /// Seconds.
    turning: f64,
    /// Seconds.
    straight: f64,
}

/// A motion that is tried.
#[derive(Debug, Clone, Copy)]
struct Attempt {
    /// The robot's motion at its beginning, with the command of the first phase.
    start: Motion,
    phases: Phases,
}

/// The best motion so far.
struct Best {
    /// Distance to the nearest obstacle at its end, metres.
    room: f64,
    attempt: Option<Attempt>,
}

/// A search for one motion.
struct Search<'a> {
    footprint: &'a Footprint,
    limits: &'a Limits,
    near: Vec<&'a Obstacle>,
}

impl Search<'_> {
    fn near(&self) -> impl Iterator<Item = &Obstacle> {
        self.near.iter().copied()
    }

    /// Replaces the best motion by one that gains more.
    fn offer(&self, best: &mut Best, attempt: Attempt) {
        let mut end = attempt.start.pose;
        let is_free = self.is_free(attempt, &mut |_, pose| end = pose);
        // Rounding must not decide between motions that gain the same: the first one is kept.
        if is_free && self.room(end) > best.room + 1e-9 {
            *best = Best {
                room: self.room(end),
                attempt: Some(attempt),
            };
        }
    }

    /// Distance to the nearest obstacle, as far as it matters, metres.
    fn room(&self, pose: Pose2) -> f64 {
        clearance(self.footprint, self.near(), pose, 0.0, ENOUGH_M)
    }

    /// Whether a motion keeps off all obstacles; `look` is shown the times (seconds) and poses
    /// along it.
    fn is_free(&self, attempt: Attempt, look: &mut dyn FnMut(f64, Pose2)) -> bool {
        let Phases { turning, straight } = attempt.phases;
        let mut motion = attempt.start;
        let mut floors = Floors::new(self.footprint, self.near(), motion.pose, KEEP_M);
        let mut time = 0.0;
        while time < turning + straight || !motion.stands() {
            if time >= turning {
                motion.command.angular = 0.0;
            }
            if time >= turning + straight {
                motion.command = Velocity::ZERO;
            }
            motion.step(self.limits, STEP_S);
            time += STEP_S;
            if time > LONGEST_S || !floors.keep(self.footprint, self.near(), motion.pose, 0.0) {
                return false;
            }
            look(time, motion.pose);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::{MapPoint, RobotDescription, SimTime};

    fn after(obstacles: &[Obstacle], cycles: usize) -> f64 {
        let robot = RobotDescription::sentry();
        let (footprint, limits) = (Footprint::of(&robot).unwrap(), Limits::of(&robot).unwrap());
        let mut motion = Motion {
            pose: Pose2::default(),
            velocity: Velocity::ZERO,
            command: Velocity::ZERO,
        };
        let mut band = None;
        for _ in 0..cycles {
            let situation = Situation {
                time: SimTime::ZERO,
                pose: motion.pose,
                velocity: motion.velocity,
                path: &[MapPoint::new(3.0, 0.0)],
                final_yaw: None,
                obstacles,
            };
            if !band
                .as_ref()
                .is_some_and(|band: &Trajectory| band.duration() > 0.03)
            {
                band = leave(&footprint, &limits, &situation);
            }
            motion.command = band
                .as_ref()
                .map_or(Velocity::ZERO, |band| band.command(&limits));
            for _ in 0..5 {
                motion.step(&limits, 0.01);
                assert!(clearance(&footprint, obstacles.iter(), motion.pose, 0.0, 1.0) > 0.0);
            }
            if let Some(band) = &mut band {
                band.advance(motion.pose, 0.05);
            }
        }
        clearance(&footprint, obstacles.iter(), motion.pose, 0.0, 1.0)
    }

    fn wall(from: (f64, f64), to: (f64, f64)) -> Obstacle {
        Obstacle::wall(MapPoint::new(from.0, from.1), MapPoint::new(to.0, to.1)).unwrap()
    }

    #[test]
    fn the_robot_leaves_a_wall_in_near_contact() {
        assert!(after(&[wall((0.162, -1.0), (0.162, 1.0))], 30) > 0.01);
        assert!(after(&[wall((-1.0, 0.157), (2.0, 0.157))], 300) > 0.01);
    }

    #[test]
    fn the_robot_stands_where_there_is_no_room() {
        let walls = [
            wall((0.1605, -1.0), (0.1605, 1.0)),
            wall((-0.1605, -1.0), (-0.1605, 1.0)),
            wall((-1.0, 0.1555), (1.0, 0.1555)),
            wall((-1.0, -0.1555), (1.0, -0.1555)),
        ];
        let left = after(&walls, 20);
        assert!((left - 0.0005).abs() < 0.0003, "{left}");
    }
}
