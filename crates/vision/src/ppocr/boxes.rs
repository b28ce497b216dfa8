//! Boxes of text from the probability map of the detection network: threshold, contours, boxes,
//! expansion.
//!
//! A box has vertical sides and sloping upper and lower borders. PP-OCR itself uses rotated
//! rectangles. A level camera sees the vertical strokes of a plate as vertical and its lines as
//! sloping, also at oblique angles, so this box removes the shear. It is suitable for slopes up to
//! some 45 degrees.
//!
//! The network is trained with shrunken text (differentiable binarization, arXiv 1911.08947). Each
//! box is therefore expanded on all sides by area * ratio / perimeter, equation (10) of that paper.

use rten_imageproc::{Point, RetrievalMode, find_contours};
use rten_tensor::prelude::*;
use rten_tensor::{NdTensor, NdTensorView};

use super::settings::PpOcrSettings;

/// Minimum side of a legible box before expansion, pixels of the map.
const MIN_SIDE_PX: f32 = 2.0;
/// Maximum number of contours of a map. It limits the time for noise.
const MAX_CONTOURS: usize = 1000;

/// A line of text in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TextBox {
    /// Corners `[x, y]`, clockwise from the top left of the text, pixels.
    pub corners: [[f32; 2]; 4],
    /// Mean probability of text inside.
    pub score: f32,
}

impl TextBox {
    pub(super) fn scaled(self, scale: [f32; 2]) -> Self {
        Self {
            corners: self.corners.map(|[x, y]| [x * scale[0], y * scale[1]]),
            ..self
        }
    }

    /// Whether the box is so high that its text is vertical.
    pub(super) fn is_vertical(&self) -> bool {
        let [top_left, top_right, _, bottom_left] = self.corners;
        distance(top_left, bottom_left) > 1.5 * distance(top_left, top_right)
    }
}

pub(super) fn distance(a: [f32; 2], b: [f32; 2]) -> f32 {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    (dx * dx + dy * dy).sqrt()
}

/// Boxes in a map of text probabilities, in pixels of the map, the most probable first.
pub(super) fn in_map(map: NdTensorView<f32, 2>, settings: &PpOcrSettings) -> Vec<TextBox> {
    let mask: NdTensor<bool, 2> = map.map(|&probability| probability > settings.pixel_threshold);
    let contours = find_contours(mask.view(), RetrievalMode::External);
    let mut boxes: Vec<TextBox> = contours
        .iter()
        // A bound on the work: no score is known yet, so this selects nothing.
        .take(MAX_CONTOURS)
        .filter_map(|contour| around(contour, map, settings))
        .collect();
    boxes.sort_by(|a, b| b.score.total_cmp(&a.score));
    boxes.truncate(settings.max_boxes);
    boxes
}

fn around(
    contour: &[Point],
    map: NdTensorView<f32, 2>,
    settings: &PpOcrSettings,
) -> Option<TextBox> {
    let band = Band::around(contour)?;
    // Before expansion, which would make any speck large enough.
    if band.width().min(band.height()) < MIN_SIDE_PX {
        return None;
    }
    let score = band.mean_inside(map);
    // Area times ratio over perimeter, equation (10), of a rectangle with the height in the middle.
    let margin = band.width() * band.height() * settings.unclip_ratio
        / (2.0 * (band.width() + band.height()));
    (score >= settings.box_threshold).then(|| TextBox {
        corners: band.corners(margin),
        score,
    })
}

/// The region between two sloping borders and two vertical sides, pixels of the map.
struct Band {
    left: f32,
    right: f32,
    top: Border,
    bottom: Border,
}

/// The upper or lower border of a region.
#[derive(Debug, Clone, Copy)]
struct Border {
    /// The y coordinate in the middle of the region.
    middle: f32,
    slope: f32,
}

/// The uppermost and the lowest row of a contour in one column.
#[derive(Debug, Clone, Copy)]
struct Column {
    top: i32,
    bottom: i32,
}

