//! Model Predictive Path Integral control: many disturbed continuations of the last plan, averaged by what they cost.
//!
//! G. Williams, A. Aldrich, E. Theodorou, *Model Predictive Path Integral Control: From Theory to Parallel Computation*, Journal of Guidance, Control, and Dynamics 40(2), 2017; the costs are of the kinds that Nav2's controller
//! of this name has: distance to the way and to its end, heading, nearness to obstacles, driving backwards. Here as a yardstick for the band: disturbances come from a seeded generator.

use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity, frames::wrap_angle};
use openbench_grid::GridGeometry;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::checks::SettingsError;
use crate::feasible::{clearance, conflict_before_stop};
use crate::kinematics::Motion;
use crate::limits::Limits;
use crate::local::{Blocked, Entry, LocalPlanner, PathPoint, PlannerSettings, Progress, Situation, ahead};
use crate::near_cells::each_cell_near;
use crate::shape::{Footprint, Obstacle, ShapeError};

/// Continuations in a cycle.
const SAMPLES: usize = 600;
/// Steps of each.
const STEPS: usize = 32;
/// Seconds of a step.
const DT: f64 = 0.1;
/// Deviations of speed and turn rate.
const NOISE: (f64, f64) = (0.15, 0.4);
/// How sharply cheap continuations are preferred.
const TEMPERATURE: f64 = 0.3;
/// Length of the way that is looked at, metres.
const LOOKAHEAD: f64 = 1.6;
/// Distance from the footprint's circle above which obstacles cost nothing, metres.
const COMFORT: f64 = 0.25;
/// Cost of touching something.
const TOUCH: f64 = 1000.0;
/// Side of a cell of the map of distances, and how far it reaches, metres.
const GRID: (f64, f64) = (0.05, 2.0);
/// Distance from obstacles that a command has to keep, metres.
const SURE: f64 = 0.003;
/// Slower than this, m/s and rad/s, is as good as standing: the controller sees no way on.
const STILL: (f64, f64) = (0.02, 0.05);
/// Seconds that a command is held.
const HOLD: f64 = 0.1;

