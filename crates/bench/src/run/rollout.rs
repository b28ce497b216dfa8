//! An episode, one step at a time: the only interface to a running episode.
//!
//! A [`Rollout`] owns the simulator and keeps the trace. It does not depend on the source of the
//! actions: the runner takes them from an [`Agent`](openbench_core::Agent), `verify` from a
//! recording. A recorder or a live view is an [`Observer`].

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use openbench_core::{
    Action, Address, Briefing, Event, FailureCause, GiveUp, Goal, Image, MapPoint, ModelUse,
    Observation, Pose2, PoseEstimate, SimTime, Start, Velocity,
};
use openbench_scene::SemanticClass;
use openbench_sim::lidar::Scanning;
use openbench_sim::traffic::Encounters;
use openbench_sim::{OBSERVATION_NS, Simulator};

use super::observer::Observer;
use crate::BenchError;
use crate::image_file;
use crate::suite::{Compute, Condition, GoalKind};
use crate::trace::{
    Computing, Deed, EpisodeTrace, Failure, Frame, PlacedDoor, PlateRead, PoseError, Reading,
    Smoothness, TaskOutcome, TimedComparison, TimedDeed, TimedStage,
};
use crate::worlds::{Prepared, PreparedEpisode};

/// Images with plates that are kept for the report of an episode; each has about a megabyte.
const MAX_FRAMES: usize = 6;
/// True poses that are kept for late estimates: more than observations wait for an agent.
const MAX_POSES: usize = 64;
/// Time between two true positions of [`EpisodeTrace::driven`].
const DRIVEN_PERIOD_NS: u64 = 200_000_000;

/// Whether an episode is still running.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// At least one delivery has not ended.
    Running,
    /// Every delivery has ended, or an observer failed. Further steps have no effect.
    Ended,
}

/// A running episode.
///
/// The lifetime is that of its observers; a rollout without observers borrows nothing.
///
/// ```
/// use openbench_bench::{Prepared, Rollout, Status, builtin_suite};
/// use openbench_core::{Action, Velocity};
///
/// # fn main() -> Result<(), openbench_bench::BenchError> {
/// let prepared = Prepared::new(builtin_suite("small")?, None)?;
/// let mut rollout = Rollout::new(&prepared, 0, 7)?;
/// let mut scans = 0;
/// for _ in 0..20 {
///     scans += usize::from(rollout.observation().scan.is_some());
///     let status = rollout.step(Action::Drive(Velocity::new(0.2, 0.0)));
///     assert_eq!(status, Status::Running);
/// }
/// let trace = rollout.finish(None)?;
/// // 20 steps of 50 ms; the LiDAR has 10 scans a second.
/// assert!((trace.sim_seconds - 1.0).abs() < 1e-9);
/// assert!((9..=10).contains(&scans));
/// # Ok(())
/// # }
/// ```
pub struct Rollout<'o> {
    briefing: Briefing,
    /// The world in the frame of the public map; `None` if both are the same.
    frame: Option<Pose2>,
    compute: Compute,
    /// Whether wall time is charged, whatever the condition says.
    is_charged_by_clock: bool,
    /// The instant that the agent observes: now, unless it is behind with its work.
    observed: SimTime,
    /// The last true poses in the frame of the public map, oldest first.
    poses: VecDeque<(SimTime, Pose2)>,
    episode: PreparedEpisode,
    simulator: Simulator,
    observers: Vec<Box<dyn Observer + 'o>>,
    trace: EpisodeTrace,
    task: Task,
    /// Deliveries that the agent gave up, but that the instruction does not have: its reasons are
    /// those of the targets that it never mentions.
    misread: VecDeque<Failure>,
    /// The last images in which plates were read, oldest first.
    images: VecDeque<(SimTime, Arc<Image>)>,
    error: Option<BenchError>,
}

impl<'o> Rollout<'o> {
    /// Starts the episode of that number, from 0; all noise is drawn from `seed`.
    ///
    /// # Errors
    /// [`BenchError::NoSuchEpisode`], or [`BenchError::World`] if people and cars cannot be placed.
    pub fn new(prepared: &Prepared, episode: usize, seed: u64) -> Result<Self, BenchError> {
        let count = prepared.episodes.len();
        let missing = BenchError::NoSuchEpisode { episode, count };
        let episode = prepared.episodes.get(episode).ok_or(missing)?;
        Self::of(prepared, episode.clone(), seed)
    }

