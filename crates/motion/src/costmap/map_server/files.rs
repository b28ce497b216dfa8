//! Reading and writing the two files of a grid.

use std::io::Read;
use std::path::{Path, PathBuf};

use openbench_osm::write_atomically;

use super::description::{Description, Mode, describe};
use super::error::{MOST_PIXELS, MapServerError};
use super::occupancy::Occupancy;
use super::pixels::{decode, encode};

/// Longest description that is read, bytes.
const LONGEST_DESCRIPTION: u64 = 64 * 1024;
/// Largest image file that is read, bytes.
const LARGEST_IMAGE: u64 = 256 << 20;

/// Reads a description and its image.
pub fn read(path: &Path) -> Result<Occupancy, MapServerError> {
    let text = String::from_utf8_lossy(&bytes(path, LONGEST_DESCRIPTION)?).into_owned();
    let description = describe(&text, path)?;
    let image = path
        .parent()
        .unwrap_or(Path::new(""))
        .join(&description.image);
    decode(&description, &bytes(&image, LARGEST_IMAGE)?, &image)
}

/// Writes a grid as `path` and an image of the same name with `.pgm` beside it (`trinary`: a cell
/// that is neither free nor unknown counts as occupied from 65 on). Each file is either written as
/// a whole or left as it was.
pub fn write(path: &Path, occupancy: &Occupancy) -> Result<(), MapServerError> {
    let grid = &occupancy.grid;
    let sides = 1..=MOST_PIXELS as usize;
    let fits = sides.contains(&grid.width) && sides.contains(&grid.height);
    if !fits || grid.len() != occupancy.cells.len() {
        let (width, height, cells) = (grid.width, grid.height, occupancy.cells.len());
        return Err(MapServerError::Shape {
            width,
            height,
            cells,
        });
    }
    let image = path.with_extension("pgm");
    if image == path {
        return Err(MapServerError::SameName { path: image });
    }
    let description = Description {
        image: image.file_name().map(PathBuf::from).unwrap_or_default(),
        resolution: grid.cell,
        origin: vec![grid.origin.x, grid.origin.y, occupancy.yaw],
        negate: false,
        // As ROS's map saver writes them. Grey 205 has p = 0.1961: just not free.
        occupied_thresh: 0.65,
        free_thresh: 0.196,
        mode: Mode::Trinary,
    };
    description.check(path)?;
    let pgm = encode(occupancy, &image)?;
    let yaml = serde_saphyr::to_string(&description).map_err(|source| MapServerError::Yaml {
        path: path.to_owned(),
        source: Box::new(source),
    })?;
    // The image first: no description may name an image that is not there.
    write_atomically(&image, &pgm)?;
    write_atomically(path, yaml.as_bytes())?;
    Ok(())
}

/// The bytes of a file that has `most` at most.
fn bytes(path: &Path, most: u64) -> Result<Vec<u8>, MapServerError> {
    let failed = |source| MapServerError::Read {
        path: path.to_owned(),
        source,
    };
    // Before it is opened: opening a pipe may wait for ever.
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(MapServerError::NotAFile {
            path: path.to_owned(),
        });
    }
    let file = std::fs::File::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    // One byte more shows that a file is too long, without reading all of it.
    file.take(most + 1)
        .read_to_end(&mut bytes)
        .map_err(failed)?;
    if bytes.len() as u64 > most {
        return Err(MapServerError::TooLong {
            path: path.to_owned(),
            most,
        });
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::MapPoint;
    use openbench_geometry::grid::GridGeometry;
    use proptest::prelude::*;

    const CELL: GridGeometry = GridGeometry {
        origin: MapPoint::new(0.0, 0.0),
        width: 1,
        height: 1,
        cell: 0.1,
    };

    fn sound() -> Occupancy {
        Occupancy {
            grid: CELL,
            yaw: 0.0,
            cells: vec![Occupancy::FREE],
        }
    }

    proptest! {
        #[test]
        fn a_written_grid_is_read_again(
            width in 1..20_usize,
            values in prop::collection::vec(prop::sample::select(vec![-1_i8, 0, 100]), 1..200),
            x in -1e4..1e4_f64,
        ) {
            let height = values.len().div_ceil(width);
            let mut cells = values;
            cells.resize(width * height, 0);
            let origin = MapPoint::new(x, -x / 3.0);
            let grid = GridGeometry { origin, width, height, cell: 0.05 };
            let occupancy = Occupancy { grid, yaw: 0.0, cells };
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("ground.yaml");
            write(&path, &occupancy).unwrap();
            prop_assert_eq!(read(&path).unwrap(), occupancy);
        }
    }

    #[test]
    fn a_grid_without_cells_is_not_written() {
        let empty = Occupancy {
            grid: GridGeometry { width: 0, ..CELL },
            yaw: 0.0,
            cells: vec![],
        };
        let refused = write(Path::new("never.yaml"), &empty);
        assert!(matches!(refused, Err(MapServerError::Shape { .. })));
    }

    #[test]
    fn a_grid_that_could_not_be_read_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("never.yaml");
        let of_cells = |cell: f64| Occupancy {
            grid: GridGeometry { cell, ..CELL },
            ..sound()
        };
        let broken = [
            ("resolution", of_cells(0.0)),
            ("resolution", of_cells(f64::NAN)),
            (
                "origin",
                Occupancy {
                    yaw: f64::INFINITY,
                    ..sound()
                },
            ),
        ];
        for (key, occupancy) in broken {
            let error = write(&path, &occupancy).unwrap_err().to_string();
            assert!(error.contains(key), "{error}");
        }
        let error = write(&folder.path().join("never.pgm"), &sound())
            .unwrap_err()
            .to_string();
        assert!(error.contains("`.yaml`"), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        write(&path, &sound()).unwrap();
    }

    #[test]
    fn a_file_that_cannot_be_read_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let missing = read(&folder.path().join("ground.yaml")).unwrap_err();
        assert!(missing.to_string().contains("ground.yaml"), "{missing}");
        assert!(matches!(
            read(folder.path()),
            Err(MapServerError::NotAFile { .. })
        ));
    }
}
