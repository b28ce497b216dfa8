//! The image of a plate: board, rim, letters, screws, then dirt and glare.

use openbench_osm::draws::mix;

use super::design::{Color, Design, Make, Outline, Rim, Wear};
use super::lettering::Lettering;
use super::typefaces::{Style, Typeface, typefaces};
use super::wording::Line;
use crate::material::Texture;

/// Texels in the height of a capital of the largest line.
const CAPITAL_TEXELS: f64 = 40.0;
/// Texels in a metre at most, so that high letters take no more memory than today's plates.
const MOST_TEXELS_A_METRE: f64 = 640.0;
/// Texels in a metre at least: at 2 m from the robot's camera a texel is smaller than a pixel.
const LEAST_TEXELS_A_METRE: f64 = 320.0;

/// A width and a height, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// From left to right.
    pub width_m: f64,
    /// From bottom to top.
    pub height_m: f64,
}

/// A drawn plate.
#[derive(Debug, Clone)]
pub struct Face {
    /// Its image.
    pub texture: Texture,
    /// Size of the plate.
    pub size: Extent,
    /// Size of its text: all lines, and the capitals of the largest.
    pub text: Extent,
    /// Middle of the text above the middle of the plate, metres.
    pub text_above_m: f64,
    /// Whether parts of the image are holes.
    pub has_holes: bool,
}

/// Draws a plate with some lines of text, and names of people beside bells if it has any.
pub fn draw_face(design: &Design, lines: &[Line], names: &[&str], wear: Wear) -> Face {
    let design = &fitting(design, lines);
    let scale =
        (CAPITAL_TEXELS / design.capital_m).clamp(LEAST_TEXELS_A_METRE, MOST_TEXELS_A_METRE);
    let layout = Layout::new(design, lines, names, scale);
    let mut canvas = Canvas::new(layout.width, layout.height);
    let seed = design.grain;
    board(&mut canvas, design, seed);
    rim(&mut canvas, design);
    if design.make == Make::Cast {
        canvas.clear(design.ink);
    }
    for line in &layout.lines {
        letters(&mut canvas, line, design);
    }
    for bell in &layout.bells {
        draw_bell(&mut canvas, bell);
    }
    if design.screws {
        screws(&mut canvas, design);
    }
    cut(&mut canvas, design);
    dirt(&mut canvas, wear.dirt, seed);
    if let Some(middle) = wear.glare {
        glare(&mut canvas, middle);
    }
    let metres = |texels: usize| texels as f64 / scale;
    let middle = (layout.text_top + layout.text_bottom) as f64 / 2.0;
    Face {
        size: Extent {
            width_m: metres(layout.width),
            height_m: metres(layout.height),
        },
        text: Extent {
            width_m: metres(layout.text_width),
            height_m: design.capital_m,
        },
        text_above_m: (layout.height as f64 / 2.0 - middle) / scale,
        has_holes: canvas.has_holes(),
        texture: canvas.into_texture(),
    }
}

/// The design with letters so low that the widest line fits.
fn fitting(design: &Design, lines: &[Line]) -> Design {
    let width = |line: &Line| {
        let drawn = Lettering::draw(&line.text, face_for(design, &line.text), 20);
        drawn.width as f64 / 20.0 * line.size
    };
    let widest = lines.iter().map(width).fold(0.1, f64::max);
    let most = (design.widest_m - 0.1) / widest;
    let smallest = lines.iter().map(|line| line.size).fold(1.0, f64::min);
    let lowest = design.lowest_m / smallest;
    let capital_m = design.capital_m.min(most).max(lowest);
    design.with_capitals(capital_m)
}

pub(super) fn face_for(design: &Design, text: &str) -> &'static Typeface {
    let own = &typefaces()[design.typeface];
    // Any Chinese character: digits beside them are lettered alike.
    if own.style == Style::Chinese || text.chars().all(|c| c < '\u{3000}') {
        own
    } else {
        &typefaces()[design.chinese]
    }
}

/// A line of text at its place.
struct PlacedLine {
    drawn: Lettering,
    left: i32,
    /// Row in which its capitals begin.
    top: i32,
}

/// A bell: a button and a strip with a name.
struct Bell {
    name: Lettering,
    left: i32,
    top: i32,
    width: i32,
    height: i32,
}

