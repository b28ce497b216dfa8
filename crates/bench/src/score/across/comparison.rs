//! Differences between systems, paired by episode.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::measures::{MEASURES, Measure, SUCCESS, Unit};
use super::paired::{
    holm, independent_disagreement, interval_of_mean, interval_of_share_difference, mcnemar,
    pairs_to_tell,
};
use super::samples::{ClusteredBy, Samples, clustered_by, clusters, mean, samples, setups};
use super::system::System;
use crate::score::Results;
use crate::score::departures::departures;
use crate::worlds::Hashes;

/// Seed of the bootstrap. Any will do; the same one gives the same intervals.
const SEED: u64 = 0;

/// Why systems cannot be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CompareError {
    /// There are no results.
    #[error("{system}: there is no results.json, neither there nor in the folders below")]
    NoRuns {
        /// The system.
        system: String,
    },
    /// The runs are of several agents, or of one with several settings.
    #[error(
        "{system}: its runs are of several agents or settings; name folders with the runs of one"
    )]
    Mixed {
        /// The system.
        system: String,
    },
    /// Results of an older version do not say in which world they were made.
    #[error("{system}: its results of suite {suite} do not say in which world they were made")]
    Unplaced {
        /// The system.
        system: String,
        /// Name of the suite.
        suite: String,
    },
    /// Two runs are of the same suite and seed.
    #[error("{system}: it has two runs of suite {suite} with seed {seed}; name one of them")]
    Twice {
        /// The system.
        system: String,
        /// Name of the suite.
        suite: String,
        /// The seed.
        seed: u64,
    },
    /// Two systems have not run the same.
    #[error(
        "{second} has no run of suite {suite} with seed {seed} in the same world, as {first} has: \
         only runs of equal suites, worlds, maps and seeds can be compared"
    )]
    NotTheSame {
        /// The system that has the run.
        first: String,
        /// The system that lacks it.
        second: String,
        /// Name of the suite.
        suite: String,
        /// The seed.
        seed: u64,
    },
}

/// Systems beside each other. Differences are to the first one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// The systems.
    pub systems: Vec<Compared>,
    /// What the intervals are clustered by.
    pub clustered_by: ClusteredBy,
    /// The measures, in the order of the paper's table.
    pub measures: Vec<Row>,
    /// Tests of strict success in single deliveries, one for each system but the first.
    pub tests: Vec<SuccessTest>,
    /// How many pairs of single deliveries tell two systems apart; null without any.
    pub to_tell: Option<ToTell>,
}

/// A system that is compared.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Compared {
    /// Its name.
    pub name: String,
    /// Name of the agent.
    pub agent: String,
    /// Number of its runs.
    pub runs: usize,
    /// The suites that they ran.
    pub suites: BTreeSet<String>,
    /// In what they depart from the defaults, each once.
    pub departures: Vec<String>,
    /// Number of episodes in which the pose was wrong by more than a metre while the agent reported
    /// good health.
    pub silent_divergences: usize,
}

/// A measure of all systems.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Its name in `results.json`.
    pub name: String,
    /// What it is counted in.
    pub unit: Unit,
    /// The mean of each system; null where it has none.
    pub means: Vec<Option<f64>>,
    /// The differences to the first system, for each of the others; null without pairs.
    pub differences: Vec<Option<Difference>>,
}

/// How a measure differs from that of the first system.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// Mean of the other system less that of the first one, over the pairs.
    pub mean: f64,
    /// Its 95 % interval; null with too few clusters.
    pub interval: Option<[f64; 2]>,
    /// Number of pairs.
    pub pairs: usize,
}

/// Whether success differs from that of the first system: McNemar's exact test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SuccessTest {
    /// Pairs in which only the first system succeeded.
    pub only_first: usize,
    /// Pairs in which only the other one succeeded.
    pub only_other: usize,
    /// Number of pairs.
    pub pairs: usize,
    /// Number of worlds or episodes, whichever the pairs are clustered by.
    pub clusters: usize,
    /// Two-sided p-value.
    pub p: f64,
    /// The same, adjusted by Holm for all systems that are compared with the first one.
    pub p_holm: f64,
}

/// How many pairs find a difference of success with a probability of 80 %, at a level of 5 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ToTell {
    /// The difference of success, 0 to 1.
    pub difference: f64,
    /// Share of pairs in which exactly one system succeeds. With a single system it is what two
    /// independent ones of its success would have.
    pub disagreement: f64,
    /// Number of pairs.
    pub pairs: usize,
}

