//! Yardsticks on the suite *small*.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};

use openbench_bench::report::terminal_table;
use openbench_bench::run::registry::{AgentError, AgentSettings};
use openbench_bench::score::results::DeliveryResult;
use openbench_bench::{
    AgentFactory, AgentRequest, Prepared, Results, RunRequest, builtin_suite, run, yardsticks,
};
use openbench_core::{Agent, FailureCause};

static SMALL: LazyLock<Prepared> =
    LazyLock::new(|| Prepared::new(builtin_suite("small").unwrap(), None).unwrap());

/// Its first two episodes, for agents that take long.
static TWO: LazyLock<Prepared> = LazyLock::new(|| {
    let mut suite = builtin_suite("small").unwrap();
    suite.episodes.truncate(2);
    Prepared::new(suite, None).unwrap()
});

fn run_in(prepared: &Prepared, agent: &str, factory: &dyn AgentFactory) -> Results {
    let request = RunRequest {
        seed: 7,
        jobs: 2,
        ..RunRequest::new(prepared, agent, factory)
    };
    run(&request).unwrap().results
}

fn results(prepared: &Prepared, agent: &str) -> Results {
    let agents = yardsticks::agents();
    run_in(prepared, agent, agents.get(agent).unwrap().as_ref())
}

#[test]
fn the_omniscient_agent_takes_the_shortest_path_to_every_door() {
    let results = results(&SMALL, "omniscient");
    let metrics = &results.metrics;
    assert_eq!((metrics.sr_2m, metrics.sr_clean), (Some(1.0), Some(1.0)));
    assert_eq!((metrics.member_sr_2m, metrics.lsr), (Some(1.0), Some(1.0)));
    for ratio in [metrics.spl, metrics.member_spl, metrics.lspl] {
        assert!(ratio.unwrap() > 0.97, "{metrics:?}");
    }
    assert!(results.provenance.uses_truth);
}

#[test]
fn a_straight_line_and_chance_are_lower_bounds() {
    for (prepared, agent) in [(&SMALL, "straight-line"), (&TWO, "random")] {
        let results = results(prepared, agent);
        assert!(results.metrics.sr_2m.unwrap() < 0.5, "{agent}");
        assert!(results.provenance.uses_truth);
    }
}

#[test]
fn who_scrapes_along_a_wall_has_few_collisions_and_long_contact() {
    let results = results(&SMALL, "straight-line");
    for delivery in &results.deliveries {
        let classes = delivery.collisions_by_class.values();
        let (count, contact_s) = classes.fold((0, 0.0), |(count, contact_s), sum| {
            (count + sum.count, contact_s + sum.contact_s)
        });
        assert_eq!(count, delivery.collisions);
        assert!(
            (contact_s - delivery.contact_s).abs() < 1e-9,
            "{delivery:?}"
        );
        assert!(contact_s < delivery.sim_seconds, "{delivery:?}");
    }
    // It drives into the wall until it is given up.
    let scrapes = |d: &&DeliveryResult| d.collisions == 1 && d.contact_s > 10.0;
    assert!(results.deliveries.iter().filter(scrapes).count() > 2);
    assert!(terminal_table(&results).contains("contact  "));
}

#[test]
fn chance_declares_every_delivery_before_the_time_is_over() {
    let results = results(&TWO, "random");
    let is_over = |cause: Option<FailureCause>| cause == Some(FailureCause::Timeout);
    assert!(results.deliveries.iter().all(|d| !is_over(d.failure)));
}

/// Notes whether it was told the truth, and makes no agent.
struct Curious {
    uses_truth: bool,
    was_told: AtomicBool,
}

impl AgentFactory for Curious {
    fn make(&self, request: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
        let told = request.truth.is_some();
        self.was_told.store(told, Ordering::Relaxed);
        yardsticks::agents()
            .get("random")
            .unwrap()
            .make(&AgentRequest {
                // Any agent will do.
                truth: Some(openbench_bench::Truth {
                    handle: openbench_bench::TruthHandle::default(),
                    prepared: &SMALL,
                    episode: 0,
                }),
                ..request.clone()
            })
    }

    fn uses_truth(&self, _: &AgentSettings) -> bool {
        self.uses_truth
    }
}

#[test]
fn only_agents_that_say_so_are_told_the_truth() {
    for uses_truth in [true, false] {
        let factory = Curious {
            uses_truth,
            was_told: AtomicBool::new(!uses_truth),
        };
        let results = run_in(&TWO, "curious", &factory);
        assert_eq!(factory.was_told.load(Ordering::Relaxed), uses_truth);
        assert_eq!(results.provenance.uses_truth, uses_truth);
    }
}
