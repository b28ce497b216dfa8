//! Runs an agent through an episode and keeps what happened.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use openbench_core::{
    Action, Address, Agent, Briefing, Event, Events, FailureCause, GiveUp, Goal, Image, MapPoint, ModelUse,
    Plan, Pose2, SimTime, Velocity,
};
use openbench_sim::traffic::{Encounters, Totals};
use openbench_sim::{Collision, OBSERVATION_NS, Simulator};

use crate::BenchError;
use crate::metrics::{PoseError, Smoothness, SmoothnessSum};
use crate::recorder::Recorder;
use crate::stage::{Prepared, PreparedEpisode};
use crate::truth::TruthHandle;

/// How one delivery ended.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskOutcome {
    /// Index into the episode's targets.
    pub target: usize,
    /// Where the robot was when the delivery began: at the start, or where the last one was declared.
    pub began_at: MapPoint,
    /// When it began.
    pub began: SimTime,
    /// When it ended.
    pub ended: SimTime,
    /// Where the robot was at the end.
    pub ended_at: MapPoint,
    /// Whether the agent declared it delivered there.
    pub declared: bool,
    /// Metres driven meanwhile.
    pub path_m: f64,
    /// How smoothly.
    pub smoothness: SmoothnessSum,
    /// Collisions meanwhile.
    pub collisions: Vec<Collision>,
    /// How near the robot came to people and cars meanwhile; `None` where nobody moves.
    pub encounters: Option<Totals>,
    /// Distance between where the agent believed to be and where it was, metres.
    pub pose_error_m: Option<f64>,
    /// Plates read meanwhile.
    pub plates_read: usize,
    /// Why it failed, if it was not declared.
    pub failure: Option<(FailureCause, String)>,
}

/// A plate that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct PlateRead {
    /// When.
    pub time: SimTime,
    /// The text.
    pub text: String,
    /// How sure the reader was, 0 to 1.
    pub confidence: f32,
    /// The text's corners, pixels.
    pub corners: [[f32; 2]; 4],
}

/// An image in which plates were read. Only the last few are kept, since each is a megabyte.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// When it was taken.
    pub time: SimTime,
    /// The image.
    pub image: Arc<Image>,
}

/// Images of one episode that are kept for its report.
const FRAMES: usize = 6;

/// What happened in an episode.
#[derive(Debug, Clone, Default)]
pub struct EpisodeTrace {
    /// In the order in which they ended.
    pub tasks: Vec<TaskOutcome>,
    /// True poses, five a second.
    pub driven: Vec<MapPoint>,
    /// Where the agent believed to be.
    pub estimated: Vec<MapPoint>,
    /// How far that was from where it was.
    pub pose_errors: Vec<PoseError>,
    /// Routes over roads.
    pub routes: Vec<Vec<MapPoint>>,
    /// Doors written by the agent.
    pub doors: Vec<(Address, MapPoint)>,
    /// Plates read.
    pub plates: Vec<PlateRead>,
    /// The last images in which plates were read, oldest first.
    pub frames: VecDeque<Frame>,
    /// The agent's plan.
    pub plan: Option<Plan>,
    /// What the agent asked of models.
    pub models: ModelUse,
    /// All collisions.
    pub collisions: Vec<Collision>,
    /// Simulated seconds.
    pub sim_seconds: f64,
    /// The velocities that were driven, one a step.
    pub velocities: Vec<Velocity>,
    /// Hash over all states.
    pub chain: [u8; 32],
    /// The agent's copy of the map.
    pub map: Option<Vec<u8>>,
}

/// Runs one episode from a seed. Steps are reported to `recorder`.
pub fn run_episode(
    prepared: &Prepared,
    episode: &PreparedEpisode,
    agent: &mut dyn Agent,
    truth: &TruthHandle,
    seed: u64,
    recorder: &mut Recorder,
) -> Result<EpisodeTrace, BenchError> {
    let simulator = prepared.simulator(seed)?;
    let mut run = Run {
        episode,
        simulator,
        trace: EpisodeTrace::default(),
        task: Task::new(prepared),
        recorder,
        error: None,
    };
    truth.set(SimTime::ZERO, run.pose());
    run.drive(agent, &briefing(prepared, episode), truth);
    run.finish(agent)
}