/// Compares systems with the first one. `difference`, 0 to 1, is the difference of success that
/// [`Comparison::to_tell`] is about.
///
/// # Errors
/// [`CompareError`] if the systems have not run the same.
pub fn compare(systems: &[System], difference: f64) -> Result<Comparison, CompareError> {
    for system in systems {
        check(system)?;
    }
    let Some((first, others)) = systems.split_first() else {
        let system = "nothing".to_owned();
        return Err(CompareError::NoRuns { system });
    };
    for other in others {
        covers(first, other)?;
        covers(other, first)?;
    }
    let by = clustered_by(first);
    let tests = success_tests(first, others, by);
    Ok(Comparison {
        systems: systems.iter().map(compared).collect(),
        clustered_by: by,
        measures: MEASURES
            .iter()
            .filter_map(|m| row(systems, m, by))
            .collect(),
        to_tell: to_tell(first, &tests, difference),
        tests,
    })
}

/// Refuses a system without runs, with two of the same, or with runs of several systems.
fn check(system: &System) -> Result<(), CompareError> {
    let is_other = |run: &&Results| {
        let first = &system.runs[0];
        (&run.agent, &run.settings, &run.memory) != (&first.agent, &first.settings, &first.memory)
    };
    if system.runs.iter().any(|run| is_other(&run)) {
        let system = system.name.clone();
        return Err(CompareError::Mixed { system });
    }
    let mut seen = BTreeSet::new();
    for (setup, run) in setups(system).into_iter().zip(&system.runs) {
        if setup.0.are_unknown() {
            return Err(CompareError::Unplaced {
                system: system.name.clone(),
                suite: run.suite.clone(),
            });
        }
        if !seen.insert(setup) {
            return Err(CompareError::Twice {
                system: system.name.clone(),
                suite: run.suite.clone(),
                seed: run.seed,
            });
        }
    }
    if seen.is_empty() {
        let system = system.name.clone();
        return Err(CompareError::NoRuns { system });
    }
    Ok(())
}

/// Refuses a run of the first system that the second one lacks.
fn covers(first: &System, second: &System) -> Result<(), CompareError> {
    let there: BTreeSet<(Hashes, u64)> = setups(second).into_iter().collect();
    let runs = setups(first).into_iter().zip(&first.runs);
    match runs.into_iter().find(|(setup, _)| !there.contains(setup)) {
        Some((_, run)) => Err(CompareError::NotTheSame {
            first: first.name.clone(),
            second: second.name.clone(),
            suite: run.suite.clone(),
            seed: run.seed,
        }),
        None => Ok(()),
    }
}

pub(super) fn compared(system: &System) -> Compared {
    let mut all: BTreeSet<String> = system.runs.iter().flat_map(departures).collect();
    let commits: BTreeSet<&String> = system
        .runs
        .iter()
        .map(|run| &run.provenance.build.commit)
        .collect();
    if commits.len() > 1 {
        all.insert("its runs were made by programs of several commits".to_owned());
    }
    let suites = system.runs.iter().map(|run| run.suite.clone());
    Compared {
        suites: suites.collect(),
        silent_divergences: system.runs.iter().map(Results::silent_divergences).sum(),
        name: system.name.clone(),
        agent: system
            .runs
            .first()
            .map_or(String::new(), |run| run.agent.clone()),
        runs: system.runs.len(),
        departures: all.into_iter().collect(),
    }
}

/// A measure of all systems; `None` if none of them has it.
fn row(systems: &[System], measure: &Measure, by: ClusteredBy) -> Option<Row> {
    let all: Vec<Samples> = systems.iter().map(|s| samples(s, measure)).collect();
    let (first, others) = all.split_first()?;
    let means: Vec<Option<f64>> = all.iter().map(|s| mean(s.values())).collect();
    means.iter().any(Option::is_some).then(|| Row {
        name: measure.name.to_owned(),
        unit: measure.unit,
        differences: others
            .iter()
            .map(|other| difference(&differences(first, other), measure.unit, by))
            .collect(),
        means,
    })
}

/// The values of the second system less those of the first one, where both have one.
fn differences(first: &Samples, second: &Samples) -> Samples {
    let pairs = first.iter().filter_map(|(place, value)| {
        let other = second.get(place)?;
        Some((place.clone(), other - value))
    });
    pairs.collect()
}

