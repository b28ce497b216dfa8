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
//! | `mover`, `hull` | a person or a car at an instant, the robot as they see it; the outline of a car |
//! | `plan` | how many there shall be |
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
mod mover;
mod neighbours;
mod pedestrians;
mod plan;
#[cfg(test)]
mod tests;
mod ways;
pub mod yielding;

use openbench_core::{MapPoint, Pose2};
use openbench_osm::OsmMap;

use crate::noise::Noise;
use cars::Cars;
use footways::Footways;
use ground::Ground;
use lanes::{HALF, Lanes};
use pedestrians::Pedestrians;

pub use measures::{Encounters, Totals};
pub use mover::{Hull, Mover, MoverKind, PERSON_RADIUS, RobotState};
pub use plan::TrafficPlan;

/// The models' longest step, seconds; longer ones are cut.
const LONGEST_STEP: f64 = 0.05;
/// Streams of random numbers, beside those of the sensors.
const STREAMS: [u64; 2] = [11, 12];

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
        let cars = Cars::new(
            Lanes::new(map, &ground),
            plan.cars,
            start,
            &pedestrians,
            cars,
        );
        let mut traffic = Self {
            ground,
            pedestrians,
            cars,
            movers: Vec::new(),
        };
        traffic.movers =
            vec![Mover::absent(); traffic.pedestrians.people.len() + traffic.cars.cars.len()];
        traffic.show();
        traffic
    }

    /// How many people and cars there are, cars outside included: fewer than planned, or none, where the map has no
    /// footways or no roads, or no room on them.
    pub fn placed(&self) -> TrafficPlan {
        TrafficPlan {
            pedestrians: self.pedestrians.people.len(),
            cars: self.cars.cars.len(),
        }
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
        let robot = robot.seen();
        for _ in 0..parts as usize {
            self.cars
                .step(dt / parts, &self.ground, &robot, &self.pedestrians);
            let cars = (self.cars.hulls.as_slice(), &self.cars.near);
            self.pedestrians
                .step(dt / parts, &self.ground, &robot, cars);
        }
        self.show();
    }

    fn show(&mut self) {
        let (people, cars) = self.movers.split_at_mut(self.pedestrians.people.len());
        for (look, (mover, person)) in
            (0_u32..).zip(people.iter_mut().zip(&self.pedestrians.people))
        {
            *mover = Mover {
                kind: MoverKind::Pedestrian,
                present: true,
                pose: Pose2::new(person.position.x, person.position.y, person.yaw),
                velocity: person.velocity,
                hull: Hull::Disc {
                    radius: person.radius,
                },
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
                hull: Hull::Box {
                    half_length: HALF[0],
                    half_width: HALF[1],
                },
                gait: 0.0,
                look,
            };
        }
    }
}
