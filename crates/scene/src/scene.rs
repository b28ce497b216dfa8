//! Triangles in the `map` frame.

use std::borrow::Cow;
use std::ops::Range;

use nalgebra::{Point3, Vector3};
use openbench_core::{Address, MapPoint};

use crate::material::{Material, MaterialId, SemanticClass, Texture, TextureId};

/// A corner of a visible triangle: position in `map` and texture coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Position, metres.
    pub position: [f32; 3],
    /// Texture coordinates.
    pub uv: [f32; 2],
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
    /// Class of each triangle.
    pub classes: Vec<SemanticClass>,
}

/// A door, known by the plate beside or above it.
#[derive(Debug, Clone, PartialEq)]
pub struct Door {
    /// Building and unit.
    pub address: Address,
    /// Text on the plate.
    pub text: String,
    /// Middle of the plate, metres in `map`.
    pub plate: [f64; 3],
    /// Direction that the plate faces: radians, counter-clockwise from east.
    pub facing: f64,
}

impl Door {
    /// The point on the ground below the plate.
    pub fn point(&self) -> MapPoint {
        MapPoint::new(self.plate[0], self.plate[1])
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
    /// Light.
    pub sun: Sun,
    /// South-western and north-eastern corner of the ground that the world covers, where that is
    /// known. There is ground beyond it, but no path is searched there.
    pub extent: Option<[MapPoint; 2]>,
}

impl Scene {
    /// Triangles that stand in the world.
    pub fn standing(&self) -> &[Triangle] {
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
/// use openbench_scene::scene::Layer;
/// use openbench_scene::{Material, SceneBuilder, SemanticClass};
///
/// let mut builder = SceneBuilder::new();
/// let grass = builder.material(Material::plain(SemanticClass::Ground, [0.3, 0.5, 0.3]));
/// let brick = builder.material(Material::plain(SemanticClass::Building, [0.7, 0.4, 0.3]));
///
/// let corner = Point3::new(-10.0, -10.0, 0.0);
/// let sides = (Vector3::x() * 20.0, Vector3::y() * 20.0);
/// builder.rectangle(Layer::Both, grass, corner, sides, [1.0; 2]);
///
/// builder.object("house", SemanticClass::Building);
/// let sides = (Vector3::x() * 6.0, Vector3::z() * 3.0);
/// builder.rectangle(Layer::Both, brick, Point3::new(-3.0, 4.0, 0.0), sides, [3.0, 1.5]);
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
    pub fn object(&mut self, name: impl Into<Cow<'static, str>>, class: SemanticClass) {
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

    /// Adds a mesh: corners with texture coordinates, and triangles as indices into them. Triangles
    /// with a missing corner or a non-finite number are left out; returns how many.
    pub fn mesh(
        &mut self,
        layer: Layer,
        material: MaterialId,
        corners: &[(Point3<f64>, [f32; 2])],
        triangles: &[[u32; 3]],
    ) -> usize {
        let usable = |t: &&[u32; 3]| {
            t.iter().all(|&i| {
                corners.get(i as usize).is_some_and(|(p, uv)| {
                    p.iter().all(|c| c.is_finite() && c.abs() < 1e6)
                        && uv.iter().all(|c| c.is_finite())
                })
            })
        };
        let kept: Vec<[u32; 3]> = triangles.iter().filter(usable).copied().collect();
        let position = |p: &Point3<f64>| [p.x as f32, p.y as f32, p.z as f32];
        if layer != Layer::Solid {
            let base = self.scene.vertices.len() as u32;
            self.scene
                .vertices
                .extend(corners.iter().map(|(p, uv)| Vertex {
                    position: position(p),
                    uv: *uv,
                }));
            self.scene.triangles.extend(kept.iter().map(|t| Triangle {
                corners: t.map(|i| base + i),
                material,
            }));
            self.scene
                .object_numbers
                .resize(self.scene.triangles.len(), self.scene.objects.len() as u32);
        }
        if layer != Layer::Visible {
            let base = self.scene.solid.positions.len() as u32;
            self.scene
                .solid
                .positions
                .extend(corners.iter().map(|(p, _)| position(p)));
            self.scene
                .solid
                .triangles
                .extend(kept.iter().map(|t| t.map(|i| base + i)));
            let class = self
                .scene
                .materials
                .get(material.0 as usize)
                .map_or(SemanticClass::Other, |m| m.class);
            self.scene.solid.classes.extend(kept.iter().map(|_| class));
        }
        triangles.len() - kept.len()
    }

    /// Adds a rectangle with corners `origin`, `origin + u`, `origin + u + v`, `origin + v`,
    /// visible from the side that `u x v` points to. The texture covers it `repeat` times along u
    /// and v.
    pub fn rectangle(
        &mut self,
        layer: Layer,
        material: MaterialId,
        origin: Point3<f64>,
        (u, v): (Vector3<f64>, Vector3<f64>),
        repeat: [f32; 2],
    ) {
        let corners = [
            (origin, [0.0, 0.0]),
            (origin + u, [repeat[0], 0.0]),
            (origin + u + v, repeat),
            (origin + v, [0.0, repeat[1]]),
        ];
        self.mesh(layer, material, &corners, &[[0, 1, 2], [0, 2, 3]]);
    }

    /// Adds a door. Its plate is added separately.
    pub fn door(&mut self, door: Door) {
        self.scene.doors.push(door);
    }

    /// Sets the light.
    pub fn sun(&mut self, sun: Sun) {
        self.scene.sun = sun;
    }

    /// Sets the ground that the world covers.
    pub fn extent(&mut self, low: MapPoint, high: MapPoint) {
        self.scene.extent = Some([low, high]);
    }

    /// The scene.
    pub fn build(self) -> Scene {
        self.scene
    }
}
