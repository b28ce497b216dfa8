//! What every `Agent` keeps to, checked on each implementation.

use std::sync::Arc;
use std::time::Duration;

use openbench_agents::served::{
    Answer, Episode, Question, Recorded, Served, Server, ServerError, Settings,
};
use openbench_agents::{Open, Parts};
use openbench_core::{
    Action, Agent, Briefing, Camera, Event, Events, FailureCause, Georeference, Goal, Image,
    ImuSample, LidarPoint, LidarScan, LonLat, MapPoint, Observation, Pose2, RobotDescription,
    SimTime, Start, Velocity, WheelSample,
};
use openbench_language::GrammarPlanner;
use openbench_localization::DeadReckoning;
use openbench_models::{Exchanges, Meter};
use openbench_motion::costmap::Preferences;
use openbench_motion::follower;
use openbench_osm::OsmData;
use openbench_vision::{PlateReader, PlateReading, ReaderError};

type Make = fn() -> Box<dyn Agent>;

const AGENTS: [Make; 2] = [open, served];

/// Reads nothing anywhere.
struct Blank;

impl PlateReader for Blank {
    fn name(&self) -> &str {
        "blank"
    }

    fn read(&mut self, _image: &Image) -> Result<Vec<PlateReading>, ReaderError> {
        Ok(Vec::new())
    }
}

fn open() -> Box<dyn Agent> {
    Box::new(Open::new(Parts {
        planner: Box::new(GrammarPlanner::new()),
        reader: Box::new(Blank),
        localizer: Box::new(|situation| Box::new(DeadReckoning::new(situation.robot.clone()))),
        motion: follower::entry(),
        ground: Preferences::NONE,
        memory: None,
        meter: Meter::default(),
        thinks_in_simulated_time: false,
    }))
}

/// A server whose policy drives a bend to the left for ever.
struct Bend;

impl Server for Bend {
    fn reach(&mut self) -> Result<(), ServerError> {
        Ok(())
    }

    fn begin(&mut self, _: &Episode) -> Result<(), ServerError> {
        Ok(())
    }

    fn ask(&mut self, _: &Question) -> Result<Answer, ServerError> {
        Ok(Answer::Path {
            points: vec![MapPoint::new(1.0, 0.0), MapPoint::new(2.0, 0.5)],
            lasts_s: None,
        })
    }
}

fn served() -> Box<dyn Agent> {
    let settings = Settings::parse(&Default::default()).unwrap();
    let answers = Recorded::new(&Exchanges::Unkept, Box::new(Bend)).unwrap();
    Box::new(Served::new(answers, settings, 0))
}

/// One house of 6 m x 6 m.
const MAP: &str = r#"<osm version="0.6">
  <node id="1" lat="50.0" lon="8.0"/><node id="2" lat="50.0" lon="8.00008"/>
  <node id="3" lat="50.00005" lon="8.00008"/><node id="4" lat="50.00005" lon="8.0"/>
  <way id="5"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/>
    <tag k="building" v="yes"/><tag k="name" v="building1"/></way></osm>"#;

fn briefing(map: &[u8], instruction: &str) -> Briefing {
    Briefing {
        map_osm: map.to_vec(),
        georeference: Georeference::tangent_plane(LonLat::new(8.0, 50.0)),
        goal: Goal::Instruction(instruction.to_owned()),
        start: Start::exact(Pose2::new(-8.0, 3.0, 0.0)),
        robot: RobotDescription::sentry(),
        time_limit: Duration::from_secs(1200),
    }
}

#[derive(Default)]
struct Kept(Vec<Event>);

impl Events for Kept {
    fn record(&mut self, event: Event) {
        self.0.push(event);
    }
}

struct Grey;

impl Camera for Grey {
    fn image(&self) -> Option<Arc<Image>> {
        let (width, height) = (64, 48);
        Some(Arc::new(Image {
            stamp: SimTime::ZERO,
            width,
            height,
            rgb: vec![128; (3 * width * height) as usize],
        }))
    }
}

/// A world without walls: the robot moves as it is told, and its LiDAR sees flat ground.
struct Plain {
    time: SimTime,
    wheels: [f64; 2],
    velocity: Velocity,
}

impl Plain {
    fn new() -> Self {
        Self {
            time: SimTime::ZERO,
            wheels: [0.0; 2],
            velocity: Velocity::ZERO,
        }
    }

    /// What the agent does in the next 50 ms.
    fn step(&mut self, agent: &mut dyn Agent, events: &mut Kept) -> Action {
        let robot = RobotDescription::sentry();
        let (mut imu, mut wheels) = (Vec::new(), Vec::new());
        for _ in 0..5 {
            self.time = SimTime(self.time.0 + 10_000_000);
            let side = self.velocity.angular * robot.effective_track / 2.0;
            let speeds = [self.velocity.linear - side, self.velocity.linear + side];
            for (angle, speed) in self.wheels.iter_mut().zip(speeds) {
                *angle += speed * 0.01 / robot.wheel_radius;
            }
            let (stamp, [left, right]) = (self.time, self.wheels);
            imu.push(ImuSample {
                stamp,
                gyro: [0.0, 0.0, self.velocity.angular],
                accel: [0.0, 0.0, 9.8],
            });
            wheels.push(WheelSample { stamp, left, right });
        }
        let scan = self
            .time
            .0
            .is_multiple_of(100_000_000)
            .then(|| self.scan(&robot));
        let observation = Observation {
            time: self.time,
            imu: &imu,
            wheels: &wheels,
            scan: scan.as_ref(),
            gnss: None,
            camera: &Grey,
        };
        let action = agent.act(&observation, events);
        self.velocity = if let Action::Drive(v) = &action {
            *v
        } else {
            Velocity::ZERO
        };
        action
    }

