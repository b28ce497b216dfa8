//! Images of door plates as the robot's camera takes them, drawn by ray casting onto one wall.
//!
//! The wall has bricks, a door, windows and a drainpipe, with ground in front and sky above. The
//! plate is 1.0 x 0.45 m with capitals 0.25 m high, as in the published worlds.

#![allow(dead_code)]

use openbench_core::{CameraIntrinsics, Distortion, Image, SimTime};
use openbench_models::{ModelStore, catalogue};
use openbench_vision::{PpOcr, PpOcrSettings};

/// Width and height of the plate, metres.
const PLATE_M: [f64; 2] = [1.0, 0.45];
/// Height of capitals, metres.
const CAPITAL_M: f64 = 0.25;
/// Resolution of the texture, pixels per metre.
const TEXELS_PER_M: f64 = 400.0;

/// The pose of the camera relative to the plate, and the quality of the image.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// Horizontal distance from the camera to the plate, metres.
    pub distance: f64,
    /// Horizontal angle between the normal of the plate and the direction to the camera, degrees.
    pub angle: f64,
    /// Height of the middle of the plate above the camera, metres.
    pub height: f64,
    /// Horizontal position of the plate in the image: 0 in the middle, -1 and 1 at the borders.
    pub sideways: f64,
    /// Number of rays along each side of a pixel: 1 gives jagged edges.
    pub rays: u32,
    /// Determines colours and clutter.
    pub seed: u64,
}

/// The texture of a plate: ink, 0 to 255.
pub struct Plate {
    ink: Vec<u8>,
    size: [usize; 2],
}

impl Plate {
    /// A plate with `text` in its middle, compressed if it is too wide.
    pub fn new(text: &str) -> Self {
        let font =
            fontdue::Font::from_bytes(dejavu::sans::bold(), fontdue::FontSettings::default())
                .unwrap();
        let size = [
            (PLATE_M[0] * TEXELS_PER_M) as usize,
            (PLATE_M[1] * TEXELS_PER_M) as usize,
        ];
        let capital = font.metrics('H', 1000.0).height as f32 / 1000.0;
        let pixels = (CAPITAL_M * TEXELS_PER_M) as f32 / capital;
        let length: f32 = text
            .chars()
            .map(|c| font.metrics(c, pixels).advance_width)
            .sum();
        let squeeze = (length / (0.92 * size[0] as f32)).max(1.0);
        let mut plate = Self {
            ink: vec![0; size[0] * size[1]],
            size,
        };
        let mut pen = (size[0] as f32 * squeeze - length) / 2.0;
        let baseline = (size[1] as f32 + capital * pixels) / 2.0;
        for letter in text.chars() {
            let (metrics, bitmap) = font.rasterize(letter, pixels);
            let top = baseline - metrics.height as f32 - metrics.ymin as f32;
            plate.stamp(
                &bitmap,
                metrics.width,
                [pen + metrics.xmin as f32, top],
                squeeze,
            );
            pen += metrics.advance_width;
        }
        plate
    }

    fn stamp(&mut self, bitmap: &[u8], width: usize, at: [f32; 2], squeeze: f32) {
        for (index, &ink) in bitmap.iter().enumerate() {
            let x = ((at[0] + (index % width) as f32) / squeeze) as usize;
            let y = (at[1] + (index / width) as f32) as usize;
            if x < self.size[0] && y < self.size[1] {
                let texel = &mut self.ink[y * self.size[0] + x];
                *texel = (*texel).max(ink);
            }
        }
    }

    /// Ink, 0 to 1, at `u` metres right and `v` metres above the middle; `None` outside the plate.
    fn ink_at(&self, u: f64, v: f64) -> Option<f64> {
        let (x, y) = (
            (u + PLATE_M[0] / 2.0) * TEXELS_PER_M,
            (PLATE_M[1] / 2.0 - v) * TEXELS_PER_M,
        );
        let inside = x >= 0.0 && y >= 0.0 && x < self.size[0] as f64 && y < self.size[1] as f64;
        inside.then(|| f64::from(self.ink[y as usize * self.size[0] + x as usize]) / 255.0)
    }
}

