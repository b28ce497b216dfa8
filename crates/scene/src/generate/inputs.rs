//! What a world is generated from: the map with all that was computed of it before anything is
//! built. Generators read it and change nothing in it.

use openbench_core::MapPoint;
use openbench_geometry::{Bounds, Polygon, Segment};
use openbench_osm::OsmMap;

use super::doors::doorway::Doorway;
use super::doors::neighbourhood::Neighbourhood;
use super::layout::clearance::Clearance;
use super::layout::extent::GROUND_MARGIN_M;
use super::layout::features::{Feature, TreeRow};
use super::layout::lanes::Lanes;
use super::materials::palette::Palette;
use super::options::GenerateOptions;
use super::scenery::relief::Relief;

/// The inputs of all generators.
pub(super) struct Inputs<'a> {
    pub map: &'a OsmMap,
    /// Tagged nodes.
    pub features: Vec<Feature>,
    pub tree_rows: Vec<TreeRow>,
    pub sea: Vec<Polygon>,
    /// Lines of the low walls around water.
    pub quays: Vec<Segment>,
    /// In the order of buildings and their entrances.
    pub doorways: Vec<Doorway>,
    /// What plates depend on beyond their doors.
    pub neighbourhood: Neighbourhood,
    /// Every road's segments.
    pub lanes: Lanes,
    /// Around the buildings.
    pub extent: Bounds,
    /// What the map, the doors and the start keep free.
    pub clearance: Clearance,
    /// Steps, ramps and light wells.
    pub relief: Relief,
    pub palette: Palette,
    pub seed: u64,
    pub options: &'a GenerateOptions,
    /// Whether there are so few buildings that each is worth more triangles.
    pub detailed: bool,
}

impl Inputs<'_> {
    /// Whether the world has ground at a point.
    pub fn is_on_ground(&self, p: MapPoint) -> bool {
        self.extent.holds(p, GROUND_MARGIN_M)
    }
}
