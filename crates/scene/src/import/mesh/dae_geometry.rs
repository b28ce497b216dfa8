//! COLLADA primitives: triangles, polylists, polygons, strips and fans.
//!
//! Polygons become fans, as in Gazebo; holes of polygons (`<ph>`) are filled.

use nalgebra::Point3;
use roxmltree::Node;

use super::super::error::ImportError;
use super::super::xml::{child, children, list, malformed};
use super::dae_document::{Dae, input, source};
use super::part::{Joiner, Part};
use crate::scene::Corner;

/// Targets of the indices of a primitive.
struct Streams {
    positions: Vec<f64>,
    position_stride: usize,
    position_offset: usize,
    uvs: Vec<f64>,
    uv_stride: usize,
    uv_offset: Option<usize>,
    /// Indices for each corner.
    width: usize,
}

/// The triangles of a primitive element; `None` for other elements. `uv_set` is the set of texture
/// coordinates that its image uses.
pub(super) fn read_primitives(
    dae: &Dae,
    primitive: Node,
    uv_set: Option<u32>,
) -> Result<Option<Part>, ImportError> {
    let kind = primitive.tag_name().name();
    if !matches!(
        kind,
        "triangles" | "polylist" | "polygons" | "tristrips" | "trifans"
    ) {
        return Ok(None);
    }
    let streams = Streams::read(dae, primitive, uv_set)?;
    let mut joiner = Joiner::default();
    for p in index_lists(primitive) {
        let indices: Vec<usize> = list(dae.path, p)?;
        if !indices.len().is_multiple_of(streams.width) {
            return Err(malformed(
                dae.path,
                p,
                format!("<p> must hold a multiple of {} indices", streams.width),
            ));
        }
        let mut corners = Vec::with_capacity(indices.len() / streams.width);
        for one in indices.chunks_exact(streams.width) {
            let key = streams.key(one);
            let corner = streams.corner(key).ok_or_else(|| {
                malformed(
                    dae.path,
                    p,
                    format!(
                        "<p> names position {} or coordinates that are not there",
                        key.0
                    ),
                )
            })?;
            corners.push(joiner.corner(key, || corner));
        }
        add_polygons(dae, primitive, kind, &corners, &mut joiner)?;
    }
    Ok(Some(joiner.part))
}

/// All `<p>`, those inside `<ph>` included.
fn index_lists<'a, 'i: 'a>(primitive: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    let holed = children(primitive, "ph").filter_map(|h| child(h, "p"));
    children(primitive, "p").chain(holed)
}

fn add_polygons(
    dae: &Dae,
    primitive: Node,
    kind: &str,
    corners: &[u32],
    joiner: &mut Joiner,
) -> Result<(), ImportError> {
    match kind {
        "triangles" => corners.chunks_exact(3).for_each(|t| joiner.fan(t)),
        "polylist" => {
            let counts = child(primitive, "vcount")
                .ok_or_else(|| malformed(dae.path, primitive, "<polylist> needs <vcount>"))?;
            let mut rest = corners;
            for count in list::<usize>(dae.path, counts)? {
                let Some((polygon, after)) = rest.split_at_checked(count) else {
                    return Err(malformed(
                        dae.path,
                        counts,
                        "<vcount> asks for more corners than <p> has",
                    ));
                };
                joiner.fan(polygon);
                rest = after;
            }
        }
        "tristrips" => {
            for (i, t) in corners.windows(3).enumerate() {
                joiner.fan(&if i % 2 == 0 {
                    [t[0], t[1], t[2]]
                } else {
                    [t[1], t[0], t[2]]
                });
            }
        }
        // One <p> is one polygon or fan.
        _ => joiner.fan(corners),
    }
    Ok(())
}

impl Streams {
    fn read(dae: &Dae, primitive: Node, uv_set: Option<u32>) -> Result<Self, ImportError> {
        let wrong =
            |what: &str| malformed(dae.path, primitive, format!("this primitive has no {what}"));
        let offset = |n: Node| {
            n.attribute("offset")
                .and_then(|o| o.parse::<usize>().ok())
                .unwrap_or(0)
        };
        let width = children(primitive, "input").map(offset).max().unwrap_or(0) + 1;
        if width > 64 {
            return Err(wrong("sane input offsets"));
        }
        let vertex = input(primitive, "VERTEX").ok_or_else(|| wrong("input VERTEX"))?;
        let vertices = dae
            .target(vertex, "source")
            .ok_or_else(|| wrong("vertices"))?;
        let position = input(vertices, "POSITION").and_then(|i| dae.target(i, "source"));
        let (positions, position_stride) =
            source(dae, position.ok_or_else(|| wrong("positions"))?)?;
        if position_stride < 3 {
            return Err(wrong("positions of three numbers"));
        }
        let uv_input = uv_input(primitive, uv_set);
        let uv_source = uv_input.and_then(|i| dae.target(i, "source"));
        let (uvs, uv_stride) = uv_source
            .map(|s| source(dae, s))
            .transpose()?
            .unwrap_or((Vec::new(), 2));
        let usable = uv_source.is_some() && uv_stride >= 2;
        Ok(Self {
            positions,
            position_stride,
            position_offset: offset(vertex),
            uvs,
            uv_stride,
            uv_offset: uv_input.filter(|_| usable).map(offset),
            width,
        })
    }

    /// Indices of position and texture coordinates; the latter 0 where there are none.
    fn key(&self, indices: &[usize]) -> (usize, usize) {
        (
            indices[self.position_offset],
            self.uv_offset.map_or(0, |o| indices[o]),
        )
    }

    fn corner(&self, (position, uv): (usize, usize)) -> Option<Corner> {
        let p = self
            .positions
            .get(position.checked_mul(self.position_stride)?..)?
            .get(..3)?;
        let uv = match self.uv_offset {
            None => [0.0; 2],
            Some(_) => {
                let uv = self.uvs.get(uv.checked_mul(self.uv_stride)?..)?.get(..2)?;
                [uv[0] as f32, uv[1] as f32]
            }
        };
        Some(Corner::new(Point3::new(p[0], p[1], p[2]), uv))
    }
}

/// The texture coordinates of set `wanted`, else the first.
fn uv_input<'a, 'i>(primitive: Node<'a, 'i>, wanted: Option<u32>) -> Option<Node<'a, 'i>> {
    let set = |n: &Node| {
        n.attribute("set")
            .and_then(|s| s.parse::<u32>().ok())
            .unwrap_or(0)
    };
    let all =
        || children(primitive, "input").filter(|n| n.attribute("semantic") == Some("TEXCOORD"));
    all()
        .find(|n| Some(set(n)) == wanted)
        .or_else(|| all().next())
}
