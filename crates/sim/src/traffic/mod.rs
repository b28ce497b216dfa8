//! People who walk and cars that drive: where they are at each instant, without a physics engine
//! and without rays.
//!
//! The same map, free places, plan, start, seed and motions of the robot give the same bytes.
//! People keep to the map's footways and pavements and cross streets; cars keep to lanes and yield.
//! Both see the robot.
//!
//! | module | job |
//! |---|---|
//! | `plan` | [`TrafficPlan`]: how many people and cars are wanted |
//! | `mover`, `hull` | [`Mover`], [`RobotState`]: a person or car and the robot at an instant |
//! | `road_tags` | what a way's tags mean: widths, limits, directions |
//! | `ground` | where people fit, and what is carriageway |
//! | `neighbours` | points near a point |
//! | `polyline` | lengths, parts and parallels of lines |
//! | `footways`, `walk_graph` | the network that people walk on, and paths in it |
//! | `social_force`, `pedestrians` | how people walk |
//! | `streets`, `piece`, `lanes` | the network that cars drive on |
//! | `driver_model`, `obstruction`, `cars` | how cars drive and yield |
//! | `gait`, `figures`, `gallery` | how people and cars look |
//! | `measures` | [`Encounters`]: how near the robot came to them |
//! | `yielding` | whether the robot stepped in front of somebody who could no longer stop |

mod cars;
#[cfg(test)]
mod crowds;
mod driver_model;
mod figures;
mod footways;
mod gait;
mod gallery;
mod ground;
mod hull;
mod lanes;
mod measures;
mod mover;
mod neighbours;
mod obstruction;
mod pedestrians;
mod piece;
mod plan;
mod polyline;
mod road_tags;
mod social_force;
mod streets;
#[cfg(test)]
mod tests;
mod walk_graph;
mod yielding;

use openbench_core::{MapPoint, Pose2};
use openbench_osm::OsmMap;

use crate::noise::Noise;
use cars::Cars;
use footways::walk_graph;
use ground::Ground;
use hull::{CAR_HALF_LENGTH_M, CAR_HALF_WIDTH_M};
use lanes::Lanes;
use pedestrians::{Pedestrians, Surroundings};

pub(crate) use gallery::{Gallery, car_figure};
pub use measures::{EncounterTotals, Encounters, INTIMATE_M, NEAR_MISS_S, PERSONAL_M};
pub use mover::{Hull, Mover, MoverKind, PERSON_RADIUS_M, RobotState};
pub use plan::TrafficPlan;
pub(crate) use yielding::RobotWatch;

/// The models' longest step, seconds; longer ones are divided.
const LONGEST_STEP_S: f64 = 0.05;
/// Longest time that is simulated in one call, seconds.
const LONGEST_CALL_S: f64 = 1.0;
/// Streams of random numbers, beside those of the sensors.
const PEOPLE_STREAM: u64 = 11;
const CARS_STREAM: u64 = 12;

/// People and cars in a map.
///
/// Twelve people on a stretch of the Hauptstraße in Heidelberg, for ten seconds:
///
/// ```
/// use openbench_core::MapPoint;
/// use openbench_osm::{OsmData, OsmMap};
/// use openbench_sim::traffic::{RobotState, Traffic, TrafficPlan};
///
/// let xml = "<osm version='0.6'>
///     <node id='1' lon='8.6950' lat='49.4100'/><node id='2' lon='8.6990' lat='49.4105'/>
///     <way id='3'><nd ref='1'/><nd ref='2'/><tag k='highway' v='pedestrian'/></way></osm>";
/// let data = OsmData::from_xml(xml.as_bytes())?;
/// let map = OsmMap::new(&data, "tangent:8.6950,49.4100".parse()?);
///
/// let plan = TrafficPlan { pedestrians: 12, cars: 0 };
/// let start = MapPoint::new(0.0, 20.0);
/// let mut traffic = Traffic::new(&map, |_| true, plan, start, 1);
/// assert_eq!(traffic.placed(), plan);
///
/// let before = traffic.movers()[0].pose.point();
/// let robot = RobotState { position: start, velocity: [0.0; 2], radius: 0.22 };
/// for _ in 0..200 {
///     traffic.step(0.05, robot);
/// }
/// let walked = before.distance(traffic.movers()[0].pose.point());
/// assert!(walked > 5.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Traffic {
    ground: Ground,
    pedestrians: Pedestrians,
    cars: Cars,
    movers: Vec<Mover>,
}