    /// Starts an episode that is none of the suite's: with a start of its own, for training.
    ///
    /// # Errors
    /// [`BenchError::World`] if people and cars cannot be placed.
    pub fn of(
        prepared: &Prepared,
        episode: PreparedEpisode,
        seed: u64,
    ) -> Result<Self, BenchError> {
        let start = prepared.suite.conditions.start.draw(episode.start, seed);
        let start = prepared.on_map().start(start);
        Ok(Self {
            briefing: briefing(prepared, &episode, start),
            frame: prepared.on_map().frame(),
            compute: prepared.suite.conditions.compute,
            is_charged_by_clock: false,
            observed: SimTime::ZERO,
            poses: VecDeque::new(),
            simulator: prepared.simulator_at(episode.start, seed)?,
            task: Task::new(episode.start.point()),
            episode,
            observers: Vec::new(),
            trace: EpisodeTrace {
                start: Some(start),
                ..EpisodeTrace::default()
            },
            misread: VecDeque::new(),
            images: VecDeque::new(),
            error: None,
        })
    }

    /// The same rollout with one more observer.
    #[must_use]
    pub fn with_observer(mut self, mut observer: impl Observer + 'o) -> Self {
        let begun = observer.begin(&self.simulator);
        // An error ends the episode before its first step, and `finish` returns it.
        self.keep_error(begun);
        self.observers.push(Box::new(observer));
        self
    }

    /// The agent's briefing.
    pub fn briefing(&self) -> &Briefing {
        &self.briefing
    }

    /// The same rollout, of an agent whose wall time is charged.
    #[must_use]
    pub fn charged_by_clock(self, is_charged: bool) -> Self {
        Self {
            is_charged_by_clock: is_charged,
            ..self
        }
    }

    /// Whether the agent's wall time is charged.
    pub(super) fn is_charged_by_clock(&self) -> bool {
        self.is_charged_by_clock
    }

    /// Whether computing takes simulated time in this episode.
    pub(super) fn is_computing_charged(&self) -> bool {
        self.is_charged_by_clock || !self.compute.is_off()
    }

    /// What work costs.
    pub(super) fn compute(&self) -> Compute {
        self.compute
    }

