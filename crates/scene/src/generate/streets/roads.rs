//! Carriageways, pavements and paths.

use openbench_core::MapPoint;
use openbench_geometry::line::parallel;
use openbench_osm::{Road, Tags};

use super::profile::{KERB_WIDTH_M, Profile, profile};
use crate::generate::ground::levels::{
    Z_KERB_M, Z_PATH_M, Z_PAVEMENT_M, Z_ROAD_M, Z_SERVICE_M, Z_SIDEWALK_M,
};
use crate::generate::inputs::Inputs;
use crate::generate::materials::palette::Palette;
use crate::generate::output::Output;
use crate::generate::shapes::{Surface, band};
use crate::material::SemanticClass;
use crate::scene::SceneBuilder;

/// Overlap of a pavement with its kerb, metres.
const OVERLAP_M: f64 = 0.01;

/// Builds the map's roads and paths.
pub(crate) fn build(inputs: &Inputs, out: &mut Output) {
    for road in &inputs.map.roads {
        let Some(profile) = profile(&road.tags) else {
            continue;
        };
        // In this order: a road far away is not counted as left out.
        if !is_near(inputs, &road.points) || !out.admits() {
            continue;
        }
        let name = road
            .tags
            .get("name")
            .or(road.tags.get("highway"))
            .unwrap_or("road");
        let name = name.to_owned();
        let palette = &inputs.palette;
        if profile.for_cars {
            out.scene.begin_object(name, SemanticClass::Road);
            carriageway(&mut out.scene, palette, road, profile);
        } else {
            out.scene.begin_object(name, SemanticClass::Pavement);
            let surface = path_surface(&road.tags, palette);
            let z = if surface == palette.paving {
                Z_SIDEWALK_M
            } else {
                Z_PATH_M
            };
            band(
                &mut out.scene,
                surface,
                &road.points,
                profile.width / 2.0,
                z,
            );
        }
    }
}

fn is_near(inputs: &Inputs, line: &[MapPoint]) -> bool {
    line.iter().any(|p| inputs.is_on_ground(*p))
}

fn carriageway(scene: &mut SceneBuilder, palette: &Palette, road: &Road, profile: Profile) {
    let line = &road.points;
    let half = profile.width / 2.0;
    let offset = half + profile.pavement / 2.0;
    let sides = [1.0, -1.0].into_iter().zip(profile.sides);
    for (sign, _) in sides.filter(|(_, has_pavement)| *has_pavement) {
        let middle = parallel(line, sign * offset);
        let half = profile.pavement / 2.0 + OVERLAP_M;
        band(scene, palette.paving, &middle, half, Z_PAVEMENT_M);
    }
    let z = match road.tags.get("highway") {
        Some("service" | "track") => Z_SERVICE_M,
        _ => Z_ROAD_M,
    };
    // Service roads and tracks have no kerb stones.
    if z == Z_ROAD_M {
        band(scene, palette.kerb, line, half + KERB_WIDTH_M, Z_KERB_M);
    }
    band(
        scene,
        carriageway_surface(&road.tags, palette),
        line,
        half,
        z,
    );
}

fn carriageway_surface(tags: &Tags, palette: &Palette) -> Surface {
    match (tags.get("surface"), tags.get("highway")) {
        (Some("gravel" | "fine_gravel" | "compacted" | "unpaved" | "dirt"), _) => palette.gravel,
        (Some("sett" | "paving_stones" | "cobblestone"), _) => palette.path,
        (_, Some("service")) => palette.worn_asphalt,
        (_, Some("track")) => palette.gravel,
        _ => palette.asphalt,
    }
}

fn path_surface(tags: &Tags, palette: &Palette) -> Surface {
    match tags.get("surface") {
        Some("asphalt") => palette.worn_asphalt,
        Some("gravel" | "fine_gravel" | "compacted" | "unpaved") => palette.gravel,
        Some("ground" | "dirt" | "earth") => palette.earth,
        // Surfaces that say what is seen come first; what is left is decided by the kind of path.
        Some("sett" | "cobblestone") => palette.path,
        _ if ["sidewalk", "crossing"]
            .iter()
            .any(|v| tags.is("footway", v)) =>
        {
            palette.paving
        }
        Some("paving_stones" | "concrete") => palette.paving,
        _ => palette.path,
    }
}
