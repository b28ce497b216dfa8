//! Wear of carriageways: mended places, manholes, drains at the kerb.

use std::f64::consts::FRAC_PI_4;

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::segments;
use openbench_osm::Road;
use rand_pcg::Pcg64Mcg;

use super::profile::{Profile, profile};
use crate::generate::ground::levels::{Z_LID_M, Z_PATCH_M};
use crate::generate::inputs::Inputs;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, between, chance, stream};
use crate::generate::shapes::{Surface, at, facet, level_rectangle};
use crate::scene::{Layer, SceneBuilder};

/// Length of street in a neighbourhood with one place of wear, metres.
const SPACING_M: f64 = 14.0;
/// The same in a town, metres.
const TOWN_SPACING_M: f64 = 40.0;
/// Narrowest carriageway with wear, metres.
const NARROWEST_M: f64 = 4.5;
/// Radius of a manhole's lid, metres.
const LID_RADIUS_M: f64 = 0.32;
/// Places in one segment at most.
const MOST: usize = 200;

/// What is at a place of wear.
struct Wear {
    mended: bool,
    manhole: bool,
    drain: bool,
}

/// Builds the wear of all carriageways.
pub(crate) fn build(inputs: &Inputs, out: &mut Output) {
    for road in &inputs.map.roads {
        let profile = profile(&road.tags).filter(|p| p.for_cars && p.width >= NARROWEST_M);
        if let Some(profile) = profile {
            wear_of(inputs, out, road, profile);
        }
    }
}

fn wear_of(inputs: &Inputs, out: &mut Output, road: &Road, profile: Profile) {
    let mut rng = stream(inputs.seed, Purpose::Wear, road.way as u64);
    let spacing = if inputs.detailed {
        SPACING_M
    } else {
        TOWN_SPACING_M
    };
    for segment in segments(&road.points) {
        let (length, yaw) = (segment.length(), segment.bearing());
        for i in 0..((length / spacing) as usize).min(MOST) {
            let p = segment.at((i as f64 + between(&mut rng, 0.2, 0.8)) * spacing / length);
            let wear = Wear {
                mended: chance(&mut rng, 0.5),
                manhole: chance(&mut rng, 0.4),
                drain: chance(&mut rng, 0.5),
            };
            if inputs.is_on_ground(p) && !out.is_full() {
                let pose = Pose2::new(p.x, p.y, yaw);
                worn_place(
                    inputs,
                    &mut out.scene,
                    pose,
                    profile.width / 2.0,
                    &wear,
                    &mut rng,
                );
            }
        }
    }
}

/// A place of wear on a carriageway that reaches `half` metres to each side.
fn worn_place(
    inputs: &Inputs,
    scene: &mut SceneBuilder,
    pose: Pose2,
    half: f64,
    wear: &Wear,
    rng: &mut Pcg64Mcg,
) {
    let (patch, iron) = (inputs.palette.patch, inputs.palette.dark_metal);
    if wear.mended {
        let (length, width) = (between(rng, 0.8, 3.5), between(rng, 0.5, 1.4));
        let along = between(rng, -3.0, 3.0);
        // A metre from the edges, since a patch is up to 1.4 m wide.
        let p = pose.transform(along, between(rng, -half + 1.0, half - 1.0));
        let place = Pose2::new(p.x, p.y, pose.yaw);
        level_rectangle(scene, patch, place, length, width, Z_PATCH_M);
    }
    if wear.manhole {
        let side = if chance(rng, 0.5) { 0.45 } else { -0.45 };
        lid(scene, iron, pose.transform(1.5, half * side));
    }
    if wear.drain {
        let side = if chance(rng, 0.5) { 1.0 } else { -1.0 };
        let p = pose.transform(-1.5, (half - 0.22) * side);
        let place = Pose2::new(p.x, p.y, pose.yaw);
        level_rectangle(scene, iron, place, 0.5, 0.32, Z_LID_M);
    }
}

/// An octagonal lid.
fn lid(scene: &mut SceneBuilder, surface: Surface, middle: MapPoint) {
    let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| {
        let direction = FRAC_PI_4 * f64::from(i);
        at(middle.offset(direction, LID_RADIUS_M), Z_LID_M)
    });
    facet(scene, Layer::Visible, surface, &corners);
}
