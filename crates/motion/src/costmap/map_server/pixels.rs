//! The image of a grid: from grey levels to occupancy and back.

use std::io::Cursor;
use std::path::Path;

use image::{ImageEncoder, ImageFormat, ImageReader};
use openbench_core::MapPoint;
use openbench_geometry::grid::GridGeometry;

use super::description::{Description, Mode};
use super::error::{MOST_PIXELS, MapServerError};
use super::occupancy::Occupancy;

/// Grey level that is written for free cells.
const FREE_GREY: u8 = 254;
/// Grey level that is written for occupied cells.
const OCCUPIED_GREY: u8 = 0;
/// Grey level that is written for unknown cells.
const UNKNOWN_GREY: u8 = 205;
/// Up to this occupancy a cell is written as free.
const LIKELY_FREE: i8 = 25;

/// The grid of an image; `path` is for errors and says which kind of image it is.
pub fn decode(
    description: &Description,
    image: &[u8],
    path: &Path,
) -> Result<Occupancy, MapServerError> {
    let mut reader = ImageReader::new(Cursor::new(image));
    reader.set_format(ImageFormat::from_path(path).unwrap_or(ImageFormat::Pnm));
    // Before decoding: the header of a small file may claim a huge image.
    let mut limits = image::Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MOST_PIXELS), Some(MOST_PIXELS));
    reader.limits(limits);
    let image = reader.decode().map_err(|source| MapServerError::Image {
        path: path.to_owned(),
        source,
    })?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    if width == 0 || height == 0 {
        return Err(MapServerError::Shape {
            width,
            height,
            cells: 0,
        });
    }
    let has_alpha = image.color().has_alpha();
    // A grey pixel becomes three equal colours, so that one mean serves all kinds of images.
    let image = image.to_rgba8();
    let value = |pixel: &image::Rgba<u8>| {
        description.occupancy(lightness(pixel, has_alpha, description.mode), pixel.0[3])
    };
    let cells = image.rows().rev().flat_map(|row| row.map(value)).collect();
    let origin = &description.origin;
    let grid = GridGeometry {
        origin: MapPoint::new(origin[0], origin[1]),
        width,
        height,
        cell: description.resolution,
    };
    Ok(Occupancy {
        grid,
        yaw: origin.get(2).copied().unwrap_or(0.0),
        cells,
    })
}

/// The image of a grid as PGM, `trinary`. A cell that is neither free nor unknown counts as
/// occupied from [`Occupancy::LIKELY`] on.
pub(super) fn encode(occupancy: &Occupancy, path: &Path) -> Result<Vec<u8>, MapServerError> {
    use image::codecs::pnm::{PnmEncoder, PnmSubtype, SampleEncoding};
    let grid = &occupancy.grid;
    let rows = occupancy.cells.chunks_exact(grid.width).rev();
    let greys: Vec<u8> = rows.flatten().map(|value| grey(*value)).collect();
    let mut pgm = Vec::new();
    let encoder =
        PnmEncoder::new(&mut pgm).with_subtype(PnmSubtype::Graymap(SampleEncoding::Binary));
    let (width, height) = (grid.width as u32, grid.height as u32);
    encoder
        .write_image(&greys, width, height, image::ExtendedColorType::L8)
        .map_err(|source| MapServerError::Image {
            path: path.to_owned(),
            source,
        })?;
    Ok(pgm)
}

/// Mean of a pixel's colours, 0 to 255. As the map server has it, in `trinary` mode transparency
/// counts as a colour.
fn lightness(pixel: &image::Rgba<u8>, has_alpha: bool, mode: Mode) -> f64 {
    let with_alpha = has_alpha && mode == Mode::Trinary;
    let channels = if with_alpha {
        &pixel.0[..]
    } else {
        &pixel.0[..3]
    };
    channels.iter().map(|c| f64::from(*c)).sum::<f64>() / channels.len() as f64
}

