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

/// A whole number from `low` to `high`, both included.
pub(crate) fn whole(draws: &mut Pcg64Mcg, low: u32, high: u32) -> u32 {
    let span = f64::from(high - low + 1);
    let drawn = draws::between(draws, 0.0, span) as u32;
    // Rounding may give the end of the span itself.
    low + drawn.min(high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_reach_both_ends() {
        let mut draws = Seed::new(Kind::Small, 1).stream(Purpose::Style, 0);
        let drawn: Vec<u32> = (0..200).map(|_| whole(&mut draws, 3, 5)).collect();
        assert!((3..=5).all(|n| drawn.contains(&n)));
        assert!(drawn.iter().all(|n| (3..=5).contains(n)));
    }
}
