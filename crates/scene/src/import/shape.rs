//! `<geometry>` and `<material>` elements.

use std::path::Path;

use nalgebra::Vector3;
use roxmltree::Node;

use super::error::ImportError;
use super::sdf::{Geometry, Heightmap, ImageShape, MeshUse, Paint, TiledImage};
use super::warnings::Warnings;
use super::xml::{child, child_color, child_numbers, child_text, children, malformed, numbers};

/// Most corners of an outline.
const MAX_POINTS: usize = 1000;

/// The form of a `<visual>` or `<collision>`; `None` for unsupported forms, which are counted.
pub(crate) fn read_geometry(
    path: &Path,
    shape: Node,
    warnings: &mut Warnings,
) -> Result<Option<Geometry>, ImportError> {
    let Some(node) = child(shape, "geometry").and_then(|g| g.first_element_child()) else {
        return Ok(None);
    };
    let tag = node.tag_name().name();
    let geometry = match tag {
        "box" => Geometry::Box(positive::<3>(path, node, "size")?.into()),
        "plane" => read_plane(path, node)?,
        "cylinder" => {
            let [radius] = positive(path, node, "radius")?;
            let [length] = positive(path, node, "length")?;
            Geometry::Cylinder { radius, length }
        }
        "sphere" => Geometry::Sphere(positive::<1>(path, node, "radius")?[0]),
        "polyline" => read_polylines(path, node)?,
        "mesh" => Geometry::Mesh(read_mesh_use(path, node)?),
        "heightmap" => Geometry::Heightmap(read_heightmap(path, node)?),
        "image" => Geometry::Image(read_image_shape(path, node)?),
        "empty" => return Ok(None),
        _ => {
            warnings.add(format!("geometry <{tag}> is not supported"));
            return Ok(None);
        }
    };
    Ok(Some(geometry))
}

fn read_plane(path: &Path, node: Node) -> Result<Geometry, ImportError> {
    let normal = child_numbers::<3>(path, node, "normal")?.map_or(Vector3::z(), Vector3::from);
    let size = child_numbers::<2>(path, node, "size")?.unwrap_or([1.0, 1.0]);
    let normal = normal
        .try_normalize(1e-9)
        .ok_or_else(|| malformed(path, node, "the plane's normal is zero"))?;
    if size.iter().any(|s| *s <= 0.0) {
        return Err(malformed(path, node, "<size> must be positive"));
    }
    Ok(Geometry::Plane { normal, size })
}

/// All `<polyline>` elements of a `<geometry>`; `first` is one of them.
fn read_polylines(path: &Path, first: Node) -> Result<Geometry, ImportError> {
    let [height] = positive(path, first, "height")?;
    // The element that was found is the first of several: together they are one shape with holes.
    let lines: Vec<Node> = first
        .parent()
        .map_or(vec![first], |all| children(all, "polyline").collect());
    let outline = |line: &Node| -> Result<Vec<[f64; 2]>, ImportError> {
        let mut points = children(*line, "point")
            .map(|p| numbers::<2>(path, p))
            .collect::<Result<Vec<_>, _>>()?;
        // Closed or open makes no difference.
        if points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        if points.len() > MAX_POINTS {
            return Err(malformed(
                path,
                *line,
                format!("<polyline> has more than {MAX_POINTS} points"),
            ));
        }
        if points.len() < 3 {
            return Err(malformed(
                path,
                *line,
                "<polyline> needs three different <point>s",
            ));
        }
        Ok(points)
    };
    let outlines = lines.iter().map(outline).collect::<Result<Vec<_>, _>>()?;
    Ok(Geometry::Extrusion { outlines, height })
}

fn read_mesh_use(path: &Path, node: Node) -> Result<MeshUse, ImportError> {
    // SDF 1.2 and 1.3 call it <filename>.
    let uri = child_text(node, "uri").or_else(|| child_text(node, "filename"));
    let submesh = child(node, "submesh");
    Ok(MeshUse {
        uri: uri
            .ok_or_else(|| malformed(path, node, "<mesh> needs a <uri>"))?
            .to_owned(),
        scale: child_numbers::<3>(path, node, "scale")?.map_or(Vector3::repeat(1.0), Vector3::from),
        submesh: submesh
            .and_then(|s| child_text(s, "name"))
            .map(str::to_owned),
        center: submesh
            .and_then(|s| child_text(s, "center"))
            .is_some_and(|t| t == "true" || t == "1"),
    })
}