impl Description {
    /// The occupancy that a pixel of a lightness (0 to 255) and opacity means.
    fn occupancy(&self, light: f64, alpha: u8) -> i8 {
        let (occupied, free) = (self.occupied_thresh, self.free_thresh);
        let p = if self.negate {
            light / 255.0
        } else {
            (255.0 - light) / 255.0
        };
        match self.mode {
            Mode::Raw => {
                if light.round() <= 100.0 {
                    light.round() as i8
                } else {
                    Occupancy::UNKNOWN
                }
            }
            Mode::Scale if alpha < 255 => Occupancy::UNKNOWN,
            _ if p > occupied => Occupancy::OCCUPIED,
            _ if p < free => Occupancy::FREE,
            Mode::Trinary => Occupancy::UNKNOWN,
            Mode::Scale => {
                // Both thresholds may be equal.
                let graded = 100.0 * (p - free) / (occupied - free).max(1e-9);
                graded.round().clamp(0.0, 100.0) as i8
            }
        }
    }
}

fn grey(value: i8) -> u8 {
    match value {
        Occupancy::LIKELY.. => OCCUPIED_GREY,
        Occupancy::FREE..=LIKELY_FREE => FREE_GREY,
        _ => UNKNOWN_GREY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::costmap::map_server::describe;
    use crate::costmap::map_server::description::tests::YAML;
    use proptest::prelude::*;

    fn description(more: &str) -> Description {
        describe(&format!("{YAML}{more}"), Path::new("a.yaml")).unwrap()
    }

    fn decoded(more: &str, pgm: &[u8]) -> Vec<i8> {
        decode(&description(more), pgm, Path::new("a.pgm"))
            .unwrap()
            .cells
    }

    #[test]
    fn greys_mean_what_the_mode_says_and_the_first_row_is_the_northernmost() {
        let pgm = b"P5\n# made by hand\n3 2\n255\n\x00\xcd\xfe\x64\x96\xff";
        assert_eq!(decoded("", pgm), [-1, -1, 0, 100, -1, 0]);
        assert_eq!(decoded("mode: scale\n", pgm)[..2], [91, 48]);
        assert_eq!(decoded("mode: raw\n", pgm), [100, -1, -1, 0, -1, -1]);
        let text = b"P2 2 1 255 0 255\n";
        let negated = YAML.replace("negate: 0", "negate: true");
        let negated = describe(&negated, Path::new("a.yaml")).unwrap();
        assert_eq!(
            decode(&negated, text, Path::new("a.pgm")).unwrap().cells,
            [0, 100]
        );
    }

    #[test]
    fn an_image_that_is_cut_off_or_too_large_is_refused() {
        for image in [&b"P5 9 9 255 x"[..], b"P5 999999 999999 255 x"] {
            let refused = decode(&description(""), image, Path::new("a.pgm"));
            assert!(matches!(refused, Err(MapServerError::Image { .. })));
        }
    }

    #[test]
    fn transparency_is_a_colour_or_means_unknown() {
        let decoded = |more: &str| {
            let mut png = Vec::new();
            let pixels = [
                0, 0, 0, 255, 0, 0, 0, 10, 255, 255, 255, 255, 255, 255, 255, 0,
            ];
            let encoder = image::codecs::png::PngEncoder::new(&mut png);
            encoder
                .write_image(&pixels, 4, 1, image::ExtendedColorType::Rgba8)
                .unwrap();
            decode(&description(more), &png, Path::new("a.png"))
                .unwrap()
                .cells
        };
        // Black and opaque is 64 of 255 on the mean of four.
        assert_eq!(decoded(""), [100, 100, 0, -1]);
        assert_eq!(decoded("mode: scale\n"), [100, -1, 0, -1]);
    }

    proptest! {
        #[test]
        fn no_bytes_make_the_reader_panic(
            text in ".{0,200}",
            image in prop::collection::vec(any::<u8>(), 0..200),
            header in prop::sample::select(vec!["", "P5 3 2 255 ", "P2 3 2 255 ", "P6 2 2 65535 "]),
        ) {
            let path = Path::new("a.pgm");
            let _ = describe(&text, path);
            let _ = describe(&format!("{YAML}{text}"), path);
            let bytes = [header.as_bytes(), &image].concat();
            let _ = decode(&description(""), &bytes, path);
        }
    }
}
