//! Model Predictive Path Integral control: many disturbed continuations of the last plan, averaged
//! by their costs.
//!
//! G. Williams, A. Aldrich, E. Theodorou, *Model Predictive Path Integral Control: From Theory to
//! Parallel Computation*, Journal of Guidance, Control, and Dynamics 40(2), 2017. The costs are of
//! the kinds that Nav2's controller of this name has: distance to the path and to its end, heading,
//! nearness to obstacles, driving backward. It is here for comparison with Timed Elastic Bands. The
//! disturbances come from a seeded generator.

use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity, frames::wrap_angle};
use openbench_geometry::grid::GridGeometry;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::checks::SettingsError;
use crate::feasible::{ConflictCheck, clearance};
use crate::kinematics::Motion;
use crate::limits::Limits;
use crate::local::{
    Blocked, LocalPlanner, PathPoint, PlannerEntry, Progress, Situation, ahead, planner_entry,
};
use crate::near_cells::each_cell_near;
use crate::shape::{Footprint, Obstacle, ShapeError, moving, standing};

/// Continuations in a cycle.
const SAMPLES: usize = 600;
/// Steps of each.
const STEPS: usize = 32;
/// Seconds of a step.
const STEP_S: f64 = 0.1;
/// Standard deviation of the speed, m/s.
const NOISE_MPS: f64 = 0.15;
/// Standard deviation of the turn rate, rad/s.
const NOISE_RADPS: f64 = 0.4;
/// Difference of costs by which a continuation weighs e times less.
const TEMPERATURE: f64 = 0.3;
/// Length of the path that is considered, metres.
const LOOKAHEAD_M: f64 = 1.6;
/// Points of that length, besides the first.
const PATH_POINTS: i32 = 8;
/// Distance from the footprint's circumscribed circle above which obstacles cost nothing, metres.
const COMFORT_M: f64 = 0.25;
/// Cost of touching an obstacle.
const TOUCH: f64 = 1000.0;
/// Cost of a step right beside an obstacle.
const NEARNESS: f64 = 0.2;
/// Cost of a step for each m/s backward.
const BACKWARD: f64 = 0.3;
/// Cost of a step for each rad/s.
const TURNING: f64 = 0.02;
/// Cost of a step for each metre from the path.
const ASIDE: f64 = 0.1;
/// Cost of the last step for each metre from the end of the path.
const REMAINING: f64 = 10.0;
/// Side of a cell of the map of distances, metres.
const CELL_M: f64 = 0.05;
/// How far the map of distances reaches, metres.
const MAP_M: f64 = 2.0;
/// Distance from obstacles that a command has to keep, metres.
const SURE_M: f64 = 0.003;
/// Slower than this, m/s, is as good as standing: the controller found no way on.
const STILL_MPS: f64 = 0.02;
/// The same of the turn rate, rad/s.
const STILL_RADPS: f64 = 0.05;
/// Slowest turn at the end of the path, rad/s.
const LEAST_TURN_RADPS: f64 = 0.1;
/// Distance from the end of the path with which the robot has arrived, metres.
const TOLERANCE_M: f64 = 0.1;
/// Heading error there with which it has arrived, radians.
const TOLERANCE_RAD: f64 = 0.08;
/// Seconds that a command is held.
const HOLD_S: f64 = 0.1;

/// Its entry among the local planners.
pub(crate) fn entry() -> PlannerEntry {
    let description = "Model Predictive Path Integral control";
    planner_entry("mppi", description, |settings| {
        Ok(Box::new(Mppi::new(&settings.robot, settings.seed)?))
    })
}

