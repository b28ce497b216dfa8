//! Paved ground around the buildings of towns: no lawns between houses that stand wall to wall.

use std::f64::consts::PI;

use openbench_core::MapPoint;
use openbench_osm::OsmMap;

use super::levels::Z_APRON_M;
use crate::generate::inputs::Inputs;
use crate::generate::output::Output;
use crate::generate::shapes::band;
use crate::material::SemanticClass;

/// Width of the paved ground around a building, metres.
pub(crate) const WIDTH_M: f64 = 4.0;
/// A building is in a town if this share of the ground around it is built over.
const BUILT_SHARE: f64 = 0.4;
/// Radius of the ground around it, metres.
const NEIGHBOURHOOD_M: f64 = 30.0;
/// Area of one building that counts at most, m².
const MOST_BUILT_M2: f64 = 1_500.0;
/// Fewer buildings than this make no town.
const FEWEST: usize = 9;
/// A few hundred buildings are enough, should thousands be mapped in one place.
const MOST_COUNTED: usize = 300;

/// Builds the paved ground.
pub(crate) fn build(inputs: &Inputs, out: &mut Output) {
    out.scene.begin_object("paving", SemanticClass::Pavement);
    for building in &inputs.map.buildings {
        if !is_in_town(inputs.map, building.polygon.centroid()) || out.is_full() {
            continue;
        }
        let outer = &building.polygon.outer;
        // Closed: the band follows the outline round to where it began.
        let line: Vec<MapPoint> = outer.iter().chain(outer.first()).copied().collect();
        band(
            &mut out.scene,
            inputs.palette.path,
            &line,
            WIDTH_M,
            Z_APRON_M,
        );
    }
}

/// Whether a place is in a town: its surroundings are built over.
pub(crate) fn is_in_town(map: &OsmMap, middle: MapPoint) -> bool {
    let near = map.buildings_within(middle, NEIGHBOURHOOD_M);
    let areas = near
        .iter()
        .take(MOST_COUNTED)
        .map(|i| map.buildings[*i].polygon.area());
    let built: f64 = areas.map(|area| area.min(MOST_BUILT_M2)).sum();
    let enough = BUILT_SHARE * PI * NEIGHBOURHOOD_M * NEIGHBOURHOOD_M;
    // Both: one large hall is no town, and neither are nine sheds.
    near.len() >= FEWEST && built >= enough
}
