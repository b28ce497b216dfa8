//! People who walk and cars that drive: where they are at each instant, without a physics engine and without rays.
//!
//! Same map, free places, plan, start, seed and motions of the robot: the same bytes. People keep to the map's footways and
//! pavements and cross streets; cars keep to lanes and yield. Both see the robot.
//!
//! | module | its one job |
//! |---|---|
//! | `ways` | what the words on a way say: widths, limits, directions |
//! | `ground` | where people fit, how far from there to where they do not, what is carriageway |
//! | `neighbours` | who is near |
//! | `footways`, `pedestrians` | the network that people walk on; the social force model |
//! | `lanes`, `cars` | lanes and turns; the intelligent driver model and yielding |
//! | `hull` | the outline of a car |
//! | [`figures`] | how a person and a car look |
//! | [`measures`] | how near the robot came to them |
//! | [`yielding`] | whether the robot stepped before somebody who could no longer stop |

mod cars;
#[cfg(test)]
mod crowds;
pub mod figures;
mod footways;
mod ground;
mod hull;
mod lanes;
pub mod measures;
mod neighbours;
mod pedestrians;
#[cfg(test)]
mod tests;
mod ways;
pub mod yielding;

use openbench_core::{MapPoint, Pose2};
use openbench_osm::OsmMap;

use serde::{Deserialize, Serialize};

use crate::noise::Noise;
use cars::Cars;
use footways::Footways;
use ground::Ground;
pub(crate) use hull::CarHull;
use lanes::{HALF, Lanes};
use pedestrians::Pedestrians;

pub use measures::{Encounters, Totals};
pub use pedestrians::PERSON_RADIUS;

/// The models' longest step, seconds; longer ones are cut.
const LONGEST_STEP: f64 = 0.05;
/// Streams of random numbers, beside those of the sensors.
const STREAMS: [u64; 2] = [11, 12];

/// How many there shall be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrafficPlan {
    /// People on foot.
    pub pedestrians: usize,
    /// Cars that drive.
    pub cars: usize,
}

impl TrafficPlan {
    /// Whether nothing moves.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// The robot as others see it: a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobotState {
    /// Its middle in `map`, metres.
    pub position: MapPoint,
    /// Its velocity in `map`, m/s.
    pub velocity: [f64; 2],
    /// Radius of the disc, metres.
    pub radius: f64,
}

/// What moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MoverKind {
    /// A person on foot.
    Pedestrian,
    /// A car.
    Car,
}

/// The outline of a mover, seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hull {
    /// A person.
    Disc {
        /// Metres.
        radius: f64,
    },
    /// A car: a rectangle about its pose.
    Box {
        /// Half the length, metres.
        half_length: f64,
        /// Half the width, metres.
        half_width: f64,
    },
}

/// A person or a car at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mover {
    /// What it is.
    pub kind: MoverKind,
    /// Whether it is there at all: cars leave and come in again.
    pub present: bool,
    /// Middle of the hull and heading, in `map`.
    pub pose: Pose2,
    /// Velocity in `map`, m/s.
    pub velocity: [f64; 2],
    /// Outline.
    pub hull: Hull,
    /// Phase of the walking cycle, 0 to 1 (left foot in front at 0); 0 for cars.
    pub gait: f64,
    /// Which of the [`figures`] it looks like: any number, the same for the mover's whole life.
    pub look: u32,
}

/// People and cars in a map.
#[derive(Debug)]
pub struct Traffic {
    ground: Ground,
    pedestrians: Pedestrians,
    cars: Cars,
    movers: Vec<Mover>,
}

