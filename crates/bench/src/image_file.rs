//! Images as files.

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};
use openbench_core::Image;

/// The image as JPEG of the quality that logs and reports have.
pub fn jpeg(image: &Image) -> Result<Vec<u8>, ImageError> {
    jpeg_of_quality(image, 85)
}

/// The image as JPEG, its quality 1 to 100.
pub fn jpeg_of_quality(image: &Image, quality: u8) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, quality).write_image(
        &image.rgb,
        image.width,
        image.height,
        ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}

/// The image as PNG.
pub fn png(image: &Image) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(
        &image.rgb,
        image.width,
        image.height,
        ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}

/// A grey image of 16 bits as PNG, rows from the top.
pub fn grey16_png((width, height): (u32, u32), pixels: &[u16]) -> Result<Vec<u8>, ImageError> {
    let native: Vec<u8> = pixels.iter().flat_map(|p| p.to_ne_bytes()).collect();
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(&native, width, height, ExtendedColorType::L16)?;
    Ok(bytes)
}
