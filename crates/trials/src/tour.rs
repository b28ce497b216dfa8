//! Drives through a world that produce sensor logs, for odometry. The driver uses the true pose and
//! is not an agent.

use std::ops::ControlFlow;
use std::time::Duration;

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, SimTime, Velocity};
use openbench_scene::FreeSpace;
use openbench_sim::Simulator;
use openbench_sim::noise::Noise;
use openbench_sim::traffic::Hull;

use openbench_bench::{BenchError, Prepared};

/// Usual [`Tour::standstill`], as after a robot is switched on.
pub const STANDSTILL: Duration = Duration::from_secs(2);
/// Distance to obstacles where there is space.
const CLEARANCE_M: f64 = 0.6;
/// Lookahead distance on the path, and distance at which a place counts as reached.
const LOOKAHEAD_M: f64 = 0.7;
/// Distance at which the robot stops for people and cars in front of it.
const STOP_DISTANCE_M: f64 = 1.2;
/// Bearing of the target, relative to the heading, above which the robot turns on the spot.
const TURN_ON_SPOT_RAD: f64 = 0.7;
/// Stream of random numbers, distinct from those of sensors and traffic.
const RANDOM_STREAM: u64 = 31;

/// The style of driving.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// Smooth, like a delivery robot.
    Smooth,
    /// With full turns, swerves and stops at the limits of the motors.
    Wild,
}

/// The parameters of a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Tour {
    /// Simulated duration.
    pub time: Duration,
    /// Places to visit cyclically, in the `map` frame; if empty, the doors in random order.
    pub via: Vec<MapPoint>,
    /// Style of driving.
    pub style: Style,
    /// Seed of noise, traffic and order.
    pub seed: u64,
    /// Initial time without motion; part of `time`.
    pub standstill: Duration,
}

/// The result of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Driven {
    /// Driven distance, metres.
    pub metres: f64,
    /// Number of collisions.
    pub collisions: usize,
}

/// What is done after a step: the drive goes on or ends, or fails.
pub type Watched = Result<ControlFlow<()>, BenchError>;

/// Drives a tour. `watch` is called after each step of 50 ms with the commanded velocity, and may
/// end the drive.
///
/// ```
/// use std::ops::ControlFlow;
/// use std::time::Duration;
///
/// use openbench_bench::{Prepared, builtin_suite};
/// use openbench_trials::tour::{STANDSTILL, Style, Tour, drive};
///
/// let prepared = Prepared::world_of(builtin_suite("small")?)?;
/// let tour = Tour {
///     time: Duration::from_secs(4),
///     via: Vec::new(),
///     style: Style::Smooth,
///     seed: 1,
///     standstill: STANDSTILL,
/// };
/// let mut scans = 0;
/// let driven = drive(&prepared, &tour, &mut |simulator, _| {
///     scans += usize::from(simulator.observation().scan.is_some());
///     Ok(ControlFlow::Continue(()))
/// })?;
/// // Two seconds of standstill, then at most 0.5 m/s; ten scans a second.
/// assert!(driven.metres < 1.05 && (38..=41).contains(&scans));
/// # Ok::<(), openbench_bench::BenchError>(())
/// ```
///
/// # Errors
/// A place that cannot be reached, or an error of `watch`.
pub fn drive(
    prepared: &Prepared,
    tour: &Tour,
    watch: &mut dyn FnMut(&Simulator, Velocity) -> Watched,
) -> Result<Driven, BenchError> {
    let mut simulator = prepared.simulator(tour.seed)?;
    let mut driver = Driver::new(prepared, tour)?;
    let mut metres = 0.0;
    while simulator.time().since(SimTime::ZERO) < tour.time {
        let before = pose(&simulator).point();
        let velocity = if simulator.time().since(SimTime::ZERO) < tour.standstill {
            Velocity::ZERO
        } else {
            driver.steer(&simulator)
        };
        simulator.step(velocity);
        metres += before.distance(pose(&simulator).point());
        if watch(&simulator, velocity)?.is_break() {
            break;
        }
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
    /// Index of the next point of the path.
    at: usize,
    style: Style,
    noise: Noise,
    /// The current maneuver of the wild style.
    maneuver: Maneuver,
}

/// A velocity that replaces path following for some time.
#[derive(Debug, Clone, Copy)]
struct Maneuver {
    /// The velocity; `None` follows the path.
    velocity: Option<Velocity>,
    until: SimTime,
}

/// Free space with the preferred clearance, and with that of the robot.
struct Space<'a> {
    wide: FreeSpace,
    narrow: &'a FreeSpace,
}

impl Space<'_> {
    fn path(&self, from: MapPoint, to: MapPoint) -> Option<Vec<MapPoint>> {
        [&self.wide, self.narrow].into_iter().find_map(|space| {
            // Start and destination may be nearer to obstacles than the clearance: the path then
            // leads from and to the nearest free place.
            let near = |place| space.nearest_reachable(place, 2.0 * CLEARANCE_M);
            space.path(near(from)?, near(to)?)
        })
    }
}

