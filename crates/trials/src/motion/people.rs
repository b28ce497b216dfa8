//! Kilometres among people: OPEN's driver in the simulator, from door to door, with its LiDAR and wheels, and the true pose in place of a
//! localizer. Cameras, language and exploration are left out, so that kilometres are affordable.

use std::collections::BTreeMap;
use std::time::Duration;

use openbench_agents::open::driving::{Driver, Driving, Target};
use openbench_agents::open::parts::PartError;
use openbench_agents::open::perception::Perception;
use openbench_agents::open::terrain::Terrain;
use openbench_core::{Event, Events, MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_localization::Localizer;
use openbench_motion::LocalPlanner;
use openbench_motion::costmap::ground::Preferences;
use openbench_osm::OsmMap;
use openbench_sim::noise::Noise;
use openbench_sim::traffic::Encounters;
use openbench_sim::{Collision, OBSERVATION_NS, Simulator};
use serde::Serialize;

use openbench_bench::run::threads;
use openbench_bench::score::metrics::{
    CollisionSum, EncounterSum, SmoothnessSum, collisions, smoothness::Smoothness,
};
use openbench_bench::{BenchError, Prepared, TrafficPlan, TruthHandle, TruthLocalizer};

/// A drive is so long at most, metres,
const DRIVE: f64 = 500.0;
/// or takes so long at most.
const LIMIT: Duration = Duration::from_secs(3000);
/// Stream of random numbers, beside those of sensors and traffic.
const STREAM: u64 = 41;

/// Makes the local planner of a drive.
pub type MakePlanner<'a> =
    dyn Fn(&RobotDescription) -> Result<Box<dyn LocalPlanner>, PartError> + Sync + 'a;

/// What is driven.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// Kilometres at most, in drives of half a kilometre or less; drives that take too long end before.
    pub kilometres: f64,
    /// Seed of people, noise and the order of doors.
    pub seed: u64,
    /// Who drives.
    pub planner: &'a MakePlanner<'a>,
    /// How many drives at a time.
    pub threads: usize,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Among {
    /// People and cars that there were.
    pub traffic: TrafficPlan,
    /// Metres driven.
    pub metres: f64,
    /// Simulated seconds.
    pub seconds: f64,
    /// Doors that were reached.
    pub reached: usize,
    /// Doors that were given up.
    pub given_up: usize,
    /// Collisions by what was touched.
    pub collisions: BTreeMap<String, CollisionSum>,
    /// Encounters.
    pub encounters: EncounterSum,
    /// How smoothly the robot drove.
    pub smoothness: SmoothnessSum,
    /// Where and when collisions were, for a closer look.
    pub bumps: Vec<Bumped>,
}

/// A collision.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bumped {
    /// Number of the drive.
    pub drive: usize,
    /// Simulated seconds.
    pub seconds: f64,
    /// What was touched.
    pub class: String,
    /// How fast the robot was, m/s.
    pub speed_mps: f64,
    /// Whether it was the robot's fault, see [`CollisionSum`]: it drove, or had cut the other off.
    pub at_fault: bool,
    /// Where the robot was.
    pub pose: Pose2,
}

/// Drives; nothing but the time that it takes depends on the number of threads. `seen` is told of the end of each drive.
pub fn drive(
    prepared: &Prepared,
    request: &Request<'_>,
    seen: &mut dyn FnMut(),
) -> Result<Among, BenchError> {
    let drives = drives(request.kilometres);
    let course = Course::new(prepared)?;
    let parts = threads::each(
        0..drives,
        request.threads,
        |number| one(&course, request, number),
        |part| {
            seen();
            Ok::<_, BenchError>(part)
        },
    )?;
    let traffic = prepared
        .traffic(request.seed)
        .map(|t| t.placed())
        .unwrap_or_default();
    Ok(sum(traffic, parts.into_iter()))
}

/// How many drives a distance takes.
pub fn drives(kilometres: f64) -> usize {
    (kilometres * 1000.0 / DRIVE).ceil().max(1.0) as usize
}

fn one(course: &Course<'_>, request: &Request<'_>, number: usize) -> Result<Among, BenchError> {
    let planner = (request.planner)(&course.prepared.robot).map_err(BenchError::world)?;
    let seed = request.seed.wrapping_add((number as u64) << 32);
    let metres = 1000.0 * request.kilometres / drives(request.kilometres) as f64;
    Ok(Ride::new(course, planner, seed)?.ride(number, metres))
}

fn sum(traffic: TrafficPlan, parts: impl Iterator<Item = Among>) -> Among {
    parts.fold(nothing(traffic), |sum, part| Among {
        traffic,
        metres: sum.metres + part.metres,
        seconds: sum.seconds + part.seconds,
        reached: sum.reached + part.reached,
        given_up: sum.given_up + part.given_up,
        collisions: collisions::total([&sum.collisions, &part.collisions]),
        encounters: sum.encounters.and(part.encounters),
        smoothness: sum.smoothness.and(part.smoothness),
        bumps: [sum.bumps, part.bumps].concat(),
    })
}

fn nothing(traffic: TrafficPlan) -> Among {
    Among {
        traffic,
        metres: 0.0,
        seconds: 0.0,
        reached: 0,
        given_up: 0,
        collisions: BTreeMap::new(),
        encounters: EncounterSum::default(),
        smoothness: SmoothnessSum::default(),
        bumps: Vec::new(),
    }
}

