//! Triangles of a scene from the models and roads of an SDF world.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use nalgebra::{Point3, Vector3};
use openbench_core::Pose3;

use super::classes::class_of;
use super::error::ImportError;
use super::forms;
use super::images::read_grey;
use super::looks::{Look, Looks};
use super::mesh::{self, Mesh, Part};
use super::patterns::Pattern;
use super::plates::plate_of;
use super::relief;
use super::road::{ribbon, shift_to_ground};
use super::sdf::{Geometry, Heightmap, ImageShape, MeshUse, Model, Paint, Road, Shape, TiledImage};
use super::search::{SearchPath, model_of};
use super::warnings::Warnings;
use crate::scene::{Corner, Layer};
use crate::{SceneBuilder, SemanticClass};

/// Triangles of a world at most; one takes about 150 bytes with all that is derived from it.
const MAX_TRIANGLES: usize = 20_000_000;
/// Level planes at least this long are ground that roads lie on, metres.
const GROUND_EDGE_M: f64 = 10.0;

/// Collision planes whose middle is farther away than this are moved along themselves, metres.
const WITHIN_PLANE_M: f64 = 1000.0;

/// Adds models and roads to a scene.
pub(crate) struct Emitter<'a> {
    search: &'a SearchPath,
    world: &'a Path,
    builder: &'a mut SceneBuilder,
    warnings: &'a mut Warnings,
    looks: Looks<'a>,
    meshes: BTreeMap<PathBuf, Rc<Mesh>>,
    triangles: usize,
    ground: Option<f64>,
}

/// Place of a shape, and the class that it belongs to.
struct Setting<'m> {
    model: &'m str,
    pose: Pose3,
    scale: Vector3<f64>,
    layer: Layer,
    class: SemanticClass,
}

impl<'a> Emitter<'a> {
    /// An emitter that has added nothing to `builder` yet.
    pub(crate) fn new(
        search: &'a SearchPath,
        world: &'a Path,
        builder: &'a mut SceneBuilder,
        warnings: &'a mut Warnings,
    ) -> Self {
        Self {
            search,
            world,
            builder,
            warnings,
            looks: Looks::new(search, world.parent().unwrap_or(Path::new("."))),
            meshes: BTreeMap::new(),
            triangles: 0,
            ground: None,
        }
    }

    /// Adds a model and the models in it, without plates.
    pub(crate) fn model(
        &mut self,
        model: &Model,
        parent: &Pose3,
        scale: &Vector3<f64>,
    ) -> Result<(), ImportError> {
        let pose = parent * model.pose;
        let scale = scale.component_mul(&model.scale);
        // Plates are drawn with their doors, by `add_doors`.
        if plate_of(model, &pose).is_some() {
            return Ok(());
        }
        if model.links.iter().any(|link| !link.shapes.is_empty()) {
            self.builder
                .begin_object(model.name.clone(), class_of_model(model));
        }
        for link in &model.links {
            for shape in &link.shapes {
                let setting = Setting {
                    model: &model.name,
                    pose: pose * link.pose * shape.pose,
                    scale,
                    layer: if shape.visual {
                        Layer::Visible
                    } else {
                        Layer::Solid
                    },
                    class: class_of_shape(model, shape),
                };
                self.shape(shape, &setting)?;
            }
        }
        model
            .models
            .iter()
            .try_for_each(|inner| self.model(inner, &pose, &scale))
    }

    /// Adds the roads, on the ground if there is a ground plane near them. Call it after the
    /// models.
    pub(crate) fn roads(&mut self, roads: &[Road]) -> Result<(), ImportError> {
        // `note_ground` has seen all planes by now, hence roads come last.
        let shift = shift_to_ground(roads, self.ground);
        for road in roads {
            self.builder
                .begin_object(road.name.clone(), SemanticClass::Road);
            let own = match &road.paint {
                Some(paint) => self.looks.of_paint(self.builder, paint, self.warnings)?,
                None => None,
            };
            let look = own.unwrap_or_else(|| self.looks.drawn(self.builder, Pattern::MarkedRoad));
            // Along the road an image repeats at its own length; one of unknown size is taken for
            // square.
            let repeat = look.pattern.map_or(road.width, |p| p.metres()[1]);
            let setting = Setting {
                model: &road.name,
                pose: Pose3::identity(),
                scale: Vector3::repeat(1.0),
                layer: Layer::Visible,
                class: SemanticClass::Road,
            };
            self.part(&ribbon(road, shift, repeat), &look, &setting)?;
        }
        Ok(())
    }

