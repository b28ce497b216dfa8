//! From the detection network's probability map to boxes: threshold, outlines, boxes, widen.
//!
//! A box here has vertical sides and sloping upper and lower borders, not PP-OCR's rotated rectangle: a level camera sees the upright strokes of
//! a plate upright and its lines sloping, however obliquely it looks, so this box undoes the shear. It serves slopes up to some 45 degrees.
//!
//! The network is trained on shrunken text (differentiable binarisation, arXiv 1911.08947), so every box is widened by area * ratio /
//! circumference, equation 10 there, to each side.

use rten_imageproc::{Point, RetrievalMode, find_contours};
use rten_tensor::prelude::*;
use rten_tensor::{NdTensor, NdTensorView};

use super::settings::PpOcrSettings;

/// Narrower boxes hold nothing legible, map pixels before widening.
const MIN_SIDE: f32 = 2.0;
/// Outlines looked at in one map. It bounds the time for noise.
const MAX_OUTLINES: usize = 1000;

/// A line of text in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TextBox {
    /// Clockwise from the top left of the text, pixels.
    pub corners: [[f32; 2]; 4],
    /// Mean text probability.
    pub score: f32,
}

impl TextBox {
    pub(super) fn scaled(self, scale: [f32; 2]) -> Self {
        Self { corners: self.corners.map(|[x, y]| [x * scale[0], y * scale[1]]), ..self }
    }

    /// Whether the box is so much higher than wide that its text, if any, runs down the image.
    pub(super) fn runs_down(&self) -> bool {
        let [top_left, top_right, _, bottom_left] = self.corners;
        distance(top_left, bottom_left) > 1.5 * distance(top_left, top_right)
    }
}

pub(super) fn distance(a: [f32; 2], b: [f32; 2]) -> f32 {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    (dx * dx + dy * dy).sqrt()
}

/// Boxes in a map of text probabilities, in map pixels, the likeliest first.
pub(super) fn in_map(map: NdTensorView<f32, 2>, settings: &PpOcrSettings) -> Vec<TextBox> {
    let mask: NdTensor<bool, 2> = map.map(|&probability| probability > settings.pixel_threshold);
    let outlines = find_contours(mask.view(), RetrievalMode::External);
    let mut boxes: Vec<TextBox> =
        outlines.iter().take(MAX_OUTLINES).filter_map(|outline| around(outline, map, settings)).collect();
    boxes.sort_by(|a, b| b.score.total_cmp(&a.score));
    boxes.truncate(settings.max_boxes);
    boxes
}

fn around(outline: &[Point], map: NdTensorView<f32, 2>, settings: &PpOcrSettings) -> Option<TextBox> {
    let band = Band::around(outline)?;
    if band.width().min(band.height()) < MIN_SIDE {
        return None;
    }
    let score = band.mean_inside(map);
    let margin =
        band.width() * band.height() * settings.unclip_ratio / (2.0 * (band.width() + band.height()));
    (score >= settings.box_threshold).then(|| TextBox { corners: band.corners(margin), score })
}

/// A region between two sloping lines and two verticals, in map pixels.
struct Band {
    left: f32,
    right: f32,
    top: Border,
    bottom: Border,
}

/// A sloping line above or below a text.
#[derive(Debug, Clone, Copy)]
struct Border {
    /// Its height at the middle of the text.
    middle: f32,
    slope: f32,
}

/// The uppermost and the lowest row of an outline in one column.
#[derive(Debug, Clone, Copy)]
struct Column {
    top: i32,
    bottom: i32,
}

impl Band {
    fn around(outline: &[Point]) -> Option<Self> {
        let left = outline.iter().map(|point| point.x).min()?;
        let right = outline.iter().map(|point| point.x).max()?;
        let mut columns = vec![Column { top: i32::MAX, bottom: i32::MIN }; (right - left) as usize + 1];
        for point in outline {
            let column = &mut columns[(point.x - left) as usize];
            column.top = column.top.min(point.y);
            column.bottom = column.bottom.max(point.y);
        }
        // The ends are round; the lines are those of the part between.
        let skip = columns.len() / 8;
        let middle = &columns[skip..columns.len() - skip];
        let top = line(middle.iter().map(|column| column.top as f32), middle.len());
        let bottom = line(middle.iter().map(|column| column.bottom as f32 + 1.0), middle.len());
        Some(Self { left: left as f32, right: right as f32 + 1.0, top, bottom })
    }

    fn width(&self) -> f32 {
        self.right - self.left
    }

    /// At the middle.
    fn height(&self) -> f32 {
        self.bottom.middle - self.top.middle
    }