fn briefing(prepared: &Prepared, episode: &PreparedEpisode) -> Briefing {
    Briefing {
        map_osm: prepared.world.map.to_xml(),
        georeference: prepared.world.georeference,
        goal: Goal::Instruction(episode.instruction.clone()),
        start: prepared.world.start,
        robot: prepared.robot.clone(),
        time_limit: stated_limit(episode.time_limit),
    }
}

/// The time limit as agents are told it, in whole ten minutes: the exact one is made from the true way to the door.
fn stated_limit(exact: Duration) -> Duration {
    const STEP: u64 = 600;
    Duration::from_secs((exact.as_secs() / STEP + 1) * STEP)
}

/// `velocity` without what is no number: no motor takes it, and no recording holds it.
fn finite(velocity: Velocity) -> Velocity {
    let number = |v: f64| if v.is_finite() { v } else { 0.0 };
    Velocity::new(number(velocity.linear), number(velocity.angular))
}

/// The delivery at hand.
struct Task {
    began_at: MapPoint,
    began: SimTime,
    path_m: f64,
    collisions_before: usize,
    plates_before: usize,
    encounters: Encounters,
    smoothness: Smoothness,
}

impl Task {
    fn new(prepared: &Prepared) -> Self {
        Self::from(prepared.world.start.point(), SimTime::ZERO, 0, 0)
    }

    fn from(began_at: MapPoint, began: SimTime, collisions_before: usize, plates_before: usize) -> Self {
        let encounters = Encounters::new();
        let smoothness = Smoothness::default();
        Self { began_at, began, path_m: 0.0, collisions_before, plates_before, encounters, smoothness }
    }
}

struct Run<'a> {
    episode: &'a PreparedEpisode,
    simulator: Simulator,
    trace: EpisodeTrace,
    task: Task,
    recorder: &'a mut Recorder,
    error: Option<BenchError>,
}