impl Traffic {
    /// Up to as many people and cars as in `plan`, at places drawn from `seed`; fewer where the map
    /// has no footways or roads for them, see [`placed`](Self::placed).
    ///
    /// `free` tells whether a disc of [`PERSON_RADIUS_M`] fits at a point. It is asked once for
    /// each cell of a grid within 300 m of `start`, the robot's place, near which nobody is placed.
    /// Cars also need it to be true on carriageways.
    pub fn new(
        map: &OsmMap,
        free: impl Fn(MapPoint) -> bool,
        plan: TrafficPlan,
        start: MapPoint,
        seed: u64,
    ) -> Self {
        let ground = Ground::new(map, free, start);
        let noise = Noise::new(seed, PEOPLE_STREAM);
        let footways = walk_graph(map, &ground);
        let pedestrians = Pedestrians::new(footways, &ground, plan.pedestrians, start, noise);
        let noise = Noise::new(seed, CARS_STREAM);
        let lanes = Lanes::new(map, &ground);
        let cars = Cars::new(lanes, plan.cars, start, &pedestrians, noise);
        let count = pedestrians.people.len() + cars.cars.len();
        let mut traffic = Self {
            ground,
            pedestrians,
            cars,
            movers: vec![Mover::absent(); count],
        };
        traffic.update_movers();
        traffic
    }

    /// How many people and cars there are, cars off the map included. They are fewer than planned
    /// where the map has too few footways or roads, or too little room on them.
    pub fn placed(&self) -> TrafficPlan {
        TrafficPlan {
            pedestrians: self.pedestrians.people.len(),
            cars: self.cars.cars.len(),
        }
    }

    /// All movers, people first; a mover keeps its index.
    pub fn movers(&self) -> &[Mover] {
        &self.movers
    }

    /// Moves all people and cars by `dt` seconds, at most 1. A step that is not a positive number
    /// does nothing. A robot whose state contains NaN or infinity is not seen.
    pub fn step(&mut self, dt: f64, robot: RobotState) {
        if dt.is_nan() || dt <= 0.0 {
            return;
        }
        let dt = dt.min(LONGEST_CALL_S);
        // A step of exactly the longest one must not be divided for its last bit.
        let parts = (dt / LONGEST_STEP_S - 1e-9).ceil().max(1.0);
        let robot = robot.sanitized();
        for _ in 0..parts as usize {
            // Cars first: people then see where the cars are now, and nobody walks into one.
            self.cars
                .step(dt / parts, &self.ground, &robot, &self.pedestrians);
            let around = Surroundings {
                ground: &self.ground,
                robot: &robot,
                cars: &self.cars.hulls,
                near_cars: &self.cars.near,
            };
            self.pedestrians.step(dt / parts, around);
        }
        self.update_movers();
    }

    fn update_movers(&mut self) {
        let (people, cars) = self.movers.split_at_mut(self.pedestrians.people.len());
        // The number of a mover selects its figure, so it looks the same for its whole life.
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
            // Cars move along their heading.
            let (sin, cos) = libm::sincos(hull.pose.yaw);
            *mover = Mover {
                kind: MoverKind::Car,
                present: car.present,
                pose: hull.pose,
                velocity: [cos * car.speed, sin * car.speed],
                hull: Hull::Box {
                    half_length: CAR_HALF_LENGTH_M,
                    half_width: CAR_HALF_WIDTH_M,
                },
                gait: 0.0,
                look,
            };
        }
    }
}