    fn scan(&self, robot: &RobotDescription) -> LidarScan {
        let down = -robot.lidar.translation.vector.z as f32;
        let ring = (0..360_u32).map(|i| {
            let bearing = f64::from(i).to_radians();
            let xyz = [
                (2.0 * libm::cos(bearing)) as f32,
                (2.0 * libm::sin(bearing)) as f32,
                down,
            ];
            LidarPoint {
                xyz,
                offset_ns: i * 277_000,
                reflectivity: 50,
                line: 0,
            }
        });
        LidarScan {
            stamp: SimTime(self.time.0 - 100_000_000),
            points: ring.collect(),
        }
    }
}

#[test]
fn an_agent_that_was_not_begun_or_begun_twice_says_so() {
    for make in AGENTS {
        let (mut agent, mut events) = (make(), Kept::default());
        let action = Plain::new().step(agent.as_mut(), &mut events);
        assert!(
            matches!(&action, Action::GiveUp(g) if g.cause == FailureCause::AgentError),
            "{action:?}"
        );
        let briefing = briefing(MAP.as_bytes(), "box to unit 1, building 1");
        agent.begin(&briefing, &mut events).unwrap();
        assert_eq!(
            agent.begin(&briefing, &mut events).unwrap_err().cause,
            FailureCause::AgentError
        );
    }
}

#[test]
fn broken_briefings_are_given_up_with_their_cause() {
    let cases = [
        (
            &b"<osm"[..],
            "box to unit 1, building 1",
            FailureCause::Briefing,
        ),
        (
            b"\xff\xfe",
            "box to unit 1, building 1",
            FailureCause::Briefing,
        ),
        (MAP.as_bytes(), "la la la", FailureCause::NotUnderstood),
    ];
    for make in AGENTS {
        for (map, instruction, cause) in cases {
            let given_up = make()
                .begin(&briefing(map, instruction), &mut Kept::default())
                .unwrap_err();
            assert_eq!(given_up.cause, cause, "{instruction}: {given_up}");
        }
    }
}

/// Actions and events of an agent in the first minutes. The false origin of its `map` frame is
/// `shift` metres farther away.
fn minutes_with_origin_at(make: Make, shift: f64) -> (Vec<Action>, Vec<Event>) {
    let (mut agent, mut events, mut world) = (make(), Kept::default(), Plain::new());
    let at = LonLat::new(8.0, 50.0);
    let near = briefing(MAP.as_bytes(), "box to unit 1, building 1");
    let moved = Briefing {
        georeference: Georeference::TangentPlane {
            at,
            offset_x: shift,
            offset_y: -shift,
        },
        start: near.start.shifted(MapPoint::new(shift, -shift)),
        ..near
    };
    agent.begin(&moved, &mut events).unwrap();
    let actions = (0..20 * 120)
        .map(|_| world.step(agent.as_mut(), &mut events))
        .collect();
    (actions, events.0)
}

#[test]
fn a_false_origin_anywhere_gives_the_same_actions_and_events_in_its_frame() {
    for make in AGENTS {
        let (actions, events) = minutes_with_origin_at(make, 0.0);
        let paths = |events: &[Event]| {
            let path = |e: &Event| {
                if let Event::Path(path) = e {
                    Some(path.clone())
                } else {
                    None
                }
            };
            events.iter().filter_map(path).collect::<Vec<_>>()
        };
        assert!(!paths(&events).is_empty());
        for shift in [5e3, 5e5, 5e6] {
            let (same_actions, moved) = minutes_with_origin_at(make, shift);
            assert!(actions == same_actions, "other actions {shift} m away");
            assert_eq!(events.len(), moved.len());
            for (here, there) in paths(&events)
                .iter()
                .flatten()
                .zip(paths(&moved).iter().flatten())
            {
                let apart = libm::hypot(here.x + shift - there.x, here.y - shift - there.y);
                assert!(apart < 1e-6, "{here} against {there}");
            }
        }
    }
}

#[test]
fn actions_of_open_are_within_reason_repeat_and_come_to_an_end() {
    let run = || {
        let (mut agent, mut events, mut world) = (open(), Kept::default(), Plain::new());
        let briefing = briefing(MAP.as_bytes(), "box to unit 1, building 1");
        agent.begin(&briefing, &mut events).unwrap();
        let mut actions = Vec::new();
        for _ in 0..20 * briefing.time_limit.as_secs() {
            let action = world.step(agent.as_mut(), &mut events);
            actions.push(action.clone());
            match action {
                Action::Drive(v) => {
                    assert!(v.linear.is_finite() && v.angular.is_finite(), "{v:?}")
                }
                Action::Delivered(address) => {
                    panic!("{address} was declared, though no plate was read")
                }
                Action::GiveUp(_) => break,
            }
        }
        let map = agent.finish(&mut events);
        (actions, events.0, map)
    };
    let (actions, events, map) = run();
    assert!(matches!(
        actions.last(),
        Some(Action::GiveUp(g)) if g.cause == FailureCause::DoorNotFound
    ));
    assert!(
        actions
            .iter()
            .any(|a| matches!(a, Action::Drive(v) if v.linear > 0.3))
    );
    assert!(
        events
            .iter()
            .any(|e| matches!(e, Event::Plan(p) if p.deliveries.len() == 1))
    );
    let map = map.expect("OPEN edits its map");
    assert_eq!(OsmData::from_bytes(&map).unwrap().ways.len(), 1);
    let again = run();
    assert!(
        again.0 == actions && again.2 == Some(map),
        "the same briefing and sensors, other actions"
    );
}