/// A controller cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MppiError {
    /// A limit makes no sense.
    #[error(transparent)]
    Limits(#[from] SettingsError),
    /// The footprint is none.
    #[error(transparent)]
    Footprint(#[from] ShapeError),
}

/// The controller.
#[derive(Debug, Clone)]
pub struct Mppi {
    footprint: Footprint,
    limits: Limits,
    rng: Pcg64Mcg,
    seed: u64,
    plan: Vec<Velocity>,
    /// When the plan was last moved on.
    last: Option<SimTime>,
    /// Seconds of its first step that are over.
    over: f64,
    samples: Vec<[Velocity; STEPS]>,
    costs: Vec<f64>,
    /// Distance from each cell around the robot to the nearest standing obstacle, metres.
    distances: Vec<f32>,
}

impl Mppi {
    /// A controller for a robot; its disturbances are drawn from a seed.
    pub fn new(robot: &RobotDescription, seed: u64) -> Result<Self, MppiError> {
        Ok(Self {
            footprint: Footprint::of(robot)?,
            limits: Limits::of(robot)?,
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

    /// Fills the map of distances; the grid that it is over.
    fn measure(&mut self, situation: &Situation<'_>) -> GridGeometry {
        let here = situation.pose.point();
        let low = MapPoint::new(here.x - MAP_M, here.y - MAP_M);
        let high = MapPoint::new(here.x + MAP_M, here.y + MAP_M);
        let grid = GridGeometry::covering(low, high, CELL_M, 1000);
        let reach = self.footprint.circumscribed() + COMFORT_M;
        self.distances.clear();
        self.distances.resize(grid.len(), reach as f32);
        for obstacle in standing(situation.obstacles) {
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
        while self.over > STEP_S - 1e-9 {
            self.over -= STEP_S;
            self.plan.rotate_left(1);
            self.plan[STEPS - 1] = self.plan[STEPS - 2];
            // After a long pause nothing is left of the plan anyway.
            self.over = self.over.min(STEP_S * STEPS as f64);
        }
    }

    /// Draws the continuations.
    fn sample(&mut self) {
        for sample in &mut self.samples {
            for (velocity, planned) in sample.iter_mut().zip(&self.plan) {
                let noise = normal_pair(&mut self.rng);
                let linear = planned.linear + NOISE_MPS * noise[0];
                let angular = planned.angular + NOISE_RADPS * noise[1];
                *velocity = Velocity::new(
                    linear.clamp(-self.limits.backward, self.limits.forward),
                    angular.clamp(-self.limits.turn, self.limits.turn),
                );
            }
        }
    }

    /// What a continuation costs.
    fn cost(
        &self,
        sample: &[Velocity; STEPS],
        situation: &Situation<'_>,
        grid: &GridGeometry,
        aim: &Aim,
    ) -> f64 {
        let (pose, velocity) = (situation.pose, situation.velocity);
        let mut motion = Motion {
            pose,
            velocity,
            command: Velocity::ZERO,
        };
        let mut cost = 0.0;
        for (i, command) in sample.iter().enumerate() {
            motion.command = *command;
            // A continuation holds wanted velocities; what counts is what the rims make of them.
            motion.step(&self.limits, STEP_S);
            let time = (i + 1) as f64 * STEP_S;
            cost += self.nearness(motion.pose, time, situation.obstacles, grid);
            let backward = (-motion.velocity.linear).max(0.0);
            cost += BACKWARD * backward + TURNING * motion.velocity.angular.abs();
            cost += aim.path_cost(motion.pose);
        }
        cost + aim.end_cost(motion.pose)
    }

    /// What nearness to obstacles costs at a pose, `time` seconds ahead.
    fn nearness(&self, pose: Pose2, time: f64, obstacles: &[Obstacle], grid: &GridGeometry) -> f64 {
        let (inner, outer) = (self.footprint.inscribed(), self.footprint.circumscribed());
        let standing = grid
            .cell_at(pose.point())
            .map_or(outer + COMFORT_M, |cell| f64::from(self.distances[cell]));
        let distances = moving(obstacles).map(|o| {
            // The robot is moved back instead of the obstacle forward.
            let v = o.velocity();
            o.distance_to(MapPoint::new(pose.x - v.x * time, pose.y - v.y * time))
        });
        let distance = distances.fold(standing, f64::min);
        // Distances are of cells' middles, and off by less than a cell. Between both circles only
        // the footprint itself can tell.
        let may_touch = distance < outer + CELL_M;
        if distance < inner - CELL_M || may_touch && self.touches(pose, time, obstacles) {
            return TOUCH;
        }
        let near = ((outer + COMFORT_M - distance) / COMFORT_M).max(0.0);
        NEARNESS * near * near
    }

    /// Whether the footprint touches an obstacle, `time` seconds ahead.
    fn touches(&self, pose: Pose2, time: f64, obstacles: &[Obstacle]) -> bool {
        let (placed, circle) = (self.footprint.at(pose), self.footprint.circumscribed());
        let mut contacts = obstacles
            .iter()
            .filter_map(|o| o.contact(&placed, circle, time, 0.0));
        contacts.any(|contact| contact.distance <= 0.0)
    }

    /// Replaces the plan by the mean of all continuations, each weighed by how much it costs more
    /// than the cheapest.
    fn average(&mut self) {
        let least = self.costs.iter().copied().fold(f64::INFINITY, f64::min);
        let mut sum = 0.0;
        self.plan.fill(Velocity::ZERO);
        for (sample, cost) in self.samples.iter().zip(&self.costs) {
            // Relative to the cheapest, whose weight is 1: the sum cannot vanish.
            let weight = libm::exp(-(cost - least) / TEMPERATURE);
            sum += weight;
            for (planned, velocity) in self.plan.iter_mut().zip(sample) {
                planned.linear += weight * velocity.linear;
                planned.angular += weight * velocity.angular;
            }
        }
        for planned in &mut self.plan {
            *planned = Velocity::new(planned.linear / sum, planned.angular / sum);
        }
    }

    /// Distance to the nearest obstacle, metres.
    fn nearest(&self, situation: &Situation<'_>) -> f64 {
        let obstacles = situation.obstacles.iter();
        clearance(&self.footprint, obstacles, situation.pose, 0.0, MAP_M).max(0.0)
    }

    /// The largest share of a velocity with which the robot can still stop before any obstacle.
    fn secured(&self, situation: &Situation<'_>, wanted: Velocity) -> Result<Progress, Blocked> {
        let Situation {
            pose,
            velocity,
            obstacles,
            ..
        } = *situation;
        let check = ConflictCheck {
            footprint: &self.footprint,
            limits: &self.limits,
            obstacles,
            margin: SURE_M,
        };
        for share in [1.0, 0.6, 0.3, 0.1] {
            let command = Velocity::new(share * wanted.linear, share * wanted.angular);
            let motion = Motion {
                pose,
                velocity,
                command,
            };
            if check.conflict_before_stop(motion, HOLD_S).is_none() {
                return Ok(if share < 1.0 {
                    Progress::Slowed(command, Blocked::Obstacle(self.nearest(situation)))
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
        let turn = situation
            .final_yaw
            .map_or(0.0, |yaw| wrap_angle(yaw - situation.pose.yaw));
        let is_there = aim.is_last && situation.pose.point().distance(aim.end) <= TOLERANCE_M;
        if is_there && turn.abs() <= TOLERANCE_RAD {
            return Ok(Progress::Arrived);
        }
        if is_there {
            let rate = (2.0 * turn.abs())
                .max(LEAST_TURN_RADPS)
                .min(self.limits.turn);
            return self.secured(situation, Velocity::new(0.0, rate.copysign(turn)));
        }
        // Disturb the last plan, weigh the continuations by their costs, and drive the first step
        // of their mean.
        let grid = self.measure(situation);
        self.move_on(situation.time);
        self.sample();
        for i in 0..SAMPLES {
            self.costs[i] = self.cost(&self.samples[i], situation, &grid, &aim);
        }
        self.average();
        let first = self.plan[0];
        if first.linear.abs() < STILL_MPS && first.angular.abs() < STILL_RADPS {
            return Err(Blocked::Obstacle(self.nearest(situation)));
        }
        self.secured(situation, first)
    }

    fn reset(&mut self) {
        self.plan.fill(Velocity::ZERO);
        (self.last, self.over) = (None, 0.0);
        self.rng = Pcg64Mcg::seed_from_u64(self.seed);
    }
}

/// Where a continuation should lead.
struct Aim {
    /// Points of the path ahead.
    path: Vec<MapPoint>,
    /// The last of them.
    end: MapPoint,
    /// Whether the path ends there.
    is_last: bool,
    /// Heading wanted there, radians.
    yaw: Option<f64>,
}

impl Aim {
    fn of(situation: &Situation<'_>) -> Self {
        let lengths =
            (0..=PATH_POINTS).map(|i| LOOKAHEAD_M * f64::from(i) / f64::from(PATH_POINTS));
        let path = lengths.map(|length| point_ahead(situation, length).point);
        let path = path.collect();
        let PathPoint { point: end, is_end } = point_ahead(situation, LOOKAHEAD_M);
        Self {
            path,
            end,
            is_last: is_end,
            yaw: situation.final_yaw.filter(|_| is_end),
        }
    }

    /// What distance from the path costs in a step.
    fn path_cost(&self, pose: Pose2) -> f64 {
        let distances = self.path.iter().map(|p| p.distance(pose.point()));
        ASIDE * distances.fold(f64::INFINITY, f64::min)
    }

    /// What the last pose costs.
    fn end_cost(&self, pose: Pose2) -> f64 {
        let off = pose.point().distance(self.end);
        let near = (1.0 - off).clamp(0.0, 1.0);
        let turned = self.yaw.map_or(0.0, |yaw| wrap_angle(yaw - pose.yaw).abs());
        REMAINING * off + near * turned
    }
}

/// The point so many metres along the path; where the robot is, if there is no path.
fn point_ahead(situation: &Situation<'_>, length: f64) -> PathPoint {
    let here = situation.pose.point();
    ahead(situation.path, here, length).unwrap_or(PathPoint {
        point: here,
        is_end: true,
    })
}

/// Two independent standard normal numbers (Box and Muller).
fn normal_pair(rng: &mut Pcg64Mcg) -> [f64; 2] {
    let u: f64 = rng.random();
    let v: f64 = rng.random();
    // The logarithm of zero would be infinite.
    let radius = (-2.0 * libm::log((1.0 - u).max(1e-300))).sqrt();
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * v);
    [radius * cos, radius * sin]
}
