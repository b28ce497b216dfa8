//! The agent that senses and drives as a policy server says.

use std::collections::VecDeque;

use openbench_core::{
    Action, Address, Agent, Briefing, Event, Events, FailureCause, GiveUp, Goal, MapPoint,
    ModelUse, Observation, Plan, Pose2, PoseEstimate, SimTime, TravelTimes, Velocity, Work,
    frames::wrap_angle, with_causes,
};
use openbench_language::{GrammarPlanner, PlanRequest, Planner};
use openbench_localization::{LidarInertial, Localizer};
use openbench_osm::{OsmData, OsmMap};

use super::depth::RecentScans;
use super::driving::{Command, Driving};
use super::question::{Answer, Episode, Question, Timed};
use super::recorded::Recorded;
use super::settings::{Actions, Settings};
use crate::Border;

/// What a policy reads whose goal is a point.
const TO_THE_POINT: &str = "drive to the goal";
/// The name of a point, which has no address.
const POINT: &str = "goal";

/// An agent that asks a policy server what to do.
///
/// It keeps the robot's pose by LiDAR-inertial odometry, sends images, and drives the velocities or
/// along the points that are answered. The server decides all else; nothing keeps the robot from
/// driving against a wall.
pub struct Served {
    answers: Recorded,
    settings: Settings,
    seed: u64,
    border: Border,
    errand: Option<Errand>,
    /// Why the server is of no use any more.
    failure: Option<GiveUp>,
}

/// What is done in an episode.
struct Errand {
    localizer: LidarInertial,
    driving: Driving,
    words: String,
    start: Pose2,
    goal: Option<MapPoint>,
    /// The deliveries that are left.
    open: VecDeque<Address>,
    /// What was commanded last.
    velocity: Velocity,
    /// An answer that does not take effect yet.
    coming: Option<Coming>,
    used: ModelUse,
    number: u64,
    /// For servers that want depth images.
    scans: Option<RecentScans>,
}

/// An answer that takes effect later, since its computation is charged.
struct Coming {
    answer: Answer,
    /// Where the robot was when it was asked for.
    pose: Pose2,
    due: SimTime,
}

impl Served {
    /// An agent with a server, for an episode with this seed.
    pub fn new(answers: Recorded, settings: Settings, seed: u64) -> Self {
        Self {
            answers,
            settings,
            seed,
            border: Border::default(),
            errand: None,
            failure: None,
        }
    }

    /// Gives up all that is left; the server is not asked again.
    fn fail(&mut self, cause: FailureCause, detail: String) -> GiveUp {
        self.failure.get_or_insert(surrender(cause, detail)).clone()
    }
}

impl Agent for Served {
    fn begin(&mut self, briefing: &Briefing, events: &mut dyn Events) -> Result<(), GiveUp> {
        if self.errand.is_some() || self.failure.is_some() {
            let detail = "the agent was begun twice; make a new one for each episode".to_owned();
            return Err(surrender(FailureCause::AgentError, detail));
        }
        let (border, briefing) = Border::of(briefing);
        self.border = border;
        let wants_depth = self.answers.wants_depth();
        let events = &mut border.events(events);
        let errand = Errand::begin(&briefing, &self.settings, wants_depth, events);
        let errand = errand.inspect_err(|give_up| self.failure = Some(give_up.clone()))?;
        let episode = Episode {
            words: errand.words.clone(),
            has_point: errand.goal.is_some(),
            robot: briefing.robot.clone(),
            seed: self.seed,
        };
        self.errand = Some(errand);
        let begun = self.answers.begin(&episode);
        begun.map_err(|error| self.fail(error.cause(), with_causes(&error)))
    }