    /// Upper and lower border at `x`.
    fn span(&self, x: f32) -> [f32; 2] {
        let from_middle = x - (self.left + self.right) / 2.0;
        [self.top, self.bottom].map(|border| border.middle + border.slope * from_middle)
    }

    fn corners(&self, margin: f32) -> [[f32; 2]; 4] {
        let (left, right) = (self.left - margin, self.right + margin);
        let ([left_top, left_bottom], [right_top, right_bottom]) = (self.span(left), self.span(right));
        [
            [left, left_top - margin],
            [right, right_top - margin],
            [right, right_bottom + margin],
            [left, left_bottom + margin],
        ]
    }

    fn mean_inside(&self, map: NdTensorView<f32, 2>) -> f32 {
        let (mut sum, mut count) = (0.0, 0_u32);
        for column in self.left as usize..(self.right as usize).min(map.size(1)) {
            let [top, bottom] = self.span(column as f32 + 0.5);
            for row in top.round().max(0.0) as usize..(bottom.round().max(0.0) as usize).min(map.size(0)) {
                sum += map[[row, column]];
                count += 1;
            }
        }
        if count == 0 { 0.0 } else { sum / count as f32 }
    }
}

/// The line of least squares through values at 0.5, 1.5, ...
fn line(values: impl Iterator<Item = f32>, count: usize) -> Border {
    let middle = count as f32 / 2.0;
    let (mut sum, mut moment, mut spread) = (0.0, 0.0, 0.0);
    for (index, value) in values.enumerate() {
        let x = index as f32 + 0.5 - middle;
        sum += value;
        moment += x * value;
        spread += x * x;
    }
    Border { middle: sum / count as f32, slope: if spread > 0.0 { moment / spread } else { 0.0 } }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A map with 1 inside an upright rectangle that is sheared along its columns.
    fn map_of(centre: [f32; 2], size: [f32; 2], slope: f32) -> NdTensor<f32, 2> {
        let inside = |x: f32, y: f32| {
            let [dx, dy] = [x - centre[0], y - centre[1]];
            dx.abs() <= size[0] / 2.0 && (dy - slope * dx).abs() <= size[1] / 2.0
        };
        NdTensor::from_fn([96, 160], |[row, column]| {
            f32::from(u8::from(inside(column as f32 + 0.5, row as f32 + 0.5)))
        })
    }

    #[test]
    fn an_empty_map_has_no_boxes() {
        assert!(in_map(NdTensor::zeros([32, 64]).view(), &PpOcrSettings::default()).is_empty());
    }

    #[test]
    fn faint_and_tiny_spots_are_left_out() {
        let faint = map_of([80.0, 48.0], [60.0, 20.0], 0.0).map(|&p: &f32| p * 0.4);
        assert!(in_map(faint.view(), &PpOcrSettings::default()).is_empty());
        assert!(in_map(map_of([80.5, 48.5], [30.0, 0.9], 0.0).view(), &PpOcrSettings::default()).is_empty());
    }

    #[test]
    fn a_full_map_is_one_box() {
        let boxes = in_map(NdTensor::full([32, 64], 1.0).view(), &PpOcrSettings::default());
        assert_eq!(boxes.len(), 1);
    }

    proptest! {
        #[test]
        fn boxes_enclose_the_rectangle_by_the_unclip_margin(
            x in 60.0_f32..100.0, y in 45.0_f32..51.0, width in 40.0_f32..70.0, height in 8.0_f32..16.0, slope in -0.5_f32..0.5,
        ) {
            let settings = PpOcrSettings::default();
            let boxes = in_map(map_of([x, y], [width, height], slope).view(), &settings);
            prop_assert_eq!(boxes.len(), 1);
            let margin = width * height * settings.unclip_ratio / (2.0 * (width + height));
            let [a, b, _, d] = boxes[0].corners;
            prop_assert!((b[0] - a[0] - width - 2.0 * margin).abs() < 2.5, "{:?}", boxes[0]);
            prop_assert!((d[1] - a[1] - height - 2.0 * margin).abs() < 2.5, "{:?}", boxes[0]);
            let centre = boxes[0].corners.iter().fold([0.0, 0.0], |c, p| [c[0] + p[0] / 4.0, c[1] + p[1] / 4.0]);
            prop_assert!(distance(centre, [x, y]) < 1.5);
            let found = (b[1] - a[1]) / (b[0] - a[0]);
            prop_assert!((found - slope).abs() < 0.06, "{found} for {slope}");
        }
    }
}
