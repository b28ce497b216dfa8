//! Number plates: dark capitals on white, drawn with DejaVu Sans Condensed Bold.
//!
//! A plate is 1.0 x 0.45 m with capitals 0.25 m high: a camera with a focal length of 381 pixels
//! sees them 10 pixels high from 10 m away. Long texts are made narrower, not lower.

use std::sync::OnceLock;

use fontdue::{Font, FontSettings};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use openbench_core::Pose3;

use crate::plates::Extent;
use crate::scene::Layer;
use crate::{Material, MaterialId, SceneBuilder, SemanticClass, Texture};

/// Width of a plate, metres.
pub const PLATE_WIDTH_M: f64 = 1.0;
/// Height of a plate, metres.
pub const PLATE_HEIGHT_M: f64 = 0.45;
/// Height of the capitals on it, metres.
pub const CAPITAL_HEIGHT_M: f64 = 0.25;

/// The text of a plate: the plate without its margins, and the height of the capitals.
pub const USUAL_LETTERING: Extent = Extent {
    width_m: PLATE_WIDTH_M - 0.1,
    height_m: CAPITAL_HEIGHT_M,
};

/// Distance of the face in front of the pose, metres.
const FACE_M: f64 = 0.03;
/// Distance of the back in front of the pose, metres: it is behind it.
const BACK_M: f64 = -0.01;
/// A capital is 80 texels high: at 2 m from the robot's camera a texel is smaller than a pixel.
const TEXELS_A_METRE: u32 = 320;
/// Size of the image of a plate, texels.
// `PLATE_WIDTH_M` and `PLATE_HEIGHT_M` times `TEXELS_A_METRE`.
const WIDTH: usize = 320;
const HEIGHT: usize = 144;
/// Width of the border line, texels.
const BORDER: usize = 3;
/// Space between the border of the image and the text, texels.
const MARGIN: usize = 17;
/// Glyphs are drawn this many times larger and averaged down.
const OVERSAMPLING: usize = 4;
/// Characters that are drawn at most.
const LONGEST_TEXT: usize = 64;
/// Width of a space, in spaces of the font: narrower, so that letters can be wider.
const SPACE: f32 = 0.7;
const PAPER: [u8; 3] = [248, 248, 244];
const INK: [u8; 3] = [12, 12, 16];

/// The image of a plate with `text` on it.
pub fn plate_texture(text: &str) -> Texture {
    let line = draw_line(text);
    let coverage = squeeze(&line, WIDTH - 2 * MARGIN);
    let mut rgba = Vec::with_capacity(4 * WIDTH * HEIGHT);
    let top = (HEIGHT - coverage.height) / 2;
    let left = (WIDTH - coverage.width) / 2;
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            let border = x < BORDER || y < BORDER || x >= WIDTH - BORDER || y >= HEIGHT - BORDER;
            let ink = if border {
                1.0
            } else {
                // Left of the text and above it the difference wraps to a huge number, which is
                // outside too.
                coverage.at(x.wrapping_sub(left), y.wrapping_sub(top))
            };
            rgba.extend((0..3).map(|c| mix(PAPER[c], INK[c], ink)));
            rgba.push(255);
        }
    }
    Texture {
        width: WIDTH as u32,
        height: HEIGHT as u32,
        rgba: rgba.into(),
    }
}

/// Adds a plate that stands 3 cm out. `pose` is the middle of the surface behind it: the text runs
/// along the pose's x and faces its +y, and z is up.
pub fn add_plate(builder: &mut SceneBuilder, text: &str, pose: &Pose3) {
    let face = plate_material(builder, text);
    hang_plate(builder, face, pose, FACE_M);
}

/// A material with the image of a plate, for several plates with one text.
pub(crate) fn plate_material(builder: &mut SceneBuilder, text: &str) -> MaterialId {
    let texture = builder.texture(plate_texture(text));
    builder.material(Material::plain(SemanticClass::Plate, [1.0; 3]).with_texture(texture))
}

