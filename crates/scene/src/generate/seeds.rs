//! Streams of random numbers: one for each purpose and element, so that one more tree in the map
//! does not repaint the houses.

use openbench_osm::draws;
use rand_pcg::Pcg64Mcg;

pub(super) use openbench_osm::draws::{between, chance, element_number, mix, pick};

/// The purpose of a stream. The numbers are part of every world: new purposes go to the end.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
pub(super) enum Purpose {
    Palette = 1,
    Building,
    Doorway,
    Cars,
    Tree,
    Barrier,
    Planting,
    Furniture,
    Horizon,
    Wear,
}

/// The stream of one element for one purpose.
pub(super) fn stream(seed: u64, purpose: Purpose, element: u64) -> Pcg64Mcg {
    draws::stream(seed, purpose as u64, element)
}