/// Where everything is, texels.
struct Layout {
    width: usize,
    height: usize,
    lines: Vec<PlacedLine>,
    bells: Vec<Bell>,
    text_width: usize,
    text_top: usize,
    text_bottom: usize,
}

impl Layout {
    fn new(design: &Design, lines: &[Line], names: &[&str], scale: f64) -> Self {
        let capital = design.capital_m * scale;
        let drawn: Vec<Lettering> = lines
            .iter()
            .map(|line| {
                let height = (capital * line.size).max(4.0) as usize;
                Lettering::draw(&line.text, face_for(design, &line.text), height)
            })
            .collect();
        let text_width = drawn.iter().map(|line| line.width).max().unwrap_or(1);
        let margin = (capital * margin_of(design)) as usize;
        let bells = design.make == Make::Bells;
        let names = if bells { names } else { &[] };
        let strip = (0.03 * scale) as usize;
        let least_width = if bells { (0.17 * scale) as usize } else { 0 };
        let inner = text_width.max(least_width);
        let width = inner + 2 * margin;
        let gap = (capital * 0.35) as usize;
        let mut top = margin;
        let mut placed = Vec::new();
        for line in drawn {
            let rows = line.capital;
            placed.push(PlacedLine {
                left: (width - line.width) as i32 / 2,
                top: top as i32,
                drawn: line,
            });
            top += rows + gap;
        }
        let text_bottom = top.saturating_sub(gap).max(margin + 1);
        let mut y = text_bottom + gap;
        let mut rows = Vec::new();
        for name in names {
            let drawn = Lettering::draw(name, face_for(design, name), strip * 6 / 10);
            rows.push(Bell {
                name: drawn,
                left: margin as i32,
                top: y as i32,
                width: inner as i32,
                height: strip as i32,
            });
            y += strip * 14 / 10;
        }
        let bottom = if rows.is_empty() { text_bottom } else { y };
        Self {
            width,
            height: bottom + margin,
            lines: placed,
            bells: rows,
            text_width,
            text_top: margin,
            text_bottom,
        }
    }
}

/// Space around the text, in heights of a capital.
fn margin_of(design: &Design) -> f64 {
    match (design.make, design.outline) {
        (Make::Cast, _) => 0.15,
        (_, Outline::Oval) => 0.95,
        (Make::Acrylic | Make::Sticker, _) => 0.4,
        _ => 0.55,
    }
}

struct Canvas {
    width: usize,
    height: usize,
    texels: Vec<[f32; 4]>,
}

impl Canvas {
    fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            texels: vec![[0.0, 0.0, 0.0, 1.0]; width * height],
        }
    }

    /// Replaces each texel by what a function makes of its place and itself.
    fn map(&mut self, mut change: impl FnMut(i32, i32, [f32; 4]) -> [f32; 4]) {
        for (i, texel) in self.texels.iter_mut().enumerate() {
            let (x, y) = (i % self.width, i / self.width);
            *texel = change(x as i32, y as i32, *texel);
        }
    }

    /// Holes everywhere, in the colour of the letters: small images mix them.
    fn clear(&mut self, color: Color) {
        let [r, g, b] = color.map(f32::from);
        self.texels.fill([r, g, b, 0.0]);
    }

    fn has_holes(&self) -> bool {
        self.texels.iter().any(|texel| texel[3] < 0.5)
    }

    fn into_texture(self) -> Texture {
        let byte = |value: f32| value.clamp(0.0, 255.0) as u8;
        let bytes = |[r, g, b, a]: [f32; 4]| [byte(r), byte(g), byte(b), byte(a * 255.0)];
        Texture {
            width: self.width as u32,
            height: self.height as u32,
            rgba: self.texels.into_iter().flat_map(bytes).collect(),
        }
    }
}

/// A number from 0 to 1 for each place.
fn grain(x: i32, y: i32, seed: u64) -> f32 {
    let place = (u64::from(x as u32) << 32) | u64::from(y as u32);
    (mix(place ^ mix(seed)) >> 40) as f32 / (1 << 24) as f32
}

/// The same, smooth over `cell` texels.
fn cloud(x: i32, y: i32, cell: i32, seed: u64) -> f32 {
    let (i, j) = (x.div_euclid(cell), y.div_euclid(cell));
    let share = |place: i32| place.rem_euclid(cell) as f32 / cell as f32;
    let (u, v) = (share(x), share(y));
    let row = |j: i32| grain(i, j, seed) * (1.0 - u) + grain(i + 1, j, seed) * u;
    row(j) * (1.0 - v) + row(j + 1) * v
}

