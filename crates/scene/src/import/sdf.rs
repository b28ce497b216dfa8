//! An SDF world after includes and frames are resolved.

use nalgebra::Vector3;
use openbench_core::Pose3;

use crate::Sun;

/// Largest depth of nested models and includes.
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
    /// Pose in the frame of the enclosing model, or of the world.
    pub(crate) pose: Pose3,
    /// Scale of its shapes, from the state of the world.
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
    /// Pose in the frame of the model.
    pub(crate) pose: Pose3,
    /// Visible shapes and collision shapes.
    pub(crate) shapes: Vec<Shape>,
}

/// A `<visual>` or `<collision>`.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    /// Whether it is visible; otherwise it is a collision shape.
    pub(crate) visual: bool,
    /// Pose in the frame of the link.
    pub(crate) pose: Pose3,
    /// Its form.
    pub(crate) geometry: Geometry,
    /// Its look, unless that of the mesh applies.
    pub(crate) paint: Option<Paint>,
}

/// The form of a shape, in its own frame, metres.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Geometry {
    /// Edge lengths.
    Box(Vector3<f64>),
    /// A rectangle that faces `normal`.
    Plane {
        /// Direction that it faces.
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
    /// Outlines extruded from z = 0: the first is the outer one, the others are holes in it.
    Extrusion {
        /// x and y of the corners, open: the last is joined to the first.
        outlines: Vec<Vec<[f64; 2]>>,
        /// Height.
        height: f64,
    },
    /// A mesh file.
    Mesh(MeshUse),
    /// A surface with heights from an image.
    Heightmap(Heightmap),
    /// The dark pixels of an image, extruded.
    Image(ImageShape),
}

/// A surface with heights from an image.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Heightmap {
    /// Path of the image as in the world file.
    pub(crate) uri: String,
    /// Width and length, and height where the image is brightest.
    pub(crate) size: Vector3<f64>,
    /// Its middle.
    pub(crate) position: Vector3<f64>,
    /// Image on it.
    pub(crate) texture: Option<TiledImage>,
}

/// An image that repeats over a surface.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TiledImage {
    /// Path of the image as in the world file.
    pub(crate) uri: String,
    /// Size of one repeat, metres.
    pub(crate) tile: f64,
}

/// The dark pixels of an image, extruded.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ImageShape {
    /// Path of the image as in the world file.
    pub(crate) uri: String,
    /// Side of a pixel, metres.
    pub(crate) scale: f64,
    /// Largest brightness of a dark pixel, 0 to 1.
    pub(crate) threshold: f32,
    /// Height, metres.
    pub(crate) height: f64,
}

/// A mesh file as a shape uses it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MeshUse {
    /// Path of the file as in the world file.
    pub(crate) uri: String,
    /// Scale.
    pub(crate) scale: Vector3<f64>,
    /// The only part that is used, if not all.
    pub(crate) submesh: Option<String>,
    /// Whether the middle of that part is moved to the origin.
    pub(crate) center: bool,
}

/// A `<material>`: the look of a shape.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Paint {
    /// Folders and files with OGRE scripts and images.
    pub(crate) uris: Vec<String>,
    /// Material of those scripts, or of Gazebo itself.
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
    /// Its look.
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
