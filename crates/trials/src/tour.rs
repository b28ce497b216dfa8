//! Drives round a world for the sake of what the sensors record: logs for odometry. The driver steers by the true pose; nothing of it is an agent.

use std::time::Duration;

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, SimTime, Velocity};
use openbench_scene::FreeSpace;
use openbench_sim::Simulator;
use openbench_sim::noise::Noise;
use openbench_sim::traffic::Hull;

use openbench_bench::{BenchError, Prepared};

/// Stands still that long at first, as robots do when they are switched on.
const STAND: Duration = Duration::from_secs(2);
/// Keeps so far from everything where there is room, metres.
const CLEARANCE: f64 = 0.6;
/// Steers for a point so far ahead on its way, and takes a place for reached that near, metres.
const AHEAD: f64 = 0.7;
/// Stops for people and cars so near in front, metres.
const STOP: f64 = 1.2;
/// Stops for the place it steers for only where the bearing is farther off than that, radians.
const TURN_ON_THE_SPOT: f64 = 0.7;
/// Streams of random numbers, beside those of sensors and traffic.
const STREAM: u64 = 31;

/// How the robot is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// As a delivery robot drives.
    Smooth,
    /// With full turns, swerves and stops as hard as the motors allow.
    Wild,
}

/// A drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Tour {
    /// How long.
    pub time: Duration,
    /// Where through, round and round; by default from door to door in an order drawn from the seed.
    pub via: Vec<MapPoint>,
    /// How.
    pub style: Style,
    /// What noise, traffic and order are drawn from.
    pub seed: u64,
}

/// What came of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Driven {
    /// Length of the way, metres.
    pub metres: f64,
    /// Bumps into something.
    pub collisions: usize,
}

/// Drives. `watch` is shown the robot after each step, with the velocity that was asked for.
pub fn drive(
    prepared: &Prepared,
    tour: &Tour,
    watch: &mut dyn FnMut(&Simulator, Velocity) -> Result<(), BenchError>,
) -> Result<Driven, BenchError> {
    let mut simulator = prepared.simulator(tour.seed)?;
    let mut driver = Driver::new(prepared, tour)?;
    let mut metres = 0.0;
    while simulator.time().since(SimTime::ZERO) < tour.time {
        let before = pose(&simulator).point();
        let velocity = if simulator.time().since(SimTime::ZERO) < STAND {
            Velocity::ZERO
        } else {
            driver.steer(&simulator)
        };
        simulator.step(velocity);
        metres += before.distance(pose(&simulator).point());
        watch(&simulator, velocity)?;
    }
    Ok(Driven {
        metres,
        collisions: simulator.collisions().len(),
    })
}

fn pose(simulator: &Simulator) -> Pose2 {
    Pose2::from_pose3(&simulator.base_link())
}

struct Driver<'a> {
    space: Space<'a>,
    places: Vec<MapPoint>,
    next: usize,
    path: Vec<MapPoint>,
    /// The part of the path that is driven.
    at: usize,
    style: Style,
    noise: Noise,
    /// What is done instead of following the path, and until when.
    antic: (Velocity, SimTime),
}

/// Where there is room, and where one gets at all.
struct Space<'a> {
    wide: FreeSpace,
    narrow: &'a FreeSpace,
}

impl Space<'_> {
    fn path(&self, from: MapPoint, to: MapPoint) -> Option<Vec<MapPoint>> {
        [&self.wide, self.narrow].into_iter().find_map(|space| {
            let near = |place| space.nearest_reachable(place, 2.0 * CLEARANCE);
            space.path(near(from)?, near(to)?)
        })
    }
}

impl<'a> Driver<'a> {
    fn new(prepared: &'a Prepared, tour: &Tour) -> Result<Self, BenchError> {
        let start = prepared.world.start.point();
        let wide = FreeSpace::new(prepared.stage.caster(), start, CLEARANCE);
        let space = Space {
            wide,
            narrow: &prepared.free_space,
        };
        let mut noise = Noise::new(tour.seed, STREAM);
        let places = if tour.via.is_empty() {
            doors(prepared, &mut noise)
        } else {
            tour.via.clone()
        };
        // In front of doors a robot stands where it gets to from the start.
        let missed = tour
            .via
            .iter()
            .find(|place| space.path(start, **place).is_none());
        let missed = missed.map(|place| format!("({:.1}, {:.1})", place.x, place.y));
        if let Some(place) = missed.or_else(|| places.is_empty().then(|| "any door".to_owned())) {
            return Err(BenchError::world(format!(
                "a robot cannot drive round here: nothing leads to {place}"
            )));
        }
        let antic = (Velocity::ZERO, SimTime::ZERO);
        Ok(Self {
            space,
            places,
            next: 0,
            path: Vec::new(),
            at: 0,
            style: tour.style,
            noise,
            antic,
        })
    }

