//! A computer that takes simulated time for what an agent computes.
//!
//! It is one processor with one queue. Observations wait in it; the agent works on one after
//! another; a decision takes effect when the work for it is done. Meanwhile the robot drives on
//! with its last command, for as long as its drives hold one. An agent whose work takes less than
//! the 50 ms between two observations is late by that work alone; one whose work takes longer falls
//! behind, and loses observations in the end.
//!
//! What work costs is a table, not a clock: runs repeat on every machine. Agents in other programs
//! do not say what work they did; on request they are charged the wall time that they took, and
//! such runs do not repeat. They get what is newest when they are free, as a program that
//! subscribes to sensors does: the samples of IMU and wheels that came meanwhile, the latest scan,
//! the camera.

use std::collections::VecDeque;
use std::time::Duration;

use openbench_core::{Action, Agent, Event, ModelUse, Sensed, SimTime, Velocity, Work};

use super::rollout::{Rollout, Status};
use crate::suite::Compute;
use crate::trace::Computing;

/// Observations that wait at most: those of two seconds. When the queue is full, the oldest is
/// lost, as in ROS.
const MOST_WAITING: usize = 40;

/// What work costs on the reference computer. It is assumed to be three times slower than the
/// machine on which the table in `docs/conditions.md` was measured.
pub const fn cost_of(work: Work) -> Duration {
    Duration::from_millis(match work {
        Work::Registration => 10,
        Work::MapRegistration => 30,
        Work::MapSearch => 300,
        Work::Mapping => 15,
        Work::PathSearch => 75,
        Work::LocalPlan => 5,
        Work::Reading => 500,
    })
}

/// What a request to a language or vision model costs besides its tokens.
pub const REQUEST: Duration = Duration::from_millis(300);
/// What each token that a model reads or writes costs.
pub const TOKEN_READ: Duration = Duration::from_micros(200);
/// As [`TOKEN_READ`], for tokens that it writes.
pub const TOKEN_WRITTEN: Duration = Duration::from_millis(20);

/// Lets an agent drive a rollout that began, to its end.
pub(super) fn drive(rollout: &mut Rollout<'_>, agent: &mut dyn Agent, begun: Vec<Event>) {
    let mut computer = Computer::new(rollout.compute());
    let cost = computer.record(rollout, begun);
    computer.work(SimTime::ZERO, cost);
    let mut events = Vec::new();
    while rollout.status() == Status::Running {
        let now = rollout.observation().time;
        computer.sense(Sensed::of(&rollout.observation()));
        if rollout.is_charged_by_clock() {
            computer.merge_waiting();
        }
        while let Some(sensed) = computer.next(now) {
            let mut observation = sensed.observation();
            // The camera delivers what it sees now, and only to who is up to date.
            let newest = rollout.observation();
            if sensed.time == now {
                observation.camera = newest.camera;
            }
            let action = agent.act(&observation, &mut events);
            rollout.set_observed(sensed.time);
            let cost = computer.record(rollout, std::mem::take(&mut events));
            computer.decide(sensed.time, cost, action);
        }
        let action = computer.command(now);
        rollout.step(action);
    }
    rollout.note_computing(computer.computing);
}

/// An action that waits until the work for it is done.
struct Decision {
    at: SimTime,
    action: Action,
}

/// The command that the drives hold.
#[derive(Clone, Copy, Default)]
struct Held {
    since: SimTime,
    velocity: Velocity,
}

/// The queue, the work that is under way, and the decisions that come of it.
struct Computer {
    compute: Compute,
    /// When the work on all observations that were taken is done.
    free_at: SimTime,
    waiting: VecDeque<Sensed>,
    decisions: VecDeque<Decision>,
    held: Held,
    used: ModelUse,
    computing: Computing,
}

impl Computer {
    fn new(compute: Compute) -> Self {
        Self {
            compute,
            free_at: SimTime::ZERO,
            waiting: VecDeque::new(),
            decisions: VecDeque::new(),
            held: Held::default(),
            used: ModelUse::default(),
            computing: Computing::default(),
        }
    }

    /// Queues an observation.
    fn sense(&mut self, sensed: Sensed) {
        self.waiting.push_back(sensed);
        if self.waiting.len() > MOST_WAITING {
            self.waiting.pop_front();
            self.computing.lost_observations += 1;
        }
    }

    /// Makes one observation of all that wait.
    fn merge_waiting(&mut self) {
        let all = std::mem::take(&mut self.waiting);
        self.waiting.extend(all.into_iter().reduce(merged));
    }

