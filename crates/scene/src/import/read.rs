//! SDF 1.4 to 1.7 into [`SdfWorld`]: models, includes, lights, roads and the saved state.
//!
//! Follows sdformat.org, and Gazebo Classic where that leaves something open. Physics, sensors,
//! joints and plugins are ignored silently, since they are no part of a scene. Shapes and lights
//! that are not supported are counted.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use openbench_core::Pose3;
use roxmltree::Node;

use super::error::ImportError;
use super::frames::{Frames, pose_of};
use super::plates::unit_of_name;
use super::sdf::{Link, MAX_DEPTH, Model, Road, SdfWorld, Shape};
use super::search::{SearchPath, model_of};
use super::shape::{read_geometry, read_paint};
use super::state::State;
use super::sun::read_sun;
use super::warnings::Warnings;
use super::xml::{child, child_text, children, is, malformed, numbers, parse, read_text};

const MAX_MODELS: usize = 200_000;

/// Reads worlds and the models that they include.
pub(crate) struct SdfReader<'a> {
    /// Folders that are searched for `model://`.
    pub(crate) search: &'a SearchPath,
    /// What was skipped.
    pub(crate) warnings: &'a mut Warnings,
    /// Number of models so far; includes can multiply them.
    pub(crate) models: usize,
}

/// A file, and the depth of the reader in models and includes.
#[derive(Clone, Copy)]
struct Place<'a> {
    path: &'a Path,
    depth: usize,
}

impl Place<'_> {
    fn deeper(self, node: Node) -> Result<Self, ImportError> {
        if self.depth >= MAX_DEPTH {
            return Err(malformed(
                self.path,
                node,
                format!("models are nested more than {MAX_DEPTH} deep"),
            ));
        }
        Ok(Self {
            depth: self.depth + 1,
            ..self
        })
    }
}

impl SdfReader<'_> {
    /// Reads a `.world` file.
    pub(crate) fn world(&mut self, path: &Path) -> Result<SdfWorld, ImportError> {
        let text = read_text(path)?;
        let doc = parse(path, &text)?;
        let root = doc.root_element();
        let Some(world) = child(root, "world") else {
            return Err(malformed(path, root, "there is no <world> in this file"));
        };
        let place = Place { path, depth: 0 };
        let mut result = SdfWorld {
            models: self.models_in(place, world)?,
            ..SdfWorld::default()
        };
        if let Some(state) = child(world, "state") {
            for inserted in children(state, "insertions") {
                result.models.extend(self.models_in(place, inserted)?);
            }
            // After the insertions, which the state moves too.
            State::read(path, state)?.apply(&mut result.models);
        }
        result.sun = read_sun(path, world, self.warnings)?;
        for road in children(world, "road") {
            result.roads.push(read_road(path, road)?);
        }
        // These would be seen, unlike the other elements that are left out.
        for tag in ["actor", "population"] {
            children(world, tag)
                .for_each(|_| self.warnings.add(format!("<{tag}> is not supported")));
        }
        Ok(result)
    }

    /// The models directly in `scope`, included ones too, in the order of the file.
    fn models_in(&mut self, place: Place, scope: Node) -> Result<Vec<Model>, ImportError> {
        let frames = Frames::read(place.path, scope)?;
        let mut models = Vec::new();
        // One pass over both kinds, so that models keep the order of the file.
        for node in scope.children() {
            if is(node, "model") {
                let mut model = self.model(place, node)?;
                if let Some(pose) = frames.explicit(place.path, node, self.warnings)? {
                    model.pose = pose;
                }
                models.push(model);
            } else if is(node, "include") {
                let Some(mut model) = self.include(place, node)? else {
                    continue;
                };
                if let Some(pose) = frames.explicit(place.path, node, self.warnings)? {
                    model.pose = pose;
                }
                models.push(model);
            }
        }
        Ok(models)
    }

    fn model(&mut self, place: Place, node: Node) -> Result<Model, ImportError> {
        let place = place.deeper(node)?;
        self.models += 1;
        if self.models > MAX_MODELS {
            return Err(ImportError::too_large(place.path, "models", MAX_MODELS));
        }
        let frames = Frames::read(place.path, node)?;
        let mut links = Vec::new();
        for link in children(node, "link") {
            links.push(self.link(place, &frames, link)?);
        }
        Ok(Model {
            name: node.attribute("name").unwrap_or("unnamed").to_owned(),
            pose: pose_of(place.path, node)?.pose,
            scale: Vector3::repeat(1.0),
            links,
            models: self.models_in(place, node)?,
        })
    }

    fn link(&mut self, place: Place, frames: &Frames, node: Node) -> Result<Link, ImportError> {
        let own = frames.explicit(place.path, node, self.warnings)?;
        let pose = own.map_or_else(|| pose_of(place.path, node).map(|p| p.pose), Ok)?;
        let mut shapes = Vec::new();
        for child in node
            .children()
            .filter(|n| is(*n, "visual") || is(*n, "collision"))
        {
            let Some(geometry) = read_geometry(place.path, child, self.warnings)? else {
                continue;
            };
            let in_model = frames.explicit(place.path, child, self.warnings)?;
            let own = in_model.map_or_else(
                || pose_of(place.path, child).map(|p| p.pose),
                // Named frames are those of the model; a shape's pose is kept in its link.
                |p| Ok(pose.inverse() * p),
            )?;
            let visual = is(child, "visual");
            let paint = if visual {
                read_paint(place.path, child)?
            } else {
                None
            };
            shapes.push(Shape {
                visual,
                pose: own,
                geometry,
                paint,
            });
        }
        Ok(Link {
            name: node.attribute("name").unwrap_or_default().to_owned(),
            pose,
            shapes,
        })
    }

    /// The model of an `<include>`; `None` for included lights. Number plates whose model was never
    /// published become models without links.
    fn include(&mut self, place: Place, node: Node) -> Result<Option<Model>, ImportError> {
        let place = place.deeper(node)?;
        let uri = child_text(node, "uri")
            .ok_or_else(|| malformed(place.path, node, "<include> needs a <uri>"))?;
        let name = child_text(node, "name")
            .or_else(|| model_of(uri))
            .unwrap_or(uri)
            .to_owned();
        let beside = place.path.parent().unwrap_or(Path::new("."));
        let found = self.search.find(uri, beside).and_then(|p| model_file(&p));
        let mut model = match found {
            Some(file) => match self.model_in_file(Place {
                path: &file,
                ..place
            })? {
                Some(model) => model,
                None => return Ok(None),
            },
            // A light of Gazebo's own, which models on the search path need not hold.
            None if model_of(uri) == Some("sun") => return Ok(None),
            None if model_of(uri).and_then(unit_of_name).is_some() => plate_model(uri),
            None => {
                let searched = self.search.folders();
                return Err(ImportError::Missing {
                    model: name,
                    uri: uri.to_owned(),
                    searched,
                });
            }
        };
        model.name = name;
        if child(node, "pose").is_some() {
            // The pose of an include replaces that of the model in its file.
            model.pose = pose_of(place.path, node)?.pose;
        }
        Ok(Some(model))
    }

    fn model_in_file(&mut self, place: Place) -> Result<Option<Model>, ImportError> {
        let text = read_text(place.path)?;
        let doc = parse(place.path, &text)?;
        let root = doc.root_element();
        match child(root, "model") {
            Some(model) => self.model(place, model).map(Some),
            None if child(root, "light").is_some() => Ok(None),
            None => Err(malformed(
                place.path,
                root,
                "there is no <model> in this file",
            )),
        }
    }
}

