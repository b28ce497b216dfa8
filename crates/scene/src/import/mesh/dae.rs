//! COLLADA 1.4: the nodes of the scene, their transforms, units and up axis.
//!
//! As in Gazebo Classic, a node with a `<matrix>` ignores its `<translate>`, `<rotate>` and
//! `<scale>`. The specification applies all in turn, but meshes that were made for Gazebo rely on
//! this. Left out: animation, skinning (a skinned mesh is read in its bind shape), cameras, lights,
//! physics.

use std::path::Path;

use nalgebra::{Matrix4, Rotation3, Unit, Vector3};
use roxmltree::Node;

use super::super::error::ImportError;
use super::super::xml::{child, malformed, numbers, parse};
use super::dae_document::Dae;
use super::dae_geometry::read_primitives;
use super::dae_material::Materials;
use super::part::{MAX_TRIANGLES, Mesh};

/// Nodes within nodes at most: instances can lead in a circle.
const MAX_DEPTH: usize = 64;
/// Visits of nodes at most: a few lines of nested instances can ask for millions.
const MAX_VISITS: usize = 100_000;

/// Reads COLLADA.
pub(super) fn read(path: &Path, text: &str) -> Result<Mesh, ImportError> {
    let doc = parse(path, text)?;
    let root = doc.root_element();
    let dae = Dae::new(path, &doc);
    let named = child(root, "scene").and_then(|s| child(s, "instance_visual_scene"));
    // Without a usable `<scene>`, the first visual scene is shown.
    let first = || child(root, "library_visual_scenes").and_then(|l| child(l, "visual_scene"));
    let Some(scene) = named.and_then(|n| dae.target(n, "url")).or_else(first) else {
        return Err(malformed(
            path,
            root,
            "there is no <visual_scene> in this file",
        ));
    };
    let mut walk = Walk {
        dae: &dae,
        mesh: Mesh::default(),
        materials: Materials::default(),
        visits: 0,
        triangles: 0,
    };
    // Unit and axes come first, so that all transforms of nodes act in those of the file.
    walk.children(scene, &base_transform(path, root)?, 0)?;
    walk.mesh.materials = walk.materials.into_list();
    Ok(walk.mesh)
}

/// Transform from the unit and up axis of the file to metres with z up.
fn base_transform(path: &Path, root: Node) -> Result<Matrix4<f64>, ImportError> {
    let Some(asset) = child(root, "asset") else {
        return Ok(Matrix4::identity());
    };
    let meter = child(asset, "unit")
        .and_then(|u| u.attribute("meter"))
        .map_or(Ok(1.0), str::parse::<f64>);
    let Some(meter) = meter.ok().filter(|m| m.is_finite() && *m > 0.0) else {
        return Err(malformed(
            path,
            asset,
            "<unit> needs a positive number of metres",
        ));
    };
    let up = child(asset, "up_axis")
        .and_then(|u| u.text())
        .map(str::trim);
    // COLLADA names the axes to the right, up and towards the viewer. Here these become x, z and
    // -y.
    let turn = match up {
        Some("Z_UP") => Matrix4::identity(),
        Some("X_UP") => Matrix4::new(
            0., -1., 0., 0., 0., 0., -1., 0., 1., 0., 0., 0., 0., 0., 0., 1.,
        ),
        // Y_UP, which is also the default of the specification.
        _ => Matrix4::new(
            1., 0., 0., 0., 0., 0., -1., 0., 0., 1., 0., 0., 0., 0., 0., 1.,
        ),
    };
    Ok(turn * Matrix4::new_scaling(meter))
}

struct Walk<'w, 'a, 'i> {
    dae: &'w Dae<'a, 'i>,
    mesh: Mesh,
    materials: Materials,
    visits: usize,
    triangles: usize,
}

