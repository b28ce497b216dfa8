//! Grids as ROS's map server keeps them: an image (`.pgm`, or `.png`) and a `.yaml` file that says where it lies and what its greys mean.
//!
//! After the description of `map_server` in the ROS wiki and that of `nav2_map_server`: a pixel's lightness x gives the probability p = (255 - x) / 255 that its cell is occupied, or x / 255 if `negate` is set. `mode: trinary`
//! makes it occupied above `occupied_thresh`, free below `free_thresh`, and unknown between; `scale` grades what lies between in proportion, and what is not opaque is unknown; `raw` takes x itself where it is 100 at most. The first row of the image is the northernmost.

use std::io::Read;
use std::path::{Path, PathBuf};

use image::{ImageEncoder, ImageFormat, ImageReader};
use openbench_core::MapPoint;
use openbench_grid::GridGeometry;
use openbench_osm::write_atomically;
use serde::{Deserialize, Serialize};

/// Most pixels in a row or column.
const MOST_PIXELS: u32 = 10_000;
/// Longest description that is read, bytes.
const LONGEST: u64 = 64 * 1024;
/// Largest image file that is read, bytes.
const LARGEST: u64 = 256 << 20;
/// Greys that are written: free, occupied, unknown.
const GREYS: (u8, u8, u8) = (254, 0, 205);

/// A grid of what is known to be occupied (`nav_msgs/OccupancyGrid`).
#[derive(Debug, Clone, PartialEq)]
pub struct Occupancy {
    /// Its cells; where [`Occupancy::yaw`] is not zero the grid is turned about its origin.
    pub grid: GridGeometry,
    /// Direction of its rows, radians from east.
    pub yaw: f64,
    /// Row by row from the south: [`Occupancy::UNKNOWN`], or how surely something is there, from [`Occupancy::FREE`] to [`Occupancy::OCCUPIED`].
    pub cells: Vec<i8>,
}

impl Occupancy {
    /// Nothing is known.
    pub const UNKNOWN: i8 = -1;
    /// Nothing is there.
    pub const FREE: i8 = 0;
    /// From here on something is likely to be there.
    pub const LIKELY: i8 = 65;
    /// Something is there.
    pub const OCCUPIED: i8 = 100;
}

/// How greys are understood.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Occupied, free, or unknown.
    #[default]
    Trinary,
    /// From free to occupied, or unknown.
    Scale,
    /// As they are.
    Raw,
}

/// The `.yaml` file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// The image, as seen from the description's folder.
    pub image: PathBuf,
    /// Side of a cell, metres.
    pub resolution: f64,
    /// South-west corner in `map` and direction of the rows: metres, metres, radians.
    pub origin: Vec<f64>,
    /// Whether light means occupied.
    #[serde(default, with = "flag")]
    pub negate: bool,
    /// Probability from which on a cell is occupied.
    pub occupied_thresh: f64,
    /// Probability up to which it is free.
    pub free_thresh: f64,
    /// How greys are understood.
    #[serde(default)]
    pub mode: Mode,
}

/// Files of a map server cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum MapServerError {
    /// A file cannot be read or written, or is far too large.
    #[error("{}: {why}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        why: std::io::Error,
    },
    /// The description is not YAML, or lacks something.
    #[error("{}: {why}", path.display())]
    Description {
        /// Which.
        path: PathBuf,
        /// What is wrong, and in which line.
        why: Box<serde_saphyr::Error>,
    },
    /// A value that makes no sense.
    #[error("{}: `{key}` is {value}; {wanted}", path.display())]
    Value {
        /// Which file.
        path: PathBuf,
        /// Which value.
        key: &'static str,
        /// What it is.
        value: String,
        /// What it has to be.
        wanted: &'static str,
    },
    /// The image is none, or too large.
    #[error("{}: {why}", path.display())]
    Image {
        /// Which.
        path: PathBuf,
        /// What is wrong.
        why: image::ImageError,
    },
    /// The grid has no cells, or not as many as its sides say.
    #[error(
        "a grid of {width} by {height} cells with {cells} values cannot be written; give a value for each cell, and at most {MOST_PIXELS} in a row"
    )]
    Shape {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Values.
        cells: usize,
    },
}

