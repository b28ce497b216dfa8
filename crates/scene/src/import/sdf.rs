//! What an SDF world says, after includes and frames are resolved.

use nalgebra::Vector3;
use openbench_core::Pose3;

use crate::Sun;

/// How deep models and includes may be nested.
pub(crate) const MAX_DEPTH: usize = 16;

/// A world.
#[derive(Debug, Default)]
pub(crate) struct SdfWorld {
    /// Models in the order of the file.
    pub(crate) models: Vec<Model>,
    /// Streets.
    pub(crate) roads: Vec<Road>,
    /// Directional light with the world's ambient light.
    pub(crate) sun: Option<Sun>,
}

/// A model, perhaps with models inside.
#[derive(Debug, Clone)]
pub(crate) struct Model {
    /// Its name.
    pub(crate) name: String,
    /// In the frame of the model around it, or of the world.
    pub(crate) pose: Pose3,
    /// Stretch of its shapes, from the world's state.
    pub(crate) scale: Vector3<f64>,
    /// Its bodies.
    pub(crate) links: Vec<Link>,
    /// Models inside.
    pub(crate) models: Vec<Model>,
}

/// A body of a model.
#[derive(Debug, Clone)]
pub(crate) struct Link {
    /// Its name.
    pub(crate) name: String,
    /// In the model's frame.
    pub(crate) pose: Pose3,
    /// What is seen and what is touched.
    pub(crate) shapes: Vec<Shape>,
}

/// A `<visual>` or `<collision>`.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    /// Whether it is seen; else it is touched.
    pub(crate) visual: bool,
    /// In the link's frame.
    pub(crate) pose: Pose3,
    /// Its form.
    pub(crate) geometry: Geometry,
    /// Its looks, where it does not leave them to the mesh.
    pub(crate) paint: Option<Paint>,
}

/// The form of a shape, in its own frame, metres.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Geometry {
    /// Edge lengths.
    Box(Vector3<f64>),
    /// A rectangle that faces `normal`.
    Plane {
        /// Where it faces.
        normal: Vector3<f64>,
        /// Edge lengths.
        size: [f64; 2],
    },
    /// Axis along z, origin in the middle.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Length.
        length: f64,
    },
    /// A ball of that radius.
    Sphere(f64),
    /// Outlines drawn up from z = 0: the first is the outer one, the others are holes in it.
    Extrusion {
        /// x and y of the corners, open: the last is joined to the first.
        outlines: Vec<Vec<[f64; 2]>>,
        /// How high they are drawn up.
        height: f64,
    },
    /// A mesh file.
    Mesh(MeshUse),
    /// A surface whose heights are an image's.
    Heightmap(Heightmap),
    /// The dark pixels of an image, drawn up.
    Image(ImageShape),
}

/// A surface whose heights are an image's.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Heightmap {
    /// What the world calls the image.
    pub(crate) uri: String,
    /// How wide and long it is, and how high where the image is brightest.
    pub(crate) size: Vector3<f64>,
    /// Its middle.
    pub(crate) position: Vector3<f64>,
    /// Image on it, and what one repeat of that covers, metres.
    pub(crate) texture: Option<(String, f64)>,
}

/// The dark pixels of an image, drawn up.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ImageShape {
    /// What the world calls the image.
    pub(crate) uri: String,
    /// Side of a pixel, metres.
    pub(crate) scale: f64,
    /// No brighter pixel is dark, 0 to 1.
    pub(crate) threshold: f32,
    /// How high they are drawn up, metres.
    pub(crate) height: f64,
}

/// A mesh file as a shape uses it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MeshUse {
    /// What the world calls the file.
    pub(crate) uri: String,
    /// Stretch.
    pub(crate) scale: Vector3<f64>,
    /// The one part that is used, if not all.
    pub(crate) submesh: Option<String>,
    /// Whether that part's middle is moved to the origin.
    pub(crate) center: bool,
}

/// A `<material>`: how a shape looks.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Paint {
    /// Folders and files with OGRE scripts and images.
    pub(crate) uris: Vec<String>,
    /// Material of those scripts, or one of Gazebo's own.
    pub(crate) script: Option<String>,
    /// Image of a physically based material.
    pub(crate) image: Option<String>,
    /// sRGB colour: `<diffuse>`, else `<ambient>`.
    pub(crate) color: Option<[f32; 3]>,
}

/// A ribbon through points.
#[derive(Debug, Clone)]
pub(crate) struct Road {
    /// Its name.
    pub(crate) name: String,
    /// Metres.
    pub(crate) width: f64,
    /// Its middle line.
    pub(crate) points: Vec<[f64; 3]>,
    /// Its looks.
    pub(crate) paint: Option<Paint>,
}

impl Road {
    /// Moves it.
    pub(crate) fn shift(&mut self, by: &Vector3<f64>) {
        self.points
            .iter_mut()
            .for_each(|point| *point = (Vector3::from(*point) + by).into());
    }
}