    /// The sensor data since the last step.
    pub fn observation(&self) -> Observation<'_> {
        self.simulator.observation()
    }

    /// Whether the episode is still running.
    pub fn status(&self) -> Status {
        let all_ended = self.trace.tasks.len() >= self.episode.targets.len();
        if all_ended || self.error.is_some() {
            Status::Ended
        } else {
            Status::Running
        }
    }

    /// Sets how much of the LiDAR's scans is cast from now on, for training. Only a run with the
    /// default can be verified.
    pub fn set_scanning(&mut self, scanning: Scanning) {
        self.simulator.set_scanning(scanning);
    }

    /// Sets the simulated time at which the episode ends, for training.
    pub fn set_time_limit(&mut self, limit: Duration) {
        self.episode.time_limit = limit;
    }

    /// Records an event that the agent reports.
    pub fn record(&mut self, event: Event) {
        let time = self.simulator.time();
        // Observers first, since the trace takes the event apart. By index, since `keep_error`
        // needs all of `self`.
        for i in 0..self.observers.len() {
            let seen = self.observers[i].event(time, &event);
            self.keep_error(seen);
        }
        if let Event::PlateRead { image, .. } = &event {
            self.keep_image(time, image.clone());
        }
        if let Some(deed) = Deed::of(&event) {
            let deed = self.dated(deed);
            self.enter(&deed);
            self.keep_deed(deed);
        }
        if let Event::Models(used) = event {
            // With the latency, which no deed has.
            self.trace.models = used;
        }
    }

    /// Enters what an agent reports into the trace. Recorded deeds come this way, too.
    fn enter(&mut self, deed: &Deed) {
        let time = self.simulator.time();
        match deed {
            Deed::Planned(plan) => self.trace.plan = Some(plan.clone()),
            Deed::Began(stage) => self.trace.stages.push(TimedStage {
                time,
                stage: *stage,
            }),
            Deed::Routed(points) => self.trace.routes.push(Deed::route(points)),
            Deed::Estimated(pose, health) => {
                self.enter_estimate(time, Deed::estimate(*pose, *health));
            }
            Deed::EstimatedAt(pose, health, at) => {
                self.enter_estimate(SimTime(*at), Deed::estimate(*pose, *health));
            }
            Deed::Compared(comparison) => self.trace.comparisons.push(TimedComparison {
                time,
                truth: self.pose_on_map(),
                found: comparison.reported(),
            }),
            Deed::WroteDoor(address, position) => {
                // A door that is written again replaces the earlier one.
                self.trace
                    .doors
                    .retain(|known| !known.address.same_door(address));
                self.trace.doors.push(PlacedDoor {
                    address: address.clone(),
                    position: Deed::position(*position),
                });
            }
            Deed::Read(reading) => self.trace.plates.push(plate(time, reading)),
            // The agent reports its use so far, so the last report is the total.
            Deed::Asked(used) => self.trace.models = *used,
            Deed::Computed(computing) => self.trace.computing = Some(computing.clone()),
            // Actions are applied by `step`, a refusal by `refuse`.
            Deed::Refused(_) | Deed::Delivered(_) | Deed::GaveUp(_) => {}
        }
    }

    /// Notes what computing cost in the episode.
    pub(super) fn note_computing(&mut self, computing: Computing) {
        let deed = Deed::Computed(computing);
        self.enter(&deed);
        self.keep_deed(deed);
    }

    /// A deed with its instant, where that is not now.
    fn dated(&self, deed: Deed) -> Deed {
        match deed {
            Deed::Estimated(pose, health) if self.observed < self.simulator.time() => {
                Deed::EstimatedAt(pose, health, self.observed.0)
            }
            deed => deed,
        }
    }

    /// Compares an estimate with the true pose at its instant.
    fn enter_estimate(&mut self, at: SimTime, estimate: PoseEstimate) {
        let known = self.poses.iter().find(|(time, _)| *time == at);
        let truth = known.map_or_else(|| self.pose_on_map(), |(_, pose)| *pose);
        self.trace.estimated.push(estimate.pose.point());
        let error = PoseError::new(at, truth, estimate);
        self.trace.pose_errors.push(error);
    }

    /// Says of which observation the agent reports from now on: an agent that is behind with its
    /// work reports estimates of earlier instants.
    pub(super) fn set_observed(&mut self, time: SimTime) {
        self.observed = time;
    }

    fn keep_deed(&mut self, deed: Deed) {
        let step = self.steps();
        self.trace.deeds.push(TimedDeed { step, deed });
    }

    /// Number of steps so far.
    pub(super) fn steps(&self) -> u32 {
        // An episode has a time limit of hours; 2^32 steps are almost seven years.
        self.trace.velocities.len() as u32
    }

    /// Repeats a recorded deed that is no action: a report of the agent, or its refusal.
    pub(super) fn repeat(&mut self, deed: &Deed) {
        match deed {
            Deed::Refused(give_up) => self.refuse(give_up),
            _ => {
                self.enter(deed);
                self.keep_deed(deed.clone());
            }
        }
    }

    /// Ends the episode before its first step, for an agent that cannot start. All deliveries fail.
    pub fn refuse(&mut self, give_up: &GiveUp) {
        self.keep_deed(Deed::Refused(give_up.clone()));
        self.fail_open_targets(give_up.cause, &give_up.detail);
    }

    /// Executes an action and advances the simulated time by 50 ms.
    ///
    /// The robot stands still during a step in which a delivery is declared or given up. After the
    /// end of the episode this has no effect.
    pub fn step(&mut self, action: Action) -> Status {
        if self.status() == Status::Ended {
            return Status::Ended;
        }
        // Before the step: a delivery is declared at the place that the agent has observed.
        let velocity = self.apply(action);
        let before = self.pose();
        self.simulator.step(velocity);
        self.after_step(velocity, before);
        if let Some(how) = self.simulator.left_world() {
            self.fail_open_targets(FailureCause::LeftWorld, &how.to_string());
        } else if self.simulator.time().since(SimTime::ZERO) >= self.episode.time_limit {
            self.fail_open_targets(FailureCause::Timeout, "the time limit has expired");
        }
        self.status()
    }

    /// Ends the rollout and returns its trace. `map` is the agent's copy of the map, OSM XML.
    ///
    /// # Errors
    /// The first error of an observer.
    pub fn finish(mut self, map: Option<Vec<u8>>) -> Result<EpisodeTrace, BenchError> {
        if let Some(error) = self.error {
            return Err(error);
        }
        self.trace.map = map;
        self.trace.frames = self.images.iter().map(frame).collect();
        self.trace.collisions = self.simulator.collisions().to_vec();
        self.trace.sim_seconds = self.simulator.time().seconds();
        self.trace.chain = self.simulator.hash_chain();
        Ok(self.trace)
    }

    /// The simulator, which knows the truth: for rewards and pictures, not for agents.
    pub fn simulator(&self) -> &Simulator {
        &self.simulator
    }

    /// The addresses of the deliveries that have not ended.
    pub fn open_addresses(&self) -> impl Iterator<Item = &Address> {
        let open = self.open_targets().into_iter();
        open.map(|target| &self.episode.targets[target].address)
    }

    fn pose(&self) -> Pose2 {
        Pose2::from_pose3(&self.simulator.base_link())
    }

    /// The true pose in the frame of the public map.
    fn pose_on_map(&self) -> Pose2 {
        let pose = self.pose();
        self.frame.map_or(pose, |frame| frame.compose(pose))
    }

    fn keep_error(&mut self, outcome: Result<(), BenchError>) {
        if let Err(error) = outcome {
            self.error.get_or_insert(error);
        }
    }

    fn after_step(&mut self, velocity: Velocity, before: Pose2) {
        let pose = self.pose();
        let seconds = OBSERVATION_NS as f64 * 1e-9;
        self.task.path_m += before.point().distance(pose.point());
        self.task.smoothness.step(before, pose, seconds);
        self.task.encounters.update(
            seconds,
            &self.simulator.robot_state(),
            self.simulator.movers(),
        );
        self.trace.velocities.push(velocity);
        self.observed = self.simulator.time();
        self.poses.push_back((self.observed, self.pose_on_map()));
        if self.poses.len() > MAX_POSES {
            self.poses.pop_front();
        }
        // Steps end at multiples of 50 ms, so no multiple of the period is missed.
        if self.simulator.time().0.is_multiple_of(DRIVEN_PERIOD_NS) {
            self.trace.driven.push(pose.point());
        }
        for i in 0..self.observers.len() {
            let seen = self.observers[i].step(&self.simulator, velocity);
            self.keep_error(seen);
        }
    }

    /// Applies declarations; returns the velocity that the action commands.
    fn apply(&mut self, action: Action) -> Velocity {
        match action {
            Action::Drive(velocity) => return finite(velocity),
            Action::Delivered(address) => {
                self.delivered(&address);
                self.keep_deed(Deed::Delivered(address));
            }
            Action::GiveUp(give_up) => {
                self.give_up(&give_up);
                self.keep_deed(Deed::GaveUp(give_up));
            }
        }
        Velocity::ZERO
    }

    fn keep_image(&mut self, time: SimTime, image: Arc<Image>) {
        // Several plates may be read in one image.
        if self.images.back().is_some_and(|(last, _)| *last == time) {
            return;
        }
        self.images.push_back((time, image));
        if self.images.len() > MAX_FRAMES {
            self.images.pop_front();
        }
    }

    fn has_ended(&self, target: usize) -> bool {
        self.trace
            .tasks
            .iter()
            .any(|outcome| outcome.target == target)
    }

    /// The deliveries that have not ended, as indices into the targets of the episode.
    pub fn open_targets(&self) -> Vec<usize> {
        (0..self.episode.targets.len())
            .filter(|target| !self.has_ended(*target))
            .collect()
    }

    fn names(&self, target: usize, address: &Address) -> bool {
        // With a point as its goal, an agent has no address to declare.
        if matches!(self.briefing.goal, Goal::Point(_)) {
            return true;
        }
        self.episode.targets[target].address.same_door(address)
    }

    /// A declaration for an address that is not in the instruction fails the first open target. A
    /// second declaration for the same address has no effect.
    fn delivered(&mut self, address: &Address) {
        let open = self.open_targets();
        if let Some(&target) = open.iter().find(|target| self.names(**target, address)) {
            self.end(target, true, None);
            return;
        }
        let again = self
            .trace
            .tasks
            .iter()
            .any(|outcome| self.names(outcome.target, address));
        if let Some(&target) = open.first().filter(|_| !again) {
            let detail = format!("{address} was declared, which the instruction does not name");
            let cause = FailureCause::WrongPlace;
            self.end(target, false, Some(Failure { cause, detail }));
        }
    }

    /// Giving up an address that is not in the instruction ends no delivery yet: the agent may have
    /// misread any of them.
    fn give_up(&mut self, give_up: &GiveUp) {
        let Some(address) = &give_up.address else {
            for target in self.open_targets() {
                let failure = self.misread.pop_front();
                let failure = failure.unwrap_or_else(|| Failure::from(give_up));
                self.end(target, false, Some(failure));
            }
            return;
        };
        let open = self.open_targets();
        if let Some(&target) = open.iter().find(|target| self.names(**target, address)) {
            self.end(target, false, Some(Failure::from(give_up)));
        } else if self.misread.len() < open.len() {
            self.misread.push_back(Failure::from(give_up));
        }
    }

    fn fail_open_targets(&mut self, cause: FailureCause, detail: &str) {
        for target in self.open_targets() {
            let detail = detail.to_owned();
            self.end(target, false, Some(Failure { cause, detail }));
        }
    }

    fn end(&mut self, target: usize, declared: bool, failure: Option<Failure>) {
        let (now, here) = (self.simulator.time(), self.pose().point());
        let collisions = self.simulator.collisions();
        let contacts = self.simulator.contact_durations();
        // All since the last end belongs to the delivery that ends now, whichever it is: agents
        // deliver in an order of their own.
        let next = Task {
            began: now,
            collisions_before: collisions.len(),
            contacts_before: contacts.clone(),
            models_before: self.trace.models,
            plates_before: self.trace.plates.len(),
            ..Task::new(here)
        };
        let task = std::mem::replace(&mut self.task, next);
        self.trace.tasks.push(TaskOutcome {
            target,
            began_at: task.began_at,
            began: task.began,
            ended: now,
            ended_at: here,
            declared,
            path_m: task.path_m,
            smoothness: task.smoothness.sum(),
            collisions: collisions[task.collisions_before..].to_vec(),
            contacts: longer_contacts(&task.contacts_before, contacts),
            encounters: (!self.simulator.movers().is_empty()).then(|| task.encounters.totals()),
            pose_error_m: self.trace.pose_errors.last().map(PoseError::distance),
            plates_read: self.trace.plates.len() - task.plates_before,
            models: self.trace.models.since(task.models_before),
            failure,
        });
    }
}

