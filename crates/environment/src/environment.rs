//! An episode, an action at a time.

use std::sync::Arc;
use std::time::Duration;

use openbench_bench::score::deliveries::score_episode;
use openbench_bench::score::results::DeliveryResult;
use openbench_bench::worlds::PreparedEpisode;
use openbench_bench::{Rollout, Status};
use openbench_core::{
    Action, Address, Briefing, Event, FailureCause, Goal, Image, ImuSample, LidarScan, Pose2,
    PoseEstimate, SimTime, Velocity,
};
use openbench_localization::wheels::Wheels;
use openbench_localization::{DeadReckoning, LidarInertial, Localizer};
use openbench_sim::{ImageSize, View};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use crate::beginning;
use crate::course::Tracker;
use crate::error::EnvironmentError;
use crate::observation::{self, IMU_SAMPLES, Observation};
use crate::options::{Declaration, Options, PoseSource};
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
    sensed: Sensed,
    tracker: Tracker,
    field: Option<Arc<WayField>>,
    /// Length of the way that was left after the last step, metres.
    left_m: Option<f64>,
    contact_s: f64,
    /// The target that the robot is rewarded for coming near to.
    target: Option<usize>,
    /// Until when it was rewarded.
    rewarded: SimTime,
}

/// What was sensed last.
struct Sensed {
    localizer: Option<Box<dyn Localizer + Send>>,
    scan: Option<LidarScan>,
    image: Option<Arc<Image>>,
    imu: Vec<ImuSample>,
    wheels: Wheels,
    speeds: [f32; 2],
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
        let observation = running.observation(&self.options);
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
            observation: running.observation(&self.options),
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
        Some((running.true_pose(), running.left_m))
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
        if let Some(seconds) = self.options.time_limit_s {
            episode.time_limit = Duration::from_secs_f64(seconds);
        }
        let rollout = Rollout::of(prepared, episode.clone(), self.random.random())?;
        let sensed = Sensed::new(&self.options, rollout.briefing());
        let tracker = Tracker::new(self.options.actions, &rollout.briefing().robot)?;
        let mut running = Running {
            rollout,
            number,
            episode,
            sensed,
            tracker,
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

impl Running {
    /// Lets the robot stand until there is something to see, and its localizer is ready.
    fn settle(&mut self, options: &Options) {
        let waits = |sensed: &Sensed| {
            let is_blind = options.observe.sees_scans() && sensed.scan.is_none();
            is_blind || !sensed.is_ready(options)
        };
        while waits(&self.sensed)
            && self.rollout.observation().time < LONGEST_SETTLING
            && self.rollout.status() == Status::Running
        {
            self.advance(Action::Drive(Velocity::ZERO), options);
        }
        self.sensed.look(&self.rollout, options);
        // The policy is rewarded for what follows.
        self.left_m = self.way_left();
        self.contact_s = self.contact_time();
        self.rewarded = self.rollout.observation().time;
    }

    fn act(&mut self, action: [f64; 3], options: &Options) {
        let [first, second, declares] = action;
        let by_policy = options.declaration == Declaration::Policy && declares > 0.5;
        if by_policy {
            self.declare(options);
        } else {
            // Lent out, since each step changes the rest.
            let mut tracker = std::mem::take(&mut self.tracker);
            let mut course = tracker.course([first, second], self.sensed.pose());
            for _ in 0..options.steps_per_action {
                let now = self.rollout.observation().time;
                let velocity = course.velocity(now, self.sensed.pose());
                self.advance(Action::Drive(velocity), options);
                if self.rollout.status() == Status::Ended {
                    break;
                }
            }
            self.tracker = tracker;
            if self.has_arrived(options.declaration) {
                self.declare(options);
            }
        }
        self.sensed.look(&self.rollout, options);
    }

    /// Declares the delivery that is open.
    fn declare(&mut self, options: &Options) {
        let address = self.rollout.open_addresses().next().cloned();
        if let Some(address) = address {
            self.advance(Action::Delivered(address), options);
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

    fn advance(&mut self, action: Action, options: &Options) {
        self.rollout.step(action);
        self.sensed.take(&self.rollout, options);
        if let Some(estimate) = self.sensed.estimate() {
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
            pose: simulator.base_link() * robot.camera,
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

    fn observation(&self, options: &Options) -> Observation {
        let (sensed, observe) = (&self.sensed, &options.observe);
        let estimate = sensed.estimate();
        let goal = match (&self.rollout.briefing().goal, estimate) {
            (Goal::Point(point), Some(estimate)) => {
                Some(observation::seen_from(estimate.pose, *point))
            }
            _ => None,
        };
        let scan = sensed.scan.as_ref();
        let imu_rows = IMU_SAMPLES * options.steps_per_action as usize;
        Observation {
            image: sensed.image.clone(),
            points: scan
                .filter(|_| observe.points)
                .map(observation::points_of)
                .unwrap_or_default(),
            range_image: observe
                .range_image
                .map(|size| observation::range_image_of(scan, size))
                .unwrap_or_default(),
            imu: if observe.imu {
                observation::imu_of(&sensed.imu, imu_rows)
            } else {
                Vec::new()
            },
            wheels: sensed.speeds,
            pose: estimate.map(|estimate| estimate.pose),
            health: estimate.map(|estimate| estimate.health).unwrap_or_default(),
            goal,
        }
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

impl Sensed {
    fn new(options: &Options, briefing: &Briefing) -> Self {
        let robot = briefing.robot.clone();
        let mut localizer: Option<Box<dyn Localizer + Send>> = match options.observe.pose {
            None => None,
            Some(PoseSource::Wheels) => Some(Box::new(DeadReckoning::new(robot))),
            Some(PoseSource::Odometry) => Some(Box::new(LidarInertial::new(robot))),
        };
        if let Some(localizer) = &mut localizer {
            localizer.reset(briefing.start);
        }
        Self {
            localizer,
            scan: None,
            image: None,
            imu: Vec::new(),
            wheels: Wheels::new(&briefing.robot),
            speeds: [0.0; 2],
        }
    }

    /// Takes in what was sensed during a step.
    fn take(&mut self, rollout: &Rollout<'_>, options: &Options) {
        let observation = rollout.observation();
        if let Some(localizer) = &mut self.localizer {
            localizer.update(&observation);
        }
        if options.observe.sees_scans()
            && let Some(scan) = observation.scan
        {
            // Into the memory of the last one.
            self.scan.get_or_insert_default().clone_from(scan);
        }
        if options.observe.imu {
            self.imu.extend_from_slice(observation.imu);
            let kept = IMU_SAMPLES * options.steps_per_action as usize;
            self.imu.drain(..self.imu.len().saturating_sub(kept));
        }
        for sample in observation.wheels {
            if let Some(speed) = self.wheels.take(sample) {
                self.speeds = [speed.velocity.x as f32, speed.turn as f32];
            }
        }
    }

    /// Takes an image, if one is wanted and the camera has one.
    fn look(&mut self, rollout: &Rollout<'_>, options: &Options) {
        if options.observe.image
            && let Some(image) = rollout.observation().camera.image()
        {
            self.image = Some(image);
        }
    }

    /// Where the robot takes itself to be.
    fn pose(&self) -> Option<Pose2> {
        self.localizer.as_ref().map(|localizer| localizer.pose())
    }

    fn estimate(&self) -> Option<PoseEstimate> {
        let localizer = self.localizer.as_ref()?;
        Some(PoseEstimate {
            pose: localizer.pose(),
            health: localizer.health(),
        })
    }

    /// Whether the localizer can be trusted. Wheels need a rest of four seconds for the last digits
    /// of a heading, which short episodes do not need.
    fn is_ready(&self, options: &Options) -> bool {
        let is_odometry = options.observe.pose == Some(PoseSource::Odometry);
        let localizer = self.localizer.as_ref().filter(|_| is_odometry);
        localizer.is_none_or(|localizer| localizer.ready())
    }
}