    fn steer(&mut self, simulator: &Simulator) -> Velocity {
        let (here, time) = (pose(simulator), simulator.time());
        if blocked(simulator, here) {
            return Velocity::ZERO;
        }
        if self.style == Style::Wild
            && let Some(antic) = self.antic(time)
        {
            return antic;
        }
        let Some(target) = self.target(here.point()) else {
            return Velocity::new(0.0, 0.5);
        };
        let off = wrap_angle(here.point().bearing_to(target) - here.yaw);
        if off.abs() > TURN_ON_THE_SPOT {
            return Velocity::new(0.0, (2.0 * off).clamp(-1.0, 1.0));
        }
        Velocity::new(0.5 * libm::cos(off), (1.5 * off).clamp(-1.0, 1.0))
    }

    /// The point to steer for.
    fn target(&mut self, here: MapPoint) -> Option<MapPoint> {
        // Behind the path's end comes the next place; some may lie where the robot is already.
        for _ in 0..=self.places.len() {
            while self.at < self.path.len() && here.distance(self.path[self.at]) < AHEAD {
                self.at += 1;
            }
            if let Some(point) = self.path.get(self.at) {
                return Some(*point);
            }
            let place = self.places[self.next % self.places.len()];
            self.next += 1;
            self.at = 0;
            self.path = self
                .space
                .path(here, place)
                .map(|path| dense(&path))
                .unwrap_or_default();
        }
        None
    }

    /// What a wild driver does now.
    fn antic(&mut self, time: SimTime) -> Option<Velocity> {
        if time >= self.antic.1 {
            let long = |seconds: f64| time + Duration::from_secs_f64(seconds);
            let side = if self.noise.uniform() < 0.5 {
                1.0
            } else {
                -1.0
            };
            // Half the time it follows the path; full turns come back to where they began.
            self.antic = match (self.noise.uniform() * 8.0) as usize {
                0 | 1 => (Velocity::new(0.0, side), long(std::f64::consts::TAU)),
                2 => (Velocity::new(0.0, side), long(1.0)),
                3 => (Velocity::new(0.0, 0.0), long(0.5)),
                _ => (Velocity::new(f64::NAN, 0.0), long(2.0)),
            };
        }
        let velocity = self.antic.0;
        velocity.linear.is_finite().then_some(velocity)
    }
}

/// Points of a path no farther apart than what is steered for.
fn dense(path: &[MapPoint]) -> Vec<MapPoint> {
    let pieces = path.windows(2).flat_map(|pair| {
        let (a, b) = (pair[0], pair[1]);
        let count = (a.distance(b) / (0.5 * AHEAD)).ceil().max(1.0) as usize;
        (1..=count).map(move |i| {
            let s = i as f64 / count as f64;
            MapPoint::new(a.x + s * (b.x - a.x), a.y + s * (b.y - a.y))
        })
    });
    pieces.collect()
}

/// In front of all doors that can be reached, in an order drawn at random.
fn doors(prepared: &Prepared, noise: &mut Noise) -> Vec<MapPoint> {
    let mut places: Vec<MapPoint> = prepared.approach.iter().flatten().copied().collect();
    for i in (1..places.len()).rev() {
        places.swap(i, (noise.uniform() * (i + 1) as f64) as usize % (i + 1));
    }
    places
}

/// Whether somebody stands or comes in front of the robot.
fn blocked(simulator: &Simulator, here: Pose2) -> bool {
    simulator
        .movers()
        .iter()
        .filter(|mover| mover.present)
        .any(|mover| {
            let bearing = wrap_angle(here.point().bearing_to(mover.pose.point()) - here.yaw);
            let reach = match mover.hull {
                Hull::Disc { radius } => radius,
                Hull::Box { half_length, .. } => half_length,
            };
            here.point().distance(mover.pose.point()) < STOP + reach && bearing.abs() < 1.0
        })
}