impl<'a> Driver<'a> {
    fn new(prepared: &'a Prepared, tour: &Tour) -> Result<Self, BenchError> {
        let start = prepared.world.start.point();
        let wide = FreeSpace::new(prepared.stage.caster(), start, CLEARANCE_M);
        let space = Space {
            wide,
            narrow: &prepared.free_space,
        };
        let mut noise = Noise::new(tour.seed, RANDOM_STREAM);
        let places = if tour.via.is_empty() {
            doors(prepared, &mut noise)
        } else {
            tour.via.clone()
        };
        // Approach points of doors can be reached by definition.
        let missed = tour
            .via
            .iter()
            .find(|place| space.path(start, **place).is_none());
        let missed = missed.map(|place| format!("({:.1}, {:.1})", place.x, place.y));
        if let Some(place) = missed.or_else(|| places.is_empty().then(|| "any door".to_owned())) {
            return Err(BenchError::world(format!(
                "a robot cannot drive a tour here: no path leads to {place}"
            )));
        }
        let maneuver = Maneuver {
            velocity: None,
            until: SimTime::ZERO,
        };
        Ok(Self {
            space,
            places,
            next: 0,
            path: Vec::new(),
            at: 0,
            style: tour.style,
            noise,
            maneuver,
        })
    }

    fn steer(&mut self, simulator: &Simulator) -> Velocity {
        let (here, time) = (pose(simulator), simulator.time());
        if blocked(simulator, here) {
            return Velocity::ZERO;
        }
        if self.style == Style::Wild
            && let Some(velocity) = self.maneuver(time)
        {
            return velocity;
        }
        let Some(target) = self.target(here.point()) else {
            return Velocity::new(0.0, 0.5);
        };
        // The robot's limits are 0.5 m/s and 1 rad/s. Towards the side it drives more slowly, and
        // far to the side it only turns.
        let bearing = wrap_angle(here.point().bearing_to(target) - here.yaw);
        if bearing.abs() > TURN_ON_SPOT_RAD {
            return Velocity::new(0.0, (2.0 * bearing).clamp(-1.0, 1.0));
        }
        Velocity::new(0.5 * libm::cos(bearing), (1.5 * bearing).clamp(-1.0, 1.0))
    }

    /// The point to steer towards; `None` if no place can be reached.
    fn target(&mut self, here: MapPoint) -> Option<MapPoint> {
        // After the end of the path comes the next place; some may be where the robot already is.
        for _ in 0..=self.places.len() {
            while self.at < self.path.len() && here.distance(self.path[self.at]) < LOOKAHEAD_M {
                self.at += 1;
            }
            if let Some(point) = self.path.get(self.at) {
                return Some(*point);
            }
            let place = self.places[self.next % self.places.len()];
            self.next += 1;
            self.at = 0;
            // A place without a path leaves the path empty, so the loop tries the next one.
            self.path = self
                .space
                .path(here, place)
                .map(|path| dense(&path))
                .unwrap_or_default();
        }
        None
    }

    /// The velocity of the wild style; `None` where it follows the path.
    fn maneuver(&mut self, time: SimTime) -> Option<Velocity> {
        if time >= self.maneuver.until {
            let side = if self.noise.uniform() < 0.5 {
                1.0
            } else {
                -1.0
            };
            // It follows the path half of the time. Full turns end at the initial heading.
            let turn = Some(Velocity::new(0.0, side));
            let (velocity, seconds) = match (self.noise.uniform() * 8.0) as usize {
                0 | 1 => (turn, std::f64::consts::TAU),
                2 => (turn, 1.0),
                3 => (Some(Velocity::ZERO), 0.5),
                _ => (None, 2.0),
            };
            self.maneuver = Maneuver {
                velocity,
                until: time + Duration::from_secs_f64(seconds),
            };
        }
        self.maneuver.velocity
    }
}

/// A path with additional points, at distances of at most half the lookahead.
fn dense(path: &[MapPoint]) -> Vec<MapPoint> {
    let pieces = path.windows(2).flat_map(|pair| {
        let (a, b) = (pair[0], pair[1]);
        let count = (a.distance(b) / (0.5 * LOOKAHEAD_M)).ceil().max(1.0) as usize;
        (1..=count).map(move |i| {
            let s = i as f64 / count as f64;
            MapPoint::new(a.x + s * (b.x - a.x), a.y + s * (b.y - a.y))
        })
    });
    pieces.collect()
}

/// The approach points of all reachable doors, in random order.
fn doors(prepared: &Prepared, noise: &mut Noise) -> Vec<MapPoint> {
    let mut places: Vec<MapPoint> = prepared.approach.iter().flatten().copied().collect();
    for i in (1..places.len()).rev() {
        // Fisher-Yates. The remainder keeps the index in range, however the product is rounded.
        places.swap(i, (noise.uniform() * (i + 1) as f64) as usize % (i + 1));
    }
    places
}

/// Whether a person or car is close in front of the robot.
///
/// The robot does not stop for those beside or behind it: among many people it would never move.
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
            here.point().distance(mover.pose.point()) < STOP_DISTANCE_M + reach
                && bearing.abs() < 1.0
        })
}
