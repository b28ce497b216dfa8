//! The rectangle that a world covers: around the buildings of its map.

use openbench_core::Georeference;
use openbench_geometry::Bounds;
use openbench_osm::OsmMap;

use crate::generate::error::{GenerateError, MAX_BUILDINGS, MAX_EXTENT_M};

/// Ground beyond the outermost mapped building, metres.
pub(crate) const GROUND_MARGIN_M: f64 = 80.0;
/// Farther than this from UTM's central meridian lengths are half a percent too long, metres.
const MAX_FROM_MERIDIAN_M: f64 = 640_000.0;
/// Farther than this from the point at which a plane touches the Earth lengths are half a percent
/// too short, metres.
const MAX_FROM_TOUCH_M: f64 = 640_000.0;

/// The rectangle around a map's buildings.
///
/// Roads and areas may reach far out of an extract; the buildings say where the neighbourhood is.
///
/// # Errors
/// A map without buildings, one that is too large, and one that lies where the georeference
/// distorts lengths.
pub(crate) fn extent_of(map: &OsmMap, georeference: Georeference) -> Result<Bounds, GenerateError> {
    if map.buildings.len() > MAX_BUILDINGS {
        let buildings = map.buildings.len();
        return Err(GenerateError::TooMany { buildings });
    }
    let corners = map.buildings.iter().flat_map(|b| &b.polygon.outer);
    let Some(extent) = corners.map(|p| Bounds::of_point(*p)).reduce(Bounds::union) else {
        let broken = map.report.broken_buildings;
        return Err(GenerateError::NoBuildings { broken });
    };
    let metres = (extent.high.x - extent.low.x).max(extent.high.y - extent.low.y);
    if metres > MAX_EXTENT_M {
        return Err(GenerateError::TooLarge { metres });
    }
    check_scale(extent, georeference)?;
    Ok(extent)
}

/// Whether lengths in the middle of the world are true enough.
fn check_scale(extent: Bounds, georeference: Georeference) -> Result<(), GenerateError> {
    let metres = georeference.distance_from_true_scale(extent.middle());
    let limit = match georeference {
        Georeference::Utm { .. } => MAX_FROM_MERIDIAN_M,
        Georeference::TangentPlane { .. } => MAX_FROM_TOUCH_M,
    };
    // NaN is refused too.
    if metres.is_nan() || metres > limit {
        let georeference = georeference.to_string();
        return Err(GenerateError::Distorted {
            metres,
            georeference,
        });
    }
    Ok(())
}
