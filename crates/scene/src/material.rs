//! How surfaces look, to the camera and to the LiDAR.

use std::sync::Arc;

/// Index into [`Scene::materials`](crate::Scene::materials).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialId(pub u32);

/// Index into [`Scene::textures`](crate::Scene::textures).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TextureId(pub u32);

/// Class of a surface. Numbers are kept: images of classes and hashes have them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum SemanticClass {
    /// Bare ground, and all ground far away.
    Ground,
    /// Carriageway.
    Road,
    /// Pavement, footway.
    Pavement,
    /// Walls and roofs of buildings.
    Building,
    /// Door leaves.
    Door,
    /// Number plates at doors.
    Plate,
    /// Free-standing walls and fences.
    Wall,
    /// Trees, flowers.
    Vegetation,
    /// Cars.
    Vehicle,
    /// Lamps, benches, signs, boxes.
    Furniture,
    /// People.
    Person,
    /// Raised kerbs.
    Kerb,
    /// Anything else.
    Other,
    /// Lakes, rivers, the sea.
    Water,
    /// Lawns and meadows.
    Grass,
    /// Clipped hedges, and bushes of the same leaves.
    Hedge,
    /// What pixels without a surface show; no surface has it.
    Sky,
}

/// An 8-bit RGBA image that repeats in both directions. Row 0 is the top; v = 0 is the bottom, as
/// in COLLADA and OBJ.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// `4 * width * height` bytes, sRGB and straight alpha.
    pub rgba: Arc<[u8]>,
}

/// How a surface meets light, beyond its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Finish {
    /// As paper: all light comes back evenly.
    #[default]
    Matt,
    /// Panes: light passes through, or is thrown back as by a mirror. Rooms behind may be lit.
    Glass,
    /// The glass of a lamp, which is lit in the dark.
    Lamp,
}

/// How a surface looks.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// sRGB colour, 0 to 1; multiplied with the texture.
    pub color: [f32; 3],
    /// Image over the surface.
    pub texture: Option<TextureId>,
    /// Whether texels with alpha below one half are holes (leaves).
    pub cutout: bool,
    /// Class of the surface.
    pub class: SemanticClass,
    /// Share of the LiDAR light that is reflected at normal incidence, 0 to 255.
    pub reflectivity: u8,
    /// What happens to light that is not spread evenly. Only some conditions make a difference.
    pub finish: Finish,
}

impl Material {
    /// An untextured material.
    pub fn plain(class: SemanticClass, color: [f32; 3]) -> Self {
        // Luma as in ITU-R BT.601. White paint reflects about 60 % of the light (150 of 255).
        let luma = 0.3 * color[0] + 0.59 * color[1] + 0.11 * color[2];
        Self {
            color,
            texture: None,
            cutout: false,
            class,
            reflectivity: (luma * 150.0) as u8,
            finish: Finish::Matt,
        }
    }

    /// The same material with an image.
    pub fn with_texture(mut self, texture: TextureId) -> Self {
        self.texture = Some(texture);
        self
    }
}

impl SemanticClass {
    /// Name, as in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ground => "ground",
            Self::Road => "road",
            Self::Pavement => "pavement",
            Self::Building => "building",
            Self::Door => "door",
            Self::Plate => "plate",
            Self::Wall => "wall",
            Self::Vegetation => "vegetation",
            Self::Vehicle => "vehicle",
            Self::Furniture => "furniture",
            Self::Person => "person",
            Self::Kerb => "kerb",
            Self::Other => "other",
            Self::Water => "water",
            Self::Grass => "grass",
            Self::Hedge => "hedge",
            Self::Sky => "sky",
        }
    }

    /// The class by what a robot meets there: ground for water and grass, vegetation for hedges.
    /// Collisions and hashes of worlds have it, which are those of versions with fewer classes.
    pub fn coarse(self) -> Self {
        match self {
            Self::Water | Self::Grass => Self::Ground,
            Self::Hedge => Self::Vegetation,
            class => class,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::SemanticClass::{self, *};

    /// Each class with its number and its coarse class, as in hashes and images.
    const TABLE: [(SemanticClass, u8, SemanticClass); 17] = [
        (Ground, 0, Ground),
        (Road, 1, Road),
        (Pavement, 2, Pavement),
        (Building, 3, Building),
        (Door, 4, Door),
        (Plate, 5, Plate),
        (Wall, 6, Wall),
        (Vegetation, 7, Vegetation),
        (Vehicle, 8, Vehicle),
        (Furniture, 9, Furniture),
        (Person, 10, Person),
        (Kerb, 11, Kerb),
        (Other, 12, Other),
        (Water, 13, Ground),
        (Grass, 14, Ground),
        (Hedge, 15, Vegetation),
        (Sky, 16, Sky),
    ];

    #[test]
    fn numbers_of_classes_stay() {
        for (class, number, _) in TABLE {
            assert_eq!(class as u8, number, "{class:?}");
        }
    }

    #[test]
    fn what_is_coarse_stays() {
        for (class, _, coarse) in TABLE {
            assert_eq!(class.coarse(), coarse, "{class:?}");
        }
    }
}