fn board(canvas: &mut Canvas, design: &Design, seed: u64) {
    let paper = design.paper.map(f32::from);
    let (width, height) = (canvas.width as f32, canvas.height as f32);
    canvas.map(|x, y, _| {
        let (u, v) = (x as f32 / width, y as f32 / height);
        let light = match design.make {
            // Domed: the upper edge looks at the sky.
            Make::Enamel => 1.06 - 0.12 * v,
            Make::Brass | Make::Steel | Make::Bells => {
                // Brushed from left to right, with the sky in it.
                let brushed = grain(x / 24, y, seed) * 0.05 + grain(x, y, seed) * 0.02;
                0.94 + brushed + 0.10 * (1.0 - (u + v - 0.9).abs())
            }
            Make::Stone => {
                0.88 + 0.22 * grain(x / 2, y / 2, seed) * grain(x, y, seed + 1) + 0.06 * u
            }
            Make::Wood => {
                let ring = cloud(x / 10, y, 3, seed) * 0.14 + cloud(x, y, 24, seed) * 0.06;
                0.90 + ring
            }
            Make::Tile => 0.98 + 0.03 * cloud(x, y, 9, seed),
            Make::Sticker | Make::Acrylic | Make::Cast => 1.0 - 0.03 * v,
        };
        let [r, g, b] = paper.map(|channel| channel * light);
        [r, g, b, 1.0]
    });
}

fn rim(canvas: &mut Canvas, design: &Design) {
    let (width, height) = (canvas.width as i32, canvas.height as i32);
    let unit = (height / 40).max(1);
    let bands: &[[i32; 2]] = match design.rim {
        Rim::None => &[],
        Rim::Single => &[[2, 4]],
        Rim::Double => &[[1, 3], [4, 5]],
    };
    let ink = design.ink.map(f32::from);
    canvas.map(|x, y, texel| {
        let depth = depth_in(design.outline, x, y, width, height) / unit as f32;
        let on = bands
            .iter()
            .any(|[from, to]| depth >= *from as f32 && depth < *to as f32);
        if on {
            [ink[0], ink[1], ink[2], texel[3]]
        } else {
            texel
        }
    });
}

/// Distance of a texel from the edge of an outline, texels; negative outside.
fn depth_in(outline: Outline, x: i32, y: i32, width: i32, height: i32) -> f32 {
    let (w, h) = (width as f32 / 2.0, height as f32 / 2.0);
    let (dx, dy) = ((x as f32 + 0.5 - w).abs(), (y as f32 + 0.5 - h).abs());
    match outline {
        Outline::Square => (w - dx).min(h - dy),
        Outline::Rounded => {
            let radius = 0.28 * h.min(w);
            let (cx, cy) = (dx - (w - radius), dy - (h - radius));
            if cx > 0.0 && cy > 0.0 {
                radius - libm::hypotf(cx, cy)
            } else {
                (w - dx).min(h - dy)
            }
        }
        Outline::Oval => (1.0 - libm::hypotf(dx / w, dy / h)) * h.min(w),
    }
}

fn letters(canvas: &mut Canvas, line: &PlacedLine, design: &Design) {
    let ink = design.ink.map(f32::from);
    let top = line.top - line.drawn.capital_top as i32;
    let ink_at = |x: i32, y: i32| line.drawn.at(x - line.left, y - top);
    // Lit from the upper left.
    let relief = match design.make {
        Make::Brass | Make::Stone => -0.5,
        Make::Cast | Make::Acrylic => 0.35,
        _ => 0.0,
    };
    canvas.map(|x, y, texel| {
        let share = ink_at(x, y);
        let slope = ink_at(x + 1, y + 1) - ink_at(x - 1, y - 1);
        if design.make == Make::Cast {
            let light = 1.0 + relief * slope * 0.5;
            let [r, g, b] = ink.map(|channel| channel * light);
            return [r, g, b, texel[3].max(share)];
        }
        let edge = relief * slope * 60.0;
        std::array::from_fn(|i| match i {
            3 => texel[3],
            _ => texel[i] + (ink[i] - texel[i]) * share + edge * (1.0 - share) * slope.abs(),
        })
    });
}