/// The current delivery.
struct Task {
    began_at: MapPoint,
    began: SimTime,
    path_m: f64,
    collisions_before: usize,
    contacts_before: BTreeMap<SemanticClass, Duration>,
    models_before: ModelUse,
    plates_before: usize,
    encounters: Encounters,
    smoothness: Smoothness,
}

impl Task {
    /// The first delivery, from the start position of the robot.
    fn new(began_at: MapPoint) -> Self {
        Self {
            began_at,
            began: SimTime::ZERO,
            path_m: 0.0,
            collisions_before: 0,
            contacts_before: BTreeMap::new(),
            models_before: ModelUse::default(),
            plates_before: 0,
            encounters: Encounters::new(),
            smoothness: Smoothness::default(),
        }
    }
}

/// By how much the contacts with each class are longer than before.
fn longer_contacts(
    before: &BTreeMap<SemanticClass, Duration>,
    now: BTreeMap<SemanticClass, Duration>,
) -> BTreeMap<SemanticClass, Duration> {
    now.into_iter()
        .map(|(class, time)| {
            let earlier = before.get(&class).copied().unwrap_or_default();
            (class, time.saturating_sub(earlier))
        })
        .filter(|(_, time)| !time.is_zero())
        .collect()
}

fn frame((time, image): &(SimTime, Arc<Image>)) -> Frame {
    Frame {
        time: *time,
        width: image.width,
        height: image.height,
        jpeg: image_file::jpeg(image).unwrap_or_default(),
    }
}

fn plate(time: SimTime, reading: &Reading) -> PlateRead {
    PlateRead {
        time,
        text: reading.text.clone(),
        confidence: reading.confidence(),
        corners: reading.corners(),
    }
}

fn briefing(prepared: &Prepared, episode: &PreparedEpisode, start: Start) -> Briefing {
    Briefing {
        map_osm: prepared.public_data().to_xml(),
        georeference: prepared.public_georeference(),
        goal: match (prepared.suite.goal, prepared.point_goal(episode)) {
            (GoalKind::Point, Some(point)) => Goal::Point(prepared.on_map().point(point)),
            _ => Goal::Instruction(episode.instruction.clone()),
        },
        start,
        robot: prepared.robot.clone(),
        time_limit: prepared.public_time_limit,
    }
}

/// `velocity` with NaN and infinity replaced by zero: neither a motor nor a recording in JSON
/// accepts them.
fn finite(velocity: Velocity) -> Velocity {
    let number = |v: f64| if v.is_finite() { v } else { 0.0 };
    Velocity::new(number(velocity.linear), number(velocity.angular))
}
