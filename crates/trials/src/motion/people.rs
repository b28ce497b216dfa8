//! Long drives among people: OPEN's driver in the simulator, from door to door.
//!
//! It uses the LiDAR, the wheels, and the true pose instead of a localizer. Camera, language and
//! exploration are left out, so that kilometres can be simulated in acceptable time.

use std::collections::BTreeMap;
use std::time::Duration;

use openbench_agents::open::driving::{Driver, Driving, Target};
use openbench_agents::open::parts::PartError;
use openbench_agents::open::perception::Perception;
use openbench_agents::open::terrain::Terrain;
use openbench_core::{Event, Events, MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_localization::Localizer;
use openbench_motion::LocalPlanner;
use openbench_motion::costmap::Preferences;
use openbench_sim::noise::Noise;
use openbench_sim::traffic::Encounters;
use openbench_sim::{Collision, OBSERVATION_NS, Simulator};
use serde::Serialize;

use openbench_bench::run::threads;
use openbench_bench::score::metrics::{CollisionSum, EncounterSum, collisions};
use openbench_bench::trace::{Smoothness, SmoothnessSum};
use openbench_bench::yardsticks::TruthLocalizer;
use openbench_bench::{BenchError, Prepared, TrafficPlan, TruthHandle};

/// Maximum length of a drive: short enough for many, which run on several threads.
const MAX_DRIVE_M: f64 = 500.0;
/// Maximum duration of a drive, simulated.
const MAX_DRIVE_TIME: Duration = Duration::from_secs(3000);
/// Stream of random numbers, distinct from those of sensors and traffic.
const RANDOM_STREAM: u64 = 41;

/// Creates the local planner of a drive.
pub type MakePlanner<'a> =
    dyn Fn(&RobotDescription) -> Result<Box<dyn LocalPlanner>, PartError> + Sync + 'a;

/// The parameters of the experiment.
#[derive(Clone, Copy)]
pub struct PeopleRequest<'a> {
    /// Total distance, kilometres, in drives of at most half a kilometre; drives that take too long
    /// end earlier.
    pub kilometres: f64,
    /// Seed of people, noise and the order of doors.
    pub seed: u64,
    /// The local planner.
    pub planner: &'a MakePlanner<'a>,
    /// Number of threads.
    pub threads: usize,
}

/// The result of the experiment.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PeopleResult {
    /// Number of people and cars.
    pub traffic: TrafficPlan,
    /// Driven distance, metres.
    pub metres: f64,
    /// Simulated time, seconds.
    pub seconds: f64,
    /// Number of doors that were reached.
    pub reached: usize,
    /// Number of doors that were given up.
    pub given_up: usize,
    /// Collisions by class of the object that was hit.
    pub collisions: BTreeMap<String, CollisionSum>,
    /// Encounters with people and cars.
    pub encounters: EncounterSum,
    /// Smoothness of the drives.
    pub smoothness: SmoothnessSum,
    /// Time and place of each collision.
    pub bumps: Vec<CollisionRecord>,
}

/// Time and place of a collision.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CollisionRecord {
    /// Number of the drive, from 0.
    pub drive: usize,
    /// Simulated time, seconds.
    pub seconds: f64,
    /// Class of the object that was hit.
    pub class: String,
    /// Speed of the robot before the collision, m/s.
    pub speed_mps: f64,
    /// Whether the robot was at fault, see [`CollisionSum`]: it drove into the object or had cut it
    /// off.
    pub at_fault: bool,
    /// Pose of the robot.
    pub pose: Pose2,
}

/// Runs all drives. The result does not depend on the number of threads. `seen` is called after
/// each drive.
///
/// # Errors
/// A world with fewer than two reachable doors, or a planner that cannot be created.
pub fn drive(
    prepared: &Prepared,
    request: &PeopleRequest<'_>,
    seen: &mut dyn FnMut(),
) -> Result<PeopleResult, BenchError> {
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
    // Of the first drive, which has the seed of the request. Others may have space for a different
    // number.
    let traffic = prepared
        .traffic(request.seed)
        .map(|t| t.placed())
        .unwrap_or_default();
    Ok(sum(traffic, parts.into_iter()))
}

/// Number of drives for a total distance.
pub fn drives(kilometres: f64) -> usize {
    (kilometres * 1000.0 / MAX_DRIVE_M).ceil().max(1.0) as usize
}

fn one(
    course: &Course<'_>,
    request: &PeopleRequest<'_>,
    number: usize,
) -> Result<PeopleResult, BenchError> {
    let planner = (request.planner)(&course.prepared.robot).map_err(BenchError::world)?;
    // In the upper half, so that the drives of neighbouring seeds share none.
    let seed = request.seed.wrapping_add((number as u64) << 32);
    let metres = 1000.0 * request.kilometres / drives(request.kilometres) as f64;
    Ok(Ride::new(course, planner, seed)?.ride(number, metres))
}