    fn shape(&mut self, shape: &Shape, setting: &Setting) -> Result<(), ImportError> {
        let painted = match &shape.paint {
            Some(paint) => self.looks.of_paint(self.builder, paint, self.warnings)?,
            None => None,
        };
        // Meshes have materials of their own, part by part.
        if let Geometry::Mesh(mesh) = &shape.geometry {
            return self.mesh(mesh, shape, painted, setting);
        }
        let color = shape
            .paint
            .as_ref()
            .and_then(|p| p.color)
            .unwrap_or([0.7; 3]);
        let look = painted.unwrap_or_else(|| Look::plain(color));
        let metres = look.pattern.map(Pattern::metres);
        let part = match &shape.geometry {
            Geometry::Box(size) => forms::cuboid(*size, metres),
            Geometry::Plane { normal, size } => {
                // A vector is turned by a pose and not moved.
                self.note_ground(setting.pose * normal, setting.pose.translation.z, *size);
                let part = forms::plane(*normal, *size, shape.visual, metres);
                let pose = if shape.visual {
                    setting.pose
                } else {
                    along_plane(setting.pose, normal)
                };
                return self.part(&part, &look, &Setting { pose, ..*setting });
            }
            Geometry::Cylinder { radius, length } => forms::cylinder(*radius, *length),
            Geometry::Sphere(radius) => forms::sphere(*radius),
            Geometry::Extrusion { outlines, height } => forms::extrusion(outlines, *height, metres),
            Geometry::Heightmap(heightmap) => {
                return self.heightmap(heightmap, shape, look, setting);
            }
            Geometry::Image(image) => self.drawn_up(image, setting)?,
            // Returned above.
            Geometry::Mesh(_) => Part::default(),
        };
        self.part(&part, &look, setting)
    }

    fn heightmap(
        &mut self,
        heightmap: &Heightmap,
        shape: &Shape,
        look: Look,
        setting: &Setting,
    ) -> Result<(), ImportError> {
        let image = read_grey(&self.file(&heightmap.uri, setting.model)?)?;
        // Gazebo draws heightmaps with their own textures only.
        let textured = heightmap
            .texture
            .clone()
            .filter(|_| shape.visual && shape.paint.is_none());
        let paint = |image| Paint {
            image: Some(image),
            ..Paint::default()
        };
        let (own, tile) = match textured {
            Some(TiledImage { uri, tile }) => (
                self.looks
                    .of_paint(self.builder, &paint(uri), self.warnings)?,
                tile,
            ),
            None => (None, 1.0),
        };
        let part = relief::surface(&image, heightmap, tile);
        self.part(&part, &own.unwrap_or(look), setting)
    }

    fn drawn_up(&mut self, image: &ImageShape, setting: &Setting) -> Result<Part, ImportError> {
        let path = self.file(&image.uri, setting.model)?;
        let part = relief::boxes(&read_grey(&path)?, image);
        part.ok_or_else(|| ImportError::too_large(&path, "boxes of dark pixels", relief::MAX_BOXES))
    }

    fn note_ground(&mut self, normal: Vector3<f64>, height: f64, size: [f64; 2]) {
        if normal.z > 0.999 && size.iter().all(|s| *s >= GROUND_EDGE_M) {
            self.ground.get_or_insert(height);
        }
    }

    fn mesh(
        &mut self,
        wanted: &MeshUse,
        shape: &Shape,
        painted: Option<Look>,
        setting: &Setting,
    ) -> Result<(), ImportError> {
        let path = self.file(&wanted.uri, setting.model)?;
        let mesh = self.load(&path)?;
        let used = |p: &&Part| {
            wanted
                .submesh
                .as_ref()
                .is_none_or(|name| p.names.contains(name))
        };
        let parts: Vec<&Part> = mesh.parts.iter().filter(used).collect();
        if parts.is_empty() {
            let name = wanted.submesh.as_deref().unwrap_or_default();
            self.warnings
                .add(format!("{} has no part `{name}`", wanted.uri));
        }
        let middle = if wanted.center {
            middle_of(&parts)
        } else {
            Vector3::zeros()
        };
        let setting = Setting {
            pose: setting.pose * nalgebra::Translation3::from(-middle.component_mul(&wanted.scale)),
            scale: setting.scale.component_mul(&wanted.scale),
            ..*setting
        };
        for part in parts {
            let material = part.material.and_then(|m| mesh.materials.get(m));
            let look = match &painted {
                // Collision shapes are not seen, so their images are not read.
                _ if setting.layer == Layer::Solid => Look::default(),
                Some(look) => look.clone(),
                None => {
                    let paint = shape.paint.as_ref();
                    self.looks
                        .of_mesh(self.builder, &path, material, paint, self.warnings)?
                }
            };
            self.part(part, &look, &setting)?;
        }
        Ok(())
    }