/// The plane of the wall: a point below the plate and the direction to the right, in `camera_link`.
struct Wall {
    foot: [f64; 2],
    right: [f64; 2],
}

impl Wall {
    fn new(view: &View, camera: &CameraIntrinsics) -> Self {
        let bearing = -libm::atan(view.sideways * libm::tan(camera.horizontal_fov / 2.0));
        let foot = [
            view.distance * libm::cos(bearing),
            view.distance * libm::sin(bearing),
        ];
        let turn = bearing + view.angle.to_radians();
        // At angle 0 the wall faces the camera, and both have the same direction to the right.
        Self {
            foot,
            right: [libm::sin(turn), -libm::cos(turn)],
        }
    }

    /// Where a ray, whose x is 1, meets the wall; `None` if it does not.
    fn hit(&self, ray: [f64; 3]) -> Option<Hit> {
        let normal = [self.right[1], -self.right[0]];
        let speed = ray[0] * normal[0] + ray[1] * normal[1];
        let t = (self.foot[0] * normal[0] + self.foot[1] * normal[1]) / speed;
        let along = (t * ray[0] - self.foot[0]) * self.right[0]
            + (t * ray[1] - self.foot[1]) * self.right[1];
        (speed.abs() > 1e-9 && t > 0.1).then_some(Hit { t, along })
    }
}

/// Where a ray meets the wall.
struct Hit {
    /// Distance in units of the ray.
    t: f64,
    /// Distance from the plate along the wall, metres.
    along: f64,
}

/// The robot's camera.
pub fn camera() -> CameraIntrinsics {
    CameraIntrinsics {
        width: 640,
        height: 480,
        horizontal_fov: 1.3963,
        distortion: Distortion::default(),
    }
}

/// The image of a plate, or of the wall without one.
pub fn picture(plate: Option<&Plate>, view: &View) -> Image {
    let camera = camera();
    let wall = Wall::new(view, &camera);
    let mut rgb = Vec::new();
    for index in 0..camera.width * camera.height {
        let (column, row) = (index % camera.width, index / camera.width);
        let mut sum = [0.0; 3];
        for sub in 0..view.rays * view.rays {
            let offset = |i: u32| (f64::from(i) + 0.5) / f64::from(view.rays);
            let ray = camera.ray(
                f64::from(column) + offset(sub % view.rays),
                f64::from(row) + offset(sub / view.rays),
            );
            let colour = colour_along(ray, plate, &wall, view);
            (0..3).for_each(|i| sum[i] += colour[i]);
        }
        let noise = (unit(view.seed ^ u64::from(index) << 20) - 0.5) * 6.0;
        rgb.extend(
            sum.map(|s| (s / f64::from(view.rays * view.rays) + noise).clamp(0.0, 255.0) as u8),
        );
    }
    Image {
        stamp: SimTime::default(),
        width: camera.width,
        height: camera.height,
        rgb,
    }
}

fn colour_along(ray: [f64; 3], plate: Option<&Plate>, wall: &Wall, view: &View) -> [f64; 3] {
    if let Some(Hit { t, along }) = wall.hit(ray) {
        let up = t * ray[2] - view.height;
        let above_ground = t * ray[2] + 0.3;
        if let Some(ink) = plate.and_then(|plate| plate.ink_at(along, up)) {
            return plate_colour(ink, view.seed);
        }
        if above_ground > 0.0 && above_ground < 6.0 {
            return wall_colour(along, above_ground, view);
        }
    }
    if ray[2] < 0.0 {
        ground_colour(ray, view.seed)
    } else {
        [150.0, 185.0, 225.0].map(|c| c - 60.0 * ray[2])
    }
}

