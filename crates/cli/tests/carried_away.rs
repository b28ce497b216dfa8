//! OPEN is carried away while it delivers, as by somebody who lifts the robot.

use std::collections::BTreeMap;

use openbench_agents::Open;
use openbench_agents::open::{Catalogue, Models, Settings};
use openbench_bench::worlds::suite_of_seed;
use openbench_bench::{Prepared, Rollout};
use openbench_core::{Action, Agent, Event, MapPoint, Pose2, SimTime};
use openbench_models::Exchanges;

/// Where the robot is carried: in front of another door, so far away, metres.
const CARRIED_M: std::ops::Range<f64> = 20.0..60.0;
/// As near to the door a delivery is a success, metres.
const SUCCESS_M: f64 = 2.0;

/// OPEN that localizes itself on the map.
fn open() -> Open {
    let words = BTreeMap::from([("fixes".to_owned(), "osm".to_owned())]);
    let settings = Settings::parse(&words).unwrap();
    let mut models = Models::new(settings.budget, Exchanges::Unkept);
    let parts = Catalogue::default().assemble(&settings, &mut models, None);
    Open::new(parts.unwrap())
}

/// How the first delivery ended, of which the robot was carried away after so many seconds.
struct Ended {
    notes: Vec<String>,
    /// Distance from where the parcel was put down to the door, metres.
    away_m: f64,
}

fn deliver(prepared: &Prepared, carried_after_s: u64) -> Ended {
    let episode = &prepared.episodes[0];
    let rollout = Rollout::new(prepared, 0, 1).unwrap();
    let mut simulator = prepared.simulator_at(episode.start, 1).unwrap();
    let (mut agent, mut events) = (open(), Vec::new());
    agent.begin(rollout.briefing(), &mut events).unwrap();
    let doors = &prepared.approach;
    let target = doors[episode.targets[0].door.unwrap()].unwrap();
    let place =
        |simulator: &openbench_sim::Simulator| Pose2::from_pose3(&simulator.base_link()).point();
    let carried = SimTime::from_millis(1000 * carried_after_s);
    loop {
        if simulator.time() == carried {
            let here = place(&simulator);
            let is_elsewhere = |door: &&MapPoint| CARRIED_M.contains(&door.distance(here));
            let there = doors.iter().flatten().find(is_elsewhere).unwrap();
            simulator.carry_to(Pose2::new(there.x, there.y, 1.0));
        }
        match agent.act(&simulator.observation(), &mut events) {
            Action::Drive(velocity) => simulator.step(velocity),
            Action::Delivered(_) => break,
            other => panic!("{other:?}"),
        }
        assert!(simulator.time() < SimTime::from_millis(900_000), "too late");
    }
    let note = |event| match event {
        Event::Note(note) => Some(note),
        _ => None,
    };
    Ended {
        notes: events.into_iter().filter_map(note).collect(),
        away_m: place(&simulator).distance(target),
    }
}

#[test]
fn a_robot_that_is_carried_away_finds_itself_and_delivers() {
    let suite = suite_of_seed("small", 5).unwrap();
    let prepared = Prepared::new(suite, None).unwrap();
    for seconds in [20, 40] {
        let ended = deliver(&prepared, seconds);
        let says = |words: &str| ended.notes.iter().any(|note| note.contains(words));
        assert!(says("is searched for"), "{:#?}", ended.notes);
        assert!(
            ended.away_m < SUCCESS_M,
            "{} m: {:#?}",
            ended.away_m,
            ended.notes
        );
    }
}
