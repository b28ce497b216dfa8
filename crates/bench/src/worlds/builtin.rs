//! The built-in suites. Their deliveries are drawn from the doors of their worlds.

use openbench_core::Address;
use openbench_sim::traffic::TrafficPlan;

use super::load;
use crate::BenchError;
use crate::suite::builtin::{BUILT_IN, builtin_suites};
use crate::suite::draw::Draw;
use crate::suite::{Sensors, Suite, WorldSource};

/// The built-in suite of that name. Its deliveries are the same on every call.
///
/// # Errors
/// [`BenchError::UnknownSuite`] with the names that there are.
pub fn builtin_suite(name: &str) -> Result<Suite, BenchError> {
    let unknown = || BenchError::UnknownSuite {
        name: name.to_owned(),
        known: builtin_suites(),
    };
    let built_in = BUILT_IN
        .iter()
        .find(|suite| suite.name == name)
        .ok_or_else(unknown)?;
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
        traffic: TrafficPlan::default(),
        episodes,
        sensors: Sensors::default(),
    })
}