/// Reads a description and its image.
pub fn read(path: &Path) -> Result<Occupancy, MapServerError> {
    let text = String::from_utf8_lossy(&bytes(path, LONGEST)?).into_owned();
    let description = describe(&text, path)?;
    let image = path.parent().unwrap_or(Path::new("")).join(&description.image);
    decode(&description, &bytes(&image, LARGEST)?, &image)
}

/// Writes a grid as `PATH` and an image beside it of the same name with `.pgm` (trinary: what is neither free nor unknown counts as occupied from 65 on). Each file is either written or left as it was.
pub fn write(path: &Path, occupancy: &Occupancy) -> Result<(), MapServerError> {
    let grid = &occupancy.grid;
    let most = MOST_PIXELS as usize;
    let fits = (1..=most).contains(&grid.width) && (1..=most).contains(&grid.height);
    if !fits || grid.len() != occupancy.cells.len() {
        let (width, height, cells) = (grid.width, grid.height, occupancy.cells.len());
        return Err(MapServerError::Shape { width, height, cells });
    }
    let image = path.with_extension("pgm");
    if image == path {
        return Err(written(path, "that is the name of the image; give one that ends in `.yaml`".to_owned()));
    }
    let description = Description {
        image: image.file_name().map(PathBuf::from).unwrap_or_default(),
        resolution: grid.cell,
        origin: vec![grid.origin.x, grid.origin.y, occupancy.yaw],
        negate: false,
        occupied_thresh: 0.65,
        free_thresh: 0.196,
        mode: Mode::Trinary,
    };
    check(&description, path)?;
    let rows = occupancy.cells.chunks_exact(grid.width).rev();
    let greys: Vec<u8> = rows.flatten().map(|value| grey(*value)).collect();
    let mut pgm = Vec::new();
    let encoder = image::codecs::pnm::PnmEncoder::new(&mut pgm)
        .with_subtype(image::codecs::pnm::PnmSubtype::Graymap(image::codecs::pnm::SampleEncoding::Binary));
    let (width, height) = (grid.width as u32, grid.height as u32);
    encoder
        .write_image(&greys, width, height, image::ExtendedColorType::L8)
        .map_err(|why| MapServerError::Image { path: image.clone(), why })?;
    let yaml = serde_saphyr::to_string(&description).map_err(|why| written(path, why.to_string()))?;
    write_atomically(&image, &pgm).map_err(|why| written(&image, why.to_string()))?;
    write_atomically(path, yaml.as_bytes()).map_err(|why| written(path, why.to_string()))
}

fn written(path: &Path, why: String) -> MapServerError {
    MapServerError::File { path: path.to_owned(), why: std::io::Error::other(why) }
}

fn bytes(path: &Path, most: u64) -> Result<Vec<u8>, MapServerError> {
    let failed = |why| MapServerError::File { path: path.to_owned(), why };
    // Before it is opened: what is no file may let one wait for ever.
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(failed(std::io::Error::other("it is no plain file")));
    }
    let file = std::fs::File::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    file.take(most + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > most {
        return Err(failed(std::io::Error::other(format!("it is longer than {most} bytes"))));
    }
    Ok(bytes)
}

/// Understands a description; `path` is for errors.
pub fn describe(text: &str, path: &Path) -> Result<Description, MapServerError> {
    let description: Description = serde_saphyr::from_str(text)
        .map_err(|why| MapServerError::Description { path: path.to_owned(), why: Box::new(why) })?;
    check(&description, path)?;
    Ok(description)
}

fn check(description: &Description, path: &Path) -> Result<(), MapServerError> {
    let wrong = |key: &'static str, value: String, wanted: &'static str| {
        Err(MapServerError::Value { path: path.to_owned(), key, value, wanted })
    };
    let Description { resolution, origin, occupied_thresh, free_thresh, .. } = description;
    if !(1e-4..=1e3).contains(resolution) {
        return wrong("resolution", resolution.to_string(), "give metres from 0.0001 to 1000");
    }
    if !(2..=3).contains(&origin.len()) || !origin.iter().all(|v| v.is_finite() && v.abs() < 1e7) {
        return wrong("origin", format!("{origin:?}"), "give x, y and yaw in metres and radians");
    }
    if !(0.0..=1.0).contains(occupied_thresh) {
        return wrong("occupied_thresh", occupied_thresh.to_string(), "give a probability");
    }
    if !(0.0..=*occupied_thresh).contains(free_thresh) {
        return wrong("free_thresh", free_thresh.to_string(), "give a probability below `occupied_thresh`");
    }
    Ok(())
}

