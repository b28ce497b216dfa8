//! Shapes from grey images: heightmaps, and images whose dark pixels are extruded as boxes.
//!
//! As in Gazebo Classic the first row of an image is the northernmost. The brightest pixel of a
//! heightmap is as high as its `<size>`, and dark pixels are solid.

use nalgebra::{Point3, Vector3};

use super::forms;
use super::images::Grey;
use super::mesh::Part;
use super::sdf::{Heightmap, ImageShape};
use crate::scene::Corner;

/// Most boxes of one image.
// Of twelve triangles each.
pub(crate) const MAX_BOXES: usize = 100_000;

/// The surface of a heightmap: a square between each four pixels, as two triangles. Texture
/// coordinates are in repeats of `tile` metres.
pub(crate) fn surface(image: &Grey, shape: &Heightmap, tile: f64) -> Part {
    let brightest = image.values.iter().copied().fold(0.0, f32::max);
    // A black image is level.
    let scale = if brightest > 0.0 {
        shape.size.z / f64::from(brightest)
    } else {
        0.0
    };
    // Not divided by zero: `read_grey` refuses images of fewer than two pixels a side.
    let step = |pixels: usize, metres: f64| metres / (pixels - 1) as f64;
    let (dx, dy) = (
        step(image.width, shape.size.x),
        step(image.height, shape.size.y),
    );
    let mut part = Part::default();
    for row in 0..image.height {
        for column in 0..image.width {
            let x = column as f64 * dx - shape.size.x / 2.0;
            let y = shape.size.y / 2.0 - row as f64 * dy;
            let z = f64::from(image.values[row * image.width + column]) * scale;
            let at = Point3::new(x, y, z) + shape.position;
            let uv = [(x / tile) as f32, (y / tile) as f32];
            part.corners.push(Corner::new(at, uv));
        }
    }
    let width = image.width as u32;
    for row in 0..image.height as u32 - 1 {
        for column in 0..width - 1 {
            let north = row * width + column;
            let south = north + width;
            part.triangles
                // Counter-clockwise seen from above.
                .extend([[south, south + 1, north + 1], [south, north + 1, north]]);
        }
    }
    part
}

/// Boxes on the dark pixels of an image, whose middle is the origin; `None` if there are more than
/// [`MAX_BOXES`].
pub(crate) fn boxes(image: &Grey, shape: &ImageShape) -> Option<Part> {
    let mut part = Part::default();
    let rectangles = dark_rectangles(image, shape.threshold);
    if rectangles.len() > MAX_BOXES {
        return None;
    }
    // Rows run southwards, y northwards: hence the signs of both middles.
    let (half_width, half_height) = (image.width as f64 / 2.0, image.height as f64 / 2.0);
    for Pixels { columns, rows } in rectangles {
        let side = |pixels: &std::ops::Range<usize>| pixels.len() as f64 * shape.scale;
        let size = Vector3::new(side(&columns), side(&rows), shape.height);
        let middle = Vector3::new(
            ((columns.start + columns.end) as f64 / 2.0 - half_width) * shape.scale,
            (half_height - (rows.start + rows.end) as f64 / 2.0) * shape.scale,
            shape.height / 2.0,
        );
        let cuboid = forms::cuboid(size, None);
        let base = part.corners.len() as u32;
        let moved = |corner: Corner| Corner::new(corner.position + middle, corner.uv);
        part.corners.extend(cuboid.corners.into_iter().map(moved));
        part.triangles
            .extend(cuboid.triangles.into_iter().map(|t| t.map(|i| base + i)));
    }
    Some(part)
}

/// A rectangle of pixels.
#[derive(Debug, Clone, PartialEq)]
struct Pixels {
    columns: std::ops::Range<usize>,
    rows: std::ops::Range<usize>,
}

/// The dark pixels in few rectangles: runs along rows; equal runs in neighbouring rows are joined.
fn dark_rectangles(image: &Grey, threshold: f32) -> Vec<Pixels> {
    let (mut done, mut open): (Vec<Pixels>, Vec<Pixels>) = (Vec::new(), Vec::new());
    for row in 0..image.height {
        let pixels = &image.values[row * image.width..][..image.width];
        // Both rows run from west to east.
        let mut above = std::mem::take(&mut open).into_iter().peekable();
        let mut column = 0;
        for run in pixels.chunk_by(|a, b| (*a <= threshold) == (*b <= threshold)) {
            let columns = column..column + run.len();
            column = columns.end;
            if run[0] > threshold {
                continue;
            }
            // Rectangles above that begin farther west have no equal run in this row.
            while let Some(ended) = above.next_if(|above| above.columns.start < columns.start) {
                done.push(ended);
            }
            let same = above.next_if(|above| above.columns == columns);
            let first = same.map_or(row, |above| above.rows.start);
            open.push(Pixels {
                columns,
                rows: first..row + 1,
            });
        }
        done.extend(above);
    }
    done.append(&mut open);
    // In an order that does not depend on how they were joined.
    done.sort_by_key(|pixels| (pixels.rows.start, pixels.columns.start));
    done
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: usize, values: &[f32]) -> Grey {
        Grey {
            width,
            height: values.len() / width,
            values: values.to_vec(),
        }
    }

    #[test]
    fn a_heightmap_is_as_high_as_its_size_and_faces_up() {
        let shape = Heightmap {
            uri: String::new(),
            size: Vector3::new(8.0, 4.0, 3.0),
            position: Vector3::new(1.0, 0.0, -1.0),
            texture: None,
        };
        let part = surface(&grey(3, &[0.0, 0.1, 0.5, 0.0, 0.0, 0.0]), &shape, 2.0);
        let at = |i: u32| part.corners[i as usize].position;
        assert_eq!(
            at(0),
            Point3::new(-3.0, 2.0, -1.0),
            "the first pixel is in the north-west"
        );
        assert_eq!(
            at(2),
            Point3::new(5.0, 2.0, 2.0),
            "the brightest is 3 m high"
        );
        assert_eq!(part.triangles.len(), 4);
        for [a, b, c] in &part.triangles {
            assert!((at(*b) - at(*a)).cross(&(at(*c) - at(*a))).z > 0.0);
        }
    }

    #[test]
    fn dark_pixels_become_few_boxes() {
        // An L, and a pixel apart.
        let image = grey(
            4,
            &[0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0],
        );
        let found = dark_rectangles(&image, 0.5);
        assert_eq!(found.len(), 3, "{found:?}");
        let covered: usize = found.iter().map(|p| p.columns.len() * p.rows.len()).sum();
        assert_eq!(covered, 5);
        let shape = ImageShape {
            uri: String::new(),
            scale: 0.5,
            threshold: 0.5,
            height: 2.0,
        };
        let part = boxes(&image, &shape).unwrap();
        let highest = part
            .corners
            .iter()
            .map(|c| c.position.z)
            .fold(0.0, f64::max);
        let west = part
            .corners
            .iter()
            .map(|c| c.position.x)
            .fold(0.0, f64::min);
        assert_eq!((part.triangles.len(), highest, west), (3 * 12, 2.0, -1.0));
        let checked: Vec<f32> = (0..640 * 640)
            .map(|i| ((i % 640 + i / 640) % 2) as f32)
            .collect();
        assert!(boxes(&grey(640, &checked), &shape).is_none());
    }
}