    fn act(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action {
        if let Some(give_up) = &self.failure {
            return Action::GiveUp(give_up.clone());
        }
        let Some(errand) = &mut self.errand else {
            let detail = "the agent was not begun".to_owned();
            return Action::GiveUp(surrender(FailureCause::AgentError, detail));
        };
        let events = &mut self.border.events(events);
        errand.sense(observation, events);
        if errand.has_arrived(&self.settings) {
            return errand.declare();
        }
        let question = errand.question(observation);
        if let Some(question) = question {
            match self.answers.ask(&question) {
                Ok(timed) => errand.take(timed, &self.settings, observation.time),
                Err(error) => {
                    errand.used.calls += 1;
                    errand.used.failed += 1;
                    events.record(Event::Models(errand.used));
                    let detail = with_causes(&error);
                    return Action::GiveUp(self.fail(error.cause(), detail));
                }
            }
            events.record(Event::Models(errand.used));
        }
        errand.act(observation.time, events)
    }

    fn finish(&mut self, _: &mut dyn Events) -> Option<Vec<u8>> {
        self.answers.end();
        None
    }
}

impl Errand {
    fn begin(
        briefing: &Briefing,
        settings: &Settings,
        wants_depth: bool,
        events: &mut dyn Events,
    ) -> Result<Self, GiveUp> {
        let start = briefing.start_pose()?;
        let (words, goal, open) = match &briefing.goal {
            Goal::Instruction(words) => {
                if settings.actions != Actions::Velocity {
                    // Nothing in them says that the robot has arrived.
                    let detail = "points declare no delivery; run a suite with `goal = \"point\"`";
                    return Err(surrender(FailureCause::Briefing, detail.to_owned()));
                }
                let open = deliveries(briefing, start, words, events);
                let open = open.map_err(|(cause, detail)| surrender(cause, detail))?;
                (words.clone(), None, open)
            }
            Goal::Point(point) => {
                let address = Address {
                    building: POINT.to_owned(),
                    unit: None,
                };
                (TO_THE_POINT.to_owned(), Some(*point), [address].into())
            }
            Goal::Image(_) => {
                let detail = "policy servers take instructions and points only".to_owned();
                return Err(surrender(FailureCause::Briefing, detail));
            }
        };
        let driving = Driving::new(&briefing.robot, settings.replan);
        let driving = driving.map_err(|e| surrender(FailureCause::Briefing, with_causes(&e)))?;
        let mut localizer = LidarInertial::new(briefing.robot.clone());
        localizer.reset(start);
        Ok(Self {
            localizer,
            driving,
            words,
            start,
            goal,
            open,
            velocity: Velocity::ZERO,
            coming: None,
            used: ModelUse::default(),
            number: 0,
            scans: wants_depth.then(|| RecentScans::new(briefing.robot.clone())),
        })
    }

    fn sense(&mut self, observation: &Observation<'_>, events: &mut dyn Events) {
        self.localizer.update(observation);
        if let Some(scan) = observation.scan {
            events.record(Event::Work(Work::Registration));
            if let Some(scans) = &mut self.scans {
                scans.take(scan, &self.localizer);
            }
            let (pose, health) = (self.localizer.pose(), self.localizer.health());
            events.record(Event::PoseEstimate(PoseEstimate { pose, health }));
        }
    }

    /// Whether the robot is at the point that it was to drive to.
    fn has_arrived(&self, settings: &Settings) -> bool {
        let pose = self.localizer.pose().point();
        match (self.goal, settings.arrival_m) {
            (Some(goal), Some(radius)) => pose.distance(goal) <= radius,
            _ => false,
        }
    }

    /// What to ask now, if anything.
    fn question(&self, observation: &Observation<'_>) -> Option<Question> {
        let is_due = self.localizer.ready() && self.driving.is_due(observation.time);
        if !is_due || self.coming.is_some() {
            return None;
        }
        let pose = self.localizer.pose();
        let (x, y) = self.start.inverse_transform(pose.point());
        let in_odom = Pose2::new(x, y, wrap_angle(pose.yaw - self.start.yaw));
        let in_base = |goal| {
            let (x, y) = pose.inverse_transform(goal);
            MapPoint::new(x, y)
        };
        Some(Question {
            // Later, if the camera has none at this instant.
            image: observation.camera.image()?,
            words: self.words.clone(),
            goal: self.goal.map(in_base),
            pose: in_odom,
            velocity: self.velocity,
            number: self.number,
            depth: self.scans.as_ref().map(|scans| scans.depth(pose)),
        })
    }