/// Understands an image; `path` is for errors and says which kind of image it is.
pub fn decode(description: &Description, image: &[u8], path: &Path) -> Result<Occupancy, MapServerError> {
    let failed = |why| MapServerError::Image { path: path.to_owned(), why };
    let mut reader = ImageReader::new(std::io::Cursor::new(image));
    reader.set_format(ImageFormat::from_path(path).unwrap_or(ImageFormat::Pnm));
    let mut limits = image::Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MOST_PIXELS), Some(MOST_PIXELS));
    reader.limits(limits);
    let image = reader.decode().map_err(failed)?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    if width == 0 || height == 0 {
        return Err(MapServerError::Shape { width, height, cells: 0 });
    }
    let has_alpha = image.color().has_alpha();
    let image = image.to_rgba8();
    let origin = &description.origin;
    let grid = GridGeometry {
        origin: MapPoint::new(origin[0], origin[1]),
        width,
        height,
        cell: description.resolution,
    };
    let value = |p: &image::Rgba<u8>| description.value(lightness(p, has_alpha, description.mode), p.0[3]);
    let cells = image.rows().rev().flat_map(|row| row.map(value)).collect();
    Ok(Occupancy { grid, yaw: origin.get(2).copied().unwrap_or(0.0), cells })
}

/// Mean of a pixel's colours. As the map server has it, in `trinary` mode transparency counts as a colour.
fn lightness(pixel: &image::Rgba<u8>, has_alpha: bool, mode: Mode) -> f64 {
    let channels = if has_alpha && mode == Mode::Trinary { &pixel.0[..] } else { &pixel.0[..3] };
    channels.iter().map(|c| f64::from(*c)).sum::<f64>() / channels.len() as f64
}

impl Description {
    fn value(&self, light: f64, alpha: u8) -> i8 {
        let (occupied, free) = (self.occupied_thresh, self.free_thresh);
        let p = if self.negate { light / 255.0 } else { (255.0 - light) / 255.0 };
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
            Mode::Scale => (100.0 * (p - free) / (occupied - free).max(1e-9)).round().clamp(0.0, 100.0) as i8,
        }
    }
}

fn grey(value: i8) -> u8 {
    match value {
        Occupancy::FREE => GREYS.0,
        65.. => GREYS.1,
        1..=25 => GREYS.0,
        _ => GREYS.2,
    }
}

/// `negate` is written as 0 or 1, or as a boolean.
mod flag {
    use serde::{Deserialize, Deserializer, Serializer};

    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Flag {
        Number(i64),
        Boolean(bool),
    }

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
    pub(super) fn serialize<S: Serializer>(flag: &bool, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_i64(i64::from(*flag))
    }

