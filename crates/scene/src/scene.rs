//! Triangles in the `map` frame.

use std::borrow::Cow;
use std::ops::Range;

use nalgebra::{Point3, Vector3};
use openbench_core::{Address, MapPoint, Pose2};
use openbench_geometry::Bounds;

use crate::material::{Material, MaterialId, SemanticClass, Texture, TextureId};
use crate::plates::Extent;

/// Corners farther away than this are broken data, metres. Positions are in single precision,
/// which has steps of 6 cm there.
const FARTHEST_M: f64 = 1e6;

/// A corner of a visible triangle: position in `map` and texture coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Position, metres.
    pub position: [f32; 3],
    /// Texture coordinates.
    pub uv: [f32; 2],
}

/// A corner of a mesh that is added to a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Position in `map`, or in the frame of a figure, metres.
    pub position: Point3<f64>,
    /// Texture coordinates.
    pub uv: [f32; 2],
}

impl Corner {
    /// The corner at `position` with these texture coordinates.
    pub const fn new(position: Point3<f64>, uv: [f32; 2]) -> Self {
        Self { position, uv }
    }

    /// Whether it can be drawn: its numbers are finite, and it is no more than 1,000 km away.
    fn is_usable(&self) -> bool {
        let near = |c: &f64| c.is_finite() && c.abs() < FARTHEST_M;
        self.position.iter().all(near) && self.uv.iter().all(|c| c.is_finite())
    }

    fn single_position(&self) -> [f32; 3] {
        let p = &self.position;
        [p.x as f32, p.y as f32, p.z as f32]
    }
}

/// A visible triangle, counter-clockwise seen from outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle {
    /// Indices into [`Scene::vertices`].
    pub corners: [u32; 3],
    /// Its material.
    pub material: MaterialId,
}

/// What robots collide with: an indexed triangle mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SolidMesh {
    /// Positions, metres.
    pub positions: Vec<[f32; 3]>,
    /// Indices into `positions`.
    pub triangles: Vec<[u32; 3]>,
    /// [Coarse](SemanticClass::coarse) class of each triangle.
    pub classes: Vec<SemanticClass>,
}

/// A door with its plate.
#[derive(Debug, Clone, PartialEq)]
pub struct Door {
    /// Building and unit.
    pub address: Address,
    /// Text on the plate; empty if there is no plate.
    pub text: String,
    /// Middle of the text, metres in `map`; where a plate would be if there is none.
    pub plate: [f64; 3],
    /// Direction that the plate faces: radians, counter-clockwise from east.
    pub facing: f64,
    /// Size of the text, and of its capitals.
    pub lettering: Extent,
    /// Middle of the door in its wall, and the direction out of the wall; `None` in imported
    /// worlds, which have plates only.
    pub doorway: Option<Pose2>,
}

impl Door {
    /// The point on the ground below the plate.
    pub fn point(&self) -> MapPoint {
        MapPoint::new(self.plate[0], self.plate[1])
    }

    /// Where one goes in, and the direction out: the doorway, or the plate if only that is known.
    pub fn entrance(&self) -> Pose2 {
        let plate = Pose2::new(self.plate[0], self.plate[1], self.facing);
        self.doorway.unwrap_or(plate)
    }
}

/// An instance of a thing: a house, a tree, a car. Instance images distinguish them.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    /// Name of the thing in the map, or its kind. Several objects may have one name.
    pub name: Cow<'static, str>,
    /// Class of most of it; its triangles have classes of their own.
    pub class: SemanticClass,
}

/// Directional light and the light of the sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Direction that the light travels in; unit length.
    pub direction: [f32; 3],
    /// Strength of the sun, 0 to 1 or so.
    pub diffuse: f32,
    /// Strength of the sky's light, 0 to 1 or so.
    pub ambient: f32,
}

impl Default for Sun {
    fn default() -> Self {
        Self {
            direction: [-0.60, 0.12, -0.79],
            diffuse: 0.65,
            ambient: 0.45,
        }
    }
}

/// A world's surfaces.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// Corners of the visible triangles.
    pub vertices: Vec<Vertex>,
    /// Visible triangles: what camera and LiDAR see. Those of figures come last.
    pub triangles: Vec<Triangle>,
    /// For each figure its triangles. They have no place of their own, but are placed anew for each
    /// instant.
    pub figures: Vec<Range<u32>>,
    /// Materials of the visible triangles.
    pub materials: Vec<Material>,
    /// Objects that the visible triangles belong to.
    pub objects: Vec<Object>,
    /// For each visible triangle the number of its object, see [`Scene::object`].
    pub object_numbers: Vec<u32>,
    /// Images of the materials.
    pub textures: Vec<Texture>,
    /// Solid surfaces: what the robot touches, the ground included.
    pub solid: SolidMesh,
    /// Doors in a fixed order.
    pub doors: Vec<Door>,
    /// Outlines of places without ground: light wells.
    pub pits: Vec<Vec<MapPoint>>,
    /// Light.
    pub sun: Sun,
    /// The ground that the world covers, where that is known. There is ground beyond it, but no
    /// path is searched there.
    pub extent: Option<Bounds>,
}

