//! The world that generators build: its scene, and what had to be left out.

use std::collections::BTreeMap;

use super::hung::HungFace;
use crate::material::{Material, MaterialId, SemanticClass};
use crate::plate::plate_material;
use crate::plates::{Design, DrawnPlates, Line, Wear, draw_face};
use crate::scene::{Scene, SceneBuilder};
use crate::scenery::DrawnScenery;

/// Number of visible triangles that a world may have. One takes about 150 bytes of memory, with
/// everything that is derived from it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// From so many on a world gets no more windows, lines, fences, trees and cars: walls, roofs,
    /// doors and streets only.
    pub ornate: usize,
    /// From so many on it gets nothing more at all.
    pub bare: usize,
}

impl Limits {
    pub const USUAL: Self = Self {
        ornate: 8_000_000,
        bare: 10_000_000,
    };
}

/// A world under construction.
pub(super) struct Output {
    /// Meshes, objects and doors.
    pub scene: SceneBuilder,
    /// Descriptions of what had to be left out.
    pub warnings: Vec<String>,
    /// Materials of plates by text.
    plates: BTreeMap<String, MaterialId>,
    /// Faces of plates as in streets, by all that they show.
    street_faces: BTreeMap<String, HungFace>,
    /// What was drawn of those.
    pub drawn_plates: DrawnPlates,
    /// What was drawn to make streets differ.
    pub drawn_scenery: DrawnScenery,
    limits: Limits,
    /// Buildings and streets beyond the limit.
    left_out: usize,
}

/// A finished scene.
pub(super) struct Finished {
    pub scene: Scene,
    /// The plates that were drawn as in streets.
    pub plates: Option<DrawnPlates>,
    /// What was drawn to make streets differ.
    pub scenery: DrawnScenery,
    /// Descriptions of what had to be left out.
    pub warnings: Vec<String>,
}

impl Output {
    pub fn new(scene: SceneBuilder, warnings: Vec<String>, limits: Limits) -> Self {
        Self {
            scene,
            warnings,
            plates: BTreeMap::new(),
            street_faces: BTreeMap::new(),
            drawn_plates: DrawnPlates::default(),
            drawn_scenery: DrawnScenery::default(),
            limits,
            left_out: 0,
        }
    }

    /// Whether there is no room for more than walls, roofs, doors and streets.
    pub fn is_full(&self) -> bool {
        self.scene.triangles() >= self.limits.ornate
    }

    /// Whether there is no room for anything.
    pub fn is_closed(&self) -> bool {
        self.scene.triangles() >= self.limits.bare
    }

    /// Whether there is room for a building or street; counts it as left out if there is none.
    pub fn admits(&mut self) -> bool {
        // Asked once for each building and street, so the count is right.
        self.left_out += usize::from(self.is_closed());
        !self.is_closed()
    }

    /// The material with the image of a text, shared by all plates that bear it.
    pub fn plate_face(&mut self, text: &str) -> MaterialId {
        // A town has thousands of doors and few different units. The image of a plate takes 180 kB.
        if let Some(face) = self.plates.get(text) {
            return *face;
        }
        let face = plate_material(&mut self.scene, text);
        self.plates.insert(text.to_owned(), face);
        face
    }

    /// A plate or sign as in streets, of a class; those that show the same share an image.
    pub fn street_face(
        &mut self,
        class: SemanticClass,
        design: &Design,
        lines: &[Line],
        names: &[&str],
        wear: Wear,
    ) -> HungFace {
        let key = format!("{class:?} {design:?} {lines:?} {names:?} {wear:?}");
        if let Some(face) = self.street_faces.get(&key) {
            return *face;
        }
        let drawn = draw_face(design, lines, names, wear);
        let texture = self.scene.texture(drawn.texture);
        let mut material = Material::plain(class, [1.0; 3]).with_texture(texture);
        material.cutout = drawn.has_holes;
        let face = HungFace {
            material: self.scene.material(material),
            edge: self.scene.material(Material::plain(class, [0.3; 3])),
            size: drawn.size,
            text: drawn.text,
            text_above_m: drawn.text_above_m,
            has_holes: drawn.has_holes,
            thickness_m: design.make.thickness_m(),
        };
        self.street_faces.insert(key, face);
        face
    }

    /// The scene, with warnings if it was too large.
    pub fn finish(mut self) -> Finished {
        if self.is_full() {
            self.warnings.push(format!(
                "the map is more than {} triangles; windows, fences, trees and cars beyond that \
                 were left out",
                self.limits.ornate
            ));
        }
        if self.left_out > 0 {
            self.warnings.push(format!(
                "{} buildings and streets are beyond {} triangles and were left out; cut out a \
                 neighbourhood",
                self.left_out, self.limits.bare
            ));
        }
        Finished {
            scene: self.scene.build(),
            plates: Some(self.drawn_plates),
            scenery: self.drawn_scenery,
            warnings: self.warnings,
        }
    }
}
