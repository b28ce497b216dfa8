//! Wavefront OBJ with its MTL: `v`, `vt`, `f`, `g`, `o`, `usemtl`, `mtllib`; of materials `Kd`,
//! `map_Kd`, `map_d`.
//!
//! As in Gazebo, z is assumed to point up. Lines and free-form surfaces are ignored.

use std::collections::BTreeMap;
use std::path::Path;
use std::str::SplitAsciiWhitespace;

use nalgebra::Point3;

use super::super::color::color;
use super::super::error::{ImportError, ObjError};
use super::super::xml::read_text;
use super::part::{CornerKey, Joiner, MAX_TRIANGLES, Mesh, MeshMaterial, Part};
use crate::scene::Corner;

#[derive(Default)]
struct Obj {
    positions: Vec<Point3<f64>>,
    uvs: Vec<[f32; 2]>,
    materials: Vec<MeshMaterial>,
    material_numbers: BTreeMap<String, usize>,
    parts: Vec<Part>,
    open: Joiner,
    triangles: usize,
    names: [String; 2],
    material: Option<usize>,
}

/// Reads OBJ and the MTL files beside it; a missing MTL file leaves its parts white.
pub(super) fn read(path: &Path, text: &str) -> Result<Mesh, ImportError> {
    let mut obj = Obj::default();
    for (number, line) in text.lines().enumerate() {
        obj.line(path, line).map_err(|source| ImportError::Obj {
            path: path.to_owned(),
            line: number as u32 + 1,
            source,
        })?;
    }
    obj.close();
    Ok(Mesh {
        parts: obj.parts,
        materials: obj.materials,
    })
}

impl Obj {
    fn line(&mut self, path: &Path, line: &str) -> Result<(), ObjError> {
        let mut words = line.split_ascii_whitespace();
        let Some(keyword) = words.next() else {
            return Ok(());
        };
        let rest = line.trim_start().get(keyword.len()..).unwrap_or("").trim();
        match keyword {
            "v" => self
                .positions
                .push(floats::<3>(words)?.map(f64::from).into()),
            "vt" => self.uvs.push(floats::<2>(words)?),
            "f" => self.face(words)?,
            "g" | "o" => {
                self.close();
                // A part can be named by its group and by its object.
                self.names[usize::from(keyword == "o")] = rest.to_owned();
            }
            "usemtl" => {
                self.close();
                self.material = self.material_numbers.get(rest).copied();
            }
            "mtllib" => self.library(path, rest),
            _ => {}
        }
        Ok(())
    }

    fn face(&mut self, words: SplitAsciiWhitespace) -> Result<(), ObjError> {
        let mut corners = Vec::new();
        for word in words {
            // While it is read, not afterwards: two letters of a file make a triangle.
            if self.triangles + corners.len() > MAX_TRIANGLES + 1 {
                return Err(ObjError::TooManyTriangles {
                    limit: MAX_TRIANGLES,
                });
            }
            let mut fields = word.split('/');
            let position = index(fields.next().unwrap_or(""), self.positions.len())?;
            let uv = fields
                .next()
                .filter(|f| !f.is_empty())
                .map(|f| index(f, self.uvs.len()))
                .transpose()?;
            let make = || {
                Corner::new(
                    self.positions[position],
                    uv.map_or([0.0; 2], |i| self.uvs[i]),
                )
            };
            let key = CornerKey {
                position,
                // 0 stands for none.
                uv: uv.map_or(0, |i| i + 1),
            };
            corners.push(self.open.corner(key, make));
        }
        self.triangles += corners.len().saturating_sub(2);
        self.open.fan(&corners);
        Ok(())
    }

    fn close(&mut self) {
        // A new joiner for the next part, since corners are numbered within their part.
        let mut part = std::mem::take(&mut self.open).part;
        if !part.triangles.is_empty() {
            part.names = self.names.to_vec();
            part.material = self.material;
            self.parts.push(part);
        }
    }

    fn library(&mut self, path: &Path, name: &str) {
        let file = path.parent().unwrap_or(Path::new(".")).join(name);
        let Ok(text) = read_text(&file) else { return };
        for NamedMaterial { name, material } in materials(&text) {
            self.material_numbers.insert(name, self.materials.len());
            self.materials.push(material);
        }
    }
}

/// A material of an MTL file.
struct NamedMaterial {
    name: String,
    material: MeshMaterial,
}

