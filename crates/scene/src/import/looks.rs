//! Materials of the scene from those of a shape and its mesh: scripts, images, materials of Gazebo
//! itself, each made once.
//!
//! As in Gazebo, a script of the shape takes precedence over the materials of the mesh, and a
//! colour of the shape over that of the script.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::builtin::{Builtin, builtin};
use super::error::ImportError;
use super::images::Images;
use super::mesh::MeshMaterial;
use super::ogre::{OgreMaterial, parse_script};
use super::patterns::Pattern;
use super::sdf::Paint;
use super::search::SearchPath;
use super::warnings::Warnings;
use super::xml::read_text;
use crate::{Material, MaterialId, SceneBuilder, SemanticClass, TextureId};

/// The look of a surface, before its class is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Look {
    color: [f32; 3],
    texture: Option<TextureId>,
    cutout: bool,
    /// Divisors of the texture coordinates.
    pub(crate) stretch: [f32; 2],
    /// The pattern, if it has one: its texture coordinates are in metres.
    pub(crate) pattern: Option<Pattern>,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            color: [1.0; 3],
            texture: None,
            cutout: false,
            stretch: [1.0; 2],
            pattern: None,
        }
    }
}

impl Look {
    /// A plain colour.
    pub(crate) fn plain(color: [f32; 3]) -> Self {
        Self {
            color,
            ..Self::default()
        }
    }
}

type Script = Rc<BTreeMap<String, OgreMaterial>>;

/// What distinguishes materials.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct MaterialKey {
    class: SemanticClass,
    /// The bits of the colour: floating-point numbers have no total order.
    color: [u32; 3],
    texture: Option<TextureId>,
    cutout: bool,
}

/// Makes looks, and keeps those that it made.
pub(crate) struct Looks<'a> {
    search: &'a SearchPath,
    /// Folder of the world: plain file names are relative to it.
    beside: PathBuf,
    images: Images,
    scripts: BTreeMap<PathBuf, Script>,
    patterns: BTreeMap<Pattern, TextureId>,
    materials: BTreeMap<MaterialKey, MaterialId>,
}

impl<'a> Looks<'a> {
    /// No looks yet.
    pub(crate) fn new(search: &'a SearchPath, beside: &Path) -> Self {
        Self {
            search,
            beside: beside.to_owned(),
            images: Images::default(),
            scripts: BTreeMap::new(),
            patterns: BTreeMap::new(),
            materials: BTreeMap::new(),
        }
    }

    /// The material of a look for a class.
    pub(crate) fn material(
        &mut self,
        builder: &mut SceneBuilder,
        look: &Look,
        class: SemanticClass,
    ) -> MaterialId {
        let key = MaterialKey {
            class,
            color: look.color.map(f32::to_bits),
            texture: look.texture,
            cutout: look.cutout,
        };
        *self.materials.entry(key).or_insert_with(|| {
            let plain = Material::plain(class, look.color);
            builder.material(Material {
                texture: look.texture,
                cutout: look.cutout,
                ..plain
            })
        })
    }

    /// The look of the shape itself; `None` if that of its mesh applies.
    pub(crate) fn of_paint(
        &mut self,
        builder: &mut SceneBuilder,
        paint: &Paint,
        warnings: &mut Warnings,
    ) -> Result<Option<Look>, ImportError> {
        let mut look = match &paint.script {
            Some(name) => self.of_script(builder, name, &paint.uris, warnings)?,
            None => None,
        };
        if let Some(file) = paint
            .image
            .as_ref()
            .and_then(|i| self.search.find(i, &self.beside))
        {
            look = Some(self.with_image(builder, &file, warnings)?);
        }
        // Without a script or an image, the mesh's own look applies; `of_mesh` gives it the colour.
        if let (Some(look), Some(color)) = (&mut look, paint.color) {
            look.color = color;
        }
        Ok(look)
    }

    /// The look of a part of a mesh file, in the colour of the shape if it has one.
    pub(crate) fn of_mesh(
        &mut self,
        builder: &mut SceneBuilder,
        mesh: &Path,
        material: Option<&MeshMaterial>,
        paint: Option<&Paint>,
        warnings: &mut Warnings,
    ) -> Result<Look, ImportError> {
        let plain = MeshMaterial::default();
        let material = material.unwrap_or(&plain);
        let mut look = Look {
            color: material.color,
            ..Look::default()
        };
        if let Some(name) = &material.image {
            match self.mesh_image(mesh, name) {
                Some(file) => look = self.with_image(builder, &file, warnings)?,
                None => warnings.add(format!("image `{name}` of {} is not there", mesh.display())),
            }
        }
        look.cutout = material.cutout;
        look.color = paint.and_then(|p| p.color).unwrap_or(look.color);
        Ok(look)
    }

