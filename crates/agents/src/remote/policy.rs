//! The agent whose decisions another program makes.

use std::sync::Arc;
use std::time::{Duration, Instant};

use openbench_core::{
    Action, Agent, Briefing, Event, Events, FailureCause, GiveUp, Image, Observation, Plan,
    PlannedDelivery, PoseEstimate,
};

use super::link::{Link, LinkError};
use super::message::{Act, Begin, Picture, Reply, Report, Request, Scan};
use super::pool::Pool;

/// How long answers may take, in wall time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patience {
    /// For a program to start, and to read a briefing: networks may be loaded.
    pub begin: Duration,
    /// For an action.
    pub act: Duration,
}

impl Default for Patience {
    fn default() -> Self {
        Self {
            begin: Duration::from_secs(300),
            act: Duration::from_secs(60),
        }
    }
}

/// An agent that asks a policy over a [`Link`].
///
/// A policy that cannot be understood, or is silent for too long, gives up all open deliveries with
/// [`FailureCause::AgentError`]. Its link is closed; the next episode gets another one.
pub struct Policy {
    /// `None` when it has failed.
    link: Option<Box<dyn Link>>,
    pool: Pool,
    seed: u64,
    patience: Patience,
    /// Whether it reports how long its policy takes.
    is_timed: bool,
    /// The last image that the policy got, in which it may have read plates.
    image: Option<Arc<Image>>,
    /// Why the policy is of no use any more.
    failure: Option<String>,
}

impl Policy {
    /// An agent with a link of the pool, for an episode with this seed.
    ///
    /// # Errors
    /// [`LinkError`] of a connection that cannot be made.
    pub fn new(pool: &Pool, seed: u64, patience: Patience) -> Result<Self, LinkError> {
        Ok(Self {
            link: Some(pool.take(patience.begin)?),
            pool: pool.clone(),
            seed,
            patience,
            is_timed: false,
            image: None,
            failure: None,
        })
    }

    /// The same agent, which reports the wall time of each decision ([`Event::WallTime`]), so that
    /// it can be charged.
    #[must_use]
    pub fn timed(self) -> Self {
        Self {
            is_timed: true,
            ..self
        }
    }

    /// Sends a message, and answers what the policy asks before it answers.
    fn ask(
        &mut self,
        request: &Request,
        observation: Option<&Observation<'_>>,
        within: Duration,
    ) -> Result<Answered, LinkError> {
        let link = self.link.as_mut().ok_or(LinkError::ended("before"))?;
        let began = Instant::now();
        let mut rendering = Duration::ZERO;
        link.send(request)?;
        let (mut sent_scan, mut sent_image) = (false, false);
        loop {
            let left = within.saturating_sub(began.elapsed());
            let reply = link.receive(left).map_err(|error| match error {
                LinkError::Silent { .. } => LinkError::Silent { within },
                error => error,
            })?;
            match (&reply, observation) {
                (Reply::WantScan, Some(observation)) if !sent_scan => {
                    sent_scan = true;
                    link.send(&Request::Scan(observation.scan.map(Scan::from)))?;
                }
                (Reply::WantImage, Some(observation)) if !sent_image => {
                    sent_image = true;
                    let before = Instant::now();
                    self.image = observation.camera.image();
                    rendering += before.elapsed();
                    link.send(&Request::Image(self.image.clone().map(Picture::from)))?;
                }
                _ => {
                    // The simulator's time is none of the policy's.
                    let took = began.elapsed().saturating_sub(rendering);
                    return Ok(Answered { reply, took });
                }
            }
        }
    }

    /// The same; reports the wall time that the answer took, or that none came for.
    fn ask_timed(
        &mut self,
        request: &Request,
        observation: Option<&Observation<'_>>,
        within: Duration,
        events: &mut dyn Events,
    ) -> Result<Reply, LinkError> {
        let began = Instant::now();
        let answered = self.ask(request, observation, within);
        let took = match &answered {
            Ok(answered) => answered.took,
            Err(_) => began.elapsed(),
        };
        if self.is_timed {
            events.record(Event::WallTime(took));
        }
        answered.map(|answered| answered.reply)
    }