impl Scene {
    /// Triangles that stand in the world.
    pub fn standing(&self) -> &[Triangle] {
        // Triangles of figures come after all that stand.
        let first = self
            .figures
            .first()
            .map_or(self.triangles.len(), |range| range.start as usize);
        &self.triangles[..first.min(self.triangles.len())]
    }

    /// Adds the visible triangles of a scene about its own origin as a figure, and returns its
    /// number.
    pub fn add_figure(&mut self, figure: &Scene) -> usize {
        let (vertices, materials, textures) = (
            self.vertices.len() as u32,
            self.materials.len() as u32,
            self.textures.len() as u32,
        );
        // What the figure brings is appended, and its indices are shifted by what is there already.
        let first = self.triangles.len() as u32;
        self.vertices.extend(&figure.vertices);
        self.textures.extend(figure.textures.iter().cloned());
        self.materials
            .extend(figure.materials.iter().map(|material| {
                Material {
                    texture: material
                        .texture
                        .map(|texture| TextureId(textures + texture.0)),
                    ..material.clone()
                }
            }));
        self.triangles
            .extend(figure.standing().iter().map(|triangle| Triangle {
                corners: triangle.corners.map(|corner| vertices + corner),
                material: MaterialId(materials + triangle.material.0),
            }));
        self.figures.push(first..self.triangles.len() as u32);
        self.figures.len() - 1
    }

    /// Number of the object that a visible triangle belongs to, from 1; 0 for none, and for
    /// figures.
    pub fn object_number(&self, triangle: u32) -> u32 {
        self.object_numbers
            .get(triangle as usize)
            .copied()
            .unwrap_or(0)
    }

    /// The object of that number.
    pub fn object(&self, number: u32) -> Option<&Object> {
        self.objects.get((number as usize).checked_sub(1)?)
    }
}

/// The mesh of a scene that a shape belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// Visible, but without collisions: plates, road markings.
    Visible,
    /// Invisible: collision shapes.
    Solid,
    /// Both.
    Both,
}

/// Builds a scene.
///
/// # Example
///
/// Ground of 20 m by 20 m with a house wall, 6 m long and 3 m high:
///
/// ```
/// use nalgebra::{Point3, Vector3};
/// use openbench_scene::Layer;
/// use openbench_scene::{Material, SceneBuilder, SemanticClass};
///
/// let mut builder = SceneBuilder::new();
/// let grass = builder.material(Material::plain(SemanticClass::Ground, [0.3, 0.5, 0.3]));
/// let brick = builder.material(Material::plain(SemanticClass::Building, [0.7, 0.4, 0.3]));
///
/// let corner = Point3::new(-10.0, -10.0, 0.0);
/// let (east, north) = (Vector3::x() * 20.0, Vector3::y() * 20.0);
/// builder.rectangle(Layer::Both, grass, corner, east, north, [1.0; 2]);
///
/// builder.begin_object("house", SemanticClass::Building);
/// let (corner, along, up) = (Point3::new(-3.0, 4.0, 0.0), Vector3::x() * 6.0, Vector3::z() * 3.0);
/// builder.rectangle(Layer::Both, brick, corner, along, up, [3.0, 1.5]);
///
/// let scene = builder.build();
/// assert_eq!(scene.triangles.len(), 4);
/// assert_eq!(scene.solid.triangles.len(), 4);
/// let number = scene.object_number(3);
/// assert_eq!(scene.object(number).map(|object| &*object.name), Some("house"));
/// ```
#[derive(Debug, Default)]
pub struct SceneBuilder {
    scene: Scene,
}

impl SceneBuilder {
    /// An empty scene.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of visible triangles so far.
    pub fn triangles(&self) -> usize {
        self.scene.triangles.len()
    }

    /// Begins an object: everything that is added until the next one begins belongs to it.
    pub fn begin_object(&mut self, name: impl Into<Cow<'static, str>>, class: SemanticClass) {
        self.scene.objects.push(Object {
            name: name.into(),
            class,
        });
    }

    /// Adds an image.
    pub fn texture(&mut self, texture: Texture) -> TextureId {
        self.scene.textures.push(texture);
        TextureId(self.scene.textures.len() as u32 - 1)
    }

    /// Adds a material.
    pub fn material(&mut self, material: Material) -> MaterialId {
        self.scene.materials.push(material);
        MaterialId(self.scene.materials.len() as u32 - 1)
    }