    pub(super) fn deserialize<'a, D: Deserializer<'a>>(deserializer: D) -> Result<bool, D::Error> {
        match Flag::deserialize(deserializer)? {
            Flag::Number(number) => Ok(number != 0),
            Flag::Boolean(flag) => Ok(flag),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const YAML: &str = "image: a.pgm\nresolution: 0.1\norigin: [-2.0, 3.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

    fn description(more: &str) -> Result<Description, MapServerError> {
        describe(&format!("{YAML}{more}"), Path::new("a.yaml"))
    }

    fn decoded(more: &str, pgm: &[u8]) -> Vec<i8> {
        decode(&description(more).unwrap(), pgm, Path::new("a.pgm")).unwrap().cells
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
        assert_eq!(decode(&negated, text, Path::new("a.pgm")).unwrap().cells, [0, 100]);
    }

    #[test]
    fn what_makes_no_sense_is_told_with_its_key() {
        let broken = |from: &str, to: &str| {
            describe(&YAML.replace(from, to), Path::new("a.yaml")).unwrap_err().to_string()
        };
        assert!(broken("0.1\n", "-1\n").contains("`resolution` is -1"));
        assert!(broken("0.1\n", ".nan\n").contains("`resolution`"));
        assert!(broken("[-2.0, 3.0, 0.0]", "[1]").contains("`origin`"));
        assert!(broken("0.196", "0.9").contains("`free_thresh` is 0.9"));
        assert!(broken("resolution: 0.1\n", "").contains("resolution"));
        assert!(description("mode: other\n").is_err() && describe("[", Path::new("a.yaml")).is_err());
        let cut = decode(&description("").unwrap(), b"P5 9 9 255 x", Path::new("a.pgm"));
        assert!(matches!(cut, Err(MapServerError::Image { .. })));
        let vast = decode(&description("").unwrap(), b"P5 999999 999999 255 x", Path::new("a.pgm"));
        assert!(matches!(vast, Err(MapServerError::Image { .. })));
    }

    #[test]
    fn transparency_is_a_colour_or_means_unknown() {
        let decoded = |more: &str| {
            let mut png = Vec::new();
            let pixels = [0, 0, 0, 255, 0, 0, 0, 10, 255, 255, 255, 255, 255, 255, 255, 0];
            let encoder = image::codecs::png::PngEncoder::new(&mut png);
            encoder.write_image(&pixels, 4, 1, image::ExtendedColorType::Rgba8).unwrap();
            decode(&description(more).unwrap(), &png, Path::new("a.png")).unwrap().cells
        };
        // Black and opaque is 64 of 255 on the mean of four.
        assert_eq!(decoded(""), [100, 100, 0, -1]);
        assert_eq!(decoded("mode: scale\n"), [100, -1, 0, -1]);
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(width in 1..20_usize, values in prop::collection::vec(prop::sample::select(vec![-1_i8, 0, 100]), 1..200), x in -1e4..1e4_f64) {
            let height = values.len().div_ceil(width);
            let mut cells = values;
            cells.resize(width * height, 0);
            let grid = GridGeometry { origin: MapPoint::new(x, -x / 3.0), width, height, cell: 0.05 };
            let occupancy = Occupancy { grid, yaw: 0.0, cells };
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("ground.yaml");
            write(&path, &occupancy).unwrap();
            prop_assert_eq!(read(&path).unwrap(), occupancy);
        }

        #[test]
        fn nothing_that_is_read_panics(text in ".{0,200}", image in prop::collection::vec(any::<u8>(), 0..200), header in prop::sample::select(vec!["", "P5 3 2 255 ", "P2 3 2 255 ", "P6 2 2 65535 "])) {
            let path = Path::new("a.pgm");
            let _ = describe(&text, path);
            let _ = describe(&format!("{YAML}{text}"), path);
            let bytes = [header.as_bytes(), &image].concat();
            let _ = decode(&description("").unwrap(), &bytes, path);
        }
    }

    #[test]
    fn a_grid_without_cells_is_not_written() {
        let grid = GridGeometry { origin: MapPoint::default(), width: 0, height: 3, cell: 0.1 };
        let empty = Occupancy { grid, yaw: 0.0, cells: vec![] };
        assert!(matches!(write(Path::new("never.yaml"), &empty), Err(MapServerError::Shape { .. })));
    }

    #[test]
    fn what_could_not_be_read_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("never.yaml");
        let grid = GridGeometry { origin: MapPoint::default(), width: 1, height: 1, cell: 0.1 };
        let sound = Occupancy { grid, yaw: 0.0, cells: vec![Occupancy::FREE] };
        let broken = [
            ("resolution", Occupancy { grid: GridGeometry { cell: 0.0, ..grid }, ..sound.clone() }),
            ("resolution", Occupancy { grid: GridGeometry { cell: f64::NAN, ..grid }, ..sound.clone() }),
            ("origin", Occupancy { yaw: f64::INFINITY, ..sound.clone() }),
        ];
        for (key, occupancy) in broken {
            let error = write(&path, &occupancy).unwrap_err().to_string();
            assert!(error.contains(key), "{error}");
        }
        let error = write(&folder.path().join("never.pgm"), &sound).unwrap_err().to_string();
        assert!(error.contains("`.yaml`"), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        write(&path, &sound).unwrap();
    }
}