    /// Reports what a policy reports.
    fn record(&self, reports: Vec<Report>, events: &mut dyn Events) {
        let reported = reports.into_iter().filter_map(|report| self.event(report));
        reported.for_each(|event| events.record(event));
    }

    /// A report as an event; `None` for a plate without an image.
    fn event(&self, report: Report) -> Option<Event> {
        Some(match report {
            Report::Plan(addresses) => Event::Plan(plan(addresses)),
            Report::Task(address) => Event::Task(address),
            Report::Route(points) => Event::Route(points),
            Report::Path(points) => Event::Path(points),
            Report::Pose { pose, health } => Event::PoseEstimate(PoseEstimate { pose, health }),
            Report::Plate {
                text,
                confidence,
                corners,
                position,
            } => Event::PlateRead {
                text,
                confidence,
                corners,
                position,
                image: self.image.clone()?,
            },
            Report::Door { address, position } => Event::DoorWritten { address, position },
            Report::Note(text) => Event::Note(text),
        })
    }

    /// Closes the link of a policy that has failed.
    fn fail(&mut self, detail: String) -> GiveUp {
        self.link = None;
        let detail = self.failure.get_or_insert(detail).clone();
        GiveUp {
            address: None,
            cause: FailureCause::AgentError,
            detail,
        }
    }
}

/// What a policy answered, and the wall time that it took.
struct Answered {
    reply: Reply,
    took: Duration,
}

impl Agent for Policy {
    fn begin(&mut self, briefing: &Briefing, events: &mut dyn Events) -> Result<(), GiveUp> {
        let begin = Request::Begin(Box::new(Begin::new(briefing, self.seed)));
        match self.ask_timed(&begin, None, self.patience.begin, events) {
            Ok(Reply::Ready { reports }) => {
                self.record(reports, events);
                Ok(())
            }
            // It waits for the next episode, as after any other.
            Ok(Reply::Refuse(give_up)) => Err(give_up),
            Ok(Reply::Failed { detail }) => Err(self.fail(detail)),
            Ok(reply) => Err(self.fail(out_of_turn(&reply, "ready or refuse"))),
            Err(error) => Err(self.fail(error.to_string())),
        }
    }

