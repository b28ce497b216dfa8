//! The relief of a site.

use openbench_core::MapPoint;

use super::relief::{Relief, Well};
use super::site::Site;
use super::{steps, wells};
use crate::generate::ground::pitted::pieces;
use crate::generate::layout::occupied::Occupied;

/// Draws the relief of a site. Each thing leaves the ways open that those before it left.
pub(crate) fn plan(site: &Site) -> Relief {
    if site.options.amounts.relief <= 0.0 {
        return Relief::default();
    }
    let mut occupied = Occupied::new(site.clearance);
    let entries = steps::plan(site, &mut occupied);
    let wells = wells::plan(site, &mut occupied);
    let holes: Vec<Vec<MapPoint>> = wells.iter().map(Well::hole).collect();
    // Without a ground that adds up there are no wells: neither pits nor counts may have them.
    let ground = pieces(site.ground, &holes).filter(|_| !holes.is_empty());
    let wells = if ground.is_some() { wells } else { Vec::new() };
    Relief {
        entries,
        wells,
        ground: ground.unwrap_or_default(),
    }
}
