//! Doors: leaf, frame, doorstep, canopy, and the plate beside the door or on its leaf.

use openbench_core::Pose2;
use rand_pcg::Pcg64Mcg;

use super::Site;
use super::buildings::House;
use super::entrances::{Doorway, LEAF};
use super::seeds::{chance, pick};
use super::shapes::{Surface, cuboid, panel};
use crate::material::{MaterialId, SemanticClass};
use crate::plate::{hang_plate, plate_material, plate_pose};
use crate::scene::{Door, Layer};

/// Height of a door leaf, metres.
const LEAF_HEIGHT: f64 = 2.1;
/// Height of the doorstep: low enough for a wheel not to notice, metres.
const STEP: f64 = 0.018;
/// Height of the plate's middle on the leaf and beside the door, metres.
const PLATE_HEIGHT: (f64, f64) = (1.62, 1.66);
/// How far the plate is in front of the wall on the leaf and beside the door, metres.
const PLATE_DEPTH: (f64, f64) = (0.07, 0.04);
/// How thick a plate is, metres.
const PLATE_THICKNESS: f64 = 0.03;

impl Site {
    pub(super) fn doorway(&mut self, house: &House, door: &Doorway, rng: &mut Pcg64Mcg) {
        self.builder
            .object(format!("door of {}", door.address), SemanticClass::Door);
        let pose = door.pose();
        let half = LEAF / 2.0;
        let leaf = (pose.transform(0.05, -half), pose.transform(0.05, half));
        let own = if chance(rng, 0.3) {
            pick(rng, &self.palette.doors)
        } else {
            house.door
        };
        panel(
            &mut self.builder,
            Layer::Visible,
            own,
            leaf,
            (STEP, LEAF_HEIGHT),
        );
        self.frame(house.trim, pose, half);
        let mut add = |surface: Surface, min: [f64; 3], max: [f64; 3]| {
            cuboid(&mut self.builder, Layer::Visible, surface, pose, (min, max));
        };
        add(self.palette.doorstep, [0.0, -0.8, 0.0], [1.0, 0.8, STEP]);
        add(
            self.palette.earth,
            [0.1, -0.45, STEP],
            [0.6, 0.45, STEP + 0.004],
        );
        if house.canopy && house.eaves > 2.8 {
            add(house.trim, [0.0, -0.95, 2.5], [0.95, 0.95, 2.6]);
            add(house.roofing, [0.0, -1.0, 2.6], [1.0, 1.0, 2.66]);
        }
        // A lamp on the side where the plate is not.
        let side = if door.plate_offset > 0.0 { -0.85 } else { 0.85 };
        add(
            self.palette.dark_metal,
            [0.0, side - 0.06, 1.95],
            [0.12, side + 0.06, 2.0],
        );
        add(
            self.palette.lamp_glass,
            [0.03, side - 0.05, 2.0],
            [0.12, side + 0.05, 2.2],
        );
        self.plate(door, pose);
    }

    fn frame(&mut self, surface: Surface, pose: Pose2, half: f64) {
        let (inner, outer, top) = (half, half + 0.12, LEAF_HEIGHT + 0.12);
        let parts = [
            ([0.0, -outer, 0.0], [0.09, -inner, LEAF_HEIGHT]),
            ([0.0, inner, 0.0], [0.09, outer, LEAF_HEIGHT]),
            ([0.0, -outer, LEAF_HEIGHT], [0.09, outer, top]),
        ];
        for part in parts {
            cuboid(&mut self.builder, Layer::Visible, surface, pose, part);
        }
    }

    fn plate(&mut self, door: &Doorway, pose: Pose2) {
        let on_leaf = door.plate_offset == 0.0;
        let height = if on_leaf {
            PLATE_HEIGHT.0
        } else {
            PLATE_HEIGHT.1
        };
        let depth = if on_leaf {
            PLATE_DEPTH.0
        } else {
            PLATE_DEPTH.1
        };
        let back = pose.transform(depth, door.plate_offset);
        let face = self.plate_face(&door.text);
        let hung = plate_pose([back.x, back.y, height], door.facing);
        hang_plate(&mut self.builder, face, &hung, PLATE_THICKNESS);
        let middle = pose.transform(depth + PLATE_THICKNESS, door.plate_offset);
        self.builder.door(Door {
            address: door.address.clone(),
            text: door.text.clone(),
            plate: [middle.x, middle.y, height],
            facing: door.facing,
        });
    }

    /// The picture of a text, shared by all plates that bear it.
    fn plate_face(&mut self, text: &str) -> MaterialId {
        if let Some(face) = self.plates.get(text) {
            return *face;
        }
        let face = plate_material(&mut self.builder, text);
        self.plates.insert(text.to_owned(), face);
        face
    }
}
