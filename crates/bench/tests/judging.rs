//! Whom the judge believes, and what it measures, in drives through the world of *small*.

use openbench_bench::report::terminal_table;
use openbench_bench::run::registry::{AgentError, AgentSettings};
use openbench_bench::{
    AgentFactory, AgentRequest, Episode, Prepared, Results, RunRecord, RunRequest, Truth,
    builtin_suite, run, verify, yardsticks,
};
use openbench_core::{
    Action, Address, Agent, Briefing, Events, FailureCause, GiveUp, MapPoint, Observation, Pose2,
};

fn address(building: u32, unit: u32) -> Address {
    Address {
        building: format!("building{building}"),
        unit: Some(format!("unit{unit}")),
    }
}

/// The world of *small* with one episode.
fn prepared(deliveries: &[Address]) -> Prepared {
    let mut suite = builtin_suite("small").unwrap();
    suite.episodes = vec![Episode {
        instruction: "as the addresses say".into(),
        deliveries: deliveries.to_vec(),
        before: (1..deliveries.len()).map(|i| (i - 1, i)).collect(),
    }];
    Prepared::new(suite, None).unwrap()
}

/// What is done instead of an action.
type Change = Box<dyn FnMut(Action) -> Action>;

/// Drives to every door of `told`, whatever its instruction says, and does something else there.
struct Misled {
    told: Prepared,
    change: fn() -> Change,
}

impl AgentFactory for Misled {
    fn make(&self, request: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
        let truth = request.truth.clone().ok_or("it uses the truth")?;
        let omniscient = yardsticks::agents()
            .get("omniscient")?
            .make(&AgentRequest {
                truth: Some(Truth {
                    prepared: &self.told,
                    ..truth
                }),
                ..request.clone()
            })?;
        Ok(Box::new(Changed {
            inner: omniscient,
            change: (self.change)(),
        }))
    }

    fn uses_truth(&self, _: &AgentSettings) -> bool {
        true
    }
}

struct Changed {
    inner: Box<dyn Agent>,
    change: Change,
}

impl Agent for Changed {
    fn begin(&mut self, briefing: &Briefing, events: &mut dyn Events) -> Result<(), GiveUp> {
        self.inner.begin(briefing, events)
    }