impl Band {
    fn around(contour: &[Point]) -> Option<Self> {
        let left = contour.iter().map(|point| point.x).min()?;
        let right = contour.iter().map(|point| point.x).max()?;
        // A contour is connected, so each column between its ends gets at least one point.
        let mut columns = vec![
            Column {
                top: i32::MAX,
                bottom: i32::MIN
            };
            (right - left) as usize + 1
        ];
        for point in contour {
            let column = &mut columns[(point.x - left) as usize];
            column.top = column.top.min(point.y);
            column.bottom = column.bottom.max(point.y);
        }
        // The ends of a region are round, so the borders are fitted to the part between them.
        let skip = columns.len() / 8;
        let middle = &columns[skip..columns.len() - skip];
        let top = line(middle.iter().map(|column| column.top as f32), middle.len());
        let bottom = line(
            // Points are pixels, and a border is the outer edge of its row.
            middle.iter().map(|column| column.bottom as f32 + 1.0),
            middle.len(),
        );
        Some(Self {
            left: left as f32,
            right: right as f32 + 1.0,
            top,
            bottom,
        })
    }

    fn width(&self) -> f32 {
        self.right - self.left
    }

    /// The height in the middle.
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
        let ([left_top, left_bottom], [right_top, right_bottom]) =
            (self.span(left), self.span(right));
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
            // At the centre of the column. A row belongs to the band if its centre does, which is
            // what rounding both borders selects.
            let [top, bottom] = self.span(column as f32 + 0.5);
            for row in
                top.round().max(0.0) as usize..(bottom.round().max(0.0) as usize).min(map.size(0))
            {
                sum += map[[row, column]];
                count += 1;
            }
        }
        if count == 0 { 0.0 } else { sum / count as f32 }
    }
}

/// The least-squares line through values at 0.5, 1.5, ...
fn line(values: impl Iterator<Item = f32>, count: usize) -> Border {
    let middle = count as f32 / 2.0;
    let (mut sum, mut moment, mut spread) = (0.0, 0.0, 0.0);
    for (index, value) in values.enumerate() {
        // About the mean of x the normal equations separate: the mean of the values is the height
        // in the middle, and the slope is the moment over the spread.
        let x = index as f32 + 0.5 - middle;
        sum += value;
        moment += x * value;
        spread += x * x;
    }
    Border {
        middle: sum / count as f32,
        slope: if spread > 0.0 { moment / spread } else { 0.0 },
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A map with 1 inside a rectangle that is sheared vertically.
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
    fn faint_and_tiny_spots_are_ignored() {
        let faint = map_of([80.0, 48.0], [60.0, 20.0], 0.0).map(|&p: &f32| p * 0.4);
        assert!(in_map(faint.view(), &PpOcrSettings::default()).is_empty());
        assert!(
            in_map(
                map_of([80.5, 48.5], [30.0, 0.9], 0.0).view(),
                &PpOcrSettings::default()
            )
            .is_empty()
        );
    }

    #[test]
    fn a_full_map_is_one_box() {
        let boxes = in_map(
            NdTensor::full([32, 64], 1.0).view(),
            &PpOcrSettings::default(),
        );
        assert_eq!(boxes.len(), 1);
    }

    proptest! {
        #[test]
        fn boxes_enclose_the_rectangle_by_the_unclip_margin(
            x in 60.0_f32..100.0,
            y in 45.0_f32..51.0,
            width in 40.0_f32..70.0,
            height in 8.0_f32..16.0,
            slope in -0.5_f32..0.5,
        ) {
            let settings = PpOcrSettings::default();
            let boxes = in_map(map_of([x, y], [width, height], slope).view(), &settings);
            prop_assert_eq!(boxes.len(), 1);
            let margin = width * height * settings.unclip_ratio / (2.0 * (width + height));
            let [a, b, _, d] = boxes[0].corners;
            prop_assert!((b[0] - a[0] - width - 2.0 * margin).abs() < 2.5, "{:?}", boxes[0]);
            prop_assert!((d[1] - a[1] - height - 2.0 * margin).abs() < 2.5, "{:?}", boxes[0]);
            let mut centre = [0.0, 0.0];
            for [x, y] in boxes[0].corners {
                centre[0] += x / 4.0;
                centre[1] += y / 4.0;
            }
            prop_assert!(distance(centre, [x, y]) < 1.5);
            let found = (b[1] - a[1]) / (b[0] - a[0]);
            prop_assert!((found - slope).abs() < 0.06, "{found} for {slope}");
        }
    }
}