    /// The file that a model refers to.
    fn file(&self, uri: &str, model: &str) -> Result<PathBuf, ImportError> {
        let beside = self.world.parent().unwrap_or(Path::new("."));
        let path = self.search.find(uri, beside).filter(|p| p.is_file());
        path.ok_or_else(|| ImportError::Missing {
            model: model.to_owned(),
            uri: uri.to_owned(),
            searched: self.search.folders(),
        })
    }

    /// The mesh in a file, which is read once.
    fn load(&mut self, path: &Path) -> Result<Rc<Mesh>, ImportError> {
        if let Some(mesh) = self.meshes.get(path) {
            return Ok(mesh.clone());
        }
        let mesh = Rc::new(mesh::read(path)?);
        self.meshes.insert(path.to_owned(), mesh.clone());
        Ok(mesh)
    }

    fn part(&mut self, part: &Part, look: &Look, setting: &Setting) -> Result<(), ImportError> {
        // Counted before they are placed, so that no more memory is taken than the limit allows.
        self.triangles += part.triangles.len();
        if self.triangles > MAX_TRIANGLES {
            return Err(ImportError::too_large(
                self.world,
                "triangles",
                MAX_TRIANGLES,
            ));
        }
        let material = self.looks.material(self.builder, look, setting.class);
        let [su, sv] = look.stretch;
        let place = |corner: &Corner| {
            let ([u, v], p) = (corner.uv, corner.position.coords);
            Corner::new(
                setting.pose * Point3::from(p.component_mul(&setting.scale)),
                [u / su, v / sv],
            )
        };
        let corners: Vec<Corner> = part.corners.iter().map(place).collect();
        // A scale that mirrors turns triangles inside out.
        let mirrored = setting.scale.product() < 0.0;
        let turned = |&[a, b, c]: &[u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        let triangles: Vec<[u32; 3]> = part.triangles.iter().map(turned).collect();
        for _ in 0..self
            .builder
            .mesh(setting.layer, material, &corners, &triangles)
        {
            self.warnings
                .add("triangle with a corner that is no number or too far away");
        }
        Ok(())
    }
}

/// A pose at which an infinite plane reaches around the origin of the world: it is the same plane
/// wherever its middle is.
fn along_plane(pose: Pose3, normal: &Vector3<f64>) -> Pose3 {
    // The part of the translation along the plane does not move it.
    let (at, across) = (pose.translation.vector, pose.rotation * normal);
    let along = at - across * across.dot(&at);
    if along.norm() < WITHIN_PLANE_M {
        return pose;
    }
    Pose3::from_parts((at - along).into(), pose.rotation)
}

/// Class of most of a model: that of its first shape.
fn class_of_model(model: &Model) -> SemanticClass {
    let first = model.links.iter().flat_map(|l| &l.shapes).next();
    first.map_or_else(
        || class_of(&model.name),
        |shape| class_of_shape(model, shape),
    )
}

fn class_of_shape(model: &Model, shape: &Shape) -> SemanticClass {
    let by_mesh = match &shape.geometry {
        Geometry::Mesh(mesh) => model_of(&mesh.uri).map(class_of),
        _ => None,
    };
    by_mesh
        .filter(|c| *c != SemanticClass::Other)
        .unwrap_or_else(|| class_of(&model.name))
}

/// Middle of the box around the parts.
fn middle_of(parts: &[&Part]) -> Vector3<f64> {
    let mut points = parts
        .iter()
        .flat_map(|p| &p.corners)
        .map(|c| c.position.coords);
    let Some(first) = points.next() else {
        return Vector3::zeros();
    };
    let (low, high) = points.fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)));
    (low + high) / 2.0
}
