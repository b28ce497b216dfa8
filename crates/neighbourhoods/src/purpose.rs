//! Streams of random numbers: one for each purpose and thing, so that one more house changes no
//! other.

use openbench_osm::draws::{self, mix};
use rand_pcg::Pcg64Mcg;

use crate::kind::Kind;

/// The purpose of a stream. The numbers are part of every neighbourhood: new ones go to the end.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
pub(crate) enum Purpose {
    Style = 1,
    Network,
    Lot,
    Slab,
    Numbers,
    Doors,
    Garden,
    Greenery,
    Start,
    Place,
    Streets,
}

/// The seed of a neighbourhood: kinds with one seed have nothing in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seed(u64);

impl Seed {
    pub fn new(kind: Kind, seed: u64) -> Self {
        Self(mix(mix(seed) ^ (kind as u64 + 1)))
    }

    /// The stream of one thing for one purpose.
    pub fn stream(self, purpose: Purpose, thing: u64) -> Pcg64Mcg {
        draws::stream(self.0, purpose as u64, thing)
    }
}