/// Adds a plate as [`add_plate`] does, with an existing `face`, `out` metres in front of `pose`.
pub(crate) fn hang_plate(builder: &mut SceneBuilder, face: MaterialId, pose: &Pose3, out: f64) {
    let edge = builder.material(Material::plain(SemanticClass::Plate, [0.35; 3]));
    let (x, z) = (PLATE_WIDTH_M / 2.0, PLATE_HEIGHT_M / 2.0);
    let (right, up, deep) = (
        -2.0 * x * Vector3::x(),
        2.0 * z * Vector3::z(),
        (out - BACK_M) * Vector3::y(),
    );
    // A reader of the plate looks along -y and has +x on the left.
    let sides = [
        (face, Vector3::new(x, out, -z), right, up),
        (edge, Vector3::new(-x, BACK_M, -z), -right, up),
        (edge, Vector3::new(x, BACK_M, -z), deep, up),
        (edge, Vector3::new(-x, out, -z), -deep, up),
        (edge, Vector3::new(-x, BACK_M, z), -right, deep),
        (edge, Vector3::new(-x, out, -z), -right, -deep),
    ];
    for (material, corner, u, v) in sides {
        builder.rectangle(
            Layer::Visible,
            material,
            pose * Point3::from(corner),
            pose.rotation * u,
            pose.rotation * v,
            [1.0; 2],
        );
    }
}

/// The pose of a plate with its middle at `middle` that faces `facing` (radians, counter-clockwise
/// from east).
pub fn plate_pose(middle: [f64; 3], facing: f64) -> Pose3 {
    let turn =
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), facing - std::f64::consts::FRAC_PI_2);
    Pose3::from_parts(Vector3::from(middle).into(), turn)
}

/// Share of ink in each texel, 0 to 1.
struct Coverage {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Coverage {
    fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            values: vec![0.0; width * height],
        }
    }

    /// Nothing outside.
    fn at(&self, x: usize, y: usize) -> f32 {
        if x < self.width && y < self.height {
            self.values[y * self.width + x]
        } else {
            0.0
        }
    }
}

fn font() -> &'static Font {
    static FONT: OnceLock<Font> = OnceLock::new();
    FONT.get_or_init(|| {
        let settings = FontSettings {
            load_substitutions: false,
            ..FontSettings::default()
        };
        Font::from_bytes(dejavu::sans_condensed::bold(), settings)
            .expect("the embedded font is sound")
    })
}

/// The text in one line, oversampled, as wide as its own ink. It is as high as the capitals with
/// what hangs below them, so that capitals are in the middle of the plate.
fn draw_line(text: &str) -> Coverage {
    let font = font();
    let capital = CAPITAL_HEIGHT_M as f32 * (TEXELS_A_METRE as usize * OVERSAMPLING) as f32;
    // A font's size is not the height of its capitals: it is scaled by that of an H.
    let px = capital * 1000.0 / font.metrics('H', 1000.0).height as f32;
    // A plate cannot show more; memory must not grow with what a map says.
    let text: String = text.chars().take(LONGEST_TEXT).collect();
    let height = capital as usize;
    let mut glyphs = Vec::new();
    let mut pen = 0.0f32;
    for c in text.chars() {
        let (metrics, bitmap) = font.rasterize(c, px);
        if c == ' ' {
            pen += metrics.advance_width * SPACE;
            continue;
        }
        glyphs.push((
            (pen + metrics.xmin as f32).max(0.0) as usize,
            metrics,
            bitmap,
        ));
        pen += metrics.advance_width;
    }
    let right = glyphs
        .iter()
        .map(|(x, m, _)| x + m.width)
        .max()
        .unwrap_or(1);
    let mut line = Coverage::new(right.max(1), height);
    for (left, metrics, bitmap) in &glyphs {
        let top = height as i32 - metrics.ymin - metrics.height as i32;
        for (i, value) in bitmap.iter().enumerate() {
            let y = top + (i / metrics.width) as i32;
            if let Some(row) = usize::try_from(y).ok().filter(|y| *y < height) {
                let cell = &mut line.values[row * right + left + i % metrics.width];
                // Boxes of neighbouring glyphs may overlap.
                *cell = cell.max(f32::from(*value) / 255.0);
            }
        }
    }
    line
}

