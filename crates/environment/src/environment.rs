//! An episode, an action at a time.

use std::sync::Arc;
use std::time::Duration;

use openbench_bench::score::deliveries::score_episode;
use openbench_bench::score::results::DeliveryResult;
use openbench_bench::worlds::PreparedEpisode;
use openbench_bench::{Rollout, Status};
use openbench_core::{
    Action, Address, Briefing, Event, FailureCause, Goal, Image, Pose2, SimTime, Velocity,
};
use openbench_sim::{ImageSize, View};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use crate::adapter::Adapter;
use crate::beginning;
use crate::error::EnvironmentError;
use crate::observation::Observation;
use crate::options::{Declaration, Options};
use crate::progress::WayField;
use crate::world::World;

/// Distance beyond which pictures show nothing, metres.
const PICTURE_RANGE_M: f32 = 200.0;
/// Simulated time after which an episode begins even if its localizer is not ready.
const LONGEST_SETTLING: SimTime = SimTime::from_millis(10_000);

/// Episodes of a suite for a learner.
pub struct Environment {
    world: World,
    options: Options,
    random: Pcg64Mcg,
    episode: Option<Running>,
}

/// What a step returns.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// What the policy gets.
    pub observation: Observation,
    /// The reward.
    pub reward: f64,
    /// Whether every delivery has ended by the policy's or the robot's doing.
    pub terminated: bool,
    /// Whether the episode has ended because its time is over.
    pub truncated: bool,
    /// The scores, at the end.
    pub outcome: Option<Outcome>,
}

/// The scores of an episode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Whether each delivery was declared at the right door (2 m).
    pub is_success: bool,
    /// The results of the deliveries, as in `results.json`.
    pub deliveries: Vec<DeliveryResult>,
    /// Simulated time, seconds.
    pub sim_seconds: f64,
}

/// An episode that is running.
struct Running {
    rollout: Rollout<'static>,
    number: usize,
    episode: PreparedEpisode,
    adapter: Adapter,
    field: Option<Arc<WayField>>,
    /// Length of the way that was left after the last step, metres.
    left_m: Option<f64>,
    contact_s: f64,
    /// The target that the robot is rewarded for coming near to.
    target: Option<usize>,
    /// Until when it was rewarded.
    rewarded: SimTime,
}

