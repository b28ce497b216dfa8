//! Ground covers that the map has as areas: water, squares, car parks, playgrounds.

use openbench_osm::Tags;

use super::levels::Z_AREA_M;
use crate::generate::inputs::Inputs;
use crate::generate::layout::extent::GROUND_MARGIN_M;
use crate::generate::materials::palette::Palette;
use crate::generate::output::Output;
use crate::generate::shapes::{Surface, floor};
use crate::generate::water::open_water::is_water;
use crate::material::SemanticClass;

/// Builds the areas.
pub(crate) fn build(inputs: &Inputs, out: &mut Output) {
    for area in &inputs.map.areas {
        let Some(surface) = surface_of(&area.tags, &inputs.palette) else {
            continue;
        };
        let polygon = &area.polygon;
        // An area may reach into the world from far away; one that does not is not triangulated.
        if inputs.extent.meets(polygon.bounds(), GROUND_MARGIN_M) {
            let name = area.tags.get("name").unwrap_or("area").to_owned();
            let class = if is_water(&area.tags) {
                SemanticClass::Water
            } else {
                SemanticClass::Ground
            };
            out.scene.begin_object(name, class);
            floor(
                &mut out.scene,
                surface,
                &polygon.outer,
                &polygon.holes,
                Z_AREA_M,
            );
        }
    }
}

fn surface_of(tags: &Tags, palette: &Palette) -> Option<Surface> {
    if tags.is("amenity", "parking") {
        Some(palette.worn_asphalt)
    } else if is_water(tags) {
        Some(palette.water)
    } else if is_sandy(tags) {
        Some(palette.gravel)
    } else if is_earth(tags) {
        Some(palette.earth)
    } else if is_paved(tags) {
        Some(palette.paving)
    } else {
        None
    }
}

/// Whether areas with these tags get a ground cover.
pub(crate) fn is_covered(tags: &Tags) -> bool {
    tags.is("amenity", "parking")
        || is_water(tags)
        || is_sandy(tags)
        || is_earth(tags)
        || is_paved(tags)
}

fn is_earth(tags: &Tags) -> bool {
    tags.is("landuse", "flowerbed") || tags.is("natural", "bare_ground")
}

fn is_sandy(tags: &Tags) -> bool {
    tags.is("leisure", "playground") || tags.is("natural", "sand") || tags.is("natural", "beach")
}

fn is_paved(tags: &Tags) -> bool {
    tags.is("highway", "pedestrian")
        || tags.is("highway", "footway")
        || tags.is("place", "square")
        || ["pier", "breakwater", "groyne"]
            .iter()
            .any(|kind| tags.is("man_made", kind))
        || tags.is("landuse", "railway")
}
