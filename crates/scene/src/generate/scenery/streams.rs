//! Streams of random numbers of the scenery. Their numbers are part of worlds: new ones go to the
//! end.

use openbench_core::MapPoint;
use openbench_osm::draws;
use rand_pcg::Pcg64Mcg;

/// The purpose of a stream. The numbers begin above those of plates.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
pub(crate) enum Purpose {
    Lot = 201,
    LotCorner,
    Tree,
    Car,
    BesideDoor,
    AtWall,
    OnPavement,
    Kerb,
    Steps,
    Well,
}

/// The stream of one element for one purpose.
pub(crate) fn stream(seed: u64, purpose: Purpose, element: u64) -> Pcg64Mcg {
    draws::stream(seed, purpose as u64, element)
}

/// A number for a place: other things do not change it.
pub(crate) fn place_number(place: MapPoint) -> u64 {
    place.x.to_bits() ^ place.y.to_bits().rotate_left(32)
}
