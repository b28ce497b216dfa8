//! The towns experiment with an agent that gives up at once: windows, their files, and resumption
//! after an interruption.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use openbench_bench::run::registry::AgentError;
use openbench_bench::{AgentRequest, BenchError, Build};
use openbench_core::{
    Action, Agent, Briefing, Events, FailureCause, GiveUp, Observation, with_causes,
};
use openbench_trials::towns::{Towns, TownsPlan, TownsRequest, draw, run};

struct Quitter;

impl Agent for Quitter {
    fn begin(&mut self, _briefing: &Briefing, _events: &mut dyn Events) -> Result<(), GiveUp> {
        Err(GiveUp {
            address: None,
            cause: FailureCause::Stuck,
            detail: "no will".into(),
        })
    }

    fn act(&mut self, _observation: &Observation<'_>, _events: &mut dyn Events) -> Action {
        unreachable!("it never began")
    }
}

fn plan(seed: u64) -> TownsPlan {
    let map =
        |name| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../scene/assets")).join(name);
    TownsPlan {
        version: env!("CARGO_PKG_VERSION").into(),
        maps: vec![map("large.osm"), map("medium.osm")],
        radius: 70.0,
        seed,
        false_origin: 0.0,
        agent: "quitter".into(),
        settings: Default::default(),
    }
}

/// The results, and for each window whether it was finished before.
fn run_towns(
    plan: &TownsPlan,
    windows: usize,
    out: &Path,
) -> Result<(Towns, Vec<bool>), BenchError> {
    let factory =
        |_: &AgentRequest<'_>| -> Result<Box<dyn Agent>, AgentError> { Ok(Box::new(Quitter)) };
    let seen = RefCell::new(Vec::new());
    let progress = |_: &_, was_done| seen.borrow_mut().push(was_done);
    let towns = run(&TownsRequest {
        build: &Build::default(),
        plan,
        windows,
        factory: &factory,
        jobs: 2,
        out,
        progress: &progress,
    })?;
    Ok((towns, seen.into_inner()))
}

#[test]
fn an_interrupted_experiment_is_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let (one, seen) = run_towns(&plan(3), 1, folder.path()).unwrap();
    assert_eq!((one.towns.len(), seen), (1, vec![false]));
    let town = &one.towns[0];
    assert_eq!(
        town.results.deliveries.len(),
        7,
        "four singles and a sequence of three"
    );
    assert_eq!(one.failures[&FailureCause::Stuck], 7);
    assert_eq!(
        (one.metrics.sr_2m, one.metrics.lsr, one.pose),
        (Some(0.0), Some(0.0), None)
    );
    assert!(
        town.odometry.metres > 30.0 && town.odometry.scans > 1500,
        "{:?}",
        town.odometry
    );
    assert!(
        town.odometry.max_m < 0.5 && town.odometry.nees.is_some(),
        "{:?}",
        town.odometry
    );
    for file in ["town.json", "world/world.toml", "run/report.html"] {
        assert!(folder.path().join("000").join(file).exists(), "{file}");
    }
    // The second window is at another place; the first is unchanged.
    let (two, seen) = run_towns(&plan(3), 2, folder.path()).unwrap();
    assert_eq!(seen, [true, false]);
    assert_eq!(two.towns[0], one.towns[0]);
    assert_eq!(
        (two.towns[1].place.map, two.towns[1].place.name.as_str()),
        (1, "medium-001")
    );
    assert_eq!(
        two.metrics.intervals["lsr"], None,
        "two sequences are too few"
    );
    // Windows that are only drawn are the same.
    let elsewhere = tempfile::tempdir().unwrap();
    let drawn = draw(&plan(3), 2, elsewhere.path()).unwrap();
    assert!(
        drawn
            .iter()
            .map(|drawn| &drawn.place)
            .eq(two.towns.iter().map(|town| &town.place))
    );
    let map = |folder: &Path| std::fs::read(folder.join("000/world/map.osm")).unwrap();
    assert_eq!(map(elsewhere.path()), map(folder.path()));
    // A folder with windows of another plan is rejected.
    let other = with_causes(&run_towns(&plan(4), 1, folder.path()).unwrap_err());
    assert!(
        other.contains("towns.json") && other.contains("--out"),
        "{other}"
    );
    std::fs::write(folder.path().join("000/town.json"), "{}").unwrap();
    let broken = with_causes(&run_towns(&plan(3), 1, folder.path()).unwrap_err());
    assert!(
        broken.contains("town.json") && broken.contains("remove"),
        "{broken}"
    );
}

#[test]
fn a_map_without_space_has_fewer_windows() {
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path().join("empty.osm");
    std::fs::write(
        &empty,
        "<osm version=\"0.6\"><node id=\"1\" lat=\"50\" lon=\"8\"/></osm>",
    )
    .unwrap();
    let plan = TownsPlan {
        maps: vec![empty],
        ..plan(1)
    };
    let (towns, _) = run_towns(&plan, 3, &folder.path().join("out")).unwrap();
    assert_eq!(
        (towns.towns.len(), towns.wanted, towns.metrics.sr_2m),
        (0, 3, None)
    );
}