impl Environment {
    /// An environment in a world that was made with the same options.
    ///
    /// # Errors
    /// [`EnvironmentError::Option`] that makes no sense.
    pub fn new(world: World, options: Options) -> Result<Self, EnvironmentError> {
        options.check()?;
        Ok(Self {
            world,
            options,
            random: Pcg64Mcg::seed_from_u64(0),
            episode: None,
        })
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The options.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Begins an episode: that of a number, or one that is drawn. A seed begins the sequence of all
    /// random numbers anew; without one it goes on.
    ///
    /// # Errors
    /// [`EnvironmentError::NoStart`], or [`EnvironmentError::Bench`] of a number that is too large.
    pub fn reset(
        &mut self,
        seed: Option<u64>,
        episode: Option<usize>,
    ) -> Result<Observation, EnvironmentError> {
        if let Some(seed) = seed {
            self.random = Pcg64Mcg::seed_from_u64(seed);
        }
        // Dropped first, so that two simulators are never in memory.
        self.episode = None;
        let count = self.world.prepared().episodes.len();
        let drawn = self.random.random_range(0..count);
        let number = episode.unwrap_or(drawn);
        let mut running = self.begin(number)?;
        running.settle(&self.options);
        let observation = running.adapter.observation();
        self.episode = Some(running);
        Ok(observation)
    }

    /// Does what an action says: two numbers as [`Actions`](crate::Actions) has them, and, above
    /// 0.5, that the parcel is delivered here and now, to the address that is open.
    ///
    /// # Errors
    /// [`EnvironmentError::Action`] of a number that is not finite, or
    /// [`EnvironmentError::NoEpisode`].
    pub fn step(&mut self, action: [f64; 3]) -> Result<Step, EnvironmentError> {
        if !action.iter().all(|number| number.is_finite()) {
            return Err(EnvironmentError::Action(action));
        }
        let mut running = self.episode.take().ok_or(EnvironmentError::NoEpisode)?;
        running.act(action, &self.options);
        let mut step = Step {
            observation: running.adapter.observation(),
            reward: running.reward(&self.options, &self.world),
            terminated: false,
            truncated: false,
            outcome: None,
        };
        if running.rollout.status() == Status::Running {
            self.episode = Some(running);
            return Ok(step);
        }
        let rewards = self.options.rewards;
        let outcome = running.outcome(&self.world)?;
        step.truncated = outcome.is_timeout();
        step.terminated = !step.truncated;
        step.reward += match (outcome.is_success, step.truncated) {
            (true, _) => rewards.success,
            (false, true) => 0.0,
            (false, false) => rewards.failure,
        };
        step.outcome = Some(outcome);
        Ok(step)
    }

    /// The briefing of the running episode.
    pub fn briefing(&self) -> Option<&Briefing> {
        self.episode
            .as_ref()
            .map(|running| running.rollout.briefing())
    }

    /// The address that an action declares next.
    pub fn open_address(&self) -> Option<&Address> {
        self.episode.as_ref()?.rollout.open_addresses().next()
    }

    /// The true pose of the robot and the length of the way that is left: what no policy may know.
    pub fn privileged(&self) -> Option<(Pose2, Option<f64>)> {
        let running = self.episode.as_ref()?;
        let on_map = self.world.prepared().on_map();
        Some((on_map.pose(running.true_pose()), running.left_m))
    }

    /// A picture of the running episode, from the robot's camera. Observations do not depend on it.
    pub fn picture(&self) -> Option<Image> {
        let running = self.episode.as_ref()?;
        Some(running.picture(&self.world))
    }

    /// Simulated time of the running episode.
    pub fn time(&self) -> SimTime {
        let running = self.episode.as_ref();
        running.map_or(SimTime::ZERO, |running| running.rollout.observation().time)
    }

    fn begin(&mut self, number: usize) -> Result<Running, EnvironmentError> {
        let prepared = self.world.prepared();
        let no_episode = openbench_bench::BenchError::NoSuchEpisode {
            episode: number,
            count: prepared.episodes.len(),
        };
        let mut episode = prepared.episodes.get(number).ok_or(no_episode)?.clone();
        if let Some(distance) = self.options.start {
            let start = beginning::draw(&self.world, &episode, distance, &mut self.random)?;
            episode = prepared.starting_at(start, episode);
        }
        if self.options.time_limit_s.is_some() {
            // Until it has settled; then the limit begins.
            episode.time_limit = Duration::MAX;
        }
        let rollout = Rollout::of(prepared, episode.clone(), self.random.random())?;
        let Briefing {
            robot, start, goal, ..
        } = rollout.briefing();
        let point = match goal {
            Goal::Point(point) => Some(*point),
            Goal::Instruction(_) | Goal::Image(_) => None,
        };
        let start = match start.pose() {
            Some(pose) => pose,
            // Nothing is seen from the estimated pose then.
            None if self.options.observe.pose.is_none() => Pose2::default(),
            None => return Err(no_pose()),
        };
        let adapter = Adapter::new(&self.options, robot, start, point)?;
        let mut running = Running {
            rollout,
            number,
            episode,
            adapter,
            field: None,
            left_m: None,
            contact_s: 0.0,
            target: None,
            rewarded: SimTime::ZERO,
        };
        running.aim(&self.world);
        Ok(running)
    }
}

/// The suite gives no pose at the start, from which an estimate could begin.
fn no_pose() -> EnvironmentError {
    EnvironmentError::Option {
        option: "pose",
        problem: "the suite's condition `start` gives no pose to begin with".to_owned(),
    }
}

impl Running {
    /// Lets the robot stand until there is something to see, and its localizer is ready.
    fn settle(&mut self, options: &Options) {
        self.rollout.set_scanning(options.observe.scanning(0));
        let mut time = self.rollout.observation().time;
        while !self.adapter.is_ready(time)
            && time < LONGEST_SETTLING
            && self.rollout.status() == Status::Running
        {
            self.advance(Action::Drive(Velocity::ZERO));
            time = self.rollout.observation().time;
        }
        self.adapter.look(&self.rollout.observation());
        if let Some(seconds) = options.time_limit_s {
            let limit = time.since(SimTime::ZERO) + Duration::from_secs_f64(seconds);
            self.rollout.set_time_limit(limit);
        }
        // The policy is rewarded for what follows.
        self.left_m = self.way_left();
        self.contact_s = self.contact_time();
        self.rewarded = self.rollout.observation().time;
    }