impl<'a, 'i> Walk<'_, 'a, 'i> {
    fn children(
        &mut self,
        parent: Node<'a, 'i>,
        transform: &Matrix4<f64>,
        depth: usize,
    ) -> Result<(), ImportError> {
        for node in parent.children().filter(Node::is_element) {
            match node.tag_name().name() {
                "node" => self.node(node, transform, depth)?,
                "instance_node" => {
                    if let Some(target) = self.dae.target(node, "url") {
                        self.node(target, transform, depth)?;
                    }
                }
                "instance_geometry" => {
                    self.instance(parent, node, self.dae.target(node, "url"), transform)?
                }
                "instance_controller" => {
                    let skin = self.dae.target(node, "url").and_then(|c| child(c, "skin"));
                    let geometry = skin.and_then(|s| self.dae.target(s, "source"));
                    self.instance(parent, node, geometry, transform)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn node(
        &mut self,
        node: Node<'a, 'i>,
        parent: &Matrix4<f64>,
        depth: usize,
    ) -> Result<(), ImportError> {
        self.visits += 1;
        if depth > MAX_DEPTH || self.visits > MAX_VISITS {
            return Err(malformed(
                self.dae.path,
                node,
                "nodes are nested too deep, or inside themselves",
            ));
        }
        let transform = parent * own_transform(self.dae.path, node)?;
        self.children(node, &transform, depth + 1)
    }

    fn instance(
        &mut self,
        node: Node<'a, 'i>,
        instance: Node<'a, 'i>,
        geometry: Option<Node<'a, 'i>>,
        transform: &Matrix4<f64>,
    ) -> Result<(), ImportError> {
        let Some(geometry) = geometry else {
            return Err(malformed(
                self.dae.path,
                instance,
                "the geometry that this names is not in the file",
            ));
        };
        // Splines and convex meshes are not read.
        let Some(mesh) = child(geometry, "mesh") else {
            return Ok(());
        };
        let named = [node, geometry];
        let names = named
            .iter()
            .flat_map(|n| [n.attribute("name"), n.attribute("id")])
            .flatten();
        let names: Vec<String> = names.map(str::to_owned).collect();
        for primitive in mesh.children().filter(Node::is_element) {
            let binding = self
                .materials
                .bind(self.dae, instance, primitive.attribute("material"));
            let Some(mut part) = read_primitives(self.dae, primitive, binding.uv_set)? else {
                continue;
            };
            self.triangles += part.triangles.len();
            if self.triangles > MAX_TRIANGLES {
                return Err(ImportError::too_large(
                    self.dae.path,
                    "triangles",
                    MAX_TRIANGLES,
                ));
            }
            part.corners
                .iter_mut()
                .for_each(|corner| corner.position = transform.transform_point(&corner.position));
            // A transform that mirrors turns triangles inside out.
            if transform.fixed_view::<3, 3>(0, 0).determinant() < 0.0 {
                part.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            }
            part.names.clone_from(&names);
            part.material = binding.material;
            self.mesh.parts.push(part);
        }
        Ok(())
    }
}

fn own_transform(path: &Path, node: Node) -> Result<Matrix4<f64>, ImportError> {
    if let Some(matrix) = child(node, "matrix") {
        return Ok(Matrix4::from_row_slice(&numbers::<16>(path, matrix)?));
    }
    let mut transform = Matrix4::identity();
    for step in node.children().filter(Node::is_element) {
        // In the order of the file: each step acts within the frame of those before it.
        transform *= match step.tag_name().name() {
            "translate" => Matrix4::new_translation(&numbers::<3>(path, step)?.into()),
            "scale" => Matrix4::new_nonuniform_scaling(&numbers::<3>(path, step)?.into()),
            "rotate" => {
                let [x, y, z, degrees] = numbers::<4>(path, step)?;
                let axis = Unit::try_new(Vector3::new(x, y, z), 1e-12);
                axis.map_or(Matrix4::identity(), |a| {
                    Rotation3::from_axis_angle(&a, degrees.to_radians()).to_homogeneous()
                })
            }
            _ => continue,
        };
    }
    Ok(transform)
}
