//! Image files as textures, each read once: PNG and JPEG, reduced to at most 1024 texels a side.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageReader, Limits};

use super::error::ImportError;
use crate::{SceneBuilder, Texture, TextureId};

const MAX_TEXELS_A_SIDE: u32 = 1024;
/// Side of the largest grey image: two triangles between each four pixels.
// 8.4 million triangles. Heightmaps of Gazebo have 2^n + 1 pixels a side.
const MAX_GREY_A_SIDE: u32 = 2049;
const MAX_PIXELS_A_SIDE: u32 = 16_384;
const MAX_DECODED_BYTES: u64 = 512 << 20;

/// Textures of a scene by file.
#[derive(Debug, Default)]
pub(crate) struct Images {
    known: BTreeMap<PathBuf, TextureId>,
}

impl Images {
    /// The texture of the file at `path`.
    pub(crate) fn load(
        &mut self,
        builder: &mut SceneBuilder,
        path: &Path,
    ) -> Result<TextureId, ImportError> {
        if let Some(id) = self.known.get(path) {
            return Ok(*id);
        }
        let id = builder.texture(read_image(path)?);
        self.known.insert(path.to_owned(), id);
        Ok(id)
    }
}

/// A grey image.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Grey {
    /// Pixels in a row.
    pub(crate) width: usize,
    /// Rows.
    pub(crate) height: usize,
    /// Brightness row by row, 0 to 1.
    pub(crate) values: Vec<f32>,
}

/// Reads an image in grey, of at least two pixels a side.
pub(crate) fn read_grey(path: &Path) -> Result<Grey, ImportError> {
    // 16 bits: with 8, a hill of a hundred metres would have steps of 40 cm.
    let image = decode(path)?.into_luma16();
    let (width, height) = image.dimensions();
    if !(2..=MAX_GREY_A_SIDE).contains(&width) || !(2..=MAX_GREY_A_SIDE).contains(&height) {
        let problem = format!(
            "this image has {width} by {height} pixels; a shape is made of 2 to {MAX_GREY_A_SIDE} \
             each way"
        );
        return Err(ImportError::asset(path, problem));
    }
    let values = image
        .into_raw()
        .into_iter()
        .map(|value| f32::from(value) / f32::from(u16::MAX))
        .collect();
    Ok(Grey {
        width: width as usize,
        height: height as usize,
        values,
    })
}

fn read_image(path: &Path) -> Result<Texture, ImportError> {
    let rgba = decode(path)?.into_rgba8();
    let (width, height) = rgba.dimensions();
    if width == 0 || height == 0 {
        return Err(ImportError::asset(path, "this image is empty"));
    }
    Ok(shrink(&Texture {
        width,
        height,
        rgba: rgba.into_raw().into(),
    }))
}

fn decode(path: &Path) -> Result<DynamicImage, ImportError> {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_PIXELS_A_SIDE);
    limits.max_image_height = Some(MAX_PIXELS_A_SIDE);
    // Decoders check these before they take memory: a few bytes may declare an image of gigabytes.
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    let io = |e| ImportError::io(path, e);
    let mut reader = ImageReader::open(path)
        .map_err(io)?
        // By its content, whatever the file is called.
        .with_guessed_format()
        .map_err(io)?;
    reader.limits(limits);
    reader.decode().map_err(|source| ImportError::Image {
        path: path.to_owned(),
        source,
    })
}

/// Averages blocks of texels until no side is longer than allowed. Transparent texels add no
/// colour.
fn shrink(texture: &Texture) -> Texture {
    let factor = texture
        .width
        .max(texture.height)
        .div_ceil(MAX_TEXELS_A_SIDE);
    if factor <= 1 {
        return texture.clone();
    }
    let (width, height) = (
        (texture.width / factor).max(1),
        (texture.height / factor).max(1),
    );
    let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            rgba.extend(block_mean(texture, x * factor, y * factor, factor));
        }
    }
    Texture {
        width,
        height,
        rgba: rgba.into(),
    }
}

fn block_mean(texture: &Texture, x0: u32, y0: u32, factor: u32) -> [u8; 4] {
    let (columns, rows) = (
        factor.min(texture.width - x0),
        factor.min(texture.height - y0),
    );
    let mut sums = [0u64; 4];
    for y in y0..y0 + rows {
        let start = 4 * (y as usize * texture.width as usize + x0 as usize);
        for texel in texture.rgba[start..start + 4 * columns as usize].chunks_exact(4) {
            let alpha = u64::from(texel[3]);
            for (sum, value) in sums.iter_mut().zip(&texel[..3]) {
                *sum += u64::from(*value) * alpha;
            }
            sums[3] += alpha;
        }
    }
    let alpha = sums[3];
    // Rounded to the nearest; a block that is wholly transparent has no colour.
    let color = |sum: u64| (sum + alpha / 2).checked_div(alpha).unwrap_or(0) as u8;
    let count = u64::from(columns) * u64::from(rows);
    [
        color(sums[0]),
        color(sums[1]),
        color(sums[2]),
        ((alpha + count / 2) / count) as u8,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_do_not_darken_their_neighbours() {
        let mut rgba = vec![0u8; 4 * 2048 * 2];
        rgba.chunks_exact_mut(4)
            .step_by(2)
            .for_each(|t| t.copy_from_slice(&[200, 100, 50, 255]));
        let small = shrink(&Texture {
            width: 2048,
            height: 2,
            rgba: rgba.into(),
        });
        assert_eq!((small.width, small.height), (1024, 1));
        assert_eq!(small.rgba[..4], [200, 100, 50, 128]);
    }

    #[test]
    fn a_broken_image_is_an_error_with_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bad.png");
        std::fs::write(&path, b"\x89PNG\r\n\x1a\nnothing").unwrap();
        let error = Images::default()
            .load(&mut SceneBuilder::new(), &path)
            .unwrap_err()
            .to_string();
        assert!(error.contains("bad.png"), "{error}");
    }
}
