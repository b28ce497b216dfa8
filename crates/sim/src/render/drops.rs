//! Drops and smudges on the lens: discs in which the picture is blurred.

use std::ops::Range;

use super::planes::LightPlanes;
use crate::optics::LensDrop;

/// Places at which the picture is read for a blurred pixel, in radii from it: two rings.
const TAPS: [[f32; 2]; 12] = [
    [0.3, 0.0],
    [-0.3, 0.0],
    [0.0, 0.3],
    [0.0, -0.3],
    [0.7, 0.0],
    [0.5, 0.5],
    [0.0, 0.7],
    [-0.5, 0.5],
    [-0.7, 0.0],
    [-0.5, -0.5],
    [0.0, -0.7],
    [0.5, -0.5],
];
/// The largest number among them.
const WIDEST_TAP: f64 = 0.7;
/// Share of the light that the rim of a drop keeps.
const RIM: f32 = 0.75;

/// Blurs the picture behind drops.
pub(crate) fn smear(planes: &mut LightPlanes, drops: &[LensDrop]) {
    let discs: Vec<Disc> = drops
        .iter()
        .filter_map(|drop| Disc::new(planes, *drop))
        .collect();
    // All before the first change: where drops overlap, each shows the clear picture.
    let clear: Vec<Patch> = discs
        .iter()
        .map(|disc| Patch::around(planes, disc))
        .collect();
    for (disc, clear) in discs.iter().zip(&clear) {
        for row in disc.rows.clone() {
            for column in disc.columns.clone() {
                let (dx, dy) = (column as f64 - disc.x, row as f64 - disc.y);
                let out = ((dx * dx + dy * dy).sqrt() / disc.radius) as f32;
                if out < 1.0 {
                    blur(planes, clear, [column, row], out, disc.radius as f32);
                }
            }
        }
    }
}

/// A drop in pixels, and the pixels of the picture around it.
struct Disc {
    x: f64,
    y: f64,
    radius: f64,
    columns: Range<usize>,
    rows: Range<usize>,
}

impl Disc {
    /// `None` outside of the picture.
    fn new(planes: &LightPlanes, drop: LensDrop) -> Option<Self> {
        let (width, height) = (planes.size.width as usize, planes.size.height as usize);
        let (x, y) = (drop.x * width as f64, drop.y * height as f64);
        let radius = (drop.radius * width as f64).max(1.0);
        let disc = Self {
            x,
            y,
            radius,
            columns: within(x, radius, width),
            rows: within(y, radius, height),
        };
        (!disc.columns.is_empty() && !disc.rows.is_empty()).then_some(disc)
    }
}

/// The pixels of a row of `pixels` that are no farther than `reach` from a place.
fn within(middle: f64, reach: f64, pixels: usize) -> Range<usize> {
    // Casts of numbers below zero, or too large, saturate.
    let end = ((middle + reach) as usize).saturating_add(1);
    (middle - reach) as usize..end.min(pixels)
}

/// A copy of a part of the picture.
struct Patch {
    columns: Range<usize>,
    rows: Range<usize>,
    channels: [Vec<f32>; 3],
}

impl Patch {
    /// What is read for the pixels of a disc.
    fn around(planes: &LightPlanes, disc: &Disc) -> Self {
        let (width, height) = (planes.size.width as usize, planes.size.height as usize);
        let reach = (1.0 + WIDEST_TAP) * disc.radius + 1.0;
        let (columns, rows) = (within(disc.x, reach, width), within(disc.y, reach, height));
        let copy = |channel: &Vec<f32>| {
            let mut copied = Vec::with_capacity(columns.len() * rows.len());
            for row in rows.clone() {
                let first = planes.index(columns.start, row);
                copied.extend_from_slice(&channel[first..first + columns.len()]);
            }
            copied
        };
        Self {
            channels: planes.channels.each_ref().map(copy),
            columns,
            rows,
        }
    }

    /// Index of the nearest pixel of the part.
    fn index(&self, column: usize, row: usize) -> usize {
        let x = column.clamp(self.columns.start, self.columns.end - 1) - self.columns.start;
        let y = row.clamp(self.rows.start, self.rows.end - 1) - self.rows.start;
        y * self.columns.len() + x
    }
}

/// Blurs one pixel at a share `out` of the drop's radius from its middle.
fn blur(planes: &mut LightPlanes, clear: &Patch, at: [usize; 2], out: f32, radius: f32) {
    // Nothing changes at the rim, and most of the disc is blurred whole.
    let weight = (2.0 * (1.0 - out)).min(1.0);
    let kept = 1.0 - (1.0 - RIM) * out * out * weight;
    let (place, own) = (planes.index(at[0], at[1]), clear.index(at[0], at[1]));
    let beside = TAPS.map(|tap| {
        let x = (at[0] as f32 + radius * tap[0]).max(0.0) as usize;
        let y = (at[1] as f32 + radius * tap[1]).max(0.0) as usize;
        clear.index(x, y)
    });
    for channel in 0..3 {
        let seen = &clear.channels[channel];
        let mut sum = 0.0;
        for beside in beside {
            sum += seen[beside];
        }
        let blurred = kept * sum / TAPS.len() as f32;
        planes.channels[channel][place] = seen[own] + weight * (blurred - seen[own]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::view::ImageSize;
    use super::*;

    #[test]
    fn a_drop_blurs_inside_of_its_disc_alone() {
        let mut planes = LightPlanes::new(ImageSize::new(100, 80));
        let at = planes.index(50, 40);
        planes.channels[0][at] = 12.0;
        let before = planes.clone();
        let drop = |x| LensDrop {
            x,
            y: 0.5,
            radius: 0.1,
        };
        smear(&mut planes, &[drop(0.5)]);
        assert!(planes.channels[0][at] < 2.0);
        let mut elsewhere = before.clone();
        smear(
            &mut elsewhere,
            &[drop(0.8), drop(-3.0), drop(9.0), drop(f64::NAN)],
        );
        assert_eq!(elsewhere, before);
    }
}