    /// The next observation to work on, if the work on those before is done.
    fn next(&mut self, now: SimTime) -> Option<Sensed> {
        if self.free_at > now {
            return None;
        }
        self.waiting.pop_front()
    }

    /// Records events in the rollout; returns what the work among them costs.
    fn record(&mut self, rollout: &mut Rollout<'_>, events: Vec<Event>) -> Duration {
        let (mut by_clock, mut by_table) = (Duration::ZERO, Duration::ZERO);
        for event in events {
            by_clock += self.wall_time(&event);
            by_table += self.cost(&event);
            rollout.record(event);
        }
        // The clock is that of this machine, however slow the one of the table is.
        by_clock + by_table.mul_f64(self.compute.slowness)
    }

    fn wall_time(&mut self, event: &Event) -> Duration {
        let Event::WallTime(took) = event else {
            return Duration::ZERO;
        };
        self.computing.by_clock_ns += nanoseconds(*took);
        *took
    }

    fn cost(&mut self, event: &Event) -> Duration {
        match event {
            Event::Work(work) => {
                *self.computing.work.entry(*work).or_default() += 1;
                cost_of(*work)
            }
            // The sum so far.
            Event::Models(used) => {
                let new = used.since(self.used);
                self.used = *used;
                self.computing.model_calls += new.calls;
                cost_of_models(&new)
            }
            _ => Duration::ZERO,
        }
    }

    /// Works for so long on an observation, and returns when that is done.
    fn work(&mut self, observed: SimTime, cost: Duration) -> SimTime {
        self.free_at = self.free_at.max(observed) + cost;
        self.computing.busy_ns += nanoseconds(cost);
        let late = nanoseconds(self.free_at.since(observed));
        self.computing.latest_ns = self.computing.latest_ns.max(late);
        self.free_at
    }

    fn decide(&mut self, observed: SimTime, cost: Duration, action: Action) {
        let at = self.work(observed, cost);
        self.decisions.push_back(Decision { at, action });
    }

    /// What the robot does in the next step: the newest command that is decided on, or a
    /// declaration, of which none is passed over.
    fn command(&mut self, now: SimTime) -> Action {
        while let Some(decision) = self.decisions.pop_front_if(|d| d.at <= now) {
            match decision.action {
                Action::Drive(velocity) => {
                    self.held = Held {
                        // From when the drives get it, not from when it was decided on.
                        since: now,
                        velocity,
                    }
                }
                declared => {
                    // Who declares stands; what was commanded before is over.
                    self.held = Held::default();
                    return declared;
                }
            }
        }
        Action::Drive(self.held_velocity(now))
    }

    fn held_velocity(&mut self, now: SimTime) -> Velocity {
        let moves = self.held.velocity != Velocity::ZERO;
        if moves && now.since(self.held.since).as_secs_f64() > self.compute.hold_s {
            self.computing.held_up_ns += openbench_sim::OBSERVATION_NS;
            return Velocity::ZERO;
        }
        self.held.velocity
    }
}

/// An observation of the newer instant with the samples of both.
fn merged(older: Sensed, newer: Sensed) -> Sensed {
    Sensed {
        imu: [older.imu, newer.imu].concat(),
        wheels: [older.wheels, newer.wheels].concat(),
        scan: newer.scan.or(older.scan),
        gnss: newer.gnss.or(older.gnss),
        ..newer
    }
}

fn cost_of_models(used: &ModelUse) -> Duration {
    let tokens = |count: u64, each: Duration| each * u32::try_from(count).unwrap_or(u32::MAX);
    REQUEST * used.calls
        + tokens(used.prompt_tokens, TOKEN_READ)
        + tokens(used.completion_tokens, TOKEN_WRITTEN)
}