fn sum(traffic: TrafficPlan, parts: impl Iterator<Item = PeopleResult>) -> PeopleResult {
    // The parts are in the order of their numbers, so the sums do not depend on the threads.
    parts.fold(nothing(traffic), |sum, part| PeopleResult {
        traffic,
        metres: sum.metres + part.metres,
        seconds: sum.seconds + part.seconds,
        reached: sum.reached + part.reached,
        given_up: sum.given_up + part.given_up,
        collisions: collisions::total([&sum.collisions, &part.collisions]),
        encounters: sum.encounters.plus(part.encounters),
        smoothness: sum.smoothness.plus(part.smoothness),
        bumps: [sum.bumps, part.bumps].concat(),
    })
}

fn nothing(traffic: TrafficPlan) -> PeopleResult {
    PeopleResult {
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

/// The destinations of the drives.
struct Course<'a> {
    prepared: &'a Prepared,
    /// The approach points of the reachable doors.
    places: Vec<MapPoint>,
}

impl<'a> Course<'a> {
    fn new(prepared: &'a Prepared) -> Result<Self, BenchError> {
        let places: Vec<MapPoint> = prepared.approach.iter().flatten().copied().collect();
        if places.len() < 2 {
            let why = "fewer than two doors can be reached, so there is no route to drive; use \
                       another world";
            return Err(BenchError::world(why));
        }
        Ok(Self { prepared, places })
    }

    fn terrain(&self) -> Result<Terrain, BenchError> {
        let Prepared { world, robot, .. } = self.prepared;
        Terrain::new(
            self.prepared.true_map().clone(),
            None,
            world.start.point(),
            robot,
            // All ground alike, as OPEN drives by default.
            Preferences::NONE,
        )
        .map_err(BenchError::world)
    }

    /// A random destination more than 1 m away from the robot.
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
        // The minimum keeps the index in range, however the product is rounded.
        from[((noise.uniform() * from.len() as f64) as usize).min(from.len() - 1)]
    }
}

/// Discards all events.
struct DiscardEvents;

impl Events for DiscardEvents {
    fn record(&mut self, _event: Event) {}
}

/// One drive from door to door.
struct Ride<'a> {
    course: &'a Course<'a>,
    simulator: Simulator,
    driver: Driver,
    handle: TruthHandle,
    localizer: TruthLocalizer,
    perception: Perception,
    noise: Noise,
    needs_target: bool,
    encounters: Encounters,
    smoothness: Smoothness,
    result: PeopleResult,
}

impl<'a> Ride<'a> {
    fn new(
        course: &'a Course<'a>,
        planner: Box<dyn LocalPlanner>,
        seed: u64,
    ) -> Result<Self, BenchError> {
        let (prepared, handle) = (course.prepared, TruthHandle::default());
        let simulator = prepared.simulator(seed)?;
        // The localizer is asked for a pose before the first step.
        handle.store(&simulator);
        let driver = Driver::new(course.terrain()?, prepared.robot.clone(), planner);
        Ok(Self {
            course,
            simulator,
            driver: driver.map_err(BenchError::world)?,
            localizer: TruthLocalizer::new(handle.clone().into()),
            handle,
            perception: Perception::new(prepared.robot.clone()),
            noise: Noise::new(seed, RANDOM_STREAM),
            needs_target: true,
            encounters: Encounters::new(),
            smoothness: Smoothness::default(),
            result: nothing(TrafficPlan::default()),
        })
    }

    /// Drives until the distance or the maximum time is reached.
    fn ride(mut self, number: usize, metres: f64) -> PeopleResult {
        while self.result.metres < metres
            && self.simulator.time().since(SimTime::ZERO) < MAX_DRIVE_TIME
        {
            self.sense();
            let velocity = self.decide();
            self.step(velocity);
        }
        let collisions = self.simulator.collisions();
        self.result.seconds = self.simulator.time().seconds();
        self.result.encounters = self.encounters.totals().into();
        self.result.smoothness = self.smoothness.sum();
        self.result.collisions =
            collisions::by_class(collisions.iter().map(|c| (c.class.name(), c.into())));
        self.result.bumps = collisions
            .iter()
            .map(|c| CollisionRecord::of(c, number))
            .collect();
        self.result
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
        if std::mem::take(&mut self.needs_target) {
            let point = self.course.draw(here.point(), &mut self.noise);
            self.driver.set_target(Target {
                point,
                yaw: None,
                // However long the path is: distance is what the drive is for.
                must: true,
            });
        }
        match self.driver.drive(here, now, &mut DiscardEvents) {
            Driving::OnTheWay(velocity) => return velocity,
            Driving::Arrived => self.result.reached += 1,
            Driving::Unreachable => self.result.given_up += 1,
        }
        self.needs_target = true;
        Velocity::ZERO
    }

    fn step(&mut self, velocity: Velocity) {
        let (before, seconds) = (pose(&self.simulator), OBSERVATION_NS as f64 * 1e-9);
        self.simulator.step(velocity);
        let now = pose(&self.simulator);
        self.handle.store(&self.simulator);
        self.result.metres += before.point().distance(now.point());
        self.smoothness.step(before, now, seconds);
        self.encounters.update(
            seconds,
            &self.simulator.robot_state(),
            self.simulator.movers(),
        );
    }
}

impl CollisionRecord {
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
