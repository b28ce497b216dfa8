//! OGRE `.material` scripts, as far as they determine the look of flat-shaded surfaces. Of each
//! material these are read: the first image, the diffuse colour, whether transparent texels are
//! holes, and the scale of the image.
//!
//! Left out: techniques and passes after the first that has content, programs, animation, imports
//! from other scripts.

use std::collections::BTreeMap;

use super::color::color;

/// One material of a script.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OgreMaterial {
    /// Name of the image file.
    pub(crate) image: Option<String>,
    /// sRGB colour.
    pub(crate) color: Option<[f32; 3]>,
    /// Whether transparent texels are holes.
    pub(crate) cutout: bool,
    /// Divisors of the texture coordinates.
    pub(crate) stretch: [f32; 2],
}

impl Default for OgreMaterial {
    fn default() -> Self {
        Self {
            image: None,
            color: None,
            cutout: false,
            stretch: [1.0; 2],
        }
    }
}

/// The materials of a script by name. Unknown statements are ignored, as OGRE does.
pub(crate) fn parse_script(text: &str) -> BTreeMap<String, OgreMaterial> {
    let mut script = Script::default();
    for line in without_block_comments(text).lines() {
        let line = line.split("//").next().unwrap_or("");
        // A brace may be at the end of a line.
        for piece in line.replace('{', "\n{\n").replace('}', "\n}\n").lines() {
            script.piece(piece.trim());
        }
    }
    script.materials
}

#[derive(Default)]
struct Script {
    materials: BTreeMap<String, OgreMaterial>,
    /// Headers of the open blocks, the outermost first.
    open: Vec<String>,
    /// Header of a block before its brace.
    header: String,
    current: Option<String>,
}

impl Script {
    fn piece(&mut self, piece: &str) {
        match piece {
            "" => {}
            "{" => self.enter(),
            "}" => {
                self.open.pop();
                if self.open.is_empty() {
                    self.current = None;
                }
            }
            _ => {
                // Whether a line is an attribute or the header of a block is known only from what
                // follows. No header matches an attribute below.
                self.attribute(piece);
                piece.clone_into(&mut self.header);
            }
        }
    }

    fn enter(&mut self) {
        let header = std::mem::take(&mut self.header);
        if self.open.is_empty()
            && let Some(rest) = header.strip_prefix("material ")
        {
            let (name, parent) = rest
                .split_once(':')
                .map_or((rest, None), |(n, p)| (n, Some(p.trim())));
            // A material inherits from one that stands above it in the same script.
            let start = parent
                .and_then(|p| self.materials.get(unquoted(p)))
                .cloned()
                .unwrap_or_default();
            let name = unquoted(name.trim()).to_owned();
            self.materials.insert(name.clone(), start);
            self.current = Some(name);
        }
        self.open.push(header);
    }

    fn attribute(&mut self, line: &str) {
        let Some(material) = self
            .current
            .as_ref()
            .and_then(|n| self.materials.get_mut(n))
        else {
            return;
        };
        let block = self
            .open
            .last()
            .and_then(|h| h.split_ascii_whitespace().next())
            .unwrap_or("");
        let mut words = line.split_ascii_whitespace();
        let keyword = words.next().unwrap_or("");
        let values: Vec<&str> = words.collect();
        let number = |i: usize| values.get(i).and_then(|w| w.parse::<f32>().ok());
        match (block, keyword) {
            ("pass", "diffuse") => {
                if let (Some(r), Some(g), Some(b)) = (number(0), number(1), number(2)) {
                    material.color = color([r, g, b]).or(material.color);
                }
            }
            ("pass", "alpha_rejection") => {
                material.cutout |= values.first() != Some(&"always_pass")
            }
            ("pass", "scene_blend") => {
                // Rays hit a surface or pass it, so blended texels become holes or not.
                material.cutout |= matches!(
                    values.as_slice(),
                    ["alpha_blend"] | ["src_alpha", "one_minus_src_alpha"]
                );
            }
            // The first image counts as the colour; further ones are often normals or lights.
            ("texture_unit", "texture") if material.image.is_none() => {
                material.image = values.first().map(|v| unquoted(v).to_owned());
            }
            ("texture_unit", "scale") => {
                if let (Some(u), Some(v)) = (number(0), number(1)) {
                    // OGRE scales the image, so coordinates are divided by the scale; one of zero
                    // is ignored.
                    material.stretch = [u, v].map(|s| if s.abs() > 1e-6 { s } else { 1.0 });
                }
            }
            _ => {}
        }
    }
}

fn unquoted(word: &str) -> &str {
    word.trim_matches('"')
}

fn without_block_comments(text: &str) -> String {
    let mut kept = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("/*") {
        kept.push_str(before);
        rest = after.split_once("*/").map_or("", |(_, r)| r);
    }
    kept + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCRIPT: &str = "
        // leaves
        material Tree/Leaf
        {
          technique {
            pass
            {
              diffuse 0.5 0.5 0.5 1.0
              alpha_rejection greater 128
              texture_unit
              {
                texture leaf.png /* the one */
                scale 0.1 0.2
              }
              texture_unit { texture normal.png
              }
            }
          }
        }
        fragment_program x glsl { source x.glsl }
        material \"Tree/Red leaf\" : Tree/Leaf
        { technique { pass { diffuse 1 0 0 1
        } } }";

    #[test]
    fn a_script_gives_image_colour_and_holes() {
        let found = parse_script(SCRIPT);
        let leaf = &found["Tree/Leaf"];
        assert_eq!(leaf.image.as_deref(), Some("leaf.png"));
        assert_eq!(leaf.color, Some([0.5; 3]));
        assert!(leaf.cutout);
        assert_eq!(leaf.stretch, [0.1, 0.2]);
    }

    #[test]
    fn a_material_takes_from_its_parent() {
        let found = parse_script(SCRIPT);
        let red = &found["Tree/Red leaf"];
        assert_eq!(
            (red.image.as_deref(), red.color),
            (Some("leaf.png"), Some([1.0, 0.0, 0.0]))
        );
        assert_eq!(found.len(), 2);
    }

    #[test]
    fn torn_scripts_are_survived() {
        for end in 0..SCRIPT.len() {
            parse_script(&SCRIPT[..end]);
        }
        parse_script("}}}material{{ texture_unit } material : : {");
    }
}