    fn of_script(
        &mut self,
        builder: &mut SceneBuilder,
        name: &str,
        uris: &[String],
        warnings: &mut Warnings,
    ) -> Result<Option<Look>, ImportError> {
        let places: Vec<PathBuf> = uris
            .iter()
            .filter_map(|u| self.search.find(u, &self.beside))
            .collect();
        for file in script_files(&places) {
            let script = self.script(&file)?;
            if let Some(material) = script.get(name) {
                return self
                    .of_ogre(builder, material, name, &file, &places, warnings)
                    .map(Some);
            }
        }
        // Scripts first: a world may bring its own material under a name of Gazebo's.
        match builtin(name) {
            Some(Builtin::Color(color)) => {
                return Ok(Some(Look {
                    color,
                    ..Look::default()
                }));
            }
            Some(Builtin::Pattern(pattern)) => return Ok(Some(self.drawn(builder, pattern))),
            None => warnings.add(format!(
                "material `{name}` is in no script; the mesh's own is used"
            )),
        }
        Ok(None)
    }

    /// The look of a pattern.
    pub(crate) fn drawn(&mut self, builder: &mut SceneBuilder, pattern: Pattern) -> Look {
        let texture = *self
            .patterns
            .entry(pattern)
            .or_insert_with(|| builder.texture(pattern.draw()));
        Look {
            texture: Some(texture),
            pattern: Some(pattern),
            ..Look::default()
        }
    }

    fn of_ogre(
        &mut self,
        builder: &mut SceneBuilder,
        material: &OgreMaterial,
        name: &str,
        script: &Path,
        places: &[PathBuf],
        warnings: &mut Warnings,
    ) -> Result<Look, ImportError> {
        let mut look = Look::default();
        if let Some(image) = &material.image {
            match script_image(image, script, places) {
                Some(file) => look = self.with_image(builder, &file, warnings)?,
                None => warnings.add(format!("image `{image}` of material `{name}` is not there")),
            }
        }
        look.color = material.color.unwrap_or(look.color);
        // After the image, since that makes a new look.
        look.cutout = material.cutout;
        look.stretch = material.stretch;
        Ok(look)
    }

    fn script(&mut self, file: &Path) -> Result<Script, ImportError> {
        if let Some(script) = self.scripts.get(file) {
            return Ok(script.clone());
        }
        let script = Rc::new(parse_script(&read_text(file)?));
        self.scripts.insert(file.to_owned(), script.clone());
        Ok(script)
    }

    fn with_image(
        &mut self,
        builder: &mut SceneBuilder,
        file: &Path,
        warnings: &mut Warnings,
    ) -> Result<Look, ImportError> {
        let ending = file
            .extension()
            .and_then(|e| e.to_str())
            .map(str::to_ascii_lowercase);
        // A warning and no error: without its image the shape is still there, in white.
        if !matches!(ending.as_deref(), Some("png" | "jpg" | "jpeg")) {
            warnings.add(format!(
                "image format of {} is not supported",
                file.display()
            ));
            return Ok(Look::default());
        }
        Ok(Look {
            texture: Some(self.images.load(builder, file)?),
            ..Look::default()
        })
    }

    /// The image of a mesh file: at the path in the file, else by its file name beside the mesh or
    /// among the textures of its model.
    fn mesh_image(&self, mesh: &Path, name: &str) -> Option<PathBuf> {
        // Exporters write paths of Windows, and URIs.
        let name = name.replace('\\', "/").replace("%20", " ");
        let folder = mesh.parent()?;
        let file = Path::new(&name).file_name()?;
        let textures = folder.join("../materials/textures").join(file);
        let beside = || {
            [folder.join(file), textures]
                .into_iter()
                .find(|p| p.is_file())
        };
        self.search
            .find(&name, folder)
            .filter(|p| p.is_file())
            .or_else(beside)
    }
}

/// Scripts at those places; those of a folder in the order of their names.
fn script_files(places: &[PathBuf]) -> Vec<PathBuf> {
    let is_script = |p: &PathBuf| p.extension().is_some_and(|e| e == "material");
    let mut files = Vec::new();
    for place in places {
        if place.is_file() {
            files.push(place.clone());
        } else if let Ok(entries) = std::fs::read_dir(place) {
            let mut inside: Vec<PathBuf> = entries
                .flatten()
                .map(|e| e.path())
                .filter(is_script)
                .collect();
            // The order of a folder's entries depends on the file system.
            inside.sort();
            files.extend(inside);
        }
    }
    files
}

/// The image of a script: at the places that the shape lists, beside the script, or in the folder
/// `textures` beside those.
fn script_image(image: &str, script: &Path, places: &[PathBuf]) -> Option<PathBuf> {
    let folders = places.iter().map(PathBuf::as_path).chain(script.parent());
    let mut candidates = folders.flat_map(|f| [f.join(image), f.join("../textures").join(image)]);
    candidates.find(|p| p.is_file())
}