/// Where drives lead.
struct Course<'a> {
    prepared: &'a Prepared,
    map: OsmMap,
    /// Before the doors that can be reached.
    places: Vec<MapPoint>,
}

impl<'a> Course<'a> {
    fn new(prepared: &'a Prepared) -> Result<Self, BenchError> {
        let places: Vec<MapPoint> = prepared.approach.iter().flatten().copied().collect();
        if places.len() < 2 {
            let why = "fewer than two doors can be reached: there is nowhere to drive";
            return Err(BenchError::world(why));
        }
        Ok(Self {
            prepared,
            map: prepared.osm_map(),
            places,
        })
    }

    fn terrain(&self) -> Result<Terrain, BenchError> {
        let Prepared { world, robot, .. } = self.prepared;
        Terrain::new(
            self.map.clone(),
            None,
            world.start.point(),
            robot,
            Preferences::NONE,
        )
        .map_err(BenchError::world)
    }

    /// One of the places, but not where the robot is.
    fn draw(&self, here: MapPoint, noise: &mut Noise) -> MapPoint {
        let others: Vec<MapPoint> = self
            .places
            .iter()
            .copied()
            .filter(|p| p.distance(here) > 1.0)
            .collect();
        let from = if others.is_empty() {
            &self.places
        } else {
            &others
        };
        from[((noise.uniform() * from.len() as f64) as usize).min(from.len() - 1)]
    }
}

/// Nobody listens.
struct Deaf;

impl Events for Deaf {
    fn record(&mut self, _event: Event) {}
}

/// A drive through a course.
struct Ride<'a> {
    course: &'a Course<'a>,
    simulator: Simulator,
    driver: Driver,
    handle: TruthHandle,
    localizer: TruthLocalizer,
    perception: Perception,
    noise: Noise,
    sets_out: bool,
    encounters: Encounters,
    smoothness: Smoothness,
    among: Among,
}

impl<'a> Ride<'a> {
    fn new(
        course: &'a Course<'a>,
        planner: Box<dyn LocalPlanner>,
        seed: u64,
    ) -> Result<Self, BenchError> {
        let (prepared, handle) = (course.prepared, TruthHandle::default());
        let simulator = prepared.simulator(seed)?;
        handle.set(simulator.time(), pose(&simulator));
        let driver = Driver::new(course.terrain()?, prepared.robot.clone(), planner);
        Ok(Self {
            course,
            simulator,
            driver: driver.map_err(BenchError::world)?,
            localizer: TruthLocalizer::new(handle.clone()),
            handle,
            perception: Perception::new(prepared.robot.clone()),
            noise: Noise::new(seed, STREAM),
            sets_out: true,
            encounters: Encounters::new(),
            smoothness: Smoothness::default(),
            among: nothing(TrafficPlan::default()),
        })
    }

    /// To the drive's end.
    fn ride(mut self, number: usize, metres: f64) -> Among {
        while self.among.metres < metres && self.simulator.time().since(SimTime::ZERO) < LIMIT {
            self.sense();
            let velocity = self.decide();
            self.step(velocity);
        }
        let collisions = self.simulator.collisions();
        self.among.seconds = self.simulator.time().seconds();
        self.among.encounters = self.encounters.totals().into();
        self.among.smoothness = self.smoothness.sum();
        self.among.collisions =
            collisions::by_class(collisions.iter().map(|c| (c.class.name(), c.into())));
        self.among.bumps = collisions.iter().map(|c| Bumped::of(c, number)).collect();
        self.among
    }

    fn sense(&mut self) {
        let observation = self.simulator.observation();
        self.localizer.update(&observation);
        self.driver.observe_wheels(observation.wheels);
        if let Some(scan) = observation.scan {
            self.driver.observe(
                &self.perception.observe(scan, &self.localizer),
                observation.time,
            );
        }
    }

    fn decide(&mut self) -> Velocity {
        let (here, now) = (self.localizer.pose(), self.simulator.time());
        if std::mem::take(&mut self.sets_out) {
            let point = self.course.draw(here.point(), &mut self.noise);
            self.driver.set_target(Target {
                point,
                yaw: None,
                must: true,
            });
        }
        match self.driver.drive(here, now, &mut Deaf) {
            Driving::OnTheWay(velocity) => return velocity,
            Driving::Arrived => self.among.reached += 1,
            Driving::Unreachable => self.among.given_up += 1,
        }
        self.sets_out = true;
        Velocity::ZERO
    }

    fn step(&mut self, velocity: Velocity) {
        let (before, seconds) = (pose(&self.simulator), OBSERVATION_NS as f64 * 1e-9);
        self.simulator.step(velocity);
        let now = pose(&self.simulator);
        self.handle.set(self.simulator.time(), now);
        self.among.metres += before.point().distance(now.point());
        self.smoothness.step(before, now, seconds);
        self.encounters.update(
            seconds,
            &self.simulator.robot_state(),
            self.simulator.movers(),
        );
    }
}

impl Bumped {
    fn of(collision: &Collision, drive: usize) -> Self {
        Self {
            drive,
            seconds: collision.time.seconds(),
            class: collision.class.name().to_owned(),
            speed_mps: collision.speed,
            at_fault: collisions::Bump::from(collision).is_at_fault(),
            pose: collision.pose,
        }
    }
}

fn pose(simulator: &Simulator) -> Pose2 {
    Pose2::from_pose3(&simulator.base_link())
}