fn difference(differences: &Samples, unit: Unit, by: ClusteredBy) -> Option<Difference> {
    let values = clusters(differences, by);
    Some(Difference {
        mean: mean(differences.values())?,
        interval: match unit {
            Unit::Share => interval_of_share_difference(&values, SEED),
            Unit::Count | Unit::Seconds => interval_of_mean(&values, SEED),
        },
        pairs: differences.len(),
    })
}

fn success_tests(first: &System, others: &[System], by: ClusteredBy) -> Vec<SuccessTest> {
    let Some(success) = MEASURES.iter().find(|measure| measure.name == SUCCESS) else {
        return Vec::new();
    };
    let first = samples(first, success);
    let mut tests: Vec<SuccessTest> = others
        .iter()
        .map(|other| success_test(&differences(&first, &samples(other, success)), by))
        .collect();
    let p: Vec<f64> = tests.iter().map(|test| test.p).collect();
    for (test, adjusted) in tests.iter_mut().zip(holm(&p)) {
        test.p_holm = adjusted;
    }
    tests
}

fn success_test(differences: &Samples, by: ClusteredBy) -> SuccessTest {
    let sum = |cluster: &Vec<f64>| cluster.iter().map(|d| *d as i64).sum();
    let sums: Vec<i64> = clusters(differences, by).iter().map(sum).collect();
    let p = mcnemar(&sums);
    SuccessTest {
        only_first: differences.values().filter(|d| **d < 0.0).count(),
        only_other: differences.values().filter(|d| **d > 0.0).count(),
        pairs: differences.len(),
        clusters: sums.len(),
        p,
        p_holm: p,
    }
}

/// From how often the systems disagreed so far; a single one, from its success.
fn to_tell(first: &System, tests: &[SuccessTest], difference: f64) -> Option<ToTell> {
    let disagreements = tests.iter().map(|test| {
        let apart = test.only_first + test.only_other;
        (test.pairs > 0).then(|| apart as f64 / test.pairs as f64)
    });
    let disagreement = if tests.is_empty() {
        let success = MEASURES.iter().find(|measure| measure.name == SUCCESS)?;
        let rate = mean(samples(first, success).values())?;
        independent_disagreement(rate, (rate - difference).max(0.0))
    } else {
        disagreements.flatten().reduce(f64::max)?
    };
    // Systems that never disagreed so far may do so at least as often as they differ.
    let disagreement = disagreement.max(difference);
    Some(ToTell {
        difference,
        disagreement,
        pairs: pairs_to_tell(difference, disagreement),
    })
}