    fn act(&mut self, action: [f64; 3], options: &Options) {
        let [first, second, declares] = action;
        let by_policy = options.declaration == Declaration::Policy && declares > 0.5;
        if by_policy {
            self.declare();
        } else {
            self.adapter.begin([first, second]);
            for left in (0..options.steps_per_action).rev() {
                self.rollout.set_scanning(options.observe.scanning(left));
                let now = self.rollout.observation().time;
                let velocity = self.adapter.velocity(now);
                self.advance(Action::Drive(velocity));
                if self.rollout.status() == Status::Ended {
                    break;
                }
            }
            if self.has_arrived(options.declaration) {
                self.declare();
            }
        }
        self.adapter.look(&self.rollout.observation());
    }

    /// Declares the delivery that is open.
    fn declare(&mut self) {
        let address = self.rollout.open_addresses().next().cloned();
        if let Some(address) = address {
            self.advance(Action::Delivered(address));
        }
    }

    fn has_arrived(&self, declaration: Declaration) -> bool {
        let Declaration::Arrival(radius) = declaration else {
            return false;
        };
        let here = self.true_pose().point();
        let left = self.field.as_ref().and_then(|field| field.length(here));
        left.is_some_and(|left| left <= radius)
    }

    fn advance(&mut self, action: Action) {
        self.rollout.step(action);
        self.adapter.take(&self.rollout.observation());
        if let Some(estimate) = self.adapter.estimate() {
            self.rollout.record(Event::PoseEstimate(estimate));
        }
    }

    /// Aims at the door of the delivery that is open.
    fn aim(&mut self, world: &World) {
        self.target = self.rollout.open_targets().first().copied();
        let door = self
            .target
            .and_then(|target| self.episode.targets[target].door);
        self.field = door.and_then(|door| world.way_field(door));
        self.left_m = self.way_left();
    }

    fn true_pose(&self) -> Pose2 {
        Pose2::from_pose3(&self.rollout.simulator().base_link())
    }

    /// Time in contact with obstacles so far, seconds.
    fn contact_time(&self) -> f64 {
        let contacts = self.rollout.simulator().contact_durations();
        contacts.values().sum::<Duration>().as_secs_f64()
    }

    /// What the camera would show, without its noise of exposure and at any time.
    fn picture(&self, world: &World) -> Image {
        let simulator = self.rollout.simulator();
        let robot = simulator.robot();
        let optics = robot.camera_intrinsics;
        let view = View {
            pose: simulator.base_link() * world.prepared().defects.camera.of(robot.camera),
            size: ImageSize::new(optics.width, optics.height),
            focal_length: optics.focal_length(),
            range: PICTURE_RANGE_M,
            shadows: false,
            exposure: 1.0,
        };
        let renderer = world.prepared().stage.renderer();
        Image {
            stamp: simulator.time(),
            width: optics.width,
            height: optics.height,
            rgb: renderer.render(&view, &simulator.placed_movers()),
        }
    }

    fn way_left(&self) -> Option<f64> {
        let here = self.true_pose().point();
        self.field.as_ref()?.length(here)
    }

    /// The reward since the last call, without that for the end.
    fn reward(&mut self, options: &Options, world: &World) -> f64 {
        let rewards = options.rewards;
        let left = self.way_left();
        let progress = match (self.left_m, left) {
            (Some(before), Some(now)) => before - now,
            _ => 0.0,
        };
        // Where there is no way, the last length counts until there is one again.
        self.left_m = left.or(self.left_m);
        let contact = self.contact_time();
        let touched = contact - self.contact_s;
        self.contact_s = contact;
        let now = self.rollout.observation().time;
        let seconds = now.since(self.rewarded).as_secs_f64();
        self.rewarded = now;
        let open = self.rollout.open_targets().first().copied();
        if open != self.target {
            self.aim(world);
        }
        rewards.progress * progress + rewards.contact * touched + rewards.time * seconds
    }

    /// The scores of an episode that has ended.
    fn outcome(self, world: &World) -> Result<Outcome, EnvironmentError> {
        let trace = self.rollout.finish(None)?;
        let deliveries = score_episode(world.prepared(), self.number, &self.episode, &trace);
        Ok(Outcome {
            is_success: deliveries.iter().all(|delivery| delivery.success_2m),
            sim_seconds: trace.sim_seconds,
            deliveries,
        })
    }
}

impl Outcome {
    /// Whether the end of time ended a delivery.
    fn is_timeout(&self) -> bool {
        let timeout = Some(FailureCause::Timeout);
        self.deliveries
            .iter()
            .any(|delivery| delivery.failure == timeout)
    }
}