/// Averages an oversampled line, and narrows it until it is no wider than `limit` texels.
fn squeeze(line: &Coverage, limit: usize) -> Coverage {
    let width = line.width.div_ceil(OVERSAMPLING).min(limit);
    let mut small = Coverage::new(width, line.height / OVERSAMPLING);
    let step = line.width as f32 / width as f32;
    for y in 0..small.height {
        for x in 0..width {
            let from = (x as f32 * step) as usize;
            let to = ((x + 1) as f32 * step) as usize;
            // One column at least, also where nothing is narrowed.
            let columns = from..to.max(from + 1);
            let rows = y * OVERSAMPLING..(y + 1) * OVERSAMPLING;
            let count = (columns.len() * rows.len()) as f32;
            let sum: f32 = rows
                .flat_map(|r| columns.clone().map(move |c| (c, r)))
                .map(|(c, r)| line.at(c, r))
                .sum();
            small.values[y * width + x] = sum / count;
        }
    }
    small
}

fn mix(paper: u8, ink: u8, share: f32) -> u8 {
    (f32::from(paper) * (1.0 - share) + f32::from(ink) * share + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dark(texture: &Texture, x: usize, y: usize) -> bool {
        texture.rgba[4 * (y * WIDTH + x)] < 100
    }

    fn ink_rows(texture: &Texture) -> Vec<usize> {
        (10..HEIGHT - 10)
            .filter(|y| (10..WIDTH - 10).any(|x| dark(texture, x, *y)))
            .collect()
    }

    #[test]
    fn capitals_are_a_quarter_of_a_metre_high_and_in_the_middle() {
        let rows = ink_rows(&plate_texture("UNIT 1"));
        let (first, last) = (rows[0], rows[rows.len() - 1]);
        let height = (last + 1 - first) as f64 / f64::from(TEXELS_A_METRE);
        assert!((height - CAPITAL_HEIGHT_M).abs() < 0.012, "{height}");
        assert!((first + last).abs_diff(HEIGHT - 1) <= 3, "{first} {last}");
    }

    #[test]
    fn long_texts_keep_their_height_and_stay_inside() {
        let plate = plate_texture("APARTMENT 112 B");
        assert!((76..=84).contains(&ink_rows(&plate).len()));
        let free = |x: usize| (10..HEIGHT - 10).all(|y| !dark(&plate, x, y));
        assert!((BORDER..MARGIN - 1).all(free) && (WIDTH - MARGIN + 1..WIDTH - BORDER).all(free));
    }

    #[test]
    fn texts_differ_and_odd_texts_do_not_panic() {
        assert_ne!(plate_texture("UNIT 1"), plate_texture("UNIT 2"));
        for text in ["", " ", "g", "\u{0}\u{1F4E6}", &"W".repeat(10_000)] {
            assert_eq!(plate_texture(text).rgba.len(), 4 * WIDTH * HEIGHT);
        }
    }

    #[test]
    fn the_face_looks_along_the_normal_and_reads_from_left_to_right() {
        let mut builder = SceneBuilder::new();
        add_plate(
            &mut builder,
            "UNIT 1",
            &plate_pose([5.0, 0.0, 2.0], std::f64::consts::PI),
        );
        let scene = builder.build();
        let [a, b, c, _] = [0, 1, 2, 3].map(|i| Vector3::from(scene.vertices[i].position));
        let normal = (b - a).cross(&(c - a)).normalize();
        assert!((normal + Vector3::x()).norm() < 1e-6, "{normal}");
        // Seen from the west, reading goes from north to south.
        assert!(a.y > 0.49 && b.y < -0.49 && scene.vertices[0].uv == [0.0, 0.0]);
        assert!(scene.solid.triangles.is_empty() && scene.triangles.len() == 12);
    }
}
