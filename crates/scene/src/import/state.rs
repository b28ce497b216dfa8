//! `<state>`: the poses of models and links when the world was saved. As in Gazebo Classic, these
//! are poses in the world, also of links and of nested models, and take precedence over the poses
//! of the models.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use nalgebra::Vector3;
use openbench_core::Pose3;
use roxmltree::Node;

use super::error::ImportError;
use super::frames::parse_pose;
use super::sdf::{MAX_DEPTH, Model};
use super::xml::{child, child_numbers, children};

/// The state of one model.
#[derive(Debug, Default)]
struct ModelState {
    pose: Option<Pose3>,
    scale: Option<Vector3<f64>>,
    links: BTreeMap<String, Pose3>,
    models: BTreeMap<String, ModelState>,
}

/// The state of the world.
#[derive(Debug, Default)]
pub(crate) struct State {
    models: BTreeMap<String, ModelState>,
    deleted: BTreeSet<String>,
}

impl State {
    /// Reads a `<state>` element.
    pub(crate) fn read(path: &Path, node: Node) -> Result<Self, ImportError> {
        let gone = children(node, "deletions").flat_map(|d| children(d, "name"));
        let deleted = gone
            .filter_map(|n| n.text())
            .map(|t| t.trim().to_owned())
            .collect();
        Ok(Self {
            models: read_models(path, node, 0)?,
            deleted,
        })
    }

    /// Moves, scales and removes models to match the state.
    pub(crate) fn apply(&self, models: &mut Vec<Model>) {
        models.retain(|m| !self.deleted.contains(&m.name));
        for model in models {
            if let Some(state) = self.models.get(&model.name) {
                state.apply(model, &Pose3::identity());
            }
        }
    }
}

impl ModelState {
    fn apply(&self, model: &mut Model, parent: &Pose3) {
        if let Some(pose) = self.pose {
            // Poses of the state are in the world, those of models in the frame of the enclosing
            // model.
            model.pose = parent.inverse() * pose;
        }
        if let Some(scale) = self.scale {
            model.scale = scale;
        }
        // After the model has moved: links without a state of their own move with it.
        let world = parent * model.pose;
        for link in &mut model.links {
            if let Some(pose) = self.links.get(&link.name) {
                link.pose = world.inverse() * pose;
            }
        }
        for inner in &mut model.models {
            if let Some(state) = self.models.get(&inner.name) {
                state.apply(inner, &world);
            }
        }
    }
}

fn read_models(
    path: &Path,
    node: Node,
    depth: usize,
) -> Result<BTreeMap<String, ModelState>, ImportError> {
    let mut states = BTreeMap::new();
    // Models so deep are refused by the reader, so nothing is lost.
    if depth > MAX_DEPTH {
        return Ok(states);
    }
    for model in children(node, "model") {
        let Some(name) = model.attribute("name") else {
            continue;
        };
        let mut state = ModelState {
            pose: child(model, "pose")
                .map(|p| parse_pose(path, p))
                .transpose()?,
            scale: child_numbers::<3>(path, model, "scale")?.map(Vector3::from),
            links: BTreeMap::new(),
            models: read_models(path, model, depth + 1)?,
        };
        for link in children(model, "link") {
            if let (Some(name), Some(pose)) = (link.attribute("name"), child(link, "pose")) {
                state.links.insert(name.to_owned(), parse_pose(path, pose)?);
            }
        }
        states.insert(name.to_owned(), state);
    }
    Ok(states)
}