impl Comparison {
    /// The rows by the names of their measures.
    pub fn by_name(&self) -> BTreeMap<&str, &Row> {
        self.measures
            .iter()
            .map(|row| (row.name.as_str(), row))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::results::EpisodeResult;
    use crate::score::results::tests::{delivery, results};

    /// A run of single deliveries with these successes.
    fn run(world: &str, seed: u64, successes: &[bool]) -> Results {
        let deliveries = successes.iter().enumerate().map(|(episode, success)| {
            let mut delivery = delivery(episode, 0);
            delivery.success_2m = *success;
            delivery
        });
        let mut run = results(deliveries.collect());
        run.seed = seed;
        let hashes = &mut run.provenance.hashes;
        hashes.world = world.into();
        (hashes.suite, hashes.map) = ("suite".into(), "map".into());
        run
    }

    fn system(name: &str, runs: Vec<Results>) -> System {
        System {
            name: name.into(),
            runs,
        }
    }

    const MIXED: [bool; 6] = [true, true, false, true, false, true];

    #[test]
    fn a_system_does_not_differ_from_itself() {
        let a = system("a", vec![run("w", 1, &MIXED)]);
        let compared = compare(&[a.clone(), a], 0.02).unwrap();
        let success = compared.by_name()["sr_2m"];
        let difference = success.differences[0].unwrap();
        assert_eq!((difference.mean, difference.pairs), (0.0, 6));
        let [low, high] = difference.interval.unwrap();
        assert!(low < 0.0 && high > 0.0);
        assert_eq!(compared.tests[0].p, 1.0);
        assert_eq!(compared.clustered_by, ClusteredBy::Episode);
    }

    #[test]
    fn one_that_always_succeeds_differs_from_one_that_never_does() {
        let always = system("always", vec![run("w", 1, &[true; 12])]);
        let never = system("never", vec![run("w", 1, &[false; 12])]);
        let also_never = system("also never", never.runs.clone());
        let compared = compare(&[always, never, also_never], 0.02).unwrap();
        let test = compared.tests[0];
        assert_eq!((test.only_first, test.only_other, test.pairs), (12, 0, 12));
        assert!((test.p - 2.0 / 4096.0).abs() < 1e-12);
        assert!((test.p_holm - 4.0 / 4096.0).abs() < 1e-12);
        let difference = compared.by_name()["sr_2m"].differences[0].unwrap();
        assert_eq!(difference.mean, -1.0);
    }

    #[test]
    fn a_refused_instruction_is_not_understood() {
        let episode = |number: usize, understood: Option<bool>| EpisodeResult {
            episode: number,
            sim_seconds: 1.0,
            understood,
            fallbacks: vec![],
            localization: None,
            start: None,
            health: vec![],
            stages: vec![],
            computing: None,
        };
        let planned = |plans: [Option<bool>; 2]| {
            let mut run = run("w", 1, &[true, false]);
            run.episodes = vec![episode(0, plans[0]), episode(1, plans[1])];
            let compared = compare(&[system("a", vec![run])], 0.02).unwrap();
            compared.by_name().get("srtp").map(|row| row.means[0])
        };
        assert_eq!(planned([Some(true), None]), Some(Some(0.5)));
        assert_eq!(planned([None, None]), None, "it makes no plans");
    }

    #[test]
    fn seeds_of_an_episode_are_no_independent_pairs() {
        // One of six episodes differs, with each of five seeds.
        let other = [true, true, true, true, false, true];
        let runs = |successes: &[bool]| (0..5).map(|seed| run("w", seed, successes)).collect();
        let (a, b) = (system("a", runs(&MIXED)), system("b", runs(&other)));
        let compared = compare(&[a, b], 0.02).unwrap();
        assert_eq!(
            (compared.tests[0].only_other, compared.tests[0].pairs),
            (5, 30)
        );
        assert_eq!(compared.tests[0].p, 1.0, "one episode shows nothing");
    }

    #[test]
    fn with_enough_worlds_they_are_the_clusters() {
        let worlds = ["a", "b", "c", "d", "e"];
        let runs = worlds.map(|world| run(world, 1, &MIXED));
        let system = system("a", runs.into());
        let compared = compare(&[system.clone(), system], 0.02).unwrap();
        assert_eq!(compared.clustered_by, ClusteredBy::World);
    }

    #[test]
    fn runs_of_other_suites_worlds_or_seeds_are_refused() {
        let a = system("a", vec![run("w", 1, &MIXED)]);
        let mut other_suite = run("w", 1, &MIXED);
        other_suite.provenance.hashes.suite = "another".into();
        for other in [run("v", 1, &MIXED), run("w", 2, &MIXED), other_suite] {
            let b = system("b", vec![other]);
            let error = compare(&[a.clone(), b], 0.02).unwrap_err();
            assert!(matches!(error, CompareError::NotTheSame { .. }), "{error}");
        }
        let twice = system("twice", vec![run("w", 1, &MIXED), run("w", 1, &MIXED)]);
        let error = compare(&[twice], 0.02).unwrap_err();
        assert!(matches!(error, CompareError::Twice { .. }), "{error}");
        let error = compare(&[system("none", vec![])], 0.02).unwrap_err();
        assert!(matches!(error, CompareError::NoRuns { .. }), "{error}");
        let mut other_agent = run("w", 2, &MIXED);
        other_agent.agent = "another".into();
        let mixed = system("mixed", vec![run("w", 1, &MIXED), other_agent]);
        let error = compare(&[mixed], 0.02).unwrap_err();
        assert!(matches!(error, CompareError::Mixed { .. }), "{error}");
        let mut old = run("w", 1, &MIXED);
        old.provenance.hashes = Default::default();
        let error = compare(&[system("old", vec![old])], 0.02).unwrap_err();
        assert!(matches!(error, CompareError::Unplaced { .. }), "{error}");
    }

    #[test]
    fn a_system_alone_says_how_many_episodes_a_comparison_takes() {
        let a = system("a", vec![run("w", 1, &MIXED)]);
        let to_tell = compare(&[a], 0.1).unwrap().to_tell.unwrap();
        assert!(to_tell.pairs > 200 && to_tell.pairs < 500, "{to_tell:?}");
    }
}
