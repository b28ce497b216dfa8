//! A drive and a map: what a robot knows when it is to be localized.

use std::collections::BTreeSet;
use std::sync::Arc;

use openbench_bench::suite::StartErrors;
use openbench_bench::{BenchError, Prepared};
use openbench_core::{Pose2, Start};
use openbench_osm::OsmMap;
use openbench_osm::disturb::{Disturbed, MapErrors, disturb};

use super::drives::Drive;
use super::mixed_seed;

/// So many drives have the same map.
const DRIVES_OF_MAP: usize = 5;

/// What a robot knows about its start.
#[derive(Clone, Copy)]
pub enum Known<'a> {
    /// Its start with these errors.
    Start(StartErrors),
    /// Nothing, and its map is that of this other world.
    Off(&'a Prepared),
}

/// A map with errors.
#[derive(Debug, Clone)]
pub struct WrongMap {
    /// As the robot gets it.
    pub map: Arc<OsmMap>,
    /// What is wrong with it; `None` if it is of another place.
    pub errors: Option<Disturbed>,
}

/// A drive, and what the robot knows on it.
#[derive(Debug, Clone)]
pub struct Case<'a> {
    /// What it sees.
    pub drive: &'a Drive,
    /// Its map.
    pub map: Arc<WrongMap>,
    /// What it knows about the start, in the frame of its map.
    pub start: Start,
}

impl Case<'_> {
    /// A true pose in the frame of the robot's map; `None` if that is of another place.
    pub fn on_map(&self, truth: Pose2) -> Option<Pose2> {
        let errors = self.map.errors.as_ref()?;
        Some(errors.frame.compose(truth))
    }
}

/// Draws a case for each drive.
///
/// # Errors
/// A map of which the errors would leave nothing.
pub fn cases<'a>(
    prepared: &Prepared,
    drives: &'a [Drive],
    level: &MapErrors,
    known: Known<'_>,
    seed: u64,
) -> Result<Vec<Case<'a>>, BenchError> {
    let mut cases = Vec::new();
    for (number, chunk) in drives.chunks(DRIVES_OF_MAP).enumerate() {
        let of_map = mixed_seed(seed, number as u64);
        let map = Arc::new(wrong_map(prepared, level, known, of_map)?);
        for drive in chunk {
            let truth = drive.first.truth;
            let own = mixed_seed(of_map, cases.len() as u64);
            let start = match (known, &map.errors) {
                (Known::Start(errors), Some(wrong)) => errors.draw(wrong.frame.compose(truth), own),
                _ => Start::Anywhere,
            };
            let map = Arc::clone(&map);
            cases.push(Case { drive, map, start });
        }
    }
    Ok(cases)
}

fn wrong_map(
    prepared: &Prepared,
    level: &MapErrors,
    known: Known<'_>,
    seed: u64,
) -> Result<WrongMap, BenchError> {
    let world = match known {
        Known::Start(_) => &prepared.world,
        Known::Off(other) => &other.world,
    };
    // Nothing is ordered, so nothing is spared.
    let ordered = BTreeSet::new();
    let wrong = disturb(&world.map, world.georeference, level, &ordered, seed);
    let wrong = wrong.map_err(|error| BenchError::world(error.to_string()))?;
    Ok(WrongMap {
        map: Arc::new(OsmMap::new(&wrong.map, world.georeference)),
        errors: matches!(known, Known::Start(_)).then_some(wrong),
    })
}
