//! The contract of [`Rollout`] and of its observers.

use std::sync::{Arc, LazyLock, Mutex};

use openbench_bench::run::run_episode;
use openbench_bench::{BenchError, Observer, Prepared, Rollout, Status, builtin_suite};
use openbench_core::{
    Action, Address, Agent, Briefing, Event, Events, FailureCause, GiveUp, Observation, SimTime,
    Velocity,
};
use openbench_sim::Simulator;

static SMALL: LazyLock<Prepared> =
    LazyLock::new(|| Prepared::new(builtin_suite("small").unwrap(), None).unwrap());

const FORWARD: Velocity = Velocity::new(0.3, 0.1);

/// An agent that drives in a circle for a second and then gives up.
struct Circle;

impl Agent for Circle {
    fn begin(&mut self, _: &Briefing, events: &mut dyn Events) -> Result<(), GiveUp> {
        events.record(Event::Note("begun".into()));
        Ok(())
    }

    fn act(&mut self, observation: &Observation<'_>, _: &mut dyn Events) -> Action {
        if observation.time < SimTime::from_millis(1000) {
            return Action::Drive(FORWARD);
        }
        Action::GiveUp(given_up(None))
    }
}

fn given_up(address: Option<Address>) -> GiveUp {
    GiveUp {
        address,
        cause: FailureCause::DoorNotFound,
        detail: "tired".into(),
    }
}

/// The calls that an observer received.
#[derive(Debug, Default)]
struct Seen {
    begun: usize,
    steps: usize,
    events: Vec<String>,
}

/// An observer that counts its calls and fails at a step.
struct CountingObserver {
    seen: Arc<Mutex<Seen>>,
    fails_at: usize,
}

impl Observer for CountingObserver {
    fn begin(&mut self, _: &Simulator) -> Result<(), BenchError> {
        self.seen.lock().unwrap().begun += 1;
        Ok(())
    }

    fn step(&mut self, _: &Simulator, _: Velocity) -> Result<(), BenchError> {
        let mut seen = self.seen.lock().unwrap();
        seen.steps += 1;
        let full = || BenchError::world("the disk is full");
        if seen.steps == self.fails_at {
            Err(full())
        } else {
            Ok(())
        }
    }

    fn event(&mut self, time: SimTime, event: &Event) -> Result<(), BenchError> {
        self.seen
            .lock()
            .unwrap()
            .events
            .push(format!("{time}: {event:?}"));
        Ok(())
    }
}

fn rollout<'o>() -> Rollout<'o> {
    Rollout::new(&SMALL, 0, 7).unwrap()
}

#[test]
fn single_steps_and_an_agent_give_the_same_trace() {
    let driven = run_episode(rollout(), &mut Circle).unwrap();
    let mut by_hand = rollout();
    for _ in 0..20 {
        assert_eq!(by_hand.step(Action::Drive(FORWARD)), Status::Running);
    }
    assert_eq!(by_hand.step(Action::GiveUp(given_up(None))), Status::Ended);
    let by_hand = by_hand.finish(None).unwrap();
    assert_eq!(by_hand.chain, driven.chain);
    assert_eq!(by_hand.velocities, driven.velocities);
    assert_eq!(by_hand.tasks, driven.tasks);
    assert_eq!(
        by_hand.tasks[0].failure.as_ref().unwrap().cause,
        FailureCause::DoorNotFound
    );
}

#[test]
fn steps_after_the_end_have_no_effect() {
    let mut rollout = rollout();
    rollout.step(Action::GiveUp(given_up(None)));
    let time = rollout.observation().time;
    assert_eq!(rollout.step(Action::Drive(FORWARD)), Status::Ended);
    assert_eq!(rollout.observation().time, time);
    assert_eq!(rollout.finish(None).unwrap().velocities, [Velocity::ZERO]);
}

#[test]
fn an_agent_that_cannot_begin_fails_every_delivery() {
    let sequence = SMALL
        .episodes
        .iter()
        .position(|episode| episode.targets.len() > 1)
        .unwrap();
    let mut rollout = Rollout::new(&SMALL, sequence, 1).unwrap();
    let address = SMALL.episodes[sequence].targets[0].address.clone();
    rollout.refuse(&given_up(Some(address)));
    assert_eq!(rollout.status(), Status::Ended);
    let trace = rollout.finish(None).unwrap();
    assert_eq!(trace.tasks.len(), SMALL.episodes[sequence].targets.len());
    assert_eq!(trace.sim_seconds, 0.0);
}

#[test]
fn observers_receive_the_begin_each_step_and_each_event() {
    let seen = Arc::new(Mutex::new(Seen::default()));
    let observer = CountingObserver {
        seen: seen.clone(),
        fails_at: 0,
    };
    let trace = run_episode(rollout().with_observer(observer), &mut Circle).unwrap();
    let seen = seen.lock().unwrap();
    assert_eq!((seen.begun, seen.steps), (1, trace.velocities.len()));
    assert_eq!(seen.events, [r#"0.000 s: Note("begun")"#]);
}

#[test]
fn a_failing_observer_ends_the_episode_with_its_error() {
    let seen = Arc::new(Mutex::new(Seen::default()));
    let mut rollout = rollout().with_observer(CountingObserver {
        seen: seen.clone(),
        fails_at: 3,
    });
    while rollout.step(Action::Drive(FORWARD)) == Status::Running {}
    assert_eq!(seen.lock().unwrap().steps, 3);
    assert!(
        rollout
            .finish(None)
            .unwrap_err()
            .to_string()
            .contains("the disk is full")
    );
}

#[test]
fn nan_and_infinite_velocities_are_replaced_by_zero() {
    let mut rollout = rollout();
    rollout.step(Action::Drive(Velocity::new(f64::NAN, f64::INFINITY)));
    assert_eq!(rollout.finish(None).unwrap().velocities, [Velocity::ZERO]);
}

#[test]
fn a_declared_address_that_is_not_in_the_instruction_fails_one_delivery() {
    let nobody = Address {
        building: "nowhere".into(),
        unit: None,
    };
    let mut rollout = rollout();
    rollout.step(Action::Delivered(nobody));
    let trace = rollout.finish(Some(b"<osm/>".to_vec())).unwrap();
    assert_eq!(
        trace.tasks[0].failure.as_ref().unwrap().cause,
        FailureCause::WrongPlace
    );
    assert_eq!(trace.map.as_deref(), Some(&b"<osm/>"[..]));
}

#[test]
fn an_unknown_episode_is_reported_by_number() {
    let error = Rollout::new(&SMALL, 99, 0).err().unwrap().to_string();
    assert!(error.contains("no episode 99"), "{error}");
}

#[test]
fn a_rollout_without_observers_borrows_nothing_and_is_send() {
    fn is_static_and_send<T: 'static + Send>(_: &T) {}
    is_static_and_send(&rollout());
}
