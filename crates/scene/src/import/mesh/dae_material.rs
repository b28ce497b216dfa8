//! COLLADA materials: symbol of a primitive, bound material, effect, diffuse colour or image.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::super::color::color;
use super::super::xml::{child, child_text, children, is};
use super::dae_document::Dae;
use super::part::MeshMaterial;

/// The material of one primitive of one instance.
pub(super) struct Binding {
    /// Index into the mesh's materials.
    pub(super) material: Option<usize>,
    /// The set of texture coordinates that the image uses, if the file has it.
    pub(super) uv_set: Option<u32>,
}

/// Materials that were used, by their id.
#[derive(Default)]
pub(super) struct Materials {
    list: Vec<MeshMaterial>,
    numbers: BTreeMap<String, usize>,
}

impl Materials {
    /// The materials in the order of their numbers.
    pub(super) fn into_list(self) -> Vec<MeshMaterial> {
        self.list
    }

    /// The material that `symbol` of a primitive is bound to in `instance`. An unbound symbol is
    /// tried as the id of a material.
    pub(super) fn bind(&mut self, dae: &Dae, instance: Node, symbol: Option<&str>) -> Binding {
        let none = Binding {
            material: None,
            uv_set: None,
        };
        let Some(symbol) = symbol else { return none };
        let bound = instance
            .descendants()
            .find(|n| is(*n, "instance_material") && n.attribute("symbol") == Some(symbol));
        let target = bound.and_then(|b| b.attribute("target")).unwrap_or(symbol);
        let Some(material) = dae.by_id(target).filter(|n| is(*n, "material")) else {
            return none;
        };
        let effect = child(material, "instance_effect")
            .and_then(|i| i.attribute("url"))
            .and_then(|u| dae.by_id(u));
        let Some(effect) = effect else { return none };
        let texture = diffuse(effect).and_then(|d| child(d, "texture"));
        // The texture names a channel, which the instance binds to one of the mesh's sets of
        // coordinates.
        let uv_set = texture
            .and_then(|t| t.attribute("texcoord"))
            .zip(bound)
            .and_then(|(channel, bound)| {
                let same = |n: &Node| n.attribute("semantic") == Some(channel);
                children(bound, "bind_vertex_input")
                    .find(same)?
                    .attribute("input_set")?
                    .parse()
                    .ok()
            });
        let next = self.list.len();
        // By the material, not by the symbol: instances may bind one symbol to different materials.
        let number = *self.numbers.entry(target.to_owned()).or_insert(next);
        if number == next {
            self.list.push(read_effect(dae, effect));
        }
        Binding {
            material: Some(number),
            uv_set,
        }
    }
}

/// `<diffuse>` of the shader of an effect, whichever shader it is.
fn diffuse<'a, 'i>(effect: Node<'a, 'i>) -> Option<Node<'a, 'i>> {
    effect.descendants().find(|n| is(*n, "diffuse"))
}

fn read_effect(dae: &Dae, effect: Node) -> MeshMaterial {
    let diffuse = diffuse(effect);
    let sampler = diffuse
        .and_then(|d| child(d, "texture"))
        .and_then(|t| t.attribute("texture"));
    let image = sampler.and_then(|s| image_of(dae, effect, s));
    let channels = |n: Node| {
        let values: Vec<f32> = n
            .text()?
            .split_ascii_whitespace()
            .map_while(|w| w.parse().ok())
            .collect();
        color([*values.first()?, *values.get(1)?, *values.get(2)?])
    };
    let color = diffuse
        .and_then(|d| child(d, "color"))
        .and_then(channels)
        .unwrap_or([1.0; 3]);
    let transparent = effect.descendants().find(|n| is(*n, "transparent"));
    MeshMaterial {
        // A diffuse element holds a colour or an image; white leaves the image as it is.
        color: if image.is_some() { [1.0; 3] } else { color },
        image,
        cutout: transparent.is_some_and(|t| child(t, "texture").is_some()),
    }
}

/// The file of a sampler: sampler, surface, image. Some exporters refer to the image directly.
fn image_of(dae: &Dae, effect: Node, sampler: &str) -> Option<String> {
    let param = |sid: &str| {
        effect
            .descendants()
            .find(|n| is(*n, "newparam") && n.attribute("sid") == Some(sid))
    };
    let inner = |node: Node, tag: &str| {
        node.descendants()
            .find(|n| is(*n, tag))
            .and_then(|n| n.text())
            .map(str::trim)
            .map(str::to_owned)
    };
    let surface = param(sampler).and_then(|p| inner(p, "source"));
    let image = surface
        .and_then(|s| param(&s))
        .and_then(|p| inner(p, "init_from"));
    let node = dae
        .by_id(image.as_deref().unwrap_or(sampler))
        .filter(|n| is(*n, "image"))?;
    let from = child_text(node, "init_from").map(str::to_owned);
    // COLLADA 1.5 has the path one level deeper.
    from.or_else(|| inner(node, "ref"))
        .filter(|f| !f.is_empty())
}
