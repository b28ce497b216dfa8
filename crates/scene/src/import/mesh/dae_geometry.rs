//! COLLADA primitives: triangles, polylists, polygons, strips and fans.
//!
//! Polygons become fans, as in Gazebo; holes of polygons (`<ph>`) are filled.

use nalgebra::Point3;
use roxmltree::Node;

use super::super::error::ImportError;
use super::super::xml::{child, children, list, malformed};
use super::dae_document::{Dae, Source, input, source};
use super::part::{CornerKey, Joiner, Part};
use crate::scene::Corner;

/// Targets of the indices of a primitive.
struct Streams {
    positions: Source,
    position_offset: usize,
    uvs: Option<UvStream>,
    /// Indices for each corner.
    width: usize,
}

/// Texture coordinates, and which index of a corner refers to them.
struct UvStream {
    source: Source,
    offset: usize,
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
    // A `<polygons>` has a list for each polygon; the other kinds have one, or one for each strip.
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
                        key.position
                    ),
                )
            })?;
            // Looked up above, since the joiner's closure cannot fail.
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
                // Every second triangle of a strip runs the other way round.
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
        // The inputs share one list: a corner has as many indices as the highest offset requires.
        let highest = children(primitive, "input").map(offset).max().unwrap_or(0);
        if highest >= 64 {
            return Err(wrong("sane input offsets"));
        }
        let width = highest + 1;
        let vertex = input(primitive, "VERTEX").ok_or_else(|| wrong("input VERTEX"))?;
        let vertices = dae
            .target(vertex, "source")
            .ok_or_else(|| wrong("vertices"))?;
        let position = input(vertices, "POSITION").and_then(|i| dae.target(i, "source"));
        let positions = source(dae, position.ok_or_else(|| wrong("positions"))?)?;
        if positions.stride < 3 {
            return Err(wrong("positions of three numbers"));
        }
        Ok(Self {
            positions,
            position_offset: offset(vertex),
            uvs: UvStream::read(dae, primitive, uv_set)?,
            width,
        })
    }

    /// Indices of position and texture coordinates; the latter 0 where there are none.
    fn key(&self, indices: &[usize]) -> CornerKey {
        CornerKey {
            position: indices[self.position_offset],
            uv: self.uvs.as_ref().map_or(0, |uvs| indices[uvs.offset]),
        }
    }

    fn corner(&self, key: CornerKey) -> Option<Corner> {
        let position = self.positions.item::<3>(key.position)?;
        let uv = match &self.uvs {
            None => [0.0; 2],
            Some(uvs) => uvs.source.item::<2>(key.uv)?.map(|c| c as f32),
        };
        Some(Corner::new(Point3::from(position), uv))
    }
}

impl UvStream {
    /// The texture coordinates of a primitive; `None` if it has none of two numbers.
    fn read(dae: &Dae, primitive: Node, uv_set: Option<u32>) -> Result<Option<Self>, ImportError> {
        let Some(input) = uv_input(primitive, uv_set) else {
            return Ok(None);
        };
        let Some(target) = dae.target(input, "source") else {
            return Ok(None);
        };
        let source = source(dae, target)?;
        let offset = offset(input);
        Ok((source.stride >= 2).then_some(Self { source, offset }))
    }
}

/// Which of a corner's indices belongs to an `<input>`.
fn offset(input: Node) -> usize {
    input
        .attribute("offset")
        .and_then(|o| o.parse().ok())
        .unwrap_or(0)
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