fn plate_colour(ink: f64, seed: u64) -> [f64; 3] {
    let pairs = [
        ([250.0, 250.0, 245.0], [20.0, 20.0, 25.0]),
        ([20.0, 50.0, 140.0], [245.0, 245.0, 245.0]),
        ([235.0, 225.0, 180.0], [60.0, 30.0, 20.0]),
    ];
    let (ground, letters) = pairs[(seed % 3) as usize];
    std::array::from_fn(|i| ground[i] + (letters[i] - ground[i]) * ink)
}

fn wall_colour(along: f64, up: f64, view: &View) -> [f64; 3] {
    let door_at = 1.4
        * if view.seed.is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
    if (along - door_at).abs() < 0.5 && up < 2.1 {
        let panel = (along - door_at).abs() < 0.35 && (up - 1.5).abs() < 0.4;
        return if panel {
            [70.0, 90.0, 95.0]
        } else {
            [95.0, 55.0, 35.0]
        };
    }
    if (along + 2.2).abs() < 0.05 {
        return [110.0, 110.0, 115.0];
    }
    let (window_x, window_y) = ((along + 100.7).rem_euclid(2.4), (up - 2.9).rem_euclid(2.6));
    if window_x < 1.1 && window_y < 1.3 && up > 2.9 {
        let frame =
            !(0.06..=1.04).contains(&window_x) || window_y < 0.06 || (window_x - 0.55).abs() < 0.03;
        return if frame {
            [230.0, 230.0, 230.0]
        } else {
            [50.0, 70.0, 90.0].map(|c| c + 20.0 * window_y)
        };
    }
    brick(along, up, view.seed)
}

fn brick(along: f64, up: f64, seed: u64) -> [f64; 3] {
    let row = (up / 0.075).floor();
    let shifted = along / 0.22 + 0.5 * row.rem_euclid(2.0) + 1000.0;
    let mortar = (up / 0.075).fract() < 0.13 || shifted.fract() < 0.05;
    let tint = unit(seed ^ (row as i64 as u64) << 32 ^ shifted as u64) * 40.0;
    if mortar {
        [175.0, 170.0, 160.0]
    } else {
        [150.0 + tint, 80.0 + tint, 60.0 + tint]
    }
}

fn ground_colour(ray: [f64; 3], seed: u64) -> [f64; 3] {
    let t = -0.3 / ray[2];
    let (x, y) = (
        (t * ray[0] / 0.4 + 500.0).max(0.0),
        (t * ray[1] / 0.4 + 500.0).max(0.0),
    );
    let joint = x.fract() < 0.04 || y.fract() < 0.04;
    let tint = unit(seed ^ (x as u64) << 24 ^ y as u64) * 25.0;
    if joint { [90.0; 3] } else { [125.0 + tint; 3] }
}

/// A pseudo-random number from 0 to 1 (SplitMix64).
pub fn unit(seed: u64) -> f64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// A view from `distance` metres at `angle` degrees; `seed` determines the rest. The whole plate is
/// in the image.
pub fn view(distance: f64, angle: f64, rays: u32, seed: u64) -> View {
    let highest = (0.52 * distance - 0.3).min(2.1);
    let height = 0.5 * highest + 0.5 * highest * unit(seed * 3 + 1);
    let sideways = (unit(seed * 3 + 2) * 2.0 - 1.0) * (1.0 - 1.3 / distance).clamp(0.0, 0.7);
    View {
        distance,
        angle,
        height,
        sideways,
        rays,
        seed,
    }
}

/// Why a test that reads plates is skipped.
pub const NO_PPOCR: &str = "there are no files of PP-OCR; run `openbench models pull ppocr-v4`";

/// The reader of the robot, if its model files have been downloaded. The camera is level, so plates
/// are above the horizon.
pub fn ppocr() -> Option<PpOcr> {
    let store = ModelStore::from_environment().ok()?;
    let there = catalogue::named("ppocr-v4")
        .into_iter()
        .all(|file| store.contains(file));
    let settings = PpOcrSettings {
        upper_part: 0.6,
        ..PpOcrSettings::default()
    };
    there.then(|| PpOcr::from_store(&store).unwrap().with_settings(settings))
}