/// Replaces the model of a plate, which was never published.
fn plate_model(uri: &str) -> Model {
    // This file is never read: its uri tells `plate_of` the unit.
    let mesh = format!("{}/meshes/plate.dae", uri.trim_end_matches('/'));
    let shape = Shape {
        visual: true,
        pose: Pose3::identity(),
        geometry: super::shape::whole_mesh(&mesh),
        paint: None,
    };
    Model {
        // The include gives it one.
        name: String::new(),
        pose: Pose3::identity(),
        scale: Vector3::repeat(1.0),
        links: vec![Link {
            name: "link".into(),
            pose: Pose3::identity(),
            shapes: vec![shape],
        }],
        models: Vec::new(),
    }
}

/// The SDF file of a model folder: the newest version in `model.config`, else `model.sdf`.
fn model_file(found: &Path) -> Option<PathBuf> {
    if found.is_file() {
        return Some(found.to_owned());
    }
    let named = || {
        let config = found.join("model.config");
        // A `model.config` that is missing or broken is no error: `model.sdf` is the usual name.
        let text = read_text(&config).ok()?;
        let doc = parse(&config, &text).ok()?;
        let version = |n: &Node| {
            n.attribute("version")
                .and_then(|v| v.parse::<f64>().ok())
                .unwrap_or(0.0)
        };
        let newest = children(doc.root_element(), "sdf")
            .filter(|n| version(n) < 2.0)
            .max_by(|a, b| version(a).total_cmp(&version(b)))?;
        Some(found.join(newest.text()?.trim())).filter(|p| p.is_file())
    };
    named().or_else(|| Some(found.join("model.sdf")).filter(|p| p.is_file()))
}

fn read_road(path: &Path, node: Node) -> Result<Road, ImportError> {
    let name = node.attribute("name").unwrap_or("unnamed").to_owned();
    let width = child(node, "width")
        .map(|w| numbers::<1>(path, w))
        .transpose()?
        .map_or(1.0, |[w]| w);
    let points = children(node, "point")
        .map(|p| numbers::<3>(path, p))
        .collect::<Result<Vec<_>, _>>()?;
    if points.len() < 2 || width <= 0.0 {
        return Err(malformed(
            path,
            node,
            format!("road `{name}` needs two points and a positive width"),
        ));
    }
    Ok(Road {
        name,
        width,
        points,
        paint: read_paint(path, node)?,
    })
}
