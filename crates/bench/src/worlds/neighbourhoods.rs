//! Suites of neighbourhoods that are drawn by seed.

use openbench_core::Address;
use openbench_neighbourhoods::Kind;
use openbench_sim::traffic::TrafficPlan;

use super::Prepared;
use crate::BenchError;
use crate::suite::builtin::BUILT_IN;
use crate::suite::draw::Draw;
use crate::suite::{Conditions, GoalKind, Sensors, Suite, TargetSource, WorldSource};

/// The suite of a drawn neighbourhood: as many deliveries as the built-in suite of its kind has,
/// drawn by the same seed from the doors that a robot reaches.
///
/// # Errors
/// [`BenchError::World`] if no robot reaches any of its doors.
pub fn neighbourhood_suite(kind: Kind, seed: u64) -> Result<Suite, BenchError> {
    let mut suite = Suite {
        name: format!("{kind}-{seed}"),
        world: WorldSource::Drawn {
            kind: kind.name().to_owned(),
            seed,
        },
        targets: TargetSource::World,
        goal: GoalKind::default(),
        traffic: TrafficPlan::default(),
        episodes: Vec::new(),
        sensors: Sensors::default(),
        conditions: Conditions::default(),
        seed: 0,
    };
    let prepared = Prepared::world_of(suite.clone())?;
    let doors = prepared.world.scene.doors.iter().zip(&prepared.approach);
    let reached: Vec<Address> = doors
        .filter(|(_, approach)| approach.is_some())
        .map(|(door, _)| door.address.clone())
        .collect();
    if reached.is_empty() {
        let problem = format!("{}: a robot reaches no door; use another seed", suite.name);
        return Err(BenchError::world(problem));
    }
    let mut draw = Draw::new(reached, seed);
    for counts in BUILT_IN.iter().filter(|counts| counts.name == kind.name()) {
        suite.episodes.extend(draw.singles(counts.singles));
        let sequences = draw.sequences(counts.sequences, counts.length);
        suite.episodes.extend(sequences);
    }
    Ok(suite)
}

/// The kind and seed in a name such as `medium-7`.
pub(super) fn kind_and_seed(name: &str) -> Option<(Kind, u64)> {
    let (kind, seed) = name_and_seed(name)?;
    Some((kind.parse().ok()?, seed))
}

/// What stands before and behind the last hyphen, if that is a seed.
pub(super) fn name_and_seed(name: &str) -> Option<(&str, u64)> {
    let (name, seed) = name.rsplit_once('-')?;
    // No signs, no leading zeros: one suite has one name.
    let number: u64 = seed.parse().ok().filter(|n: &u64| n.to_string() == seed)?;
    Some((name, number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_a_kind_and_a_seed() {
        assert_eq!(kind_and_seed("medium-7"), Some((Kind::Medium, 7)));
        for other in [
            "medium",
            "medium-",
            "medium-07",
            "medium-+7",
            "huge-7",
            "a-medium-7",
        ] {
            assert_eq!(kind_and_seed(other), None, "{other}");
        }
    }
}
