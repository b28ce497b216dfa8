//! Encoding of images as JPEG and PNG.

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};
use openbench_core::Image;

/// JPEG quality of images in logs and reports, 1 to 100.
const DEFAULT_QUALITY: u8 = 85;

/// Encodes an image as JPEG with the quality of logs and reports, 85.
///
/// # Errors
/// A size that JPEG does not support, or pixels that do not match the size.
pub fn jpeg(image: &Image) -> Result<Vec<u8>, ImageError> {
    jpeg_of_quality(image, DEFAULT_QUALITY)
}

/// Encodes an image as JPEG with a quality from 1 to 100.
///
/// # Errors
/// As [`jpeg`].
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

/// Encodes an image as PNG.
///
/// # Errors
/// Pixels that do not match the size.
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

/// Encodes a 16-bit grey image, rows from top to bottom, as PNG.
///
/// # Errors
/// Pixels that do not match the size.
pub fn grey16_png(width: u32, height: u32, pixels: &[u16]) -> Result<Vec<u8>, ImageError> {
    // `write_image` takes samples in the byte order of this machine. The encoder converts them to
    // that of PNG.
    let native: Vec<u8> = pixels.iter().flat_map(|p| p.to_ne_bytes()).collect();
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(&native, width, height, ExtendedColorType::L16)?;
    Ok(bytes)
}