    /// A material with the image of another, in another colour.
    pub(crate) fn tinted(
        &mut self,
        material: MaterialId,
        color: [f32; 3],
        reflectivity: u8,
    ) -> MaterialId {
        let like = self.scene.materials[material.0 as usize].clone();
        self.material(Material {
            color,
            reflectivity,
            ..like
        })
    }

    /// Brightness of a material with its image, 0 to 1; that of some of its texels.
    pub(crate) fn brightness(&self, material: MaterialId) -> f32 {
        const SAMPLES: usize = 64;
        let luma = |[r, g, b]: [f32; 3]| 0.3 * r + 0.59 * g + 0.11 * b;
        let material = &self.scene.materials[material.0 as usize];
        let own = luma(material.color);
        let Some(texture) = material.texture else {
            return own;
        };
        let rgba = &self.scene.textures[texture.0 as usize].rgba;
        let step = (rgba.len() / 4 / SAMPLES).max(1);
        let texels = rgba.chunks_exact(4).step_by(step);
        let count = texels.len() as f32;
        let sum: f32 = texels
            .map(|texel| luma([0, 1, 2].map(|c| f32::from(texel[c]) / 255.0)))
            .sum();
        own * sum / count
    }

    /// Adds a mesh: corners, and triangles as indices into them. Triangles with a corner that is
    /// missing, not finite or more than 1,000 km away are left out; returns how many.
    pub fn mesh(
        &mut self,
        layer: Layer,
        material: MaterialId,
        corners: &[Corner],
        triangles: &[[u32; 3]],
    ) -> usize {
        // All corners are kept, so that indices hold; those of no triangle are never looked at.
        let is_usable = |i: &u32| corners.get(*i as usize).is_some_and(Corner::is_usable);
        let kept: Vec<[u32; 3]> = triangles
            .iter()
            .filter(|triangle| triangle.iter().all(is_usable))
            .copied()
            .collect();
        if layer != Layer::Solid {
            self.add_visible(material, corners, &kept);
        }
        if layer != Layer::Visible {
            self.add_solid(material, corners, &kept);
        }
        triangles.len() - kept.len()
    }

    fn add_visible(&mut self, material: MaterialId, corners: &[Corner], triangles: &[[u32; 3]]) {
        let scene = &mut self.scene;
        let base = scene.vertices.len() as u32;
        scene.vertices.extend(corners.iter().map(|corner| Vertex {
            position: corner.single_position(),
            uv: corner.uv,
        }));
        scene.triangles.extend(triangles.iter().map(|t| Triangle {
            corners: t.map(|i| base + i),
            material,
        }));
        let object = scene.objects.len() as u32;
        // The object that was begun last, counted from 1; 0 before the first.
        scene.object_numbers.resize(scene.triangles.len(), object);
    }

    fn add_solid(&mut self, material: MaterialId, corners: &[Corner], triangles: &[[u32; 3]]) {
        let class = self
            .scene
            .materials
            .get(material.0 as usize)
            .map_or(SemanticClass::Other, |m| m.class.coarse());
        let solid = &mut self.scene.solid;
        let base = solid.positions.len() as u32;
        solid
            .positions
            .extend(corners.iter().map(Corner::single_position));
        solid
            .triangles
            .extend(triangles.iter().map(|t| t.map(|i| base + i)));
        solid.classes.extend(triangles.iter().map(|_| class));
    }

    /// Adds a rectangle with corners `origin`, `origin + u`, `origin + u + v`, `origin + v`,
    /// visible from the side that `u x v` points to. The texture covers it `repeat` times along u
    /// and v.
    pub fn rectangle(
        &mut self,
        layer: Layer,
        material: MaterialId,
        origin: Point3<f64>,
        u: Vector3<f64>,
        v: Vector3<f64>,
        repeat: [f32; 2],
    ) {
        let corners = [
            Corner::new(origin, [0.0, 0.0]),
            Corner::new(origin + u, [repeat[0], 0.0]),
            Corner::new(origin + u + v, repeat),
            Corner::new(origin + v, [0.0, repeat[1]]),
        ];
        self.mesh(layer, material, &corners, &[[0, 1, 2], [0, 2, 3]]);
    }

    /// Adds a door. Its plate is added separately.
    pub fn door(&mut self, door: Door) {
        self.scene.doors.push(door);
    }

    /// Adds the outline of a place without ground. Its walls and floor are added separately.
    pub fn pit(&mut self, outline: &[MapPoint]) {
        self.scene.pits.push(outline.to_vec());
    }

    /// Sets the light.
    pub fn set_sun(&mut self, sun: Sun) {
        self.scene.sun = sun;
    }

    /// Sets the ground that the world covers.
    pub fn set_extent(&mut self, extent: Bounds) {
        self.scene.extent = Some(extent);
    }

    /// The scene.
    pub fn build(self) -> Scene {
        self.scene
    }
}
