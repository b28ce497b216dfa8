//! Doors: leaf, frame, doorstep, canopy, lamp, and the plate beside the door or on its leaf.

use openbench_core::Pose2;
use openbench_geometry::Segment;
use rand_pcg::Pcg64Mcg;

use super::doorway::{Doorway, LEAF_WIDTH_M};
use super::street_plate;
use crate::generate::buildings::house::House;
use crate::generate::inputs::Inputs;
use crate::generate::output::Output;
use crate::generate::seeds::{chance, pick};
use crate::generate::shapes::{Block, Surface, cuboid, panel};
use crate::material::SemanticClass;
use crate::plate::{USUAL_LETTERING, hang_plate, plate_pose};
use crate::scene::{Door, Layer, SceneBuilder};

/// Height of a door leaf, metres.
const LEAF_HEIGHT_M: f64 = 2.1;
/// Width of the frame, metres.
const FRAME_WIDTH_M: f64 = 0.12;
/// Height of the doorstep: low enough for a wheel not to notice, metres.
const STEP_HEIGHT_M: f64 = 0.018;
/// Thickness of a plate, metres.
const PLATE_THICKNESS_M: f64 = 0.03;

/// Where a plate hangs, metres.
struct Hanging {
    /// Height of its middle.
    height: f64,
    /// Distance of its back from the wall.
    depth: f64,
}

const ON_LEAF: Hanging = Hanging {
    height: 1.62,
    depth: 0.07,
};
const BESIDE_DOOR: Hanging = Hanging {
    height: 1.66,
    depth: 0.04,
};

/// Builds a door of a house.
pub(crate) fn build(
    inputs: &Inputs,
    out: &mut Output,
    house: &House,
    door: &Doorway,
    rng: &mut Pcg64Mcg,
) {
    let palette = &inputs.palette;
    out.scene
        .begin_object(format!("door of {}", door.address), SemanticClass::Door);
    let pose = door.pose();
    let own = if chance(rng, 0.3) {
        pick(rng, &palette.doors)
    } else {
        house.door
    };
    let lift = inputs.relief.lift(door);
    let leaf = Segment::across(pose, 0.05, LEAF_WIDTH_M / 2.0);
    panel(
        &mut out.scene,
        Layer::Visible,
        own,
        leaf,
        STEP_HEIGHT_M + lift..LEAF_HEIGHT_M + lift,
    );
    frame(&mut out.scene, house.trim, pose, lift);
    let mut add = |surface: Surface, min: [f64; 3], max: [f64; 3]| {
        cuboid(
            &mut out.scene,
            Layer::Visible,
            surface,
            pose,
            Block { min, max },
        );
    };
    add(
        // Visible only: at 18 mm it is no obstacle, and wheels need not climb it.
        palette.doorstep,
        [0.0, -0.8, lift],
        [1.0, 0.8, STEP_HEIGHT_M + lift],
    );
    let doormat_top = STEP_HEIGHT_M + 0.004 + lift;
    add(
        palette.earth,
        [0.1, -0.45, STEP_HEIGHT_M + lift],
        [0.6, 0.45, doormat_top],
    );
    if house.canopy && house.eaves > 2.8 + lift {
        let [low, middle, top] = [2.5, 2.6, 2.66].map(|z| z + lift);
        add(house.trim, [0.0, -0.95, low], [0.95, 0.95, middle]);
        add(house.roofing, [0.0, -1.0, middle], [1.0, 1.0, top]);
    }
    // A lamp on the side where the plate is not.
    let side = if door.plate_offset > 0.0 { -0.85 } else { 0.85 };
    add(
        palette.dark_metal,
        [0.0, side - 0.06, 1.95],
        [0.12, side + 0.06, 2.0],
    );
    add(
        palette.lamp_glass,
        [0.03, side - 0.05, 2.0],
        [0.12, side + 0.05, 2.2],
    );
    if inputs.options.plates.shares.real {
        street_plate::hang(inputs, out, house, door);
    } else {
        plate(out, door);
    }
}

/// The frame of a door that is `lift` metres above the ground.
fn frame(scene: &mut SceneBuilder, surface: Surface, pose: Pose2, lift: f64) {
    let inner = LEAF_WIDTH_M / 2.0;
    let outer = inner + FRAME_WIDTH_M;
    let (head, top) = (LEAF_HEIGHT_M + lift, LEAF_HEIGHT_M + FRAME_WIDTH_M + lift);
    let parts = [
        Block {
            min: [0.0, -outer, 0.0],
            max: [0.09, -inner, head],
        },
        Block {
            min: [0.0, inner, 0.0],
            max: [0.09, outer, head],
        },
        Block {
            min: [0.0, -outer, head],
            max: [0.09, outer, top],
        },
    ];
    for part in parts {
        cuboid(scene, Layer::Visible, surface, pose, part);
    }
}

fn plate(out: &mut Output, door: &Doorway) {
    let on_leaf = door.plate_offset == 0.0;
    let Hanging { height, depth } = if on_leaf { ON_LEAF } else { BESIDE_DOOR };
    let pose = door.pose();
    let back = pose.transform(depth, door.plate_offset);
    // Plates with one text share an image.
    let face = out.plate_face(&door.text);
    let hung = plate_pose([back.x, back.y, height], door.facing);
    hang_plate(&mut out.scene, face, &hung, PLATE_THICKNESS_M);
    let middle = pose.transform(depth + PLATE_THICKNESS_M, door.plate_offset);
    out.scene.door(Door {
        address: door.address.clone(),
        text: door.text.clone(),
        plate: [middle.x, middle.y, height],
        facing: door.facing,
        lettering: USUAL_LETTERING,
        doorway: Some(pose),
    });
}