    fn act(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action {
        (self.change)(self.inner.act(observation, events))
    }
}

/// What an agent is given for driving to `told` where `asked` is asked for.
fn judged(asked: &[Address], told: &[Address], change: fn() -> Change) -> Results {
    let factory = Misled {
        told: prepared(told),
        change,
    };
    let prepared = prepared(asked);
    let request = RunRequest {
        seed: 3,
        ..RunRequest::new(&prepared, "misled", &factory)
    };
    run(&request).unwrap().results
}

fn as_it_is() -> Change {
    Box::new(|action| action)
}

/// Declares deliveries at this address, wherever it is.
fn as_unit_1_of_building_3() -> Change {
    Box::new(|action| match action {
        Action::Delivered(_) => Action::Delivered(address(3, 1)),
        other => other,
    })
}

#[test]
fn a_parcel_at_the_neighbours_door_is_not_delivered() {
    let (asked, told) = ([address(3, 1)], [address(3, 2)]);
    let results = judged(&asked, &told, as_unit_1_of_building_3);
    let delivery = &results.deliveries[0];
    assert!(delivery.declared_at.is_some());
    assert!(!delivery.success_2m && !delivery.correct_unit);
    assert_eq!(delivery.failure, Some(FailureCause::WrongPlace));
    // The same parcel at its own door.
    let right = judged(&asked, &asked, as_it_is);
    assert!(right.deliveries[0].success_2m && right.deliveries[0].correct_unit);
}

#[test]
fn the_right_door_under_a_wrong_address_is_not_delivered() {
    let (asked, told) = ([address(3, 2)], [address(3, 2)]);
    let results = judged(&asked, &told, as_unit_1_of_building_3);
    let delivery = &results.deliveries[0];
    assert!(!delivery.success_10m && !delivery.success_2m && !delivery.correct_unit);
    assert_eq!(delivery.failure, Some(FailureCause::WrongPlace));
    let detail = delivery.failure_detail.as_deref().unwrap_or_default();
    assert!(detail.contains("unit1, building3"), "{detail}");
}

#[test]
fn straight_lines_are_measured_from_where_the_episode_starts() {
    let mut prepared = prepared(&[address(3, 1)]);
    let door = |address: &Address| {
        let doors = &prepared.world.scene.doors;
        doors.iter().position(|d| d.address == *address).unwrap()
    };
    let (from, to) = (door(&address(1, 1)), door(&address(3, 1)));
    let start = prepared.approach[from].unwrap();
    let plate = prepared.world.scene.doors[to].point();
    // The world's start is its origin.
    assert!((start.distance(plate) - MapPoint::default().distance(plate)).abs() > 1.0);
    let episode = prepared.episodes[0].clone();
    prepared.episodes[0] = prepared.starting_at(Pose2::new(start.x, start.y, 0.0), episode);
    let agents = yardsticks::agents();
    let factory = agents.get("omniscient").unwrap();
    let factory = factory.as_ref();
    let results = run(&RunRequest::new(&prepared, "omniscient", factory))
        .unwrap()
        .results;
    let delivery = &results.deliveries[0];
    assert!(delivery.success_2m);
    assert!((delivery.straight_line_m - start.distance(plate)).abs() < 1e-9);
}

/// A way through all three buildings.
fn rounds() -> [Address; 3] {
    [address(1, 1), address(3, 1), address(2, 2)]
}

#[test]
fn a_sequence_goes_on_from_where_the_robot_stands() {
    let results = judged(&rounds(), &rounds(), as_it_is);
    assert_eq!(results.metrics.lsr, Some(1.0));
    assert_eq!(results.metrics.sr_2m, None, "it is no single delivery");
    let world = prepared(&rounds());
    let door = |address: &Address| {
        let doors = &world.world.scene.doors;
        doors
            .iter()
            .position(|door| door.address == *address)
            .unwrap()
    };
    let mut from = world.world.start.point();
    for (delivery, address) in results.deliveries.iter().zip(rounds()) {
        assert!(delivery.success_2m, "{delivery:?}");
        let shortest = world.shortest(from, door(&address)).unwrap();
        assert_eq!(delivery.shortest_path_m, Some(shortest));
        // Had the robot been put back to the start, it would have driven another way.
        assert!((delivery.path_m - shortest).abs() < 0.5, "{delivery:?}");
        from = delivery.declared_at.unwrap();
    }
}

/// Gives up the first delivery where it should be declared.
fn without_the_first() -> Change {
    let mut is_first = true;
    Box::new(move |action| match action {
        Action::Delivered(address) if std::mem::take(&mut is_first) => Action::GiveUp(GiveUp {
            address: Some(address),
            cause: FailureCause::DoorNotFound,
            detail: "the bell is broken".into(),
        }),
        other => other,
    })
}

#[test]
fn a_failure_at_the_beginning_of_a_sequence_weighs_most() {
    let results = judged(&rounds(), &rounds(), without_the_first);
    // Weights 1, 0.9 and 0.81, the first of which is lost.
    let expected = (0.9 + 0.81) / (1.0 + 0.9 + 0.81);
    let lsr = results.metrics.lsr.unwrap();
    assert!((lsr - expected).abs() < 1e-12, "{lsr}");
    let lspl = results.metrics.lspl.unwrap();
    assert!(lspl < lsr && lspl > lsr - 0.02, "{lspl}");
    assert_eq!(results.metrics.member_sr_2m, Some(2.0 / 3.0));
    let failed = &results.deliveries[0];
    assert_eq!(failed.failure, Some(FailureCause::DoorNotFound));
}

/// Drives as the omniscient agent does, and cannot repeat it.
struct Unrepeatable;

impl AgentFactory for Unrepeatable {
    fn make(&self, request: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
        yardsticks::agents().get("omniscient")?.make(request)
    }

    fn uses_truth(&self, _: &AgentSettings) -> bool {
        true
    }

    fn cannot_repeat(&self, _: &AgentSettings) -> Option<String> {
        Some("a person drove".into())
    }
}

#[test]
fn results_that_nobody_can_repeat_say_so_and_their_actions_are_verified() {
    let prepared = prepared(&[address(1, 1)]);
    let out = tempfile::tempdir().unwrap();
    let request = RunRequest {
        out: Some(out.path()),
        ..RunRequest::new(&prepared, "driver", &Unrepeatable)
    };
    let results = run(&request).unwrap().results;
    let reason = results.provenance.cannot_repeat.as_deref();
    assert_eq!(reason, Some("a person drove"));
    assert!(terminal_table(&results).contains("a person drove"));
    let record = RunRecord::read(out.path()).unwrap();
    verify(out.path(), &record, &prepared, 1, &mut || {}).unwrap();
}