/// The materials of an MTL file.
fn materials(text: &str) -> Vec<NamedMaterial> {
    let mut found: Vec<NamedMaterial> = Vec::new();
    for line in text.lines() {
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if keyword == "newmtl" {
            found.push(NamedMaterial {
                name: rest.trim().to_owned(),
                material: MeshMaterial::default(),
            });
        }
        let Some(NamedMaterial { material, .. }) = found.last_mut() else {
            continue;
        };
        match keyword {
            "Kd" => material.color = floats::<3>(rest.split_ascii_whitespace()).unwrap_or([1.0; 3]),
            "map_Kd" => material.image = image_name(rest),
            "map_d" => material.cutout = true,
            _ => {}
        }
    }
    for NamedMaterial { material, .. } in &mut found {
        // Exporters write a meaningless grey beside an image.
        material.color = if material.image.is_some() {
            [1.0; 3]
        } else {
            color(material.color).unwrap_or([1.0; 3])
        };
    }
    found
}

/// The file name after options such as `-s 1 1 1`: without options it may contain spaces.
fn image_name(rest: &str) -> Option<String> {
    let rest = rest.trim();
    let name = if rest.starts_with('-') {
        rest.split_ascii_whitespace().last()?
    } else {
        rest
    };
    Some(name.to_owned()).filter(|n| !n.is_empty())
}

/// The first `N` numbers of a line.
fn floats<const N: usize>(words: SplitAsciiWhitespace) -> Result<[f32; N], ObjError> {
    let mut values = [0.0; N];
    let mut count = 0;
    for (value, word) in values.iter_mut().zip(words) {
        *value = word.parse().map_err(|source| ObjError::Number {
            word: word.to_owned(),
            source,
        })?;
        count += 1;
    }
    if count < N {
        return Err(ObjError::TooFewNumbers { needed: N });
    }
    Ok(values)
}

/// Zero-based place of an index that counts from 1, or from the end if negative.
fn index(word: &str, count: usize) -> Result<usize, ObjError> {
    let index: i64 = word.parse().map_err(|source| ObjError::Index {
        word: word.to_owned(),
        source,
    })?;
    let place = if index < 0 {
        // -1 is the last element so far, not the last of the file.
        count as i64 + index
    } else {
        index - 1
    };
    let place = usize::try_from(place).ok().filter(|p| *p < count);
    place.ok_or(ObjError::OutOfRange { index, count })
}

#[cfg(test)]
mod tests {
    use openbench_core::with_causes;

    use super::*;

    const SQUARE: &str =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\ng side\nf 1/1 2/2 3/2 -1/1\n";

    #[test]
    fn a_square_becomes_two_triangles() {
        let mesh = read(Path::new("a.obj"), SQUARE).unwrap();
        assert_eq!(mesh.parts[0].triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(
            mesh.parts[0].corners[3].position,
            Point3::new(0.0, 1.0, 0.0)
        );
        assert_eq!(mesh.parts[0].corners[2].uv, [1.0, 1.0]);
        assert!(mesh.parts[0].names.contains(&"side".to_owned()));
    }

    #[test]
    fn bad_indices_are_errors_with_their_line() {
        for face in ["f 1 2 5", "f 0 1 2", "f -5 1 2", "f 1/3 2/1 3/1", "f a b c"] {
            let error = read(Path::new("a.obj"), &format!("{SQUARE}{face}\n"))
                .unwrap_err()
                .to_string();
            assert!(error.starts_with("a.obj:9:1: "), "{error}");
        }
    }

    #[test]
    fn a_mesh_of_too_many_triangles_is_refused_while_it_is_read() {
        let corners = " 1 2".repeat(MAX_TRIANGLES / 2 + 2);
        let error = read(Path::new("a.obj"), &format!("{SQUARE}f{corners}\n")).unwrap_err();
        let error = with_causes(&error);
        assert!(
            error.starts_with("a.obj:9:1: ") && error.contains("5000000 triangles"),
            "{error}"
        );
    }

    #[test]
    fn materials_know_their_image() {
        let found =
            materials("newmtl A\n\tKd 0.5 0.5 0.5\n\tmap_Kd -s 1 1 1 a.png\nnewmtl B\nKd 0 1 0\n");
        assert_eq!(found[0].material.image.as_deref(), Some("a.png"));
        assert_eq!(found[0].material.color, [1.0; 3]);
        assert_eq!(found[1].material.color, [0.0, 1.0, 0.0]);
    }

    proptest::proptest! {
        #[test]
        fn any_file_is_an_error_or_a_mesh_with_sound_indices(
            lines in proptest::collection::vec(
                "(v|vt|f|g|usemtl|mtllib)( -?[0-9]{1,2}(/[0-9]?){0,2}){0,5}",
                0..40,
            ),
        ) {
            if let Ok(mesh) = read(Path::new("nowhere/a.obj"), &lines.join("\n")) {
                for part in &mesh.parts {
                    let mut indices = part.triangles.iter().flatten();
                    assert!(indices.all(|i| (*i as usize) < part.corners.len()));
                }
            }
        }
    }
}