fn read_heightmap(path: &Path, node: Node) -> Result<Heightmap, ImportError> {
    let size = match child(node, "size") {
        Some(_) => positive::<3>(path, node, "size")?.into(),
        None => Vector3::repeat(1.0),
    };
    let texture = child(node, "texture");
    let image = texture
        .and_then(|texture| child_text(texture, "diffuse"))
        .map(str::to_owned);
    let tile = texture
        .map(|t| child_numbers::<1>(path, t, "size"))
        .transpose()?
        .flatten();
    // Defaults here and below are those of the SDF specification.
    let tile = tile.map_or(10.0, |[metres]| metres);
    Ok(Heightmap {
        uri: uri_of(path, node)?,
        size,
        position: child_numbers::<3>(path, node, "pos")?.map_or(Vector3::zeros(), Vector3::from),
        texture: image
            .filter(|_| tile > 0.0)
            .map(|uri| TiledImage { uri, tile }),
    })
}

fn read_image_shape(path: &Path, node: Node) -> Result<ImageShape, ImportError> {
    let number = |name: &str, usual: f64| -> Result<f64, ImportError> {
        match child(node, name) {
            Some(_) => Ok(positive::<1>(path, node, name)?[0]),
            None => Ok(usual),
        }
    };
    Ok(ImageShape {
        uri: uri_of(path, node)?,
        scale: number("scale", 1.0)?,
        // The file counts brightness in bytes, images are read from 0 to 1.
        threshold: (number("threshold", 200.0)? / 255.0) as f32,
        height: number("height", 1.0)?,
    })
}

fn uri_of(path: &Path, node: Node) -> Result<String, ImportError> {
    let lacks = || {
        malformed(
            path,
            node,
            format!("<{}> needs a <uri>", node.tag_name().name()),
        )
    };
    Ok(child_text(node, "uri").ok_or_else(lacks)?.to_owned())
}

/// A mesh file at its own scale.
pub(crate) fn whole_mesh(uri: &str) -> Geometry {
    Geometry::Mesh(MeshUse {
        uri: uri.to_owned(),
        scale: Vector3::repeat(1.0),
        submesh: None,
        center: false,
    })
}

fn positive<const N: usize>(path: &Path, node: Node, name: &str) -> Result<[f64; N], ImportError> {
    let lacks = || {
        malformed(
            path,
            node,
            format!("<{}> needs a <{name}>", node.tag_name().name()),
        )
    };
    let values = numbers::<N>(path, child(node, name).ok_or_else(lacks)?)?;
    if values.iter().any(|v| *v <= 0.0) {
        return Err(malformed(path, node, format!("<{name}> must be positive")));
    }
    Ok(values)
}

/// The `<material>` of a `<visual>` or `<road>`, if it has one.
pub(crate) fn read_paint(path: &Path, shape: Node) -> Result<Option<Paint>, ImportError> {
    let Some(node) = child(shape, "material") else {
        return Ok(None);
    };
    let script = child(node, "script");
    let diffuse = child_color(path, node, "diffuse")?;
    let image = child(node, "pbr")
        .and_then(|p| p.first_element_child())
        .and_then(|m| child_text(m, "albedo_map"));
    let uris = script
        .into_iter()
        .flat_map(|s| children(s, "uri").collect::<Vec<_>>());
    Ok(Some(Paint {
        uris: uris
            .filter_map(|u| u.text())
            .map(|t| t.trim().to_owned())
            .collect(),
        script: script
            .and_then(|s| child_text(s, "name"))
            .map(str::to_owned),
        image: image.map(str::to_owned),
        color: if diffuse.is_some() {
            diffuse
        } else {
            child_color(path, node, "ambient")?
        },
    }))
}