impl Run<'_> {
    fn pose(&self) -> Pose2 {
        Pose2::from_pose3(&self.simulator.base_link())
    }

    fn drive(&mut self, agent: &mut dyn Agent, briefing: &Briefing, truth: &TruthHandle) {
        let mut listener = Listener::at(SimTime::ZERO);
        let begun = agent.begin(briefing, &mut listener);
        self.take_in(listener);
        if let Err(give_up) = begun {
            self.give_up(&give_up);
            return;
        }
        while self.trace.tasks.len() < self.episode.targets.len() && self.error.is_none() {
            if self.simulator.time().0 >= self.episode.time_limit.as_nanos() as u64 {
                self.fail_rest(FailureCause::Timeout, "the time limit is over");
                return;
            }
            let mut listener = Listener::at(self.simulator.time());
            let action = agent.act(&self.simulator.observation(), &mut listener);
            self.take_in(listener);
            let velocity = self.apply(action);
            let before = self.pose();
            self.simulator.step(velocity);
            self.after_step(velocity, before, truth);
            if let Some(how) = self.simulator.left_world() {
                self.fail_rest(FailureCause::LeftWorld, &how.to_string());
            }
        }
    }

    fn after_step(&mut self, velocity: Velocity, before: Pose2, truth: &TruthHandle) {
        let (time, pose) = (self.simulator.time(), self.pose());
        truth.set(time, pose);
        self.task.path_m += before.point().distance(pose.point());
        self.trace.velocities.push(velocity);
        let step = OBSERVATION_NS as f64 * 1e-9;
        self.task.smoothness.step(before, pose, step);
        self.task.encounters.update(step, &self.simulator.robot_state(), self.simulator.movers());
        if time.0.is_multiple_of(200_000_000) {
            self.trace.driven.push(pose.point());
        }
        if let Err(error) = self.recorder.step(&self.simulator, velocity) {
            self.error.get_or_insert(error.into());
        }
    }

    fn apply(&mut self, action: Action) -> Velocity {
        match action {
            Action::Drive(velocity) => return finite(velocity),
            Action::Delivered(address) => self.delivered(&address),
            Action::GiveUp(give_up) => self.give_up(&give_up),
        }
        Velocity::ZERO
    }

    fn take_in(&mut self, listener: Listener) {
        let time = listener.time;
        for event in listener.events {
            if let Err(error) = self.recorder.event(time, &event) {
                self.error.get_or_insert(error.into());
            }
            match event {
                Event::Plan(plan) => self.trace.plan = Some(plan),
                Event::Route(points) => self.trace.routes.push(points),
                Event::PoseEstimate(told) => {
                    self.trace.estimated.push(told.pose.point());
                    self.trace.pose_errors.push(PoseError::new(time, self.pose(), told));
                }
                Event::DoorWritten { address, position } => {
                    // A door that is written again was moved.
                    self.trace.doors.retain(|(known, _)| !known.same_door(&address));
                    self.trace.doors.push((address, position));
                }
                Event::PlateRead { text, confidence, corners, image, .. } => {
                    self.trace.plates.push(PlateRead { time, text, confidence, corners });
                    self.keep_frame(Frame { time, image });
                }
                Event::Models(used) => self.trace.models = used,
                _ => {}
            }
        }
    }

    fn keep_frame(&mut self, frame: Frame) {
        let frames = &mut self.trace.frames;
        if frames.back().is_some_and(|last| last.time == frame.time) {
            return;
        }
        frames.push_back(frame);
        if frames.len() > FRAMES {
            frames.pop_front();
        }
    }

    /// Targets that have not ended yet.
    fn open_targets(&self) -> Vec<usize> {
        (0..self.episode.targets.len()).filter(|t| self.trace.tasks.iter().all(|o| o.target != *t)).collect()
    }

    /// The open target of that address; an address that nobody asked for counts against the first open one.
    fn target_for(&self, address: &Address) -> Option<(usize, bool)> {
        let open = self.open_targets();
        let meant = open.iter().copied().find(|&t| self.episode.targets[t].address.same_door(address));
        meant.map(|t| (t, true)).or_else(|| open.first().map(|&t| (t, false)))
    }

    fn delivered(&mut self, address: &Address) {
        let targets = &self.episode.targets;
        let ended = self.trace.tasks.iter().any(|t| targets[t.target].address.same_door(address));
        let open = self.target_for(address).filter(|(_, asked_for)| *asked_for || !ended);
        let Some((target, asked_for)) = open else { return };
        let wrong = || {
            (FailureCause::WrongPlace, format!("{address} was declared, which the instruction does not name"))
        };
        self.end(target, asked_for, (!asked_for).then(wrong));
    }

    fn give_up(&mut self, give_up: &GiveUp) {
        match &give_up.address {
            None => self.fail_rest(give_up.cause, &give_up.detail),
            Some(address) => {
                // Giving up what nobody asked for costs nothing.
                if let Some((target, true)) = self.target_for(address) {
                    self.end(target, false, Some((give_up.cause, give_up.detail.clone())));
                }
            }
        }
    }

    fn fail_rest(&mut self, cause: FailureCause, detail: &str) {
        for target in self.open_targets() {
            self.end(target, false, Some((cause, detail.to_owned())));
        }
    }

    fn end(&mut self, target: usize, declared: bool, failure: Option<(FailureCause, String)>) {
        let (now, here) = (self.simulator.time(), self.pose().point());
        let collisions = self.simulator.collisions();
        let outcome = TaskOutcome {
            target,
            began_at: self.task.began_at,
            began: self.task.began,
            ended: now,
            ended_at: here,
            declared,
            path_m: self.task.path_m,
            smoothness: self.task.smoothness.sum(),
            collisions: collisions[self.task.collisions_before..].to_vec(),
            encounters: (!self.simulator.movers().is_empty()).then(|| self.task.encounters.totals()),
            pose_error_m: self.trace.estimated.last().map(|p| p.distance(here)),
            plates_read: self.trace.plates.len() - self.task.plates_before,
            failure,
        };
        self.task = Task::from(here, now, collisions.len(), self.trace.plates.len());
        self.trace.tasks.push(outcome);
    }

    fn finish(mut self, agent: &mut dyn Agent) -> Result<EpisodeTrace, BenchError> {
        let mut listener = Listener::at(self.simulator.time());
        self.trace.map = agent.finish(&mut listener);
        self.take_in(listener);
        self.trace.collisions = self.simulator.collisions().to_vec();
        self.trace.sim_seconds = self.simulator.time().seconds();
        self.trace.chain = self.simulator.chain();
        self.error.map_or(Ok(self.trace), Err)
    }
}

/// Collects the events of one instant.
struct Listener {
    time: SimTime,
    events: Vec<Event>,
}

impl Listener {
    fn at(time: SimTime) -> Self {
        Self { time, events: Vec::new() }
    }
}

impl Events for Listener {
    fn record(&mut self, event: Event) {
        self.events.push(event);
    }
}