    /// Takes in an answer.
    fn take(&mut self, timed: Timed, settings: &Settings, now: SimTime) {
        let Timed { answer, took } = timed;
        self.number += 1;
        self.used.calls += 1;
        self.used.latency_ms += took.as_millis() as u64;
        let due = if settings.is_charged { now + took } else { now };
        self.coming = Some(Coming {
            answer,
            pose: self.localizer.pose(),
            due,
        });
    }

    /// Does what the newest answer that takes effect says.
    fn act(&mut self, now: SimTime, events: &mut dyn Events) -> Action {
        if let Some(coming) = self.coming.take_if(|coming| coming.due <= now) {
            self.driving.follow(coming.answer, coming.pose, now);
            if !self.driving.path().is_empty() {
                events.record(Event::Path(self.driving.path().to_vec()));
            }
        }
        match self
            .driving
            .command(now, self.localizer.pose(), self.velocity)
        {
            Command::Declare => self.declare(),
            Command::Drive(velocity) => {
                self.velocity = velocity;
                Action::Drive(velocity)
            }
        }
    }

    /// Declares the delivery that is next; the policy is then asked anew.
    fn declare(&mut self) -> Action {
        self.driving.stop();
        self.velocity = Velocity::ZERO;
        match self.open.pop_front() {
            Some(address) => Action::Delivered(address),
            None => Action::GiveUp(surrender(
                FailureCause::NotDeclared,
                "every delivery that was understood is done".to_owned(),
            )),
        }
    }
}

/// Gives up all deliveries that are left.
fn surrender(cause: FailureCause, detail: String) -> GiveUp {
    GiveUp {
        address: None,
        cause,
        detail,
    }
}

/// The addresses of an instruction, in driving order: policies say that they have arrived, but not
/// where.
fn deliveries(
    briefing: &Briefing,
    start: Pose2,
    instruction: &str,
    events: &mut dyn Events,
) -> Result<VecDeque<Address>, (FailureCause, String)> {
    let data = OsmData::from_bytes(&briefing.map_osm)
        .map_err(|error| (FailureCause::Briefing, with_causes(&error)))?;
    let map = OsmMap::new(&data, briefing.georeference);
    let request = PlanRequest {
        instruction,
        map: &map,
        start: start.point(),
        times: &Straight,
    };
    let plan: Plan = GrammarPlanner::new()
        .plan(&request)
        .map_err(|error| (FailureCause::NotUnderstood, with_causes(&error)))?;
    events.record(Event::Plan(plan.clone()));
    Ok(plan
        .deliveries
        .iter()
        .map(|delivery| delivery.address())
        .collect())
}

/// Straight lines, at 1 m/s.
struct Straight;

impl TravelTimes for Straight {
    fn matrix(&self, places: &[MapPoint]) -> Vec<f64> {
        let to_all = |from: &MapPoint| {
            let from = *from;
            places.iter().map(move |to| from.distance(*to))
        };
        places.iter().flat_map(to_all).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Duration;

    use openbench_core::{
        Camera, Georeference, Image, ImuSample, LidarScan, LonLat, RobotDescription, Start,
    };
    use openbench_models::Exchanges;

    use super::super::error::ServerError;
    use super::super::question::Step;
    use super::super::testing::{Script, image};
    use super::*;

    struct Still;

    impl Camera for Still {
        fn image(&self) -> Option<Arc<Image>> {
            Some(image())
        }
    }

    fn agent(script: Script, charged: bool) -> Served {
        let mut settings = Settings::parse(&Default::default()).unwrap();
        settings.is_charged = charged;
        let answers = Recorded::new(&Exchanges::Unkept, Box::new(script)).unwrap();
        Served::new(answers, settings, 7)
    }

    fn briefing(goal: Goal) -> Briefing {
        Briefing {
            map_osm: b"<osm version='0.6'/>".to_vec(),
            georeference: Georeference::tangent_plane(LonLat::default()),
            goal,
            start: Start::exact(Pose2::default()),
            robot: RobotDescription::sentry(),
            time_limit: Duration::from_secs(60),
        }
    }

    /// What an agent does that stands on a plain for so many steps.
    fn acts(agent: &mut Served, steps: u64) -> Vec<Action> {
        let mut events = Vec::new();
        let act = |step: u64| {
            let at = |millis| SimTime::from_millis(50 * step + millis);
            let imu = [0, 10, 20, 30, 40].map(|millis| ImuSample {
                stamp: at(millis),
                gyro: [0.0; 3],
                accel: [0.0, 0.0, 9.81],
            });
            let scan = LidarScan {
                stamp: at(0),
                points: Vec::new(),
            };
            let observation = Observation {
                time: at(50),
                imu: &imu,
                wheels: &[],
                scan: step.is_multiple_of(2).then_some(&scan),
                gnss: None,
                camera: &Still,
            };
            agent.act(&observation, &mut events)
        };
        (0..steps).map(act).collect()
    }

    fn velocities(linear: f64, declares: bool) -> Answer {
        let velocity = Velocity::new(linear, 0.0);
        let step = Step { velocity, declares };
        Answer::Velocities {
            period_s: 0.1,
            steps: vec![step],
        }
    }

    #[test]
    fn a_policy_drives_and_declares() {
        let script = Script::new([Ok(velocities(0.25, false)), Ok(velocities(0.0, true))]);
        let mut agent = agent(script, false);
        let goal = Goal::Point(MapPoint::new(5.0, 0.0));
        agent.begin(&briefing(goal), &mut Vec::new()).unwrap();
        let actions = acts(&mut agent, 60);
        let declared = actions
            .iter()
            .position(|a| matches!(a, Action::Delivered(_)));
        let driven = actions
            .iter()
            .filter(|a| **a == Action::Drive(Velocity::new(0.25, 0.0)));
        assert_eq!(driven.count(), 2, "{actions:?}");
        assert!(declared.is_some(), "{actions:?}");
    }

    #[test]
    fn at_the_point_it_declares_without_being_told() {
        let mut agent = agent(Script::new([]), false);
        let goal = Goal::Point(MapPoint::new(0.5, 0.5));
        agent.begin(&briefing(goal), &mut Vec::new()).unwrap();
        assert!(matches!(acts(&mut agent, 1)[0], Action::Delivered(_)));
    }

    #[test]
    fn a_server_that_fails_is_not_asked_again() {
        let late = ServerError::Silent {
            within: Duration::from_secs(1),
        };
        let mut agent = agent(Script::new([Err(late), Ok(velocities(0.3, false))]), false);
        let goal = Goal::Point(MapPoint::new(5.0, 0.0));
        agent.begin(&briefing(goal), &mut Vec::new()).unwrap();
        let actions = acts(&mut agent, 60);
        let first = actions.iter().position(|a| matches!(a, Action::GiveUp(_)));
        for action in &actions[first.unwrap()..] {
            let Action::GiveUp(give_up) = action else {
                panic!("{action:?}");
            };
            assert_eq!(give_up.cause, FailureCause::PolicyUnavailable);
            assert!(give_up.detail.contains("within 1 s"), "{give_up}");
        }
    }

    #[test]
    fn images_are_no_goals() {
        let goal = Goal::Image((*image()).clone());
        let begun = agent(Script::new([]), false).begin(&briefing(goal), &mut Vec::new());
        assert_eq!(begun.unwrap_err().cause, FailureCause::Briefing);
    }

    #[test]
    fn a_charged_answer_takes_effect_when_it_came() {
        let goal = Goal::Point(MapPoint::new(5.0, 0.0));
        let mut errand = Errand::begin(
            &briefing(goal),
            &Settings::parse(&Default::default()).unwrap(),
            false,
            &mut Vec::new(),
        )
        .unwrap();
        let mut settings = Settings::parse(&Default::default()).unwrap();
        settings.is_charged = true;
        let timed = Timed {
            answer: velocities(0.25, false),
            took: Duration::from_millis(120),
        };
        errand.take(timed, &settings, SimTime::from_millis(1000));
        let drives = |errand: &mut Errand, millis| {
            errand.act(SimTime::from_millis(millis), &mut Vec::new())
                == Action::Drive(Velocity::new(0.25, 0.0))
        };
        assert!(!drives(&mut errand, 1000) && !drives(&mut errand, 1100));
        assert!(drives(&mut errand, 1150) && drives(&mut errand, 1200));
        assert!(!drives(&mut errand, 1250));
    }
}