impl Traffic {
    /// Up to as many people and cars as `plan` says, at places drawn from `seed`; fewer where the map has no ways for them:
    /// see [`placed`](Self::placed). `free` says whether a disc of [`PERSON_RADIUS`] fits at a point; it is asked once for each
    /// place of a grid within 300 m of `start`, the robot's place, near which nobody stands. Cars also need it to be true on carriageways.
    pub fn new(
        map: &OsmMap,
        free: impl Fn(MapPoint) -> bool,
        plan: TrafficPlan,
        start: MapPoint,
        seed: u64,
    ) -> Self {
        let ground = Ground::new(map, free, start);
        let [people, cars] = STREAMS.map(|stream| Noise::new(seed, stream));
        let footways = Footways::new(map, &ground);
        let pedestrians = Pedestrians::new(footways, &ground, plan.pedestrians, start, people);
        let cars = Cars::new(Lanes::new(map, &ground), plan.cars, start, &pedestrians, cars);
        let mut traffic = Self { ground, pedestrians, cars, movers: Vec::new() };
        traffic.movers = vec![absent(); traffic.pedestrians.people.len() + traffic.cars.cars.len()];
        traffic.show();
        traffic
    }

    /// How many people and cars there are, cars outside included: fewer than planned, or none, where the map has no
    /// footways or no roads, or no room on them.
    pub fn placed(&self) -> TrafficPlan {
        TrafficPlan { pedestrians: self.pedestrians.people.len(), cars: self.cars.cars.len() }
    }

    /// Everyone, people first; a mover keeps its index.
    pub fn movers(&self) -> &[Mover] {
        &self.movers
    }

    /// Moves everyone by `dt` seconds, up to 1; a step that is not a positive number does nothing. A robot whose state is not
    /// finite is not seen.
    pub fn step(&mut self, dt: f64, robot: RobotState) {
        if dt.is_nan() || dt <= 0.0 {
            return;
        }
        let dt = dt.min(1.0);
        let parts = (dt / LONGEST_STEP - 1e-9).ceil().max(1.0);
        let robot = seen(robot);
        for _ in 0..parts as usize {
            self.cars.step(dt / parts, &self.ground, &robot, &self.pedestrians);
            let cars = (self.cars.hulls.as_slice(), &self.cars.near);
            self.pedestrians.step(dt / parts, &self.ground, &robot, cars);
        }
        self.show();
    }

    fn show(&mut self) {
        let (people, cars) = self.movers.split_at_mut(self.pedestrians.people.len());
        for (look, (mover, person)) in (0_u32..).zip(people.iter_mut().zip(&self.pedestrians.people)) {
            *mover = Mover {
                kind: MoverKind::Pedestrian,
                present: true,
                pose: Pose2::new(person.position.x, person.position.y, person.yaw),
                velocity: person.velocity,
                hull: Hull::Disc { radius: person.radius },
                gait: person.gait,
                look,
            };
        }
        let hulls = self.cars.cars.iter().zip(&self.cars.hulls);
        for (look, (mover, (car, hull))) in (0_u32..).zip(cars.iter_mut().zip(hulls)) {
            let (sin, cos) = libm::sincos(hull.pose.yaw);
            *mover = Mover {
                kind: MoverKind::Car,
                present: car.present,
                pose: hull.pose,
                velocity: [cos * car.speed, sin * car.speed],
                hull: Hull::Box { half_length: HALF[0], half_width: HALF[1] },
                gait: 0.0,
                look,
            };
        }
    }
}

fn absent() -> Mover {
    Mover {
        kind: MoverKind::Pedestrian,
        present: false,
        pose: Pose2::default(),
        velocity: [0.0; 2],
        hull: Hull::Disc { radius: PERSON_RADIUS },
        gait: 0.0,
        look: 0,
    }
}

fn seen(robot: RobotState) -> RobotState {
    let numbers = [robot.position.x, robot.position.y, robot.velocity[0], robot.velocity[1], robot.radius];
    if numbers.iter().all(|v| v.is_finite() && v.abs() < 1e7) {
        return robot;
    }
    RobotState { position: MapPoint::new(1e7, 1e7), velocity: [0.0; 2], radius: 0.0 }
}