/// As JSON has it: an episode is shorter than the 584 years that fit.
fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use openbench_core::ImuSample;

    use super::*;
    use crate::suite::Condition;

    fn charged() -> Computer {
        Computer::new(Compute::LEVELS[1].1)
    }

    fn at(ms: u64) -> SimTime {
        SimTime::from_millis(ms)
    }

    fn sensed(ms: u64) -> Sensed {
        Sensed {
            time: at(ms),
            imu: vec![],
            wheels: vec![],
            scan: None,
            gnss: None,
            image: None,
        }
    }

    fn forward(speed: f64) -> Action {
        Action::Drive(Velocity::new(speed, 0.0))
    }

    #[test]
    fn a_decision_takes_effect_when_the_work_for_it_is_done() {
        let mut computer = charged();
        computer.decide(at(0), Duration::from_millis(120), forward(0.5));
        assert_eq!(computer.command(at(100)), forward(0.0));
        assert_eq!(computer.command(at(150)), forward(0.5));
        // Without work it does at once, as where computing is free.
        computer.decide(at(200), Duration::ZERO, forward(0.2));
        assert_eq!(computer.command(at(200)), forward(0.2));
    }

    #[test]
    fn observations_wait_for_their_turn_and_the_oldest_are_lost() {
        let mut computer = charged();
        computer.work(at(0), Duration::from_millis(220));
        for ms in [50, 100, 150, 200] {
            computer.sense(sensed(ms));
            assert!(computer.next(at(ms)).is_none());
        }
        assert_eq!(computer.next(at(250)).unwrap().time, at(50));
        // What waited is worked on from when the work before was done, not from now.
        assert_eq!(computer.work(at(50), Duration::from_millis(10)), at(230));
        assert_eq!(computer.computing.latest_ns, 220_000_000);
        for ms in 0..100 {
            computer.sense(sensed(1_000 + 50 * ms));
        }
        assert_eq!(computer.computing.lost_observations, 63);
    }

    #[test]
    fn what_waits_becomes_one_observation_with_all_samples() {
        let mut computer = charged();
        let sample = |ms: u64| ImuSample {
            stamp: at(ms),
            gyro: Default::default(),
            accel: Default::default(),
        };
        for ms in [50, 100, 150] {
            let imu = vec![sample(ms - 10), sample(ms)];
            computer.sense(Sensed { imu, ..sensed(ms) });
        }
        computer.merge_waiting();
        let one = computer.next(at(150)).unwrap();
        assert_eq!((one.time, one.imu.len()), (at(150), 6));
        assert!(one.imu.is_sorted_by_key(|sample| sample.stamp));
        assert!(computer.next(at(150)).is_none());
        computer.merge_waiting();
        assert!(computer.next(at(150)).is_none());
    }

    #[test]
    fn wall_time_is_charged_as_it_is() {
        let mut computer = Computer::new(Compute {
            slowness: 3.0,
            ..Compute::default()
        });
        let took = Duration::from_millis(70);
        assert_eq!(computer.wall_time(&Event::WallTime(took)), took);
        assert_eq!(computer.cost(&Event::WallTime(took)), Duration::ZERO);
        assert_eq!(computer.computing.by_clock_ns, 70_000_000);
    }

    #[test]
    fn the_robot_stops_when_no_command_comes() {
        let mut computer = charged();
        computer.decide(at(0), Duration::ZERO, forward(0.5));
        assert_eq!(computer.command(at(0)), forward(0.5));
        assert_eq!(computer.command(at(500)), forward(0.5));
        assert_eq!(computer.command(at(550)), forward(0.0));
        assert_eq!(computer.computing.held_up_ns, 50_000_000);
    }

    #[test]
    fn no_declaration_is_passed_over() {
        let mut computer = charged();
        let delivered = Action::Delivered(openbench_core::Address::new("building1", "unit1"));
        computer.decide(at(0), Duration::ZERO, delivered.clone());
        computer.decide(at(50), Duration::ZERO, forward(0.5));
        assert_eq!(computer.command(at(50)), delivered);
        assert_eq!(computer.command(at(100)), forward(0.5));
    }

    #[test]
    fn a_declaration_ends_the_command_before_it() {
        let mut computer = charged();
        computer.decide(at(0), Duration::ZERO, forward(0.5));
        assert_eq!(computer.command(at(0)), forward(0.5));
        let delivered = Action::Delivered(openbench_core::Address::new("building1", "unit1"));
        computer.decide(at(50), Duration::ZERO, delivered.clone());
        assert_eq!(computer.command(at(50)), delivered);
        assert_eq!(computer.command(at(100)), forward(0.0));
    }

    #[test]
    fn models_cost_by_their_tokens_and_only_once() {
        let mut computer = charged();
        let used = |calls, written| {
            Event::Models(ModelUse {
                calls,
                completion_tokens: written,
                ..ModelUse::default()
            })
        };
        assert_eq!(computer.cost(&used(1, 10)), Duration::from_millis(500));
        assert_eq!(computer.cost(&used(2, 10)), Duration::from_millis(300));
        assert_eq!(computer.cost(&used(2, 10)), Duration::ZERO);
    }
}
