//! The built-in suites, whose deliveries are drawn from the doors of their worlds.

use openbench_core::Address;
use openbench_sim::traffic::TrafficPlan;

use super::load;
use crate::BenchError;
use crate::suite::builtin::{BUILT_IN, known_suites};
use crate::suite::draw::Draw;
use crate::suite::{Conditions, GoalKind, Sensors, Suite, TargetSource, WorldSource};

/// A built-in suite: `small`, `medium`, `large`, or that of a real place, such as `krems`; the same
/// deliveries on every call.
///
/// ```
/// let suite = openbench_bench::builtin_suite("small")?;
/// let sequences = suite.episodes.iter().filter(|e| e.deliveries.len() > 1).count();
/// assert_eq!((suite.episodes.len(), sequences), (9, 1));
/// # Ok::<(), openbench_bench::BenchError>(())
/// ```
///
/// # Errors
/// [`BenchError::UnknownSuite`] with the known names.
pub fn builtin_suite(name: &str) -> Result<Suite, BenchError> {
    let unknown = || BenchError::UnknownSuite {
        name: name.to_owned(),
        known: known_suites(),
    };
    let built_in = BUILT_IN
        .iter()
        .find(|suite| suite.name == name)
        .ok_or_else(unknown)?;
    // World and deliveries do not depend on the seed of a run, so that runs can be compared.
    let source = WorldSource::Builtin {
        name: name.to_owned(),
        seed: 1,
    };
    let world = load(&source)?;
    let addresses: Vec<Address> = world
        .scene
        .doors
        .iter()
        .map(|d| d.address.clone())
        .collect();
    let mut draw = Draw::new(addresses, 1);
    let mut episodes = draw.singles(built_in.singles);
    episodes.extend(draw.sequences(built_in.sequences, built_in.length));
    Ok(Suite {
        name: name.to_owned(),
        world: source,
        targets: TargetSource::World,
        goal: GoalKind::default(),
        traffic: TrafficPlan::default(),
        episodes,
        sensors: Sensors::default(),
        conditions: Conditions::default(),
        seed: 0,
    })
}