fn draw_bell(canvas: &mut Canvas, bell: &Bell) {
    let button = bell.height;
    let strip_right = bell.width - button - button / 3;
    let top = (bell.height - bell.name.capital as i32) / 2 - bell.name.capital_top as i32;
    canvas.map(|x, y, texel| {
        let (x, y) = (x - bell.left, y - bell.top);
        if !(0..bell.height).contains(&y) || !(0..bell.width).contains(&x) {
            return texel;
        }
        if x < strip_right {
            let ink = bell.name.at(x - button / 4, y - top);
            let value = 236.0 - 200.0 * ink;
            return [value, value, value * 0.97, 1.0];
        }
        let half = button as f32 / 2.0;
        let middle = bell.width as f32 - half;
        let away = libm::hypotf(x as f32 + 0.5 - middle, y as f32 + 0.5 - half) / half;
        match away {
            a if a < 0.55 => [206.0, 206.0, 202.0, 1.0],
            a if a < 0.8 => [70.0, 70.0, 72.0, 1.0],
            _ => texel,
        }
    });
}

fn screws(canvas: &mut Canvas, design: &Design) {
    let has_board = !matches!(design.make, Make::Cast | Make::Sticker | Make::Tile);
    if !has_board || design.outline == Outline::Oval {
        return;
    }
    let (width, height) = (canvas.width as i32, canvas.height as i32);
    let radius = (height / 28).clamp(2, 5);
    let inset = 3 * radius;
    canvas.map(|x, y, texel| {
        let near =
            |size: i32, place: i32| (place - inset).abs().min((size - 1 - place - inset).abs());
        let (dx, dy) = (near(width, x), near(height, y));
        let away = dx * dx + dy * dy;
        if away > radius * radius {
            return texel;
        }
        let slot = dx == dy;
        let value = if slot {
            60.0
        } else {
            150.0 - 6.0 * (dx + dy) as f32
        };
        [value, value, value * 0.96, texel[3]]
    });
}

/// Makes holes outside the outline.
fn cut(canvas: &mut Canvas, design: &Design) {
    if design.outline == Outline::Square {
        return;
    }
    let (width, height) = (canvas.width as i32, canvas.height as i32);
    canvas.map(|x, y, [r, g, b, a]| {
        let inside = depth_in(design.outline, x, y, width, height) >= 0.0;
        [r, g, b, if inside { a } else { 0.0 }]
    });
}

/// Dust everywhere, streaks of rain, chips at the edges.
fn dirt(canvas: &mut Canvas, amount: f64, seed: u64) {
    if amount <= 0.0 {
        return;
    }
    const DUST: [f32; 3] = [104.0, 92.0, 74.0];
    const RUST: [f32; 3] = [92.0, 52.0, 30.0];
    let amount = amount as f32;
    let (width, height) = (canvas.width as i32, canvas.height as i32);
    canvas.map(|x, y, texel| {
        let dust = cloud(x, y, 14, seed + 2) * cloud(x, y, 40, seed + 3);
        let streak = (cloud(x, 0, 5, seed + 4) - 0.55).max(0.0) * (y as f32 / height as f32);
        let share = (amount * (0.15 + 0.8 * dust + 1.6 * streak)).min(0.85);
        let edge = depth_in(Outline::Square, x, y, width, height) / height as f32;
        let chip = cloud(x, y, 7, seed + 5) > 1.15 - 0.5 * amount && edge < 0.12;
        let (over, share) = if chip { (RUST, 0.9) } else { (DUST, share) };
        std::array::from_fn(|i| match i {
            3 => texel[3],
            _ => texel[i] + (over[i] - texel[i]) * share,
        })
    });
}

/// The sun's reflection: a slanted streak that hides what is under it.
fn glare(canvas: &mut Canvas, middle: f64) {
    let (width, height) = (canvas.width as f32, canvas.height as f32);
    canvas.map(|x, y, texel| {
        let slanted = (x as f32 - 0.35 * (y as f32 - height / 2.0)) / width;
        let away = (slanted - middle as f32).abs() / 0.16;
        let share = (1.2 - away).clamp(0.0, 0.92);
        std::array::from_fn(|i| match i {
            3 => texel[3],
            _ => texel[i] + (255.0 - texel[i]) * share,
        })
    });
}