/// A controller cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MppiError {
    /// A limit makes no sense.
    #[error(transparent)]
    Limits(#[from] SettingsError),
    /// The footprint is none.
    #[error(transparent)]
    Footprint(#[from] ShapeError),
}

/// Its entry among the local planners.
pub fn entry() -> Entry {
    Entry::new("mppi", "Model Predictive Path Integral control", |settings: &PlannerSettings| {
        Mppi::new(&settings.robot, settings.seed)
    })
}

/// The controller.
#[derive(Debug, Clone)]
pub struct Mppi {
    footprint: Footprint,
    limits: Limits,
    tolerance: f64,
    yaw_tolerance: f64,
    rng: Pcg64Mcg,
    seed: u64,
    plan: Vec<Velocity>,
    /// When the plan was last moved on, and the seconds of its first step that are over.
    last: Option<SimTime>,
    over: f64,
    samples: Vec<[Velocity; STEPS]>,
    costs: Vec<f64>,
    distances: Vec<f32>,
}

impl Mppi {
    /// A controller for a robot whose disturbances are those of a seed.
    pub fn new(robot: &RobotDescription, seed: u64) -> Result<Self, MppiError> {
        Ok(Self {
            footprint: Footprint::of(robot)?,
            limits: Limits::of(robot)?,
            tolerance: 0.1,
            yaw_tolerance: 0.08,
            rng: Pcg64Mcg::seed_from_u64(seed),
            seed,
            plan: vec![Velocity::ZERO; STEPS],
            last: None,
            over: 0.0,
            samples: vec![[Velocity::ZERO; STEPS]; SAMPLES],
            costs: vec![0.0; SAMPLES],
            distances: Vec::new(),
        })
    }

    /// Distances to what stands, around the robot.
    fn measure(&mut self, situation: &Situation<'_>) -> GridGeometry {
        let here = situation.pose.point();
        let low = MapPoint::new(here.x - GRID.1, here.y - GRID.1);
        let high = MapPoint::new(here.x + GRID.1, here.y + GRID.1);
        let grid = GridGeometry::covering(low, high, GRID.0, 1000);
        let reach = self.footprint.circumscribed() + COMFORT;
        self.distances.clear();
        self.distances.resize(grid.len(), reach as f32);
        for obstacle in situation.obstacles.iter().filter(|o| !o.is_moving()) {
            each_cell_near(&grid, obstacle, reach, |cell, distance| {
                self.distances[cell] = self.distances[cell].min(distance as f32);
            });
        }
        grid
    }

    /// Drops the steps of the plan that are over by now.
    fn move_on(&mut self, now: SimTime) {
        let elapsed = self.last.map_or(0.0, |last| now.since(last).as_secs_f64());
        self.last = Some(now);
        self.over += elapsed;
        while self.over > DT - 1e-9 {
            self.over -= DT;
            self.plan.rotate_left(1);
            self.plan[STEPS - 1] = self.plan[STEPS - 2];
            // After a long pause nothing is left of the plan anyway.
            self.over = self.over.min(DT * STEPS as f64);
        }
    }

    fn sample(&mut self) {
        for sample in &mut self.samples {
            for (velocity, planned) in sample.iter_mut().zip(&self.plan) {
                let (v, w) = normal_pair(&mut self.rng);
                *velocity = Velocity::new(
                    (planned.linear + NOISE.0 * v).clamp(-self.limits.backward, self.limits.forward),
                    (planned.angular + NOISE.1 * w).clamp(-self.limits.turn, self.limits.turn),
                );
            }
        }
    }

    fn cost(
        &self,
        sample: &[Velocity; STEPS],
        situation: &Situation<'_>,
        grid: &GridGeometry,
        aim: &Aim,
    ) -> f64 {
        let mut motion =
            Motion { pose: situation.pose, velocity: situation.velocity, command: Velocity::ZERO };
        let mut cost = 0.0;
        for (i, command) in sample.iter().enumerate() {
            motion.command = *command;
            motion.step(&self.limits, DT);
            cost += self.nearness(motion.pose, (i + 1) as f64 * DT, situation.obstacles, grid);
            cost += 0.3 * (-motion.velocity.linear).max(0.0) + 0.02 * motion.velocity.angular.abs();
            cost += aim.way_cost(motion.pose);
        }
        cost + aim.end_cost(motion.pose)
    }

    fn nearness(&self, pose: Pose2, time: f64, obstacles: &[Obstacle], grid: &GridGeometry) -> f64 {
        let (inner, outer) = (self.footprint.inscribed(), self.footprint.circumscribed());
        let standing = grid.cell_at(pose.point()).map_or(outer + COMFORT, |c| f64::from(self.distances[c]));
        let moving = obstacles.iter().filter(|o| o.is_moving()).map(|o| {
            let v = o.velocity();
            o.distance_to(MapPoint::new(pose.x - v.x * time, pose.y - v.y * time))
        });
        let distance = moving.fold(standing, f64::min);
        let touches = |o: &Obstacle| {
            let contact = o.contact(&self.footprint.at(pose), outer, time, 0.0);
            contact.is_some_and(|c| c.distance <= 0.0)
        };
        if distance < inner - GRID.0 || distance < outer + GRID.0 && obstacles.iter().any(touches) {
            return TOUCH;
        }
        let near = ((outer + COMFORT - distance) / COMFORT).max(0.0);
        0.2 * near * near
    }

    /// The mean of all continuations, each weighed by what it costs more than the cheapest.
    fn average(&mut self) {
        let least = self.costs.iter().copied().fold(f64::INFINITY, f64::min);
        let mut sum = 0.0;
        self.plan.fill(Velocity::ZERO);
        for (sample, cost) in self.samples.iter().zip(&self.costs) {
            let weight = libm::exp(-(cost - least) / TEMPERATURE);
            sum += weight;
            for (planned, velocity) in self.plan.iter_mut().zip(sample) {
                planned.linear += weight * velocity.linear;
                planned.angular += weight * velocity.angular;
            }
        }
        self.plan.iter_mut().for_each(|v| *v = Velocity::new(v.linear / sum, v.angular / sum));
    }

    fn nearest(&self, situation: &Situation<'_>) -> f64 {
        clearance(&self.footprint, situation.obstacles.iter(), situation.pose, 0.0, GRID.1).max(0.0)
    }

    fn secured(&self, situation: &Situation<'_>, wanted: Velocity) -> Result<Progress, Blocked> {
        for share in [1.0, 0.6, 0.3, 0.1] {
            let command = Velocity::new(share * wanted.linear, share * wanted.angular);
            let motion = Motion { pose: situation.pose, velocity: situation.velocity, command };
            let (footprint, obstacles) = (&self.footprint, situation.obstacles);
            if conflict_before_stop(footprint, obstacles, motion, &self.limits, HOLD, SURE).is_none() {
                let cause = || Blocked::Obstacle(self.nearest(situation));
                return Ok(if share < 1.0 {
                    Progress::Slowed(command, cause())
                } else {
                    Progress::Drive(command)
                });
            }
        }
        Err(Blocked::Obstacle(self.nearest(situation)))
    }
}

impl LocalPlanner for Mppi {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Progress, Blocked> {
        situation.check()?;
        let aim = Aim::of(situation);
        let turn = situation.final_yaw.map_or(0.0, |yaw| wrap_angle(yaw - situation.pose.yaw));
        let there = aim.last && situation.pose.point().distance(aim.end) <= self.tolerance;
        if there && turn.abs() <= self.yaw_tolerance {
            return Ok(Progress::Arrived);
        }
        if there {
            let rate = (2.0 * turn.abs()).max(0.1).min(self.limits.turn).copysign(turn);
            return self.secured(situation, Velocity::new(0.0, rate));
        }
        let grid = self.measure(situation);
        self.move_on(situation.time);
        self.sample();
        for i in 0..SAMPLES {
            self.costs[i] = self.cost(&self.samples[i], situation, &grid, &aim);
        }
        self.average();
        if self.plan[0].linear.abs() < STILL.0 && self.plan[0].angular.abs() < STILL.1 {
            return Err(Blocked::Obstacle(self.nearest(situation)));
        }
        self.secured(situation, self.plan[0])
    }

    fn reset(&mut self) {
        self.plan.fill(Velocity::ZERO);
        (self.last, self.over) = (None, 0.0);
        self.rng = Pcg64Mcg::seed_from_u64(self.seed);
    }
}

/// Where a continuation should lead.
struct Aim {
    way: Vec<MapPoint>,
    end: MapPoint,
    last: bool,
    yaw: Option<f64>,
}

impl Aim {
    fn of(situation: &Situation<'_>) -> Self {
        let from = situation.pose.point();
        let here = PathPoint { point: from, is_end: true };
        let at = |length: f64| ahead(situation.path, from, length).unwrap_or(here);
        let way = (0..=8).map(|i| at(LOOKAHEAD * f64::from(i) / 8.0).point).collect();
        let PathPoint { point: end, is_end: last } = at(LOOKAHEAD);
        Self { way, end, last, yaw: situation.final_yaw.filter(|_| last) }
    }

    fn way_cost(&self, pose: Pose2) -> f64 {
        let off = self.way.iter().map(|p| p.distance(pose.point())).fold(f64::INFINITY, f64::min);
        0.1 * off
    }

    fn end_cost(&self, pose: Pose2) -> f64 {
        let off = pose.point().distance(self.end);
        let near = (1.0 - off).clamp(0.0, 1.0);
        let turned = self.yaw.map_or(0.0, |yaw| wrap_angle(yaw - pose.yaw).abs());
        10.0 * off + near * turned
    }
}

/// Two independent normal deviates (Box and Muller).
fn normal_pair(rng: &mut Pcg64Mcg) -> (f64, f64) {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    let radius = (-2.0 * libm::log((1.0 - u).max(1e-300))).sqrt();
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * v);
    (radius * cos, radius * sin)
}