    fn act(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action {
        let act = Request::Act(Act::from(observation));
        match self.ask_timed(&act, Some(observation), self.patience.act, events) {
            Ok(Reply::Action { action, reports }) if is_finite(&action) => {
                self.record(reports, events);
                action
            }
            Ok(Reply::Action { action, .. }) => {
                Action::GiveUp(self.fail(format!("the policy answered {action:?}")))
            }
            Ok(Reply::Failed { detail }) => Action::GiveUp(self.fail(detail)),
            Ok(reply) => Action::GiveUp(self.fail(out_of_turn(&reply, "action"))),
            Err(error) => Action::GiveUp(self.fail(error.to_string())),
        }
    }

    fn finish(&mut self, events: &mut dyn Events) -> Option<Vec<u8>> {
        // Without a link it has failed already.
        self.link.as_ref()?;
        let outcome = self.ask(&Request::Finish, None, self.patience.act);
        let failure = match outcome.map(|answered| answered.reply) {
            Ok(Reply::Finished { map }) => {
                if let Some(link) = self.link.take() {
                    self.pool.give_back(link);
                }
                return map.map(serde_bytes::ByteBuf::into_vec);
            }
            Ok(Reply::Failed { detail }) => detail,
            Ok(reply) => out_of_turn(&reply, "finished"),
            Err(error) => error.to_string(),
        };
        events.record(Event::Note(format!(
            "the policy failed at the end: {failure}"
        )));
        self.fail(failure);
        None
    }
}

fn out_of_turn(reply: &Reply, expected: &'static str) -> String {
    let said = reply.name();
    LinkError::OutOfTurn { said, expected }.to_string()
}

fn is_finite(action: &Action) -> bool {
    match action {
        Action::Drive(velocity) => velocity.linear.is_finite() && velocity.angular.is_finite(),
        Action::Delivered(_) | Action::GiveUp(_) => true,
    }
}

/// The plan of a policy: doors in an order, without routes.
fn plan(addresses: Vec<openbench_core::Address>) -> Plan {
    let deliveries = addresses.into_iter().enumerate();
    let deliveries = deliveries.map(|(index, address)| PlannedDelivery::to(index, address));
    Plan {
        planner: "policy".to_owned(),
        deliveries: deliveries.collect(),
        fallbacks: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;
    use std::sync::Mutex;

    use openbench_core::{
        Address, Camera, Georeference, Goal, LidarScan, LonLat, Pose2, RobotDescription, SimTime,
        Start, Velocity,
    };

    use super::*;

    /// A link with scripted replies, which records the requests.
    struct Script {
        replies: VecDeque<Result<Reply, LinkError>>,
        told: Arc<Mutex<Vec<Request>>>,
    }

    impl Link for Script {
        fn send(&mut self, request: &Request) -> Result<(), LinkError> {
            self.told.lock().unwrap().push(request.clone());
            Ok(())
        }

        fn receive(&mut self, within: Duration) -> Result<Reply, LinkError> {
            self.replies
                .pop_front()
                .unwrap_or(Err(LinkError::Silent { within }))
        }
    }

    struct Black;

    /// How long the camera of the tests takes.
    const SHUTTER: Duration = Duration::from_millis(200);

    impl Camera for Black {
        fn image(&self) -> Option<Arc<Image>> {
            std::thread::sleep(SHUTTER);
            Some(Arc::new(Image {
                stamp: SimTime::ZERO,
                width: 1,
                height: 1,
                rgb: vec![0; 3],
            }))
        }
    }

    /// A policy with scripted replies, the pool of its link, and the recorded requests.
    fn policy(
        replies: impl IntoIterator<Item = Result<Reply, LinkError>>,
    ) -> (Policy, Pool, Arc<Mutex<Vec<Request>>>) {
        let told = Arc::default();
        let pool = Pool::new(|_| Err(LinkError::ended("before")));
        pool.give_back(Box::new(Script {
            replies: replies.into_iter().collect(),
            told: Arc::clone(&told),
        }));
        let policy = Policy::new(&pool, 7, Patience::default()).unwrap();
        (policy, pool, told)
    }

    fn act(policy: &mut Policy) -> (Action, Vec<Event>) {
        let mut events = Vec::new();
        let scan = LidarScan::default();
        let observation = Observation {
            time: SimTime::ZERO,
            imu: &[],
            wheels: &[],
            scan: Some(&scan),
            gnss: None,
            camera: &Black,
        };
        let action = policy.act(&observation, &mut events);
        (action, events)
    }

    fn answer(action: Action) -> Result<Reply, LinkError> {
        Ok(Reply::Action {
            action,
            reports: vec![],
        })
    }

    fn drive(linear: f64) -> Action {
        Action::Drive(Velocity::new(linear, 0.0))
    }

    fn surrender(action: Action) -> GiveUp {
        match action {
            Action::GiveUp(give_up) => give_up,
            other => panic!("{other:?}"),
        }
    }

    fn is_idle(pool: &Pool) -> bool {
        pool.take(Duration::ZERO).is_ok()
    }

    #[test]
    fn a_policy_that_is_timed_reports_how_long_it_took_without_the_camera() {
        let waits = |timed: bool| {
            let (policy, _, _) = policy([Ok(Reply::WantImage), answer(drive(0.2))]);
            let mut policy = if timed { policy.timed() } else { policy };
            act(&mut policy).1
        };
        assert!(waits(false).is_empty());
        let events = waits(true);
        let [Event::WallTime(took)] = events[..] else {
            panic!("{events:?}");
        };
        // The script answers at once; the camera takes its time.
        assert!(took < SHUTTER, "{took:?}");
    }

    #[test]
    fn a_policy_gets_scan_and_image_when_it_wants_them() {
        let replies = [
            Ok(Reply::WantImage),
            Ok(Reply::WantScan),
            answer(drive(0.2)),
        ];
        let (mut policy, _, told) = policy(replies);
        assert_eq!(act(&mut policy).0, drive(0.2));
        let told = told.lock().unwrap();
        assert!(matches!(
            told[..],
            [
                Request::Act(Act { has_scan: true, .. }),
                Request::Image(Some(_)),
                Request::Scan(Some(_))
            ]
        ));
    }

    #[test]
    fn what_it_reports_becomes_events() {
        let (address, position) = (Address::new("b", "1"), Default::default());
        let reports = vec![
            Report::Plan(vec![address.clone()]),
            Report::Door { address, position },
            // Without an image there is no plate.
            Report::Plate {
                text: "1".into(),
                confidence: 1.0,
                corners: [[0.0; 2]; 4],
                position: None,
            },
        ];
        let action = drive(0.1);
        let (mut policy, ..) = policy([Ok(Reply::Action { action, reports })]);
        let (_, events) = act(&mut policy);
        assert!(matches!(
            events[..],
            [Event::Plan(_), Event::DoorWritten { .. }]
        ));
    }

    #[test]
    fn what_is_no_answer_gives_up_with_a_cause() {
        let cases = [
            (answer(drive(f64::NAN)), "NaN"),
            (
                Ok(Reply::Finished { map: None }),
                "said finished where action",
            ),
            (Err(LinkError::TooLong { bytes: 1 << 30 }), "longer than"),
            (
                Ok(Reply::Failed {
                    detail: "KeyError: 3".into(),
                }),
                "KeyError: 3",
            ),
            (
                Err(LinkError::Silent {
                    within: Duration::ZERO,
                }),
                "within 60 s",
            ),
        ];
        for (reply, expected) in cases {
            let (mut policy, pool, _) = policy([reply, answer(drive(0.1))]);
            for _ in 0..2 {
                // It is not asked again.
                let give_up = surrender(act(&mut policy).0);
                assert_eq!(give_up.cause, FailureCause::AgentError);
                assert!(give_up.detail.contains(expected), "{}", give_up.detail);
            }
            assert_eq!(policy.finish(&mut Vec::new()), None);
            assert!(!is_idle(&pool));
        }
    }

    #[test]
    fn a_policy_that_wants_scans_for_ever_is_stopped() {
        let (mut policy, ..) = policy(vec![Ok(Reply::WantScan); 9]);
        let give_up = surrender(act(&mut policy).0);
        assert!(give_up.detail.contains("want_scan"), "{}", give_up.detail);
    }

    #[test]
    fn a_link_is_used_by_the_next_episode() {
        let map = Some(serde_bytes::ByteBuf::from(b"<osm/>".to_vec()));
        let replies = [
            Ok(Reply::Ready { reports: vec![] }),
            Ok(Reply::Finished { map }),
        ];
        let (mut policy, pool, told) = policy(replies);
        let briefing = Briefing {
            map_osm: Vec::new(),
            georeference: Georeference::tangent_plane(LonLat::default()),
            goal: Goal::Instruction("box to unit 1".into()),
            start: Start::exact(Pose2::default()),
            robot: RobotDescription::sentry(),
            time_limit: Duration::from_secs(9),
        };
        policy.begin(&briefing, &mut Vec::new()).unwrap();
        assert_eq!(policy.finish(&mut Vec::new()), Some(b"<osm/>".to_vec()));
        assert!(is_idle(&pool));
        let told = told.lock().unwrap();
        assert!(matches!(&told[0], Request::Begin(begin) if begin.seed == 7));
    }

    #[test]
    fn a_refusal_ends_the_episode_but_not_the_policy() {
        let give_up = GiveUp {
            address: None,
            cause: FailureCause::Briefing,
            detail: "points only".into(),
        };
        let (mut policy, pool, _) = policy([
            Ok(Reply::Refuse(give_up.clone())),
            Ok(Reply::Finished { map: None }),
        ]);
        let briefing = Briefing {
            map_osm: Vec::new(),
            georeference: Georeference::tangent_plane(LonLat::default()),
            goal: Goal::Instruction(String::new()),
            start: Start::exact(Pose2::default()),
            robot: RobotDescription::sentry(),
            time_limit: Duration::ZERO,
        };
        assert_eq!(policy.begin(&briefing, &mut Vec::new()), Err(give_up));
        policy.finish(&mut Vec::new());
        assert!(is_idle(&pool));
    }
}
